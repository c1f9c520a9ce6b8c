//! What the user decides about the reading of cameras.

/// Decisions about the reading of cameras, which a project keeps.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CameraOptions {
    /// The chunk of a Metashape project that is read, by its label. `None` for the one with most aligned cameras.
    pub chunk: Option<String>,
    /// Whether photos of rolling shutters are resampled row by row; otherwise a note says how far it moves them.
    pub rolling_shutter: bool,
}
