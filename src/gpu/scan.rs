//! Pass *scan* (`shaders/scan.wgsl`): converts counts to offsets by prefix sums.

use wgpu::{BindGroupLayout, CommandEncoder, ComputePipeline, ShaderStages};

use super::bindings::{self, BindingKind};
use super::device::Gpu;
use super::frame::{self, BoundRows};
use super::workspace::Workspace;

/// The WGSL source of the pass.
pub const SOURCE: &str = include_str!("../../shaders/scan.wgsl");

/// The number of pixels that one invocation adds up.
pub const RUN: u64 = 64;

/// The number of invocations in a workgroup of the steps over runs.
const WORKGROUP: u64 = 64;

/// The pipelines of the three steps.
#[derive(Debug)]
pub struct Scan {
    own: BindGroupLayout,
    sum_runs: ComputePipeline,
    place_runs: ComputePipeline,
    place_pixels: ComputePipeline,
}

impl Scan {
    /// Builds the pipelines.
    pub fn new(gpu: &Gpu, frame: &BindGroupLayout) -> Self {
        let own =
            bindings::layout(gpu, "scan", ShaderStages::COMPUTE, &[BindingKind::Write, BindingKind::Write]);
        let module = bindings::shader(gpu, "scan", &[frame::SOURCE, SOURCE].concat());
        let step = |entry| bindings::compute(gpu, entry, &module, &[frame, &own]);
        Self {
            sum_runs: step("sum_runs"),
            place_runs: step("place_runs"),
            place_pixels: step("place_pixels"),
            own,
        }
    }

    /// Records the pass: it converts the counts in the workspace to the offsets at which each pixel's entries
    /// end. The last word, after all pixels, is the total.
    pub fn record(&self, gpu: &Gpu, encoder: &mut CommandEncoder, space: &Workspace, bound: BoundRows) {
        let runs = (bound.rows.pixels() + 1).div_ceil(RUN);
        let resources = [space.places_of(bound.rows), bindings::words(&space.runs, runs)];
        let own = bindings::bind(gpu, "scan", &self.own, &resources);
        let workgroups = runs.div_ceil(WORKGROUP) as u32;
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_bind_group(0, bound.group, &[]);
        pass.set_bind_group(1, &own, &[]);
        let steps = [(&self.sum_runs, workgroups), (&self.place_runs, 1), (&self.place_pixels, workgroups)];
        for (step, workgroups) in steps {
            pass.set_pipeline(step);
            pass.dispatch_workgroups(workgroups, 1, 1);
        }
    }
}
