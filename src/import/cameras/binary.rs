//! Reads COLMAP's binary files: little-endian, each a count followed by that many records.
//!
//! Counts are never trusted: memory is reserved only for what the rest of the file can hold.

use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::path::Path;

use super::assembly::Assembly;
use super::colmap_model::{ColmapModel, MODELS};
use super::photo_name::LONGEST_NAME;
use super::pose::pose_of_quaternion;
use super::raw::RawImage;
use super::reconstruction::ReconstructionFiles;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;

/// COLMAP's id for a keypoint without a point.
const NO_POINT: u64 = u64::MAX;

/// Reads all files into `assembly`.
pub(super) fn read(files: &ReconstructionFiles, assembly: &mut Assembly, task: &Task) -> Result<()> {
    let mut cameras = Records::open(&files.cameras)?;
    for done in 0..cameras.count(24)? {
        task.step("read cameras", done, cameras.total)?;
        read_camera(&mut cameras, assembly)?;
    }
    assembly.some_cameras()?;
    let mut images = Records::open(&files.images)?;
    for done in 0..images.count(73)? {
        task.step("read poses", done, images.total)?;
        read_image(&mut images, assembly)?;
    }
    if let Some(points) = &files.points {
        let mut points = Records::open(points)?;
        for done in 0..points.count(51)? {
            if done % 1024 == 0 {
                task.step("read points", done, points.total)?;
            }
            read_point(&mut points, assembly)?;
        }
    }
    Ok(())
}

fn read_camera(file: &mut Records<'_>, assembly: &mut Assembly) -> Result<()> {
    let place = file.place();
    let (id, number) = (file.u32()?, file.u32()? as i32);
    let (width, height) = (file.u64()?, file.u64()?);
    let model = ColmapModel::by_number(number).ok_or_else(|| {
        // The number of parameters is unknown, so nothing behind this camera can be read.
        let found = format!("camera model {number}; known models are 0 to {}", MODELS.len() - 1);
        Error::input(file.path, place.clone(), found, "use one of COLMAP's models, or check the file")
    })?;
    let mut parameters = [0.0; 16];
    let parameters = &mut parameters[..model.parameter_count()];
    for value in parameters.iter_mut() {
        *value = file.f64()?;
    }
    assembly.camera(place, id, model.camera(width, height, parameters));
    Ok(())
}

fn read_image(file: &mut Records<'_>, assembly: &mut Assembly) -> Result<()> {
    let place = file.place();
    let id = file.u32()?;
    let quaternion = [file.f64()?, file.f64()?, file.f64()?, file.f64()?];
    let translation = [file.f64()?, file.f64()?, file.f64()?];
    let camera = file.u32()?;
    let name = file.name()?;
    let mut observations = Vec::new();
    for _ in 0..file.count(24)? {
        let at = [file.f64()?, file.f64()?];
        let point = file.u64()?;
        if point != NO_POINT {
            observations.push((at, point));
        }
    }
    let name = &String::from_utf8_lossy(&name);
    let pose = pose_of_quaternion(quaternion, translation);
    assembly.image(place, RawImage { id, pose, camera, name, observations });
    Ok(())
}

fn read_point(file: &mut Records<'_>, assembly: &mut Assembly) -> Result<()> {
    let place = file.place();
    let id = file.u64()?;
    let position = [file.f64()?, file.f64()?, file.f64()?];
    file.skip(3 + 8)?; // colour and error
    // The keypoints of the images already hold the tracks.
    let track = file.count(8)?;
    file.skip(8 * track)?;
    assembly.point(place, id, position);
    Ok(())
}

/// A reader of records that keeps track of its position.
pub(super) struct Records<'a> {
    path: &'a Path,
    reader: BufReader<File>,
    at: u64,
    size: u64,
    /// The last count read, in records.
    total: u64,
}

impl<'a> Records<'a> {
    /// Opens a file.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn open(path: &'a Path) -> Result<Self> {
        let file = File::open(path).map_err(Error::io(path, "read it"))?;
        let size = file.metadata().map_err(Error::io(path, "read it"))?.len();
        Ok(Self { path, reader: BufReader::with_capacity(1 << 16, file), at: 0, size, total: 0 })
    }

    /// Returns the position for messages.
    pub fn place(&self) -> String {
        format!("byte {}", self.at)
    }

    /// Reads a count of records of at least `smallest` bytes each, and checks it against the rest of the
    /// file.
    pub fn count(&mut self, smallest: u64) -> Result<u64> {
        let place = self.place();
        let count = self.u64()?;
        let room = (self.size - self.at.min(self.size)) / smallest;
        if count > room {
            let found = format!("{count} records announced, but the rest of the file holds at most {room}");
            return Err(Error::input(
                self.path,
                place,
                found,
                "copy the file again; it is cut short or damaged",
            ));
        }
        self.total = count;
        Ok(count)
    }

    fn bytes<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut bytes = [0; N];
        self.reader.read_exact(&mut bytes).map_err(|error| self.ended(error))?;
        self.at += N as u64;
        Ok(bytes)
    }

    /// Returns the last count that was read.
    pub fn total(&self) -> u64 {
        self.total
    }

    pub fn u8(&mut self) -> Result<u8> {
        Ok(u8::from_le_bytes(self.bytes()?))
    }

    pub fn u32(&mut self) -> Result<u32> {
        Ok(u32::from_le_bytes(self.bytes()?))
    }

    pub fn u64(&mut self) -> Result<u64> {
        Ok(u64::from_le_bytes(self.bytes()?))
    }

    pub fn f64(&mut self) -> Result<f64> {
        Ok(f64::from_le_bytes(self.bytes()?))
    }

    /// Reads a zero-terminated name and returns its bytes without the zero.
    fn name(&mut self) -> Result<Vec<u8>> {
        let mut name = Vec::new();
        let place = self.place();
        let most = LONGEST_NAME as u64 + 2;
        self.reader.by_ref().take(most).read_until(0, &mut name).map_err(|error| self.ended(error))?;
        self.at += name.len() as u64;
        if name.pop() != Some(0) {
            let found = format!("a name that does not end within {LONGEST_NAME} bytes");
            return Err(Error::input(
                self.path,
                place,
                found,
                "copy the file again; it is cut short or damaged",
            ));
        }
        Ok(name)
    }

    fn skip(&mut self, bytes: u64) -> Result<()> {
        self.reader.seek_relative(bytes as i64).map_err(|error| self.ended(error))?;
        self.at += bytes;
        Ok(())
    }

    fn ended(&self, error: std::io::Error) -> Error {
        if error.kind() != ErrorKind::UnexpectedEof {
            return Error::io(self.path, "read it")(error);
        }
        let found = format!("the file ends at byte {} within a record", self.size);
        Error::input(self.path, self.place(), found, "copy the file again; it is cut short or damaged")
    }
}
