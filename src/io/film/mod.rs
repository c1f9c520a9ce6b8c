//! Writes videos: animated PNG by this program, everything else through ffmpeg.

mod apng;
mod ffmpeg;

use std::path::Path;

use self::apng::Apng;
use self::ffmpeg::Ffmpeg;
use quadratura_base::error::{Error, Result};

/// The kinds of videos, by the extensions of their files.
pub const EXTENSIONS: [&str; 5] = ["apng", "mp4", "webm", "gif", "webp"];

/// Size, rate and length of a video.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VideoFormat {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Frames per second.
    pub fps: f64,
    /// Number of frames.
    pub frames: u32,
}

/// A video that is being written. [`Film::finish`] puts it in place; dropped before that, it vanishes.
#[derive(Debug)]
pub struct Film(VideoKind);

#[derive(Debug)]
enum VideoKind {
    Apng(Apng),
    Ffmpeg(Ffmpeg),
}

impl Film {
    /// Starts a video; the extension of `file` decides its kind.
    ///
    /// # Errors
    /// [`Error::Request`] for an unknown extension, and where ffmpeg is needed and not installed;
    /// [`Error::Io`].
    pub fn create(file: &Path, reel: VideoFormat) -> Result<Self> {
        let extension = kind_of(file)?;
        Ok(Self(match extension {
            "apng" => VideoKind::Apng(Apng::create(file, reel)?),
            _ => VideoKind::Ffmpeg(Ffmpeg::start(file, extension, reel)?),
        }))
    }

    /// Adds the next frame: `width * height * 3` bytes, rows from the top, RGB.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Request`] with ffmpeg's message.
    pub fn add(&mut self, rgb: &[u8]) -> Result<()> {
        match &mut self.0 {
            VideoKind::Apng(film) => film.add(rgb),
            VideoKind::Ffmpeg(film) => film.add(rgb),
        }
    }

    /// Puts the video in place and replaces an old one.
    ///
    /// # Errors
    /// As [`Film::add`].
    pub fn finish(self) -> Result<()> {
        match self.0 {
            VideoKind::Apng(film) => film.finish(),
            VideoKind::Ffmpeg(film) => film.finish(),
        }
    }
}

/// Checks that a video of this name can be made, before its pictures are.
///
/// # Errors
/// [`Error::Request`] for an unknown extension, and where ffmpeg is needed and not installed; [`Error::Io`].
pub fn check(file: &Path) -> Result<()> {
    match kind_of(file)? {
        "apng" => Ok(()),
        _ => ffmpeg::check(file),
    }
}

/// Returns the kind of video for a file's name: one of [`EXTENSIONS`].
///
/// # Errors
/// [`Error::Request`] for an unknown extension.
pub fn kind_of(file: &Path) -> Result<&'static str> {
    let extension = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    EXTENSIONS.into_iter().find(|known| *known == extension).ok_or_else(|| {
        let known = EXTENSIONS.map(|known| format!(".{known}")).join(", ");
        Error::Request(format!("{}: the extension of a video file is one of {known}", file.display()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_says_the_kind_and_another_one_is_refused() {
        assert_eq!(kind_of(Path::new("a/flight.MP4")).unwrap(), "mp4");
        let message = kind_of(Path::new("flight.avi")).unwrap_err().to_string();
        assert!(message.contains("flight.avi") && message.contains(".webm"), "{message}");
        assert!(kind_of(Path::new("flight")).is_err());
    }
}
