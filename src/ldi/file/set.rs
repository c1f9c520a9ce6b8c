//! Reads and writes files of several layered depth images: a first line, then each image as in a file of its own.

use std::io::BufReader;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::defect::FileDefect;
use super::header::LdiHeader;
use super::line::{Line, to_line};
use super::packing::Packing;
use super::read::{AGAIN, PARTIAL, Reading, WholeRows, open_plain};
use super::set_header::{SET_FORMAT, SET_VERSION, SetHeader};
use super::write::{PackedImage, write_all};
use crate::cube::{CubeFace, flaw};
use crate::{Arrangement, Ldi, LdiSet};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;

/// A file of one layered depth image or of several, whose first line was read. The images are read one by one, so that not all
/// need be in memory.
#[derive(Debug)]
pub struct LdiFile {
    path: PathBuf,
    /// How the images belong together.
    pub arrangement: Arrangement,
    /// Where the images are, in bytes from the beginning of the file.
    parts: Vec<Range<u64>>,
    /// The size of the file in bytes.
    length: u64,
}

impl LdiFile {
    /// Reads the first line of a file of one image or of several.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Input`] with what was found and what was expected.
    pub fn open(path: &Path) -> Result<Self> {
        let file = open_plain(path)?;
        let length = file.metadata().map_err(Error::io(path, "read its size"))?.len();
        let line = Line::read(path, BufReader::new(&file), AGAIN)?;
        let path = path.to_path_buf();
        if line.format != SET_FORMAT {
            // Whatever is wrong with it is told when the image is read.
            let parts = std::iter::once(0..u64::MAX).collect();
            return Ok(Self { path, arrangement: Arrangement::Single, parts, length });
        }
        let version = line.version;
        if version != SET_VERSION {
            let found = format!(
                "`version` is {version}; expected {SET_VERSION}: a newer version of quadratura may read it"
            );
            return Err(FileDefect::of_line(found).into_input(&path, AGAIN));
        }
        let header: SetHeader = line.content(&path, AGAIN)?;
        let arrangement = header.check().map_err(|defect| defect.into_input(&path, AGAIN))?;
        let mut at = line.bytes();
        let parts = header.images.iter().map(|image| {
            let from = at;
            at += image.bytes;
            from..at
        });
        let parts = parts.collect();
        Ok(Self { path, arrangement, parts, length })
    }

    /// Returns the number of images.
    pub fn count(&self) -> usize {
        self.parts.len()
    }

    /// Reads the first line of an image.
    ///
    /// # Errors
    /// As [`super::read_ldi_header`]; the place names the image.
    pub fn header(&self, image: usize) -> Result<LdiHeader> {
        self.reading(image).map(Reading::into_header)
    }

    /// Reads an image and checks all of it.
    ///
    /// # Errors
    /// As [`super::read_ldi`]; the place names the image.
    pub fn read(&self, image: usize, task: &Task) -> Result<Ldi> {
        self.reading(image)?.whole(task).map_err(|error| self.placed(error, image))
    }

    /// Reads what is left of an image; see [`super::read_whole_rows`].
    ///
    /// # Errors
    /// As [`super::read_whole_rows`]; the place names the image.
    pub fn read_whole_rows(&self, image: usize, task: &Task) -> Result<(Ldi, WholeRows)> {
        self.reading(image)?.whole_rows(task).map_err(|error| self.placed(error, image))
    }

    /// Checks that the file ends where its last image does, and that the images fit together.
    ///
    /// # Errors
    /// [`Error::Input`].
    pub fn check(&self) -> Result<()> {
        if self.arrangement == Arrangement::Single {
            return Ok(());
        }
        let end = self.parts.last().map_or(0, |part| part.end);
        if self.length != end {
            let (cut, remedy) =
                if self.length < end { ("the file is cut short: ", PARTIAL) } else { ("", AGAIN) };
            let found = format!("{cut}{} bytes; expected {end}", self.length);
            return Err(Error::input(&self.path, "", found, remedy));
        }
        let headers: Vec<LdiHeader> =
            (0..self.count()).map(|image| self.header(image)).collect::<Result<_>>()?;
        let faces: Vec<CubeFace> = headers.iter().map(face).collect();
        self.check_faces(&faces)
    }

    /// Checks that the images that were read fit together, all of them or those that are left.
    ///
    /// # Errors
    /// [`Error::Input`].
    pub fn check_images(&self, images: &[Ldi]) -> Result<()> {
        self.check_faces(&images.iter().map(CubeFace::of).collect::<Vec<_>>())
    }

    fn check_faces(&self, faces: &[CubeFace]) -> Result<()> {
        match flaw(faces).filter(|_| self.arrangement == Arrangement::Cube) {
            Some(found) => {
                Err(Error::input(&self.path, "", format!("the images make no cube: {found}"), AGAIN))
            }
            None => Ok(()),
        }
    }

    fn reading(&self, image: usize) -> Result<Reading> {
        let reading = Reading::open_part(&self.path, self.parts[image].clone());
        reading.map_err(|error| self.placed(error, image))
    }

    /// Names the image in an error about one of several.
    fn placed(&self, error: Error, image: usize) -> Error {
        match error {
            Error::Input { file, place, found, remedy } if self.arrangement != Arrangement::Single => {
                let place = if place.is_empty() { place } else { format!(", {place}") };
                Error::Input { file, place: format!("image {image}{place}"), found, remedy }
            }
            other => other,
        }
    }
}

fn face(header: &LdiHeader) -> CubeFace {
    CubeFace { camera: header.camera.pinhole(), pose: header.camera.pose(), gain: header.gain }
}

/// Reads a file of one layered depth image or of several and checks all of it. The memory that it takes is limited by what the
/// size of the file justifies.
///
/// # Errors
/// [`Error::Io`]; [`Error::Cancelled`]; [`Error::Input`] with the place, what was found and what was expected.
pub fn read_ldi_set(file: &Path, task: &Task) -> Result<LdiSet> {
    let file = LdiFile::open(file)?;
    file.check()?;
    let images = (0..file.count()).map(|image| file.read(image, task)).collect::<Result<_>>()?;
    Ok(LdiSet { arrangement: file.arrangement, images })
}

/// Several layered depth images as they are written, so that only one need be in memory as it is.
pub struct PackedSet {
    arrangement: Arrangement,
    packing: Packing,
    parts: Vec<PackedImage>,
    faces: Vec<CubeFace>,
}

impl PackedSet {
    /// Begins a file of a cube or a set.
    pub fn new(arrangement: Arrangement, packing: Packing) -> Self {
        Self { arrangement, packing, parts: Vec::new(), faces: Vec::new() }
    }

    /// Packs the next image, which is to be written to `file`, and returns the number of bytes.
    ///
    /// # Errors
    /// As [`super::write_ldi`].
    pub fn add(&mut self, file: &Path, ldi: &Ldi) -> Result<u64> {
        let content = PackedImage::of(ldi, self.packing).map_err(|defect| defect.into_request(file))?;
        let bytes = content.bytes();
        self.parts.push(content);
        self.faces.push(CubeFace::of(ldi));
        Ok(bytes)
    }

    /// Writes the file, whole or not at all, and returns the number of bytes.
    ///
    /// # Errors
    /// [`Error::Request`] where the images make no cube, or there is none; [`Error::Io`].
    pub fn write(&self, file: &Path) -> Result<u64> {
        let request = |defect: FileDefect| defect.into_request(file);
        let header = SetHeader::new(self.arrangement, self.parts.iter().map(PackedImage::bytes));
        header.check().map_err(request)?;
        if let Some(found) = flaw(&self.faces).filter(|_| self.arrangement == Arrangement::Cube) {
            return Err(request(FileDefect::at("", found)));
        }
        let line = to_line(&header).map_err(request)?;
        write_all(file, |out| {
            out.write_all(&line)?;
            self.parts.iter().try_for_each(|part| part.write_to(out))
        })?;
        Ok(line.len() as u64 + self.parts.iter().map(PackedImage::bytes).sum::<u64>())
    }
}
