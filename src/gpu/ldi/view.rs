//! The data that all passes of the warp share (`shaders/ldi_view.wgsl`): the view, its tables, and the layouts of the bindings.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use wgpu::{BindGroup, BindGroupLayout, BufferUsages, ShaderStages};

use crate::bindings::{self, BindingKind};
use crate::device::Gpu;
use crate::renderer::table::GrowingBuffer;
use quadratura_base::scene::light::bytes_of_light_times;
use quadratura_ldi::warp::light_of_bytes;
use quadratura_ldi::warp::moves::Moves;
use quadratura_ldi::{SplatKind, WarpOptions};

/// The WGSL source that is put before every pass.
pub const SOURCE: &str = include_str!("../../../shaders/ldi_view.wgsl");

/// The invocations of a workgroup of every pass.
pub const WORKGROUP: u32 = 256;

/// Returns the source of a pass whose buffers hold words of these types (WGSL), which are atomic where many depth pixels write
/// to one pixel.
pub fn source(depth: &str, sum: &str, texts: &[&str]) -> String {
    format!("alias Depth = {depth};\nalias Sum = {sum};\n{SOURCE}{}", texts.concat())
}

/// The uniform of the shaders (`View`), which document the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct ViewUniform {
    pub step: [f32; 3],
    pub zero: u32,
    pub depth: [f32; 3],
    pub runs: u32,
    pub half: [f32; 2],
    pub size: [u32; 2],
    pub rows: [u32; 2],
    pub within: [u32; 2],
}

/// The layouts of the three bind groups of every pass.
#[derive(Debug)]
pub struct Layouts {
    /// The view and its tables.
    pub view: BindGroupLayout,
    /// A chunk of a level.
    pub chunk: BindGroupLayout,
    /// The buffers of the picture's pixels.
    pub space: BindGroupLayout,
}

impl Layouts {
    /// Creates the layouts.
    pub fn new(gpu: &Gpu) -> Self {
        let of = |label, kinds: &[BindingKind]| bindings::layout(gpu, label, ShaderStages::COMPUTE, kinds);
        Self {
            view: of(
                "LDI view",
                &[BindingKind::Uniform, BindingKind::Read, BindingKind::Read, BindingKind::Read],
            ),
            chunk: of("LDI chunk", &[BindingKind::Uniform, BindingKind::Read]),
            space: of("LDI space", &[BindingKind::Write; 3]),
        }
    }

    /// Compiles a pass.
    pub fn pipeline(&self, gpu: &Gpu, entry: &str, source: &str) -> wgpu::ComputePipeline {
        let module = bindings::shader(gpu, entry, source);
        bindings::compute(gpu, entry, &module, &[&self.view, &self.chunk, &self.space])
    }
}

/// The tables of a view on the device, rewritten for every view.
#[derive(Debug)]
pub struct ViewTables {
    uniform: GrowingBuffer,
    starts: GrowingBuffer,
    surfaces: GrowingBuffer,
    exposed: GrowingBuffer,
}

impl ViewTables {
    /// Creates empty tables.
    pub fn new(gpu: &Gpu) -> Self {
        let table = |label| GrowingBuffer::new(gpu, label, BufferUsages::STORAGE);
        Self {
            uniform: GrowingBuffer::new(gpu, "LDI view", BufferUsages::UNIFORM),
            starts: table("LDI starts"),
            surfaces: table("LDI surfaces"),
            exposed: table("LDI exposure"),
        }
    }

    /// Writes the tables of a view.
    pub fn write(&mut self, gpu: &Gpu, moves: &Moves, options: &WarpOptions) {
        self.starts.write(gpu, &moves.starts);
        self.surfaces.write(gpu, &moves.surfaces);
        self.exposed.write(gpu, &exposed(options));
    }

    /// Binds the tables for some rows of the picture, and the depth pixels that can be on them. What was recorded with the
    /// binding before has to be submitted.
    pub fn bind(&mut self, gpu: &Gpu, layouts: &Layouts, uniform: &ViewUniform) -> BindGroup {
        self.uniform.write(gpu, &[*uniform]);
        let tables = [&self.uniform, &self.starts, &self.surfaces, &self.exposed];
        bindings::bind(gpu, "LDI view", &layouts.view, &tables.map(GrowingBuffer::binding))
    }
}

/// Returns, R, G, B, what each stored value is in the picture: its light, as bits, for sums, and a stored value for single pixels.
fn exposed(options: &WarpOptions) -> Vec<u32> {
    match options.splat {
        SplatKind::Sums => {
            light_of_bytes(options.exposure).as_flattened().iter().map(|light| light.to_bits()).collect()
        }
        _ => {
            let bytes = |gain: f64| match gain {
                0.0 => std::array::from_fn(|byte| byte as u8),
                gain => bytes_of_light_times(gain.exp()),
            };
            options.exposure.iter().flat_map(|gain| bytes(*gain)).map(u32::from).collect()
        }
    }
}

/// Returns the uniform for some rows of a picture, with the depth pixels that can be on them.
pub fn uniform(moves: &Moves, size: [u32; 2], rows: &Range<u32>, within: &Range<u32>) -> ViewUniform {
    ViewUniform {
        step: moves.rows.step,
        zero: 0,
        depth: moves.rows.depth,
        runs: moves.runs(),
        half: moves.rows.half,
        size,
        rows: [rows.start, rows.end],
        within: [within.start, within.end],
    }
}
