//! Pass *surface* (`shaders/ldi_surface.wgsl`): the surface of the depth pixel that pass *nearest* found.

use super::level::Filling;

/// The pass.
pub const PASS: Filling =
    Filling { entry: "surface_of_nearest", text: include_str!("../../../shaders/ldi_surface.wgsl") };
