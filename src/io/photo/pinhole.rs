//! The pinhole image of a distorted photo, kept as a PNG file in the cache.
//!
//! The file says what it was made of: the photo's content, lens and sizes, and this method. As long
//! as that is the same it is used; else, or when it is gone, it is made again.

use std::borrow::Cow;
use std::fs::File;
use std::io::{BufReader, Write};
use std::path::Path;
use std::time::UNIX_EPOCH;

use png::{BitDepth, ColorType, Compression, Decoder, Encoder, Info};

use super::read_photo;
use crate::error::{Error, Result};
use crate::geometry::Undistortion;
use crate::io::atomic::write_atomically_with;
use crate::io::hash::{hash_bytes, hash_file};
use crate::scene::resample::undistorted;
use crate::scene::{PhotoPixels, Samples};
use crate::task::Task;

/// Changes when the same photo and lens would give other pixels.
const METHOD: &str = "lanczos3 1";

/// Text chunks of the file: hash of lens and sizes, hash of the photo's file, its size and time.
const RECIPE: &str = "quadratura recipe";
const CONTENT: &str = "quadratura photo";
const STAMP: &str = "quadratura stamp";

/// Makes `image` the pinhole image of `photo`, unless it is that already. A photo counts as unchanged
/// while its size and time are those that it had, or else while its content is.
///
/// # Errors
/// [`Error::Input`] when the photo cannot be used, [`Error::Io`] when the cache cannot be written,
/// [`Error::Cancelled`]; an old image stays.
pub fn make_pinhole_image(
    photo: &Path,
    undistortion: &Undistortion,
    image: &Path,
    task: &Task,
) -> Result<()> {
    let recipe = hash_bytes(format!("{METHOD} {undistortion:?}").as_bytes());
    let stamp = stamp_of(photo)?;
    let old = texts_of(image);
    let kept = |key: &str| old.iter().find(|(k, _)| k == key).map(|(_, value)| value.as_str());
    if kept(RECIPE) == Some(&recipe) && kept(STAMP) == Some(&stamp) {
        return Ok(());
    }
    let content = hash_file(photo)?;
    if kept(RECIPE) == Some(&recipe) && kept(CONTENT) == Some(&content) {
        return Ok(());
    }
    let (width, height) = (undistortion.photo.width, undistortion.photo.height);
    let pixels = task.timed("decode photo", || read_photo(photo, width, height))?;
    let pixels = task.timed("undistort photo", || undistorted(&pixels, undistortion, task))?;
    let texts = [(RECIPE, recipe), (CONTENT, content), (STAMP, stamp)];
    task.timed("write pinhole image", || write_png(image, &pixels, &texts))
}

/// Size and time of a file, without reading it.
fn stamp_of(file: &Path) -> Result<String> {
    let metadata = file.metadata().map_err(Error::io(file, "read it"))?;
    let time = metadata.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
    Ok(format!("{} bytes, {} ns", metadata.len(), time.unwrap_or_default().as_nanos()))
}

/// The text chunks in front of a PNG's pixels; none when there is no such file.
fn texts_of(image: &Path) -> Vec<(String, String)> {
    let reader = File::open(image).ok().and_then(|file| Decoder::new(BufReader::new(file)).read_info().ok());
    let texts = reader.map(|reader| reader.info().uncompressed_latin1_text.clone()).unwrap_or_default();
    texts.into_iter().map(|chunk| (chunk.keyword, chunk.text)).collect()
}

/// Writes a PNG at the fast level, with its profile and text chunks.
fn write_png(file: &Path, pixels: &PhotoPixels, texts: &[(&str, String)]) -> Result<()> {
    write_atomically_with(file, |out| match &pixels.samples {
        Samples::U8(samples) => encode(out, pixels, BitDepth::Eight, samples, texts),
        Samples::U16(samples) => {
            let bytes: Vec<u8> = samples.iter().flat_map(|sample| sample.to_be_bytes()).collect();
            encode(out, pixels, BitDepth::Sixteen, &bytes, texts)
        }
    })
}

fn encode(
    out: impl Write,
    pixels: &PhotoPixels,
    depth: BitDepth,
    bytes: &[u8],
    texts: &[(&str, String)],
) -> std::io::Result<()> {
    let mut info = Info::with_size(pixels.width, pixels.height);
    info.color_type = if pixels.has_alpha() { ColorType::Rgba } else { ColorType::Rgb };
    info.bit_depth = depth;
    info.icc_profile = pixels.icc.as_deref().map(Cow::Borrowed);
    let mut encoder = Encoder::with_info(out, info)?;
    encoder.set_compression(Compression::Fast);
    for (key, text) in texts {
        encoder.add_text_chunk((*key).into(), text.clone())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, SystemTime};

    use super::*;
    use crate::geometry::{Lens, Pinhole};

    const PHOTO: Pinhole = Pinhole { width: 40, height: 30, fx: 35.0, fy: 35.0, cx: 20.0, cy: 15.0 };

    fn undistortion(k: f64) -> Undistortion {
        Undistortion::new(&PHOTO, Lens::Division { k }).unwrap()
    }

    fn save(path: &Path, shade: u16) {
        image::ImageBuffer::from_fn(40, 30, |x, _| image::Rgb([shade, x as u16 * 999, 7]))
            .save(path)
            .unwrap();
    }

    /// Makes the image again and says whether it is another file than before.
    fn remade(folder: &Path, k: f64) -> bool {
        let (photo, image) = (folder.join("photo.png"), folder.join("image.png"));
        let marked = SystemTime::UNIX_EPOCH + Duration::from_secs(1);
        if let Ok(file) = File::options().write(true).open(&image) {
            file.set_modified(marked).unwrap();
        }
        make_pinhole_image(&photo, &undistortion(k), &image, &Task::silent()).unwrap();
        image.metadata().unwrap().modified().unwrap() != marked
    }

    #[test]
    fn the_image_is_made_again_only_when_photo_or_lens_changed_or_it_is_gone() {
        let folder = tempfile::tempdir().unwrap();
        let (photo, image) = (folder.path().join("photo.png"), folder.path().join("image.png"));
        save(&photo, 1);
        assert!(remade(folder.path(), -0.1), "it was not there");
        assert!(!remade(folder.path(), -0.1), "nothing changed");
        File::options().write(true).open(&photo).unwrap().set_modified(SystemTime::UNIX_EPOCH).unwrap();
        assert!(!remade(folder.path(), -0.1), "only the time changed");
        assert!(remade(folder.path(), -0.2), "the lens changed");
        save(&photo, 60_000);
        assert!(remade(folder.path(), -0.2), "the photo changed");
        std::fs::write(&image, "damaged").unwrap();
        assert!(remade(folder.path(), -0.2), "the image was damaged");
    }

    #[test]
    fn the_file_holds_depth_alpha_and_profile() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image.png");
        let mut profile = vec![0; 128];
        profile[16..20].copy_from_slice(b"RGB ");
        let samples = Samples::U16((0..40 * 30 * 4).map(|i| (i * 13) as u16).collect());
        let pixels = PhotoPixels { width: 40, height: 30, channels: 4, samples, icc: Some(profile) };
        write_png(&path, &pixels, &[]).unwrap();
        assert_eq!(read_photo(&path, 40, 30).unwrap(), pixels);
    }

    #[test]
    fn a_photo_that_cannot_be_read_leaves_no_image() {
        let folder = tempfile::tempdir().unwrap();
        let (photo, image) = (folder.path().join("photo.png"), folder.path().join("image.png"));
        std::fs::write(&photo, "no photo").unwrap();
        assert!(make_pinhole_image(&photo, &undistortion(-0.1), &image, &Task::silent()).is_err());
        assert!(!image.exists());
    }
}
