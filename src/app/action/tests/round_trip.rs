//! Tests of the round trip to the image editor: dialogs, the results of imports and exports, and undoing imports.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use super::bench::{PHOTOS, TestBench};
use super::layered::layered;
use crate::action::take_in;
use crate::state::panels::Tab;
use crate::state::request::{Flag, RoundTripRequest, WindowRequest};
use crate::state::round_trip::image_editor::EditorChoice;
use crate::state::round_trip::report::Way;
use quadratura_base::error::Error;
use quadratura_document::paint::{PaintBook, PaintImport};
use quadratura_editing::export::Exported;
use quadratura_editing::import::Imported;
use quadratura_editing::import::report::FileReport;
use quadratura_io::programs::ImageEditor;

fn file(bench: &TestBench) -> FileReport {
    FileReport {
        file: bench.folder().join("edited").join("a.psd"),
        photo: PHOTOS[0].into(),
        key: String::new(),
        turned: None,
        question: None,
        offset: [0; 2],
        scale: 1.0,
        layers: Vec::new(),
        notes: Vec::new(),
    }
}

fn import(number: u32) -> PaintImport {
    PaintImport {
        number,
        time: 0,
        files: Vec::new(),
        photos: vec![PHOTOS[0].into()],
        pixels: 1,
        added: Vec::new(),
        replaced: Vec::new(),
        documents: Default::default(),
        masks: Vec::new(),
        brush: None,
    }
}

/// Hands in the result of an import with this number, or of one that changed nothing.
fn come(bench: &mut TestBench, number: Option<u32>, way: Way) {
    let imports = number.map(import).into_iter().collect();
    let book = Arc::new(PaintBook { imports, ..PaintBook::default() });
    let imported = Imported { number, files: vec![file(bench)], book, ..Imported::default() };
    let requests = bench.state.paint_came(imported, Duration::ZERO, way);
    requests.into_iter().for_each(|request| bench.request(request));
    bench.settle();
}

const BY_HAND: Way = Way::ByHand { again: None };

// ---- dialogs ----

#[test]
fn programs_are_looked_up_when_their_dialog_is_opened_and_only_then() {
    let mut bench = TestBench::empty();
    assert!(bench.state.round_trip.found.is_none());
    bench.request(WindowRequest::Flip(Flag::ImageEditor));
    assert!(bench.state.round_trip.found.is_some() && bench.state.has_dialog());
    bench.state.round_trip.found = Some(vec![(ImageEditor::Krita, "no-such-program".into())]);
    bench.request(RoundTripRequest::LookForEditors);
    let found = bench.state.round_trip.found.as_ref().unwrap();
    assert!(found.iter().all(|(_, program)| program != &PathBuf::from("no-such-program")));
}

#[test]
fn the_chosen_image_editor_is_a_setting() {
    let mut bench = TestBench::empty();
    let choice = EditorChoice { editor: None, program: "paint".into(), ..EditorChoice::default() };
    bench.request(RoundTripRequest::UseEditor(choice.clone()));
    assert_eq!(bench.state.settings.image_editor, choice);
}

#[test]
fn a_photo_that_no_program_can_open_asks_for_one() {
    let mut bench = layered();
    let choice = EditorChoice { editor: None, program: "no-such-program".into(), ..EditorChoice::default() };
    bench.request(RoundTripRequest::UseEditor(choice));
    bench.request(RoundTripRequest::EditPhoto { fresh: false });
    assert!(bench.state.round_trip.dialogs.choosing_editor && bench.state.running.is_idle());
    assert_eq!(bench.said().len(), 1);
}

#[test]
fn an_import_takes_the_lines_that_are_not_empty_and_closes_its_dialog() {
    let mut bench = TestBench::new();
    bench.request(RoundTripRequest::ChooseImports);
    bench.request(RoundTripRequest::Import);
    assert!(bench.state.running.is_idle(), "there was nothing to import");
    bench.request(RoundTripRequest::ChooseImports);
    let dialog = bench.state.round_trip.dialogs.import.as_mut().unwrap();
    dialog.paths = vec![" no-such-file.psd ".into(), "  ".into()];
    bench.request(RoundTripRequest::Import);
    assert!(!bench.state.round_trip.is_asking());
    bench.settle();
    let said = bench.said().join("\n");
    assert!(said.contains("no-such-file.psd"), "{said}");
}

#[test]
fn an_export_without_a_dialog_or_a_project_starts_nothing() {
    for mut bench in [TestBench::new(), TestBench::empty()] {
        bench.request(RoundTripRequest::Export);
        assert!(bench.state.running.is_idle());
    }
}

// ---- results ----

#[test]
fn paint_that_came_by_hand_is_a_step_and_its_panel_is_shown() {
    let mut bench = TestBench::new();
    come(&mut bench, Some(1), BY_HAND);
    assert_eq!(bench.undoes(), Some("import 1"));
    assert_eq!(bench.state.settings.side, Tab::Paint);
    assert_eq!(bench.state.round_trip.history.len(), 1);
    assert!(bench.said().iter().any(|said| said.starts_with("edited/a.psd ")), "{:?}", bench.said());
}

#[test]
fn a_save_that_changed_nothing_shows_no_other_panel() {
    let mut bench = TestBench::new();
    come(&mut bench, None, Way::Saved);
    assert_eq!((bench.state.settings.side, bench.undoes()), (Tab::Selection, None));
    assert!(bench.state.round_trip.report.is_none());
    come(&mut bench, None, BY_HAND);
    assert_eq!(bench.state.settings.side, Tab::Paint, "who asked for it is told");
}

#[test]
fn a_file_that_failed_is_a_problem_of_its_own() {
    let mut bench = TestBench::new();
    let failed = vec![("a.psd".into(), Error::Request("it is broken".into()))];
    let imported = Imported { failed, ..Imported::default() };
    assert!(bench.state.paint_came(imported, Duration::ZERO, BY_HAND).is_empty());
    assert_eq!(bench.said(), ["it is broken"]);
}

#[test]
fn pictures_of_an_import_that_is_not_the_last_one_are_dropped() {
    let mut bench = TestBench::new();
    come(&mut bench, Some(2), BY_HAND);
    let looks = bench.state.round_trip.report.as_ref().unwrap().looks.clone();
    bench.state.show_looks(1, Vec::new());
    assert!(Arc::ptr_eq(&looks, &bench.state.round_trip.report.as_ref().unwrap().looks));
    bench.state.show_looks(2, Vec::new());
    assert!(!Arc::ptr_eq(&looks, &bench.state.round_trip.report.as_ref().unwrap().looks));
}

#[test]
fn an_import_that_was_taken_back_is_marked_and_its_photos_are_shown_again() {
    let mut bench = TestBench::new();
    come(&mut bench, Some(1), BY_HAND);
    let requests = bench.state.taken_back(import(1), Arc::default());
    requests.into_iter().for_each(|request| bench.request(request));
    assert!(bench.state.round_trip.report.as_ref().unwrap().taken_back);
    assert!(bench.state.round_trip.history.is_empty());
}

#[test]
fn an_import_that_cannot_be_taken_back_is_no_step_any_more() {
    let mut bench = TestBench::new();
    come(&mut bench, Some(1), BY_HAND);
    bench.state.not_taken_back(1);
    assert_eq!(bench.undoes(), None);
    assert!(bench.said().iter().any(|said| said.contains("can no longer be undone")));
}

#[test]
fn taking_back_the_last_import_when_it_is_the_last_step_is_an_undo() {
    let mut bench = TestBench::new();
    come(&mut bench, Some(1), BY_HAND);
    bench.request(RoundTripRequest::TakeBackLast);
    assert_eq!(bench.undoes(), None);
    assert!(!bench.state.running.is_idle());
    bench.settle();
    assert!(bench.said().iter().any(|said| said.contains("can no longer be undone")), "it is not on disk");
}

#[test]
fn an_export_says_how_much_it_wrote_and_what_failed() {
    let mut bench = TestBench::new();
    bench.request(RoundTripRequest::ChooseExport);
    let failed = vec![(PHOTOS[1].to_owned(), Error::Request("no room".into()))];
    bench.state.exported(&Exported { done: Vec::new(), failed }, "out".into());
    assert_eq!(bench.said(), ["no room", "Exported 0 photos to out: 0.0 MB"]);
    let dialog = bench.state.round_trip.dialogs.export.as_ref().unwrap();
    assert_eq!(dialog.done, Some("out".into()));
}

#[test]
fn the_watch_begins_with_the_folder_of_documents_and_ends_with_the_project() {
    let mut bench = TestBench::new();
    bench.request(RoundTripRequest::WatchForSaves);
    assert!(bench.work.watching.is_none() && bench.session().editing_folder().is_none());
    std::fs::create_dir_all(quadratura_editing::editing::folder(bench.folder())).unwrap();
    assert!(bench.session().editing_folder().is_some());
    bench.request(RoundTripRequest::WatchForSaves);
    assert!(bench.work.watching.is_some());
    crate::action::build::close_project(&mut bench.state, &mut bench.work);
    take_in(&mut bench.state, &mut bench.work);
    assert!(bench.work.watching.is_none());
}
