//! Reads depth images from elsewhere: one number a pixel, from OpenEXR, PFM, 16-bit PNG, or COLMAP's dense depth maps.
//!
//! The numbers are those of the file. What they mean is said in a list of depth images ([`read_list`]).

mod colmap;
mod depth_file;
mod exr;
mod list;
mod pfm;
mod png16;
#[cfg(test)]
mod tests;

use std::io::BufRead;
use std::path::Path;

use self::depth_file::DepthFile;
pub use self::list::{DepthEntry, DepthKind, DepthList, read_list};
use quadratura_base::error::{Error, Result};
use quadratura_files::guarded::guarded;

/// The numbers of a depth image, as its file has them.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthMap {
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
    /// `height * width` numbers, rows from the top, in a row from the left. NaN where the file has none; other values are not
    /// checked.
    pub values: Vec<f32>,
}

impl DepthMap {
    /// Returns the number in column `x`, row `y`.
    pub fn at(&self, x: u32, y: u32) -> f32 {
        self.values[y as usize * self.width as usize + x as usize]
    }
}

/// A format of depth images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum DepthFormat {
    Exr,
    Pfm,
    Png,
    Colmap,
}

/// The remedy for a file in no known format.
const FORMATS: &str =
    "give an OpenEXR file, a PFM file (`Pf`), a 16-bit grey PNG, or COLMAP's `*.geometric.bin`";

/// Reads the depth image of a picture of `size` (width and height in pixels). Its content says which format it is. Nothing
/// larger than such a picture is taken into memory.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] with place, finding and remedy where the file is in no known format, of another size, cut
/// short or damaged.
pub fn read_depth_map(file: &Path, size: [u32; 2]) -> Result<DepthMap> {
    guarded(file, depth_file::COPY, || read_source(&mut DepthFile::open(file)?, size))
}

fn read_source(source: &mut DepthFile, size: [u32; 2]) -> Result<DepthMap> {
    let values = match format_of(source)? {
        DepthFormat::Exr => exr::read(source, size)?,
        DepthFormat::Pfm => pfm::read(source, size)?,
        DepthFormat::Png => png16::read(source, size)?,
        DepthFormat::Colmap => colmap::read(source, size)?,
    };
    Ok(DepthMap { width: size[0], height: size[1], values })
}

/// Returns the format that the first bytes show.
fn format_of(source: &mut DepthFile) -> Result<DepthFormat> {
    const EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
    const PNG: [u8; 4] = [0x89, b'P', b'N', b'G'];
    let start = source.reader.fill_buf().map_err(Error::io(&source.path, "read it"))?;
    Ok(match start {
        [] => {
            return Err(source.wrong(
                "",
                "the file is empty: 0 bytes",
                "copy it again from a complete original",
            ));
        }
        start if start.starts_with(&EXR) => DepthFormat::Exr,
        start if start.starts_with(&PNG) => DepthFormat::Png,
        [b'P', b'f' | b'F', ..] => DepthFormat::Pfm,
        [first, ..] if first.is_ascii_digit() && start.iter().take(12).any(|byte| *byte == b'&') => {
            DepthFormat::Colmap
        }
        _ => return Err(source.wrong("", "the file is no depth image in a known format", FORMATS)),
    })
}
