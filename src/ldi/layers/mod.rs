//! Writes and reads a layered depth image as a folder of pictures: for each layer its colours, its depths with 16 bits, and
//! its surfaces, for programs that know no `.ldi` (see `docs/formats.md`).

mod json;
mod picture_kind;
mod read;
mod write;

use std::path::Path;

use self::json::JSON;
pub use self::json::{DepthError, FORMAT, LayerEntry, LayersFile};
pub use self::read::read_ldi_layers;
pub use self::write::{WrittenLayers, write_ldi_layers};

/// Returns whether a folder is one of pictures of layers: whether it has the file that describes them.
pub fn is_ldi_layers(folder: &Path) -> bool {
    folder.join(JSON).is_file()
}

#[cfg(test)]
mod tests;
