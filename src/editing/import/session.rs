//! A change of the project's paint in progress: what an import or a stroke of the brush adds to the paint book, which
//! is written as a whole and can be undone as a whole.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use super::elsewhere::{PaintElsewhere, paint_elsewhere};
use super::report::Conflict;
use super::settle::{BookChanges, ImportedLayer, SurfacePaint, settle};
use quadratura_base::error::Result;
use quadratura_document::paint::{
    ImportedMask, PaintBook, PaintEntry, PaintImport, PaintPatch, PaintedDocument, PaintedView,
};
use quadratura_document::stroke::BrushMode;
use quadratura_io::paint_store::PaintStore;
use quadratura_io::project::change_project;
use quadratura_layers::fill::FillOptions;

/// The project's paint with the changes of one import.
pub struct PaintSession<'a> {
    project: &'a Path,
    store: PaintStore,
    before: PaintBook,
    /// The project's paint with this import.
    book: PaintBook,
    number: u32,
    /// The choice of whose paint is seen in other photos.
    fill: FillOptions,
    /// Paint that is not written yet, by its temporary file name.
    pending: BTreeMap<String, PaintPatch>,
}

/// The paint at a point of an import.
pub struct PaintState {
    book: PaintBook,
    /// The number of patches that are not written yet.
    pending: usize,
}

/// Returns the temporary name of a patch. No file of paint has such a name, because all of them are in folders.
fn pending_name(number: usize) -> String {
    format!("+{number}")
}

/// Where paint was made: a layer of a document.
pub struct PaintedPlace<'a> {
    /// The photo and its camera.
    pub view: &'a PaintedView,
    /// The layer's token.
    pub layer: &'a str,
    /// The key of the document.
    pub document: &'a str,
    /// The files of paint that were visible there: replacing them is not a conflict.
    pub known: &'a BTreeSet<String>,
}

/// What changed on a layer.
#[derive(Debug, Default)]
pub struct SettledLayer {
    /// The number of pixels that show other paint than before.
    pub changed: u64,
    /// Conflicts with paint of other documents.
    pub conflicts: Vec<Conflict>,
}

/// What the history records of an import beside its entries.
#[derive(Debug, Default)]
pub struct PaintMade {
    /// The paths of imported files from the project; none for a stroke.
    pub files: Vec<String>,
    /// The painted photos, in any order.
    pub photos: Vec<String>,
    /// The number of painted pixels that are new or were changed.
    pub pixels: u64,
    /// The masks that come with it.
    pub masks: Vec<ImportedMask>,
    /// The mode of a stroke's brush.
    pub brush: Option<BrushMode>,
}

/// Paint that was written.
pub struct CommittedPaint {
    store: PaintStore,
    /// The project's paint as it is now.
    pub book: PaintBook,
}

impl CommittedPaint {
    /// Undoes the import.
    ///
    /// # Errors
    /// Those of [`PaintStore::commit`].
    pub fn undone(&self) -> Result<()> {
        let mut book = self.book.clone();
        book.take_back();
        self.store.commit(&book, &self.book)
    }
}

impl<'a> PaintSession<'a> {
    /// Reads the paint of the project in the folder `project`, which has these options of filling.
    ///
    /// # Errors
    /// Returns the errors of reading the paint book.
    pub fn begin(project: &'a Path, fill: FillOptions) -> Result<Self> {
        let store = PaintStore::new(project);
        let before = store.read()?;
        // A number that an import had which was undone is not used again while something is decided about it.
        let decided = fill.only_here.imports.last().map_or(0, |number| number.saturating_add(1));
        let number = before.next_import().max(decided);
        Ok(Self { project, store, book: before.clone(), before, number, fill, pending: BTreeMap::new() })
    }

    /// Returns the project's folder.
    pub fn project(&self) -> &'a Path {
        self.project
    }

    /// Returns the paint as it was before.
    pub fn before(&self) -> &PaintBook {
        &self.before
    }

    /// Returns the paint with this import.
    pub fn book(&self) -> &PaintBook {
        &self.book
    }

    /// Returns the number of this import.
    pub fn number(&self) -> u32 {
        self.number
    }

    /// Returns true when there is something to write.
    pub fn changed(&self) -> bool {
        self.book != self.before
    }

    /// Takes in all paint of a layer of a document, see [`settle`].
    ///
    /// # Errors
    /// Returns the errors of reading paint.
    pub fn settle(&mut self, place: &PaintedPlace, surfaces: Vec<SurfacePaint>) -> Result<SettledLayer> {
        let arrival = ImportedLayer {
            photo: &place.view.photo.name,
            layer: place.layer,
            document: place.document,
            import: self.number,
            view: &view_id(place.view),
            known: place.known,
            only_here: &self.fill.only_here.imports,
        };
        let BookChanges { removed, added, changed, conflicts } =
            settle(&self.book, &arrival, surfaces, &|entry| self.pixels(entry))?;
        self.take(removed, added);
        Ok(SettledLayer { changed, conflicts })
    }

    /// Returns the paint as it is now, to be restored.
    pub fn state(&self) -> PaintState {
        PaintState { book: self.book.clone(), pending: self.pending.len() }
    }

    /// Restores the paint as it was.
    pub fn restore(&mut self, state: PaintState) {
        self.book = state.book;
        // Paint is only ever added, under the next number.
        self.pending.retain(|name, _| (0..state.pending).any(|number| *name == pending_name(number)));
    }

    /// Records what a document's layers show now, and the camera of its photo.
    pub fn note_document(&mut self, document: String, seen: PaintedDocument, view: &PaintedView) {
        if seen.layers.is_empty() {
            self.book.documents.remove(&document);
        } else {
            self.book.documents.insert(document, seen);
        }
        self.note_view(view);
    }

    /// Records the camera of a photo on which there is paint now.
    pub fn note_view(&mut self, view: &PaintedView) {
        self.book.views.insert(view_id(view), view.clone());
        self.book.tidy();
    }

    /// Returns true when the file of an entry is missing or damaged.
    pub fn is_lost(&self, entry: &PaintEntry) -> bool {
        !self.pending.contains_key(&entry.file) && self.store.check(entry).is_err()
    }

    /// Returns the paint of an entry; `None` where it is lost.
    ///
    /// # Errors
    /// Returns the errors of reading its file.
    pub fn pixels(&self, entry: &PaintEntry) -> Result<Option<PaintPatch>> {
        match self.pending.get(&entry.file) {
            Some(patch) => Ok(Some(patch.clone())),
            None if self.is_lost(entry) => Ok(None),
            None => self.store.patch(entry).map(Some),
        }
    }

    /// Returns the paint of an entry.
    ///
    /// # Errors
    /// Returns an error that says which paint is lost.
    pub fn whole_pixels(&self, entry: &PaintEntry) -> Result<PaintPatch> {
        match self.pending.get(&entry.file) {
            Some(patch) => Ok(patch.clone()),
            None => self.store.check(entry).and_then(|()| self.store.patch(entry)),
        }
    }

    /// Returns the paint of other photos that differs from this import's; none where the paint stays in its photo.
    ///
    /// # Errors
    /// Returns the errors of reading paint.
    pub fn elsewhere(&self, only_here: bool) -> Result<Vec<PaintElsewhere>> {
        if only_here {
            return Ok(Vec::new());
        }
        paint_elsewhere(&self.book, self.number, &self.fill, &|entry| self.pixels(entry))
    }

    /// Replaces entries of the book.
    fn take(&mut self, removed: Vec<PaintEntry>, added: Vec<(PaintEntry, PaintPatch)>) {
        self.book.entries.retain(|entry| !removed.contains(entry));
        for (mut entry, patch) in added {
            entry.file = pending_name(self.pending.len());
            (entry.rect, entry.pixels) = (patch.rect(), patch.count());
            self.pending.insert(entry.file.clone(), patch);
            self.book.entries.push(entry);
        }
    }

    /// Writes the pending paint, then the book that refers to it. That the paint stays in its photo is written before
    /// the book, so that it is at no time seen elsewhere.
    ///
    /// # Errors
    /// Returns the errors of writing; the project's paint is then unchanged.
    pub fn commit(mut self, made: PaintMade, only_here: bool) -> Result<CommittedPaint> {
        for entry in &mut self.book.entries {
            if let Some(patch) = self.pending.get(&entry.file) {
                self.store.add(entry, patch)?;
            }
        }
        let import = self.import(made);
        self.book.remember(import);
        self.book.tidy();
        if only_here {
            change_project(self.project, |project| {
                let mut project = project?;
                project.fill.only_here.imports.insert(self.number);
                Ok(project)
            })?;
        }
        self.store.commit(&self.book, &self.before)?;
        Ok(CommittedPaint { book: self.store.held(self.book), store: self.store })
    }

    /// Makes the history's record.
    fn import(&self, made: PaintMade) -> PaintImport {
        let names = |book: &PaintBook| book.entries.iter().map(PaintEntry::name).collect::<Vec<_>>();
        let (old, new) = (names(&self.before), names(&self.book));
        let gone = self.before.entries.iter().filter(|entry| !new.contains(&entry.name()));
        let before = &self.before.documents;
        let keys = self.book.documents.keys().chain(before.keys());
        let changed = keys.filter(|key| self.book.documents.get(*key) != before.get(*key));
        let PaintMade { files, mut photos, pixels, masks, brush } = made;
        photos.sort();
        photos.dedup();
        PaintImport {
            number: self.number,
            time: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()),
            files,
            photos,
            pixels,
            added: new.iter().filter(|name| !old.contains(name)).cloned().collect(),
            replaced: gone.cloned().collect(),
            documents: changed.map(|key| (key.clone(), before.get(key).cloned())).collect(),
            masks,
            brush,
        }
    }
}

/// Returns a short id of a photo with its camera.
pub fn view_id(view: &PaintedView) -> String {
    let text = quadratura_files::json::to_json(view);
    quadratura_files::hash::hash_bytes(&text)[..12].to_owned()
}
