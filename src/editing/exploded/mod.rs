//! The exploded view of a photo's stack: its layers as panes in the photo's view frustum, one behind the other,
//! with needed and hidden pixels hatched.

mod drawing;
pub mod layer_textures;
pub mod premultiplied;

use std::path::Path;

use self::premultiplied::{Ink, PremultipliedPicture, scaled};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::over::premultiplied;
use quadratura_base::task::Task;
use quadratura_document::{ImageLayer, Stack};
use quadratura_io::layer_reader::{read_grey, read_layer, read_mask};
use quadratura_view::Picture;
use quadratura_view::srgb::Srgb;

pub use drawing::draw;

/// The colour that hatches needed and hidden pixels.
const NEEDED: Ink = Ink(0xf2_8c_38, 0.85);

/// An image layer with its pixels.
#[derive(Debug, Clone)]
pub struct LayerPicture {
    /// The readable name.
    pub name: String,
    /// The order in the stack, 0 nearest.
    pub order: u32,
    /// The rectangle of the pixels, in photo pixels.
    pub rect: PixelRect,
    /// The colours, as large as `rect`.
    pub pixels: PremultipliedPicture,
    /// For each pixel, whether a surface needs it and the photo does not show it.
    pub hidden: Vec<bool>,
}

/// Reads the layers of a stack that are not empty, nearest first, from the stack's `folder`.
///
/// # Errors
/// Returns [`quadratura_base::Error::Io`] and [`quadratura_base::Error::Input`] for their files, or [`quadratura_base::Error::Cancelled`].
pub fn read_layers(folder: &Path, stack: &Stack, task: &Task) -> Result<Vec<LayerPicture>> {
    let seen = stack.image_layers.iter().filter(|layer| !layer.needed_rect.is_empty());
    let read = |layer| task.check_cancelled().and_then(|()| LayerPicture::read(folder, layer));
    seen.map(read).collect()
}

/// Draws the exploded view of a stack as an opaque picture of `size_px` (width, height).
///
/// # Errors
/// Returns the errors of [`read_layers`].
pub fn exploded(folder: &Path, stack: &Stack, size_px: (u32, u32), task: &Task) -> Result<Picture> {
    let layers = read_layers(folder, stack, task)?;
    let photo_px = (stack.photo.width as usize, stack.photo.height as usize);
    let canvas = draw(&layers, photo_px, (size_px.0 as usize, size_px.1 as usize));
    let rgb = canvas.rgb();
    let rgba = rgb.as_chunks::<3>().0.iter().flat_map(|&[r, g, b]| [r, g, b, u8::MAX]).collect();
    Ok(Picture { width: size_px.0, height: size_px.1, rgba })
}

/// Reads what the photo shows of a layer within `rect` (photo pixels): RGBA, see-through where its surfaces are, and
/// whether something is needed and hidden.
fn shown_texels(folder: &Path, layer: &ImageLayer, rect: PixelRect) -> Result<(Vec<u8>, Vec<bool>)> {
    let mut texels = read_layer(&folder.join(&layer.file), layer.rect, rect)?;
    let needed = read_mask(&folder.join(&layer.needed_file), layer.rect, rect)?;
    let all = texels.as_chunks::<4>().0.iter().zip(&needed);
    let hidden = all.map(|(texel, needed)| *needed > 0 && texel[3] < 128).collect();
    let beside = texels.as_chunks_mut::<4>().0.iter_mut().zip(&needed).filter(|(_, needed)| **needed == 0);
    beside.for_each(|(texel, _)| *texel = [0; 4]);
    let fill = layer.fill.as_ref();
    if let Some(file) = fill.and_then(|fill| fill.foreground_file.as_ref()) {
        let foreground = read_layer(&folder.join(file), layer.rect, rect)?;
        let colours = texels.as_chunks_mut::<4>().0.iter_mut().zip(foreground.as_chunks::<4>().0);
        colours.filter(|(_, colour)| colour[3] > 0).for_each(|(texel, colour)| *texel = *colour);
    }
    if let Some(file) = fill.and_then(|fill| fill.matte_file.as_ref()) {
        let matte = read_grey(&folder.join(file), layer.rect, rect)?;
        let visible = texels.as_chunks_mut::<4>().0.iter_mut().zip(matte).filter(|(texel, _)| texel[3] > 0);
        visible.for_each(|(texel, matte)| texel[3] = matte.min(255) as u8);
    }
    Ok((texels, hidden))
}

impl LayerPicture {
    /// Reads a layer, cropped to its needed part.
    fn read(folder: &Path, layer: &ImageLayer) -> Result<Self> {
        let rect = layer.needed_rect.intersection(&layer.rect);
        let (texels, hidden) = shown_texels(folder, layer, rect)?;
        let mut pixels = PremultipliedPicture::new(rect.w as usize, rect.h as usize);
        let light = Srgb::tables();
        for (i, texel) in texels.as_chunks::<4>().0.iter().enumerate() {
            let [r, g, b, a] = *texel;
            let color = [light.linear(r), light.linear(g), light.linear(b), 1.0];
            pixels.pixels[i] = scaled(color, f32::from(a) / 255.0);
        }
        Ok(Self { name: layer.name.clone(), order: layer.order, rect, pixels, hidden })
    }

    /// Returns the pixels with stripes, `pitch` pixels apart, where they are needed and hidden. The stripes are
    /// aligned to the photo, so that those of adjacent layers connect.
    pub fn hatched(&self, pitch: usize) -> PremultipliedPicture {
        let mut out = self.pixels.clone();
        let faint = Ink(NEEDED.0, 0.16).linear();
        let pixels = self.rect.pixels().zip(&mut out.pixels).zip(&self.hidden);
        for (((x, y), pixel), _) in pixels.filter(|(_, hidden)| **hidden) {
            let in_stripe = (x + y).rem_euclid(pitch as i32) * 3 < pitch as i32;
            *pixel = premultiplied(if in_stripe { NEEDED.linear() } else { faint }, *pixel);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes a layer of one colour in the photo's left or right half.
    fn half(order: u32, x: i32, color: Ink, hidden: bool) -> LayerPicture {
        let rect = PixelRect { x, y: 0, w: 60, h: 80 };
        let mut pixels = PremultipliedPicture::new(60, 80);
        if !hidden {
            pixels.pixels.fill(color.linear());
        }
        LayerPicture { name: "half".into(), order, rect, hidden: vec![hidden; pixels.pixels.len()], pixels }
    }

    #[test]
    fn layers_of_two_orders_are_both_to_be_seen_with_their_hatching() {
        let red = half(0, 0, Ink(0xff_00_00, 1.0), false);
        let hatched = half(1, 60, Ink(0, 1.0), true);
        let canvas = draw(&[red, hatched], (120, 80), (90, 46));
        assert_eq!((canvas.width, canvas.height), (90, 46));
        let count =
            |like: fn(&[u8; 3]) -> bool| canvas.rgb().as_chunks::<3>().0.iter().filter(|p| like(p)).count();
        let reddish = count(|&[r, g, b]| r > 200 && g < 40 && b < 40);
        let orange = count(|&[r, g, b]| r > 100 && g > 60 && b < 80 && r > g);
        assert!(reddish > 100 && orange > 20, "{reddish} {orange}");
    }

    #[test]
    fn a_stack_without_layers_is_an_empty_stage() {
        let canvas = draw(&[], (120, 80), (30, 20));
        assert!(canvas.pixels.iter().all(|pixel| pixel[3] == 1.0));
    }
}
