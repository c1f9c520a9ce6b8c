//! The file that a PSD is written to.

use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

use super::Kind;
use super::planes::Planes;
use super::records::EMPTY_CHANNEL;
use crate::error::{Error, Result};

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

    /// Writes the four channels of a record, empty ones for a record without pixels, and returns
    /// their lengths.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn channels(&mut self, planes: Option<&Planes>, kind: Kind) -> Result<[u64; 4]> {
        let Some(planes) = planes else {
            self.bytes(&[EMPTY_CHANNEL; 4].concat())?;
            return Ok([EMPTY_CHANNEL.len() as u64; 4]);
        };
        let path = self.path;
        for channel in 0..4 {
            planes.write_channel(channel, kind, self).map_err(Error::io(path, "write it"))?;
        }
        Ok([0, 1, 2, 3].map(|channel| planes.channel_length(channel, kind)))
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
