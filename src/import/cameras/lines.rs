//! The lines of a text file of cameras, read one at a time.

use std::borrow::Cow;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_files::text::{BYTE_ORDER_MARK, Lines, not_utf16};

/// The longest line in bytes: a photo with over a million keypoints. A file without line ends must
/// not fill the memory.
const LONGEST_LINE: usize = 64 << 20;

/// The lines of a file, counted from 1; one at a time in memory.
pub(super) struct LineReader<'a> {
    /// The path of the file.
    pub path: &'a Path,
    lines: Lines<BufReader<File>>,
    line: Vec<u8>,
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
        let lines = Lines::new(BufReader::with_capacity(1 << 16, file));
        Ok(Self { path, lines, line: Vec::new(), size })
    }

    /// Returns the place of the current line for messages.
    pub fn place(&self) -> String {
        format!("line {}", self.lines.number)
    }

    /// Advances to the next line that is neither empty nor a comment; returns false at the end of the file.
    pub fn next_record(&mut self, stage: &'static str, task: &Task) -> Result<bool> {
        while self.next_line(stage, task)? {
            if !self.text().starts_with('#') {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Advances to the next line that is not empty; returns false at the end of the file.
    pub fn next_line(&mut self, stage: &'static str, task: &Task) -> Result<bool> {
        loop {
            if self.lines.number.is_multiple_of(1024) {
                task.step(stage, self.lines.bytes, self.size)?;
            }
            if !self.advance()? {
                return Ok(false);
            }
            if !self.text().is_empty() {
                return Ok(true);
            }
        }
    }

    /// Advances to the next line; returns false, with an empty line, at the end of the file.
    pub fn advance(&mut self) -> Result<bool> {
        self.line.clear();
        let read = self.lines.append_next(&mut self.line, LONGEST_LINE);
        let is_there = read.map_err(Error::io(self.path, "read it"))?;
        if self.lines.number == 1
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
        Ok(is_there)
    }

    /// Returns the line without surrounding white space; bytes that are not UTF-8 become U+FFFD, which names must not
    /// contain.
    pub fn text(&self) -> Cow<'_, str> {
        let line = self.line.trim_ascii();
        String::from_utf8_lossy(line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(line))
    }
}
