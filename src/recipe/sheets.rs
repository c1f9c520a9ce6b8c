//! The files of the current stacks as texels of sheets.

use std::path::PathBuf;

use crate::document::Stack;
use crate::error::{Error, Result};
use crate::geometry::PixelRect;
use crate::io::layer_reader::{read_grey, read_layer, read_mask};
use crate::io::stack_store::StackStore;
use crate::projection::sources::{BESIDE, FILLED};
use crate::projection::{SheetId, SheetPixels, Texels};

/// Where the texels of each sheet are. Sheets are counted as in [`crate::projection::Sources::sheets`]:
/// photo by photo, image layers as in the stack.
#[derive(Debug, Default)]
pub struct SheetFiles {
    files: Vec<SheetFile>,
}

#[derive(Debug, Clone)]
struct SheetFile {
    texels: PathBuf,
    needed: PathBuf,
    /// Colours and confidence of the filling.
    filled: Option<[PathBuf; 2]>,
    /// Of the files.
    rect: PixelRect,
    needed_rect: PixelRect,
}

impl SheetFiles {
    /// The image layers of these stacks, in their order; photos without a stack have `None`. Files are
    /// read when they are asked for: where a build replaces a stack in the meantime they are gone, and the
    /// stacks have to be read again. `filled`: with what filled the hidden texels, where there is any.
    pub fn new(store: &StackStore, stacks: &[Option<Stack>], filled: bool) -> Self {
        let files = stacks.iter().flatten().flat_map(|stack| {
            let folder = store.folder(&stack.photo.name);
            stack.image_layers.iter().map(move |layer| SheetFile {
                texels: folder.join(&layer.file),
                needed: folder.join(&layer.needed_file),
                filled: layer
                    .fill
                    .as_ref()
                    .filter(|_| filled)
                    .map(|fill| [&fill.filled_file, &fill.confidence_file].map(|file| folder.join(file))),
                rect: layer.rect,
                needed_rect: layer.needed_rect,
            })
        });
        Self { files: files.collect() }
    }

    /// How many sheets there are.
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// There is no sheet.
    pub fn is_empty(&self) -> bool {
        self.files.is_empty()
    }
}

impl Texels for SheetFiles {
    fn sheet(&self, sheet: SheetId) -> Result<SheetPixels> {
        let file = self.files.get(sheet.0 as usize);
        let file = file.ok_or_else(|| Error::Request(format!("there is no image layer {}", sheet.0)))?;
        // What the photo shows beside the layer's outlines is of use, too.
        let rect = file.needed_rect.grown(1).intersection(&file.rect);
        if file.needed_rect.is_empty() || rect.is_empty() {
            return Ok(SheetPixels {
                rect,
                rgba: vec![0; 4 * rect.area() as usize],
                needed: vec![0; rect.area() as usize],
            });
        }
        let mut rgba = read_layer(&file.texels, file.rect, rect)?;
        let mut needed = read_mask(&file.needed, file.rect, rect)?;
        mark_beside(&rgba, &mut needed);
        if let Some([colours, confidence]) = &file.filled {
            let colours = read_layer(colours, file.rect, rect)?;
            let confidence = read_grey(confidence, file.rect, rect)?;
            fill_in(&mut rgba, &mut needed, &colours, &confidence);
        }
        Ok(SheetPixels { rect, rgba, needed })
    }
}

/// Says where a layer has the photo's colour beside what it shows: at transparent pixels that are not black.
fn mark_beside(rgba: &[u8], needed: &mut [u8]) {
    for (texel, needed) in rgba.as_chunks::<4>().0.iter().zip(needed) {
        let [r, g, b, a] = *texel;
        *needed |= if a == 0 && r | g | b != 0 { BESIDE } else { 0 };
    }
}

/// Gives empty texels the colour that fills them, their alpha how far that is trusted.
fn fill_in(rgba: &mut [u8], needed: &mut [u8], colours: &[u8], confidence: &[u16]) {
    let filling = colours.as_chunks::<4>().0.iter().zip(confidence);
    let texels = rgba.as_chunks_mut::<4>().0.iter_mut().zip(needed);
    for ((texel, needed), (colour, confidence)) in texels.zip(filling) {
        if texel[3] == 0 && *confidence > 0 {
            let [r, g, b, _] = *colour;
            *texel = [r, g, b, (*confidence).min(255) as u8];
            *needed |= FILLED;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::sources::COVERED;

    #[test]
    fn transparent_pixels_with_a_colour_lie_beside_what_the_layer_shows() {
        let rgba = [[7, 7, 7, 255], [0, 0, 1, 0], [0, 0, 0, 0], [0, 0, 0, 255], [9, 0, 0, 0]].concat();
        let mut needed = [COVERED, COVERED, COVERED, COVERED, 0];
        mark_beside(&rgba, &mut needed);
        assert_eq!(needed, [COVERED, COVERED | BESIDE, COVERED, COVERED, BESIDE]);
    }

    #[test]
    fn a_filling_never_takes_the_place_of_what_the_photo_shows() {
        let mut rgba = vec![1, 2, 3, 255, 0, 0, 0, 0, 0, 0, 0, 0];
        let mut needed = vec![1, 1, 1];
        fill_in(&mut rgba, &mut needed, &[[7, 8, 9, 255]; 3].concat(), &[30, 30, 0]);
        assert_eq!(rgba, [1, 2, 3, 255, 7, 8, 9, 30, 0, 0, 0, 0]);
        assert_eq!(needed, [1, 1 | FILLED, 1]);
    }
}
