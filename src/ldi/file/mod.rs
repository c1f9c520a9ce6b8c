//! Reads and writes `NAME.ldi`, the file of a layered depth image (see `docs/formats.md`).
//!
//! One line of JSON describes the file. After a line feed follow chunks of 64 rows, level after level. Each has its
//! streams in turn, so that any chunk can be shown alone. Several images are one file of a format of its own ([`SET_FORMAT`]):
//! a first line, then each image as it would be in a file of its own.

mod check;
mod chunk_pixels;
mod defect;
mod hash;
mod header;
mod line;
mod packing;
mod prediction;
mod read;
mod set;
mod set_header;
mod streams;
mod write;

pub use self::hash::HASH_DIGITS;
pub use self::header::{
    CHUNK_ROWS, ChunkEntry, FORMAT, LdiCamera, LdiHeader, LevelEntry, ReportEntry, STREAMS, SurfaceEntry,
    VERSION,
};
pub use self::packing::Packing;
pub use self::read::{
    WholeRows, has_whole_length, read_ldi, read_ldi_header, read_ldi_level, read_whole_rows,
};
pub use self::set::{LdiFile, PackedSet, read_ldi_set};
pub use self::set_header::{MOST_IMAGES, SET_FORMAT, SET_VERSION};
pub use self::write::write_ldi;

/// Returns what is wrong with a camera: its frame's size, K, R or t; `None` where nothing is.
pub fn wrong_camera(camera: &LdiCamera) -> Option<String> {
    check::check_camera(camera).err().map(|defect| defect.found)
}

#[cfg(test)]
mod set_tests;
#[cfg(test)]
mod tests;
