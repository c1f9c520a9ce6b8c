//! Reads bytes of a file by position, and never beyond its end.
//!
//! A length that a file claims is checked against the file's size before anything of that size is allocated.
//! Numbers are big-endian, as in PSD and XCF.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use quadratura_base::error::{Error, Result};

/// The remedy for a damaged file.
pub const SAVE_AGAIN: &str = "save it again in the image editor, or use an older copy";

/// An open file that can be read from any thread.
#[derive(Debug)]
pub struct FileBytes {
    file: File,
    path: PathBuf,
    length: u64,
}

impl FileBytes {
    /// Opens a file.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn open(path: &Path) -> Result<Arc<Self>> {
        let file = File::open(path).map_err(Error::io(path, "open it"))?;
        let length = file.metadata().map_err(Error::io(path, "read it"))?.len();
        Ok(Arc::new(Self { file, path: path.to_owned(), length }))
    }

    /// Returns the path, for errors.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the length in bytes at the time of opening.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Reads `length` bytes from position `at`.
    ///
    /// # Errors
    /// [`Error::Input`] when the file is too short; [`Error::Io`] when it cannot be read.
    pub fn read(&self, at: u64, length: u64) -> Result<Vec<u8>> {
        if at.checked_add(length).is_none_or(|end| end > self.length) {
            let found =
                format!("the file ends at byte {}, but {length} bytes were expected here", self.length);
            return Err(self.damaged(at, found));
        }
        let mut bytes = vec![0; length as usize];
        self.fill(&mut bytes, at).map_err(Error::io(&self.path, "read it"))?;
        Ok(bytes)
    }

    #[cfg(unix)]
    fn fill(&self, bytes: &mut [u8], at: u64) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.file, bytes, at)
    }

    #[cfg(windows)]
    fn fill(&self, mut bytes: &mut [u8], mut at: u64) -> io::Result<()> {
        while !bytes.is_empty() {
            let count = std::os::windows::fs::FileExt::seek_read(&self.file, bytes, at)?;
            if count == 0 {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            (bytes, at) = (&mut bytes[count..], at + count as u64);
        }
        Ok(())
    }

    /// Returns the error for a finding at byte `at`.
    pub fn damaged(&self, at: u64, found: impl Into<String>) -> Error {
        Error::input(&self.path, format!("byte {at}"), found, SAVE_AGAIN)
    }

    /// Returns a cursor that starts at byte `at`.
    pub fn cursor(&self, at: u64) -> Cursor<'_> {
        Cursor { bytes: self, at, end: self.length, ahead: Vec::new(), ahead_at: 0 }
    }
}

/// A sequential reader of a part of a file.
#[derive(Debug, Clone)]
pub struct Cursor<'f> {
    bytes: &'f FileBytes,
    at: u64,
    end: u64,
    /// Bytes that were read in advance from position `ahead_at`.
    ahead: Vec<u8>,
    ahead_at: u64,
}

/// Number of bytes that are read in advance for single numbers: about the size of a layer's record.
const AHEAD: u64 = 4096;

impl<'f> Cursor<'f> {
    /// Returns the position, in bytes from the beginning of the file.
    pub fn at(&self) -> u64 {
        self.at
    }

    /// Returns the number of bytes up to the end of the part.
    pub fn left(&self) -> u64 {
        self.end.saturating_sub(self.at)
    }

    /// Returns the error for a finding at the present position.
    pub fn damaged(&self, found: impl Into<String>) -> Error {
        self.bytes.damaged(self.at, found)
    }

    /// Skips `length` bytes.
    ///
    /// # Errors
    /// [`Error::Input`] when there are fewer.
    pub fn skip(&mut self, length: u64) -> Result<()> {
        self.expect(length)?;
        self.at += length;
        Ok(())
    }

    /// Returns a cursor over the next `length` bytes and skips them here.
    ///
    /// # Errors
    /// As [`Self::skip`].
    pub fn part(&mut self, length: u64) -> Result<Self> {
        let (at, end) = (self.at, self.at.saturating_add(length));
        self.skip(length)?;
        Ok(Self { bytes: self.bytes, at, end, ahead: self.ahead.clone(), ahead_at: self.ahead_at })
    }

    /// Reads the next `length` bytes.
    ///
    /// # Errors
    /// As [`FileBytes::read`].
    pub fn take(&mut self, length: u64) -> Result<Vec<u8>> {
        self.expect(length)?;
        let bytes = self.bytes.read(self.at, length)?;
        self.at += length;
        Ok(bytes)
    }

    fn expect(&self, length: u64) -> Result<()> {
        if length <= self.left() {
            return Ok(());
        }
        let found =
            format!("{length} bytes were expected here, but this part of the file has {}", self.left());
        Err(self.damaged(found))
    }

    /// Reads the next `N` bytes; meant for single numbers.
    ///
    /// # Errors
    /// As [`FileBytes::read`].
    pub fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        self.expect(N as u64)?;
        let ahead_end = self.ahead_at + self.ahead.len() as u64;
        if self.at < self.ahead_at || self.at + N as u64 > ahead_end {
            let length = AHEAD.max(N as u64).min(self.bytes.length.saturating_sub(self.at));
            self.ahead = self.bytes.read(self.at, length)?;
            self.ahead_at = self.at;
        }
        let start = (self.at - self.ahead_at) as usize;
        let found = self.ahead.get(start..start + N).and_then(|bytes| bytes.try_into().ok());
        let array = found.ok_or_else(|| self.damaged("the file ends here"))?;
        self.at += N as u64;
        Ok(array)
    }

    /// Reads an unsigned 8-bit integer.
    ///
    /// # Errors
    /// As [`FileBytes::read`].
    pub fn u8(&mut self) -> Result<u8> {
        Ok(self.array::<1>()?[0])
    }

    /// Reads an unsigned 16-bit integer.
    ///
    /// # Errors
    /// As [`Self::u8`].
    pub fn u16(&mut self) -> Result<u16> {
        Ok(u16::from_be_bytes(self.array()?))
    }

    /// Reads an unsigned 32-bit integer.
    ///
    /// # Errors
    /// As [`Self::u8`].
    pub fn u32(&mut self) -> Result<u32> {
        Ok(u32::from_be_bytes(self.array()?))
    }

    /// Reads an unsigned 64-bit integer.
    ///
    /// # Errors
    /// As [`Self::u8`].
    pub fn u64(&mut self) -> Result<u64> {
        Ok(u64::from_be_bytes(self.array()?))
    }

    /// Reads a signed 16-bit integer.
    ///
    /// # Errors
    /// As [`Self::u8`].
    pub fn i16(&mut self) -> Result<i16> {
        Ok(i16::from_be_bytes(self.array()?))
    }

    /// Reads a signed 32-bit integer.
    ///
    /// # Errors
    /// As [`Self::u8`].
    pub fn i32(&mut self) -> Result<i32> {
        Ok(i32::from_be_bytes(self.array()?))
    }

    /// Reads a 32-bit float.
    ///
    /// # Errors
    /// As [`Self::u8`].
    pub fn f32(&mut self) -> Result<f32> {
        Ok(f32::from_be_bytes(self.array()?))
    }
}

/// A file as a `Read + Seek`, for packages that need one; copies share the file.
#[derive(Debug, Clone)]
pub struct FileReader {
    bytes: Arc<FileBytes>,
    at: u64,
}

impl FileReader {
    /// Starts at the beginning of the file.
    pub fn new(bytes: Arc<FileBytes>) -> Self {
        Self { bytes, at: 0 }
    }
}

impl io::Read for FileReader {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = (out.len() as u64).min(self.bytes.length.saturating_sub(self.at)) as usize;
        self.bytes.fill(&mut out[..count], self.at)?;
        self.at += count as u64;
        Ok(count)
    }
}

impl io::Seek for FileReader {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        let target = match to {
            io::SeekFrom::Start(at) => Some(at),
            io::SeekFrom::End(offset) => self.bytes.length.checked_add_signed(offset),
            io::SeekFrom::Current(offset) => self.at.checked_add_signed(offset),
        };
        self.at = target.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(content: &[u8]) -> (tempfile::TempDir, Arc<FileBytes>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::write(&path, content).unwrap();
        let bytes = FileBytes::open(&path).unwrap();
        (folder, bytes)
    }

    #[test]
    fn numbers_are_big_endian_and_follow_each_other() {
        let (_folder, bytes) = file(&[1, 2, 3, 255, 255, 255, 254, 0, 0, 0, 7]);
        let mut cursor = bytes.cursor(0);
        assert_eq!((cursor.u8().unwrap(), cursor.u16().unwrap()), (1, 0x0203));
        assert_eq!((cursor.i32().unwrap(), cursor.left()), (-2, 4));
        assert_eq!(cursor.take(4).unwrap(), [0, 0, 0, 7]);
    }

    #[test]
    fn reading_beyond_the_end_is_an_error_with_its_place_and_allocates_nothing() {
        let (_folder, bytes) = file(&[0; 10]);
        let error = bytes.read(4, u64::MAX - 2).unwrap_err().to_string();
        assert!(error.contains("byte 4") && error.contains("ends at byte 10"), "{error}");
        let mut cursor = bytes.cursor(8);
        assert!(cursor.u32().is_err() && cursor.skip(3).is_err() && cursor.part(u64::MAX).is_err());
        assert_eq!(cursor.u16().unwrap(), 0);
        assert!(bytes.cursor(100).u8().is_err());
    }

    #[test]
    fn a_part_ends_where_it_was_said_to() {
        let (_folder, bytes) = file(&[9; 10]);
        let mut cursor = bytes.cursor(1);
        let mut part = cursor.part(3).unwrap();
        assert_eq!((part.left(), cursor.at()), (3, 4));
        assert!(part.u32().is_err() && part.u16().is_ok() && part.u8().is_ok() && part.u8().is_err());
    }

    #[test]
    fn a_reader_sees_the_same_bytes_from_wherever_it_is_put() {
        use std::io::{Read, Seek, SeekFrom};
        let (_folder, bytes) = file(&[1, 2, 3, 4]);
        let mut reader = FileReader::new(bytes);
        assert_eq!(reader.seek(SeekFrom::End(-3)).unwrap(), 1);
        let mut rest = Vec::new();
        reader.read_to_end(&mut rest).unwrap();
        assert_eq!(rest, [2, 3, 4]);
        assert!(reader.seek(SeekFrom::Current(-9)).is_err());
    }
}
