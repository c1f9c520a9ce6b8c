//! Writes the file of a layered depth image.

use std::io::Write;
use std::path::Path;

use rayon::prelude::*;

use super::check::check;
use super::chunk_pixels::ChunkPixels;
use super::defect::{CheckResult, FileDefect, ensure};
use super::hash::short_hash;
use super::header::{CHUNK_ROWS, ChunkEntry, LdiHeader};
use super::line::to_line;
use super::packing::Packing;
use super::prediction::LevelPlanes;
use super::streams;
use crate::layout::LONGEST_SIDE;
use crate::levels::half_camera;
use crate::{Ldi, LdiSurface, ResolutionLevel};
use quadratura_base::error::{Error, Result};
use quadratura_files::atomic::write_atomically_with;

/// A chunk as it is written, with what the first line says of it.
type WrittenChunk = (ChunkEntry, Vec<u8>);

/// Writes a layered depth image, whole or not at all, and returns the number of bytes. Packed files have the first level
/// alone, of which readers make the others: they would be a quarter of the file. The bytes depend on the content
/// alone. The folder is made if it is missing.
///
/// # Errors
/// [`Error::Request`] where the content breaks a rule of the layout, or has more than 255 depth pixels at one position;
/// [`Error::Io`].
pub fn write_ldi(file: &Path, ldi: &Ldi, packing: Packing) -> Result<u64> {
    let content = PackedImage::of(ldi, packing).map_err(|defect| defect.into_request(file))?;
    write_all(file, |out| content.write_to(out))?;
    Ok(content.bytes())
}

/// Writes a file whole or not at all, in a folder that is made if it is missing.
pub(super) fn write_all(
    file: &Path,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<()> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    write_atomically_with(file, |out| write(out))
}

/// An image as bytes: its first line and its chunks.
pub(super) struct PackedImage {
    line: Vec<u8>,
    chunks: Vec<Vec<u8>>,
}

impl PackedImage {
    /// Packs an image.
    pub fn of(ldi: &Ldi, packing: Packing) -> CheckResult<Self> {
        check_levels(ldi)?;
        let levels = match packing {
            Packing::None => &ldi.levels[..],
            Packing::Deflate => &ldi.levels[..ldi.levels.len().min(1)],
        };
        let chunks = levels.iter().enumerate();
        let chunks = chunks.map(|(index, level)| to_chunks(index, level, &ldi.surfaces, packing));
        let chunks = chunks.collect::<CheckResult<Vec<_>>>()?;
        let entries = chunks.iter().map(|level| level.iter().map(|(entry, _)| entry.clone()).collect());
        let header = LdiHeader::of(ldi, packing, entries.collect());
        check(&header)?;
        let line = to_line(&header)?;
        Ok(Self { line, chunks: chunks.into_iter().flatten().map(|(_, bytes)| bytes).collect() })
    }

    /// Returns its size in bytes.
    pub fn bytes(&self) -> u64 {
        self.line.len() as u64 + self.chunks.iter().map(|chunk| chunk.len() as u64).sum::<u64>()
    }

    /// Writes it.
    pub fn write_to(&self, out: &mut dyn Write) -> std::io::Result<()> {
        out.write_all(&self.line)?;
        self.chunks.iter().try_for_each(|bytes| out.write_all(bytes))
    }
}

/// Checks that the arrays have the sizes that they need to be cut into chunks.
fn check_levels(ldi: &Ldi) -> CheckResult {
    let mut camera = ldi.camera;
    for (index, level) in ldi.levels.iter().enumerate() {
        let sides = 1..=LONGEST_SIDE;
        ensure(sides.contains(&level.camera.width) && sides.contains(&level.camera.height), || {
            let found = format!("{} x {} pixels", level.camera.width, level.camera.height);
            FileDefect::at(place(index), format!("{found}; expected sides of 1 to {LONGEST_SIDE}"))
        })?;
        ensure(level.camera == camera, || {
            FileDefect::at(
                place(index),
                "its camera is not the one of half the resolution of the level before",
            )
        })?;
        ensure(has_layout(level), || FileDefect::at(place(index), "its arrays do not fit together"))?;
        camera = half_camera(&camera);
    }
    Ok(())
}

fn has_layout(level: &ResolutionLevel) -> bool {
    let ResolutionLevel { camera, rows, columns, inverse_depths, colours, surfaces, splats, .. } = level;
    let sizes = [inverse_depths.len(), colours.len(), surfaces.len(), splats.len()];
    let in_row = |row: &[u32]| {
        let columns = &columns[row[0] as usize..row[1] as usize];
        columns.is_sorted() && columns.last().is_none_or(|last| u32::from(*last) < camera.width)
    };
    sizes.iter().all(|size| *size == columns.len())
        && rows.len() == camera.height as usize + 1
        && rows[0] == 0
        && rows[camera.height as usize] as usize == columns.len()
        && rows.is_sorted()
        && rows.windows(2).all(in_row)
}

fn place(level: usize) -> String {
    format!("level {level}")
}

fn to_chunks(
    index: usize,
    level: &ResolutionLevel,
    surfaces: &[LdiSurface],
    packing: Packing,
) -> CheckResult<Vec<WrittenChunk>> {
    let planes = LevelPlanes { surfaces, pixel_size: f64::from(1u32 << index) };
    let chunks = level.camera.height.div_ceil(CHUNK_ROWS) as usize;
    let chunks: Vec<_> =
        (0..chunks).into_par_iter().map(|chunk| to_chunk(level, chunk, packing, &planes)).collect();
    // In order, so that the same defect is reported for any number of threads.
    chunks.into_iter().collect::<Result<_, String>>().map_err(|found| FileDefect::at(place(index), found))
}

fn to_chunk(
    level: &ResolutionLevel,
    index: usize,
    packing: Packing,
    planes: &LevelPlanes,
) -> Result<WrittenChunk, String> {
    let pixels = ChunkPixels::of(level, index);
    pixels.check(planes.surfaces.len())?;
    let bytes = streams::to_bytes(&pixels, level.camera.width, packing, planes)?;
    let (near, far) = pixels.near_and_far();
    let entry = ChunkEntry {
        bytes: bytes.len() as u64,
        depth_pixels: pixels.surfaces.len() as u64,
        near,
        far,
        hash: short_hash(&bytes),
    };
    Ok((entry, bytes))
}
