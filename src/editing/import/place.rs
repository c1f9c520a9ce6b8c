//! Location of the photo on the canvas of an edited document: unchanged, cropped or enlarged, or scaled.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use super::compare::PlacedRaster;
use super::gather::gathered;
use super::identify::SortedLayers;
use super::originals::ExportedPixels;
use super::shift::shift;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_document::export_record::ExportRecord;
use quadratura_document::paint::PaintColour;
use quadratura_layered_files::{EditedDocument, Raster};

/// The number of layers, the largest ones, by which the canvas is located.
const VOTERS: usize = 8;
/// The number of layers that have to be moved together before the others count as moved, too: one or two may have been moved by hand.
const AGREEING: usize = 3;
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

/// An image layer as it was exported, and as it is in the document, each with its rectangle: in the photo, and on the
/// canvas.
pub struct PlacedLayer {
    /// The exported pixels.
    pub base: Raster,
    /// Their rectangle in photo pixels.
    pub at: PixelRect,
    /// The pixels in the document, in the depth of the exported ones.
    pub found: Raster,
    /// Their rectangle on the canvas.
    pub found_at: PixelRect,
}

/// The number of pixels of a layer that stand for all of them.
const SAMPLED: u64 = 4096;

impl PlacedLayer {
    /// Returns colours as they were exported and as they are in the document, whose canvas shows the photo at `offset`.
    pub fn colours(&self, offset: [i32; 2]) -> Vec<(PaintColour, PaintColour)> {
        let step = (self.at.area() / SAMPLED).max(1) as usize;
        let (base, found) = (
            PlacedRaster { rect: self.at, pixels: &self.base },
            PlacedRaster { rect: self.found_at, pixels: &self.found },
        );
        let pairs = self
            .at
            .pixels()
            .step_by(step)
            .map(|(x, y)| (base.at(x, y), found.at(x + offset[0], y + offset[1])));
        pairs.filter(|(base, found)| base[3] != 0 && found[3] != 0).collect()
    }
}

/// Returns the largest image layers of a document whose exported pixels are known.
///
/// # Errors
/// Returns the errors of reading the exported pixels.
pub fn placed_layers(
    record: &ExportRecord,
    sorted: &SortedLayers,
    originals: ExportedPixels,
) -> Result<Vec<PlacedLayer>> {
    let mut largest: Vec<_> = sorted.image_layers.iter().collect();
    largest.sort_by_key(|(index, layers)| (Reverse(layers[0].rect.area()), **index));
    let mut placed = Vec::new();
    for (index, layers) in largest.into_iter().take(VOTERS) {
        let exported = &record.layers[index.0];
        let Some(base) = originals.pixels(record, exported)? else { continue };
        // A layer that cannot be read is left out later, with the reason.
        let Ok(found) = gathered(layers) else { continue };
        let pixels = found.pixels.in_depth(base.depth());
        placed.push(PlacedLayer { base, at: exported.baseline.rect, found: pixels, found_at: found.rect });
    }
    Ok(placed)
}

/// Locates the photo of an export on the canvas of a document, by the size of the canvas or by the largest image
/// layers, of which the majority decides.
///
/// # Errors
/// Returns the errors of reading the exported pixels.
pub fn place(
    document: &EditedDocument,
    record: &ExportRecord,
    sorted: &SortedLayers,
    originals: ExportedPixels,
) -> Result<CanvasPlacement> {
    let (canvas, photo) = ((document.width, document.height), (record.photo.width, record.photo.height));
    if canvas == photo {
        let rects = sorted.image_layers.iter().map(|(index, layers)| {
            (record.layers[index.0].exported_rect, layers.iter().map(|layer| layer.rect).next())
        });
        return Ok(CanvasPlacement::At(common_offset(rects)));
    }
    let mut votes: BTreeMap<[i32; 2], usize> = BTreeMap::new();
    for layer in placed_layers(record, sorted, originals)? {
        if let Some(offset) = shift(&layer.base, layer.at, &layer.found, layer.found_at) {
            *votes.entry(offset).or_default() += 1;
        }
    }
    if let Some((offset, _)) = votes.into_iter().max_by_key(|(_, count)| *count) {
        return Ok(CanvasPlacement::At(offset));
    }
    Ok(scale_of(canvas, photo).map_or(CanvasPlacement::Unclear, CanvasPlacement::Scaled))
}

/// Returns the offset by which most layers were moved together, from their rectangles as they were exported and as they are; zero
/// where most were not, or where too few agree.
fn common_offset(rects: impl Iterator<Item = (PixelRect, Option<PixelRect>)>) -> [i32; 2] {
    let mut votes: BTreeMap<[i32; 2], usize> = BTreeMap::new();
    let mut all = 0;
    for (exported, found) in rects {
        all += 1;
        let of_the_same_size = found.filter(|found| (found.w, found.h) == (exported.w, exported.h));
        if let Some(found) = of_the_same_size {
            *votes.entry([found.x - exported.x, found.y - exported.y]).or_default() += 1;
        }
    }
    let most = votes.into_iter().max_by_key(|(_, count)| *count);
    most.filter(|(_, count)| *count >= AGREEING && 2 * count > all).map_or([0, 0], |(offset, _)| offset)
}

/// Returns the scale with which a photo has the size of a canvas; `None` where the sides have other proportions.
pub fn scale_of(canvas: (u32, u32), (width, height): (u32, u32)) -> Option<f64> {
    let scale = ratio(canvas.0, width).max(ratio(canvas.1, height));
    let fits = |side: u32, canvas: u32| (f64::from(side) * scale - f64::from(canvas)).abs() <= ROUNDED_PX;
    (fits(width, canvas.0) && fits(height, canvas.1)).then_some(scale)
}

/// Returns the ratio of two sides.
fn ratio(canvas: u32, photo: u32) -> f64 {
    f64::from(canvas) / f64::from(photo.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Layers of several sizes, of which the edited file has these offsets; `None` for one of another size.
    fn offset_of(offsets: &[Option<[i32; 2]>]) -> [i32; 2] {
        let rect = |index: usize| PixelRect { x: 7 * index as i32, y: 3, w: 8 << index, h: 16 };
        common_offset(offsets.iter().enumerate().map(|(index, offset)| {
            let exported = rect(index);
            let found = offset.map_or(PixelRect { w: 5, ..exported }, |[x, y]| PixelRect {
                x: exported.x + x,
                y: exported.y + y,
                ..exported
            });
            (exported, Some(found))
        }))
    }

    #[test]
    fn layers_that_were_moved_together_agree_and_a_few_that_were_moved_by_hand_do_not() {
        let (moved, stays) = (Some([-13, 7]), Some([0, 0]));
        assert_eq!(offset_of(&[moved, moved, moved, stays, None]), [-13, 7]);
        assert_eq!(offset_of(&[moved, moved, stays]), [0, 0], "two are too few");
        assert_eq!(offset_of(&[moved, moved, moved, stays, stays, stays]), [0, 0], "half are not most");
        assert_eq!(offset_of(&[stays, stays, stays, moved]), [0, 0]);
        assert_eq!(offset_of(&[]), [0, 0]);
    }
}
