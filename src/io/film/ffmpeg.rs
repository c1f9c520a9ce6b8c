//! Writes videos with ffmpeg, which reads the frames from its standard input.

use std::io::{ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use super::VideoFormat;
use quadratura_base::error::{Error, Result};
use quadratura_files::atomic::AtomicFile;

/// Encoder options for each kind of file: small, and playable everywhere.
const ENCODERS: [(&str, &[&str]); 4] = [
    // 4:2:0 chroma subsampling needs even sides.
    ("mp4", &["-vf", EVEN, "-pix_fmt", "yuv420p", "-crf", "18", "-movflags", "+faststart"]),
    ("webm", &["-vf", EVEN, "-pix_fmt", "yuv420p", "-crf", "24", "-b:v", "0"]),
    ("gif", &["-filter_complex", "split[a][b];[a]palettegen[p];[b][p]paletteuse", "-loop", "0"]),
    ("webp", &["-c:v", "libwebp_anim", "-quality", "80", "-loop", "0"]),
];
const EVEN: &str = "crop=trunc(iw/2)*2:trunc(ih/2)*2";

/// Limit on the part of ffmpeg's output that messages quote, in bytes.
const LONGEST_WORDS: usize = 1000;

/// A running ffmpeg.
#[derive(Debug)]
pub(super) struct Ffmpeg {
    child: Child,
    /// The file that ffmpeg writes; `None` once it is finished.
    file: Option<AtomicFile>,
    /// The file with ffmpeg's error output. It is not a pipe, because ffmpeg would block on a pipe that is
    /// not read.
    messages: std::fs::File,
    target: PathBuf,
}

impl Ffmpeg {
    /// Starts ffmpeg.
    ///
    /// # Errors
    /// [`Error::Request`] when ffmpeg is not installed; [`Error::Io`].
    pub fn start(target: &Path, kind: &str, reel: VideoFormat) -> Result<Self> {
        let file = AtomicFile::create(target)?;
        let messages = tempfile::tempfile().map_err(Error::io(target, "write what ffmpeg says"))?;
        let errors = messages.try_clone().map_err(Error::io(target, "write what ffmpeg says"))?;
        let mut command = command(file.path(), kind, reel);
        let child = command.stderr(errors).spawn().map_err(|error| not_started(target, error))?;
        Ok(Self { child, file: Some(file), messages, target: target.to_path_buf() })
    }

    /// Adds a frame: RGB, 8 bits, rows from the top.
    pub fn add(&mut self, rgb: &[u8]) -> Result<()> {
        let pipe = self.child.stdin.as_mut().expect("it was started with a pipe, which finish() takes");
        // A broken pipe means that ffmpeg has ended; its own message says more.
        pipe.write_all(rgb).map_err(|_| self.refused())
    }

    /// Waits until ffmpeg is done and puts the file in place.
    pub fn finish(mut self) -> Result<()> {
        drop(self.child.stdin.take());
        let status = self.child.wait().map_err(Error::io(&self.target, "wait for ffmpeg"))?;
        if !status.success() {
            return Err(self.refused());
        }
        // ffmpeg has written into the file that was created here, so its name still belongs to it.
        self.file.take().expect("only this takes it, and takes self").commit()
    }

    /// Returns the error with ffmpeg's own message.
    fn refused(&mut self) -> Error {
        // The message is complete once the process has ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
        let mut message = String::new();
        let read = self.messages.rewind().and_then(|()| self.messages.read_to_string(&mut message));
        let message = if read.is_ok() { message.trim() } else { "" };
        let from = message.len().saturating_sub(LONGEST_WORDS);
        let end = message.get(from..).unwrap_or(message);
        Error::Request(format!("{}: ffmpeg could not write the video: {end}", self.target.display()))
    }
}

impl Drop for Ffmpeg {
    fn drop(&mut self) {
        // The process may have ended before, which is no error.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Checks that ffmpeg can be started, for a video of this name.
///
/// # Errors
/// As [`Ffmpeg::start`].
pub fn check(target: &Path) -> Result<()> {
    let mut command = Command::new("ffmpeg");
    command.arg("-version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().map(|_| ()).map_err(|error| not_started(target, error))
}

fn command(file: &Path, kind: &str, reel: VideoFormat) -> Command {
    let mut command = Command::new("ffmpeg");
    let size = format!("{}x{}", reel.width, reel.height);
    command.args(["-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"]).args([
        "-video_size",
        &size,
        "-framerate",
        &reel.fps.to_string(),
        "-i",
        "-",
    ]);
    for (_, options) in ENCODERS.iter().filter(|(name, _)| *name == kind) {
        command.args(*options);
    }
    command.args(["-f", kind]).arg(file).stdin(Stdio::piped()).stdout(Stdio::null());
    command
}

fn not_started(target: &Path, error: std::io::Error) -> Error {
    if error.kind() != ErrorKind::NotFound {
        return Error::io(target, "start ffmpeg for it")(error);
    }
    Error::Request(format!(
        "{}: this kind of video needs ffmpeg, which is not installed; install it, or use the extension .apng, \
         which needs no other program",
        target.display()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    const REEL: VideoFormat = VideoFormat { width: 33, height: 17, fps: 10.0, frames: 3 };

    /// Returns `None` where ffmpeg is not installed; then only the message about it is tested.
    fn film(folder: &Path, kind: &str) -> Option<Ffmpeg> {
        match Ffmpeg::start(&folder.join(format!("flight.{kind}")), kind, REEL) {
            Ok(film) => Some(film),
            Err(error) => {
                assert!(error.to_string().contains(".apng"), "{error}");
                None
            }
        }
    }

    #[test]
    fn films_of_every_kind_are_whole_or_not_there() {
        for (kind, begin) in
            [("mp4", &b"ftyp"[..]), ("gif", b"GIF8"), ("webp", b"RIFF"), ("webm", b"\x1a\x45")]
        {
            let folder = tempfile::tempdir().unwrap();
            let Some(mut film) = film(folder.path(), kind) else { return };
            for shade in 0..3u8 {
                film.add(&[shade * 60; 33 * 17 * 3]).unwrap();
            }
            match film.finish() {
                Ok(()) => {
                    let bytes = std::fs::read(folder.path().join(format!("flight.{kind}"))).unwrap();
                    assert!(
                        bytes[..12].windows(begin.len()).any(|w| w == begin),
                        "{kind}: {:?}",
                        &bytes[..12]
                    );
                }
                // An ffmpeg without this encoder says so.
                Err(error) => assert!(error.to_string().contains("ncoder"), "{kind}: {error}"),
            }
            assert!(std::fs::read_dir(folder.path()).unwrap().count() <= 1, "nothing else is left");
        }
    }

    #[test]
    fn a_film_that_is_given_up_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let Some(mut film) = film(folder.path(), "mp4") else { return };
        film.add(&[0; 33 * 17 * 3]).unwrap();
        drop(film);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
