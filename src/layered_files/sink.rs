//! The output file of a layered image.

use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

use quadratura_base::error::{Error, Result};

/// Whether a document fits into this variant of the format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FormatFit {
    /// The document was written completely.
    Whole,
    /// The document is larger than this variant of the format allows and has to be written again in the
    /// larger one. The content of the file is invalid.
    TooLarge,
}

/// A buffered output that keeps its path, for errors, and counts the bytes written.
pub struct FileSink<'p, W: Write> {
    out: BufWriter<W>,
    /// The file's path, for errors.
    pub path: &'p Path,
    /// Number of bytes written so far.
    pub written: u64,
}

impl<'p, W: Write + Seek> FileSink<'p, W> {
    /// Wraps `out`, which must be at its beginning.
    pub fn new(out: W, path: &'p Path) -> Self {
        Self { out: BufWriter::with_capacity(1 << 18, out), path, written: 0 }
    }

    /// Writes `bytes`.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn bytes(&mut self, bytes: &[u8]) -> Result<()> {
        self.write_all(bytes).map_err(Error::io(self.path, "write it"))
    }

    /// Replaces bytes that were written before at position `at` by as many others, and finishes writing.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn rewrite(mut self, at: u64, bytes: &[u8]) -> Result<()> {
        let seek = self.out.seek(SeekFrom::Start(at));
        let rewritten = seek.and_then(|_| self.out.write_all(bytes)).and_then(|()| self.out.flush());
        rewritten.map_err(Error::io(self.path, "write it"))
    }
}

impl<W: Write> Write for FileSink<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let count = self.out.write(bytes)?;
        self.written += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}
