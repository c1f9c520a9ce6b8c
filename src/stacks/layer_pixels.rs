//! The complete pixels of an image layer, for editors and for the renderer: the photo's visible pixels, the
//! filling, and paint from other photos and from this one.

use std::path::Path;

use crate::paint::PhotoPaint;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::over::on_opaque;
use quadratura_document::Stack;
use quadratura_document::paint::{ERASED, PaintColour, PaintPatch};
use quadratura_io::layer_reader::read_grey;
use quadratura_layered_files::Raster;
use quadratura_layered_files::png::read_rgba;
use quadratura_layers::LayerIndex;

/// Reads an image layer of a stack with files below `folder`, as large as its rectangle: paint over filling over
/// photo, where the filling includes paint that was propagated from other photos over visible pixels. Each painted
/// pixel is as it was painted, except that semitransparent paint on empty pixels is blended with the filling. The alpha of
/// see-through layers is their matte: what is painted half transparent is half see-through.
///
/// # Errors
/// Returns the errors of reading the layer's files and paint.
pub fn layer_pixels(stack: &Stack, folder: &Path, paint: &PhotoPaint, layer: LayerIndex) -> Result<Raster> {
    let image_layer = stack.layer(layer);
    let rect = image_layer.rect;
    let mut raster = read_rgba(&folder.join(&image_layer.file), rect.w, rect.h)?;
    let mut patch = paint.on(stack, layer)?;
    if let Some(fill) = &image_layer.fill {
        for file in [&fill.foreground_file, &fill.propagation_file].into_iter().flatten() {
            let visible = raster;
            raster = read_rgba(&folder.join(file), rect.w, rect.h)?;
            raster.lay_over(&visible);
        }
        let filling = read_rgba(&folder.join(&fill.filled_file), rect.w, rect.h)?;
        match &fill.matte_file {
            Some(file) => {
                raster.lay_over(&filling);
                take_matte(&mut raster, &read_grey(&folder.join(file), rect, rect)?);
            }
            None => {
                patch = over_filling(patch, rect, &raster, &filling);
                raster.lay_over(&filling);
            }
        }
    }
    paint_over(&mut raster, rect, &patch);
    Ok(raster)
}

/// Reads the same without the filling; see [`layer_pixels`].
///
/// # Errors
/// Returns the errors of reading the layer's files and paint.
pub fn unfilled_pixels(
    stack: &Stack,
    folder: &Path,
    paint: &PhotoPaint,
    layer: LayerIndex,
) -> Result<Raster> {
    let rect = stack.layer(layer).rect;
    let mut raster = read_rgba(&folder.join(&stack.layer(layer).file), rect.w, rect.h)?;
    paint_over(&mut raster, rect, &paint.on(stack, layer)?);
    Ok(raster)
}

/// Multiplies the alpha of a raster with a matte in 255ths, row by row.
fn take_matte(raster: &mut Raster, matte: &[u16]) {
    let width = raster.width();
    for (at, matte) in (0..).zip(matte).filter(|(_, matte)| **matte < 255) {
        let (x, y) = (at % width, at / width);
        let [r, g, b, a] = raster.rgba16(x, y);
        let alpha = (u32::from(a) * u32::from(*matte) + 127) / 255;
        raster.set_rgba16(x, y, [r, g, b, alpha as u16]);
    }
}

/// Draws paint on a raster whose top-left corner is that of `rect`, in photo pixels.
fn paint_over(raster: &mut Raster, rect: PixelRect, paint: &PaintPatch) {
    for (x, y, colour) in paint.iter() {
        if let Some((x, y)) = within(rect, x, y) {
            raster.set_rgba16(x, y, shown(colour));
        }
    }
}

/// Returns the paint with semitransparent pixels blended with the filling, where the photo shows nothing.
fn over_filling(paint: PaintPatch, rect: PixelRect, photo: &Raster, filling: &Raster) -> PaintPatch {
    let mut mixed = paint.clone();
    for (x, y, colour) in paint.iter().filter(|(_, _, colour)| !matches!(colour[3], 0 | u16::MAX)) {
        if let Some((u, v)) = within(rect, x, y)
            && !photo.has_colour(u, v)
            && filling.has_colour(u, v)
        {
            let below = filling.rgba16(u, v);
            let [r, g, b] = [0, 1, 2].map(|i| on_opaque(colour[i], colour[3], below[i]));
            mixed.put(x, y, [r, g, b, u16::MAX]);
        }
    }
    mixed
}

/// Converts a pixel of the photo to one of a raster of `rect`; `None` outside of it.
fn within(rect: PixelRect, x: i32, y: i32) -> Option<(u32, u32)> {
    rect.contains(x, y).then(|| ((x - rect.x) as u32, (y - rect.y) as u32))
}

/// Returns the colour that a painted pixel shows: erased pixels are transparent black.
pub fn shown(colour: PaintColour) -> PaintColour {
    if colour == ERASED { [0; 4] } else { colour }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_layered_files::Depth;

    #[test]
    fn a_painted_pixel_is_as_the_artist_left_it_and_an_erased_one_is_empty() {
        let rect = PixelRect { x: 10, y: 20, w: 3, h: 1 };
        let mut raster = Raster::blank(3, 1, Depth::Eight);
        (0..3).for_each(|x| raster.set_rgba16(x, 0, [2570, 2570, 2570, 65535]));
        let paint =
            PaintPatch::of_pixels(&[(10, 20, [257, 0, 0, 32896]), (11, 20, ERASED), (13, 20, [1; 4])]);
        paint_over(&mut raster, rect, &paint);
        let found: Vec<_> = (0..3).map(|x| raster.rgba16(x, 0)).collect();
        assert_eq!(found, [[257, 0, 0, 32896], [0; 4], [2570, 2570, 2570, 65535]]);
    }

    #[test]
    fn soft_paint_lets_the_filling_through_but_not_the_photo_that_it_replaced() {
        let rect = PixelRect::of_size(3, 1);
        let (mut photo, mut filling) =
            (Raster::blank(3, 1, Depth::Sixteen), Raster::blank(3, 1, Depth::Sixteen));
        photo.set_rgba16(0, 0, [9, 9, 9, 65535]);
        (1..3).for_each(|x| filling.set_rgba16(x, 0, [1000, 0, 0, 65535]));
        let soft = [0, 1000, 0, 13107];
        let paint = PaintPatch::of_pixels(&[(0, 0, soft), (1, 0, soft), (2, 0, ERASED)]);
        let found: Vec<_> = over_filling(paint, rect, &photo, &filling).iter().map(|pixel| pixel.2).collect();
        assert_eq!(found, [soft, [800, 200, 0, 65535], ERASED]);
    }
}
