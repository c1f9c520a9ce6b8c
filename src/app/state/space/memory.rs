//! State that the 3D view changes by itself while it is drawn.

use glam::DVec2;

use super::brush::SpaceBrush;
use super::measure::MeasuringTool;
use super::picking::ViewPixel;
use crate::state::State;
use crate::state::model_suggestions::EdgeGrip;
use quadratura_base::scene::{FaceId, PhotoId};
use quadratura_layers::LayerIndex;
use quadratura_view::navigation::Viewpoint;
use quadratura_views::render::Appearance;

/// The values of the 3D view that change while it is drawn: a copy, which is put back afterwards.
#[derive(Debug, Clone)]
pub struct SpaceMemory {
    /// The viewpoint, which mouse and keys move.
    pub viewpoint: Viewpoint,
    /// The photo that the view looks through, until it moves.
    pub through: Option<PhotoId>,
    /// The size of the view in pixels.
    pub size_px: [u32; 2],
    /// The face under the pointer.
    pub hovered: Option<FaceId>,
    /// The blending of photos, and the display mode.
    pub look: Appearance,
    /// Whether the photo that the view looks through is drawn over it.
    pub photo_over: bool,
    /// The opacity of that photo, 0 to 1.
    pub photo_opacity: f32,
    /// The share of the view's width, from the left, in which the photo is drawn.
    pub wipe: f32,
    /// The requested spacing of layers pulled apart.
    pub apart: f32,
    /// The current spacing during the animation.
    pub now_apart: f32,
    /// Whether the animation starts from the beginning.
    pub begins: bool,
    /// The layer under the pointer, by its index in the stack.
    pub hovered_layer: Option<LayerIndex>,
    /// Whether pictures of layers that are pulled apart are still missing.
    pub is_loading: bool,
    /// The layers of depth pixels that are hidden, nearest first.
    pub peeled: u32,
    /// The brush.
    pub brush: SpaceBrush,
    /// The measuring tool.
    pub measure: MeasuringTool,
    /// The edge of a suggestion under the pointer.
    pub grip: EdgeGrip,
    /// Whether the hint with the first steps is on.
    pub hints: bool,
}

impl SpaceMemory {
    /// Copies the current values.
    pub fn new(state: &State) -> Self {
        let space = &state.space;
        Self {
            viewpoint: space.viewpoint,
            through: space.through,
            size_px: space.size_px,
            hovered: space.hovered,
            look: space.look.clone(),
            photo_over: space.photo_over,
            photo_opacity: space.photo_opacity,
            wipe: space.wipe,
            apart: space.exploded.apart,
            now_apart: space.exploded.now_apart,
            begins: space.exploded.begins,
            hovered_layer: space.exploded.hovered,
            is_loading: false,
            peeled: space.images.peeled,
            brush: space.brush.clone(),
            measure: space.measure.clone(),
            grip: space.grip,
            hints: state.settings.hints,
        }
    }

    /// Puts the changed values back; a view that the user has moved leaves its photo and its flight.
    pub fn put_back(self, state: &mut State) {
        let now_s = state.window.now_s;
        let space = &mut state.space;
        if self.viewpoint != space.viewpoint {
            space.show_from(self.viewpoint, now_s);
        }
        (space.size_px, space.hovered) = (self.size_px, self.hovered);
        (space.look, space.photo_over, space.photo_opacity) =
            (self.look, self.photo_over, self.photo_opacity);
        space.wipe = self.wipe;
        space.images.peeled = self.peeled;
        space.brush = self.brush;
        (space.measure, space.grip) = (self.measure, self.grip);
        let exploded = &mut space.exploded;
        (exploded.apart, exploded.now_apart) = (self.apart, self.now_apart);
        (exploded.begins, exploded.hovered) = (self.begins, self.hovered_layer);
        state.settings.hints = self.hints;
    }

    /// Returns how a position is seen, in pixels from the top left corner of the view.
    pub fn pixel_at(&self, at_px: DVec2) -> ViewPixel {
        ViewPixel { viewpoint: self.viewpoint, size_px: self.size_px, at_px }
    }
}
