//! The slots of a pixel, in which sums are (`shaders/ldi_slots.wgsl`).

use quadratura_ldi::splat::sums::{OVERFULL, PER_OPAQUE, SLIGHT};

/// The WGSL source that is put before the passes over slots.
pub const SOURCE: &str = include_str!("../../../shaders/ldi_slots.wgsl");

/// The words of a pixel that hold depths: see `PLANES` of the shader.
pub const PLANES: u64 = 4;
/// The words of a pixel's sums: `SLOTS` times `SUMS` of the shader.
pub const SUMS: u64 = 15;

/// A weight of 1 in the sums. 16 bits: of surfaces that are far away, pixels of a spacing of 1/100 have weights of 10^-4.
const WEIGHT_UNIT: f32 = 65_536.0;
/// A light of 1 in the sums. 18 bits: in the dark, a step of sRGB is 3 10^-4 of the light, of which weights are a part. 256
/// weights of the brightest light that counts have room in 32 bits.
const LIGHT_UNIT: f32 = 262_144.0;

/// Returns the constants of [`SOURCE`].
pub fn constants() -> String {
    [
        ("OVERFULL", OVERFULL),
        ("SLIGHT", SLIGHT),
        ("PER_OPAQUE", PER_OPAQUE),
        ("WEIGHT_UNIT", WEIGHT_UNIT),
        ("LIGHT_UNIT", LIGHT_UNIT),
    ]
    .map(|(name, value)| format!("const {name}: f32 = {value:?};\n"))
    .concat()
}
