//! Reads Wavefront OBJ files.
//!
//! The project has its own reader, because existing ones cannot distinguish `o` from `g`, read 32-bit floats
//! (which loses half a metre of a site in map coordinates), or give no line numbers for errors.
//!
//! - `o NAME` begins an object; `g NAME` begins one where there is no `o`, and a sub-object `OBJECT/NAME`
//!   inside one. The same name again continues the same object. Faces before any name belong to an object
//!   named after the file. An object without faces is left out.
//! - `v x y z` is read in 64 bits; a weight or colours behind it are ignored, as are `vt`, `vn`, materials,
//!   lines and points. Free-form surfaces are left out with a note.
//! - `f` has any number of corners, `v/vt/vn` in all forms, with indices from 1 or negative from the end,
//!   after the vertices that it uses. Holes are bridged: the outline repeats the bridge's ends.
//! - `\` continues a line, `#` begins a comment; CRLF, a byte order mark and names in any encoding are
//!   accepted.

use std::collections::BTreeMap;
use std::io::{BufRead, Read};
use std::path::Path;

use glam::DVec3;

use super::limits::{check_count, check_position};
use crate::error::{Error, Result};
use crate::scene::builder::says_billboard;
use crate::scene::{ModelBuilder, ObjectId};
use crate::task::Task;

/// Maximum length of a line with its continuations in bytes: a face of a million corners.
const LONGEST_LINE: usize = 8 << 20;

/// Number of lines between two reports of progress.
const LINES_A_STEP: u64 = 1 << 16;

/// Reads an OBJ file of `size` bytes from `input`; `path` is named in errors and gives the object's name
/// where the file has none.
///
/// # Errors
/// [`Error::Input`] with the line; [`Error::Io`]; [`Error::Cancelled`].
pub fn read(
    path: &Path,
    input: impl BufRead,
    size: u64,
    task: &Task,
    notes: &mut Vec<String>,
) -> Result<ModelBuilder> {
    let mut lines = LogicalLines { path, input, number: 0, next_number: 1, bytes: 0 };
    let mut reader = ObjReader::new(path);
    let mut line = Vec::new();
    let mut last_step = 0;
    while lines.next_into(&mut line)? {
        reader.line(lines.number, &line)?;
        if lines.number - last_step >= LINES_A_STEP {
            last_step = lines.number;
            task.step("read the model", lines.bytes, size)?;
        }
    }
    reader.finish(notes)
}

/// A reader of logical lines with the number of the first physical line of each.
struct LogicalLines<'a, R> {
    path: &'a Path,
    input: R,
    number: u64,
    next_number: u64,
    bytes: u64,
}

impl<R: BufRead> LogicalLines<'_, R> {
    /// Reads the next logical line into `line`; false at the end of the file.
    fn next_into(&mut self, line: &mut Vec<u8>) -> Result<bool> {
        line.clear();
        self.number = self.next_number;
        loop {
            let room = (LONGEST_LINE + 1).saturating_sub(line.len()) as u64;
            let read = (&mut self.input).take(room).read_until(b'\n', line);
            let read = read.map_err(Error::io(self.path, "read it"))?;
            if read == 0 {
                return Ok(!line.is_empty());
            }
            self.bytes += read as u64;
            if line.len() > LONGEST_LINE {
                let found = format!("a line of more than {LONGEST_LINE} bytes");
                return Err(Error::input(self.path, format!("line {}", self.number), found, NO_OBJ));
            }
            self.next_number += 1;
            while line.last().is_some_and(|b| matches!(b, b'\n' | b'\r')) {
                line.pop();
            }
            if line.last() != Some(&b'\\') {
                return Ok(true);
            }
            *line.last_mut().expect("it ends in a backslash") = b' ';
        }
    }
}

const NO_OBJ: &str = "check that it is an OBJ file, or export the model again";

struct ObjReader<'a> {
    path: &'a Path,
    builder: ModelBuilder,
    /// The name after the last `o`.
    object: Option<String>,
    /// The name after the last `g`.
    group: Option<String>,
    billboard_material: bool,
    /// The object of the next face; created when the face is read.
    current: Option<ObjectId>,
    ring: Vec<u32>,
    /// Statements that are left out, by keyword: their number and the first line.
    left_out: BTreeMap<String, (u64, u64)>,
}

impl<'a> ObjReader<'a> {
    fn new(path: &'a Path) -> Self {
        Self {
            path,
            builder: ModelBuilder::new(),
            object: None,
            group: None,
            billboard_material: false,
            current: None,
            ring: Vec::new(),
            left_out: BTreeMap::new(),
        }
    }

    fn line(&mut self, number: u64, line: &[u8]) -> Result<()> {
        let line = if number == 1 { line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line) } else { line };
        let line = line.split(|&b| b == b'#').next().unwrap_or_default();
        let mut words =
            line.split(|b| matches!(b, b' ' | b'\t' | b'\x0b' | b'\x0c')).filter(|w| !w.is_empty());
        match words.next() {
            None => {}
            Some(b"v") => self.vertex(number, words)?,
            Some(b"f" | b"fo") => self.face(number, words)?,
            Some(b"o") => (self.object, self.group, self.current) = (name(words), None, None),
            Some(b"g") => (self.group, self.current) = (name(words), None),
            Some(b"usemtl") => {
                self.billboard_material = name(words).is_some_and(|name| says_billboard(&name));
                self.current = None;
            }
            Some(b"vt" | b"vn" | b"s" | b"mtllib" | b"l" | b"p" | b"lod" | b"usemap" | b"maplib") => {}
            Some(other) => self.leave_out(number, other),
        }
        Ok(())
    }

    /// Adds the vertex of a `v` statement in line `line_number`; words after the third coordinate are ignored.
    fn vertex<'b>(&mut self, line_number: u64, mut words: impl Iterator<Item = &'b [u8]>) -> Result<()> {
        let mut position = [0.0; 3];
        for value in &mut position {
            let word = words.next().ok_or_else(|| {
                self.error(
                    line_number,
                    "a vertex with fewer than three coordinates",
                    "export the model again",
                )
            })?;
            let parsed = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
            *value = parsed.ok_or_else(|| {
                let found = format!("`{}` where a coordinate should be", printable(word));
                self.error(line_number, found, "write numbers with a point, as in 1.5 or -2e3")
            })?;
        }
        let position = DVec3::from_array(position);
        check_position(self.path, || format!("line {line_number}"), position)?;
        let vertex = self.builder.vertex(position);
        check_count(self.path, || format!("line {line_number}"), vertex as usize + 1, "vertices")
    }

    fn face<'b>(&mut self, number: u64, words: impl Iterator<Item = &'b [u8]>) -> Result<()> {
        let mut ring = std::mem::take(&mut self.ring);
        ring.clear();
        for word in words {
            ring.push(self.corner(number, word)?);
        }
        let object = self.current_object();
        self.builder.face(object, &ring);
        self.ring = ring;
        check_count(self.path, || format!("line {number}"), self.builder.corner_count(), "corners")
    }

    /// Parses a corner (`7`, `7/1`, `7//2`, `7/1/2` or `-1`) and returns the index of its vertex.
    fn corner(&self, number: u64, word: &[u8]) -> Result<u32> {
        let vertex = word.split(|&b| b == b'/').next().unwrap_or_default();
        let index: Option<i64> = std::str::from_utf8(vertex).ok().and_then(|text| text.parse().ok());
        let count = self.builder.vertices().len() as i64;
        let Some(index) = index.filter(|&index| index != 0) else {
            let found = format!("`{}` where the number of a vertex should be", printable(word));
            return Err(self.error(number, found, "count vertices from 1, or from the end with -1"));
        };
        let vertex_index = if index > 0 { index - 1 } else { count.saturating_add(index) };
        if !(0..count).contains(&vertex_index) {
            let found =
                format!("a face names vertex {}, but only {count} were read so far", printable(vertex));
            return Err(self.error(number, found, "export the model again, vertices before faces"));
        }
        Ok(vertex_index as u32)
    }

    fn current_object(&mut self) -> ObjectId {
        if let Some(known) = self.current {
            return known;
        }
        let name = match (&self.object, &self.group) {
            (Some(object), Some(group)) => format!("{object}/{group}"),
            (Some(name), None) | (None, Some(name)) => name.clone(),
            (None, None) => self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        };
        let id = self.builder.object(&name);
        if self.billboard_material {
            self.builder.mark_billboard(id);
        }
        self.current = Some(id);
        id
    }

    /// Counts a statement that is left out. A file that is not OBJ has only unknown statements; a few
    /// keywords are enough.
    fn leave_out(&mut self, number: u64, keyword: &[u8]) {
        let keyword = printable(keyword);
        if self.left_out.len() < KEYWORDS_REMEMBERED || self.left_out.contains_key(&keyword) {
            self.left_out.entry(keyword).or_insert((0, number)).0 += 1;
        }
    }

    fn finish(self, notes: &mut Vec<String>) -> Result<ModelBuilder> {
        if self.builder.corner_count() == 0 {
            let found = format!("no faces among {} vertices", self.builder.vertices().len());
            return Err(Error::input(self.path, "", found, NO_OBJ));
        }
        for (keyword, (count, line)) in &self.left_out {
            notes.push(format!("`{keyword}` is left out ({count} times, first in line {line})"));
        }
        Ok(self.builder)
    }

    fn error(&self, number: u64, found: impl Into<String>, remedy: &str) -> Error {
        Error::input(self.path, format!("line {number}"), found, remedy)
    }
}

/// Number of unknown keywords that are reported.
const KEYWORDS_REMEMBERED: usize = 8;

/// Joins the rest of a line to a name; `None` when it is empty.
fn name<'b>(words: impl Iterator<Item = &'b [u8]>) -> Option<String> {
    let words: Vec<_> = words.map(String::from_utf8_lossy).collect();
    (!words.is_empty()).then(|| words.join(" "))
}

/// Returns a piece of the file for a message, without control characters and cut to 40 bytes.
fn printable(word: &[u8]) -> String {
    String::from_utf8_lossy(&word[..word.len().min(40)])
        .chars()
        .map(|c| if c.is_control() { '?' } else { c })
        .collect()
}

#[cfg(test)]
mod tests;
