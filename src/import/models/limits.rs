//! Limits on model files; larger ones are refused.

use std::path::Path;

use glam::DVec3;

use quadratura_base::error::{Error, Result};

/// Maximum size of a model file, or of a buffer beside it, in bytes. A million faces take about 100 MB.
pub const LARGEST_FILE: u64 = 2_000_000_000;

/// Maximum number of corners of all outlines together, and of vertices; they take about 1.5 GB of memory.
pub const MOST_CORNERS: usize = 30_000_000;

/// Maximum absolute value of a coordinate. Beyond it, squares of areas overflow, and no useful digits are
/// left.
const LARGEST_COORDINATE: f64 = 1e15;

/// Refuses files that are too large.
///
/// # Errors
/// [`Error::Input`] when the file is too large.
pub fn check_file_size(path: &Path, bytes: u64) -> Result<()> {
    if bytes > LARGEST_FILE {
        let found = format!("{bytes} bytes, but at most {LARGEST_FILE} are read");
        return Err(Error::input(path, "", found, COARSER));
    }
    Ok(())
}

/// Refuses too many vertices or corners.
///
/// # Errors
/// [`Error::Input`] when `count` of `what` ("vertices" or "corners") is too large.
pub(super) fn check_count(
    path: &Path,
    place: impl FnOnce() -> String,
    count: usize,
    what: &str,
) -> Result<()> {
    if count > MOST_CORNERS {
        let found = format!("more than {MOST_CORNERS} {what}");
        return Err(Error::input(path, place(), found, COARSER));
    }
    Ok(())
}

/// Refuses coordinates that are not finite or too large.
///
/// # Errors
/// [`Error::Input`] when a coordinate is not a number, infinite, or absurdly large.
pub(super) fn check_position(path: &Path, place: impl FnOnce() -> String, position: DVec3) -> Result<()> {
    if position.is_finite() && position.abs().max_element() <= LARGEST_COORDINATE {
        return Ok(());
    }
    let DVec3 { x, y, z } = position;
    let found = format!("the position {x:?} {y:?} {z:?} is not within 1e15 of the origin");
    Err(Error::input(path, place(), found, "delete or repair this vertex in the modelling program"))
}

const COARSER: &str = "export a coarser model, or a part of it";
