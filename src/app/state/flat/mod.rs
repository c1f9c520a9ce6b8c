//! The flat views: the photo with its layers, and one image layer.

pub mod layer;
pub mod layer_views;
pub mod levels;
pub mod loading;
pub mod photo;
pub mod picked;
pub mod placement;
mod queries;
pub mod slot;
pub mod version;

use self::layer::LayerPane;
use self::layer_views::LayerViews;
use self::loading::Loading;
use self::photo::PhotoPane;

/// Overlays of the flat views; one set of switches applies to all of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Switches {
    /// Whether outlines of elements are drawn.
    pub outlines: bool,
    /// Whether hidden areas are hatched.
    pub hatching: bool,
    /// Whether rectangles of image layers are drawn.
    pub rectangles: bool,
    /// Whether the filling of occluded areas is drawn.
    pub filling: bool,
    /// Whether paint is drawn.
    pub paint: bool,
    /// Whether photos are drawn with matched exposure.
    pub even: bool,
}

impl Default for Switches {
    fn default() -> Self {
        Self { outlines: true, hatching: true, rectangles: false, filling: true, paint: true, even: false }
    }
}

/// The state of the flat views.
#[derive(Default)]
pub struct FlatViews {
    /// The overlays of both views.
    pub switches: Switches,
    /// The view of the photo with its layers.
    pub photo: PhotoPane,
    /// The view of one image layer.
    pub layer: LayerPane,
    /// Eyes, solo layers and opacities.
    pub layer_views: LayerViews,
    /// Results of jobs for both views.
    pub loading: Loading,
}

impl FlatViews {
    /// Resets the state that belongs to a project; the user's choices are kept.
    pub fn forget(&mut self) {
        *self = Self { switches: self.switches.clone(), ..Self::default() };
    }
}
