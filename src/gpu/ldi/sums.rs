//! Pass *sums* (`shaders/ldi_sums.wgsl`): the sums of what is level with the nearest depth pixel, or of what is behind the near slot.

use wgpu::ComputePipeline;

use super::view::{self, Layouts};
use super::{dots, slots};
use crate::gpu::device::Gpu;

const SOURCE: &str = include_str!("../../../shaders/ldi_sums.wgsl");

/// Returns the pass as it is compiled, for the near slot or for the far one.
pub fn source(far: bool) -> String {
    let far = format!("const FAR: bool = {far};\n");
    let constants = [dots::constants(false), slots::constants(), far].concat();
    view::source("atomic<u32>", "atomic<u32>", &[&constants, dots::SOURCE, slots::SOURCE, SOURCE])
}

/// Builds the pipeline for the near slot or for the far one.
pub fn pipeline(gpu: &Gpu, layouts: &Layouts, far: bool) -> ComputePipeline {
    layouts.pipeline(gpu, "sums_of_slots", &source(far))
}
