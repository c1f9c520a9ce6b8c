//! Merging of new paint with the project's: what stays, what is replaced, what conflicts.
//!
//! The paint of a document's layer is *all* of its paint: earlier paint that it no longer contains was removed in
//! the editor. A pixel that is the same as at an earlier import keeps its position among the imports, so that
//! saving a file again does not move its old strokes above newer ones of another file.

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::FxHashSet;

use super::report::Conflict;
use quadratura_base::error::Result;
use quadratura_base::scene::FaceIndex;
use quadratura_document::paint::{PaintBook, PaintEntry, PaintPatch};

/// The layer of a document that is being imported.
pub struct ImportedLayer<'a> {
    /// The photo's name.
    pub photo: &'a str,
    /// The layer's token.
    pub layer: &'a str,
    /// The key of the document.
    pub document: &'a str,
    /// The number of this import.
    pub import: u32,
    /// The id of the document's camera.
    pub view: &'a str,
    /// The files of paint that were visible in the export: replacing them is not a conflict.
    pub known: &'a BTreeSet<String>,
    /// The imports whose paint stays in its photo.
    pub only_here: &'a BTreeSet<u32>,
}

/// The paint of a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfacePaint {
    /// The unique name of the object; `[surroundings]` for the surroundings.
    pub object: String,
    /// The face's index within the object; `None` for the surroundings.
    pub face: Option<FaceIndex>,
    /// The triangle's index within the face, for a face that is not planar.
    pub triangle: Option<u32>,
    /// Whether the paint is outside of all outlines.
    pub beyond: bool,
    /// The surface's outline in world coordinates, at the time of the export.
    pub outline: Vec<[f64; 3]>,
    /// All paint on it in the layer.
    pub patch: PaintPatch,
}

/// The changes to be made in the paint book.
#[derive(Debug, Default)]
pub struct BookChanges {
    /// The entries to be removed, as they are in the book.
    pub removed: Vec<PaintEntry>,
    /// The entries to be added, which have no file yet.
    pub added: Vec<(PaintEntry, PaintPatch)>,
    /// The number of pixels that show other paint than before, each counted once, however many surfaces and
    /// documents share it.
    pub changed: u64,
    /// Conflicts with paint of other documents.
    pub conflicts: Vec<Conflict>,
}

/// Object, face, triangle, and whether the paint is outside of all outlines.
type SurfaceKey = (String, Option<FaceIndex>, Option<u32>, bool);

/// Returns the surface of an entry.
fn key_of(entry: &PaintEntry) -> SurfaceKey {
    (entry.object.clone(), entry.face, entry.triangle, entry.beyond)
}

/// Merges the paint of one layer into the book. `read` returns the pixels of an entry, or `None` where its file is
/// damaged.
///
/// # Errors
/// Returns the errors of `read`.
pub fn settle(
    book: &PaintBook,
    arrival: &ImportedLayer,
    surfaces: Vec<SurfacePaint>,
    read: &dyn Fn(&PaintEntry) -> Result<Option<PaintPatch>>,
) -> Result<BookChanges> {
    let of_photo: Vec<&PaintEntry> = book.of_photo(arrival.photo);
    let is_own = |entry: &&PaintEntry| entry.document == arrival.document && entry.layer == arrival.layer;
    let mut by_surface: BTreeMap<SurfaceKey, SurfacePaint> = BTreeMap::new();
    for surface in surfaces {
        let key = (surface.object.clone(), surface.face, surface.triangle, surface.beyond);
        by_surface.insert(key, surface);
    }
    let (mut settled, mut changed) = (BookChanges::default(), FxHashSet::default());
    let own_keys: BTreeSet<SurfaceKey> = of_photo.iter().copied().filter(is_own).map(key_of).collect();
    let first_kept = book.imports.first().map_or(arrival.import, |import| import.number);
    let keys: BTreeSet<SurfaceKey> = by_surface.keys().cloned().chain(own_keys).collect();
    for key in keys {
        let (own, others): (Vec<&PaintEntry>, Vec<&PaintEntry>) =
            of_photo.iter().copied().filter(|entry| key_of(entry) == key).partition(is_own);
        let surface = by_surface.remove(&key);
        SurfaceMerge { arrival, own, others, first_kept, read }.settle(
            surface,
            &mut settled,
            &mut changed,
        )?;
    }
    settled.changed = changed.len() as u64;
    Ok(settled)
}

/// New and existing paint of one surface.
struct SurfaceMerge<'a> {
    arrival: &'a ImportedLayer<'a>,
    /// The entries of the same layer of the same document, earlier imports first.
    own: Vec<&'a PaintEntry>,
    /// All other entries on the surface.
    others: Vec<&'a PaintEntry>,
    /// The number of the first import in the history.
    first_kept: u32,
    read: &'a dyn Fn(&PaintEntry) -> Result<Option<PaintPatch>>,
}

impl SurfaceMerge<'_> {
    /// Merges the new paint of the surface with the existing entries.
    fn settle(
        &self,
        surface: Option<SurfacePaint>,
        settled: &mut BookChanges,
        changed: &mut FxHashSet<(i32, i32)>,
    ) -> Result<()> {
        let others = self.shown_by_others()?;
        let mut fresh = surface.as_ref().map_or_else(|| PaintPatch::of_pixels(&[]), |s| s.patch.clone());
        let mut kept = Vec::new();
        for &entry in self.own.iter().rev() {
            let Some(before) = (self.read)(entry)? else {
                // The layer contains all of its paint, including what was lost.
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
            self.join_former(&mut kept);
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

    /// Returns the combined paint of all other entries of the surface.
    fn shown_by_others(&self) -> Result<PaintPatch> {
        let mut combined = PaintPatch::of_pixels(&[]);
        for entry in &self.others {
            if let Some(patch) = (self.read)(entry)? {
                combined = combined.under(&patch);
            }
        }
        Ok(combined)
    }

    /// Combines own paint of imports that are no longer in the history, as far as no newer paint of others covers it:
    /// a surface is saved a hundred times, and each import would leave a file. Imports in the history keep theirs,
    /// because it can be decided of each whether its paint stays in its photo, and so do those that stay.
    fn join_former(&self, kept: &mut [(&PaintEntry, PaintPatch, PaintPatch)]) {
        let newest_other = self.others.iter().map(|entry| entry.import).max().unwrap_or(0);
        let joins = |import: u32| {
            import > newest_other && import < self.first_kept && !self.arrival.only_here.contains(&import)
        };
        let mut former = kept.iter_mut().filter(|(entry, ..)| joins(entry.import));
        let Some((.., newest)) = former.next() else { return };
        for (.., older) in former {
            *newest = std::mem::replace(older, PaintPatch::of_pixels(&[])).under(newest);
        }
    }

    /// Returns the conflicts of new paint with other documents, except paint that was visible in the export.
    fn conflicts(&self, fresh: &PaintPatch) -> Result<Vec<Conflict>> {
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

    /// Makes the entry for new paint.
    fn entry(&self, surface: SurfacePaint) -> PaintEntry {
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
    use quadratura_document::paint::PaintColour;

    const RED: PaintColour = [65535, 0, 0, 65535];
    const BLUE: PaintColour = [0, 0, 65535, 65535];

    /// A book whose files are patches in memory.
    #[derive(Default)]
    struct Shelf {
        book: PaintBook,
        patches: BTreeMap<String, PaintPatch>,
        known: BTreeSet<String>,
        only_here: BTreeSet<u32>,
    }

    impl Shelf {
        /// Imports paint of the wall from a document.
        fn import(&mut self, document: &str, import: u32, pixels: &[(i32, i32, PaintColour)]) -> BookChanges {
            let arrival = ImportedLayer {
                photo: "a.png",
                layer: "t1",
                document,
                import,
                view: "v",
                known: &self.known,
                only_here: &self.only_here,
            };
            let surface = SurfacePaint {
                object: "wall".into(),
                face: Some(FaceIndex(0)),
                triangle: None,
                beyond: false,
                outline: vec![],
                patch: PaintPatch::of_pixels(pixels),
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

        /// Returns the visible colours, from left to right.
        fn seen(&self) -> Vec<(i32, PaintColour)> {
            let all = self.book.of_photo("a.png").into_iter().map(|entry| self.patches[&entry.file].clone());
            let all = all.reduce(|below, above| below.under(&above)).unwrap_or(PaintPatch::of_pixels(&[]));
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
        let imports: Vec<u32> = shelf.book.entries.iter().map(|entry| entry.import).collect();
        assert_eq!(imports, [1, 2], "each import keeps what is left of its paint");
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

    /// Paints one more pixel with each import; the history begins with import `first_kept`.
    fn painted_again_and_again(only_here: &[u32]) -> Vec<(u32, u64)> {
        let only_here = only_here.iter().copied().collect();
        let mut shelf = Shelf { only_here, ..Shelf::default() };
        for import in 1..=14 {
            let pixels: Vec<_> = (0..import).map(|x| (x as i32, 0, RED)).collect();
            shelf.import("k1", import, &pixels);
            shelf.book.remember(quadratura_document::paint::PaintImport {
                number: import,
                time: 0,
                files: vec![],
                photos: vec![],
                pixels: 1,
                added: vec![],
                replaced: vec![],
                documents: BTreeMap::new(),
                masks: vec![],
                brush: None,
            });
        }
        assert_eq!(shelf.seen().len(), 14);
        let entries = shelf.book.entries.iter();
        entries.map(|entry| (entry.import, shelf.patches[&entry.file].count())).collect()
    }

    #[test]
    fn paint_of_imports_that_left_the_history_is_joined_unless_it_stays_in_its_photo() {
        let in_history = (4..=14).map(|import| (import, 1)).collect::<Vec<_>>();
        assert_eq!(painted_again_and_again(&[]), [&[(3, 3)], &in_history[..]].concat());
        assert_eq!(painted_again_and_again(&[2]), [&[(2, 1), (3, 2)], &in_history[..]].concat());
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
        // A stroke elsewhere in the first file does not move its old one to the top.
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
