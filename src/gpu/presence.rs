//! Pass *presence* (`shaders/presence.wgsl`): which items are nearest somewhere, and where the
//! others are hidden first.

use bytemuck::{Pod, Zeroable};
use wgpu::{BindGroup, BindGroupLayout, Buffer, CommandEncoder};

use super::bindings::{self, Kind};
use super::device::Gpu;
use super::drawing::{Canvas, DrawPipeline, Style, Triangles};
use super::frame::Frame;
use super::readback;
use crate::error::Result;
use crate::layers::rasteriser::{FragmentLists, Presence as Seen};

/// WGSL of the pass.
pub const SOURCE: &str = include_str!("../../shaders/presence.wgsl");

/// `Sighting` of the shader: what was seen of one item, gathered over all bands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Sighting {
    /// Not 0 when some fragment is visible.
    pub visible: u32,
    /// Complement of the first pixel of the photo where the item is hidden; 0: none.
    pub hidden: u32,
}

impl Sighting {
    /// What became of the item, the lists telling who hides it.
    pub fn presence(self, lists: &FragmentLists) -> Seen {
        match self {
            Self { visible: 0, hidden: 0 } => Seen::Nowhere,
            Self { visible: 0, hidden } => {
                let (x, y) = (!hidden % lists.width, !hidden / lists.width);
                Seen::Hidden { x, y, by: lists.owner(x, y).unwrap_or(u32::MAX) }
            }
            _ => Seen::Working,
        }
    }
}

/// The sightings of a view's items on the device.
#[derive(Debug)]
pub struct Sightings(Buffer);

impl Sightings {
    /// Nothing seen yet of so many items.
    pub fn new(gpu: &Gpu, items: usize) -> Self {
        // One at least: a photo that looks away from the model has no items.
        Self(bindings::storage(gpu, "sightings", 2 * items.max(1) as u64, true))
    }

    /// What was seen, one per item.
    pub fn read(&self, gpu: &Gpu, items: usize) -> Result<Vec<Sighting>> {
        let [words] = readback::read(gpu, [(&self.0, 0..2 * items as u64)])?;
        Ok(bytemuck::cast_slice(&words).to_vec())
    }
}

/// The pipeline.
#[derive(Debug)]
pub struct Presence {
    draw: DrawPipeline,
}

impl Presence {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu, frame: &BindGroupLayout) -> Self {
        let kinds = &[Kind::Depth, Kind::Write];
        let style = Style { name: "presence", source: SOURCE, kinds, ..Style::LOOK };
        Self { draw: DrawPipeline::new(gpu, frame, style) }
    }

    /// Adds what this band shows; the canvas' depth buffer holds the nearest.
    pub fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        canvas: Canvas,
        frame: (&Frame, &BindGroup),
        triangles: &Triangles,
        sightings: &Sightings,
    ) {
        let nearest = wgpu::BindingResource::TextureView(canvas.depth);
        let own = self.draw.bind(gpu, &[nearest, sightings.0.as_entire_binding()]);
        self.draw.record(encoder, canvas, frame, &own, triangles);
    }
}
