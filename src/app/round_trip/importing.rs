//! Imports from image editors, manual and automatic: their changes, and undoing them.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::TextureHandle;

use super::shown_path;
use crate::app::action::decide::undo;
use crate::app::panel::{counted, grouped, side::Tab};
use crate::app::state::State;
use crate::app::state::ask::{Ask, RoundTripAsk};
use crate::app::state::editing::step_of_import;
use crate::app::state::notes::{Note, Weight};
use crate::app::state::running::JobKind;
use crate::app::work::Work;
use crate::app::work::jobs::arrival;
use crate::app::work::painter::Change;
use crate::document::paint::{PaintBook, PaintImport};
use crate::io::paint_store::PaintStore;
use crate::recipe::import::pictures::{ChangedLayer, changed_layers};
use crate::recipe::import::{ImportOptions, Imported, history, import_once, take_back_with_book};
use crate::task::Task;

/// The longer side of a picture before or after, in pixels: the width of the panel in a large window.
const PICTURE: u32 = 512;

/// The state of the import dialog.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ImportDialog {
    /// The paths of files and folders, as typed or chosen.
    pub paths: Vec<String>,
    /// Whether scaled images are accepted.
    pub scaled: bool,
}

/// The origin of an import.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// A file was saved in an image editor.
    Saved,
    /// The user started the import, or redid one that was undone.
    ByHand {
        /// The number of the import that was undone.
        again: Option<u32>,
    },
}

/// The report of an import.
pub struct Report {
    /// The result for each file and layer.
    pub imported: Imported,
    /// The duration.
    pub spent: Duration,
    /// The pictures of changed layers, once they are made.
    pub looks: Vec<LayerLook>,
    /// Whether the import was undone.
    pub taken_back: bool,
}

/// The pictures of one changed layer.
pub struct LayerLook {
    /// The changed layer.
    pub layer: ChangedLayer,
    /// The textures before and after the import, once they are uploaded.
    pub textures: Option<[TextureHandle; 2]>,
}

impl State {
    /// Opens the import dialog.
    pub fn choose_imports(&mut self) {
        self.round_trip
            .import
            .get_or_insert_with(|| ImportDialog { paths: vec![String::new()], scaled: false });
    }

    /// Handles an import that has ended: reports its result, and updates all views.
    pub fn paint_came(&mut self, imported: Imported, spent: Duration, way: Way) -> Vec<Ask> {
        let Some(session) = &self.session else { return Vec::new() };
        let folder = session.folder.clone();
        let failed =
            imported.failed.iter().map(|(_, problem)| Note::new(Weight::Problem, problem.to_string()));
        failed.collect::<Vec<_>>().into_iter().for_each(|note| self.tell(note));
        for file in &imported.files {
            let name = shown_path(&folder, &file.file);
            let changed: u64 = file.layers.iter().map(|layer| layer.changed).sum();
            let text = match changed {
                0 => format!("{name}: nothing was painted that the project does not have"),
                1 => format!("{name}: 1 pixel is painted that was not"),
                pixels => format!("{name}: {} pixels are painted that were not", grouped(pixels)),
            };
            self.notes.add(Note::about(Weight::Info, &file.photo, text));
        }
        // A save without changes does not switch to another panel.
        if imported.files.is_empty() || (way == Way::Saved && imported.number.is_none()) {
            return Vec::new();
        }
        let photos = imported.files.iter().map(|file| file.photo.clone()).collect();
        let number = imported.number;
        if let Some(number) = number {
            let files = imported.files.iter().map(|file| file.file.clone()).collect();
            let again = if let Way::ByHand { again } = way { again } else { None };
            self.remember_import(number, again, files, imported.masks.clone());
        }
        let book = imported.book.clone();
        self.round_trip.report = Some(Report { imported, spent, looks: Vec::new(), taken_back: false });
        self.settings.side = Tab::Paint;
        let looks = number.map(|number| RoundTripAsk::LookAtImport(number, book.clone()).into());
        [RoundTripAsk::PaintChanged(photos, book.clone()).into()].into_iter().chain(looks).collect()
    }

    fn show_looks(&mut self, number: u32, changed: Vec<ChangedLayer>) {
        let look = |layer| LayerLook { layer, textures: None };
        let report = self.round_trip.report.as_mut().filter(|report| report.imported.number == Some(number));
        if let Some(report) = report {
            report.looks = changed.into_iter().map(look).collect();
        }
    }

    fn not_taken_back(&mut self, number: u32) {
        self.forget_import(number);
        let text = format!(
            "Import {number} cannot be taken back any more: another one lies on top, or it is too old"
        );
        self.tell(Note::new(Weight::Problem, text));
    }

    fn taken_back(&mut self, import: PaintImport, book: Arc<PaintBook>) -> Vec<Ask> {
        let text = format!(
            "Import {} is taken back: {} of {} are as they were. The files are as they were saved; saving one again \
             imports it again.",
            import.number,
            counted(import.pixels, "pixel"),
            import.photos.join(", ")
        );
        self.tell(Note::new(Weight::Info, text));
        if let Some(report) = &mut self.round_trip.report {
            report.taken_back |= report.imported.number == Some(import.number);
        }
        self.forget_masks_of(&import);
        vec![RoundTripAsk::PaintChanged(import.photos.into_iter().collect(), book).into()]
    }

    /// Updates the list of imports that can be undone, and the photos that have paint, from `book`.
    fn history_is(&mut self, book: &PaintBook) {
        self.round_trip.history = book.imports.clone();
        self.round_trip.painted = book.entries.iter().map(|entry| entry.photo.clone()).collect();
    }
}

/// Imports the files of the dialog.
pub fn import_chosen(state: &mut State, work: &mut Work) {
    let Some(dialog) = state.round_trip.import.take() else { return };
    let paths = dialog.paths.iter().map(|path| path.trim()).filter(|path| !path.is_empty());
    let files: Vec<PathBuf> = paths.map(PathBuf::from).collect();
    let options = ImportOptions { scaled: dialog.scaled, ..ImportOptions::default() };
    import_with(state, work, files, options, None);
}

/// Imports edited files.
pub fn import_files(state: &mut State, work: &mut Work, files: Vec<PathBuf>) {
    import_with(state, work, files, ImportOptions::default(), None);
}

/// Redoes an import that was undone.
pub fn import_again(state: &mut State, work: &mut Work, number: u32, files: Vec<PathBuf>) {
    // The import passed its checks before, so that its options allow everything.
    let options = ImportOptions { scaled: true, ..ImportOptions::default() };
    import_with(state, work, files, options, Some(number));
}

fn import_with(
    state: &mut State,
    work: &mut Work,
    files: Vec<PathBuf>,
    options: ImportOptions,
    again: Option<u32>,
) {
    let Some(session) = state.session.as_ref().filter(|_| !files.is_empty()) else { return };
    let (folder, lock, turn) = (session.folder.clone(), session.lock.clone(), work.turn.clone());
    work.jobs.start(&mut state.running, JobKind::Import, "Importing", move |task| {
        let _turn = turn.take();
        let since = Instant::now();
        let imported = import_once(&folder, &files, options, task)?;
        drop(lock);
        Ok(Box::new(move |state| state.paint_came(imported, since.elapsed(), Way::ByHand { again })))
    });
}

/// Shows the paint of these photos, which has changed to that of `book`.
pub fn paint_changed(state: &mut State, work: &mut Work, photos: BTreeSet<String>, book: Arc<PaintBook>) {
    state.history_is(&book);
    state.quality.forget_fillings();
    if let Some(painter) = &mut work.painter {
        painter.change(Change::Paint(photos.into_iter().collect(), book));
        state.space.redraw();
    }
}

/// Makes the pictures of an import's changes.
pub fn look_at_import(state: &mut State, work: &mut Work, number: u32, book: Arc<PaintBook>) {
    let Some(session) = &state.session else { return };
    let folder = session.folder.clone();
    work.jobs.start(&mut state.running, JobKind::Look, "Looking at what was painted", move |task| {
        let changed = changed_layers(&folder, &book, number, PICTURE, task)?;
        Ok(arrival(move |state| state.show_looks(number, changed)))
    });
}

/// Undoes the last import: by undo where it is the last step, otherwise without the history.
pub fn take_back_last(state: &mut State, work: &mut Work) {
    let Some(number) = state.round_trip.history.last().map(|import| import.number) else { return };
    let step = state.session.as_ref().and_then(|session| session.history.undoes());
    if step == Some(step_of_import(number).as_str()) {
        return undo(state, work);
    }
    state.forget_import(number);
    take_back_import(state, work, number);
}

/// Undoes an import, if it is the last one.
pub fn take_back_import(state: &mut State, work: &mut Work, number: u32) {
    let Some(session) = &state.session else { return };
    let (folder, lock, turn) = (session.folder.clone(), session.lock.clone(), work.turn.clone());
    work.jobs.start(&mut state.running, JobKind::Import, "Taking an import back", move |_| {
        let _turn = turn.take();
        if history(&folder)?.last().map(|import| import.number) != Some(number) {
            return Ok(arrival(move |state| state.not_taken_back(number)));
        }
        let (import, book) = take_back_with_book(&folder)?;
        drop(lock);
        Ok(Box::new(move |state| state.taken_back(import, book)))
    });
}

/// Loads which imports can be undone, and which photos have paint.
pub fn read_history(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let folder = session.folder.clone();
    work.jobs.start(&mut state.running, JobKind::Look, "Reading the imports", move |_: &Task| {
        let book = PaintStore::new(&folder).read()?;
        Ok(arrival(move |state| {
            let same = state.session.as_ref().is_some_and(|session| session.folder == folder);
            if same {
                state.history_is(&book);
            }
        }))
    });
}
