//! Small pictures of image layers, for the exploded view in 3D.

use std::path::Path;

use super::shown_texels;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::task::Task;
use quadratura_document::Stack;
use quadratura_layers::LayerIndex;
use quadratura_projection::reduced::halves;
use quadratura_view::Picture;

/// The sRGB colour of needed and hidden pixels.
const HIDDEN: [u8; 3] = [0xf2, 0x8c, 0x38];
/// The opacity of stripes, of 255.
const STRIPE: u8 = 0xe0;
/// The opacity between stripes, of 255.
const BETWEEN: u8 = 0x2c;

/// The period of the stripes in pixels of the small picture; a third of it is stripe.
const PITCH: i32 = 9;

/// A picture of an image layer, small enough to keep all of a photo's layers in memory.
#[derive(Debug, Clone)]
pub struct LayerThumbnail {
    /// The index in [`Stack::image_layers`].
    pub layer: LayerIndex,
    /// The order in the stack, 0 nearest.
    pub order: u32,
    /// The part that the picture shows, in photo pixels.
    pub rect: PixelRect,
    /// The visible pixels of the layer, and stripes where it is hidden.
    pub picture: Picture,
}

impl LayerThumbnail {
    /// Returns true when the layer has or needs something at a photo pixel.
    pub fn has(&self, x_px: f64, y_px: f64) -> bool {
        let Picture { width, height, rgba } = &self.picture;
        let cell = |px: f64, from: i32, all: u32, of: u32| {
            let cell = (px - f64::from(from)) / f64::from(all) * f64::from(of);
            (cell >= 0.0 && cell < f64::from(of)).then_some(cell as usize)
        };
        let column = cell(x_px, self.rect.x, self.rect.w, *width);
        let row = cell(y_px, self.rect.y, self.rect.h, *height);
        let at = |(column, row): (usize, usize)| rgba[4 * (row * *width as usize + column) + 3] > 0;
        column.zip(row).is_some_and(at)
    }
}

/// Reads the image layers of a stack that need any pixels, in the stack's order, from the stack's `folder`. All are
/// reduced by the same factor, so that a layer as large as the photo has no side longer than `longest_px`.
///
/// # Errors
/// Returns [`quadratura_base::Error::Io`] and [`quadratura_base::Error::Input`] for their files, or [`quadratura_base::Error::Cancelled`].
pub fn layer_thumbnails(
    folder: &Path,
    stack: &Stack,
    longest_px: u32,
    task: &Task,
) -> Result<Vec<LayerThumbnail>> {
    let longest = stack.photo.width.max(stack.photo.height).max(1);
    // The number of halvings after which the photo fits.
    let halvings = longest.div_ceil(longest_px.max(1)).next_power_of_two().trailing_zeros();
    let layers = &stack.image_layers;
    let mut layer_textures = Vec::with_capacity(layers.len());
    for (index, layer) in stack.numbered_layers() {
        task.step("read layers", index.0.into(), layers.len() as u64)?;
        let rect = layer.needed_rect.intersection(&layer.rect);
        if rect.is_empty() {
            continue;
        }
        let (mut rgba, hidden) = shown_texels(folder, layer, rect)?;
        hatch(&mut rgba, &hidden, rect, halvings);
        let picture = reduced(Picture { width: rect.w, height: rect.h, rgba }, halvings);
        layer_textures.push(LayerThumbnail { layer: index, order: layer.order, rect, picture });
    }
    Ok(layer_textures)
}

/// Draws stripes where texels are needed and hidden. The stripes are aligned to the photo, so that those of adjacent layers connect.
fn hatch(rgba: &mut [u8], hidden: &[bool], rect: PixelRect, halvings: u32) {
    let pitch = PITCH << halvings;
    let texels = rgba.as_chunks_mut::<4>().0.iter_mut().zip(hidden);
    for ((x, y), (texel, hidden)) in rect.pixels().zip(texels) {
        if *hidden {
            let in_stripe = (x + y).rem_euclid(pitch) * 3 < pitch;
            let [r, g, b] = HIDDEN;
            *texel = [r, g, b, if in_stripe { STRIPE } else { BETWEEN }];
        }
    }
}

/// Halves a picture repeatedly.
fn reduced(picture: Picture, halvings: u32) -> Picture {
    let longest = picture.width.max(picture.height);
    let Some(least) = longest.checked_shr(halvings).filter(|_| halvings > 0) else { return picture };
    halves(&picture, least.max(1)).pop().unwrap_or(picture)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_hidden_is_striped_and_what_is_shown_stays() {
        let rect = PixelRect { x: -2, y: 1, w: 12, h: 2 };
        let mut rgba = [9, 9, 9, 255].repeat(24);
        rgba[4 * 12..].iter_mut().for_each(|byte| *byte = 0);
        let hidden: Vec<bool> = (0..24).map(|at| at >= 12).collect();
        hatch(&mut rgba, &hidden, rect, 0);
        assert_eq!(rgba[..8], [9, 9, 9, 255, 9, 9, 9, 255]);
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
        let layer_texture = LayerThumbnail { layer: LayerIndex(0), order: 0, rect, picture };
        assert!(
            layer_texture.has(10.5, 21.9) && !layer_texture.has(12.5, 21.0) && !layer_texture.has(9.9, 21.0)
        );
    }
}
