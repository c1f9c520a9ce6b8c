//! Pass *show* (`shaders/ldi_show.wgsl`): the colours of the depth pixels that were found for single pixels.

use wgpu::ComputePipeline;

use super::view::{self, Layouts};
use crate::device::Gpu;

const SOURCE: &str = include_str!("../../../shaders/ldi_show.wgsl");

/// Returns the pass as it is compiled; `wide` where the words are of 64 bits.
pub fn source(wide: bool) -> String {
    view::source("u32", "u32", &[&format!("const WIDE: bool = {wide};\n"), SOURCE])
}

/// Builds the pipeline.
pub fn pipeline(gpu: &Gpu, layouts: &Layouts, wide: bool) -> ComputePipeline {
    layouts.pipeline(gpu, "show", &source(wide))
}
