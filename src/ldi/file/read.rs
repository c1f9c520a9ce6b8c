//! Reads the file of a layered depth image, whole or what is left of it.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::chunk_pixels::ChunkPixels;
use super::defect::{CheckResult, FileDefect};
use super::hash::short_hash;
use super::header::{CHUNK_ROWS, ChunkEntry, LdiCamera, LdiHeader, LevelEntry};
use super::line::read_line;
use super::packing::Packing;
use super::prediction::LevelPlanes;
use super::streams::{self, ChunkShape};
use crate::levels::{half_camera, pyramid, surfaces_at};
use crate::{Ldi, LdiKind, LdiSurface, ResolutionLevel};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;

/// The remedy for a file that is damaged.
pub(super) const AGAIN: &str = "make it again with `quadratura ldi build`, or get an intact copy";

/// The remedy for a file of which some rows are whole.
pub(super) const PARTIAL: &str = "make it again with `quadratura ldi build`, get an intact copy, \
    or show the rows that are whole with `quadratura ldi render --partial`";

/// The number of chunks that are in memory as bytes at a time, a few for each thread.
const CHUNKS_AT_A_TIME: usize = 32;

/// Opens a file. What is no plain file, as a pipe, is refused: opening it may wait for ever.
///
/// # Errors
/// [`Error::Io`], [`Error::Input`].
pub(super) fn open_plain(path: &Path) -> Result<File> {
    let metadata = std::fs::metadata(path).map_err(Error::io(path, "open it"))?;
    if !metadata.is_file() {
        let found = if metadata.is_dir() { "it is a folder" } else { "it is no plain file" };
        return Err(Error::input(path, "", found, "give a file that `quadratura ldi build` wrote"));
    }
    File::open(path).map_err(Error::io(path, "open it"))
}

/// How many rows of a file could be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WholeRows {
    /// The number of rows of the first level that are whole; the others have no depth pixels.
    pub whole: u32,
    /// The number of rows of the frame.
    pub height: u32,
}

impl WholeRows {
    /// Returns true when no row is missing.
    pub fn are_all(self) -> bool {
        self.whole == self.height
    }
}

/// An image in a file, whose first line was read.
pub(super) struct Reading {
    path: PathBuf,
    file: File,
    header: LdiHeader,
    surfaces: Vec<LdiSurface>,
    /// Where the first line ends and the chunks begin, in bytes from the beginning of the file.
    start: u64,
    /// Where the image ends, in bytes from the beginning of the file, or the file where it is cut short.
    end: u64,
}

/// Reads the first line of a file, which is checked, and none of its chunks.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] with what was found and what was expected.
pub fn read_ldi_header(file: &Path) -> Result<LdiHeader> {
    Ok(Reading::open(file)?.into_header())
}

/// Returns whether the first line of a file can be read and the file is as long as that says.
pub fn has_whole_length(file: &Path) -> bool {
    Reading::open(file).is_ok_and(|reading| reading.check_length().is_ok())
}

/// Reads a layered depth image and checks all of it. The memory that it takes is limited by what the size of the file
/// justifies.
///
/// # Errors
/// [`Error::Io`]; [`Error::Cancelled`]; [`Error::Input`] with the place, what was found and what was expected. Where the
/// file is cut short, it says how many rows are whole.
pub fn read_ldi(file: &Path, task: &Task) -> Result<Ldi> {
    Reading::open(file)?.whole(task)
}

/// Reads one level of a layered depth image and checks it; of the rest of the file it reads the first line alone. The result is
/// an image of its own, whose frame is the level's, with its coarser levels; it does not say where the photo is in the frame.
/// Where the file has fewer levels, it is the coarsest one.
///
/// # Errors
/// Those of [`read_ldi`].
pub fn read_ldi_level(file: &Path, index: usize, task: &Task) -> Result<Ldi> {
    Reading::open(file)?.one_level(index, task)
}

/// Reads what is left of a layered depth image whose file is cut short or damaged, with the number of its rows that are
/// whole. Rows of chunks that are not whole have no depth pixels; the levels are made again from those that are.
///
/// # Errors
/// [`Error::Io`]; [`Error::Cancelled`]; [`Error::Input`] where the first line is not whole.
pub fn read_whole_rows(file: &Path, task: &Task) -> Result<(Ldi, WholeRows)> {
    Reading::open(file)?.whole_rows(task)
}

impl Reading {
    fn open(path: &Path) -> Result<Self> {
        Self::open_part(path, 0..u64::MAX)
    }

    /// Opens the image in a part of a file, in bytes from its beginning.
    pub(super) fn open_part(path: &Path, part: Range<u64>) -> Result<Self> {
        let mut file = open_plain(path)?;
        let length = file.metadata().map_err(Error::io(path, "read its size"))?.len();
        let end = part.end.min(length);
        file.seek(SeekFrom::Start(part.start)).map_err(Error::io(path, "read it"))?;
        let of_part = BufReader::new((&file).take(end.saturating_sub(part.start)));
        let (header, bytes) = read_line(path, of_part, AGAIN)?;
        let surfaces = header.ldi_surfaces();
        let start = part.start + bytes;
        Ok(Self { path: path.to_path_buf(), file, header, surfaces, start, end })
    }

    /// Returns the first line.
    pub(super) fn into_header(self) -> LdiHeader {
        self.header
    }

    /// Reads all of the image.
    pub(super) fn whole(self, task: &Task) -> Result<Ldi> {
        self.check_length()?;
        let mut levels = Vec::new();
        for index in 0..self.header.levels.len() {
            let refuse = |_, defect: FileDefect| Err(defect.into_input(&self.path, PARTIAL));
            let (level, _) = self.level(index, task, refuse)?;
            levels.push(level);
        }
        Ok(self.into_ldi(levels))
    }

    /// Reads one level as an image of its own.
    fn one_level(mut self, index: usize, task: &Task) -> Result<Ldi> {
        self.check_length()?;
        let index = index.min(self.header.levels.len() - 1);
        let refuse = |_, defect: FileDefect| Err(defect.into_input(&self.path, AGAIN));
        let (level, _) = self.level(index, task, refuse)?;
        self.header.camera = LdiCamera::of(&level.camera, &self.header.camera.pose());
        self.header.photo_rect = None;
        self.surfaces = surfaces_at(&self.surfaces, f64::from(1u32 << index));
        Ok(self.into_ldi(vec![level]))
    }

    /// Reads what is left of the image.
    pub(super) fn whole_rows(self, task: &Task) -> Result<(Ldi, WholeRows)> {
        let height = self.header.camera.height;
        let (first, missing) = self.level(0, task, |_, _| Ok(()))?;
        let mut levels = vec![first];
        let mut lost = missing;
        for index in 1..self.header.levels.len() {
            let (level, missing) = self.level(index, task, |_, _| Ok(()))?;
            levels.push(level);
            lost += missing;
        }
        if lost > 0 {
            levels.truncate(1);
        }
        Ok((self.into_ldi(levels), WholeRows { whole: height - missing, height }))
    }

    /// Checks that the image ends where its last chunk does.
    fn check_length(&self) -> Result<()> {
        let bytes = self.end - self.start;
        // The first line was checked, so this is a number; nothing else is longer than any file.
        let expected = self.header.chunk_bytes().unwrap_or(u64::MAX);
        if bytes > expected {
            let found = format!("{bytes} bytes after the first line; expected {expected}");
            return Err(Error::input(&self.path, "", found, AGAIN));
        }
        if bytes < expected {
            let (whole, height) = (self.rows_within_length(), self.header.camera.height);
            let found = format!(
                "the file is cut short: {bytes} bytes after the first line; expected {expected}; \
                 {whole} of {height} rows are whole"
            );
            return Err(Error::input(&self.path, "", found, PARTIAL));
        }
        Ok(())
    }

    /// Returns the number of rows of the first level whose chunks are within the file's length.
    fn rows_within_length(&self) -> u32 {
        let level = &self.header.levels[0];
        let mut left = self.end - self.start;
        let within = level.chunks.iter().take_while(|chunk| {
            let whole = chunk.bytes <= left;
            left -= chunk.bytes.min(left);
            whole
        });
        (within.count() as u32 * CHUNK_ROWS).min(level.height)
    }

    /// Reads a level, with the number of rows that are missing: those of chunks for whose defect `missing` gives no error.
    fn level(
        &self,
        index: usize,
        task: &Task,
        mut missing: impl FnMut(usize, FileDefect) -> Result<()>,
    ) -> Result<(ResolutionLevel, u32)> {
        let entry = &self.header.levels[index];
        let mut level = self.empty_level(index);
        let mut at = self.start + chunk_bytes(&self.header.levels[..index]);
        let mut lost = 0;
        for first in (0..entry.chunks.len()).step_by(CHUNKS_AT_A_TIME) {
            let mut batch = Vec::new();
            for chunk in &entry.chunks[first..entry.chunks.len().min(first + CHUNKS_AT_A_TIME)] {
                task.check_cancelled()?;
                batch.push(self.load(at, chunk.bytes)?);
                at += chunk.bytes;
            }
            let read = batch
                .par_iter()
                .enumerate()
                .map(|(i, bytes)| self.chunk_pixels(index, first + i, bytes.as_deref()));
            for (i, pixels) in read.collect::<Vec<_>>().into_iter().enumerate() {
                match pixels {
                    Ok(pixels) => pixels.add_to(&mut level),
                    Err(defect) => {
                        missing(first + i, defect)?;
                        let rows = entry.rows_of(first + i);
                        level.rows.extend(std::iter::repeat_n(level.len() as u32, rows as usize));
                        lost += rows;
                    }
                }
            }
        }
        Ok((level.finished(), lost))
    }

    /// Returns a level without rows. It has room for those that it will have where the file is long enough for them.
    fn empty_level(&self, index: usize) -> ResolutionLevel {
        let mut cameras =
            std::iter::successors(Some(self.header.camera.pinhole()), |camera| Some(half_camera(camera)));
        let camera = cameras.nth(index).expect("there is a half of every camera");
        let mut level = ResolutionLevel::without_rows(camera);
        let entry = &self.header.levels[index];
        if chunk_bytes(std::slice::from_ref(entry)) <= self.end - self.start {
            let depth_pixels = entry.depth_pixels as usize;
            level.columns.reserve_exact(depth_pixels);
            level.inverse_depths.reserve_exact(depth_pixels);
            level.colours.reserve_exact(depth_pixels);
            level.surfaces.reserve_exact(depth_pixels);
            level.splats.reserve_exact(depth_pixels);
        }
        level
    }

    /// Reads bytes of the file; `None` where it ends before them.
    fn load(&self, at: u64, bytes: u64) -> Result<Option<Vec<u8>>> {
        if at.checked_add(bytes).is_none_or(|end| end > self.end) {
            return Ok(None);
        }
        let mut content = vec![0; bytes as usize];
        let mut file = &self.file;
        let read = file.seek(SeekFrom::Start(at)).and_then(|_| file.read_exact(&mut content));
        read.map_err(Error::io(&self.path, "read it"))?;
        Ok(Some(content))
    }

    /// Returns a chunk of a level, checked; `bytes` are `None` where the file ends before it.
    fn chunk_pixels(&self, level: usize, index: usize, bytes: Option<&[u8]>) -> CheckResult<ChunkPixels> {
        let entry = &self.header.levels[level];
        let first_row = index as u32 * CHUNK_ROWS;
        let rows = entry.rows_of(index);
        let place = format!("level {level}, rows {first_row} to {}", first_row + rows - 1);
        let bytes = bytes.ok_or_else(|| FileDefect::at(&place, "the file ends before them"))?;
        let chunk = &entry.chunks[index];
        let shape = ChunkShape { first_row, rows, width: entry.width, depth_pixels: chunk.depth_pixels };
        let planes = LevelPlanes { surfaces: &self.surfaces, pixel_size: f64::from(1u32 << level) };
        let pixels = unpacked(bytes, chunk, shape, self.header.packing, &planes);
        pixels.map_err(|found| FileDefect::at(place, found))
    }

    /// Returns the layered depth image of its levels; of the first one alone, the others are made.
    fn into_ldi(self, mut levels: Vec<ResolutionLevel>) -> Ldi {
        let Self { header, surfaces, .. } = self;
        if levels.len() == 1 {
            levels = levels.pop().map_or_else(Vec::new, |first| pyramid(first, &surfaces));
        }
        let kind = LdiKind::ALL.into_iter().find(|kind| kind.name() == header.kind);
        Ldi {
            kind: kind.expect("the first line was checked"),
            camera: header.camera.pinhole(),
            pose: header.camera.pose(),
            inputs: header.inputs,
            photo_rect: header.photo_rect,
            gain: header.gain,
            surfaces,
            sources: header.sources,
            levels,
            report: header.report.report,
        }
    }
}

/// Returns the size of the chunks of levels in bytes; the first line was checked, so it is a number.
fn chunk_bytes(levels: &[LevelEntry]) -> u64 {
    levels.iter().flat_map(|level| &level.chunks).map(|chunk| chunk.bytes).sum()
}

/// Returns the chunk that bytes hold, all of it checked.
fn unpacked(
    bytes: &[u8],
    chunk: &ChunkEntry,
    shape: ChunkShape,
    packing: Packing,
    planes: &LevelPlanes,
) -> Result<ChunkPixels, String> {
    let hash = short_hash(bytes);
    if hash != chunk.hash {
        return Err(format!(
            "the content has the hash {hash}; expected {}: it was changed or damaged",
            chunk.hash
        ));
    }
    let pixels = streams::from_bytes(bytes, shape, packing, planes)?;
    pixels.check(planes.surfaces.len())?;
    let (near, far) = pixels.near_and_far();
    if (near, far) != (chunk.near, chunk.far) {
        let expected = format!("{} to {}", chunk.far, chunk.near);
        return Err(format!("inverse depths from {far} to {near}; expected {expected}"));
    }
    Ok(pixels)
}
