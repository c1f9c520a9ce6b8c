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

impl TextureOptions {
    /// Returns the usual options, with limits for long tasks that draw a picture in slices and may take about `memory` bytes: on software adapters
    /// textures are in the same memory, and they take as much again while they grow.
    pub fn within(memory: u64) -> Self {
        let usual = Self::default();
        Self {
            budget_bytes: usual.budget_bytes.min(memory / 6).max(LEAST_BUDGET),
            cache_bytes: usual.cache_bytes.min(memory / 64),
            ..usual
        }
    }

    /// Returns the largest number of texels of layer textures that are decoded at once.
    pub fn decoded_texels(&self) -> u64 {
        (self.cache_bytes / DECODED_SHARE).clamp(LEAST_DECODED, MOST_DECODED)
    }
}

/// The least budget of textures, in bytes: less shows single pictures coarser than photos are.
const LEAST_BUDGET: u64 = 48 << 20;

/// The largest number of texels that are decoded at once, the least, and the bytes of the cache for each of the former: one takes about
/// twelve bytes until it is on the device, and the next ones are decoded meanwhile.
const MOST_DECODED: u64 = 32 << 20;
const LEAST_DECODED: u64 = 2 << 20;
const DECODED_SHARE: u64 = 8;

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
