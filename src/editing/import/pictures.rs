//! Previews of an import: each changed image layer around its changed pixels, before and after.

use std::collections::BTreeSet;
use std::path::Path;

use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::task::Task;
use quadratura_document::Stack;
use quadratura_document::paint::{PaintBook, PaintPatch};
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::StackStore;
use quadratura_layered_files::Raster;
use quadratura_layers::LayerIndex;
use quadratura_stacks::layer_pixels::layer_pixels;
use quadratura_stacks::paint::PhotoPaint;
use quadratura_view::Picture;

/// An image layer that an import changes.
#[derive(Debug, Clone, PartialEq)]
pub struct ChangedLayer {
    /// The photo's name.
    pub photo: String,
    /// The index of the layer in the stack.
    pub layer: LayerIndex,
    /// The layer's token.
    pub token: String,
    /// The number of changed pixels.
    pub pixels: u64,
    /// The part that the pictures show, in photo pixels.
    pub rect: PixelRect,
    /// The layer without the import and later ones.
    pub before: Picture,
    /// The layer with the import.
    pub after: Picture,
}

/// The margin around changed pixels, as a share of their rectangle's longer side, so that their location can be
/// recognised.
const AROUND: f64 = 0.25;
/// The least margin in pixels, so that single pixels are visible, too.
const LEAST_AROUND: f64 = 12.0;

/// Returns the image layers that the import `number` in the history of the project's paint, `book`, changed, sorted
/// by photo and image layer, with pictures of at most `longest` pixels in width and height. The result is empty where
/// the import is not in the history, or its photos have no stack.
///
/// # Errors
/// Returns an error when paint, stacks or layers cannot be read, or [`quadratura_base::Error::Cancelled`].
pub fn changed_layers(
    project: &Path,
    book: &PaintBook,
    number: u32,
    longest: u32,
    task: &Task,
) -> Result<Vec<ChangedLayer>> {
    let paint = PaintStore::new(project);
    let stacks = StackStore::new(project);
    let Some(sides) = sides(book.clone(), number) else { return Ok(Vec::new()) };
    let mut changed = Vec::new();
    for photo in &sides.photos {
        let Some(stack) = stacks.current(photo)? else { continue };
        let [before, after] =
            [&sides.before, &sides.after].map(|b| PhotoPaint::new(b, paint.clone(), &stack));
        for layer in after.differs_on(&before) {
            task.check_cancelled()?;
            let look = LayerComparison { stack: &stack, folder: &stacks.folder(photo), layer, longest };
            changed.extend(look.at(&before, &after)?);
        }
    }
    Ok(changed)
}

/// The paint book before an import and after it.
struct BooksCompared {
    before: PaintBook,
    after: PaintBook,
    photos: BTreeSet<String>,
}

/// Undoes imports in memory, the latest first, up to and including this one.
fn sides(mut book: PaintBook, number: u32) -> Option<BooksCompared> {
    loop {
        let after = book.clone();
        let import = book.take_back()?;
        if import.number == number {
            return Some(BooksCompared { before: book, after, photos: import.photos.into_iter().collect() });
        }
    }
}

/// An image layer to be compared.
struct LayerComparison<'a> {
    stack: &'a Stack,
    folder: &'a Path,
    layer: LayerIndex,
    longest: u32,
}

impl LayerComparison<'_> {
    /// Compares the layer with two states of the paint; `None` where they are equal.
    fn at(&self, before: &PhotoPaint, after: &PhotoPaint) -> Result<Option<ChangedLayer>> {
        let layer = self.stack.layer(self.layer);
        let old = before.on(self.stack, self.layer)?;
        let new = after.on(self.stack, self.layer)?;
        let Some((changed, pixels)) = difference(&old, &new) else { return Ok(None) };
        let margin = (AROUND * f64::from(changed.w.max(changed.h))).max(LEAST_AROUND) as u32;
        let rect = changed.grown(margin).intersection(&layer.rect);
        let picture_with = |paint: &PhotoPaint| {
            let raster = layer_pixels(self.stack, self.folder, paint, self.layer)?;
            let part = PixelRect { x: rect.x - layer.rect.x, y: rect.y - layer.rect.y, ..rect };
            Ok(picture(&raster.cropped(part), self.longest))
        };
        let photo = self.stack.photo.name.clone();
        let token = layer.id.clone();
        let (before, after) = (picture_with(before)?, picture_with(after)?);
        Ok(Some(ChangedLayer { photo, layer: self.layer, token, pixels, rect, before, after }))
    }
}

/// Returns the bounding box and the number of the pixels that differ between two states of paint; `None` where
/// there are none.
fn difference(old: &PaintPatch, new: &PaintPatch) -> Option<(PixelRect, u64)> {
    let others = |one: &PaintPatch, two: &PaintPatch| {
        let other = one.iter().filter(|(x, y, colour)| two.at(*x, *y) != Some(*colour));
        other.map(|(x, y, _)| (x, y)).collect::<BTreeSet<_>>()
    };
    let mut positions = others(old, new);
    positions.extend(others(new, old));
    let pixel = |&(x, y): &(i32, i32)| PixelRect { x, y, w: 1, h: 1 };
    let rect = positions.iter().map(pixel).reduce(|a, b| a.union(&b))?;
    Some((rect, positions.len() as u64))
}

/// Converts a raster to a picture of at most `longest` pixels per side.
fn picture(raster: &Raster, longest: u32) -> Picture {
    let small = raster.thumbnail(longest);
    Picture { width: small.width(), height: small.height(), rgba: small.samples().big_endian().into_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_new_gone_or_another_colour_is_a_difference() {
        let (red, blue) = ([65535, 0, 0, 65535], [0, 0, 65535, 65535]);
        let old = PaintPatch::of_pixels(&[(1, 1, red), (2, 1, red), (3, 1, red)]);
        let new = PaintPatch::of_pixels(&[(2, 1, red), (3, 1, blue), (9, 5, red)]);
        let (rect, pixels) = difference(&old, &new).unwrap();
        assert_eq!((rect, pixels), (PixelRect { x: 1, y: 1, w: 9, h: 5 }, 3));
        assert_eq!(difference(&new, &new.clone()), None);
    }
}
