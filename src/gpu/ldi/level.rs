//! Passes over depth pixels that fill slots; which slot a depth pixel belongs to is in `shaders/ldi_level.wgsl`.

use wgpu::ComputePipeline;

use super::view::{self, Layouts};
use super::{dots, nearest, slots, sums, surface};
use crate::device::Gpu;
use quadratura_ldi::splat::sums::{APART, APART_PIXELS, LEVEL};

/// The WGSL source that is put before the passes.
const SOURCE: &str = include_str!("../../../shaders/ldi_level.wgsl");

/// A pass over depth pixels that fills slots. Each runs twice, for the near slot and for the far one.
#[derive(Debug, Clone, Copy)]
pub struct Filling {
    /// The function of the shader.
    pub entry: &'static str,
    /// The WGSL source of the pass alone.
    pub text: &'static str,
}

/// The passes in their order.
pub const FILLING: [Filling; 3] = [nearest::PASS, surface::PASS, sums::PASS];

impl Filling {
    /// Returns the pass as it is compiled, for the near slot or for the far one.
    pub fn source(&self, far: bool) -> String {
        let far = format!("const FAR: bool = {far};\n");
        let constants = [dots::constants(false), slots::constants(), constants(), far].concat();
        let texts = [&constants, dots::SOURCE, slots::SOURCE, SOURCE, self.text];
        view::source("atomic<u32>", "atomic<u32>", &texts)
    }

    /// Builds the pipeline for the near slot or for the far one.
    pub fn pipeline(&self, gpu: &Gpu, layouts: &Layouts, far: bool) -> ComputePipeline {
        layouts.pipeline(gpu, self.entry, &self.source(far))
    }
}

/// Returns the constants of [`SOURCE`].
fn constants() -> String {
    [("LEVEL", LEVEL), ("APART", APART), ("APART_PIXELS", APART_PIXELS)]
        .map(|(name, value)| format!("const {name}: f32 = {value:?};\n"))
        .concat()
}
