//! Pixels of a picture that need not fit into memory: a file without a name, which the system removes when the program ends.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use quadratura_base::error::{Error, Result};

/// Rows of RGBA pixels, 8 bits a channel, from the top.
#[derive(Debug)]
pub struct RowsFile {
    file: File,
    folder: PathBuf,
    /// The pixels of a row.
    width: u32,
    /// The rows that were written so far.
    rows: u32,
}

/// The bytes of a pixel.
const PX_BYTES: usize = 4;

impl RowsFile {
    /// Creates the file on the disk of `folder`, for rows of `width` pixels.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn create(folder: &Path, width: u32) -> Result<Self> {
        let file =
            tempfile::tempfile_in(folder).map_err(Error::io(folder, "create a file for the picture in"))?;
        Ok(Self { file, folder: folder.to_owned(), width, rows: 0 })
    }

    /// Appends whole rows.
    ///
    /// # Errors
    /// [`Error::Io`], on a full disk.
    pub fn append(&mut self, rgba: &[u8]) -> Result<()> {
        debug_assert!(rgba.len().is_multiple_of(self.row_bytes()));
        self.file.write_all(rgba).map_err(Error::io(&self.folder, "write the picture to"))?;
        self.rows += (rgba.len() / self.row_bytes()) as u32;
        Ok(())
    }

    /// Returns width and height in pixels.
    pub fn size_px(&self) -> [u32; 2] {
        [self.width, self.rows]
    }

    fn row_bytes(&self) -> usize {
        PX_BYTES * self.width as usize
    }

    /// Calls `each` with `count` rows at a time from the top, the last time with as many as are left.
    ///
    /// # Errors
    /// [`std::io::Error`] of reading or of `each`.
    pub fn read(
        &self,
        count: u32,
        mut each: impl FnMut(&[u8]) -> std::io::Result<()>,
    ) -> std::io::Result<()> {
        let mut file = &self.file;
        file.seek(SeekFrom::Start(0))?;
        let mut buffer = vec![0; self.row_bytes() * count.min(self.rows.max(1)) as usize];
        let mut left = self.row_bytes() * self.rows as usize;
        while left > 0 {
            let part = left.min(buffer.len());
            file.read_exact(&mut buffer[..part])?;
            each(&buffer[..part])?;
            left -= part;
        }
        Ok(())
    }

    /// Reads one row.
    ///
    /// # Errors
    /// [`std::io::Error`].
    pub fn row(&self, row: u32, into: &mut Vec<u8>) -> std::io::Result<()> {
        let mut file = &self.file;
        into.resize(self.row_bytes(), 0);
        file.seek(SeekFrom::Start(self.row_bytes() as u64 * u64::from(row)))?;
        file.read_exact(into)
    }
}

/// Lays a pixel over white.
pub(super) fn on_white(pixel: [u8; 4]) -> [u8; 3] {
    use quadratura_base::raster::over::on_opaque;
    let [r, g, b, alpha] = pixel;
    [r, g, b].map(|channel| on_opaque(channel, alpha, u8::MAX))
}
