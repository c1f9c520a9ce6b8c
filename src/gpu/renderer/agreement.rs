//! The photos' agreement and their outlines on the device: the grids of all image layers packed into one texture, and the position of
//! each (`AgreementPlace` of `shaders/project.wgsl`).

use std::collections::BTreeMap;

use bytemuck::{Pod, Zeroable};
use wgpu::{
    Buffer, BufferUsages, Extent3d, Origin3d, TexelCopyBufferLayout, TexelCopyTextureInfo, TextureFormat,
    TextureView,
};

use super::grid_packing::GridPacking;
use crate::bindings;
use crate::device::Gpu;
use quadratura_projection::LayerTextureId;
use quadratura_projection::agreement::Agreement;
use quadratura_view::agreement::AgreementGrid;

/// The grid of one image layer in the layout of the shader (`AgreementPlace`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct PlaceWords {
    pub cells_per_px: [f32; 2],
    pub origin: [f32; 2],
    pub size: [f32; 2],
    pub corner: [f32; 2],
}

/// The longest side of the texture: 64 MiB in all.
const LONGEST_SIDE: u32 = 8192;

/// Names one of the two grids of an image layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct GridKey {
    id: LayerTextureId,
    /// Whether it is that of the layer's outlines.
    is_outline: bool,
}

/// Returns the grid of an image layer.
fn grid(agreement: &Agreement, key: GridKey) -> Option<&AgreementGrid> {
    let grids = if key.is_outline { &agreement.outlines } else { &agreement.of_texture };
    grids.get(key.id.0 as usize)?.as_ref()
}

/// The agreement's texture and table.
#[derive(Debug)]
pub struct AgreementTexture {
    /// The agreement of each cell, 0 to 1.
    pub texture: TextureView,
    /// The first cell of each grid in the texture.
    corners: BTreeMap<GridKey, [u32; 2]>,
    /// How often the numbers of columns and rows were halved, so that all grids fit into the texture.
    halvings: u32,
    /// The table of [`PlaceWords`], one per image layer for its agreement, then one per image layer for its outlines.
    pub places: Buffer,
    /// The same on the CPU, for bounds of penalties.
    pub agreement: Agreement,
}

impl AgreementTexture {
    /// Uploads the agreement of `layer_textures` image layers. Grids that exceed the device's textures together are all
    /// made coarser: hundreds of photos still agree or not, less sharply.
    pub fn new(gpu: &Gpu, mut agreement: Agreement, layer_textures: usize) -> Self {
        let keys = || {
            [false, true].into_iter().flat_map(|is_outline| {
                (0..layer_textures as u32).map(move |id| GridKey { id: LayerTextureId(id), is_outline })
            })
        };
        let longest = gpu.device.limits().max_texture_dimension_2d.min(LONGEST_SIDE);
        let mut halvings = 0;
        let packing = loop {
            let grids = keys().filter_map(|key| Some((key, grid(&agreement, key)?.size)));
            let packing = GridPacking::new(grids, longest);
            if packing.is_complete {
                break packing;
            }
            agreement = agreement.halved();
            halvings += 1;
        };
        let mut cells = vec![u8::MAX; packing.cells()];
        let layers = layer_textures.max(1);
        let mut places = vec![PlaceWords::zeroed(); 2 * layers];
        for &(key, corner) in &packing.positions {
            let Some(grid) = grid(&agreement, key) else { continue };
            places[usize::from(key.is_outline) * layers + key.id.0 as usize] = words(grid, corner);
            packing.copy(&mut cells, &grid.values, corner, grid.size[0]);
        }
        Self {
            texture: packing.texture(gpu, "agreement", TextureFormat::R8Unorm, &cells),
            places: bindings::filled(gpu, "agreement places", &places, BufferUsages::STORAGE),
            corners: packing.positions.iter().copied().collect(),
            halvings,
            agreement,
        }
    }

    /// Uploads the grids of these image layers again, where only the values of cells have changed; returns false, with nothing
    /// changed, where grids are others.
    pub fn renew(&mut self, gpu: &Gpu, agreement: &Agreement, changed: &[LayerTextureId]) -> bool {
        let same = |key: GridKey| -> Option<(GridKey, [u32; 2], AgreementGrid)> {
            let mut present = grid(agreement, key)?.clone();
            (0..self.halvings).for_each(|_| present = present.halved());
            let before = grid(&self.agreement, key)?;
            let is_same = (before.corner, before.size) == (present.corner, present.size);
            is_same.then_some((key, *self.corners.get(&key)?, present))
        };
        let of_layer = |id: &LayerTextureId| [false, true].map(|is_outline| GridKey { id: *id, is_outline });
        let is_any = |key: &GridKey| grid(agreement, *key).is_some() || grid(&self.agreement, *key).is_some();
        let keys = changed.iter().flat_map(of_layer).filter(is_any);
        let Some(grids) = keys.map(same).collect::<Option<Vec<_>>>() else { return false };
        for (GridKey { id, is_outline }, [x, y], grid) in grids {
            let [width, height] = grid.size;
            let texture = self.texture.texture();
            let origin = Origin3d { x, y, z: 0 };
            let target = TexelCopyTextureInfo { origin, ..texture.as_image_copy() };
            let layout =
                TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width), rows_per_image: None };
            let size = Extent3d { width, height, depth_or_array_layers: 1 };
            gpu.queue.write_texture(target, &grid.values, layout, size);
            let Agreement { of_texture, outlines } = &mut self.agreement;
            (if is_outline { outlines } else { of_texture })[id.0 as usize] = Some(grid);
        }
        true
    }

    /// Describes the texture, and that it is coarser than what was found where it is.
    pub fn statistics(&self) -> String {
        let size = self.texture.texture().size();
        let mib = f64::from(size.width) * f64::from(size.height) / f64::from(1 << 20);
        let coarser = match self.halvings {
            0 => String::new(),
            times => format!(
                ", {} times coarser along both sides than it was found, because the device has no room for more",
                1u32 << times
            ),
        };
        format!("agreement of photos: {mib:.1} MiB{coarser}")
    }
}

fn words(grid: &AgreementGrid, corner: [u32; 2]) -> PlaceWords {
    PlaceWords {
        cells_per_px: grid.cells_per_px.as_vec2().to_array(),
        origin: grid.corner.map(|at| at as f32),
        size: grid.size.map(|side| side as f32),
        corner: corner.map(|at| at as f32),
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::Gpu;

    /// Two layers with an agreement of 0.2 here and there, `wide` columns apart.
    fn agreement(wide: u16) -> Agreement {
        let cells = BTreeMap::from([((0, 0), 51), ((3, wide), 51)]);
        let grid = AgreementGrid::new(DVec2::splat(0.5), &cells);
        Agreement { of_texture: vec![grid.clone(), None, grid.clone()], outlines: vec![None, None, grid] }
    }

    #[test]
    fn the_grids_of_layers_are_renewed_where_they_are_and_refused_where_they_are_others() {
        let (gpu, before) = (Gpu::noop(), agreement(40));
        let mut texture = AgreementTexture::new(&gpu, before.clone(), 3);
        let mut after = before.clone();
        after.of_texture[2].as_mut().unwrap().spare([(0, 0)].into_iter());
        after.outlines[2].as_mut().unwrap().spare([(0, 0)].into_iter());
        assert!(texture.renew(&gpu, &after, &[LayerTextureId(2)]));
        assert_eq!(texture.agreement, after);
        let mut more = before.clone();
        more.of_texture[1] = before.of_texture[0].clone();
        for (other, changed) in [(agreement(41), LayerTextureId(0)), (more, LayerTextureId(1))] {
            assert!(!texture.renew(&gpu, &other, &[changed]), "{changed:?}");
            assert_eq!(texture.agreement, after, "nothing has changed");
        }
    }

    #[test]
    fn grids_that_do_not_fit_become_coarser_and_that_is_told() {
        let gpu = Gpu::noop();
        let longest = gpu.device.limits().max_texture_dimension_2d.min(LONGEST_SIDE);
        let fits = AgreementTexture::new(&gpu, agreement(40), 3);
        assert!(!fits.statistics().contains("coarser"), "{}", fits.statistics());
        let wide = agreement(longest as u16 + 10);
        let mut halved = AgreementTexture::new(&gpu, wide.clone(), 3);
        assert!(halved.statistics().contains("2 times coarser"), "{}", halved.statistics());
        let mut after = wide;
        after.of_texture[0].as_mut().unwrap().spare([(0, 0)].into_iter());
        assert!(halved.renew(&gpu, &after, &[LayerTextureId(0)]));
        assert_eq!(halved.agreement, after.halved());
    }
}
