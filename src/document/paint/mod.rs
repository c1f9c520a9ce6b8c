//! The paint book `paint/paint.json`: all paint of a project by surface, in photo pixels (see `docs/formats.md`).
//! It is authored data; nothing in it is derived.

pub mod patch;
mod undo;

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::in_use::FilesInUse;
use super::masks::{Mask, MaskOrigin};
use super::stack::{StackCamera, StackPhoto};
use super::stroke::BrushMode;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::FaceIndex;
use quadratura_layers::fill::PaintPlace;

pub use patch::{ERASED, PaintColour, PaintPatch};

/// The version of the format that this program writes, and the only one that it reads.
pub const PAINT_VERSION: u32 = 1;

/// The number of imports that can be undone.
pub const IMPORTS_KEPT: usize = 10;

/// The beginning of the keys of the documents that hold strokes of the brush: one for each photo with its camera.
const BRUSH_DOCUMENT: &str = "brush-";

/// Returns the key of the document with the brush strokes on a photo, whose camera has this id in [`PaintBook::views`].
pub fn brush_document(view: &str) -> String {
    format!("{BRUSH_DOCUMENT}{view}")
}

/// All paint of a project without its pixels, and what is needed to undo imports.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PaintBook {
    /// The format's version, [`PAINT_VERSION`].
    pub version: u32,
    /// The cameras under which paint was imported, by [`PaintEntry::view`].
    pub views: BTreeMap<String, PaintedView>,
    /// The entries, sorted by photo, surface and import. Where two have the same pixel, the later import is on top.
    pub entries: Vec<PaintEntry>,
    /// The edited files as they were at their last import, by [`PaintEntry::document`].
    pub documents: BTreeMap<String, PaintedDocument>,
    /// The last [`IMPORTS_KEPT`] imports, oldest first.
    pub imports: Vec<PaintImport>,
    /// The hold on the files of this book, where it was read from disk or written to it.
    #[serde(skip)]
    pub in_use: FilesInUse,
}

/// A photo and its camera at the time of an import.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PaintedView {
    /// The photo.
    pub photo: StackPhoto,
    /// The photo's camera.
    pub camera: StackCamera,
}

/// The paint of one import, or of several in a row, on one surface of one photo, or on its surroundings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PaintEntry {
    /// The photo's name.
    pub photo: String,
    /// The unique name of the object; `[surroundings]` for the surroundings.
    pub object: String,
    /// The face's index within the object; `None` for the surroundings, which have no faces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub face: Option<FaceIndex>,
    /// The triangle's index within the face, for a face that is not planar.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub triangle: Option<u32>,
    /// Whether the paint lies outside of all outlines of the image layer; this surface is the nearest one.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub beyond: bool,
    /// The token of the image layer in which it was painted.
    pub layer: String,
    /// The document in which it was painted: the export's key, `@`, and the file's path from the project, because
    /// two people may paint on copies of one export; for strokes of the brush, `brush-` and the value of `view`.
    pub document: String,
    /// The number of the import; paint of a higher one lies on top.
    pub import: u32,
    /// The key in [`PaintBook::views`] of the camera at the time of the import.
    pub view: String,
    /// The surface at the time of the import: one ring in world coordinates with bridged holes, or empty where it
    /// is unknown, and for the surroundings.
    pub outline: Vec<[f64; 3]>,
    /// An RGBA PNG of `rect`, below `paint/`. A black transparent pixel is not painted, a white transparent one is
    /// erased.
    pub file: String,
    /// The rectangle in photo pixels; it may extend beyond the photo.
    pub rect: PixelRect,
    /// The number of painted pixels.
    pub pixels: u64,
}

/// An edited file at its last import.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct PaintedDocument {
    /// The layers with paint, by token.
    pub layers: BTreeMap<String, PaintedLayer>,
}

/// An image layer of an edited file at its last import.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct PaintedLayer {
    /// The hash of its visible pixels; while it matches, the layer was not edited since.
    pub shown: String,
    /// The number of painted pixels.
    pub painted: u64,
    /// The number of painted pixels that were erased.
    pub erased: u64,
}

/// An import, with what is needed to undo it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PaintImport {
    /// The number, counted from 1.
    pub number: u32,
    /// The time in seconds since 1970, UTC.
    pub time: u64,
    /// The files that were imported.
    pub files: Vec<String>,
    /// The photos to which the files belong.
    pub photos: Vec<String>,
    /// The number of painted pixels that are new or were changed.
    pub pixels: u64,
    /// The entries that it added.
    pub added: Vec<EntryKey>,
    /// The entries that it replaced, as they were before.
    pub replaced: Vec<PaintEntry>,
    /// The documents as they were before; `None` where they were unknown.
    pub documents: BTreeMap<String, Option<PaintedDocument>>,
    /// The masks that it added to `project.json`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub masks: Vec<ImportedMask>,
    /// The mode of the brush, where it is a stroke in the 3D view and not an import of files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brush: Option<BrushMode>,
}

/// A mask that came with an import, and the mask that it replaced.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ImportedMask {
    /// The photo's name.
    pub photo: String,
    /// The origin of the mask.
    pub from: MaskOrigin,
    /// The earlier mask of the same origin; `None` where there was none.
    pub before: Option<Mask>,
}

/// The key of an entry, which is unique in the book.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct EntryKey {
    /// The value of [`PaintEntry::file`].
    pub file: String,
    /// The value of [`PaintEntry::document`].
    pub document: String,
    /// The value of [`PaintEntry::layer`].
    pub layer: String,
    /// The value of [`PaintEntry::import`].
    pub import: u32,
}

impl Default for PaintBook {
    fn default() -> Self {
        Self {
            version: PAINT_VERSION,
            views: BTreeMap::new(),
            entries: Vec::new(),
            documents: BTreeMap::new(),
            imports: Vec::new(),
            in_use: FilesInUse::default(),
        }
    }
}

impl PaintEntry {
    /// Returns the key by which the book is sorted.
    fn order(&self) -> impl Ord + use<'_> {
        let surface = (&self.photo, &self.object, self.face, self.triangle, self.beyond);
        (surface, self.import, &self.layer, &self.document, &self.file)
    }

    /// Returns the entry's key.
    pub fn name(&self) -> EntryKey {
        EntryKey {
            file: self.file.clone(),
            document: self.document.clone(),
            layer: self.layer.clone(),
            import: self.import,
        }
    }

    /// Returns the place of the paint, which decides where it is seen.
    pub fn place(&self) -> PaintPlace<'_> {
        PaintPlace { photo: &self.photo, object: &self.object, face: self.face, import: self.import }
    }

    /// Returns true when the paint is of strokes of the brush.
    pub fn is_of_brush(&self) -> bool {
        self.document.starts_with(BRUSH_DOCUMENT) && !self.document.contains('@')
    }

    /// Returns `object[index]`, the name of its face in messages, or the name of the surroundings.
    pub fn face_name(&self) -> String {
        self.face.map_or_else(|| self.object.clone(), |face| format!("{}[{face}]", self.object))
    }
}

impl PaintBook {
    /// Returns true when there is no paint and no import to undo.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty() && self.imports.is_empty() && self.documents.is_empty()
    }

    /// Returns the number of the next import.
    pub fn next_import(&self) -> u32 {
        let entries = self.entries.iter().map(|entry| entry.import);
        entries.chain(self.imports.iter().map(|import| import.number)).max().unwrap_or(0) + 1
    }

    /// Returns the paint of one photo, earlier imports first.
    pub fn of_photo(&self, photo: &str) -> Vec<&PaintEntry> {
        let mut entries: Vec<_> = self.entries.iter().filter(|entry| entry.photo == photo).collect();
        entries.sort_by_key(|entry| entry.import);
        entries
    }

    /// Returns all files that are referred to, by entries or by imports that can be undone.
    pub fn files(&self) -> BTreeSet<&str> {
        let replaced = self.imports.iter().flat_map(|import| &import.replaced);
        self.entries.iter().chain(replaced).map(|entry| entry.file.as_str()).collect()
    }

    /// Adds an import to the history and drops the oldest one beyond [`IMPORTS_KEPT`].
    pub fn remember(&mut self, import: PaintImport) {
        self.imports.push(import);
        let surplus = self.imports.len().saturating_sub(IMPORTS_KEPT);
        self.imports.drain(..surplus);
    }

    /// Sorts the entries, and drops views to which none of them refers.
    pub fn tidy(&mut self) {
        self.entries.sort_by(|a, b| a.order().cmp(&b.order()));
        let replaced = self.imports.iter().flat_map(|import| &import.replaced);
        let named: BTreeSet<String> =
            self.entries.iter().chain(replaced).map(|entry| entry.view.clone()).collect();
        self.views.retain(|view, _| named.contains(view));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(face: u32, import: u32, file: &str) -> PaintEntry {
        PaintEntry {
            photo: "a.png".into(),
            object: "wall".into(),
            face: Some(FaceIndex(face)),
            triangle: None,
            beyond: false,
            layer: "t1".into(),
            document: "k1".into(),
            import,
            view: "v1".into(),
            outline: vec![],
            file: file.into(),
            rect: PixelRect { x: 1, y: 2, w: 3, h: 4 },
            pixels: 5,
        }
    }

    fn import(number: u32, added: Vec<EntryKey>, replaced: Vec<PaintEntry>) -> PaintImport {
        PaintImport {
            number,
            time: 0,
            files: vec![],
            photos: vec![],
            pixels: 0,
            added,
            replaced,
            documents: BTreeMap::from([("k1".into(), None)]),
            masks: vec![],
            brush: None,
        }
    }

    #[test]
    fn an_import_taken_back_leaves_the_book_as_it_was() {
        let mut before =
            PaintBook { entries: vec![entry(1, 1, "old"), entry(2, 1, "kept")], ..PaintBook::default() };
        let view = StackCamera { K: [[0.0; 3]; 3], R: [[0.0; 3]; 3], t: [0.0; 3] };
        let photo = StackPhoto { name: "a.png".into(), width: 1, height: 1 };
        before.views.insert("v1".into(), PaintedView { photo, camera: view });
        before.tidy();
        let mut book = before.clone();
        book.entries.retain(|entry| entry.file != "old");
        book.entries.push(entry(1, 2, "new"));
        book.documents.insert("k1".into(), PaintedDocument::default());
        book.remember(import(2, vec![entry(1, 2, "new").name()], vec![entry(1, 1, "old")]));
        book.tidy();
        assert_eq!(book.next_import(), 3);
        assert_eq!(book.files().into_iter().collect::<Vec<_>>(), ["kept", "new", "old"]);
        assert_eq!(book.take_back().unwrap().number, 2);
        assert_eq!(book, before);
        assert!(book.take_back().is_none());
    }

    #[test]
    fn ten_imports_are_remembered() {
        let mut book = PaintBook::default();
        (1..=13).for_each(|number| book.remember(import(number, vec![], vec![])));
        let numbers: Vec<_> = book.imports.iter().map(|import| import.number).collect();
        assert_eq!(numbers, (4..=13).collect::<Vec<_>>());
    }
}
