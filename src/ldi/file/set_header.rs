//! The first line of a file of several layered depth images.

use serde::{Deserialize, Serialize};

use super::defect::{CheckResult, FileDefect, ensure};
use super::header::ALIGNMENT;
use crate::Arrangement;

/// What `format` says.
pub const SET_FORMAT: &str = "quadratura-ldi-set";

/// The version that this program writes, and the only one that it reads.
pub const SET_VERSION: u32 = 1;

/// The number of faces of a cube.
const FACES: usize = 6;

/// The largest number of images in a file, more than photos of any site are chosen for a set.
pub const MOST_IMAGES: usize = 4096;

/// The first line of a file of several layered depth images. `docs/formats.md` describes it for other programs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SetHeader {
    /// The name of the format, [`SET_FORMAT`].
    pub format: String,
    /// The version of the format, [`SET_VERSION`].
    pub version: u32,
    /// How the images belong together: the name of an [`Arrangement`].
    pub arrangement: String,
    /// The images, one after the other.
    pub images: Vec<PartEntry>,
}

/// An image of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PartEntry {
    /// Its size in the file, with its own first line.
    pub bytes: u64,
}

impl SetHeader {
    /// Makes the first line of images of these sizes.
    pub fn new(arrangement: Arrangement, sizes: impl Iterator<Item = u64>) -> Self {
        Self {
            format: SET_FORMAT.to_owned(),
            version: SET_VERSION,
            arrangement: arrangement.name().to_owned(),
            images: sizes.map(|bytes| PartEntry { bytes }).collect(),
        }
    }

    /// Checks what it says, and returns how the images belong together.
    pub fn check(&self) -> CheckResult<Arrangement> {
        let known = Arrangement::OF_SEVERAL.into_iter().find(|known| known.name() == self.arrangement);
        let arrangement = known.ok_or_else(|| {
            let names = Arrangement::OF_SEVERAL.map(Arrangement::name).join(", ");
            FileDefect::of_line(format!("`arrangement` is {:?}; expected one of: {names}", self.arrangement))
        })?;
        let count = self.images.len();
        match arrangement {
            Arrangement::Cube => ensure(count == FACES, || {
                FileDefect::of_line(format!("there are {count} images of a cube; expected {FACES}"))
            })?,
            _ => ensure(count > 0, || {
                FileDefect::of_line("there is no image in the set; expected one at least")
            })?,
        }
        ensure(count <= MOST_IMAGES, || {
            FileDefect::of_line(format!("there are {count} images; expected {MOST_IMAGES} at most"))
        })?;
        for (index, image) in self.images.iter().enumerate() {
            let bytes = image.bytes;
            ensure(bytes > 0 && bytes.is_multiple_of(ALIGNMENT as u64), || {
                let place = format!("first line, image {index}");
                FileDefect::at(place, format!("{bytes} bytes; expected a multiple of {ALIGNMENT} above 0"))
            })?;
        }
        let sum = self.images.iter().map(|image| image.bytes).try_fold(0u64, u64::checked_add);
        ensure(sum.is_some_and(|sum| sum < 1 << 63), || {
            FileDefect::of_line("the images have more bytes than any file")
        })?;
        Ok(arrangement)
    }
}
