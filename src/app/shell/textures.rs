//! The textures of the window, which panels upload and draw.

use crate::app::panel::paint::PaintTextures;
use crate::app::panel::space::SpaceTextures;

/// The textures of the window, by panel.
#[derive(Default)]
pub struct Textures {
    /// The changes of the last import.
    pub paint: PaintTextures,
    /// The 3D view.
    pub space: SpaceTextures,
}
