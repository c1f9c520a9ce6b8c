//! A layered file as an image editor left it: what its reader understood, whatever its format.
//!
//! Pixels stay in the file until they are asked for, so that a document of many layers takes little
//! memory, and layers that nobody looks at take no time.

use std::sync::Arc;

use super::depth::Depth;
use super::grey::Grey;
use super::raster::Raster;
use crate::document::export_record::ExportFormat;
use crate::error::Result;
use crate::geometry::PixelRect;

/// What a layered file says.
#[derive(Debug)]
pub struct EditedDocument {
    /// Of the file, by its content; a PSB counts as a PSD.
    pub format: ExportFormat,
    /// Canvas, in pixels.
    pub width: u32,
    /// Canvas, in pixels.
    pub height: u32,
    /// Of the pixels and masks of every layer.
    pub depth: Depth,
    /// The colour profile of all pixels, as it lies in the file.
    pub icc: Option<Vec<u8>>,
    /// The document key that an export wrote into the file; none when the editor dropped it, or the
    /// file is not one of ours.
    pub key: Option<String>,
    /// From the bottom to the top, groups flattened.
    pub layers: Vec<EditedLayer>,
    /// What was not understood, with its place in the file: for the user.
    pub notes: Vec<String>,
}

/// A layer with pixels.
#[derive(Debug)]
pub struct EditedLayer {
    /// As the editor left it, without the NULs that some append.
    pub name: String,
    /// The names of the groups that it lies in, outermost first.
    pub groups: Vec<String>,
    /// Place and size of the pixels, in canvas pixels; may reach outside the canvas, may be empty.
    pub rect: PixelRect,
    /// As it is stored, whatever its groups are.
    pub visible: bool,
    /// True when some group around it is not shown.
    pub hidden_by_group: bool,
    /// 0..=1, with that of its groups: they multiply.
    pub opacity: f32,
    /// How it is laid over what is below, or some group around it is.
    pub blend: Blend,
    /// Where the layer is to be seen, besides its alpha: its own mask, then those of its groups. They multiply.
    pub masks: Vec<Arc<EditedMask>>,
    /// The token of the image layer, where the format keeps one beside the name.
    pub id: Option<String>,
    /// Locked against painting.
    pub locked: bool,
    /// As large as `rect`, of the document's depth. Neither mask nor opacity is applied; colours of
    /// transparent pixels are as stored.
    pub pixels: Lazy<Raster>,
}

#[cfg(test)]
impl EditedLayer {
    /// One as it is exported, to be written over by tests.
    pub fn plain(name: &str, rect: PixelRect, pixels: Lazy<Raster>) -> Self {
        Self {
            name: name.into(),
            groups: vec![],
            rect,
            visible: true,
            hidden_by_group: false,
            opacity: 1.0,
            blend: Blend::Normal,
            masks: vec![],
            id: None,
            locked: false,
            pixels,
        }
    }
}

/// How a layer is laid over what is below.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Blend {
    /// By the over operator, alone.
    Normal,
    /// In another way, by the name that users know it by: `multiply`, `clipped to the layer below`.
    Other(String),
}

/// The mask of a layer.
#[derive(Debug)]
pub struct EditedMask {
    /// In canvas pixels.
    pub rect: PixelRect,
    /// Its value outside `rect`: 0 hides, 1 shows.
    pub outside: f32,
    /// False when the user switched it off.
    pub enabled: bool,
    /// As large as `rect`, of the document's depth.
    pub pixels: Lazy<Grey>,
}

type Read<T> = Box<dyn Fn() -> Result<T> + Send + Sync>;

/// Something that is read when it is asked for: more than once, from any thread, anew each time.
pub struct Lazy<T> {
    read: Read<T>,
    code: Option<Read<String>>,
}

impl<T> Lazy<T> {
    /// Read by this function.
    pub fn new(read: impl Fn() -> Result<T> + Send + Sync + 'static) -> Self {
        Self { read: Box::new(read), code: None }
    }

    /// With a function that gives a hash of all that is decoded, and of how.
    pub fn with_code(self, code: impl Fn() -> Result<String> + Send + Sync + 'static) -> Self {
        Self { code: Some(Box::new(code)), ..self }
    }

    /// A hash of what is stored: where it is the same, [`Self::read`] gives the same. Much faster than reading. None
    /// where nobody can say.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn code(&self) -> Result<Option<String>> {
        self.code.as_ref().map(|code| code()).transpose()
    }

    /// Reads it.
    ///
    /// # Errors
    /// [`crate::Error::Input`] with file and place when it is damaged, [`crate::Error::Io`] when the file
    /// cannot be read any more.
    pub fn read(&self) -> Result<T> {
        (self.read)()
    }
}

impl<T> std::fmt::Debug for Lazy<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("Lazy")
    }
}
