//! The first line as text: JSON, whose last field is a hash of everything before it, and spaces up to the line feed.

use std::io::BufRead;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::check::{check, check_format};
use super::defect::{CheckResult, FileDefect, ensure};
use super::hash::short_hash;
use super::header::{ALIGNMENT, LdiHeader};
use super::set_header::SET_FORMAT;
use quadratura_base::error::{Error, Result};
use quadratura_files::json::parse_json;

/// The size of the longest first line, with its line feed, in bytes.
pub(super) const LONGEST_LINE: usize = 16 << 20;

/// What every version of the format says.
#[derive(Deserialize)]
struct FormatAndVersion {
    format: String,
    version: u32,
}

/// Returns the last field, after which only the closing bracket follows.
fn last_field(before: &[u8]) -> String {
    format!(",\"line_hash\":\"{}\"}}", short_hash(before))
}

/// Returns the first line with its line feed.
pub(super) fn to_line(header: &impl Serialize) -> CheckResult<Vec<u8>> {
    let mut line = serde_json::to_vec(header).expect("plain data is JSON");
    line.pop();
    let last = last_field(&line);
    line.extend_from_slice(last.as_bytes());
    line.resize((line.len() + 1).next_multiple_of(ALIGNMENT) - 1, b' ');
    line.push(b'\n');
    ensure(line.len() <= LONGEST_LINE, || FileDefect::of_line(too_long()))?;
    Ok(line)
}

/// The format and the version that a first line says it has, with the line itself, without its line feed.
pub(super) struct Line {
    pub text: Vec<u8>,
    pub format: String,
    pub version: u32,
}

impl Line {
    /// Reads a first line, of which nothing but its format and version is known yet.
    pub fn read(file: &Path, from: impl BufRead, remedy: &str) -> Result<Self> {
        let mut text = Vec::new();
        let mut from = from.take(LONGEST_LINE as u64);
        from.read_until(b'\n', &mut text).map_err(Error::io(file, "read it"))?;
        if text.pop_if(|last| *last == b'\n').is_none() {
            let found = if text.len() >= LONGEST_LINE {
                too_long()
            } else {
                format!("the file ends after {} bytes, within its first line", text.len())
            };
            return Err(FileDefect::of_line(found).into_input(file, remedy));
        }
        if !text.starts_with(b"{") {
            let found = "the file is no layered depth image, which would begin with a line of JSON";
            return Err(Error::input(file, "", found, "give a file that `quadratura ldi build` made"));
        }
        let FormatAndVersion { format, version } = parse_json(file, &text, remedy)?;
        Ok(Self { text, format, version })
    }

    /// Returns its size in bytes, with its line feed.
    pub fn bytes(&self) -> u64 {
        self.text.len() as u64 + 1
    }

    /// Returns what it says, once its hash was checked.
    pub fn content<T: serde::de::DeserializeOwned>(&self, file: &Path, remedy: &str) -> Result<T> {
        check_hash(&self.text).map_err(|defect| defect.into_input(file, remedy))?;
        parse_json(file, &self.text, remedy)
    }
}

/// Reads the first line of a single image and checks it; returns it with its size in bytes.
pub(super) fn read_line(file: &Path, from: impl BufRead, remedy: &str) -> Result<(LdiHeader, u64)> {
    let line = Line::read(file, from, remedy)?;
    if line.format == SET_FORMAT {
        let found = "the file holds several layered depth images, a cube or a set; expected a single one";
        let remedy = "give a file of one image; `quadratura ldi render` and `ldi info` take both";
        return Err(Error::input(file, "", found, remedy));
    }
    let input = |defect: FileDefect| defect.into_input(file, remedy);
    check_format(&line.format, line.version).map_err(input)?;
    let header = line.content(file, remedy)?;
    check(&header).map_err(input)?;
    Ok((header, line.bytes()))
}

fn check_hash(line: &[u8]) -> CheckResult {
    let text = line.trim_ascii_end();
    let (before, last) = text.split_at(text.len().saturating_sub(last_field(&[]).len()));
    ensure((line.len() + 1).is_multiple_of(ALIGNMENT), || {
        FileDefect::of_line(format!("it has {} bytes; expected a multiple of {ALIGNMENT}", line.len() + 1))
    })?;
    ensure(last_field(before).as_bytes() == last, || {
        FileDefect::of_line(
            "its content is not the one that its `line_hash` was made of; it was changed or damaged",
        )
    })
}

fn too_long() -> String {
    format!("it has more than {LONGEST_LINE} bytes; expected that many at most")
}
