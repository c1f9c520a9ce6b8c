//! Reads brush strokes as JSON files.

use std::path::Path;

use quadratura_base::error::{Error, Result};
use quadratura_document::stroke::Stroke;
use quadratura_files::json::read_json;

const LARGEST_STROKE: u64 = 64 << 20;
const REMEDY: &str = "correct it; docs/formats.md describes brush strokes";

/// Reads a stroke.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] with line and column, or with the field, where the file is not a stroke or describes
/// one that cannot be applied.
pub fn read_stroke(file: &Path) -> Result<Stroke> {
    let stroke: Stroke = read_json(file, LARGEST_STROKE, REMEDY)?;
    match stroke.problem() {
        None => Ok(stroke),
        Some((place, found)) => Err(Error::input(file, place, found, REMEDY)),
    }
}
