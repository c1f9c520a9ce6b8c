//! Caches thumbnails of photos in `cache/thumbnails/`. They are derived: a file that is missing, damaged, or
//! of an older state of its photo is no error; it is made again.

use std::fs::{File, Metadata};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use png::{BitDepth, ColorType, Compression, Decoder, Encoder};

use quadratura_base::error::{Error, Result};
use quadratura_document::names::file_name_of_photo;
use quadratura_files::atomic::write_atomically_with;
use quadratura_view::Picture;

/// Keyword of the text chunk that holds the photo's stamp.
const MADE_OF: &str = "quadratura-photo";
/// Limit on decoded bytes (2048 x 2048 pixels); larger files are not thumbnails of this program.
const MOST_BYTES: usize = 1 << 24;

/// The thumbnails of a project.
#[derive(Debug, Clone)]
pub struct Thumbnails {
    folder: PathBuf,
}

/// The state of a photo's file and the size of its thumbnail. A cached thumbnail is used only if its stamp is
/// equal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ThumbnailStamp(String);

impl ThumbnailStamp {
    /// Takes the stamp of a photo's file by its length and modification time; `longest_px` is the longer side
    /// of the thumbnail in pixels.
    ///
    /// # Errors
    /// [`Error::Io`] when the file does not exist.
    pub fn from_photo(photo: &Path, longest_px: u32) -> Result<Self> {
        let metadata = std::fs::metadata(photo).map_err(Error::io(photo, "read its size"))?;
        let length = metadata.len();
        let changed = changed_ns(&metadata);
        Ok(Self(format!("{length} bytes, {changed} ns, {longest_px} px")))
    }
}

/// Returns the modification time in nanoseconds since 1970; 0 where the system does not say.
fn changed_ns(metadata: &Metadata) -> u128 {
    let changed = metadata.modified().ok();
    changed.and_then(|at| at.duration_since(UNIX_EPOCH).ok()).map_or(0, |since| since.as_nanos())
}

impl Thumbnails {
    /// Returns the cache of the project in the folder `project`.
    pub fn new(project: &Path) -> Self {
        Self { folder: project.join("cache").join("thumbnails") }
    }

    fn file(&self, photo: &str) -> PathBuf {
        self.folder.join(format!("{}.png", file_name_of_photo(photo)))
    }

    /// Reads the thumbnail of `photo` if one is cached for this stamp.
    pub fn kept(&self, photo: &str, stamp: &ThumbnailStamp) -> Option<Picture> {
        let file = BufReader::new(File::open(self.file(photo)).ok()?);
        let mut reader = Decoder::new(file).read_info().ok()?;
        let info = reader.info();
        let made_of = info.uncompressed_latin1_text.iter().find(|chunk| chunk.keyword == MADE_OF)?;
        let rgba = (info.color_type, info.bit_depth) == (ColorType::Rgba, BitDepth::Eight);
        if made_of.text != stamp.0 || !rgba {
            return None;
        }
        let (width, height) = (info.width, info.height);
        let mut rgba = vec![0; reader.output_buffer_size().filter(|size| *size <= MOST_BYTES)?];
        reader.next_frame(&mut rgba).ok()?;
        Some(Picture { width, height, rgba })
    }

    /// Stores the thumbnail of `photo`.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn keep(&self, photo: &str, stamp: &ThumbnailStamp, picture: &Picture) -> Result<()> {
        std::fs::create_dir_all(&self.folder).map_err(Error::io(&self.folder, "create the folder"))?;
        write_atomically_with(self.file(photo), |out| {
            let mut encoder = Encoder::new(out, picture.width, picture.height);
            encoder.set_color(ColorType::Rgba);
            encoder.set_depth(BitDepth::Eight);
            encoder.set_compression(Compression::Fast);
            encoder.add_text_chunk(MADE_OF.into(), stamp.0.clone())?;
            let mut writer = encoder.write_header()?;
            writer.write_image_data(&picture.rgba)?;
            writer.finish()?;
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_kept_until_its_photo_changes_or_another_size_is_wanted() {
        let project = tempfile::tempdir().unwrap();
        let photo = project.path().join("a b.jpg");
        std::fs::write(&photo, "some bytes").unwrap();
        let (thumbnails, stamp) =
            (Thumbnails::new(project.path()), ThumbnailStamp::from_photo(&photo, 4).unwrap());
        assert!(thumbnails.kept("x/a b.jpg", &stamp).is_none());
        let picture = Picture { width: 4, height: 1, rgba: (0..16).collect() };
        thumbnails.keep("x/a b.jpg", &stamp, &picture).unwrap();
        assert_eq!(thumbnails.kept("x/a b.jpg", &stamp).as_ref(), Some(&picture));
        assert!(thumbnails.kept("a b.jpg", &stamp).is_none(), "another photo of the same file name");
        assert!(thumbnails.kept("x/a b.jpg", &ThumbnailStamp::from_photo(&photo, 8).unwrap()).is_none());
        std::fs::write(&photo, "other bytes").unwrap();
        assert!(thumbnails.kept("x/a b.jpg", &ThumbnailStamp::from_photo(&photo, 4).unwrap()).is_none());
    }

    #[test]
    fn a_broken_file_is_as_good_as_none() {
        let project = tempfile::tempdir().unwrap();
        let photo = project.path().join("a.jpg");
        std::fs::write(&photo, "bytes").unwrap();
        let (thumbnails, stamp) =
            (Thumbnails::new(project.path()), ThumbnailStamp::from_photo(&photo, 4).unwrap());
        thumbnails.keep("a.jpg", &stamp, &Picture { width: 2, height: 1, rgba: vec![7; 8] }).unwrap();
        let file = thumbnails.file("a.jpg");
        let bytes = std::fs::read(&file).unwrap();
        std::fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
        assert!(thumbnails.kept("a.jpg", &stamp).is_none());
    }
}
