//! A layered depth image as a cloud of points: PLY, binary, little-endian, in world coordinates (see `docs/formats.md`).
//!
//! Coordinates are 64-bit floats: in a georeferenced world, millions of units from its origin, 32 bits would round points to
//! half a unit, and an origin in a comment is read by no program.

use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::spacing::normal_of;
use crate::{Ldi, ResolutionLevel};
use quadratura_base::error::{Error, Result};
use quadratura_files::atomic::AtomicFile;
use quadratura_files::free_path::free_path;
use quadratura_files::hash::Hashing;

/// The bytes of a point.
const POINT: usize = 3 * 8 + 4 + 3 * 4 + 2 + 2;

/// The rows that are in memory as bytes at a time.
const ROWS_AT_A_TIME: u32 = 64;

/// The beginning of the comment with the hash of the file.
const HASH: &str = "comment quadratura ";

/// The digits of that hash; the file is hashed with zeros in their place.
const DIGITS: usize = 64;

/// A PLY file that was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenPly {
    /// The file.
    pub file: PathBuf,
    /// Files that have the name, were changed or made by others, and were therefore kept.
    pub spared: Vec<PathBuf>,
    /// The number of points.
    pub points: u64,
    /// The depth pixels that are infinitely far away, which are no points.
    pub at_infinity: u64,
    /// The size of the file in bytes.
    pub bytes: u64,
}

/// Writes the depth pixels of the first level as points, whole or not at all, in reading order and at a position nearest first.
/// Where the name is taken by anything but an unchanged file of this program, it gets the next free one: `NAME-2.ply` and so
/// on. The folder is made if it is missing. The bytes depend on the content alone.
///
/// # Errors
/// [`Error::Io`].
pub fn write_ply(file: &Path, ldi: &Ldi) -> Result<WrittenPly> {
    let level = &ldi.levels[0];
    let points = level.inverse_depths.iter().filter(|depth| **depth > 0.0).count() as u64;
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    let free = free_path(file, |path| is_unchanged(path).unwrap_or(false));
    let mut atomic = AtomicFile::create(&free.path)?;
    let failed = |error| Error::io(&free.path, "write it")(error);
    let bytes = write(atomic.file(), ldi, points).map_err(failed)?;
    atomic.commit()?;
    let at_infinity = level.len() as u64 - points;
    Ok(WrittenPly { file: free.path, spared: free.spared, points, at_infinity, bytes })
}

/// Returns the header.
fn header(ldi: &Ldi, points: u64, hash: &str) -> String {
    let left_out = ldi.levels[0].len() as u64 - points;
    let sources = ldi.sources.iter().map(|source| format!("comment source {}\n", one_line(source)));
    let properties = [
        "double x",
        "double y",
        "double z",
        "uchar red",
        "uchar green",
        "uchar blue",
        "uchar alpha",
        "float nx",
        "float ny",
        "float nz",
        "ushort layer",
        "ushort surface",
    ];
    let properties: String = properties.iter().map(|property| format!("property {property}\n")).collect();
    format!(
        "ply\nformat binary_little_endian 1.0\n{HASH}{hash}\n{}\
         comment {left_out} depth pixels infinitely far away are left out\n\
         comment a normal of 0 0 0 is unknown; layer 0 is the nearest\n\
         element vertex {points}\n{properties}end_header\n",
        sources.collect::<String>()
    )
}

/// Returns a name without what would end its line.
fn one_line(name: &str) -> String {
    name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// Writes the file, and then its hash into its header; returns its size in bytes.
fn write(file: &mut File, ldi: &Ldi, points: u64) -> std::io::Result<u64> {
    let level = &ldi.levels[0];
    let normals: Vec<DVec3> = ldi.surfaces.iter().map(|surface| world_normal(ldi, surface)).collect();
    let zeros = header(ldi, points, &"0".repeat(DIGITS));
    let mut hashing = Hashing::default();
    let mut out = BufWriter::new(&mut *file);
    let mut add = |bytes: &[u8]| {
        hashing.extend(bytes);
        out.write_all(bytes)
    };
    add(zeros.as_bytes())?;
    for first in (0..level.camera.height).step_by(ROWS_AT_A_TIME as usize) {
        let rows = first..level.camera.height.min(first + ROWS_AT_A_TIME);
        let rows: Vec<Vec<u8>> = rows.into_par_iter().map(|y| row(ldi, level, y, &normals)).collect();
        rows.iter().try_for_each(|row| add(row))?;
    }
    out.flush()?;
    drop(out);
    file.seek(SeekFrom::Start(0))?;
    file.write_all(header(ldi, points, &hashing.hash()).as_bytes())?;
    Ok(zeros.len() as u64 + points * POINT as u64)
}

/// Returns the unit normal of a surface in the world, towards the camera; 0 for what is infinitely far away.
fn world_normal(ldi: &Ldi, surface: &crate::LdiSurface) -> DVec3 {
    match surface.nu == DVec3::ZERO {
        true => DVec3::ZERO,
        false => ldi.pose.rotation.transpose() * normal_of(surface, &ldi.camera),
    }
}

/// Returns the points of a row.
fn row(ldi: &Ldi, level: &ResolutionLevel, y: u32, normals: &[DVec3]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for pixels in level.layered_pixels(y) {
        for (layer, index) in (0u16..).zip(pixels) {
            let pixel = level.pixel(index);
            if pixel.inverse_depth <= 0.0 {
                continue;
            }
            let centre = DVec2::new(f64::from(level.columns[index]) + 0.5, f64::from(y) + 0.5);
            let in_camera = ldi.camera.ray_in_camera(centre) / f64::from(pixel.inverse_depth);
            let normal =
                usize::from(pixel.surface).checked_sub(1).map_or(DVec3::ZERO, |index| normals[index]);
            let point = ldi.pose.world_from_camera(in_camera).to_array();
            bytes.extend(point.iter().flat_map(|value| value.to_le_bytes()));
            bytes.extend(pixel.colour);
            bytes.extend(normal.to_array().iter().flat_map(|value| (*value as f32).to_le_bytes()));
            bytes.extend(layer.to_le_bytes());
            bytes.extend(pixel.surface.to_le_bytes());
        }
    }
    bytes
}

/// Returns whether a file has the hash that its header tells, so that this program wrote it and nobody changed it; `None` where
/// that cannot be determined.
fn is_unchanged(path: &Path) -> Option<bool> {
    const START: &[u8] = b"ply\nformat binary_little_endian 1.0\n";
    let mut file = BufReader::new(File::open(path).ok()?);
    let mut start = vec![0; START.len() + HASH.len() + DIGITS];
    file.read_exact(&mut start).ok()?;
    let digits = start.split_off(START.len() + HASH.len());
    if start != [START, HASH.as_bytes()].concat() {
        return None;
    }
    let mut hashing = Hashing::default();
    hashing.extend(&start);
    hashing.extend(&[b'0'; DIGITS]);
    let mut piece = vec![0; 1 << 20];
    loop {
        match file.read(&mut piece).ok()? {
            0 => return Some(hashing.hash().as_bytes() == digits),
            read => hashing.extend(&piece[..read]),
        }
    }
}

#[cfg(test)]
mod tests;
