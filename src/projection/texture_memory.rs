//! The texture memory of a device that draws a site: its limits and its format.

use super::pyramid::PyramidOptions;
use super::tiles::SLOT;

/// The limits and format of texture memory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextureOptions {
    /// The largest size of texels on the device, in bytes.
    pub budget_bytes: u64,
    /// The largest size of decoded layer textures kept in main memory, in bytes.
    pub cache_bytes: u64,
    /// Options of levels and confidence.
    pub pyramid: PyramidOptions,
    /// The format of texels on the device.
    pub storage: Storage,
}

impl Default for TextureOptions {
    fn default() -> Self {
        Self {
            budget_bytes: 4 << 30,
            cache_bytes: 256 << 20,
            pyramid: PyramidOptions::default(),
            storage: Storage::default(),
        }
    }
}

/// The format of texels in slots.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Storage {
    /// 4 bytes per texel, uncompressed.
    #[default]
    Plain,
    /// BC7, 1 byte per texel: colours lose a few steps of 255, and loading takes longer.
    Compressed,
}

impl Storage {
    /// Returns the number of bytes of a slot.
    pub fn slot_bytes(self) -> u64 {
        let texels = u64::from(SLOT * SLOT);
        if self == Self::Plain { 4 * texels } else { texels }
    }
}
