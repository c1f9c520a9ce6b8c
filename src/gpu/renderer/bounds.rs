//! Bounds of texels that are on the device.

use glam::DVec2;

use crate::TileStore;
use quadratura_projection::Server;
use quadratura_projection::agreement::Agreement;
use quadratura_projection::cells::TexelBounds;

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

/// Bounds that take layer textures that were never decoded for trusted everywhere.
pub struct LikelyBounds<'a>(pub StoredBounds<'a>);

impl TexelBounds for LikelyBounds<'_> {
    fn least(&self, server: &Server, low_px: DVec2, high_px: DVec2) -> f64 {
        if self.0.tiles.is_decoded(server.layer_texture) {
            self.0.least(server, low_px, high_px)
        } else {
            1.0
        }
    }

    fn least_agreement(&self, server: &Server, low_px: DVec2, high_px: DVec2) -> f64 {
        self.0.least_agreement(server, low_px, high_px)
    }
}
