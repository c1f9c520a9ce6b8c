//! `exports/<document key>.json`: what an export gave away, so that it finds home when it comes
//! back, even after the stack was built anew.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::stack::{Element, Piece, StackCamera, StackPhoto, Surface};
use crate::geometry::PixelRect;

/// The version this program writes; it reads no other.
pub const RECORD_VERSION: u32 = 2;

/// Hexadecimal digits of a document's key.
pub const KEY_DIGITS: usize = 20;

/// The kinds of layered images that are exported.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ExportFormat {
    /// Photoshop's; a PSB where a PSD cannot hold it.
    Psd,
    /// A folder of PNG files with `stack.json`.
    Folder,
    /// OpenRaster.
    Ora,
    /// GIMP's.
    Xcf,
    /// Of a test.
    #[cfg(test)]
    Dummy,
}

/// What one export gave away. It says everything that an import has to know, without the stack
/// of that time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExportRecord {
    /// [`RECORD_VERSION`].
    pub version: u32,
    /// Names the document; it is in the file, too, where the format has a place for it. The same
    /// stack exported in the same way has the same key.
    pub key: String,
    /// Of the file.
    pub format: ExportFormat,
    /// The photo.
    pub photo: StackPhoto,
    /// Its camera at that time.
    pub camera: StackCamera,
    /// Bits of a sample: 8 or 16.
    pub depth: u8,
    /// [`super::Stack::inputs`] of the stack that was exported.
    pub inputs: String,
    /// Every file that was ever written under this key: a file that has another content was
    /// changed since.
    pub files: BTreeSet<ExportedFile>,
    /// What the linear colours of all pixels were multiplied with, R, G, B, in an export of even colour; such a
    /// file is for looking at, so no layer is listed and nothing of it is taken home.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evened: Option<[f64; 3]>,
    /// The image layers, nearest first.
    pub layers: Vec<ExportedLayer>,
    /// What else is in the document, from the top: nothing that is painted there is taken home.
    pub helpers: Vec<Helper>,
    /// The pieces that the elements of `layers` name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pieces: Vec<Piece>,
    /// The surfaces that the elements of `layers` name, in the model's order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub surfaces: Vec<Surface>,
    /// Files below `paint/` that were shown in the layers: what is painted over them contradicts nobody.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub paint: BTreeSet<String>,
    /// The colour profile in the document, a file below `exports/pixels/`; none: it had none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<String>,
}

/// A file as it was written.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ExportedFile {
    /// Below the folder of the export, with `/`.
    pub name: String,
    /// BLAKE3 of its content, hexadecimal.
    pub hash: String,
}

/// An image layer as it was exported.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExportedLayer {
    /// Token of the image layer; the layer's name ends with it in brackets.
    pub id: String,
    /// Name in the document.
    pub name: String,
    /// Its place in the stack, 0 nearest.
    pub order: u32,
    /// Of the image layer, in photo pixels.
    pub rect: PixelRect,
    /// Of the pixels in the document, in photo pixels: a part of `rect`.
    pub exported_rect: PixelRect,
    /// The bounding box of what some element covers, in photo pixels; a part of `exported_rect`.
    pub needed_rect: PixelRect,
    /// Hash of what is to be seen and where: the same for a layer that came back untouched, even
    /// when the editor cropped it to what is not transparent.
    pub pixels: String,
    /// The pixels themselves.
    pub baseline: Baseline,
    /// What it textures.
    pub elements: Vec<Element>,
}

/// The pixels of an image layer as they were exported, kept to tell what was painted since.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Baseline {
    /// RGBA PNG below `exports/pixels/`, named by its content.
    pub file: String,
    /// What it shows, in photo pixels.
    pub rect: PixelRect,
}

/// A layer that is no image layer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Helper {
    /// Name in the document.
    pub name: String,
    /// What it is there for.
    pub role: HelperRole,
    /// Its place, in photo pixels.
    pub rect: PixelRect,
    /// As that of an image layer: tells whether somebody painted on it.
    pub pixels: String,
}

/// What a helper layer is there for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HelperRole {
    /// The photo.
    Reference,
    /// Shows what is hidden and needed.
    Guide,
}

impl ExportFormat {
    /// All of them, the default first.
    pub const ALL: &'static [Self] = &[
        Self::Psd,
        Self::Folder,
        Self::Ora,
        Self::Xcf,
        #[cfg(test)]
        Self::Dummy,
    ];

    /// As it is typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Psd => "psd",
            Self::Folder => "folder",
            Self::Ora => "ora",
            Self::Xcf => "xcf",
            #[cfg(test)]
            Self::Dummy => "dummy",
        }
    }
}

impl std::str::FromStr for ExportFormat {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.iter().find(|format| format.name() == text);
        let names = || Self::ALL.iter().map(|format| format.name()).collect::<Vec<_>>().join(", ");
        found.copied().ok_or_else(|| format!("\"{text}\" is no format; choose one of {}", names()))
    }
}

impl std::fmt::Display for ExportFormat {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_read_as_they_are_written() {
        for &format in ExportFormat::ALL {
            assert_eq!(format.to_string().parse(), Ok(format));
            assert_eq!(serde_json::to_value(format).unwrap(), format.name());
        }
        assert!("tiff".parse::<ExportFormat>().unwrap_err().contains("psd"));
    }
}
