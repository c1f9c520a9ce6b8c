//! Reads Wavefront OBJ files.
//!
//! The project has its own reader, because existing ones cannot distinguish `o` from `g`, read 32-bit floats
//! (which loses half a metre of a site in map coordinates), or give no line numbers for errors.
//!
//! - The first word of a line is its keyword, which decides how the rest is read. A line that begins with `#` is a comment.
//! - `o NAME` begins an object; `g NAME` begins one where there is no `o`, and a sub-object `OBJECT/NAME`
//!   inside one. The same name again continues the same object. Faces before any name belong to an object
//!   named after the file. An object without faces is left out.
//! - A name is the rest of its line, whatever that holds: `#`, a backslash at the end, bytes of any encoding. Names are the same
//!   when their bytes are (`names`).
//! - `v x y z` is read in 64 bits; a weight or colours behind it are ignored, as are `vt`, `vn`, materials,
//!   lines and points. Free-form surfaces are left out with a note.
//! - `f` has any number of corners, `v/vt/vn` in all forms, with indices from 1 or negative from the end,
//!   after the vertices that it uses. Holes are bridged: the outline repeats the bridge's ends.
//! - In a statement of numbers, and only there, `\` at the end continues the line, and a word that begins with `#` begins a
//!   comment, which ends with its line.
//! - Lines end with LF, CR LF or CR.

mod object_names;

use std::collections::BTreeMap;
use std::io::BufRead;
use std::path::Path;

use glam::DVec3;

use self::object_names::ObjectNames;
use super::limits::{check_count, check_position};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::builder::says_billboard;
use quadratura_base::scene::{ModelBuilder, ObjectId};
use quadratura_base::task::Task;
use quadratura_files::text::{BYTE_ORDER_MARK, Lines, is_no_number, not_utf16};

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
    let mut statements = StatementReader { path, lines: Lines::new(input), number: 0 };
    let mut reader = ObjReader::new(path);
    let mut statement = Vec::new();
    let mut last_step = 0;
    while statements.next_into(&mut statement)? {
        reader.statement(statements.number, &statement)?;
        if statements.number - last_step >= LINES_A_STEP {
            last_step = statements.number;
            task.step("read the model", statements.lines.bytes, size)?;
        }
    }
    reader.finish(notes)
}

/// A reader of statements with the number of the first line of each.
struct StatementReader<'a, R> {
    path: &'a Path,
    lines: Lines<R>,
    number: u64,
}

impl<R: BufRead> StatementReader<'_, R> {
    /// Reads the next statement into `statement`, with the lines that continue it and without comments behind numbers; false at
    /// the end of the file.
    fn next_into(&mut self, statement: &mut Vec<u8>) -> Result<bool> {
        statement.clear();
        if !self.append_line(statement)? {
            return Ok(false);
        }
        self.number = self.lines.number;
        if self.number == 1 {
            if let Some((found, remedy)) = not_utf16(statement) {
                return Err(Error::input(self.path, "", found, remedy));
            }
            if statement.starts_with(BYTE_ORDER_MARK) {
                statement.drain(..BYTE_ORDER_MARK.len());
            }
        }
        if !is_of_numbers(keyword_and_rest(statement).0) {
            return Ok(true);
        }
        let mut line = 0;
        loop {
            let length = length_without_comment(&statement[line..]);
            statement.truncate(line + length);
            if statement[line..].last() != Some(&b'\\') {
                return Ok(true);
            }
            *statement.last_mut().expect("it ends in a backslash") = b' ';
            line = statement.len();
            if !self.append_line(statement)? {
                return Ok(true);
            }
        }
    }

    fn append_line(&mut self, statement: &mut Vec<u8>) -> Result<bool> {
        let read = self.lines.append_next(statement, LONGEST_LINE);
        let is_there = read.map_err(Error::io(self.path, "read it"))?;
        if statement.len() > LONGEST_LINE {
            let found = format!("a line of more than {LONGEST_LINE} bytes");
            return Err(Error::input(self.path, format!("line {}", self.lines.number), found, NO_OBJ));
        }
        Ok(is_there)
    }
}

/// The keywords of statements that consist of numbers: of vertices, elements, and free-form curves and surfaces.
const OF_NUMBERS: [&[u8]; 24] = [
    b"v", b"vt", b"vn", b"vp", b"f", b"fo", b"l", b"p", b"s", b"deg", b"bmat", b"step", b"curv", b"curv2",
    b"surf", b"parm", b"trim", b"hole", b"scrv", b"sp", b"con", b"bzp", b"bsp", b"res",
];

fn is_of_numbers(keyword: &[u8]) -> bool {
    OF_NUMBERS.contains(&keyword)
}

/// Divides a line into its first word and what is behind it, without white space around.
fn keyword_and_rest(line: &[u8]) -> (&[u8], &[u8]) {
    let line = trimmed(line);
    let end = line.iter().position(is_space).unwrap_or(line.len());
    let (keyword, rest) = line.split_at(end);
    (keyword, trimmed(rest))
}

fn is_space(byte: &u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\x0b' | b'\x0c')
}

fn trimmed(mut bytes: &[u8]) -> &[u8] {
    while let [first, rest @ ..] = bytes
        && is_space(first)
    {
        bytes = rest;
    }
    while let [rest @ .., last] = bytes
        && is_space(last)
    {
        bytes = rest;
    }
    bytes
}

fn words(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    bytes.split(is_space).filter(|word| !word.is_empty())
}

/// Returns the length of a line of numbers up to its comment, which begins with a word, without white space at its end.
fn length_without_comment(line: &[u8]) -> usize {
    let is_first = |at: &usize| *at == 0 || is_space(&line[at - 1]);
    let comment = (0..line.len()).find(|at| line[*at] == b'#' && is_first(at));
    let rest = &line[..comment.unwrap_or(line.len())];
    rest.iter().rposition(|byte| !is_space(byte)).map_or(0, |last| last + 1)
}

const NO_OBJ: &str = "check that it is an OBJ file, or export the model again";

struct ObjReader<'a> {
    path: &'a Path,
    builder: ModelBuilder,
    names: ObjectNames,
    /// The name after the last `o`.
    object: Option<Vec<u8>>,
    /// The name after the last `g`.
    group: Option<Vec<u8>>,
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
            names: ObjectNames::default(),
            object: None,
            group: None,
            billboard_material: false,
            current: None,
            ring: Vec::new(),
            left_out: BTreeMap::new(),
        }
    }

    fn statement(&mut self, number: u64, statement: &[u8]) -> Result<()> {
        let (keyword, rest) = keyword_and_rest(statement);
        match keyword {
            b"" | [b'#', ..] => {}
            b"v" => self.vertex(number, words(rest))?,
            b"f" | b"fo" => self.face(number, words(rest))?,
            b"o" => (self.object, self.group, self.current) = (name(rest), None, None),
            b"g" => (self.group, self.current) = (name(rest), None),
            b"usemtl" => {
                self.billboard_material = says_billboard(&String::from_utf8_lossy(rest));
                self.current = None;
            }
            b"vt" | b"vn" | b"s" | b"mtllib" | b"l" | b"p" | b"lod" | b"usemap" | b"maplib" => {}
            other => self.leave_out(number, other),
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
            *value = self.coordinate(line_number, word)?;
        }
        let position = DVec3::from_array(position);
        check_position(self.path, || format!("line {line_number}"), position)?;
        let vertex = self.builder.vertex(position);
        check_count(self.path, || format!("line {line_number}"), vertex as usize + 1, "vertices")
    }

    fn coordinate(&self, number: u64, word: &[u8]) -> Result<f64> {
        if is_no_number(word) {
            let found = format!("`{}` where a coordinate should be, which is no number", printable(word));
            return Err(self.error(number, found, "delete or repair this vertex in the modelling program"));
        }
        let parsed = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
        parsed.ok_or_else(|| {
            let found = format!("`{}` where a coordinate should be", printable(word));
            self.error(number, found, "write numbers with a point, as in 1.5 or -2e3")
        })
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
            (Some(object), Some(group)) => [&object[..], b"/", group].concat(),
            (Some(name), None) | (None, Some(name)) => name.clone(),
            (None, None) => {
                self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned().into_bytes()
            }
        };
        let id = self.names.object(name, &mut self.builder);
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

    fn finish(mut self, notes: &mut Vec<String>) -> Result<ModelBuilder> {
        if self.builder.corner_count() == 0 {
            let strange = self.left_out.iter().min_by_key(|(_, (_, line))| *line);
            let strange = strange.map_or_else(String::new, |(keyword, (_, line))| {
                format!("; `{keyword}` in line {line} is no statement that is read")
            });
            let found = format!("no faces among {} vertices{strange}", self.builder.vertices().len());
            return Err(Error::input(self.path, "", found, NO_OBJ));
        }
        for (keyword, (count, line)) in &self.left_out {
            notes.push(format!("`{keyword}` is left out ({count} times, first in line {line})"));
        }
        notes.extend(self.names.show(&mut self.builder));
        Ok(self.builder)
    }

    fn error(&self, number: u64, found: impl Into<String>, remedy: &str) -> Error {
        Error::input(self.path, format!("line {number}"), found, remedy)
    }
}

/// Number of unknown keywords that are reported.
const KEYWORDS_REMEMBERED: usize = 8;

/// Returns the name that the rest of a line is; `None` when it is empty.
fn name(rest: &[u8]) -> Option<Vec<u8>> {
    (!rest.is_empty()).then(|| rest.to_vec())
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
