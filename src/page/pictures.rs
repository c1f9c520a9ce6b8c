//! The pictures of pages.

pub use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ImageEncoder, RgbImage};
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};

/// Returns RGB pixels, 8 bits each, rows from the top, as a JPEG of a quality from 1 to 100. It holds pixels alone: nothing that a
/// camera wrote into its file.
pub fn jpeg(rgb: &[u8], [width, height]: [u32; 2], quality: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, quality);
    encoder
        .write_image(rgb, width, height, ExtendedColorType::Rgb8)
        .expect("the picture has a size that JPEG allows, and memory does not fail");
    bytes
}

/// Returns RGB pixels as [`jpeg`] does, a fifth smaller: progressive, with a colour for four pixels. Sides are at most 65,535 pixels.
pub fn photo_jpeg(rgb: &[u8], [width, height]: [u32; 2], quality: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, quality);
    encoder.set_sampling_factor(SamplingFactor::F_2_2);
    encoder.set_progressive(true);
    encoder.set_optimized_huffman_tables(true);
    let [width, height] =
        [width, height].map(|side| u16::try_from(side).expect("photos are smaller than this"));
    encoder.encode(rgb, width, height, ColorType::Rgb).expect("the picture has a size that JPEG allows");
    bytes
}

/// Returns pixels as a PNG.
pub fn png(pixels: &[u8], [width, height]: [u32; 2], kind: ExtendedColorType) -> Vec<u8> {
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive);
    encoder.write_image(pixels, width, height, kind).expect("the picture has a size that PNG allows");
    bytes
}

/// Returns a picture with a longest side of at most `longest`, and its size.
pub fn reduced(rgb: Vec<u8>, [width, height]: [u32; 2], longest: u32) -> (Vec<u8>, [u32; 2]) {
    if longest >= width.max(height) {
        return (rgb, [width, height]);
    }
    let picture = RgbImage::from_raw(width, height, rgb).expect("there are three values a pixel");
    let scale = f64::from(longest) / f64::from(width.max(height));
    let size = [width, height].map(|side| ((f64::from(side) * scale).round() as u32).max(1));
    let small = image::imageops::resize(&picture, size[0], size[1], image::imageops::FilterType::CatmullRom);
    (small.into_raw(), size)
}

/// Returns a picture with a longest side of at most `longest`, as JPEG.
pub fn small_jpeg(rgb: Vec<u8>, size: [u32; 2], longest: u32, quality: u8) -> Vec<u8> {
    let (rgb, size) = reduced(rgb, size, longest);
    jpeg(&rgb, size, quality)
}
