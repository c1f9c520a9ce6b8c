//! Pass *resolve* (`shaders/ldi_resolve.wgsl`): the colours of the picture from the sums of its pixels.

use wgpu::ComputePipeline;

use super::slots;
use super::view::{self, Layouts};
use crate::device::Gpu;

const SOURCE: &str = include_str!("../../../shaders/ldi_resolve.wgsl");

/// Returns the pass as it is compiled.
pub fn source() -> String {
    view::source("u32", "u32", &[&slots::constants(), slots::SOURCE, SOURCE])
}

/// Builds the pipeline.
pub fn pipeline(gpu: &Gpu, layouts: &Layouts) -> ComputePipeline {
    layouts.pipeline(gpu, "resolve", &source())
}
