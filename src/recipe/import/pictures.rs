//! What an import changed, to be looked at: each image layer around its changed pixels, before and after.

use std::collections::BTreeSet;
use std::path::Path;

use super::super::layer_pixels::layer_pixels;
use super::super::paint::PhotoPaint;
use crate::document::Stack;
use crate::document::paint::{PaintBook, Patch};
use crate::error::Result;
use crate::geometry::PixelRect;
use crate::io::layered::Raster;
use crate::io::layered::raster::in_8_bits;
use crate::io::paint_store::PaintStore;
use crate::io::stack_store::StackStore;
use crate::projection::Picture;
use crate::task::Task;

/// An image layer of today that looks other for an import.
#[derive(Debug, Clone, PartialEq)]
pub struct ChangedLayer {
    /// The photo.
    pub photo: String,
    /// Its place in the stack.
    pub layer: usize,
    /// Token.
    pub token: String,
    /// Pixels that look other.
    pub pixels: u64,
    /// What the pictures show, in photo pixels.
    pub rect: PixelRect,
    /// Without the import, and those after it.
    pub before: Picture,
    /// With it.
    pub after: Picture,
}

/// Around changed pixels this share of their rectangle's longer side is shown, so that one sees where they are.
const AROUND: f64 = 0.25;
/// At least so many pixels around them: a single one is seen as well.
const LEAST_AROUND: f64 = 12.0;

/// What the import `number` in the history of the project's paint, `book`, changed, sorted by photo and image layer;
/// pictures are at most `longest` pixels wide and high. None of it where the import is not in the history, or its photos
/// have no stack.
///
/// # Errors
/// When paint, stacks or layers cannot be read; [`crate::Error::Cancelled`].
pub fn changed_layers(
    project: &Path,
    book: &PaintBook,
    number: u32,
    longest: u32,
    task: &Task,
) -> Result<Vec<ChangedLayer>> {
    let (paint, stacks) = (PaintStore::new(project), StackStore::new(project));
    let Some(sides) = sides(book.clone(), number) else { return Ok(Vec::new()) };
    let mut changed = Vec::new();
    for photo in &sides.photos {
        let Some(stack) = stacks.current(photo)? else { continue };
        let [before, after] = [&sides.before, &sides.after].map(|b| PhotoPaint::of(b, paint.clone(), &stack));
        for layer in after.differs_on(&before) {
            task.go_on()?;
            let look = Look { stack: &stack, folder: &stacks.folder(photo), layer, longest };
            changed.extend(look.at(&before, &after)?);
        }
    }
    Ok(changed)
}

/// The book of paint before an import and after it.
struct Sides {
    before: PaintBook,
    after: PaintBook,
    photos: BTreeSet<String>,
}

/// Takes back one import after the other until this one is.
fn sides(mut book: PaintBook, number: u32) -> Option<Sides> {
    loop {
        let after = book.clone();
        let import = book.take_back()?;
        if import.number == number {
            return Some(Sides { before: book, after, photos: import.photos.into_iter().collect() });
        }
    }
}

/// One image layer.
struct Look<'a> {
    stack: &'a Stack,
    folder: &'a Path,
    layer: usize,
    longest: u32,
}

impl Look<'_> {
    fn at(&self, before: &PhotoPaint, after: &PhotoPaint) -> Result<Option<ChangedLayer>> {
        let layer = &self.stack.image_layers[self.layer];
        let (old, new) = (before.on(self.stack, self.layer)?, after.on(self.stack, self.layer)?);
        let Some((changed, pixels)) = difference(&old, &new) else { return Ok(None) };
        let margin = (AROUND * f64::from(changed.w.max(changed.h))).max(LEAST_AROUND) as u32;
        let rect = changed.grown(margin).intersection(&layer.rect);
        let shown = |paint: &PhotoPaint| {
            let raster = layer_pixels(self.stack, self.folder, paint, self.layer)?;
            let part = PixelRect { x: rect.x - layer.rect.x, y: rect.y - layer.rect.y, ..rect };
            Ok(picture(&raster.cropped(part), self.longest))
        };
        let (photo, token) = (self.stack.photo.name.clone(), layer.id.clone());
        let (before, after) = (shown(before)?, shown(after)?);
        Ok(Some(ChangedLayer { photo, layer: self.layer, token, pixels, rect, before, after }))
    }
}

/// The rectangle of the pixels that two states of paint do not have alike, and how many there are.
fn difference(old: &Patch, new: &Patch) -> Option<(PixelRect, u64)> {
    let others = |one: &Patch, two: &Patch| {
        let other = one.iter().filter(|(x, y, colour)| two.at(*x, *y) != Some(*colour));
        other.map(|(x, y, _)| (x, y)).collect::<BTreeSet<_>>()
    };
    let mut places = others(old, new);
    places.extend(others(new, old));
    let pixel = |&(x, y): &(i32, i32)| PixelRect { x, y, w: 1, h: 1 };
    let rect = places.iter().map(pixel).reduce(|a, b| a.union(&b))?;
    Some((rect, places.len() as u64))
}

/// A raster as a picture of at most `longest` pixels a side.
fn picture(raster: &Raster, longest: u32) -> Picture {
    let small = raster.thumbnail(longest);
    let (width, height) = (small.width(), small.height());
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    Picture { width, height, rgba: places.flat_map(|(x, y)| small.rgba16(x, y).map(in_8_bits)).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_new_gone_or_another_colour_is_a_difference() {
        let (red, blue) = ([65535, 0, 0, 65535], [0, 0, 65535, 65535]);
        let old = Patch::of_pixels(&[(1, 1, red), (2, 1, red), (3, 1, red)]);
        let new = Patch::of_pixels(&[(2, 1, red), (3, 1, blue), (9, 5, red)]);
        let (rect, pixels) = difference(&old, &new).unwrap();
        assert_eq!((rect, pixels), (PixelRect { x: 1, y: 1, w: 9, h: 5 }, 3));
        assert_eq!(difference(&new, &new.clone()), None);
    }
}
