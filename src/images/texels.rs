//! The texels of an image layer within the photo: colour, opacity, and where they are from.

use std::path::Path;

use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::in_8_bits;
use quadratura_document::Stack;
use quadratura_document::stack::origins::origin_of;
use quadratura_io::layer_reader::{read_grey, read_layer, read_mask};
use quadratura_layers::LayerIndex;
use quadratura_ldi::DepthPixelOrigin;
use quadratura_stacks::layer_pixels::{layer_pixels, shown, unfilled_pixels};
use quadratura_stacks::paint::PhotoPaint;
use quadratura_view::legend::Origin;

/// Flag: a surface of the layer covers the pixel.
const COVERED: u8 = 1;
/// Flag: the photo shows the layer at the pixel.
const VISIBLE: u8 = 2;
/// The first bit of the origin.
const ORIGIN: u8 = 6;

/// The texels of an image layer within the photo.
#[derive(Debug)]
pub struct LayerTexels {
    /// The part of the photo, in its pixels.
    pub rect: PixelRect,
    /// Whether the layer has a matte, so that empty texels are holes in its surfaces.
    pub sees_through: bool,
    colours: Vec<[u8; 4]>,
    flags: Vec<u8>,
}

/// One texel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LayerTexel {
    /// sRGB and opacity, not premultiplied.
    pub colour: [u8; 4],
    /// Whether the photo shows it.
    pub visible: bool,
    /// Where its colour is from.
    pub origin: DepthPixelOrigin,
}

impl LayerTexels {
    /// Reads an image layer of a stack with files in `folder`.
    ///
    /// # Errors
    /// Returns the errors of reading its files and paint.
    pub fn read(
        folder: &Path,
        stack: &Stack,
        paint: &PhotoPaint,
        layer: LayerIndex,
        filled: bool,
    ) -> Result<Self> {
        let image_layer = stack.layer(layer);
        let photo = PixelRect::of_size(stack.photo.width, stack.photo.height);
        let rect = image_layer.needed_rect.intersection(&image_layer.rect).intersection(&photo);
        let fill = image_layer.fill.as_ref().filter(|_| filled);
        let sees_through = fill.is_some_and(|fill| fill.matte_file.is_some());
        if rect.is_empty() {
            return Ok(Self { rect: PixelRect::EMPTY, sees_through, colours: Vec::new(), flags: Vec::new() });
        }
        let pixels = if filled { layer_pixels } else { unfilled_pixels };
        let raster = pixels(stack, folder, paint, layer)?;
        let of_raster = |(x, y): (i32, i32)| {
            raster.rgba16((x - image_layer.rect.x) as u32, (y - image_layer.rect.y) as u32).map(in_8_bits)
        };
        let colours = rect.pixels().map(of_raster).collect();
        let shown = read_layer(&folder.join(&image_layer.file), image_layer.rect, rect)?;
        let needed = read_mask(&folder.join(&image_layer.needed_file), image_layer.rect, rect)?;
        let flag = |(texel, needed): (&[u8; 4], &u8)| {
            (if *needed > 0 { COVERED } else { 0 }) | (if texel[3] > 0 { VISIBLE } else { 0 })
        };
        let flags = shown.as_chunks::<4>().0.iter().zip(&needed).map(flag).collect();
        let mut texels = Self { rect, sees_through, colours, flags };
        if filled {
            texels.read_origins(folder, stack, layer)?;
        }
        texels.mark_paint(stack, paint, layer)?;
        Ok(texels)
    }

    /// Returns whether a surface of the layer covers a pixel.
    pub fn covers(&self, x: i32, y: i32) -> bool {
        self.rect.index(x, y).is_some_and(|at| self.flags[at] & COVERED != 0)
    }

    /// Returns the texel at a pixel of `rect`.
    pub fn at(&self, x: i32, y: i32) -> LayerTexel {
        let at = self.rect.offset(x, y);
        let flags = self.flags[at];
        let origin = DepthPixelOrigin::ALL[usize::from(flags >> ORIGIN)];
        LayerTexel { colour: self.colours[at], visible: flags & VISIBLE != 0, origin }
    }

    /// Sets the origins of filled texels.
    fn read_origins(&mut self, folder: &Path, stack: &Stack, layer: LayerIndex) -> Result<()> {
        let image_layer = stack.layer(layer);
        let (Some(fill), Some(of_stack)) = (&image_layer.fill, &stack.fill) else { return Ok(()) };
        let numbers = read_grey(&folder.join(&fill.provenance_file), image_layer.rect, self.rect)?;
        let names: Vec<DepthPixelOrigin> = of_stack.origins.iter().map(|name| origin_named(name)).collect();
        for (flags, number) in self.flags.iter_mut().zip(numbers).filter(|(_, number)| *number > 0) {
            let origin = names.get(usize::from(number)).copied();
            *flags |= (origin.unwrap_or(DepthPixelOrigin::OtherPhotos) as u8) << ORIGIN;
        }
        Ok(())
    }

    /// Sets the origin of painted texels.
    fn mark_paint(&mut self, stack: &Stack, paint: &PhotoPaint, layer: LayerIndex) -> Result<()> {
        for (x, y, _) in paint.on(stack, layer)?.iter().filter(|(_, _, colour)| shown(*colour)[3] > 0) {
            if let Some(at) = self.rect.index(x, y) {
                let below = self.flags[at] & (COVERED | VISIBLE);
                self.flags[at] = below | (DepthPixelOrigin::Paint as u8) << ORIGIN;
            }
        }
        Ok(())
    }
}

/// Returns where texels are from that have a source of this name. What was painted in another photo counts as
/// paint.
fn origin_named(name: &str) -> DepthPixelOrigin {
    match origin_of(name) {
        Origin::Photo => DepthPixelOrigin::Photo,
        Origin::Paint | Origin::Propagated => DepthPixelOrigin::Paint,
        Origin::OtherPhoto => DepthPixelOrigin::OtherPhotos,
        Origin::Example | Origin::Diffused => DepthPixelOrigin::Invented,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_document::stack::origins;

    #[test]
    fn what_was_painted_in_another_photo_counts_as_paint_and_inpainting_as_invented() {
        let names = [origins::NONE, origins::PAINTED, "[painted in a.jpg]", "b.jpg", origins::EXEMPLAR];
        use DepthPixelOrigin::{Invented, OtherPhotos, Paint, Photo};
        assert_eq!(names.map(origin_named), [Photo, Paint, Paint, OtherPhotos, Invented]);
    }
}
