//! The lines of a text file of cameras, read one at a time.

use std::borrow::Cow;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use super::Objection;
use crate::error::{Error, Result};
use crate::task::Task;

/// The longest line in bytes: a photo with over a million keypoints. A file without line ends must
/// not fill the memory.
const LONGEST_LINE: usize = 64 << 20;

/// The byte order mark that some editors write before the first line.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// The remedy for a text in another encoding.
pub(super) const SAVE_AS_UTF8: &str = "save it as UTF-8 in a text editor";

/// Returns the objection to a text in UTF-16, judged by its first bytes.
pub(super) fn not_utf16(text: &[u8]) -> Option<Objection> {
    // Without a byte order mark, every other byte of ASCII text in UTF-16 is 0.
    let is_utf16 = matches!(text, [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] | [0, 1..=255, ..] | [1..=255, 0, ..]);
    is_utf16.then(|| ("it is text in UTF-16, expected UTF-8".into(), SAVE_AS_UTF8))
}

/// The lines of a file, counted from 1; one at a time in memory.
pub(super) struct LineReader<'a> {
    /// The path of the file.
    pub path: &'a Path,
    reader: BufReader<File>,
    line: Vec<u8>,
    number: u64,
    at: u64,
    size: u64,
}

impl<'a> LineReader<'a> {
    /// Opens the file.
    ///
    /// # Errors
    /// Returns [`Error::Io`].
    pub fn open(path: &'a Path) -> Result<Self> {
        let file = File::open(path).map_err(Error::io(path, "read it"))?;
        let size = file.metadata().map_err(Error::io(path, "read it"))?.len();
        let reader = BufReader::with_capacity(1 << 16, file);
        Ok(Self { path, reader, line: Vec::new(), number: 0, at: 0, size })
    }

    /// Returns the place of the current line for messages.
    pub fn place(&self) -> String {
        format!("line {}", self.number)
    }

    /// Advances to the next line that is neither empty nor a comment; returns false at the end of the file.
    pub fn next_record(&mut self, stage: &'static str, task: &Task) -> Result<bool> {
        loop {
            if self.number.is_multiple_of(1024) {
                task.step(stage, self.at, self.size)?;
            }
            if !self.advance()? {
                return Ok(false);
            }
            if !matches!(self.text().as_bytes().first(), None | Some(b'#')) {
                return Ok(true);
            }
        }
    }

    /// Advances to the next line; returns false, with an empty line, at the end of the file.
    pub fn advance(&mut self) -> Result<bool> {
        self.line.clear();
        let most = LONGEST_LINE as u64 + 1;
        let read = self.reader.by_ref().take(most).read_until(b'\n', &mut self.line);
        let bytes = read.map_err(Error::io(self.path, "read it"))?;
        self.number += 1;
        self.at += bytes as u64;
        if self.number == 1
            && let Some((found, remedy)) = not_utf16(&self.line)
        {
            return Err(Error::input(self.path, "", found, remedy));
        }
        if self.line.len() > LONGEST_LINE {
            let found = format!("a line of more than {} megabytes", LONGEST_LINE >> 20);
            return Err(Error::input(
                self.path,
                self.place(),
                found,
                "check that it is a text file of cameras",
            ));
        }
        Ok(bytes > 0)
    }

    /// Returns the line without surrounding white space; bytes that are not UTF-8 become U+FFFD, which names must not
    /// contain.
    pub fn text(&self) -> Cow<'_, str> {
        let line = self.line.trim_ascii();
        String::from_utf8_lossy(line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(line))
    }
}
