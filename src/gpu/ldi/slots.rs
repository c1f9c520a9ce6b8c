//! The slots of a pixel, in which sums are (`shaders/ldi_slots.wgsl`), and the passes over depth pixels that fill them.

use wgpu::ComputePipeline;

use super::dots;
use super::view::{self, Layouts};
use crate::gpu::device::Gpu;
use crate::ldi::splat::sums::{APART, APART_PIXELS, LEVEL, OVERFULL, PER_OPAQUE, SLIGHT};

/// The WGSL source that is put before the passes over slots.
pub const SOURCE: &str = include_str!("../../../shaders/ldi_slots.wgsl");

/// The WGSL source that is put before the passes over depth pixels that fill slots.
const LEVEL_SOURCE: &str = include_str!("../../../shaders/ldi_level.wgsl");

/// The words of a pixel that hold depths: see `PLANES` of the shader.
pub const PLANES: u64 = 4;
/// The words of a pixel's sums: `SLOTS` times `SUMS` of the shader.
pub const SUMS: u64 = 15;

/// A weight of 1 in the sums. 16 bits: of surfaces that are far away, pixels of a spacing of 1/100 have weights of 10^-4.
const WEIGHT_UNIT: f32 = 65_536.0;
/// A light of 1 in the sums. 18 bits: in the dark, a step of sRGB is 3 10^-4 of the light, of which weights are a part. 256
/// weights of the brightest light that counts have room in 32 bits.
const LIGHT_UNIT: f32 = 262_144.0;

/// A pass over depth pixels that fills slots. Each runs twice, for the near slot and for the far one.
#[derive(Debug, Clone, Copy)]
pub struct Filling {
    /// The function of the shader.
    entry: &'static str,
    text: &'static str,
}

/// The passes in their order.
pub const FILLING: [Filling; 3] = [
    Filling { entry: "nearest", text: include_str!("../../../shaders/ldi_nearest.wgsl") },
    Filling { entry: "surface_of_nearest", text: include_str!("../../../shaders/ldi_surface.wgsl") },
    Filling { entry: "sums_of_slots", text: include_str!("../../../shaders/ldi_sums.wgsl") },
];

impl Filling {
    /// Returns the pass as it is compiled, for the near slot or for the far one.
    pub fn source(&self, far: bool) -> String {
        let far = format!("const FAR: bool = {far};\n");
        let constants = [dots::constants(false), constants(), far].concat();
        let texts = [&constants, dots::SOURCE, SOURCE, LEVEL_SOURCE, self.text];
        view::source("atomic<u32>", "atomic<u32>", &texts)
    }

    /// Builds the pipeline for the near slot or for the far one.
    pub fn pipeline(&self, gpu: &Gpu, layouts: &Layouts, far: bool) -> ComputePipeline {
        layouts.pipeline(gpu, self.entry, &self.source(far))
    }
}

/// Returns the constants of the sources.
pub fn constants() -> String {
    [
        ("LEVEL", LEVEL),
        ("APART", APART),
        ("APART_PIXELS", APART_PIXELS),
        ("OVERFULL", OVERFULL),
        ("SLIGHT", SLIGHT),
        ("PER_OPAQUE", PER_OPAQUE),
        ("WEIGHT_UNIT", WEIGHT_UNIT),
        ("LIGHT_UNIT", LIGHT_UNIT),
    ]
    .map(|(name, value)| format!("const {name}: f32 = {value:?};\n"))
    .concat()
}
