//! The share of sunlight that reaches the trees past everything else, on the device (`shaders/daylight.wgsl`, `sunlit_at`).

use std::sync::Arc;

use wgpu::{BindingResource, TextureFormat, TextureView};

use super::daylight::volume;
use crate::device::Gpu;
use quadratura_foliage::{PlacedTrees, SUNLIT_CELLS, Sunlit};

/// Blocks of cells in a row, and rows in a layer, as in the shader (`SUNLIT_ACROSS`).
const ACROSS: usize = 16;
/// The most layers of blocks; textures are 2048 deep everywhere.
const MOST_LAYERS: usize = 2048 / SUNLIT_CELLS;

/// The cells of all trees that something shades, in blocks of one texture.
#[derive(Debug)]
pub struct SunlitCells {
    texture: TextureView,
    /// What was uploaded, by tree.
    known: Vec<Option<Arc<Sunlit>>>,
    /// Of each tree 1 + the number of its block; 0 for those in the sun.
    blocks: Vec<u32>,
}

impl SunlitCells {
    /// Uploads the cells. Of more trees than a texture holds, the last ones are in the sun.
    pub fn new(gpu: &Gpu, placed: &PlacedTrees) -> Self {
        let known: Vec<Option<Arc<Sunlit>>> = placed.trees.iter().map(|tree| tree.sunlit.clone()).collect();
        let mut count = 0;
        let block = |sunlit: &Option<Arc<Sunlit>>| {
            let is_held = sunlit.is_some() && count < ACROSS * ACROSS * MOST_LAYERS;
            count += usize::from(is_held);
            if is_held { count as u32 } else { 0 }
        };
        let blocks: Vec<u32> = known.iter().map(block).collect();
        let layers = count.div_ceil(ACROSS * ACROSS).max(1);
        let side = ACROSS * SUNLIT_CELLS;
        let mut texels = vec![u8::MAX; side * side * layers * SUNLIT_CELLS];
        for (sunlit, block) in known.iter().zip(&blocks) {
            let (Some(sunlit), Some(block)) = (sunlit, (*block as usize).checked_sub(1)) else { continue };
            let [x, y, z] = [block % ACROSS, block / ACROSS % ACROSS, block / (ACROSS * ACROSS)];
            for (row, shares) in sunlit.shares().chunks(SUNLIT_CELLS).enumerate() {
                let (y, z) = (y * SUNLIT_CELLS + row % SUNLIT_CELLS, z * SUNLIT_CELLS + row / SUNLIT_CELLS);
                texels[(z * side + y) * side + x * SUNLIT_CELLS..][..SUNLIT_CELLS].copy_from_slice(shares);
            }
        }
        let size = [side, side, layers * SUNLIT_CELLS].map(|count| count as u32);
        Self { texture: volume(gpu, size, TextureFormat::R8Unorm, &texels), known, blocks }
    }

    /// Returns whether these are the cells of the trees.
    pub fn is_of(&self, placed: &PlacedTrees) -> bool {
        self.known.len() == placed.trees.len()
            && self.known.iter().zip(&placed.trees).all(|(known, tree)| *known == tree.sunlit)
    }

    /// Returns 1 + the number of a tree's block; 0 for a tree in the sun.
    pub fn block(&self, number: usize) -> u32 {
        self.blocks[number]
    }

    /// Returns what is bound of them.
    pub fn binding(&self) -> BindingResource<'_> {
        BindingResource::TextureView(&self.texture)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::renderer::plants::daylight::SOURCE;

    #[test]
    fn the_shader_knows_how_blocks_lie() {
        for constant in
            [format!("const SUNLIT_ACROSS = {ACROSS}u;"), format!("const SUNLIT_CELLS = {SUNLIT_CELLS}.0;")]
        {
            assert!(SOURCE.contains(&constant), "{constant}");
        }
    }
}
