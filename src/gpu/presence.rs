//! Pass *presence* (`shaders/presence.wgsl`): finds the items that are nearest somewhere, and the first pixel
//! at which each of the others is hidden.

use bytemuck::{Pod, Zeroable};
use wgpu::{BindGroupLayout, Buffer, CommandEncoder};

use super::bindings::{self, BindingKind};
use super::device::Gpu;
use super::drawing::{Attachments, DrawPipeline, Style, Triangles};
use super::frame::BoundRows;
use super::readback;
use quadratura_base::error::Result;
use quadratura_layers::rasteriser::{FragmentLists, Presence as Seen};

/// The WGSL source of the pass.
pub const SOURCE: &str = include_str!("../../shaders/presence.wgsl");

/// The observations of one item over all bands (`Sighting` of the shader).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Sighting {
    /// Nonzero when some fragment of the item is visible.
    pub visible: u32,
    /// The complement of the index of the first pixel of the photo at which the item is hidden; 0 when there
    /// is none.
    pub hidden: u32,
}

impl Sighting {
    /// Converts the observations to the item's state; `lists` provides the owner that hides it.
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
    /// Creates empty sightings of this many items.
    pub fn new(gpu: &Gpu, items: usize) -> Self {
        // At least one, because a photo that looks away from the model has no items.
        Self(bindings::storage(gpu, "sightings", 2 * items.max(1) as u64, true))
    }

    /// Reads the sightings back, one per item.
    pub fn read(&self, gpu: &Gpu, items: usize) -> Result<Vec<Sighting>> {
        let [words] = readback::read(gpu, [(&self.0, 0..2 * items as u64)])?;
        Ok(bytemuck::cast_slice(&words).to_vec())
    }
}

/// The pipeline of the pass.
#[derive(Debug)]
pub struct PresencePass {
    draw: DrawPipeline,
}

impl PresencePass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu, frame: &BindGroupLayout) -> Self {
        let kinds = &[BindingKind::Depth, BindingKind::Write];
        let style = Style { name: "presence", source: SOURCE, kinds, ..Style::LOOK };
        Self { draw: DrawPipeline::new(gpu, frame, style) }
    }

    /// Records the pass: it adds the sightings of a band; the canvas' depth buffer holds the nearest depths.
    pub fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        canvas: Attachments,
        bound: BoundRows,
        triangles: &Triangles,
        sightings: &Sightings,
    ) {
        let nearest = wgpu::BindingResource::TextureView(canvas.depth);
        let own = self.draw.bind(gpu, &[nearest, sightings.0.as_entire_binding()]);
        self.draw.record(encoder, canvas, bound, &own, triangles);
    }
}
