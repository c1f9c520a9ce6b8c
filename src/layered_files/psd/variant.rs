//! The variants of the format.

/// The variant of the format, which decides the width of lengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PsdVariant {
    /// PSD: up to 30,000 pixels per side and 2 GB.
    Psd,
    /// PSB, the large variant. GIMP before version 3 does not read it.
    Psb,
}
