//! The pictures of an exported layered depth image: colours as JPEG, rims as PNG.

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, RgbImage};

use crate::segments::Atlas;

/// Returns RGB pixels, 8 bits each, rows from the top, as a JPEG of a quality from 1 to 100.
pub fn jpeg(rgb: &[u8], [width, height]: [u32; 2], quality: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, quality);
    encoder
        .write_image(rgb, width, height, ExtendedColorType::Rgb8)
        .expect("the picture has a size that JPEG allows, and memory does not fail");
    bytes
}

/// Returns what a segment covers, and its opacity there, as a PNG: grey where everything that is covered is opaque, otherwise
/// the cover in red and the opacity in green.
pub fn rims(atlas: &Atlas) -> Vec<u8> {
    let soft = atlas.opacity.iter().any(|opacity| !matches!(opacity, 0 | 255));
    let cover = |opacity: u8| if opacity > 0 { 255 } else { 0 };
    if soft {
        let pixels: Vec<u8> =
            atlas.opacity.iter().flat_map(|&opacity| [cover(opacity), opacity, 0]).collect();
        return png(&pixels, [atlas.width, atlas.height], ExtendedColorType::Rgb8);
    }
    png(&atlas.opacity, [atlas.width, atlas.height], ExtendedColorType::L8)
}

/// Returns colours with their opacity as a PNG.
pub fn rgba_png(atlas: &Atlas) -> Vec<u8> {
    let texels = atlas.rgb.as_chunks::<3>().0.iter().zip(&atlas.opacity);
    let pixels: Vec<u8> = texels.flat_map(|(&[r, g, b], &a)| [r, g, b, a]).collect();
    png(&pixels, [atlas.width, atlas.height], ExtendedColorType::Rgba8)
}

/// Returns pixels as a PNG.
pub fn png(pixels: &[u8], [width, height]: [u32; 2], kind: ExtendedColorType) -> Vec<u8> {
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive);
    encoder.write_image(pixels, width, height, kind).expect("the picture has a size that PNG allows");
    bytes
}

/// Returns a picture with a longest side of at most `longest`, as JPEG.
pub fn small_jpeg(rgb: Vec<u8>, [width, height]: [u32; 2], longest: u32, quality: u8) -> Vec<u8> {
    let picture = RgbImage::from_raw(width, height, rgb).expect("there are three values a pixel");
    let scale = (f64::from(longest) / f64::from(width.max(height))).min(1.0);
    let size = [width, height].map(|side| ((f64::from(side) * scale).round() as u32).max(1));
    let small = image::imageops::resize(&picture, size[0], size[1], image::imageops::FilterType::CatmullRom);
    jpeg(small.as_raw(), size, quality)
}
