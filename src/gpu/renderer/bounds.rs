//! Bounds of texels that are on the device.

use glam::DVec2;

use crate::gpu::TileStore;
use crate::projection::Server;
use crate::projection::agreement::Agreement;
use crate::projection::cells::TexelBounds;

/// What is known of texels without access to them.
pub struct StoredBounds<'a> {
    /// The layer textures' texels.
    pub tiles: &'a TileStore,
    /// The agreement of photos.
    pub agreement: &'a Agreement,
}

impl TexelBounds for StoredBounds<'_> {
    fn least(&self, server: &Server, low_px: DVec2, high_px: DVec2) -> f64 {
        self.tiles.least(server, low_px, high_px)
    }

    fn least_agreement(&self, server: &Server, low_px: DVec2, high_px: DVec2) -> f64 {
        self.agreement.least(server.layer_texture, low_px, high_px)
    }
}
