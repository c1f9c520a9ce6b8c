//! The import of edited files of species: what differs from the export becomes paint.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use super::export::RECORDS;
use crate::import::context::{EditedFile, ReadContext, missing};
use crate::import::file::{ComparedDocument, begun_report, compared, identified, others};
use crate::import::originals::ExportedPixels;
use crate::import::report::{FileReport, LayerImportReport, LayerState};
use crate::import::{ImportOptions, LayerCache, documents_of};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::task::Task;
use quadratura_document::Trees;
use quadratura_document::export_record::{ExportRecord, ExportedTree, RecordedIndex};
use quadratura_document::paint::{PaintBook, PaintPatch, PaintedDocument};
use quadratura_document::tree_paint::{TreeCoat, TreeImport, TreePaintBook};
use quadratura_foliage::files::images::{parse_mbuffer, plant_hash};
use quadratura_foliage::{PaintedSlab, SlabTally, painted_slabs};
use quadratura_io::baselines::Baselines;
use quadratura_io::exports::ExportStore;
use quadratura_io::project::relative_to;
use quadratura_io::tree_paint::TreePaintStore;
use quadratura_layered_files::read_layered;
use quadratura_sites::side_by_side::{done_and_failed, one_by_one};
use quadratura_trees::paint::part_of;
use quadratura_trees::plant_of;

/// The stage that is reported.
const STAGE: &str = "import";

/// Options of [`import_tree_paint`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TreeImportOptions {
    /// Whether the import is only simulated and reported.
    pub dry_run: bool,
    /// Whether paint of images that were scaled is imported.
    pub scaled: bool,
}

/// The results for all files, in their order.
#[derive(Debug, Default)]
pub struct TreeImported {
    /// The number of the import; `None` when it changed nothing.
    pub number: Option<u32>,
    /// The number of texels whose paint changed.
    pub changed: u64,
    /// The species that have other paint than before.
    pub species: BTreeSet<String>,
    /// The reports of files that were read.
    pub files: Vec<FileReport>,
    /// The files that failed, with the reasons.
    pub failed: Vec<(PathBuf, Error)>,
}

/// Imports edited files of species, or those in folders, as paint of these, as one import that can be undone as a whole. An error in one file is in
/// [`TreeImported::failed`], and an unreadable layer is left out; neither stops the others. The caller holds the project's lock, unless
/// it is a dry run.
///
/// # Errors
/// [`Error::Io`] and [`Error::Input`] when the records of exports or the paint of species cannot be read, or nothing can be written;
/// [`Error::Cancelled`]. The paint is then unchanged.
pub fn import_tree_paint(
    project: &Path,
    trees: &Trees,
    files: &[PathBuf],
    options: TreeImportOptions,
    task: &Task,
) -> Result<TreeImported> {
    let folder = project.join(RECORDS);
    let (records, problems) = task.timed("read records", || ExportStore::new(&folder).read_all())?;
    problems.iter().for_each(|problem| task.note(problem));
    let store = TreePaintStore::new(project);
    let before = store.read()?;
    let mut ongoing = ImportInProgress {
        project,
        trees,
        records,
        kept: Baselines::new(&folder),
        number: before.next_import(),
        book: before.clone(),
        pending: BTreeMap::new(),
        replaced: Vec::new(),
        options,
    };
    let mut failed = Vec::new();
    let mut documents = Vec::new();
    for path in files {
        match documents_of(std::slice::from_ref(path), &mut failed) {
            Ok(found) => documents.extend(found),
            Err(error) => failed.push((path.clone(), error)),
        }
    }
    let files = documents;
    let reports = one_by_one(STAGE, &files, |file| ongoing.file(file, task), task)?;
    let (done, not_read) = done_and_failed(&files, reports)?;
    failed.extend(not_read);
    let changed = done.iter().flat_map(|file: &FileReport| &file.layers).map(|layer| layer.changed).sum();
    let mut imported = TreeImported { changed, files: done, failed, ..TreeImported::default() };
    if ongoing.book != before {
        imported.number = Some(ongoing.number);
        imported.species = ongoing.species();
        if !options.dry_run {
            ongoing.commit(&store, &before, &imported)?;
        }
    }
    Ok(imported)
}

/// Returns the last imports of paint of species, oldest first.
///
/// # Errors
/// [`Error::Io`] and [`Error::Input`] when the paint cannot be read.
pub fn tree_import_history(project: &Path) -> Result<Vec<TreeImport>> {
    Ok(TreePaintStore::new(project).read()?.imports)
}

/// Undoes the last import of paint of species. The caller holds the project's lock.
///
/// # Errors
/// [`Error::Request`] when there is none; [`Error::Io`] and [`Error::Input`] when the paint cannot be read or written.
pub fn undo_tree_import(project: &Path) -> Result<TreeImport> {
    let store = TreePaintStore::new(project);
    let before = store.read()?;
    let mut book = before.clone();
    let import = book
        .take_back()
        .ok_or_else(|| Error::Request("there is no import of paint of trees to undo".into()))?;
    store.commit(&book, &before)?;
    Ok(import)
}

/// An edited file of a species.
#[derive(Clone, Copy)]
struct EditedTree<'a> {
    /// The record of its export.
    record: &'a ExportRecord,
    /// What was exported.
    tree: &'a ExportedTree,
    /// The name by which its paint is kept.
    document: &'a str,
}

/// An import in progress.
struct ImportInProgress<'a> {
    project: &'a Path,
    trees: &'a Trees,
    records: Vec<ExportRecord>,
    kept: Baselines,
    number: u32,
    /// The paint with this import.
    book: TreePaintBook,
    /// Points that are not written yet, with their species, by the names that their files will have.
    pending: BTreeMap<String, (String, PaintedSlab)>,
    /// The coats that were replaced or removed.
    replaced: Vec<TreeCoat>,
    options: TreeImportOptions,
}

/// The paint of a file by direction and slab, with the place of the layer's report.
type Patches = BTreeMap<usize, BTreeMap<usize, (usize, PaintPatch)>>;

impl ImportInProgress<'_> {
    fn file(&mut self, file: &Path, task: &Task) -> Result<FileReport> {
        self.refuse_others(file)?;
        let records = std::mem::take(&mut self.records);
        let report = self.of_records(file, &records, task);
        self.records = records;
        report
    }

    /// Refuses a file with the key of an export of a photo, or of another project.
    fn refuse_others(&self, file: &Path) -> Result<()> {
        let Some(key) = read_layered(file)?.key else { return Ok(()) };
        if self.records.iter().any(|record| record.key == key) {
            return Ok(());
        }
        let photos = self.project.join("exports").join(format!("{key}.json"));
        if photos.is_file() {
            let found = "it is an export of a photo, expected one of a species of tree";
            return Err(Error::input(file, "", found, "import it with `quadratura import`"));
        }
        Ok(())
    }

    fn of_records(&mut self, file: &Path, records: &[ExportRecord], task: &Task) -> Result<FileReport> {
        let (document, record) = identified(file, records, task)?;
        let Some(tree) = &record.tree else {
            let json = self.project.join(RECORDS).join(format!("{}.json", record.key));
            let found = "it is the record of a photo, expected that of a species of tree";
            return Err(Error::input(json, "tree", found, "move it to exports/"));
        };
        let no_paint = PaintBook::default();
        let cache = LayerCache::default();
        let kept = self.kept.clone();
        let originals = ExportedPixels { kept: &kept, project: self.project, book: &no_paint };
        let options = ImportOptions { scaled: self.options.scaled, ..ImportOptions::default() };
        let reading = ReadContext { records, originals, options, recall: &cache };
        let edited = EditedFile { file, document: &document, turn: None };
        let compared = compared(edited, record, reading, &PaintedDocument::default(), task)?;
        let ComparedDocument { context, sorted, found } = compared;
        let mut report = begun_report(file, &document, &context);
        report.notes.extend(self.notes_about_plant(file, tree, task)?);
        let mut patches = Patches::new();
        let mut of_absent: Vec<(RecordedIndex, PaintPatch)> = Vec::new();
        for (index, paint) in found {
            if let Some(patch) = paint.patch {
                let [direction, slab] = slab_of(file, tree, index)?;
                patches.entry(direction).or_default().insert(slab, (report.layers.len(), patch));
            }
            of_absent.extend(paint.of_absent);
            report.layers.push(paint.report);
        }
        for (index, exported) in missing(record, &sorted) {
            let mut entry = LayerImportReport::new(&exported.name, Some(&exported.id), LayerState::Missing);
            let merged = of_absent.iter().filter(|(of, _)| *of == index).map(|(_, patch)| patch.clone());
            if let Some(patch) = merged.reduce(|a, b| a.under(&b)) {
                entry.notes.push("it was merged into another layer; its paint is imported from there".into());
                let [direction, slab] = slab_of(file, tree, index)?;
                patches.entry(direction).or_default().insert(slab, (report.layers.len(), patch));
            }
            report.layers.push(entry);
        }
        let name = format!("{}@{}", record.key, self.path_of(file));
        let edited = EditedTree { record, tree, document: &name };
        for (direction, patches) in patches {
            self.direction(edited, direction, patches, &mut report)?;
        }
        // A layer called `mask` is one of photos; here it is a layer like others.
        let unknown = sorted.masks.iter().map(|layer| {
            let mut entry = LayerImportReport::new(&layer.name, None, LayerState::Unknown);
            entry.notes.push("trees have no masks; erase in the layers instead".into());
            entry
        });
        report.layers.extend(unknown);
        report.layers.extend(others(&context, &sorted)?);
        Ok(report)
    }

    /// Takes in the paint of a direction.
    fn direction(
        &mut self,
        edited: EditedTree,
        direction: usize,
        patches: BTreeMap<usize, (usize, PaintPatch)>,
        report: &mut FileReport,
    ) -> Result<()> {
        let tree = edited.tree;
        let frame = &tree.frame;
        let is_painted = patches.values().any(|(_, patch)| !patch.is_empty());
        let lost = tree.samples.get(direction).map(|samples| self.kept.bytes(samples)).transpose()?.flatten();
        let (samples, why) = match (lost, tree.samples.get(direction)) {
            (Some(bytes), Some(name)) => {
                let stored = self.project.join(RECORDS).join("pixels").join(name);
                (parse_mbuffer(&stored, &bytes, frame.side)?, None)
            }
            _ if !is_painted => (Default::default(), None),
            _ => (Default::default(), Some(LOST)),
        };
        let cell = super::layers::cell(direction, frame.side);
        let mut pixels = BTreeMap::new();
        for (slab, (_, patch)) in &patches {
            let inside = patch.iter().filter(|(x, y, _)| cell.contains(*x, *y));
            let inside = inside.map(|(x, y, colour)| ((x - cell.x) as u32, (y - cell.y) as u32, colour));
            pixels.insert(*slab, inside.collect());
        }
        let mut slabs = match (is_painted, why) {
            (true, None) => painted_slabs(&samples, frame, direction, &pixels),
            _ => BTreeMap::new(),
        };
        for (slab, (index, patch)) in patches {
            let entry = &mut report.layers[index];
            if let Some(why) = why.filter(|_| !patch.is_empty()) {
                entry.state = LayerState::LeftOut;
                entry.notes.push(why.into());
                continue;
            }
            let (coat, tally) = match slabs.remove(&slab).filter(|_| !patch.is_empty()) {
                Some((coat, tally)) => (Some(coat), tally),
                None => (None, SlabTally::default()),
            };
            note_tally(entry, &tally, outside(&patch, &cell));
            let layer = entry.token.clone().unwrap_or_default();
            entry.changed = self.set(edited, &layer, coat, &tally);
        }
        Ok(())
    }

    /// Replaces the paint of a layer; returns how many texels have other paint than before.
    fn set(&mut self, edited: EditedTree, layer: &str, coat: Option<PaintedSlab>, tally: &SlabTally) -> u64 {
        let EditedTree { record, tree, document } = edited;
        debug_assert!(record.layers.iter().any(|of| of.id == layer));
        let species = &tree.species;
        let coat = coat.filter(|coat| !coat.points.is_empty() || !coat.beside.is_empty()).map(|slab| {
            let file = TreePaintStore::name_of(species, &slab);
            self.pending.insert(file.clone(), (species.clone(), slab));
            TreeCoat {
                species: species.clone(),
                part: tree.part.clone(),
                document: document.to_owned(),
                layer: layer.to_owned(),
                import: self.number,
                file,
                texels: tally.painted,
                erased: tally.erased,
                beside: tally.beside,
            }
        });
        let texels = |coat: &TreeCoat| coat.texels + coat.beside;
        let is_new =
            |coat: &TreeCoat| {
                !self.book.coats.iter().any(|of| {
                    (&of.document, &of.layer, &of.file) == (&coat.document, &coat.layer, &coat.file)
                })
            };
        let changed = coat.as_ref().filter(|coat| is_new(coat)).map(texels);
        let is_kept = coat.is_some() && changed.is_none();
        let before = self.book.set(document, layer, coat);
        let removed = before.as_ref().filter(|_| !is_kept).map_or(0, texels);
        self.replaced.extend(before);
        changed.unwrap_or(removed)
    }

    /// Returns what has to be said of the species of a file, and refuses one that the project does not have.
    fn notes_about_plant(&self, file: &Path, tree: &ExportedTree, task: &Task) -> Result<Vec<String>> {
        let name = &tree.species;
        let Some(species) = self.trees.species.get(name) else {
            let found = format!("it is of the species {name:?}, which the project does not have any more");
            let remedy = "add the species again with `quadratura tree species`, and import the file then";
            return Err(Error::input(file, "", found, remedy));
        };
        if !tree.frame.is_sound() {
            let found = format!("the record of its export says that the images are {:?}", tree.frame);
            return Err(Error::input(file, "", found, "restore exports/trees from a copy, or export again"));
        }
        let plant = match plant_of(self.project, species, task) {
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => return Ok(vec![format!("the plant of the species cannot be read now: {error}")]),
            Ok(plant) => plant,
        };
        let mut notes = Vec::new();
        if let Err(found) = part_of(&plant, tree.part.as_deref()) {
            notes.push(format!("the paint is kept and not shown: {found}"));
        }
        if plant_hash(&plant) != tree.plant {
            notes.push(format!(
                "the plant of the species {name:?} has changed since this export; the paint stays where it was, and changes what is \
                 within two texels of it now"
            ));
        }
        Ok(notes)
    }

    /// Returns the file's path from the project, if there is one; it distinguishes copies of one export.
    fn path_of(&self, file: &Path) -> String {
        relative_to(self.project, file).unwrap_or_else(|_| file.display().to_string())
    }

    /// Returns the species whose paint this import changes.
    fn species(&self) -> BTreeSet<String> {
        let added = self.book.coats.iter().filter(|coat| coat.import == self.number);
        added.chain(&self.replaced).map(|coat| coat.species.clone()).collect()
    }

    /// Writes the points, and then the book that names them.
    fn commit(
        mut self,
        store: &TreePaintStore,
        before: &TreePaintBook,
        imported: &TreeImported,
    ) -> Result<()> {
        let named: BTreeSet<String> = self.book.coats.iter().map(|coat| coat.file.clone()).collect();
        for (file, (species, slab)) in &self.pending {
            if named.contains(file) {
                store.add(species, slab)?;
            }
        }
        let files = imported.files.iter().filter(|file| file.layers.iter().any(|layer| layer.changed > 0));
        let import = TreeImport {
            number: self.number,
            time: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()),
            files: files.map(|file| self.path_of(&file.file)).collect(),
            species: imported.species.clone(),
            texels: imported.changed,
            replaced: std::mem::take(&mut self.replaced)
                .into_iter()
                .filter(|coat| coat.import < self.number)
                .collect(),
        };
        self.book.remember(import);
        self.book.tidy();
        store.commit(&self.book, before)
    }
}

/// Why a layer is left out whose samples are no longer kept.
const LOST: &str = "the samples of its export are no longer kept (exports/trees/pixels holds those of the last eight exports of each \
                    species), so its paint has no place on the plant; export again, and copy the layer over in the image editor";

/// Returns the direction and the slab of a layer of a record.
fn slab_of(file: &Path, tree: &ExportedTree, index: RecordedIndex) -> Result<[usize; 2]> {
    let slab = tree.slabs.get(index.0).copied();
    let is_sound = |[direction, slab]: &[usize; 2]| *direction < 6 && *slab < usize::from(tree.frame.slabs);
    slab.filter(is_sound).ok_or_else(|| {
        let found = format!("the record of its export does not say which slab layer {} is", index.0);
        Error::input(file, "", found, "restore exports/trees from a copy, or export again")
    })
}

/// Returns the number of painted pixels outside of a view.
fn outside(patch: &PaintPatch, cell: &PixelRect) -> usize {
    patch.iter().filter(|(x, y, _)| !cell.contains(*x, *y)).count()
}

/// Reports what became of the painted pixels of a layer.
fn note_tally(entry: &mut LayerImportReport, tally: &SlabTally, outside: usize) {
    (entry.painted, entry.erased) = (tally.painted + tally.beside, tally.erased);
    if tally.beside > 0 {
        entry.notes.push(format!(
            "{} of the painted pixels are where the plant has nothing in this slab; they are kept and shown in exports, and change \
             no picture",
            tally.beside
        ));
    }
    if tally.more_opaque > 0 {
        entry.notes.push(format!(
            "{} of the painted pixels are more opaque than the plant is there; their colours are taken, and it covers no more than \
             before",
            tally.more_opaque
        ));
    }
    if outside > 0 {
        entry.notes.push(format!("{outside} painted pixels outside of its view are left out"));
    }
    if entry.painted == 0 && entry.state == LayerState::Painted {
        entry.state = LayerState::Unchanged;
    }
}
