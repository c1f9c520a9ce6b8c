//! Writes and reads a layered depth image as a folder of pictures: for each layer its colours, its depths with 16 bits, and
//! its surfaces, for programs that know no `.ldi` (see `docs/formats.md`).

mod json;
mod pictures;
mod read;
mod write;

use std::path::{Path, PathBuf};

pub use self::json::{DepthError, FORMAT, LayerEntry, LayersFile};
pub use self::read::read_ldi_layers;
pub use self::write::write_ldi_layers;

/// The file that describes the others.
const JSON: &str = "ldi.json";

/// Returns whether a folder is one of pictures of layers: whether it has the file that describes them.
pub fn is_ldi_layers(folder: &Path) -> bool {
    folder.join(JSON).is_file()
}

/// The largest number of layers.
const MOST_LAYERS: usize = u8::MAX as usize;

/// The largest value of 16 bits, which stands for the nearest depth pixel.
const NEAREST: f64 = u16::MAX as f64;

/// A folder that was written.
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenLayers {
    /// The folder.
    pub folder: PathBuf,
    /// What has the folder's name, was changed or made by others, and was therefore kept.
    pub spared: Vec<PathBuf>,
    /// The number of layers.
    pub layers: usize,
    /// The number of depth pixels.
    pub depth_pixels: u64,
    /// The size of all files in bytes.
    pub bytes: u64,
    /// The error that 16 bits of depth make.
    pub error: DepthError,
}

/// A picture of a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Picture {
    Colours,
    Depths,
    Surfaces,
}

impl Picture {
    const ALL: [Self; 3] = [Self::Colours, Self::Depths, Self::Surfaces];

    /// Returns its name in the folder, for a layer counted from 0.
    fn file_name(self, layer: usize) -> String {
        let name = match self {
            Self::Colours => "layer",
            Self::Depths => "depth",
            Self::Surfaces => "surface",
        };
        format!("{name}-{layer:02}.png")
    }
}

#[cfg(test)]
mod tests;
