//! Where the photo lies on a canvas that came back: as it was, cropped or enlarged, or scaled.

use std::collections::BTreeMap;

use super::shift::shift;
use crate::geometry::PixelRect;
use crate::io::layered::{EditedDocument, Raster};

/// Width and height may have been rounded to whole pixels: by less than this.
const ROUNDED_PX: f64 = 1.0;

/// The canvas against the photo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// Pixel for pixel; the photo's top left pixel is at this place of the canvas.
    At([i32; 2]),
    /// So many pixels of the canvas to one of the photo.
    Scaled(f64),
    /// Of another size, and nothing on it says where the photo lies.
    Unclear,
}

/// Where the photo of `width` x `height` lies on the canvas of a document. `layers` yields layers as they were exported
/// and as they came back, each with its place; it is asked only where the canvas has another size. Most votes win.
pub fn place<'a>(
    document: &EditedDocument,
    (width, height): (u32, u32),
    layers: impl Iterator<Item = (&'a Raster, PixelRect, &'a Raster, PixelRect)>,
) -> Place {
    if (document.width, document.height) == (width, height) {
        return Place::At([0, 0]);
    }
    let mut votes: BTreeMap<[i32; 2], usize> = BTreeMap::new();
    for (base, at, found, found_at) in layers {
        if let Some(offset) = shift(base, at, found, found_at) {
            *votes.entry(offset).or_default() += 1;
        }
    }
    if let Some((offset, _)) = votes.into_iter().max_by_key(|(_, count)| *count) {
        return Place::At(offset);
    }
    let (x, y) = (ratio(document.width, width), ratio(document.height, height));
    let scale = x.max(y);
    let fits = |side: u32, canvas: u32| (f64::from(side) * scale - f64::from(canvas)).abs() <= ROUNDED_PX;
    let is_scaled = fits(width, document.width) && fits(height, document.height);
    if is_scaled { Place::Scaled(scale) } else { Place::Unclear }
}

fn ratio(canvas: u32, photo: u32) -> f64 {
    f64::from(canvas) / f64::from(photo.max(1))
}
