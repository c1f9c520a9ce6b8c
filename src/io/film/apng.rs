//! Writes animated PNG, which every browser shows and which needs no other program.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use png::{BitDepth, ColorType, Compression, Encoder, Writer};

use super::VideoFormat;
use quadratura_base::error::{Error, Result};
use quadratura_files::atomic::AtomicFile;
use quadratura_files::png_error::io_error;

/// The number of plays that stands for an endless loop.
const ENDLESS: u32 = 0;

/// An animated PNG that is being written.
pub(super) struct Apng {
    file: AtomicFile,
    target: PathBuf,
    writer: Writer<BufWriter<File>>,
}

impl std::fmt::Debug for Apng {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Apng").field("target", &self.target).finish_non_exhaustive()
    }
}

impl Apng {
    /// Starts writing an animated PNG.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn create(target: &Path, reel: VideoFormat) -> Result<Self> {
        let mut file = AtomicFile::create(target)?;
        let out = file.file().try_clone().map_err(Error::io(target, "write it"))?;
        let writer = begun(out, reel).map_err(|error| cannot_encode(target, error))?;
        Ok(Self { file, target: target.to_path_buf(), writer })
    }

    /// Adds a frame: RGB, 8 bits, rows from the top.
    pub fn add(&mut self, rgb: &[u8]) -> Result<()> {
        self.writer.write_image_data(rgb).map_err(|error| cannot_encode(&self.target, error))
    }

    /// Puts the file in place.
    pub fn finish(self) -> Result<()> {
        self.writer.finish().map_err(|error| cannot_encode(&self.target, error))?;
        self.file.commit()
    }
}

fn begun(out: File, reel: VideoFormat) -> std::result::Result<Writer<BufWriter<File>>, png::EncodingError> {
    let mut encoder = Encoder::new(BufWriter::new(out), reel.width, reel.height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Balanced);
    encoder.set_animated(reel.frames, ENDLESS)?;
    let (numerator, denominator) = delay(reel.fps);
    encoder.set_frame_delay(numerator, denominator)?;
    encoder.write_header()
}

/// Returns the seconds between frames as a fraction of two 16-bit numbers.
fn delay(fps: f64) -> (u16, u16) {
    // Whole rates are exact, others are rounded to a thousandth of a second.
    if fps.fract() == 0.0 && fps <= 65_535.0 {
        (1, fps as u16)
    } else {
        ((1000.0 / fps).round().clamp(1.0, 65_535.0) as u16, 1000)
    }
}

fn cannot_encode(target: &Path, error: png::EncodingError) -> Error {
    Error::io(target, "write it")(io_error(error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_back_in_their_order() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("flight.apng");
        let reel = VideoFormat { width: 4, height: 3, fps: 12.0, frames: 3 };
        let mut film = Apng::create(&target, reel).unwrap();
        (0..3u8).for_each(|shade| film.add(&[shade * 40; 36]).unwrap());
        assert!(!target.exists(), "unfinished films have no place");
        film.finish().unwrap();
        let file = std::io::BufReader::new(File::open(&target).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 3);
        for shade in 0..3u8 {
            let mut pixels = [0; 36];
            reader.next_frame(&mut pixels).unwrap();
            assert_eq!(pixels, [shade * 40; 36]);
            let control = reader.info().frame_control().unwrap();
            assert_eq!((control.delay_num, control.delay_den), (1, 12));
        }
    }

    #[test]
    fn a_film_that_is_given_up_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let reel = VideoFormat { width: 1, height: 1, fps: 29.97, frames: 2 };
        let mut film = Apng::create(&folder.path().join("flight.apng"), reel).unwrap();
        film.add(&[1, 2, 3]).unwrap();
        drop(film);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        assert_eq!(delay(29.97), (33, 1000));
    }
}
