//! Films of frames: animated PNG by ourselves, everything else through ffmpeg.

mod apng;
mod ffmpeg;

use std::path::Path;

use self::apng::Apng;
use self::ffmpeg::Ffmpeg;
use crate::error::{Error, Result};

/// The kinds of films, by the extensions of their files.
pub const EXTENSIONS: [&str; 5] = ["apng", "mp4", "webm", "gif", "webp"];

/// What a film consists of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reel {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Frames a second.
    pub fps: f64,
    /// So many will come.
    pub frames: u32,
}

/// A film that is being written; it takes its place at [`Film::finish`]. Dropped before that, it
/// vanishes.
#[derive(Debug)]
pub struct Film(Kind);

#[derive(Debug)]
enum Kind {
    Apng(Apng),
    Ffmpeg(Ffmpeg),
}

impl Film {
    /// Starts a film; the extension of `file` says of which kind.
    ///
    /// # Errors
    /// [`Error::Request`] for another extension, and where ffmpeg is needed and not there;
    /// [`Error::Io`].
    pub fn create(file: &Path, reel: Reel) -> Result<Self> {
        let extension = kind_of(file)?;
        Ok(Self(match extension {
            "apng" => Kind::Apng(Apng::create(file, reel)?),
            _ => Kind::Ffmpeg(Ffmpeg::start(file, extension, reel)?),
        }))
    }

    /// Adds the next frame: `width * height * 3` bytes, rows from the top, RGB.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Request`] with what ffmpeg said.
    pub fn add(&mut self, rgb: &[u8]) -> Result<()> {
        match &mut self.0 {
            Kind::Apng(film) => film.add(rgb),
            Kind::Ffmpeg(film) => film.add(rgb),
        }
    }

    /// Puts the film in its place, over an old one.
    ///
    /// # Errors
    /// As [`Film::add`].
    pub fn finish(self) -> Result<()> {
        match self.0 {
            Kind::Apng(film) => film.finish(),
            Kind::Ffmpeg(film) => film.finish(),
        }
    }
}

/// The kind of film that a file's name asks for: one of [`EXTENSIONS`].
///
/// # Errors
/// [`Error::Request`] for another one.
pub fn kind_of(file: &Path) -> Result<&'static str> {
    let extension = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    EXTENSIONS.into_iter().find(|known| *known == extension).ok_or_else(|| {
        let known = EXTENSIONS.map(|known| format!(".{known}")).join(", ");
        Error::Request(format!("{}: a film's name ends with one of {known}", file.display()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_says_the_kind_and_another_one_is_refused() {
        assert_eq!(kind_of(Path::new("a/flight.MP4")).unwrap(), "mp4");
        let told = kind_of(Path::new("flight.avi")).unwrap_err().to_string();
        assert!(told.contains("flight.avi") && told.contains(".webm"), "{told}");
        assert!(kind_of(Path::new("flight")).is_err());
    }
}
