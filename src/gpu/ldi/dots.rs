//! Passes over depth pixels (`shaders/ldi_dots.wgsl`): each is placed in the picture, and the pass is called for the pixels of
//! its splat.

use wgpu::{ComputePass, ComputePipeline};

use super::uploaded::LevelChunk;
use super::view::WORKGROUP;
use quadratura_ldi::splat::sums::{CLOSED_BY_ONE, COVERS, LARGEST, LEAST, LEVEL};
use quadratura_ldi::stretch::{CLOSED, LEAST_FACTOR, LEAST_SQUARES, LONGEST};
use quadratura_ldi::transfer::RUN;

/// The WGSL source that is put before the passes over depth pixels.
pub const SOURCE: &str = include_str!("../../../shaders/ldi_dots.wgsl");

/// Returns the constants of [`SOURCE`]; `single` where splats are one pixel.
pub fn constants(single: bool) -> String {
    let bits = RUN.ilog2();
    format!(
        "const RUN_BITS: u32 = {bits}u;\nconst LARGEST: f32 = {LARGEST:?};\n\
         const CLOSED_BY_ONE: f32 = {CLOSED_BY_ONE:?};\nconst LEAST: f32 = {LEAST:?};\n\
         const COVERS: f32 = {COVERS:?};\nconst COVERS_LEVEL: f32 = {LEVEL:?};\n\
         const LEAST_SQUARES: f32 = {LEAST_SQUARES:?};\nconst LEAST_FACTOR: f32 = {LEAST_FACTOR:?};\nconst CLOSED: f32 = {CLOSED:?};\nconst LONGEST: f32 = {LONGEST:?};\n\
         const SINGLE: bool = {single};\n"
    )
}

/// Records a pass over the depth pixels `within` of the chunks of a level.
pub fn record(pass: &mut ComputePass, pipeline: &ComputePipeline, chunks: &[LevelChunk], within: [u32; 2]) {
    pass.set_pipeline(pipeline);
    for chunk in chunks {
        let (first, end) = (chunk.pixels.start.max(within[0]), chunk.pixels.end.min(within[1]));
        if first < end {
            pass.set_bind_group(1, &chunk.group, &[]);
            pass.dispatch_workgroups((end - first).div_ceil(WORKGROUP), 1, 1);
        }
    }
}
