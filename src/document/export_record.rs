//! Export records: `exports/<document key>.json` describes what was exported, so that edited documents can be
//! imported even after the stack was rebuilt.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::stack::{Element, FacePiece, StackCamera, StackPhoto, StackSurface};
use quadratura_base::geometry::PixelRect;
use quadratura_foliage::SlabFrame;

/// The version of the format that this program writes, and the only one that it reads.
pub const RECORD_VERSION: u32 = 2;

/// The number of hexadecimal digits of a document's key.
pub const KEY_DIGITS: usize = 20;

/// A format of exported layered images. The enum is closed, because records on disk and the command line name its variants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ExportFormat {
    /// Photoshop's PSD, or PSB where a PSD cannot hold the image.
    Psd,
    /// A folder of PNG files with `stack.json`.
    Folder,
    /// OpenRaster.
    Ora,
    /// GIMP's XCF.
    Xcf,
}

/// A record of one export. It contains everything that an import needs to know, without the stack of that time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExportRecord {
    /// The format's version, [`RECORD_VERSION`].
    pub version: u32,
    /// The document's key, also stored in the file where the format has a place for it. The same stack exported in
    /// the same way gets the same key.
    pub key: String,
    /// The format of the file.
    pub format: ExportFormat,
    /// The exported photo.
    pub photo: StackPhoto,
    /// The photo's camera at the time of the export.
    pub camera: StackCamera,
    /// The bits per sample: 8 or 16.
    pub depth: u8,
    /// The value of [`super::Stack::inputs`] of the exported stack.
    pub inputs: String,
    /// All files that were ever written under this key. A file with other content was changed since.
    pub files: BTreeSet<ExportedFile>,
    /// The factors for R, G, B that the linear colours were multiplied with, in an export with matched exposure.
    /// Such a file is only for viewing: no layers are listed, and it is not imported.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evened: Option<[f64; 3]>,
    /// The image layers, nearest first.
    pub layers: Vec<ExportedLayer>,
    /// The other layers of the document, from the top; paint on them is not imported.
    pub helpers: Vec<HelperLayer>,
    /// The pieces to which the elements of `layers` refer.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pieces: Vec<FacePiece>,
    /// The surfaces to which the elements of `layers` refer, in the model's order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub surfaces: Vec<StackSurface>,
    /// The files below `paint/` that were visible in the layers. Changing that paint in the editor is not a
    /// conflict.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub paint: BTreeSet<String>,
    /// The colour profile of the document, a file below `exports/pixels/`; `None` where it had none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<String>,
    /// What the images are of, where the export is of a species of tree and not of a photo. `photo` then has the file's name and the
    /// size of the canvas, `camera` the unit matrix, and layers have no elements.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tree: Option<ExportedTree>,
}

/// The images of a species as they were exported.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExportedTree {
    /// The name of the species.
    pub species: String,
    /// The name of the sub-object; `None` for the whole plant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// The hash of the plant's geometry and materials, without paint.
    pub plant: String,
    /// Where the images are.
    pub frame: SlabFrame,
    /// For each direction, in the order of [`quadratura_foliage::DIRECTION_NAMES`], the file of its samples below `pixels/`.
    pub samples: Vec<String>,
    /// For each layer in the order of the record, its direction and its slab.
    pub slabs: Vec<[usize; 2]>,
}

/// A file as it was written.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ExportedFile {
    /// The path below the export's folder, with `/`.
    pub name: String,
    /// The BLAKE3 hash of the content, hexadecimal.
    pub hash: String,
}

/// The index of an image layer among those of an export's record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RecordedIndex(pub usize);

/// An image layer as it was exported.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExportedLayer {
    /// The token of the image layer; the layer's name ends with it in brackets.
    pub id: String,
    /// The name in the document.
    pub name: String,
    /// The order in the stack, 0 nearest.
    pub order: u32,
    /// The image layer's rectangle, in photo pixels.
    pub rect: PixelRect,
    /// The rectangle of the pixels in the document, in photo pixels; a part of `rect`.
    pub exported_rect: PixelRect,
    /// The bounding box of the pixels that elements cover, in photo pixels; a part of `exported_rect`.
    pub needed_rect: PixelRect,
    /// The hash of the visible pixels and their positions. It is the same for a layer that was not edited, even
    /// when the editor cropped it to its non-transparent part.
    pub pixels: String,
    /// The exported pixels.
    pub baseline: Baseline,
    /// The elements that the layer textures.
    pub elements: Vec<Element>,
}

/// The pixels of an image layer as they were exported, kept to detect what was painted since.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Baseline {
    /// The file, an RGBA PNG below `exports/pixels/` that is named by its content's hash.
    pub file: String,
    /// The rectangle that the file shows, in photo pixels.
    pub rect: PixelRect,
}

/// A layer of the document that is not an image layer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct HelperLayer {
    /// The name in the document.
    pub name: String,
    /// The purpose of the layer.
    pub role: HelperRole,
    /// The layer's rectangle, in photo pixels.
    pub rect: PixelRect,
    /// The hash of its pixels, as for an image layer; it tells whether the layer was painted on.
    pub pixels: String,
}

/// The purpose of a helper layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HelperRole {
    /// The photo, for reference.
    Reference,
    /// A guide that shows the occluded pixels that are needed.
    Guide,
    /// The visible pixels of faces that are in no image layer.
    Leftovers,
}

impl ExportFormat {
    /// All formats, the default first.
    pub const ALL: &'static [Self] = &[Self::Psd, Self::Folder, Self::Ora, Self::Xcf];

    /// Returns the name that is typed on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Psd => "psd",
            Self::Folder => "folder",
            Self::Ora => "ora",
            Self::Xcf => "xcf",
        }
    }
}

impl std::str::FromStr for ExportFormat {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.iter().find(|format| format.name() == text);
        let names = || Self::ALL.iter().map(|format| format.name()).collect::<Vec<_>>().join(", ");
        found.copied().ok_or_else(|| format!("\"{text}\" is not a format; choose one of {}", names()))
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
