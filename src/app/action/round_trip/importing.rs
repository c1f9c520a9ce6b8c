//! Imports from image editors: their start, their effect on what is shown, and their undoing.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use super::projecting::project_paint;
use crate::action::quality::surroundings::{is_repainted, renew_surroundings};
use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::round_trip::report::Way;
use crate::state::running::JobKind;
use crate::work::Work;
use crate::work::jobs::arrival;
use crate::work::painter::PreviewChange;
use quadratura_base::error::Error;
use quadratura_base::task::Task;
use quadratura_document::paint::PaintBook;
use quadratura_editing::import::before_after::before_and_after;
use quadratura_editing::import::pictures::changed_layers;
use quadratura_editing::import::{ImportOptions, import_once, take_back_one};
use quadratura_io::paint_store::PaintStore;

/// The longer side of a picture before or after, in pixels: the width of the panel in a large window.
const PICTURE: u32 = 512;

/// Imports the files of the dialog.
pub fn import_chosen(state: &mut State, work: &mut Work) {
    let Some(dialog) = state.round_trip.dialogs.import.take() else { return };
    let paths = dialog.paths.iter().map(|path| path.trim()).filter(|path| !path.is_empty());
    let files: Vec<PathBuf> = paths.map(PathBuf::from).collect();
    let (scaled, only_unseen) = (dialog.scaled, dialog.only_unseen);
    let options = ImportOptions { scaled, only_unseen, ..ImportOptions::default() };
    import_with(state, work, files, options, None);
}

/// Imports edited files.
pub fn import_files(state: &mut State, work: &mut Work, files: Vec<PathBuf>) {
    import_with(state, work, files, ImportOptions::default(), None);
}

/// Imports a file in which nearly everything has changed at once.
pub fn import_all(state: &mut State, work: &mut Work, file: PathBuf) {
    let options = ImportOptions { all: true, ..ImportOptions::default() };
    import_with(state, work, vec![file], options, None);
}

/// Makes the pictures for the question about a file.
pub fn look_at_question(state: &mut State, work: &mut Work, file: PathBuf) {
    let Some(session) = &state.session else { return };
    let folder = session.folder.clone();
    work.jobs.start(&mut state.running, JobKind::Look, "Reading the edited file", move |task| {
        let pictures = before_and_after(&folder, &file, PICTURE, task)?;
        Ok(arrival(move |state| state.show_question(&file, pictures)))
    });
}

/// Redoes an import that was undone.
pub fn import_again(state: &mut State, work: &mut Work, number: u32, files: Vec<PathBuf>) {
    // The import passed its checks before, so that its options allow everything.
    let options = ImportOptions { scaled: true, all: true, ..ImportOptions::default() };
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
    let (folder, lock, turn) = (session.folder.clone(), session.lock.clone(), work.live.paint.clone());
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
        painter.change(PreviewChange::Paint(photos.into_iter().collect(), book.clone()));
        state.space.redraw();
    }
    if is_repainted(state.round_trip.book.as_deref(), &book) {
        renew_surroundings(state, work);
    }
    project_paint(state, work, book);
}

/// Makes the pictures of an import's changes.
pub fn look_at_import(state: &mut State, work: &mut Work, number: u32, book: Arc<PaintBook>) {
    let Some(session) = &state.session else { return };
    let folder = session.folder.clone();
    work.jobs.start(&mut state.running, JobKind::Look, "Reading imported paint", move |task| {
        let changed = changed_layers(&folder, &book, number, PICTURE, task)?;
        Ok(arrival(move |state| state.show_looks(number, changed)))
    });
}

/// Undoes an import, if no later one depends on it.
pub fn take_back_import(state: &mut State, work: &mut Work, number: u32) {
    let Some(session) = &state.session else { return };
    let (folder, lock, turn) = (session.folder.clone(), session.lock.clone(), work.live.paint.clone());
    state.space.hide_stroke(number);
    work.jobs.start(&mut state.running, JobKind::Import, "Undoing an import", move |_| {
        let _turn = turn.take();
        let (import, book) = match take_back_one(&folder, Some(number)) {
            Err(Error::Request(_)) => return Ok(arrival(move |state| state.not_taken_back(number))),
            undone => undone?,
        };
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
                if state.asks_where_paint_is_seen() {
                    let text = "This project has paint, and it has not been chosen whether it is seen from everywhere. \
                                Choose in the panel Paint, which shows a picture of both.";
                    state.notify(Note::new(Weight::Info, text));
                }
            }
        }))
    });
}
