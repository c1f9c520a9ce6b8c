//! The exploded view: a photo's image layers pulled apart in space, with the one under the pointer and their spacing.

use crate::state::flat::slot::ResultSlot;
use crate::state::flat::version::LayersVersion;
use quadratura_base::scene::PhotoId;
use quadratura_editing::exploded::layer_textures::LayerThumbnail;
use quadratura_layers::LayerIndex;
use quadratura_view::navigation::Viewpoint;

/// The default spacing: the distance of the last layer behind the nearest one, as a multiple of the nearest one's
/// distance. It is independent of the number of layers, so that all are visible.
const APART: f32 = 1.8;
/// The largest spacing; see [`APART`].
pub const MOST_APART: f32 = 6.0;

/// The state of the exploded view.
pub struct Exploded {
    /// The photo whose layers are pulled apart.
    pub photo: Option<PhotoId>,
    /// The requested spacing: the distance of the last layer behind the nearest one, as a multiple of the nearest one's
    /// distance.
    pub apart: f32,
    /// The current spacing during the animation.
    pub now_apart: f32,
    /// Whether the animation starts from the beginning.
    pub begins: bool,
    /// The viewpoint before, and the photo that the view looked through.
    pub(super) back: Option<(Viewpoint, Option<PhotoId>)>,
    /// The layer pictures of a stack.
    pub made: ResultSlot<LayersVersion, Panes3D>,
    /// The layer under the pointer, by its index in the stack.
    pub hovered: Option<LayerIndex>,
}

/// The layer pictures of a stack.
pub struct Panes3D {
    /// The pictures, in the stack's order.
    pub pictures: Vec<LayerThumbnail>,
}

impl Default for Exploded {
    fn default() -> Self {
        Self {
            photo: None,
            apart: APART,
            now_apart: 0.0,
            begins: false,
            back: None,
            made: ResultSlot::new(1),
            hovered: None,
        }
    }
}

impl Exploded {
    /// Returns whether the exploded view is on.
    pub fn is_on(&self) -> bool {
        self.photo.is_some()
    }
}
