//! A layered file as an image editor saved it: the result of reading, independent of its format.
//!
//! Pixels stay in the file until they are requested, so a document of many layers takes little memory, and
//! layers that are not needed take no time.

use std::path::PathBuf;
use std::sync::Arc;

use super::depth::Depth;
use super::grey::Grey;
use super::raster::Raster;
use super::read::SAVE_AGAIN;
use crate::document::export_record::ExportFormat;
use crate::error::Result;
use crate::geometry::PixelRect;
use crate::io::guarded::{file_being_decoded, guarded};

/// The content of a layered file.
#[derive(Debug)]
pub struct EditedDocument {
    /// Format of the file, by its content; a PSB counts as a PSD.
    pub format: ExportFormat,
    /// Width of the canvas in pixels.
    pub width: u32,
    /// Height of the canvas in pixels.
    pub height: u32,
    /// Bit depth of the pixels and masks of every layer.
    pub depth: Depth,
    /// ICC profile of all pixels as stored in the file.
    pub icc: Option<Vec<u8>>,
    /// The document key that the export wrote into the file; `None` when the editor dropped it, or when the
    /// file was not exported by this program.
    pub key: Option<String>,
    /// Layers from bottom to top, without the hierarchy of groups.
    pub layers: Vec<EditedLayer>,
    /// Notes for the user about content that was not understood, with its place in the file.
    pub notes: Vec<String>,
}

/// A layer of a file that was read.
#[derive(Debug)]
pub struct EditedLayer {
    /// The name as the editor saved it, without trailing NULs.
    pub name: String,
    /// The names of the groups that contain the layer, outermost first.
    pub groups: Vec<String>,
    /// Position and size of the pixels on the canvas; may reach outside the canvas, and may be empty.
    pub rect: PixelRect,
    /// Whether the layer itself is visible, regardless of its groups.
    pub visible: bool,
    /// Whether a group that contains the layer is hidden.
    pub hidden_by_group: bool,
    /// Opacity, 0..=1, multiplied with that of the groups.
    pub opacity: f32,
    /// Blend mode of the layer, or of a group that contains it.
    pub blend: BlendMode,
    /// The layer's own mask followed by those of its groups; they multiply.
    pub masks: Vec<Arc<EditedMask>>,
    /// The token of the image layer, where the format stores one beside the name.
    pub id: Option<String>,
    /// Whether the layer is locked against painting.
    pub locked: bool,
    /// Pixels of the size of `rect` and of the document's depth. Mask and opacity are not applied; colours of
    /// transparent pixels are as stored.
    pub pixels: Lazy<Raster>,
}

#[cfg(test)]
impl EditedLayer {
    /// Creates a layer as an export writes it, for tests to modify.
    pub fn plain(name: &str, rect: PixelRect, pixels: Lazy<Raster>) -> Self {
        Self {
            name: name.into(),
            groups: vec![],
            rect,
            visible: true,
            hidden_by_group: false,
            opacity: 1.0,
            blend: BlendMode::Normal,
            masks: vec![],
            id: None,
            locked: false,
            pixels,
        }
    }
}

/// How a layer is combined with the layers below.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BlendMode {
    /// The over operator.
    Normal,
    /// Another mode, by the name that users know: `multiply`, `clipped to the layer below`.
    Other(String),
}

/// A mask of a layer or group.
#[derive(Debug)]
pub struct EditedMask {
    /// Position and size on the canvas, in pixels.
    pub rect: PixelRect,
    /// The value outside `rect`: 0 hides, 1 shows.
    pub outside: f32,
    /// False when the user disabled the mask.
    pub enabled: bool,
    /// Samples of the size of `rect` and of the document's depth.
    pub pixels: Lazy<Grey>,
}

type Read<T> = Box<dyn Fn() -> Result<T> + Send + Sync>;

/// Data that is read on request: any number of times, from any thread, anew each time.
pub struct Lazy<T> {
    read: Read<T>,
    code: Option<Read<String>>,
    /// The layered file, which errors of decoders name.
    file: PathBuf,
}

impl<T> Lazy<T> {
    /// Creates a value that the function `read` reads.
    pub fn new(read: impl Fn() -> Result<T> + Send + Sync + 'static) -> Self {
        Self { read: Box::new(read), code: None, file: file_being_decoded().unwrap_or_default() }
    }

    /// Adds a function that returns a hash of the stored data and of how it is decoded.
    pub(crate) fn with_stored_hash(self, code: impl Fn() -> Result<String> + Send + Sync + 'static) -> Self {
        Self { code: Some(Box::new(code)), ..self }
    }

    /// Returns a hash of the stored data, much faster than reading: equal hashes mean that [`Self::read`]
    /// returns the same. `None` where no hash is available.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn code(&self) -> Result<Option<String>> {
        self.code.as_ref().map(|code| guarded(&self.file, SAVE_AGAIN, code)).transpose()
    }

    /// Reads the data.
    ///
    /// # Errors
    /// [`crate::Error::Input`] with file and place when the data is damaged; [`crate::Error::Io`] when the
    /// file can no longer be read.
    pub fn read(&self) -> Result<T> {
        guarded(&self.file, SAVE_AGAIN, &self.read)
    }
}

impl<T> std::fmt::Debug for Lazy<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("Lazy")
    }
}
