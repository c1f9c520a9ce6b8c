//! Pass *find* of single pixels (`shaders/ldi_pixel.wgsl`), in two runs: the nearest inverse depth at each pixel, then the first
//! depth pixel that has it.

use wgpu::ComputePipeline;

use super::dots;
use super::view::{self, Layouts};
use crate::device::Gpu;

const SOURCE: &str = include_str!("../../../shaders/ldi_pixel.wgsl");

/// Returns the pass as it is compiled, for the depth or for the first depth pixel that has it.
pub fn source(first: bool) -> String {
    let constants = format!("{}const FIRST: bool = {first};\n", dots::constants(true));
    view::source("atomic<u32>", "u32", &[&constants, dots::SOURCE, SOURCE])
}

/// Builds the pipelines of both runs.
pub fn pipelines(gpu: &Gpu, layouts: &Layouts) -> Vec<ComputePipeline> {
    [false, true].map(|first| layouts.pipeline(gpu, "find", &source(first))).into()
}
