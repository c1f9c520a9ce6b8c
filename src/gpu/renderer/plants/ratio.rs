//! The ratio images of trees on the device (`shaders/daylight.wgsl`, `photographed`).

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DVec3, DVec4, Vec3};
use half::f16;
use wgpu::{BindingResource, TextureView};

use crate::device::Gpu;
use quadratura_foliage::{PlacedTrees, RATIO_CELLS, RatioImage, RatioInView, RatiosInView, Tree};
use quadratura_view::Shot;

/// A ratio image in a view, in the layout of the shader (`Ratio`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct RatioWords {
    pub x: [f32; 4],
    pub y: [f32; 4],
    pub w: [f32; 4],
    pub corner: [f32; 2],
    pub weight: f32,
    pub pad0: f32,
}

/// The largest number of ratio images across, and down.
const MOST_ACROSS: usize = 8192 / RATIO_CELLS;

/// The cells of the ratio images of all trees, in squares that lie side by side in one texture.
#[derive(Debug)]
pub struct RatioCells {
    texture: TextureView,
    /// The number of ratio images across.
    across: usize,
    /// Their number.
    count: usize,
    /// Of each tree the number of ratio images before its own.
    firsts: Vec<usize>,
}

impl RatioCells {
    /// Uploads the cells. Of more ratio images than a texture holds, the last ones do not count.
    pub fn new(gpu: &Gpu, placed: &PlacedTrees) -> Self {
        let mut count = 0;
        let firsts = placed.trees.iter().map(|tree| {
            let first = count;
            count += tree.ratios.len();
            first
        });
        let firsts = firsts.collect();
        let across = (count.max(1) as f64).sqrt().ceil().min(MOST_ACROSS as f64) as usize;
        let down = count.div_ceil(across).clamp(1, MOST_ACROSS);
        let row = across * RATIO_CELLS;
        let mut texels = vec![[0u16; 4]; row * down * RATIO_CELLS];
        let count = count.min(across * down);
        let ratios = placed.trees.iter().flat_map(|tree| tree.ratios.iter());
        for (at, ratio) in ratios.take(count).enumerate() {
            let corner = at / across * RATIO_CELLS * row + at % across * RATIO_CELLS;
            for (y, cells) in ratio.logs.chunks(RATIO_CELLS).enumerate() {
                for (x, log) in cells.iter().enumerate() {
                    texels[corner + y * row + x] =
                        [log.x, log.y, log.z, 0.0].map(|log| f16::from_f32(log).to_bits());
                }
            }
        }
        let texture = upload(gpu, [row as u32, (down * RATIO_CELLS) as u32], bytemuck::cast_slice(&texels));
        Self { texture, across, count, firsts }
    }

    /// Returns what is bound of them.
    pub fn binding(&self) -> BindingResource<'_> {
        BindingResource::TextureView(&self.texture)
    }

    /// Returns the ratio images of a tree that count in a view, and the factor on all of its light.
    pub fn in_view(&self, shot: &Shot, placed: &PlacedTrees, number: usize) -> (Vec<RatioWords>, Vec3) {
        let tree = &placed.trees[number];
        if tree.ratios.is_empty() {
            return (Vec::new(), Vec3::ONE);
        }
        let (middle, eye) = (placed.ball(tree).middle, shot.pose.center_in_world());
        let world_from_camera =
            DAffine3::from_mat3_translation(shot.pose.rotation, shot.pose.translation).inverse();
        let RatiosInView { images, rest } = RatiosInView::new(&tree.ratios, middle, eye, &shot.without);
        let words = |RatioInView { index, weight }: RatioInView| {
            let at = self.firsts[number] + index;
            let [x, y, w] = rows(&tree.ratios[index], &world_from_camera);
            let corner = [at % self.across, at / self.across].map(|square| (square * RATIO_CELLS) as f32);
            let weight = if at < self.count { weight as f32 } else { 0.0 };
            RatioWords { x, y, w, corner, weight, pad0: 0.0 }
        };
        (images.into_iter().map(words).collect(), rest.exp())
    }
}

/// Returns whether trees have the ratio images of others: a tree that is dragged changes none.
pub fn have_same_ratios(trees: &PlacedTrees, others: &PlacedTrees) -> bool {
    let same = |(tree, other): (&Tree, &Tree)| {
        Arc::ptr_eq(&tree.ratios, &other.ratios) || tree.ratios.is_empty() && other.ratios.is_empty()
    };
    trees.trees.len() == others.trees.len() && trees.trees.iter().zip(&others.trees).all(same)
}

/// Returns the rows of the map from a camera's frame to cells. What is far from the world's origin cancels before it is rounded.
fn rows(ratio: &RatioImage, world_from_camera: &DAffine3) -> [[f32; 4]; 3] {
    ratio.cells_from_world().map(|(along, offset)| {
        let in_camera: DVec3 = world_from_camera.matrix3.transpose() * along;
        let offset = offset + along.dot(world_from_camera.translation);
        DVec4::from((in_camera, offset)).as_vec4().to_array()
    })
}

fn upload(gpu: &Gpu, [width, height]: [u32; 2], texels: &[u8]) -> TextureView {
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("ratio images"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(texels.len() as u32 / height),
        rows_per_image: Some(height),
    };
    gpu.queue.write_texture(texture.as_image_copy(), texels, layout, size);
    texture.create_view(&Default::default())
}
