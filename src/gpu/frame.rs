//! The data common to all passes: the rows being processed, and the items' planes (`shaders/frame.wgsl`).

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use wgpu::{BindGroup, BindGroupLayout, Buffer, BufferUsages, ShaderStages};

use super::bindings::{self, BindingKind};
use super::device::Gpu;
use quadratura_layers::ProjectedModel;

/// The WGSL source that is put before every shader.
pub const SOURCE: &str = include_str!("../../shaders/frame.wgsl");

/// The scale of the depth buffer: it holds inverse depths times this over [`ProjectedModel::largest_inverse_depth`],
/// which leaves room for planes seen edge-on, whose extrapolation to a pixel centre may exceed the largest
/// inverse depth.
const DEPTH_ROOM: f32 = 1.0 / 65536.0;

/// The uniform of the shaders (`Frame`), which document the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct FrameUniform {
    pub width: u32,
    pub y0: u32,
    pub row: u32,
    pub row_end: u32,
    pub first_entry: u32,
    pub nearer: f32,
    pub depth_scale: f32,
    pub zero: u32,
}

/// An item's plane (`Plane` of the shaders, which document the fields).
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct PlaneWords {
    pub a: f32,
    pub b: f32,
    pub c: f32,
    pub u0: f32,
    pub v0: f32,
    pub number: u32,
}

/// Creates the layout of bind group 0 of every pipeline.
pub fn layout(gpu: &Gpu) -> BindGroupLayout {
    let stages = ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE;
    bindings::layout(gpu, "frame", stages, &[BindingKind::Uniform, BindingKind::Read])
}

/// Uploads the planes of a view's items; `number` returns each item's index in the working set.
pub fn planes(gpu: &Gpu, view: &ProjectedModel, number: impl Fn(usize) -> u32) -> Buffer {
    let words = |(index, item): (usize, &quadratura_layers::Item)| {
        let plane = item.inverse_depth;
        PlaneWords { a: plane.a, b: plane.b, c: plane.c, u0: plane.u0, v0: plane.v0, number: number(index) }
    };
    let planes: Vec<PlaneWords> = view.items.iter().enumerate().map(words).collect();
    bindings::filled(gpu, "planes", &planes, BufferUsages::STORAGE)
}

/// The rows of a photo that textures and per-pixel buffers hold at a time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PhotoRows {
    /// Size of the photo in pixels.
    pub size: [u32; 2],
    /// The rows of the band.
    pub band: Range<u32>,
    /// The rows of the band that are being processed.
    pub rows: Range<u32>,
    /// The index, among the whole band's entries, of the first entry in the buffer.
    pub first_entry: u32,
}

impl PhotoRows {
    /// Selects all rows of a band.
    pub fn band(view: &ProjectedModel, band: Range<u32>) -> Self {
        Self { size: [view.width, view.height], rows: band.clone(), band, first_entry: 0 }
    }

    /// Returns the number of pixels of the band.
    pub fn pixels(&self) -> u64 {
        u64::from(self.size[0]) * self.band.len() as u64
    }

    /// Builds bind group 0 for these rows.
    pub fn bind(
        &self,
        gpu: &Gpu,
        layout: &BindGroupLayout,
        view: &ProjectedModel,
        tolerance: f32,
        planes: &Buffer,
    ) -> BindGroup {
        let uniform = FrameUniform {
            width: self.size[0],
            y0: self.band.start,
            row: self.rows.start,
            row_end: self.rows.end,
            first_entry: self.first_entry,
            nearer: 1.0 + tolerance,
            depth_scale: DEPTH_ROOM / view.largest_inverse_depth,
            zero: 0,
        };
        let uniform = bindings::filled(gpu, "frame", &[uniform], BufferUsages::UNIFORM);
        let resources = [uniform.as_entire_binding(), planes.as_entire_binding()];
        bindings::bind(gpu, "frame", layout, &resources)
    }
}

/// The rows that a pass processes, with bind group 0, which is built for them ([`PhotoRows::bind`]).
#[derive(Debug, Clone, Copy)]
pub struct BoundRows<'a> {
    /// The rows.
    pub rows: &'a PhotoRows,
    /// The frame and the planes of the items.
    pub group: &'a BindGroup,
}

/// Divides a photo into bands of whole rows, from the top, of at most `most_pixels` each (at least one row).
pub fn bands(view: &ProjectedModel, most_pixels: u64) -> Vec<Range<u32>> {
    let rows = (most_pixels / u64::from(view.width.max(1))).clamp(1, u64::from(view.height.max(1))) as u32;
    // Bands of equal height need the least memory.
    let rows = view.height.div_ceil(view.height.div_ceil(rows).max(1)).max(1);
    (0..view.height).step_by(rows as usize).map(|y| y..(y + rows).min(view.height)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_are_whole_rows_without_gaps_and_nearly_equal() {
        let view = ProjectedModel { width: 100, height: 70, ..ProjectedModel::default() };
        let whole = 0..70;
        assert_eq!(bands(&view, 100_000), [whole]);
        assert_eq!(bands(&view, 3999), [0..35, 35..70]);
        assert_eq!(bands(&view, 1), (0..70).map(|y| y..y + 1).collect::<Vec<_>>());
    }

    #[test]
    fn a_photo_without_pixels_has_no_bands() {
        assert!(bands(&ProjectedModel::default(), 100).is_empty());
    }
}
