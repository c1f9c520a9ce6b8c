//! New paint meets the project's: what stays, what is replaced, what contradicts.
//!
//! The paint of a layer of a document is *all* of its paint: what was imported from it before and is not there any
//! more was taken back in the editor. A pixel that is as it was imported before keeps its place among the
//! imports, so that saving a file again brings none of its old strokes above another file's newer ones.

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::FxHashSet;

use super::report::Conflict;
use crate::document::paint::{PaintBook, PaintEntry, Patch};
use crate::error::Result;

/// What is being imported: one layer of one document.
pub struct Arrival<'a> {
    /// The photo.
    pub photo: &'a str,
    /// Token.
    pub layer: &'a str,
    /// Key.
    pub document: &'a str,
    /// Number of this import.
    pub import: u32,
    /// Camera of the document.
    pub view: &'a str,
    /// Files of paint that were exported with it: painting over them contradicts nobody.
    pub known: &'a BTreeSet<String>,
}

/// A surface with paint.
#[derive(Debug, Clone, PartialEq)]
pub struct OnSurface {
    /// Unique name of the object.
    pub object: String,
    /// Index within the object.
    pub face: u32,
    /// Of a face that is not planar.
    pub triangle: Option<u32>,
    /// Past all outlines.
    pub beyond: bool,
    /// As it is in the document's camera's world.
    pub outline: Vec<[f64; 3]>,
    /// All of its paint in the layer.
    pub patch: Patch,
}

/// How the book changes.
#[derive(Debug, Default)]
pub struct Settled {
    /// Entries that go, as they are in the book.
    pub removed: Vec<PaintEntry>,
    /// Entries that come, without a file yet.
    pub added: Vec<(PaintEntry, Patch)>,
    /// Pixels that show other paint than before, each once, however many surfaces and documents share it.
    pub changed: u64,
    /// Paint of other documents that is contradicted.
    pub conflicts: Vec<Conflict>,
}

type SurfaceKey = (String, u32, Option<u32>, bool);

fn key_of(entry: &PaintEntry) -> SurfaceKey {
    (entry.object.clone(), entry.face, entry.triangle, entry.beyond)
}

/// Brings the paint of one layer into the book; `read` gives the pixels of an entry, none where its picture is damaged.
///
/// # Errors
/// What `read` says.
pub fn settle(
    book: &PaintBook,
    arrival: &Arrival,
    surfaces: Vec<OnSurface>,
    read: &dyn Fn(&PaintEntry) -> Result<Option<Patch>>,
) -> Result<Settled> {
    let of_photo: Vec<&PaintEntry> = book.of_photo(arrival.photo);
    let is_own = |entry: &&PaintEntry| entry.document == arrival.document && entry.layer == arrival.layer;
    let mut by_surface: BTreeMap<SurfaceKey, OnSurface> = BTreeMap::new();
    for surface in surfaces {
        let key = (surface.object.clone(), surface.face, surface.triangle, surface.beyond);
        by_surface.insert(key, surface);
    }
    let (mut settled, mut changed) = (Settled::default(), FxHashSet::default());
    let own_keys: BTreeSet<SurfaceKey> = of_photo.iter().copied().filter(is_own).map(key_of).collect();
    let keys: BTreeSet<SurfaceKey> = by_surface.keys().cloned().chain(own_keys).collect();
    for key in keys {
        let (own, others): (Vec<&PaintEntry>, Vec<&PaintEntry>) =
            of_photo.iter().copied().filter(|entry| key_of(entry) == key).partition(is_own);
        let surface = by_surface.remove(&key);
        Meeting { arrival, own, others, read }.settle(surface, &mut settled, &mut changed)?;
    }
    settled.changed = changed.len() as u64;
    Ok(settled)
}

/// New and old paint of one surface.
struct Meeting<'a> {
    arrival: &'a Arrival<'a>,
    /// Of the same layer of the same document, earlier imports first.
    own: Vec<&'a PaintEntry>,
    others: Vec<&'a PaintEntry>,
    read: &'a dyn Fn(&PaintEntry) -> Result<Option<Patch>>,
}

impl Meeting<'_> {
    fn settle(
        &self,
        surface: Option<OnSurface>,
        settled: &mut Settled,
        changed: &mut FxHashSet<(i32, i32)>,
    ) -> Result<()> {
        let others = self.shown_by_others()?;
        let mut fresh = surface.as_ref().map_or_else(|| Patch::of_pixels(&[]), |s| s.patch.clone());
        let mut kept = Vec::new();
        for &entry in self.own.iter().rev() {
            let Some(before) = (self.read)(entry)? else {
                // The layer has all of its paint, so it has what was lost.
                settled.removed.push(entry.clone());
                continue;
            };
            let stays = before.picked(|x, y, colour| fresh.at(x, y) == Some(colour));
            let gone = |x: i32, y: i32| surface.as_ref().is_none_or(|s| s.patch.at(x, y).is_none());
            let bared = before.iter().filter(|&(x, y, old)| gone(x, y) && others.at(x, y) != Some(old));
            changed.extend(bared.map(|(x, y, _)| (x, y)));
            fresh = fresh.picked(|x, y, _| stays.at(x, y).is_none());
            kept.push((entry, before, stays));
        }
        let new = fresh.iter().filter(|&(x, y, colour)| others.at(x, y) != Some(colour));
        changed.extend(new.map(|(x, y, _)| (x, y)));
        settled.conflicts.extend(self.conflicts(&fresh)?);
        if !fresh.is_empty() {
            fresh = self.gather_newest(&mut kept, fresh);
        }
        for (entry, before, stays) in kept {
            if stays != before {
                settled.removed.push(entry.clone());
                if !stays.is_empty() {
                    settled.added.push((PaintEntry { file: String::new(), ..entry.clone() }, stays));
                }
            }
        }
        if let (false, Some(surface)) = (fresh.is_empty(), surface) {
            settled.added.push((self.entry(surface), fresh));
        }
        Ok(())
    }

    /// What all other paint of the surface shows together.
    fn shown_by_others(&self) -> Result<Patch> {
        let mut shown = Patch::of_pixels(&[]);
        for entry in &self.others {
            if let Some(patch) = (self.read)(entry)? {
                shown = shown.under(&patch);
            }
        }
        Ok(shown)
    }

    /// Own paint that nobody's newer paint lies over becomes one with the new paint.
    fn gather_newest(&self, kept: &mut [(&PaintEntry, Patch, Patch)], fresh: Patch) -> Patch {
        let newest_other = self.others.iter().map(|entry| entry.import).max().unwrap_or(0);
        let own = kept.iter_mut().filter(|(entry, ..)| entry.import > newest_other);
        own.fold(fresh, |fresh, (_, _, stays)| std::mem::replace(stays, Patch::of_pixels(&[])).under(&fresh))
    }

    fn conflicts(&self, fresh: &Patch) -> Result<Vec<Conflict>> {
        let mut conflicts = Vec::new();
        let others = self.others.iter().filter(|entry| entry.document != self.arrival.document);
        for entry in others.filter(|entry| !self.arrival.known.contains(&entry.file)) {
            let Some(theirs) = (self.read)(entry)? else { continue };
            let other = |x: i32, y: i32, colour| theirs.at(x, y).is_some_and(|theirs| theirs != colour);
            let pixels = fresh.iter().filter(|&(x, y, colour)| other(x, y, colour)).count() as u64;
            if pixels > 0 {
                let (face, document) = (entry.face_name(), entry.document.clone());
                conflicts.push(Conflict { face, import: entry.import, document, pixels });
            }
        }
        Ok(conflicts)
    }

    fn entry(&self, surface: OnSurface) -> PaintEntry {
        let patch = surface.patch.rect();
        PaintEntry {
            photo: self.arrival.photo.to_owned(),
            object: surface.object,
            face: surface.face,
            triangle: surface.triangle,
            beyond: surface.beyond,
            layer: self.arrival.layer.to_owned(),
            document: self.arrival.document.to_owned(),
            import: self.arrival.import,
            view: self.arrival.view.to_owned(),
            outline: surface.outline,
            file: String::new(),
            rect: patch,
            pixels: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::paint::Colour;

    const RED: Colour = [65535, 0, 0, 65535];
    const BLUE: Colour = [0, 0, 65535, 65535];

    /// A book whose files are patches in memory.
    #[derive(Default)]
    struct Shelf {
        book: PaintBook,
        patches: BTreeMap<String, Patch>,
        known: BTreeSet<String>,
    }

    impl Shelf {
        /// Imports paint of the wall from a document.
        fn import(&mut self, document: &str, import: u32, pixels: &[(i32, i32, Colour)]) -> Settled {
            let arrival =
                Arrival { photo: "a.png", layer: "t1", document, import, view: "v", known: &self.known };
            let surface = OnSurface {
                object: "wall".into(),
                face: 0,
                triangle: None,
                beyond: false,
                outline: vec![],
                patch: Patch::of_pixels(pixels),
            };
            let surfaces = if pixels.is_empty() { vec![] } else { vec![surface] };
            let read = |entry: &PaintEntry| Ok(self.patches.get(&entry.file).cloned());
            let settled = settle(&self.book, &arrival, surfaces, &read).unwrap();
            self.book.entries.retain(|entry| !settled.removed.contains(entry));
            for (number, (entry, patch)) in settled.added.iter().enumerate() {
                let file = format!("{document} {import} {number}");
                self.patches.insert(file.clone(), patch.clone());
                self.book.entries.push(PaintEntry { file, ..entry.clone() });
            }
            self.book.tidy();
            settled
        }

        /// What is to be seen, from the left.
        fn seen(&self) -> Vec<(i32, Colour)> {
            let all = self.book.of_photo("a.png").into_iter().map(|entry| self.patches[&entry.file].clone());
            let all = all.reduce(|below, above| below.under(&above)).unwrap_or(Patch::of_pixels(&[]));
            all.iter().map(|(x, _, colour)| (x, colour)).collect()
        }
    }

    #[test]
    fn the_same_file_again_changes_nothing() {
        let mut shelf = Shelf::default();
        assert_eq!(shelf.import("k1", 1, &[(0, 0, RED)]).changed, 1);
        let book = shelf.book.clone();
        let again = shelf.import("k1", 2, &[(0, 0, RED)]);
        assert_eq!((again.changed, shelf.book), (0, book));
    }

    #[test]
    fn paint_that_was_taken_back_in_the_editor_is_gone_and_more_paint_is_added() {
        let mut shelf = Shelf::default();
        shelf.import("k1", 1, &[(0, 0, RED), (1, 0, RED)]);
        assert_eq!(shelf.import("k1", 2, &[(1, 0, RED), (2, 0, BLUE)]).changed, 2);
        assert_eq!(shelf.seen(), [(1, RED), (2, BLUE)]);
        assert_eq!(shelf.book.entries.len(), 1, "one surface, one file");
        shelf.import("k1", 3, &[]);
        assert!(shelf.book.entries.is_empty());
    }

    #[test]
    fn paint_whose_picture_was_lost_comes_back_with_the_file_that_brought_it() {
        let mut shelf = Shelf::default();
        shelf.import("k1", 1, &[(0, 0, RED), (1, 0, RED)]);
        shelf.patches.clear();
        assert_eq!(shelf.import("k1", 2, &[(0, 0, RED), (1, 0, RED)]).changed, 2);
        assert_eq!(shelf.seen(), [(0, RED), (1, RED)]);
        assert_eq!(shelf.book.entries.len(), 1);
    }

    #[test]
    fn the_same_paint_in_a_copy_of_the_file_changes_nothing() {
        let mut shelf = Shelf::default();
        assert_eq!(shelf.import("k1@a.psd", 1, &[(0, 0, RED), (1, 0, RED)]).changed, 2);
        assert_eq!(shelf.import("k1@copy.psd", 2, &[(0, 0, RED), (1, 0, BLUE)]).changed, 1);
        assert_eq!(shelf.import("k1@copy.psd", 3, &[]).changed, 1, "of the two only the blue one vanishes");
    }

    #[test]
    fn of_two_files_the_newer_stroke_is_on_top_and_the_conflict_is_told() {
        let mut shelf = Shelf::default();
        shelf.import("k1", 1, &[(0, 0, RED), (1, 0, RED)]);
        let second = shelf.import("k2", 2, &[(1, 0, BLUE), (2, 0, BLUE)]);
        let conflict = Conflict { face: "wall[0]".into(), import: 1, document: "k1".into(), pixels: 1 };
        assert_eq!(second.conflicts, [conflict]);
        assert_eq!(shelf.seen(), [(0, RED), (1, BLUE), (2, BLUE)]);
        // A stroke elsewhere in the first file does not bring its old one up.
        shelf.import("k1", 3, &[(0, 0, RED), (1, 0, RED), (9, 0, RED)]);
        assert_eq!(shelf.seen(), [(0, RED), (1, BLUE), (2, BLUE), (9, RED)]);
    }

    #[test]
    fn painting_over_paint_that_was_exported_contradicts_nobody() {
        let mut shelf = Shelf::default();
        shelf.import("k1", 1, &[(0, 0, RED)]);
        shelf.known = shelf.book.files().into_iter().map(str::to_owned).collect();
        assert!(shelf.import("k2", 2, &[(0, 0, BLUE)]).conflicts.is_empty());
        shelf.import("k2", 3, &[]);
        assert_eq!(shelf.seen(), [(0, RED)], "taken back, the older paint shows again");
    }
}
