//! The nearest samples in one run (`shaders/flakes_wide.wgsl`), for devices that find maxima of words of 64 bits.

/// The WGSL source that is put before the pass *flakes*.
pub const SOURCE: &str = include_str!("../../../../shaders/flakes_wide.wgsl");
