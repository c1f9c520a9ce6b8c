//! Reads and writes equirectangular pictures of all directions: PNG, JPEG, TIFF, WebP in sRGB, and Radiance HDR in
//! linear light.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Read, Write};
use std::path::Path;

use glam::DVec3;
use image::codecs::hdr::HdrEncoder;
use image::{DynamicImage, ImageError, ImageReader, Rgb};
use png::{BitDepth, ColorType, Encoder};

use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Image;
use quadratura_base::scene::light::linear_of_srgb;
use quadratura_files::atomic::write_atomically_with;
use quadratura_files::guarded::guarded;
use quadratura_files::png_error::io_error;
use quadratura_view::srgb::Srgb;

/// What to do about a picture of another shape.
const REMEDY: &str =
    "give an equirectangular picture: 360 degrees wide, 180 degrees high, so twice as wide as high";

/// The keyword of the text that says where the middle of a PNG looks. Image editors keep comments.
const COMMENT: &str = "Comment";

/// What precedes the direction of a picture's middle, three numbers with commas between, in the cameras' world.
const MIDDLE: &str = "QUADRATURA_MIDDLE=";

/// The first line of a Radiance picture.
const RADIANCE: &str = "#?RADIANCE";

/// The most bytes of a Radiance header that are read.
const LONGEST_HEADER: u64 = 64 << 10;

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
/// Radiance HDR, with the direction of the middle in the cameras' world ([`recorded_middle`]).
///
/// # Errors
/// [`Error::Io`].
pub fn write_dome_picture(path: &Path, width: u32, light: &[[f32; 3]], middle: DVec3) -> Result<()> {
    let height = (light.len() / width as usize) as u32;
    let DVec3 { x, y, z } = middle;
    let record = format!("{MIDDLE}{x},{y},{z}");
    write_atomically_with(path, |out| {
        let mut out = BufWriter::new(out);
        if extension(path) == "hdr" {
            let pixels: Vec<Rgb<f32>> = light.iter().map(|light| Rgb(*light)).collect();
            // The encoder writes its own first line, which is a comment here.
            writeln!(out, "{RADIANCE}\n{record}")?;
            let written = HdrEncoder::new(&mut out).encode(&pixels, width as usize, height as usize);
            written.map_err(std::io::Error::other)?;
        } else {
            let srgb = Srgb::tables();
            let bytes: Vec<u8> = light
                .iter()
                .flat_map(|light| light.map(|light| srgb.encoded(light.clamp(0.0, 1.0))))
                .collect();
            let mut encoder = Encoder::new(&mut out, width, height);
            encoder.set_color(ColorType::Rgb);
            encoder.set_depth(BitDepth::Eight);
            encoder.add_text_chunk(COMMENT.into(), record.clone()).map_err(io_error)?;
            let mut writer = encoder.write_header().map_err(io_error)?;
            writer.write_image_data(&bytes).map_err(io_error)?;
            writer.finish().map_err(io_error)?;
        }
        out.flush()
    })
}

/// Returns the direction of a picture's middle that [`write_dome_picture`] has recorded in it; `None` where a file of
/// another format, or of another program, has none.
pub fn recorded_middle(path: &Path) -> Option<[f64; 3]> {
    guarded(path, REMEDY, || Ok(middle_in_text(path))).ok().flatten()
}

fn middle_in_text(path: &Path) -> Option<[f64; 3]> {
    let file = BufReader::new(File::open(path).ok()?);
    let line = match extension(path).as_str() {
        "png" => {
            let reader = png::Decoder::new(file).read_info().ok()?;
            let info = reader.info();
            let latin = info.uncompressed_latin1_text.iter().map(|text| text.text.clone());
            let utf8 = info.utf8_text.iter().filter_map(|text| text.get_text().ok());
            latin.chain(utf8).find(|text| text.starts_with(MIDDLE))?
        }
        "hdr" => {
            let header = file.take(LONGEST_HEADER).lines().map_while(std::io::Result::ok);
            header.take_while(|line| !line.is_empty()).find(|line| line.starts_with(MIDDLE))?
        }
        _ => return None,
    };
    let numbers = line.strip_prefix(MIDDLE)?.trim().split(',').map(|number| number.parse::<f64>().ok());
    let middle = <[f64; 3]>::try_from(numbers.collect::<Option<Vec<_>>>()?).ok()?;
    (middle.iter().all(|x| x.is_finite()) && middle != [0.0; 3]).then_some(middle)
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
            let middle = DVec3::new(0.1, -0.7 / 3.0, 1e-17);
            write_dome_picture(&file, 32, &light, middle).unwrap();
            assert_eq!(recorded_middle(&file), Some(middle.to_array()), "{name}");
            let read = read_dome_picture(&file).unwrap();
            assert_eq!(read.size(), [32, 16]);
            let pairs = read.pixels().iter().zip(&light);
            let off = pairs.flat_map(|(a, b)| [0, 1, 2].map(|c| (a[c] - b[c]).abs()));
            // Half a step of 8 bits; HDR shares an exponent among three channels of 8 bits.
            assert!(off.fold(0.0, f32::max) < tolerance, "{name}");
        }
        let square = folder.path().join("square.png");
        write_dome_picture(&square, 16, &light[..256], DVec3::Y).unwrap();
        let message = read_dome_picture(&square).unwrap_err().to_string();
        let says = ["square.png", "16 x 16", "twice as wide as high", "equirectangular"];
        assert!(says.iter().all(|words| message.contains(words)), "{message}");
        std::fs::write(&square, "no picture").unwrap();
        assert!(read_dome_picture(&square).unwrap_err().to_string().contains("cannot be read"));
        assert!(is_writable(Path::new("a.Png")) && !is_writable(Path::new("a.exr")));
    }

    #[test]
    fn a_picture_of_another_program_records_no_direction_and_a_wrong_record_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let plain = folder.path().join("plain.png");
        image::RgbImage::new(8, 4).save(&plain).unwrap();
        assert_eq!(recorded_middle(&plain), None);
        let radiance = |name: &str, record: &str| {
            let file = folder.path().join(name);
            std::fs::write(&file, format!("{RADIANCE}\n{record}\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n"))
                .unwrap();
            recorded_middle(&file)
        };
        assert_eq!(radiance("a.hdr", "QUADRATURA_MIDDLE=0,1,0"), Some([0.0, 1.0, 0.0]));
        for wrong in
            ["EXPOSURE=1", "QUADRATURA_MIDDLE=0,0,0", "QUADRATURA_MIDDLE=1,2", "QUADRATURA_MIDDLE=a,b,c"]
        {
            assert_eq!(radiance("b.hdr", wrong), None, "{wrong}");
        }
        assert_eq!(recorded_middle(&folder.path().join("missing.hdr")), None);
    }
}
