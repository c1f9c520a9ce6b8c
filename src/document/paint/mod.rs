//! `paint/paint.json`: what artists painted, kept by the surface that it belongs to, in pixels of the photo
//! (see `docs/formats.md`). Authored: nothing in it is derived from anything.

pub mod patch;

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::masks::{Mask, MaskFrom};
use super::stack::{StackCamera, StackPhoto};
use crate::geometry::PixelRect;

pub use patch::{Colour, ERASED, Patch};

/// The version this program writes; it reads no other.
pub const PAINT_VERSION: u32 = 1;

/// So many imports can be taken back.
pub const IMPORTS_KEPT: usize = 10;

/// All paint of a project, without its pixels, and what is needed to take imports back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PaintBook {
    /// [`PAINT_VERSION`].
    pub version: u32,
    /// Cameras under which paint was brought home, by [`PaintEntry::view`].
    pub views: BTreeMap<String, PaintedView>,
    /// Sorted by photo, surface and import; where two have the same pixel the later import shows.
    pub entries: Vec<PaintEntry>,
    /// The edited files as they were when they were last imported, by [`PaintEntry::document`].
    pub documents: BTreeMap<String, PaintedDocument>,
    /// The last [`IMPORTS_KEPT`] imports, oldest first.
    pub imports: Vec<PaintImport>,
}

/// A photo and its camera at the time of an import.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PaintedView {
    /// The photo.
    pub photo: StackPhoto,
    /// Its camera.
    pub camera: StackCamera,
}

/// What one import, or several in a row, painted on one surface of one photo.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PaintEntry {
    /// The photo.
    pub photo: String,
    /// Unique name of the object.
    pub object: String,
    /// Index within the object.
    pub face: u32,
    /// Of a face that is not planar, which of its triangles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub triangle: Option<u32>,
    /// Painted past all outlines of the image layer; this surface is the nearest one.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub beyond: bool,
    /// Token of the image layer that it was painted in.
    pub layer: String,
    /// The document that it was painted in: key of the export, `@`, and the file's path from the project, because
    /// two people may paint on copies of one export.
    pub document: String,
    /// Number of the import that brought it; a higher one lies on top.
    pub import: u32,
    /// Its camera then, in [`PaintBook::views`].
    pub view: String,
    /// The surface as it was then: one ring in world coordinates, holes bridged; empty when nobody knew.
    pub outline: Vec<[f64; 3]>,
    /// RGBA PNG of `rect`, below `paint/`. Black without opacity: not painted; white without opacity:
    /// painted away.
    pub file: String,
    /// In photo pixels; may reach outside the photo.
    pub rect: PixelRect,
    /// Painted pixels.
    pub pixels: u64,
}

/// An edited file at its last import.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct PaintedDocument {
    /// By token, those with paint.
    pub layers: BTreeMap<String, PaintedLayer>,
}

/// An image layer in an edited file at its last import.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct PaintedLayer {
    /// Hash of what it showed: one that still has it was not touched since.
    pub shown: String,
    /// Painted pixels.
    pub painted: u64,
    /// Those of them that were painted away.
    pub erased: u64,
}

/// One import, and how to take it back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PaintImport {
    /// Counted from 1.
    pub number: u32,
    /// When, in seconds since 1970, UTC.
    pub time: u64,
    /// The files that were imported.
    pub files: Vec<String>,
    /// The photos that they are of.
    pub photos: Vec<String>,
    /// Painted pixels that were new or other than before.
    pub pixels: u64,
    /// Entries that it added.
    pub added: Vec<EntryName>,
    /// Entries that it replaced, as they were.
    pub replaced: Vec<PaintEntry>,
    /// The documents as they were; none where they were not known.
    pub documents: BTreeMap<String, Option<PaintedDocument>>,
    /// The masks that it put into `project.json`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub masks: Vec<ImportedMask>,
}

/// A mask that an import brought, and what stood in its place.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ImportedMask {
    /// The photo.
    pub photo: String,
    /// Whose mask it is.
    pub from: MaskFrom,
    /// What the same maker had made before; none where there was nothing.
    pub before: Option<Mask>,
}

/// What tells one entry from all others.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct EntryName {
    /// [`PaintEntry::file`].
    pub file: String,
    /// [`PaintEntry::document`].
    pub document: String,
    /// [`PaintEntry::layer`].
    pub layer: String,
    /// [`PaintEntry::import`].
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
        }
    }
}

impl PaintEntry {
    /// What the book is sorted by.
    fn order(&self) -> impl Ord + use<'_> {
        let surface = (&self.photo, &self.object, self.face, self.triangle, self.beyond);
        (surface, self.import, &self.layer, &self.document, &self.file)
    }

    /// What tells it from all others.
    pub fn name(&self) -> EntryName {
        let (file, document, layer) = (self.file.clone(), self.document.clone(), self.layer.clone());
        EntryName { file, document, layer, import: self.import }
    }

    /// `object[index]`, how messages name its face.
    pub fn face_name(&self) -> String {
        format!("{}[{}]", self.object, self.face)
    }
}

impl PaintBook {
    /// No paint, and nothing to take back.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty() && self.imports.is_empty() && self.documents.is_empty()
    }

    /// The number of the next import.
    pub fn next_import(&self) -> u32 {
        let entries = self.entries.iter().map(|entry| entry.import);
        entries.chain(self.imports.iter().map(|import| import.number)).max().unwrap_or(0) + 1
    }

    /// The paint of one photo, earlier imports first.
    pub fn of_photo(&self, photo: &str) -> Vec<&PaintEntry> {
        let mut entries: Vec<_> = self.entries.iter().filter(|entry| entry.photo == photo).collect();
        entries.sort_by_key(|entry| entry.import);
        entries
    }

    /// Every file that is named, by entries or by imports that can be taken back.
    pub fn files(&self) -> BTreeSet<&str> {
        let replaced = self.imports.iter().flat_map(|import| &import.replaced);
        self.entries.iter().chain(replaced).map(|entry| entry.file.as_str()).collect()
    }

    /// Adds an import that was made to the history, which forgets the oldest one beyond [`IMPORTS_KEPT`].
    pub fn remember(&mut self, import: PaintImport) {
        self.imports.push(import);
        let surplus = self.imports.len().saturating_sub(IMPORTS_KEPT);
        self.imports.drain(..surplus);
    }

    /// Takes the last import back; none when there is none. What it added is gone, what it replaced is there
    /// again.
    pub fn take_back(&mut self) -> Option<PaintImport> {
        let import = self.imports.pop()?;
        self.entries.retain(|entry| !import.added.contains(&entry.name()));
        self.entries.extend(import.replaced.iter().cloned());
        for (key, before) in &import.documents {
            match before {
                Some(document) => self.documents.insert(key.clone(), document.clone()),
                None => self.documents.remove(key),
            };
        }
        self.tidy();
        Some(import)
    }

    /// Puts entries in order, and forgets views that none of them names.
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
            face,
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

    fn import(number: u32, added: Vec<EntryName>, replaced: Vec<PaintEntry>) -> PaintImport {
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
