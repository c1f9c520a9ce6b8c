//! A depth image's file while it is read: its content, its length, and the errors about it.

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek};
use std::path::{Path, PathBuf};

use quadratura_base::error::{Error, Message, Result};

/// The remedy for a file that is cut short or damaged.
pub(super) const COPY: &str = "copy the file again from a complete original, or write it again";

/// The longest word of a header in bytes.
const LONGEST_WORD: usize = 64;

/// The bytes of a file.
pub(super) trait ReadSeek: Read + Seek {}
impl<T: Read + Seek> ReadSeek for T {}

/// An open file.
pub(super) struct DepthFile {
    /// The file.
    pub path: PathBuf,
    /// Its content.
    pub reader: BufReader<Box<dyn ReadSeek>>,
    /// Its length in bytes.
    pub length: u64,
}

impl DepthFile {
    /// Opens a file.
    pub fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(Error::io(path, "open it"))?;
        let metadata = file.metadata().map_err(Error::io(path, "read its size"))?;
        if !metadata.is_file() {
            return Err(Error::input(path, "", "not a file", "name the file of a depth image"));
        }
        Ok(Self::new(path, Box::new(file), metadata.len()))
    }

    /// Makes a file of its content and length in bytes.
    pub fn new(path: &Path, content: Box<dyn ReadSeek>, length: u64) -> Self {
        Self { path: path.to_path_buf(), reader: BufReader::new(content), length }
    }

    /// Makes the error about a place in the file.
    pub fn wrong(&self, place: &str, found: impl Into<String>, remedy: impl Into<Message>) -> Error {
        Error::input(&self.path, place, found, remedy)
    }

    /// Checks the size that the file has against the picture's, before memory is taken.
    pub fn check_size(&self, found: [u64; 2], expected: [u32; 2]) -> Result<()> {
        check_size(&self.path, found, expected)
    }

    /// Checks that exactly `expected` bytes follow the `header` bytes that were read.
    pub fn check_rest(&self, header: u64, expected: u64) -> Result<()> {
        let rest = self.length.saturating_sub(header);
        if rest == expected {
            return Ok(());
        }
        let found = format!("{rest} bytes after the header of {header}; expected {expected}");
        let found = if rest < expected { format!("the file is cut short: {found}") } else { found };
        Err(self.wrong(&format!("byte {header}"), found, COPY))
    }

    /// Reads `count` numbers, in either byte order.
    pub fn floats(&mut self, count: usize, from: fn([u8; 4]) -> f32) -> Result<Vec<f32>> {
        let mut bytes = vec![0u8; 4 * count];
        self.reader.read_exact(&mut bytes).map_err(Error::io(&self.path, "read it"))?;
        Ok(bytes.as_chunks().0.iter().copied().map(from).collect())
    }

    /// Reads the text up to the next byte that ends a word, which is read, too; `read` counts the bytes.
    ///
    /// # Errors
    /// [`Error::Input`] where the file ends before, or the word is longer than any in a header.
    pub fn word(&mut self, ends: fn(u8) -> bool, read: &mut u64) -> Result<String> {
        let mut word = Vec::new();
        while word.len() <= LONGEST_WORD {
            let mut byte = [0u8];
            if let Err(error) = self.reader.read_exact(&mut byte) {
                return Err(match error.kind() {
                    ErrorKind::UnexpectedEof => {
                        self.wrong(&format!("byte {read}"), "the file ends within its header", COPY)
                    }
                    _ => Error::io(&self.path, "read it")(error),
                });
            }
            *read += 1;
            if ends(byte[0]) {
                return Ok(String::from_utf8_lossy(&word).into_owned());
            }
            word.push(byte[0]);
        }
        Err(self.wrong(&format!("byte {read}"), "a word in the header that is too long", COPY))
    }

    /// Returns a number of the header.
    pub fn number(&self, word: &str, what: &str) -> Result<u64> {
        word.parse().map_err(|_| {
            let found = format!("{word:?} as the {what}; expected a whole number");
            self.wrong("header", found, COPY)
        })
    }
}

/// Checks the size that a file has against the picture's, before memory is taken.
pub(super) fn check_size(path: &Path, found: [u64; 2], [width, height]: [u32; 2]) -> Result<()> {
    if found == [u64::from(width), u64::from(height)] {
        return Ok(());
    }
    let found =
        format!("{} x {} numbers; expected {width} x {height}, as the picture has", found[0], found[1]);
    Err(Error::input(
        path,
        "",
        found,
        "use the depth image that belongs to this picture, and both in one size",
    ))
}
