//! Reads and writes equirectangular pictures of all directions: PNG, JPEG, TIFF, WebP in sRGB, and Radiance HDR in
//! linear light.

use std::ffi::OsStr;
use std::io::{BufWriter, Write};
use std::path::Path;

use image::codecs::hdr::HdrEncoder;
use image::codecs::png::PngEncoder;
use image::{DynamicImage, ExtendedColorType, ImageEncoder, ImageError, ImageReader, Rgb};

use super::atomic::write_atomically_with;
use super::guarded::guarded;
use crate::error::{Error, Result};
use crate::geometry::PixelRect;
use crate::projection::srgb::Srgb;
use crate::raster::Image;
use crate::scene::light::linear_of_srgb;

/// What to do about a picture of another shape.
const REMEDY: &str =
    "give an equirectangular picture: 360 degrees wide, 180 degrees high, so twice as wide as high";

/// Reads a picture of all directions: linear light (full range 1), rows from the top.
///
/// # Errors
/// [`Error::Io`], and [`Error::Input`] for a file that is no picture or is not twice as wide as high.
pub fn read_dome_picture(path: &Path) -> Result<Image<[f32; 3]>> {
    guarded(path, "save it as PNG or Radiance HDR", || decoded(path))
}

fn decoded(path: &Path) -> Result<Image<[f32; 3]>> {
    let reader = ImageReader::open(path).map_err(Error::io(path, "open it"))?;
    let reader = reader.with_guessed_format().map_err(Error::io(path, "read it"))?;
    let picture = reader.decode().map_err(|error| {
        if let ImageError::Limits(_) = error {
            let found = "this picture is too large to be read";
            return Error::input(path, "", found, "save it with 8192 x 4096 pixels at most");
        }
        Error::input(
            path,
            "",
            format!("this picture cannot be read: {error}"),
            "save it as PNG or Radiance HDR",
        )
    })?;
    let (width, height) = (picture.width(), picture.height());
    if width != 2 * height || height == 0 {
        let found = format!("{width} x {height} pixels, expected twice as wide as high, such as 4096 x 2048");
        return Err(Error::input(path, "", found, REMEDY));
    }
    let light: Vec<[f32; 3]> = match picture {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            let finite = |light: f32| if light.is_finite() { light } else { 0.0 };
            picture.to_rgb32f().pixels().map(|pixel| pixel.0.map(finite)).collect()
        }
        encoded => {
            let linear = |value: u16| linear_of_srgb(f64::from(value) / 65535.0) as f32;
            encoded.to_rgb16().pixels().map(|pixel| pixel.0.map(linear)).collect()
        }
    };
    Ok(Image::new(PixelRect::of_size(width, height), light))
}

/// Returns true for the names of files that [`write_dome_picture`] can write.
pub fn is_writable(path: &Path) -> bool {
    matches!(extension(path).as_str(), "png" | "hdr")
}

fn extension(path: &Path) -> String {
    path.extension().and_then(OsStr::to_str).unwrap_or_default().to_lowercase()
}

/// Writes linear light (full range 1), rows from the top, as PNG in sRGB or, where the name ends in `.hdr`, as
/// Radiance HDR.
///
/// # Errors
/// [`Error::Io`].
pub fn write_dome_picture(path: &Path, width: u32, light: &[[f32; 3]]) -> Result<()> {
    let height = (light.len() / width as usize) as u32;
    write_atomically_with(path, |out| {
        let mut out = BufWriter::new(out);
        let written = if extension(path) == "hdr" {
            let pixels: Vec<Rgb<f32>> = light.iter().map(|light| Rgb(*light)).collect();
            HdrEncoder::new(&mut out).encode(&pixels, width as usize, height as usize)
        } else {
            let srgb = Srgb::tables();
            let bytes: Vec<u8> = light
                .iter()
                .flat_map(|light| light.map(|light| srgb.encoded(light.clamp(0.0, 1.0))))
                .collect();
            PngEncoder::new(&mut out).write_image(&bytes, width, height, ExtendedColorType::Rgb8)
        };
        written.map_err(std::io::Error::other)?;
        out.flush()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_comes_back_from_both_formats_and_another_shape_is_told_with_what_was_expected() {
        let folder = tempfile::tempdir().unwrap();
        let light: Vec<[f32; 3]> = (0..32 * 16).map(|i| [(i % 32) as f32 / 32.0, 0.25, 0.5]).collect();
        for (name, tolerance) in [("sky.png", 0.005), ("sky.HDR", 0.01)] {
            let file = folder.path().join(name);
            write_dome_picture(&file, 32, &light).unwrap();
            let read = read_dome_picture(&file).unwrap();
            assert_eq!(read.size(), [32, 16]);
            let pairs = read.pixels().iter().zip(&light);
            let off = pairs.flat_map(|(a, b)| [0, 1, 2].map(|c| (a[c] - b[c]).abs()));
            // Half a step of 8 bits; HDR shares an exponent among three channels of 8 bits.
            assert!(off.fold(0.0, f32::max) < tolerance, "{name}");
        }
        let square = folder.path().join("square.png");
        write_dome_picture(&square, 16, &light[..256]).unwrap();
        let message = read_dome_picture(&square).unwrap_err().to_string();
        let says = ["square.png", "16 x 16", "twice as wide as high", "equirectangular"];
        assert!(says.iter().all(|words| message.contains(words)), "{message}");
        std::fs::write(&square, "no picture").unwrap();
        assert!(read_dome_picture(&square).unwrap_err().to_string().contains("cannot be read"));
        assert!(is_writable(Path::new("a.Png")) && !is_writable(Path::new("a.exr")));
    }
}
