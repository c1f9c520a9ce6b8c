//! The content of an image layer pixel by pixel: photo, filling, paint, or nothing yet.

use std::path::Path;

use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::in_8_bits;
use quadratura_document::Stack;
use quadratura_document::paint::PaintPatch;
use quadratura_io::layer_reader::{read_grey, read_layer, read_mask};
use quadratura_layers::LayerIndex;
use quadratura_stacks::layer_pixels::shown;
use quadratura_stacks::layer_textures::over_filling;
use quadratura_stacks::paint::PhotoPaint;

/// Flag: a surface of the layer covers the pixel.
const COVERED: u8 = 1;
/// Flag: the surface is visible in the photo at the pixel.
const VISIBLE: u8 = 2;

/// The content of an image layer at a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TexelContent {
    /// No surface of the layer is there, or it was erased.
    Nothing,
    /// A surface is there, but hidden, and there is no content.
    Hidden,
    /// The photo's own pixel.
    Photo,
    /// A see-through surface that the photo shows mixed with what is behind it: sRGB and its matte as alpha, not
    /// premultiplied, in linear light.
    Mixed([u8; 4]),
    /// Filling: sRGB and alpha, not premultiplied.
    Filling([u8; 4]),
    /// Paint of another photo that was propagated over a visible pixel: sRGB and alpha, not premultiplied.
    Spread([u8; 4]),
    /// Paint, or paint over filling.
    Paint([u8; 4]),
}

/// The content of an image layer within the photo.
#[derive(Debug)]
pub struct PeelContent {
    rect: PixelRect,
    /// The flags in rows of `rect`.
    flags: Vec<u8>,
    /// The filling, opaque where the layer is filled; empty where it has no filling at all.
    filling: Vec<[u8; 4]>,
    /// Propagated paint of other photos with its opacity; empty where there is none at all.
    propagated: Vec<[u8; 4]>,
    /// The colours of see-through surfaces where the photo shows them mixed with what is behind, opaque; empty where there
    /// is none at all.
    foreground: Vec<[u8; 4]>,
    /// The matte of see-through surfaces, in 255ths; empty for solid ones.
    matte: Vec<u8>,
    paint: PaintPatch,
}

impl PeelContent {
    /// Reads an image layer of a stack with files in `folder`.
    ///
    /// # Errors
    /// Returns the errors of reading its files and paint.
    pub fn read(folder: &Path, stack: &Stack, paint: &PhotoPaint, layer: LayerIndex) -> Result<Self> {
        let image_layer = stack.layer(layer);
        let photo = PixelRect::of_size(stack.photo.width, stack.photo.height);
        let rect = image_layer.needed_rect.intersection(&image_layer.rect).intersection(&photo);
        if rect.is_empty() {
            let filling = Vec::new();
            let propagated = Vec::new();
            return Ok(Self {
                rect,
                flags: Vec::new(),
                filling,
                propagated,
                foreground: Vec::new(),
                matte: Vec::new(),
                paint: PaintPatch::of_pixels(&[]),
            });
        }
        let texels = read_layer(&folder.join(&image_layer.file), image_layer.rect, rect)?;
        let needed = read_mask(&folder.join(&image_layer.needed_file), image_layer.rect, rect)?;
        let flag = |(texel, needed): (&[u8; 4], &u8)| {
            let visible = if texel[3] > 0 { VISIBLE } else { 0 };
            if *needed > 0 { COVERED | visible } else { 0 }
        };
        let flags = texels.as_chunks::<4>().0.iter().zip(&needed).map(flag).collect();
        let read = |file: Option<&String>| match file {
            Some(file) => Ok(read_layer(&folder.join(file), image_layer.rect, rect)?.as_chunks().0.to_vec()),
            None => Ok(Vec::new()),
        };
        let fill = image_layer.fill.as_ref();
        let filling = read(fill.map(|fill| &fill.filled_file))?;
        let propagated = read(fill.and_then(|fill| fill.propagation_file.as_ref()))?;
        let foreground = read(fill.and_then(|fill| fill.foreground_file.as_ref()))?;
        let matte = match fill.and_then(|fill| fill.matte_file.as_ref()) {
            Some(file) => read_grey(&folder.join(file), image_layer.rect, rect)?,
            None => Vec::new(),
        };
        let matte = matte.into_iter().map(|value| value.min(255) as u8).collect();
        Ok(Self { rect, flags, filling, propagated, foreground, matte, paint: paint.on(stack, layer)? })
    }

    /// Returns the content at a pixel of the photo, with or without filling and paint.
    pub fn texel(&self, x: i32, y: i32, filling: bool, paint: bool) -> TexelContent {
        let Some(at) = self.rect.index(x, y) else { return TexelContent::Nothing };
        let below = self.without_paint(at, filling);
        if !paint || self.flags[at] & COVERED == 0 {
            return below;
        }
        match (self.paint.at(x, y).map(|colour| shown(colour).map(in_8_bits)), below) {
            (None, below) => below,
            (Some([.., 0]), _) => TexelContent::Nothing,
            (Some(paint), TexelContent::Filling(filling)) if self.matte.is_empty() => {
                TexelContent::Paint(over_filling(paint, &filling))
            }
            (Some(paint), _) => TexelContent::Paint(paint),
        }
    }

    /// Returns true when one sees through the layer's surfaces: its colours are laid over others in linear light.
    pub fn sees_through(&self) -> bool {
        !self.matte.is_empty()
    }

    /// Returns true when the layer has paint.
    pub fn is_painted(&self) -> bool {
        !self.paint.is_empty()
    }

    /// Returns true when paint of other photos was propagated to the layer.
    pub fn is_propagated_on(&self) -> bool {
        self.propagated.iter().any(|colour| colour[3] > 0)
    }

    /// Returns true when a surface is at the pixel, but not visible in the photo.
    pub fn is_hidden(&self, x: i32, y: i32) -> bool {
        self.rect.index(x, y).is_some_and(|at| self.flags[at] == COVERED)
    }

    /// Returns true when the layer is visible in the photo at the pixel.
    pub fn is_visible(&self, x: i32, y: i32) -> bool {
        self.rect.index(x, y).is_some_and(|at| self.flags[at] & VISIBLE != 0)
    }

    /// Returns the content at an index without the photo's own paint.
    fn without_paint(&self, at: usize, filling: bool) -> TexelContent {
        let propagated = self.propagated.get(at).filter(|colour| filling && colour[3] > 0);
        let matte = self.matte.get(at).copied().filter(|_| filling).unwrap_or(u8::MAX);
        match (self.flags[at], self.filling.get(at)) {
            (0, _) => TexelContent::Nothing,
            _ if propagated.is_some() => {
                propagated.map_or(TexelContent::Nothing, |colour| TexelContent::Spread(*colour))
            }
            _ if matte == 0 => TexelContent::Nothing,
            (flags, _) if flags & VISIBLE != 0 => match self.foreground.get(at) {
                Some(&[r, g, b, a]) if filling && a > 0 => TexelContent::Mixed([r, g, b, matte]),
                _ => TexelContent::Photo,
            },
            (_, Some(&[r, g, b, a])) if filling && a > 0 => TexelContent::Filling([r, g, b, a.min(matte)]),
            _ => TexelContent::Hidden,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paint_of_other_photos_lies_over_the_photo_and_below_its_own_paint() {
        let red = [65535, 0, 0, 65535];
        let content = PeelContent {
            rect: PixelRect { x: 5, y: 0, w: 4, h: 1 },
            flags: vec![COVERED | VISIBLE, COVERED | VISIBLE, COVERED | VISIBLE, COVERED],
            filling: vec![[0; 4], [0; 4], [0; 4], [9, 9, 9, 255]],
            propagated: vec![[0; 4], [1, 2, 3, 255], [1, 2, 3, 255], [0; 4]],
            foreground: Vec::new(),
            matte: Vec::new(),
            paint: PaintPatch::of_pixels(&[(7, 0, red)]),
        };
        let row = |filling| [5, 6, 7, 8].map(|x| content.texel(x, 0, filling, true));
        let painted = TexelContent::Paint([255, 0, 0, 255]);
        let (propagation, filled) =
            (TexelContent::Spread([1, 2, 3, 255]), TexelContent::Filling([9, 9, 9, 255]));
        assert_eq!(row(true), [TexelContent::Photo, propagation, painted, filled]);
        assert_eq!(row(false), [TexelContent::Photo, TexelContent::Photo, painted, TexelContent::Hidden]);
        assert!(content.is_propagated_on());
    }
}
