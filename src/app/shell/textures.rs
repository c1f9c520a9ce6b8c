//! The textures of the window, which panels upload and draw.

use crate::app::panel::space::SpaceTextures;

/// The textures of the views, by panel.
#[derive(Default)]
pub struct Textures {
    /// Those of the 3D view.
    pub space: SpaceTextures,
}
