//! Reads photos: JPEG, PNG, TIFF and WebP, 8 and 16 bit, grey, RGB and RGBA. A file is judged by its content, not by its name;
//! a picture in another format is refused by the name of the format.
//!
//! Cameras refer to the pixels as they are stored. Viewers rotate a photo by its EXIF orientation; this
//! module does so only where the stored size does not match the camera and the rotated size does.

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read, Seek};
use std::path::Path;

use image::metadata::Orientation;
use image::{ColorType, ImageDecoder, ImageFormat, ImageReader, Limits};

use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{CameraExposure, PhotoPixels, Samples};
use quadratura_files::guarded::guarded;

mod exif;
mod folder;
mod jpeg;
mod kind;
mod parameters;
mod pinhole;
mod png;
mod tiff;
mod turn;

#[cfg(test)]
mod tests;

pub use folder::{Match, PhotoFolder};
pub use kind::{EXTENSIONS, is_picture_ending};
use kind::{Kind, kind_of, lying_ending, refusal};
pub use pinhole::make_pinhole_image;

/// The note about inks, which no decoder converts as their profile says.
const CMYK: &str = "its CMYK colours are converted without their profile; save it as RGB for exact colours";

/// The result of comparing a photo's header with its camera.
#[derive(Debug, Clone, PartialEq)]
pub struct PhotoHeader {
    /// The rotation of the stored pixels that matches the camera.
    turn: Orientation,
    /// Bytes per sample: 1 or 2.
    pub sample_bytes: u64,
    /// The exposure that the camera wrote down.
    pub exposure: Option<CameraExposure>,
    /// Notes for the user about orientation and profile.
    pub notes: Vec<String>,
}

/// Checks a photo without decoding it: whether it can be read, and whether its size matches the camera's.
///
/// # Errors
/// [`Error::Input`] when the file is in no supported format, damaged at its beginning, a truncated JPEG or PNG, of
/// an unsupported kind, or of another size; [`Error::Io`].
pub fn check_photo(path: &Path, width: u32, height: u32) -> Result<PhotoHeader> {
    guarded(path, SAVE_AGAIN, || checked(path, width, height))
}

fn checked(path: &Path, width: u32, height: u32) -> Result<PhotoHeader> {
    // The JPEG decoder reads all that it is given; the header rarely reaches beyond this.
    const BEGINNING: u64 = 1 << 18;
    let mut file = open(path, width, height)?;
    let mut beginning = Vec::new();
    file.by_ref().take(BEGINNING).read_to_end(&mut beginning).map_err(Error::io(path, "read it"))?;
    refuse_cut(path, &beginning, &mut file)?;
    if beginning.starts_with(&jpeg::START) {
        let header = header_of(path, Cursor::new(&beginning), width, height);
        if header.is_ok() || (beginning.len() as u64) < BEGINNING {
            return header;
        }
    }
    file.rewind().map_err(Error::io(path, "read it"))?;
    header_of(path, file, width, height)
}

fn header_of(path: &Path, input: impl BufRead + Seek, width: u32, height: u32) -> Result<PhotoHeader> {
    fitting(path, &mut decoder(path, input, most_memory(width, height))?, width, height)
}

/// Reads a photo whose camera has `width` x `height` pixels. Samples are those of the file, bit for bit as
/// its decoder returns them; grey is repeated in three channels.
///
/// # Errors
/// As [`check_photo`], and when the file is damaged.
pub fn read_photo(path: &Path, width: u32, height: u32) -> Result<PhotoPixels> {
    guarded(path, SAVE_AGAIN, || whole(path, width, height))
}

fn whole(path: &Path, width: u32, height: u32) -> Result<PhotoPixels> {
    let mut file = open(path, width, height)?;
    let beginning: Vec<u8> =
        file.fill_buf().map_err(Error::io(path, "read it"))?.iter().take(kind::START).copied().collect();
    refuse_cut(path, &beginning, &mut file)?;
    file.rewind().map_err(Error::io(path, "read it"))?;
    decoded(path, file, width, height)
}

fn decoded(path: &Path, input: impl BufRead + Seek, width: u32, height: u32) -> Result<PhotoPixels> {
    let mut opened = decoder(path, input, most_memory(width, height))?;
    let header = fitting(path, &mut opened, width, height)?;
    let mut decoder = opened.decoder;
    let icc = decoder.icc_profile().ok().flatten().filter(|profile| describes_rgb(profile));
    let (stored_width, stored_height) = decoder.dimensions();
    let color = decoder.color_type();
    let samples = samples(decoder, color).map_err(|error| unreadable(path, &error))?;
    let channels = if color.has_alpha() { 4 } else { 3 };
    let samples = turn::turned(samples, stored_width, stored_height, channels, header.turn);
    Ok(PhotoPixels { width, height, channels, samples, icc })
}

/// Reads a picture that is in memory, as stored, with at most `longest` pixels a side; `path` is named in errors.
///
/// # Errors
/// [`Error::Input`] when it is in no supported format, damaged or too large.
pub fn decode_picture(path: &Path, bytes: &[u8], longest: u32) -> Result<PhotoPixels> {
    guarded(path, SAVE_AGAIN, || picture(path, bytes, longest))
}

fn picture(path: &Path, bytes: &[u8], longest: u32) -> Result<PhotoPixels> {
    let (width, height) = decoder(path, Cursor::new(bytes), MEMORY_OF_A_HEADER)?.decoder.dimensions();
    if width > longest || height > longest {
        let found = format!("a picture of {width} x {height} pixels, expected at most {longest} a side");
        return Err(Error::input(path, "", found, "make it smaller"));
    }
    refuse_cut(path, bytes, &mut Cursor::new(bytes))?;
    decoded(path, Cursor::new(bytes), width, height)
}

/// Refuses a JPEG or a PNG that ends before its picture does. `beginning` are the first bytes of the file.
fn refuse_cut(path: &Path, beginning: &[u8], file: &mut (impl BufRead + Seek)) -> Result<()> {
    let (name, is_whole) = match beginning {
        start if start.starts_with(&jpeg::START) => ("JPEG", jpeg::is_whole(file)),
        start if start.starts_with(&png::START) => ("PNG", png::is_whole(file)),
        _ => return Ok(()),
    };
    if is_whole.map_err(Error::io(path, "read it"))? {
        return Ok(());
    }
    let found = format!("the {name} is cut short: it ends before its picture does");
    Err(Error::input(path, "", found, "copy the file again from a complete original"))
}

/// Returns width and height of a picture as stored, from its header.
///
/// # Errors
/// [`Error::Input`] when the format is not supported; [`Error::Io`].
pub fn picture_size(path: &Path) -> Result<[u32; 2]> {
    guarded(path, SAVE_AGAIN, || {
        let file = BufReader::new(File::open(path).map_err(Error::io(path, "open it"))?);
        let (width, height) = decoder(path, file, MEMORY_OF_A_HEADER)?.decoder.dimensions();
        Ok([width, height])
    })
}

/// Returns true where a file's content is a photo in a format that is read, whatever its name is.
pub fn is_photo(path: &Path) -> bool {
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| file.take(kind::START as u64).read_to_end(&mut start));
    read.is_ok() && matches!(kind_of(path, &start), Kind::Photo(_))
}

/// Returns the exposure that the camera wrote into a photo's file; `None` where there is none, and where the file cannot be read.
pub fn read_exposure(path: &Path) -> Option<CameraExposure> {
    let read = || {
        let file = BufReader::new(File::open(path).map_err(Error::io(path, "open it"))?);
        let mut decoder = decoder(path, file, MEMORY_OF_A_HEADER)?.decoder;
        Ok(decoder.exif_metadata().ok().flatten().and_then(exif::camera_exposure))
    };
    guarded(path, SAVE_AGAIN, read).ok().flatten()
}

/// Opens a file that may be a photo of this size.
fn open(path: &Path, width: u32, height: u32) -> Result<BufReader<File>> {
    let metadata = std::fs::metadata(path).map_err(Error::io(path, "read it"))?;
    if !metadata.is_file() {
        return Err(Error::input(path, "", "not a file", "put the photo there"));
    }
    if metadata.len() == 0 {
        let remedy = "copy the file again from a complete original";
        return Err(Error::input(path, "", "the file is empty: 0 bytes", remedy));
    }
    // More than 8 bytes per sample of uncompressed RGBA is not a photo of this size, but an attack.
    if metadata.len() > most_memory(width, height) {
        let found = format!("{} megabytes for a photo of {width} x {height} pixels", metadata.len() >> 20);
        return Err(Error::input(path, "", found, "save the photo again without other data"));
    }
    Ok(BufReader::new(File::open(path).map_err(Error::io(path, "read it"))?))
}

/// The memory in bytes that the decoder of a photo of this size may take: several times the 8 bytes of a 16-bit RGBA pixel, but
/// not unlimited.
fn most_memory(width: u32, height: u32) -> u64 {
    32 * u64::from(width) * u64::from(height) + (64 << 20)
}

/// The same where only the header is read.
const MEMORY_OF_A_HEADER: u64 = 64 << 20;

/// A decoder that has read a file's header.
struct OpenDecoder<'a> {
    decoder: Box<dyn ImageDecoder + 'a>,
    /// Remarks for the user about the file.
    notes: Vec<String>,
}

fn decoder<'a>(path: &Path, mut input: impl BufRead + Seek + 'a, memory: u64) -> Result<OpenDecoder<'a>> {
    let start = input.fill_buf().map_err(Error::io(path, "read it"))?;
    let kind = kind_of(path, &start[..start.len().min(kind::START)]);
    let Kind::Photo(format) = kind else { return Err(refusal(path, kind)) };
    let mut notes: Vec<String> = lying_ending(path, format).into_iter().collect();
    if format == ImageFormat::Tiff {
        let decoder = tiff::TiffPhoto::open(path, input, memory)?;
        notes.extend_from_slice(decoder.notes());
        return Ok(OpenDecoder { decoder: Box::new(decoder), notes });
    }
    notes.extend(parameters::unapplied(format, &mut input).map_err(Error::io(path, "read it"))?);
    let mut reader = ImageReader::with_format(input, format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(memory);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(|error| unreadable(path, &error))?;
    Ok(OpenDecoder { decoder: Box::new(decoder), notes })
}

/// Checks size and sample type.
fn fitting(path: &Path, opened: &mut OpenDecoder, width: u32, height: u32) -> Result<PhotoHeader> {
    let decoder = &mut opened.decoder;
    use ColorType::{L8, L16, La8, La16, Rgb8, Rgb16, Rgba8, Rgba16};
    let color = decoder.color_type();
    if !matches!(color, L8 | L16 | La8 | La16 | Rgb8 | Rgb16 | Rgba8 | Rgba16) {
        let found = format!("samples of an unsupported kind ({color:?})");
        return Err(Error::input(path, "", found, "save the photo with 8 or 16 bits per channel"));
    }
    let stored = decoder.dimensions();
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let turns = turn::swaps_sides(orientation);
    let mut notes = std::mem::take(&mut opened.notes);
    let turn = if stored == (width, height) {
        if orientation != Orientation::NoTransforms {
            let tag = orientation.to_exif();
            notes.push(format!("EXIF orientation {tag} is not applied: the camera fits the stored pixels"));
        }
        Orientation::NoTransforms
    } else if turns && (stored.1, stored.0) == (width, height) {
        let tag = orientation.to_exif();
        notes.push(format!("EXIF orientation {tag} is applied: the camera fits the turned photo only"));
        orientation
    } else {
        return Err(wrong_size(path, stored, (width, height), turns));
    };
    if decoder.icc_profile().ok().flatten().is_some_and(|profile| !describes_rgb(&profile)) {
        notes.push("its colour profile is not for RGB and is ignored".into());
    }
    let exposure = decoder.exif_metadata().ok().flatten().and_then(exif::camera_exposure);
    Ok(PhotoHeader { turn, sample_bytes: sample_bytes(color), exposure, notes })
}

fn sample_bytes(color: ColorType) -> u64 {
    (color.bytes_per_pixel() / color.channel_count()).into()
}

/// Returns whether a profile is for RGB; one for grey or CMYK does not fit the decoded pixels. Bytes 16..20
/// of a profile hold its colour space.
fn describes_rgb(profile: &[u8]) -> bool {
    profile.get(16..20) == Some(b"RGB ")
}

fn wrong_size(path: &Path, stored: (u32, u32), (width, height): (u32, u32), turns: bool) -> Error {
    let found = format!("{} x {} pixels where the camera has {width} x {height}", stored.0, stored.1);
    let remedy = if (stored.1, stored.0) == (width, height) && !turns {
        "turn the photo by 90 degrees, or use the one that the cameras were computed from"
    } else {
        "use the photo that the cameras were computed from, in its own size"
    };
    Error::input(path, "", found, remedy)
}

/// Decodes directly into the final buffer.
fn samples(decoder: impl ImageDecoder, color: ColorType) -> image::ImageResult<Samples> {
    let (width, height) = decoder.dimensions();
    let count = width as usize * height as usize * usize::from(color.channel_count());
    if sample_bytes(color) == 1 {
        let mut samples = vec![0u8; count];
        decoder.read_image(&mut samples)?;
        Ok(Samples::U8(in_color(samples, color)))
    } else {
        let mut samples = vec![0u16; count];
        decoder.read_image(bytemuck::cast_slice_mut(&mut samples))?;
        Ok(Samples::U16(in_color(samples, color)))
    }
}

/// Repeats grey in three channels.
fn in_color<T: Copy>(samples: Vec<T>, color: ColorType) -> Vec<T> {
    match (color.has_color(), color.has_alpha()) {
        (true, _) => samples,
        (false, false) => samples.iter().flat_map(|&grey| [grey; 3]).collect(),
        (false, true) => samples.chunks_exact(2).flat_map(|p| [p[0], p[0], p[0], p[1]]).collect(),
    }
}

/// The remedy for a file that cannot be decoded.
const SAVE_AGAIN: &str = "copy the file again, or save it again in an image editor";

fn unreadable(path: &Path, error: &image::ImageError) -> Error {
    let found = format!("the photo cannot be decoded ({error})");
    Error::input(path, "", found, SAVE_AGAIN)
}
