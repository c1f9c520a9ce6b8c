//! The stippled transparency (`shaders/stipple.wgsl`): in which sub-pixels something is drawn that is drawn in part. Its words are
//! [`quadratura_foliage::Stipple::word`].

/// The WGSL source that is put before the passes that draw through stipples.
pub const SOURCE: &str = include_str!("../../../../shaders/stipple.wgsl");
