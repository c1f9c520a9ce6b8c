//! A position in the 3D view, and where the view looks from.

use glam::{DVec2, DVec3};

use quadratura_view::navigation::Viewpoint;

/// A position in the 3D view, mostly the pointer's, and the viewpoint of the view.
#[derive(Debug, Clone, Copy)]
pub struct ViewPixel {
    /// The viewpoint.
    pub viewpoint: Viewpoint,
    /// The size of the view in pixels.
    pub size_px: [u32; 2],
    /// The position in pixels, from the top left corner.
    pub at_px: DVec2,
}

impl ViewPixel {
    /// Returns the direction of the ray through the position, in world space.
    pub fn ray(&self) -> DVec3 {
        self.viewpoint.ray(self.at_px, self.size_px)
    }
}
