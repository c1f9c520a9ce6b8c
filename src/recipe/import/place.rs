//! Location of the photo on the canvas of an edited document: unchanged, cropped or enlarged, or scaled.

use std::collections::BTreeMap;

use super::shift::shift;
use crate::geometry::PixelRect;
use crate::io::layered::{EditedDocument, Raster};

/// The largest error in pixels by which width and height may have been rounded.
const ROUNDED_PX: f64 = 1.0;

/// The location of the photo on a canvas.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CanvasPlacement {
    /// The scale is unchanged; the photo's top-left pixel is at this position of the canvas.
    At([i32; 2]),
    /// The image was scaled to this number of canvas pixels per photo pixel.
    Scaled(f64),
    /// The canvas has another size, and nothing on it tells where the photo is.
    Unclear,
}

/// Locates the photo of `width` x `height` on the canvas of a document. `layers` yields layers as they were
/// exported and as they are in the document, each with its rectangle; it is used only where the canvas has another
/// size. The majority of the layers decides.
pub fn place<'a>(
    document: &EditedDocument,
    (width, height): (u32, u32),
    layers: impl Iterator<Item = (&'a Raster, PixelRect, &'a Raster, PixelRect)>,
) -> CanvasPlacement {
    if (document.width, document.height) == (width, height) {
        return CanvasPlacement::At([0, 0]);
    }
    let mut votes: BTreeMap<[i32; 2], usize> = BTreeMap::new();
    for (base, at, found, found_at) in layers {
        if let Some(offset) = shift(base, at, found, found_at) {
            *votes.entry(offset).or_default() += 1;
        }
    }
    if let Some((offset, _)) = votes.into_iter().max_by_key(|(_, count)| *count) {
        return CanvasPlacement::At(offset);
    }
    let (x, y) = (ratio(document.width, width), ratio(document.height, height));
    let scale = x.max(y);
    let fits = |side: u32, canvas: u32| (f64::from(side) * scale - f64::from(canvas)).abs() <= ROUNDED_PX;
    let is_scaled = fits(width, document.width) && fits(height, document.height);
    if is_scaled { CanvasPlacement::Scaled(scale) } else { CanvasPlacement::Unclear }
}

/// Returns the ratio of two sides.
fn ratio(canvas: u32, photo: u32) -> f64 {
    f64::from(canvas) / f64::from(photo.max(1))
}
