//! A layered file as an image editor saved it: the result of reading, independent of its format.
//!
//! Pixels stay in the file until they are requested, so a document of many layers takes little memory, and
//! layers that are not needed take no time.

use std::path::PathBuf;
use std::sync::Arc;

use super::depth::Depth;
use super::grey::Grey;
use super::raster::Raster;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::in_8_bits;
use quadratura_base::scene::light::linear_of_srgb;
use quadratura_document::export_record::ExportFormat;
use quadratura_files::guarded::{file_being_decoded, guarded};

/// The remedy for a file that is damaged.
pub(super) const SAVE_AGAIN: &str =
    "save it again in the image editor; paint that was imported from it before stays";

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
    /// How coarsely colours are stored, where that is not the depth in which they are read.
    pub rounding: Option<Rounding>,
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

/// How coarsely a file stores colours that are read in another way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rounding {
    /// Whether linear light is stored instead of values with sRGB's tone curve.
    pub linear: bool,
    /// The largest difference between neighbouring values, of 1; of the value itself where they are floating-point.
    pub step: f64,
    /// Whether they are floating-point.
    pub is_float: bool,
}

impl Rounding {
    /// Returns true when both colours, in 16 bits, are the same one as the file stores it: rounded up or down.
    pub fn is_same(self, one: [u16; 4], other: [u16; 4]) -> bool {
        let value = |sample: u16| {
            let value = f64::from(sample) / 65535.0;
            if self.linear { linear_of_srgb(value) } else { value }
        };
        let same = |i: usize| {
            let (one, other) = (value(one[i]), value(other[i]));
            let step = if self.is_float { self.step * one.max(other) } else { self.step };
            // Reading rounds once more.
            (one - other).abs() <= step + 1.0 / 65535.0
        };
        in_8_bits(one[3]) == in_8_bits(other[3]) && (0..3).all(same)
    }
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
    /// The colours that its pixels can have as they are stored.
    pub colours: StoredColours,
    /// Pixels of the size of `rect` and of the document's depth. Mask and opacity are not applied; colours of
    /// transparent pixels are as stored.
    pub pixels: Lazy<Raster>,
}

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
            colours: StoredColours::Full,
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

/// The colours that the pixels of a layer can have as they are stored; they are always read as RGBA.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StoredColours {
    /// Any colour.
    Full,
    /// Grey values only.
    Grey,
    /// At most 256 colours.
    Palette,
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
    /// Another mask of the same layer; the lower value of both counts.
    pub lowest_with: Option<Arc<EditedMask>>,
    /// Samples of the size of `rect` and of the document's depth.
    pub pixels: Lazy<Grey>,
}

impl EditedMask {
    /// Returns the pixels of a mask that several layers share, to be read on request.
    pub(crate) fn shared_pixels(mask: &Arc<Self>) -> Lazy<Grey> {
        let (pixels, code) = (mask.clone(), mask.clone());
        let code: ReadFn<String> = Box::new(move || {
            code.pixels.code().map(|code| code.expect("it was there when the mask was shared"))
        });
        Lazy {
            read: Box::new(move || pixels.pixels.read()),
            code: mask.pixels.code.as_ref().map(|_| code),
            file: mask.pixels.file.clone(),
        }
    }
}

type ReadFn<T> = Box<dyn Fn() -> Result<T> + Send + Sync>;

/// Data that is read on request: any number of times, from any thread, anew each time.
pub struct Lazy<T> {
    read: ReadFn<T>,
    code: Option<ReadFn<String>>,
    /// The layered file, which errors of decoders name.
    file: PathBuf,
}

impl<T> Lazy<T> {
    /// Creates a value that the function `read` reads.
    pub fn new(read: impl Fn() -> Result<T> + Send + Sync + 'static) -> Self {
        Self { read: Box::new(read), code: None, file: file_being_decoded().unwrap_or_default() }
    }

    /// Adds a function that returns a hash of the stored data and of how it is decoded.
    pub fn with_stored_hash(self, code: impl Fn() -> Result<String> + Send + Sync + 'static) -> Self {
        Self { code: Some(Box::new(code)), ..self }
    }

    /// Returns what `change` makes of the value when it is read; `how` tells the change from others.
    pub fn changed(self, how: &'static str, change: impl Fn(T) -> T + Send + Sync + 'static) -> Self
    where
        T: 'static,
    {
        let Self { read, code, file } = self;
        let code = code.map(|code| -> ReadFn<String> { Box::new(move || Ok(format!("{} {how}", code()?))) });
        Self { read: Box::new(move || Ok(change(read()?))), code, file }
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
    /// [`quadratura_base::Error::Input`] with file and place when the data is damaged; [`quadratura_base::Error::Io`] when the
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
