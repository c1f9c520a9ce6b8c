//! The texels that a view needs on the device.

use std::collections::BTreeMap;

use quadratura_base::geometry::PixelRect;
use quadratura_projection::cells::Cells;
use quadratura_projection::residency::TileRequest;
use quadratura_projection::{LayerTextureId, Sources};

/// Collects the texels that the cells may look up: one rectangle per layer texture and finest level.
pub fn wants(cells: &Cells, sources: &Sources) -> Vec<TileRequest> {
    let mut wanted: BTreeMap<(LayerTextureId, u32), PixelRect> = BTreeMap::new();
    for candidate in &cells.candidates {
        let layer_texture = sources.servers[candidate.server as usize].layer_texture;
        let rect = wanted.entry((layer_texture, candidate.finest)).or_insert(candidate.rect);
        *rect = rect.union(&candidate.rect);
    }
    let want = |((layer_texture, finest), rect): ((LayerTextureId, u32), PixelRect)| {
        let corner = sources.layer_texture(layer_texture).rect;
        // The next level, which contributes to the lookup, has a filter twice as wide.
        let rect = PixelRect { x: rect.x - corner.x, y: rect.y - corner.y, ..rect };
        TileRequest { layer_texture, finest, rect: rect.grown(2 << finest) }
    };
    wanted.into_iter().map(want).collect()
}
