//! One image layer alone, to be looked at: its pixels, or how far they are trusted and where they come from.

use std::path::Path;

use super::layer_pixels::{layer_pixels, unfilled_pixels};
use super::origins::origin_of;
use super::paint::PhotoPaint;
use crate::document::Stack;
use crate::document::stack::origins;
use crate::error::Result;
use crate::geometry::PixelRect;
use crate::io::layer_reader::{read_grey, read_layer, read_mask};
use crate::io::layered::Raster;
use crate::io::stack_store::StackStore;
use crate::projection::Picture;
use crate::projection::hatching::Mask;
use crate::projection::legend::{CONFIDENCE, Origin, colour_at};
use crate::raster::in_8_bits;
use crate::task::Task;

/// What is shown of a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LayerLook {
    /// Its pixels: the photo's, and with them what fills and what was painted.
    Pixels {
        /// With the filling.
        filling: bool,
        /// With paint.
        paint: bool,
    },
    /// How far each texel is trusted.
    Confidence,
    /// Where each texel comes from.
    Provenance,
}

/// What colours mean: each with its texels.
pub type Legend = Vec<(String, [u8; 3], u64)>;

/// A layer to look at, as large as its rectangle.
#[derive(Debug)]
pub struct LayerView {
    /// Transparent where there is nothing.
    pub picture: Picture,
    /// In photo pixels: what is needed and empty.
    pub hidden: Mask,
    /// For confidence and provenance.
    pub legend: Legend,
}

/// Other photos, in turn.
const OTHERS: [[u8; 3]; 8] = [
    [0x66, 0xa6, 0x1e],
    [0x1b, 0x9e, 0x77],
    [0x7f, 0xc9, 0xa8],
    [0xa6, 0x76, 0x1d],
    [0x4d, 0xaf, 0xc4],
    [0xe4, 0x8a, 0x72],
    [0x9a, 0xb9, 0x73],
    [0x73, 0x70, 0xb3],
];
/// The image layer `layer` of `stack`, which belongs to the project in the folder `project`.
///
/// # Errors
/// What reading its files and its paint says; [`crate::Error::Cancelled`].
pub fn layer_view(
    project: &Path,
    stack: &Stack,
    layer: usize,
    look: LayerLook,
    task: &Task,
) -> Result<LayerView> {
    let folder = StackStore::new(project).folder(&stack.photo.name);
    let painted = PhotoPaint::open(project, stack)?;
    let files = Files { folder: &folder, stack, layer };
    task.go_on()?;
    let needed = files.needed()?;
    task.go_on()?;
    let (picture, legend) = match look {
        LayerLook::Pixels { filling, paint } => {
            let paint = if paint { &painted } else { &PhotoPaint::default() };
            let read = if filling { layer_pixels } else { unfilled_pixels };
            (in_bytes(&read(stack, &folder, paint, layer)?), Vec::new())
        }
        LayerLook::Confidence => files.confidence(&painted, &needed)?,
        LayerLook::Provenance => files.provenance(&painted, &needed)?,
    };
    let hidden = files.hidden(&picture, &needed);
    Ok(LayerView { picture, hidden, legend })
}

fn in_bytes(raster: &Raster) -> Picture {
    let (width, height) = (raster.width(), raster.height());
    let pixels = PixelRect::of_size(width, height).pixels();
    // What lies under transparent pixels of a file helps filtering there, and is nothing to look at.
    let seen = |(x, y)| match raster.rgba16(x as u32, y as u32).map(in_8_bits) {
        [.., 0] => [0; 4],
        pixel => pixel,
    };
    Picture { width, height, rgba: pixels.flat_map(seen).collect() }
}

/// The files of one image layer.
struct Files<'a> {
    folder: &'a Path,
    stack: &'a Stack,
    layer: usize,
}

/// Of each texel the number of its entry in a legend, 0 for none.
type Numbered = Vec<u16>;

impl Files<'_> {
    fn rect(&self) -> PixelRect {
        self.stack.image_layers[self.layer].rect
    }

    fn needed(&self) -> Result<Vec<u8>> {
        let layer = &self.stack.image_layers[self.layer];
        read_mask(&self.folder.join(&layer.needed_file), layer.rect, layer.rect)
    }

    /// Texels that are needed and that the photo shows.
    fn visible(&self, needed: &[u8]) -> Result<Vec<bool>> {
        let layer = &self.stack.image_layers[self.layer];
        let texels = read_layer(&self.folder.join(&layer.file), layer.rect, layer.rect)?;
        Ok(texels
            .as_chunks::<4>()
            .0
            .iter()
            .zip(needed)
            .map(|(texel, needed)| texel[3] > 0 && *needed > 0)
            .collect())
    }

    fn hidden(&self, picture: &Picture, needed: &[u8]) -> Mask {
        let rect = self.rect();
        let texels = picture.pixels().iter().zip(needed);
        Mask::new(rect, texels.map(|(texel, needed)| texel[3] == 0 && *needed > 0).collect())
    }

    /// The texels that were painted: their places.
    fn painted(&self, paint: &PhotoPaint) -> Result<Vec<usize>> {
        let rect = self.rect();
        let patch = paint.on(self.stack, self.layer)?;
        Ok(patch.iter().filter(|(.., colour)| colour[3] > 0).map(|(x, y, _)| rect.offset(x, y)).collect())
    }

    fn confidence(&self, paint: &PhotoPaint, needed: &[u8]) -> Result<(Picture, Legend)> {
        let layer = &self.stack.image_layers[self.layer];
        let mut trust: Vec<Option<u8>> =
            self.visible(needed)?.into_iter().map(|visible| visible.then_some(u8::MAX)).collect();
        if let Some(fill) = &layer.fill {
            let grey = read_grey(&self.folder.join(&fill.confidence_file), layer.rect, layer.rect)?;
            // Also where paint of another photo lies over what this one shows.
            let filled = trust.iter_mut().zip(grey).filter(|(_, grey)| *grey > 0);
            filled.for_each(|(trust, grey)| *trust = Some(grey.min(255) as u8));
        }
        self.painted(paint)?.into_iter().for_each(|at| trust[at] = Some(u8::MAX));
        let colour = |trust: &Option<u8>| trust.map(|trust| colour_at(CONFIDENCE, f32::from(trust) / 255.0));
        let picture = self.picture(trust.iter().map(colour));
        let names = ["none", "a third", "two thirds", "full"];
        let third = |trust: &Option<u8>| trust.map(|trust| (f32::from(trust) / 85.0).round() as usize);
        let count = |at: usize| trust.iter().filter(|trust| third(trust) == Some(at)).count() as u64;
        let legend = names.into_iter().zip(CONFIDENCE).enumerate();
        Ok((picture, legend.map(|(at, (name, colour))| (name.to_owned(), *colour, count(at))).collect()))
    }

    fn provenance(&self, paint: &PhotoPaint, needed: &[u8]) -> Result<(Picture, Legend)> {
        let layer = &self.stack.image_layers[self.layer];
        let entry = |name: &str, origin: Origin| (name.to_owned(), origin.colour());
        let names = self.stack.fill.as_ref().map_or(&[][..], |fill| &fill.origins);
        let mut entries =
            vec![(String::new(), [0; 3]), entry("this photo", Origin::Photo), entry("paint", Origin::Paint)];
        let first = entries.len() as u16;
        entries.extend(names.iter().enumerate().map(|(at, name)| origin(name, at)));
        let mut from: Numbered = self.visible(needed)?.into_iter().map(u16::from).collect();
        if let Some(fill) = &layer.fill {
            let grey = read_grey(&self.folder.join(&fill.provenance_file), layer.rect, layer.rect)?;
            // What paint of another photo is laid over is shown as that paint.
            let filled = from.iter_mut().zip(grey).filter(|(_, grey)| *grey > 0);
            filled.for_each(|(from, grey)| *from = (first + grey).min(entries.len() as u16 - 1));
        }
        self.painted(paint)?.into_iter().for_each(|at| from[at] = 2);
        let colour = |from: &u16| (*from > 0).then(|| entries[usize::from(*from)].1);
        let picture = self.picture(from.iter().map(colour));
        let mut counts = vec![0u64; entries.len()];
        from.iter().for_each(|from| counts[usize::from(*from)] += 1);
        let legend = entries.into_iter().zip(counts).skip(1).filter(|(_, count)| *count > 0);
        Ok((picture, legend.map(|((name, colour), count)| (name, colour, count)).collect()))
    }

    fn picture(&self, colours: impl Iterator<Item = Option<[u8; 3]>>) -> Picture {
        let pixel = |colour: Option<[u8; 3]>| colour.map_or([0; 4], |[r, g, b]| [r, g, b, u8::MAX]);
        let rect = self.rect();
        Picture { width: rect.w, height: rect.h, rgba: colours.flat_map(pixel).collect() }
    }
}

/// An origin of fillings in words, with its colour; `at` is its number. Other photos are told apart here.
fn origin(name: &str, at: usize) -> (String, [u8; 3]) {
    match origin_of(name) {
        Origin::Photo => (String::new(), [0; 3]),
        Origin::OtherPhoto => (name.to_owned(), OTHERS[at % OTHERS.len()]),
        Origin::Propagated => {
            let photo = origins::painter(name).unwrap_or(name);
            (format!("paint in {photo}"), Origin::Propagated.colour())
        }
        origin => (origin.name().to_owned(), origin.colour()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_told_apart() {
        assert_eq!(origin("[exemplar]", 2).0, "invented by example");
        assert_eq!(
            origin(&origins::painted_in("a.jpg"), 5),
            ("paint in a.jpg".into(), Origin::Propagated.colour())
        );
        assert_ne!(origin("a.jpg", 4).1, origin("b.jpg", 5).1);
    }
}
