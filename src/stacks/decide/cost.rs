//! The cost of merging image layers: one rectangle around all of them, including whatever lies between.

use quadratura_base::geometry::PixelRect;
use quadratura_document::Stack;
use quadratura_layers::cluster::{box_size, longest_side};
use quadratura_layers::{LayerIndex, Options};

/// The ratio of texels after and before up to which a merge is cheap. Rounding to powers of two costs up to a
/// factor of two even where two layers are adjacent; beyond that the rectangle holds empty space.
const MOST_TIMES: u64 = 2;
/// The additional texels that are acceptable in any case, as a divisor of the photo's pixels.
const NOTICED: u64 = 10;

/// The image layer that several would become.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MergeCost {
    /// The number of layers that are merged.
    pub layers: usize,
    /// The rectangle's width and height in pixels.
    pub size: [u32; 2],
    /// The number of texels of the rectangle.
    pub texels: u64,
    /// The number of texels of the separate rectangles.
    pub before: u64,
    /// The number of texels that surfaces cover, which is the same before and after.
    pub used: u64,
    /// The number of pixels of the photo.
    pub photo: u64,
    /// The longest permitted side of an image layer in pixels.
    pub longest: u32,
}

impl MergeCost {
    /// Computes the cost of merging layers of a stack, by index; `options` are the photo's. `None` for fewer than
    /// two layers.
    pub fn new(stack: &Stack, layers: &[LayerIndex], options: &Options) -> Option<Self> {
        let parts: Vec<_> = layers.iter().filter_map(|index| stack.image_layers.get(index.index())).collect();
        let bounds = parts.iter().map(|layer| layer.needed_rect).reduce(|a, b| a.union(&b))?;
        let size: PixelRect = box_size(bounds, options);
        (parts.len() > 1).then(|| Self {
            layers: parts.len(),
            size: [size.w, size.h],
            texels: size.area(),
            before: parts.iter().map(|layer| layer.rect.area()).sum(),
            used: parts.iter().map(|layer| layer.texels_used).sum(),
            photo: u64::from(stack.photo.width) * u64::from(stack.photo.height),
            longest: longest_side(options),
        })
    }

    /// Returns true when the increase is large enough for a warning.
    pub fn is_high(&self) -> bool {
        let more = self.texels.saturating_sub(self.before);
        self.texels > MOST_TIMES * self.before && more > self.photo / NOTICED
    }

    /// Returns true when the rectangle exceeds the permitted size, so that the next build would keep parts of it
    /// separate.
    pub fn is_too_large(&self) -> bool {
        self.size.iter().any(|side| *side > self.longest)
    }

    /// Returns the ratio of texels after and before.
    pub fn times(&self) -> f64 {
        self.texels as f64 / self.before.max(1) as f64
    }
}
