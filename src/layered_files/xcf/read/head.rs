//! Reads the header of an XCF: version, size, precision.

use super::SIGNATURE;
use super::precision::Precision;
use crate::bytes::{Cursor, FileBytes};
use crate::place::{is_canvas, not_a_canvas};
use quadratura_base::error::{Error, Result};

/// The newest version that is fully known.
const NEWEST: u32 = 14;
/// The first version number of CinePaint, a program of its own.
const FOREIGN: u32 = 100;

/// The header of an XCF.
#[derive(Debug, Clone, Copy)]
pub struct XcfHeader {
    pub version: u32,
    pub width: u32,
    pub height: u32,
    pub precision: Precision,
    /// Whether pointers have 8 bytes.
    pub wide: bool,
}

impl XcfHeader {
    /// Reads up to the properties of the image.
    ///
    /// # Errors
    /// [`Error::Input`] when the file is damaged or of an unsupported kind.
    pub fn read(cursor: &mut Cursor, bytes: &FileBytes) -> Result<Self> {
        cursor.skip(SIGNATURE.len() as u64)?;
        let version = version(cursor.array()?, bytes)?;
        let (width, height) = (cursor.u32()?, cursor.u32()?);
        if !is_canvas(width, height) {
            return Err(bytes.damaged(14, not_a_canvas(width, height)));
        }
        let model = cursor.u32()?;
        if model > 2 {
            let found = format!("colour model {model}, expected 0 (RGB), 1 (grey) or 2 (indexed)");
            return Err(bytes.damaged(22, found));
        }
        let number = if version >= 4 { Some(cursor.u32()?) } else { None };
        let precision = Precision::new(version, number).ok_or_else(|| {
            let found = format!("precision {} in version {version}", number.unwrap_or(0));
            Error::input(bytes.path(), "byte 26", found, AS_PSD)
        })?;
        Ok(Self { version, width, height, precision, wide: version >= 11 })
    }

    /// Returns notes for the user about the file.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.version > NEWEST {
            let version = self.version;
            notes.push(format!(
                "it is an XCF of version {version}, this program knows {NEWEST}: its layers are read, what is new is \
                 not; save it as PSD if something is amiss"
            ));
        }
        notes.extend(self.precision.note());
        notes
    }
}

const AS_PSD: &str = "export it from GIMP as PSD and import that";

/// Parses the version: three digits behind a `v` and a NUL; `file` is version 0.
fn version(mark: [u8; 5], bytes: &FileBytes) -> Result<u32> {
    let number = match &mark {
        b"file\0" => Some(0),
        [b'v', digits @ .., 0] => std::str::from_utf8(digits).ok().and_then(|digits| digits.parse().ok()),
        _ => None,
    };
    let found = || format!("version \"{}\", expected \"file\" or v001 to v099", mark.escape_ascii());
    match number {
        Some(number) if number < FOREIGN => Ok(number),
        Some(_) => Err(Error::input(bytes.path(), "byte 9", found(), AS_PSD)),
        None => Err(bytes.damaged(9, found())),
    }
}
