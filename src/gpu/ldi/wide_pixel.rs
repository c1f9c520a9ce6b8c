//! Pass *find* of single pixels in one run (`shaders/ldi_wide_pixel.wgsl`), for devices that find maxima of words of 64 bits.

use wgpu::ComputePipeline;

use super::dots;
use super::view::{self, Layouts};
use crate::device::Gpu;

const SOURCE: &str = include_str!("../../../shaders/ldi_wide_pixel.wgsl");

/// Returns the pass as it is compiled.
pub fn source() -> String {
    view::source("atomic<u64>", "u32", &[&dots::constants(true), dots::SOURCE, SOURCE])
}

/// Builds the pipeline.
pub fn pipelines(gpu: &Gpu, layouts: &Layouts) -> Vec<ComputePipeline> {
    vec![layouts.pipeline(gpu, "find", &source())]
}
