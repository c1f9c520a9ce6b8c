//! Pass *nearest* (`shaders/ldi_nearest.wgsl`): the nearest inverse depth at each pixel, of all, or of what is behind the near slot.

use super::level::Filling;

/// The pass.
pub const PASS: Filling =
    Filling { entry: "nearest", text: include_str!("../../../shaders/ldi_nearest.wgsl") };
