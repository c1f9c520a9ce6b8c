//! The file that a layered image is written to.

use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

use crate::error::{Error, Result};

/// Whether a document went into a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fit {
    /// All of it.
    Whole,
    /// It is larger than this variant of the format allows: start again with the larger one. The file holds
    /// rubbish.
    TooLarge,
}

/// A buffered file that knows its name, for errors, and how much was written.
pub struct Sink<'p, W: Write> {
    out: BufWriter<W>,
    /// What errors call the file.
    pub path: &'p Path,
    /// Bytes so far.
    pub written: u64,
}

impl<'p, W: Write + Seek> Sink<'p, W> {
    /// `out` stands at its beginning.
    pub fn new(out: W, path: &'p Path) -> Self {
        Self { out: BufWriter::with_capacity(1 << 18, out), path, written: 0 }
    }

    /// # Errors
    /// [`Error::Io`]
    pub fn bytes(&mut self, bytes: &[u8]) -> Result<()> {
        self.write_all(bytes).map_err(Error::io(self.path, "write it"))
    }

    /// Puts other bytes where as many were written before, and ends the writing.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn rewrite(mut self, at: u64, bytes: &[u8]) -> Result<()> {
        let seek = self.out.seek(SeekFrom::Start(at));
        let rewritten = seek.and_then(|_| self.out.write_all(bytes)).and_then(|()| self.out.flush());
        rewritten.map_err(Error::io(self.path, "write it"))
    }
}

impl<W: Write> Write for Sink<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let count = self.out.write(bytes)?;
        self.written += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}
