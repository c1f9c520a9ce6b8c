//! The screen door (`shaders/door.wgsl`): in which sub-pixels something is drawn that is drawn in part. Its words are
//! [`quadratura_foliage::Door::word`].

/// The WGSL source that is put before the passes that draw through doors.
pub const SOURCE: &str = include_str!("../../../../shaders/door.wgsl");
