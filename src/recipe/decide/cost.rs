//! What merging image layers by hand would cost: one rectangle around all of them, with whatever lies between.

use crate::document::Stack;
use crate::geometry::PixelRect;
use crate::layers::Options;
use crate::layers::cluster::{box_size, longest_side};

/// A merge costs a power of two on one side even where two layers lie beside each other without a gap: up to twice the
/// texels of the parts. Beyond that it is emptiness that is kept.
const MOST_TIMES: u64 = 2;
/// Less than this share of the photo's own pixels nobody notices, however many times the parts it is.
const NOTICED: u64 = 10;

/// The image layer that several would become.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MergeCost {
    /// How many they are.
    pub layers: usize,
    /// Width and height of its rectangle, in pixels.
    pub size: [u32; 2],
    /// Texels of its rectangle.
    pub texels: u64,
    /// Texels of theirs.
    pub before: u64,
    /// Texels that surfaces cover, in either.
    pub used: u64,
    /// Pixels of the photo.
    pub photo: u64,
    /// No image layer has a longer side, in pixels.
    pub longest: u32,
}

impl MergeCost {
    /// Of layers of a stack, by their places; `options` are the photo's. None for fewer than two.
    pub fn of(stack: &Stack, layers: &[usize], options: &Options) -> Option<Self> {
        let parts: Vec<_> = layers.iter().filter_map(|place| stack.image_layers.get(*place)).collect();
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

    /// It is so much more than before that one should know.
    pub fn is_high(&self) -> bool {
        let more = self.texels.saturating_sub(self.before);
        self.texels > MOST_TIMES * self.before && more > self.photo / NOTICED
    }

    /// The rectangle is larger than image layers may be: the next build would leave parts of it apart.
    pub fn is_too_large(&self) -> bool {
        self.size.iter().any(|side| *side > self.longest)
    }

    /// How many times the texels of before.
    pub fn times(&self) -> f64 {
        self.texels as f64 / self.before.max(1) as f64
    }
}
