//! The first line as text: JSON, whose last field is a hash of everything before it, and spaces up to the line feed.

use std::io::BufRead;
use std::path::Path;

use serde::Deserialize;

use super::check::{check, check_format};
use super::fault::{Checked, Fault, ensure};
use super::header::LdiHeader;
use super::short_hash;
use crate::error::{Error, Result};
use crate::io::json::parse_json;

/// The size of the longest first line, with its line feed, in bytes.
pub(super) const LONGEST_LINE: usize = 16 << 20;

/// The chunks start at a multiple of this many bytes, and so does each of their streams.
pub(super) const ALIGNMENT: usize = 8;

/// What every version of the format says.
#[derive(Deserialize)]
struct Probe {
    format: String,
    version: u32,
}

/// Returns the last field, after which only the closing bracket follows.
fn last_field(before: &[u8]) -> String {
    format!(",\"line_hash\":\"{}\"}}", short_hash(before))
}

/// Returns the first line with its line feed.
pub(super) fn to_line(header: &LdiHeader) -> Checked<Vec<u8>> {
    let mut line = serde_json::to_vec(header).expect("plain data is JSON");
    line.pop();
    let last = last_field(&line);
    line.extend_from_slice(last.as_bytes());
    line.resize((line.len() + 1).next_multiple_of(ALIGNMENT) - 1, b' ');
    line.push(b'\n');
    ensure(line.len() <= LONGEST_LINE, || Fault::of_line(too_long()))?;
    Ok(line)
}

/// Reads the first line and checks it; returns it with its size in bytes.
pub(super) fn read_line(file: &Path, from: impl BufRead, remedy: &str) -> Result<(LdiHeader, u64)> {
    let mut line = Vec::new();
    let mut from = from.take(LONGEST_LINE as u64);
    from.read_until(b'\n', &mut line).map_err(Error::io(file, "read it"))?;
    if line.pop_if(|last| *last == b'\n').is_none() {
        let found = if line.len() >= LONGEST_LINE {
            too_long()
        } else {
            format!("the file ends after {} bytes, within its first line", line.len())
        };
        return Err(Fault::of_line(found).into_input(file, remedy));
    }
    if !line.starts_with(b"{") {
        let found = "the file is no layered depth image, which would begin with a line of JSON";
        return Err(Error::input(file, "", found, "give a file that `quadratura ldi build` made"));
    }
    let probe: Probe = parse_json(file, &line, remedy)?;
    let input = |fault: Fault| fault.into_input(file, remedy);
    check_format(&probe.format, probe.version).map_err(input)?;
    check_hash(&line).map_err(input)?;
    let header = parse_json(file, &line, remedy)?;
    check(&header).map_err(input)?;
    Ok((header, line.len() as u64 + 1))
}

fn check_hash(line: &[u8]) -> Checked {
    let text = line.trim_ascii_end();
    let (before, last) = text.split_at(text.len().saturating_sub(last_field(&[]).len()));
    ensure((line.len() + 1).is_multiple_of(ALIGNMENT), || {
        Fault::of_line(format!("it has {} bytes; expected a multiple of {ALIGNMENT}", line.len() + 1))
    })?;
    ensure(last_field(before).as_bytes() == last, || {
        Fault::of_line(
            "its content is not the one that its `line_hash` was made of; it was changed or damaged",
        )
    })
}

fn too_long() -> String {
    format!("it has more than {LONGEST_LINE} bytes; expected that many at most")
}
