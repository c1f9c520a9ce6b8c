//! Image layers as small pictures, to be looked at in space.

use std::path::Path;

use crate::document::Stack;
use crate::error::Result;
use crate::geometry::PixelRect;
use crate::io::layer_reader::{read_layer, read_mask};
use crate::projection::Picture;
use crate::projection::reduced::halves;
use crate::task::Task;

/// What is needed and hidden, sRGB, as stripes with this opacity and between them.
const HIDDEN: [u8; 3] = [0xf2, 0x8c, 0x38];
const STRIPE: u8 = 0xe0;
const BETWEEN: u8 = 0x2c;

/// From stripe to stripe in pixels of the small picture, of which a third is stripe.
const PITCH: i32 = 9;

/// An image layer as a picture that is small enough to have all of a photo's at hand.
#[derive(Debug, Clone)]
pub struct SheetPicture {
    /// Its place in [`Stack::image_layers`].
    pub layer: usize,
    /// Its place from the front.
    pub order: u32,
    /// What the picture shows, in photo pixels.
    pub rect: PixelRect,
    /// What the photo shows of the layer; stripes where something else hides it.
    pub picture: Picture,
}

impl SheetPicture {
    /// Whether the layer holds or needs anything at a photo pixel.
    pub fn has(&self, x_px: f64, y_px: f64) -> bool {
        let Picture { width, height, rgba } = &self.picture;
        let place = |px: f64, from: i32, all: u32, of: u32| {
            let place = (px - f64::from(from)) / f64::from(all) * f64::from(of);
            (place >= 0.0 && place < f64::from(of)).then_some(place as usize)
        };
        let column = place(x_px, self.rect.x, self.rect.w, *width);
        let row = place(y_px, self.rect.y, self.rect.h, *height);
        let at = |(column, row): (usize, usize)| rgba[4 * (row * *width as usize + column) + 3] > 0;
        column.zip(row).is_some_and(at)
    }
}

/// The image layers of a stack that need anything, as in the stack; `folder` is the stack's. No side of the pictures of layers
/// as large as the photo is longer than `longest_px`; all are reduced alike.
///
/// # Errors
/// [`crate::Error::Io`] and [`crate::Error::Input`] for their files; [`crate::Error::Cancelled`].
pub fn sheet_pictures(
    folder: &Path,
    stack: &Stack,
    longest_px: u32,
    task: &Task,
) -> Result<Vec<SheetPicture>> {
    let longest = stack.photo.width.max(stack.photo.height).max(1);
    // Halved so often, the photo fits.
    let halvings = longest.div_ceil(longest_px.max(1)).next_power_of_two().trailing_zeros();
    let layers = &stack.image_layers;
    let mut sheets = Vec::with_capacity(layers.len());
    for (place, layer) in layers.iter().enumerate() {
        task.step("read layers", place as u64, layers.len() as u64)?;
        let rect = layer.needed_rect.intersection(&layer.rect);
        if rect.is_empty() {
            continue;
        }
        let mut rgba = read_layer(&folder.join(&layer.file), layer.rect, rect)?;
        let needed = read_mask(&folder.join(&layer.needed_file), layer.rect, rect)?;
        hatch(&mut rgba, &needed, rect, halvings);
        let picture = reduced(Picture { width: rect.w, height: rect.h, rgba }, halvings);
        sheets.push(SheetPicture { layer: place, order: layer.order, rect, picture });
    }
    Ok(sheets)
}

/// Lays stripes where texels are needed and empty; what is not needed becomes empty. Stripes lie in the photo's frame,
/// so that those of neighbouring layers meet.
fn hatch(rgba: &mut [u8], needed: &[u8], rect: PixelRect, halvings: u32) {
    let pitch = PITCH << halvings;
    let texels = rgba.as_chunks_mut::<4>().0.iter_mut().zip(needed);
    for ((x, y), (texel, needed)) in rect.pixels().zip(texels) {
        if *needed == 0 {
            *texel = [0; 4];
        } else if texel[3] < 128 {
            let in_stripe = (x + y).rem_euclid(pitch) * 3 < pitch;
            let [r, g, b] = HIDDEN;
            *texel = [r, g, b, if in_stripe { STRIPE } else { BETWEEN }];
        }
    }
}

fn reduced(picture: Picture, halvings: u32) -> Picture {
    let longest = picture.width.max(picture.height);
    let Some(least) = longest.checked_shr(halvings).filter(|_| halvings > 0) else { return picture };
    halves(&picture, least.max(1)).pop().unwrap_or(picture)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_hidden_is_striped_and_what_is_not_needed_empty() {
        let rect = PixelRect { x: -2, y: 1, w: 12, h: 2 };
        let mut rgba = [9, 9, 9, 255].repeat(24);
        rgba[4 * 12..].iter_mut().for_each(|byte| *byte = 0);
        let mut needed = vec![1; 24];
        needed[0] = 0;
        hatch(&mut rgba, &needed, rect, 0);
        assert_eq!(rgba[..8], [0, 0, 0, 0, 9, 9, 9, 255]);
        let alphas: Vec<u8> = rgba[4 * 12..].chunks(4).map(|texel| texel[3]).collect();
        assert_eq!(alphas[..9], [[STRIPE; 3], [BETWEEN; 3], [BETWEEN; 3]].concat());
    }

    #[test]
    fn all_sheets_are_reduced_alike_and_tell_where_they_hold_anything() {
        let mut rgba = [0; 4].repeat(8 * 4);
        rgba[4 * 9..4 * 9 + 4].copy_from_slice(&[1, 2, 3, 255]);
        let picture = reduced(Picture { width: 8, height: 4, rgba }, 1);
        assert_eq!((picture.width, picture.height), (4, 2));
        let rect = PixelRect { x: 10, y: 20, w: 8, h: 4 };
        let sheet = SheetPicture { layer: 0, order: 0, rect, picture };
        assert!(sheet.has(10.5, 21.9) && !sheet.has(12.5, 21.0) && !sheet.has(9.9, 21.0));
    }
}
