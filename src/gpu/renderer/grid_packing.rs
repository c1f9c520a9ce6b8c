//! The packing of small grids into one texture, in rows of falling height.

use std::cmp::Reverse;

use wgpu::util::{DeviceExt, TextureDataOrder};
use wgpu::{TextureFormat, TextureView};

use crate::device::Gpu;

/// The least width of the texture in cells, which any device supports.
const WIDTH: u32 = 2048;

/// A packing of grids, each with its key.
#[derive(Debug)]
pub struct GridPacking<K> {
    /// The size of the texture in cells.
    pub size: [u32; 2],
    /// The position of each grid's first cell.
    pub positions: Vec<(K, [u32; 2])>,
    /// False when grids were left out, for lack of room.
    pub is_complete: bool,
}

impl<K> GridPacking<K> {
    /// Returns the number of cells of the texture.
    pub fn cells(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// Copies the values of a grid of `width` columns to its place among the `cells` of the texture.
    pub fn copy<T: Copy>(&self, cells: &mut [T], values: &[T], corner: [u32; 2], width: u32) {
        for (row, line) in (0..).zip(values.chunks_exact(width as usize)) {
            let first = ((corner[1] + row) * self.size[0] + corner[0]) as usize;
            cells[first..first + line.len()].copy_from_slice(line);
        }
    }

    /// Uploads the bytes of all cells, row by row, as a texture of this format.
    pub fn texture(&self, gpu: &Gpu, label: &str, format: TextureFormat, cells: &[u8]) -> TextureView {
        texture(gpu, label, format, self.size, cells)
    }
}

/// Uploads the bytes of all cells, row by row, as a texture of this format and size.
pub fn texture(gpu: &Gpu, label: &str, format: TextureFormat, size: [u32; 2], cells: &[u8]) -> TextureView {
    let [width, height] = size;
    let descriptor = wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    };
    let order = TextureDataOrder::LayerMajor;
    let texture = gpu.device.create_texture_with_data(&gpu.queue, &descriptor, order, cells);
    texture.create_view(&Default::default())
}

impl<K: Copy + Ord> GridPacking<K> {
    /// Packs grids of these sizes; `longest` is the longest side that the texture may have. What does not fit is left out:
    /// grids with longer sides, and then the lowest ones.
    pub fn new(grids: impl Iterator<Item = (K, [u32; 2])>, longest: u32) -> Self {
        let all: Vec<(K, [u32; 2])> = grids.collect();
        let mut grids = all.clone();
        grids.retain(|(_, [w, h])| *w.max(h) <= longest);
        grids.sort_by_key(|(key, [_, height])| (Reverse(*height), *key));
        let cells: f64 = grids.iter().map(|(_, [w, h])| f64::from(*w) * f64::from(*h)).sum();
        // About square where it is large, so that neither side reaches the limit unnecessarily.
        let square = (cells.sqrt().ceil() as u32).max(WIDTH).min(longest);
        let width = grids.iter().map(|(_, [w, _])| *w).fold(square, u32::max);
        let (mut x, mut y, mut row_height) = (0, 0, 0);
        let mut positions = Vec::with_capacity(grids.len());
        for (key, [w, h]) in grids {
            if x + w > width {
                (x, y, row_height) = (0, y + row_height, 0);
            }
            if y + h > longest {
                continue;
            }
            positions.push((key, [x, y]));
            x += w;
            row_height = row_height.max(h);
        }
        let is_complete = positions.len() == all.len();
        Self { size: [width, (y + row_height).max(1)], positions, is_complete }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_do_not_overlap_and_lie_within_the_texture() {
        let sizes: Vec<(u32, [u32; 2])> =
            (0..60).map(|i| (i, [1 + i * 37 % 900, 1 + i * 53 % 400])).collect();
        let packing = GridPacking::new(sizes.iter().copied(), 4096);
        assert!(packing.is_complete);
        let mut taken = vec![false; (packing.size[0] * packing.size[1]) as usize];
        assert_eq!(packing.positions.len(), sizes.len());
        for (key, [x, y]) in packing.positions {
            let [w, h] = sizes[key as usize].1;
            assert!(x + w <= packing.size[0] && y + h <= packing.size[1]);
            for (u, v) in (y..y + h).flat_map(|v| (x..x + w).map(move |u| (u, v))) {
                assert!(!std::mem::replace(&mut taken[(v * packing.size[0] + u) as usize], true), "{u} {v}");
            }
        }
    }

    #[test]
    fn grids_that_exceed_the_limit_are_left_out() {
        let packing = |count: u32| GridPacking::new((0..count).map(|i| (i, [1000, 1000])), 2048);
        assert!(packing(4).is_complete && !packing(5).is_complete);
        assert_eq!((packing(5).positions.len(), packing(5).size), (4, [2048, 2000]));
        let long = GridPacking::new([(0, [3000, 1]), (1, [10, 1])].into_iter(), 2048);
        assert_eq!((long.is_complete, long.positions), (false, vec![(1, [0, 0])]));
    }
}
