//! Makes the pinhole image of a distorted photo and caches it as a PNG file.
//!
//! The file records what it was made from: the photo's content, lens and sizes, and the method. It is used
//! while these are the same; otherwise, or when it is missing, it is made again.

use std::borrow::Cow;
use std::fs::File;
use std::io::{BufReader, Write};
use std::path::Path;

use png::{BitDepth, ColorType, Compression, Decoder, Encoder, Info};

use super::read_photo;
use quadratura_base::error::Result;
use quadratura_base::geometry::Undistortion;
use quadratura_base::scene::PhotoPixels;
use quadratura_base::scene::resample::undistorted;
use quadratura_base::task::Task;
use quadratura_files::atomic::write_atomically_with;
use quadratura_files::hash::{hash_bytes, hash_file};

/// The method's name and version; it changes when the same photo and lens would give other pixels.
const METHOD: &str = "lanczos3 1";

/// Keyword of the text chunk with the hash of the photo's content, of its lens and sizes, and of [`METHOD`].
const MADE_OF: &str = "quadratura";

/// Makes `image` the pinhole image of `photo`, unless it is already up to date. Modification times are
/// ignored: the photo's content is hashed, which takes a hundredth of the time of decoding it.
///
/// # Errors
/// [`quadratura_base::Error::Input`] when the photo cannot be used; [`quadratura_base::Error::Io`] when the cache is not
/// writable; [`quadratura_base::Error::Cancelled`]. An old image stays.
pub fn make_pinhole_image(
    photo: &Path,
    undistortion: &Undistortion,
    image: &Path,
    task: &Task,
) -> Result<()> {
    let content = hash_file(photo)?;
    let made_of = hash_bytes(format!("{METHOD} {undistortion:?} {content}").as_bytes());
    if recorded_hash(image).as_ref() == Some(&made_of) {
        return Ok(());
    }
    let (width, height) = (undistortion.photo.width, undistortion.photo.height);
    let pixels = task.timed("decode photo", || read_photo(photo, width, height))?;
    let pixels = task.timed("undistort photo", || undistorted(&pixels, undistortion, task))?;
    task.timed("write pinhole image", || write_png(image, &pixels, &made_of))
}

/// Returns the hash recorded in an image; `None` when the file does not exist or was not made by this
/// program.
fn recorded_hash(image: &Path) -> Option<String> {
    let reader = Decoder::new(BufReader::new(File::open(image).ok()?)).read_info().ok()?;
    let chunks = &reader.info().uncompressed_latin1_text;
    chunks.iter().find(|chunk| chunk.keyword == MADE_OF).map(|chunk| chunk.text.clone())
}

/// Writes a PNG with fast compression, its profile and the hash of what it was made from.
fn write_png(file: &Path, pixels: &PhotoPixels, made_of: &str) -> Result<()> {
    write_atomically_with(file, |out| encode(out, pixels, made_of))
}

fn encode(out: impl Write, pixels: &PhotoPixels, made_of: &str) -> std::io::Result<()> {
    let mut info = Info::with_size(pixels.width, pixels.height);
    info.color_type = if pixels.has_alpha() { ColorType::Rgba } else { ColorType::Rgb };
    info.bit_depth = if pixels.bits() == 16 { BitDepth::Sixteen } else { BitDepth::Eight };
    info.icc_profile = pixels.icc.as_deref().map(Cow::Borrowed);
    let mut encoder = Encoder::with_info(out, info)?;
    encoder.set_compression(Compression::Fast);
    encoder.add_text_chunk(MADE_OF.into(), made_of.into())?;
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels.samples.big_endian())?;
    writer.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, SystemTime};

    use super::*;
    use quadratura_base::geometry::{Lens, Pinhole};
    use quadratura_base::scene::Samples;

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
        write_png(&path, &pixels, "test").unwrap();
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
