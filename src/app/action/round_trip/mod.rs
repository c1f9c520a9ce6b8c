//! Actions of the round trip to the image editor: exports, imports, and their undoing.

mod choosing;
mod editing;
mod exporting;
pub mod importing;
mod projecting;
mod taking_back;
pub mod watching;

use std::path::PathBuf;

use self::choosing::{choose_path, take_chosen_files};
use self::editing::edit_photo;
use self::exporting::{export_chosen, show_folder_of};
use self::importing::{
    import_all, import_chosen, import_files, look_at_import, look_at_question, paint_changed,
};
use self::projecting::{show_fillings, show_projected};
use self::taking_back::take_back_last;
use self::watching::{take_saved, watch_for_saves};
use crate::state::State;
use crate::state::request::{Request, RoundTripRequest};
use crate::work::Work;
use quadratura_io::programs::image_editors;
use quadratura_layered_files::recognise::is_document;

/// Applies a request about the round trip.
pub fn apply(state: &mut State, work: &mut Work, request: RoundTripRequest) {
    match request {
        RoundTripRequest::ChooseImports => state.choose_imports(),
        RoundTripRequest::Import => import_chosen(state, work),
        RoundTripRequest::ImportFiles(files) => import_files(state, work, files),
        RoundTripRequest::ImportAll(file) => import_all(state, work, file),
        RoundTripRequest::LeaveFile(file) => {
            state.round_trip.questions.retain(|question| question.file != file)
        }
        RoundTripRequest::LookAtQuestion(file) => look_at_question(state, work, file),
        RoundTripRequest::ChooseExport => state.choose_export(),
        RoundTripRequest::Export => export_chosen(state, work),
        RoundTripRequest::EditPhoto { fresh } => edit_photo(state, work, fresh),
        RoundTripRequest::UseEditor(choice) => state.settings.image_editor = choice,
        RoundTripRequest::LookForEditors => state.round_trip.found = Some(image_editors()),
        RoundTripRequest::TakeBackLast => take_back_last(state, work),
        RoundTripRequest::ShowFolder(folder) => show_folder_of(state, &folder),
        RoundTripRequest::ChoosePath(wanted) => choose_path(state, work, wanted),
        RoundTripRequest::PaintChanged(photos, book) => paint_changed(state, work, photos, book),
        RoundTripRequest::ShowProjected(projected) => show_projected(state, work, *projected),
        RoundTripRequest::ShowFillings => show_fillings(state, work),
        RoundTripRequest::LookAtImport(number, book) => look_at_import(state, work, number, book),
        RoundTripRequest::WatchForSaves => watch_for_saves(state, work),
    }
}

/// Handles files saved in image editors, and answers of system dialogs; returns the requests to apply next.
pub fn take_home(state: &mut State, work: &mut Work) -> Vec<Request> {
    let requests = take_saved(state, work);
    take_chosen_files(state, work);
    requests
}

/// Imports layered files dropped on the window; returns whether there were any.
pub fn import_dropped(state: &mut State, work: &mut Work, dropped: &[PathBuf]) -> bool {
    let layered: Vec<PathBuf> = dropped.iter().filter(|path| is_document(path)).cloned().collect();
    if state.session.is_none() || layered.is_empty() {
        return false;
    }
    import_files(state, work, layered);
    true
}
