//! Pass *sums* (`shaders/ldi_sums.wgsl`): the sums of what is level with the near slot's depth, or with the far one's.

use super::level::Filling;

/// The pass.
pub const PASS: Filling =
    Filling { entry: "sums_of_slots", text: include_str!("../../../shaders/ldi_sums.wgsl") };
