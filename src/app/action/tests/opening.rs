//! Tests of the dialogs for opening, creating and relinking projects.

use std::path::PathBuf;

use super::bench::{TestBench, project};
use crate::action::build::close_project;
use crate::action::opening::chooser::{take_choice, without_dialog};
use crate::action::opening::{take_dropped, watch_opening};
use crate::state::opening::assistant::Assistant;
use crate::state::opening::relinking::Relinking;
use crate::state::opening::{DialogRequest, PathKind, Purpose};
use crate::state::request::ProjectRequest;
use crate::state::running::JobKind;
use quadratura_files::lock::ProjectLock;
use quadratura_io::project::write_project;
use quadratura_sites::discover::{SitePart, SiteParts};

fn dialog(bench: &mut TestBench, request: DialogRequest) {
    bench.request(ProjectRequest::Dialog(request));
}

fn assistant(bench: &mut TestBench) -> &mut Assistant {
    bench.state.opening.dialogs.assistant.as_mut().expect("the assistant is open")
}

fn relinking(bench: &TestBench) -> &Relinking {
    bench.state.opening.dialogs.relinking.as_ref().expect("the dialog is open")
}

/// Returns a bench with a project on disk whose site is missing; it is not open.
fn without_site() -> (TestBench, PathBuf) {
    let bench = TestBench::empty();
    write_project(bench.folder(), &project()).unwrap();
    let folder = bench.folder().to_path_buf();
    (bench, folder)
}

/// Runs the periodic checks of the dialogs at a time, in seconds.
fn watch(bench: &mut TestBench, now_s: f64) {
    bench.state.window.now_s = now_s;
    watch_opening(&mut bench.state, &mut bench.work);
}

// ---- opening ----

#[test]
fn the_folder_of_a_project_and_its_file_are_opened() {
    for file in ["", "project.json"] {
        let (mut bench, folder) = without_site();
        dialog(&mut bench, DialogRequest::Take(folder.join(file)));
        assert!(bench.state.running.runs(JobKind::Open));
        bench.settle();
        assert_eq!(relinking(&bench).folder, folder);
    }
}

#[test]
fn anything_that_is_no_project_starts_a_new_one() {
    let mut bench = TestBench::empty();
    let folder = bench.folder().to_path_buf();
    take_dropped(&mut bench.state, &mut bench.work, std::slice::from_ref(&folder));
    assert!(bench.state.opening.is_asking() && bench.state.running.runs(JobKind::Search));
    assert_eq!(PathBuf::from(&assistant(&mut bench).root), folder);
}

#[test]
fn what_is_dropped_while_a_question_is_open_is_ignored() {
    let mut bench = TestBench::new();
    let mut edited = bench.project();
    edited.options.margin += 1;
    bench.state.edit("margin", edited, None);
    bench.request(ProjectRequest::Open("other".into()));
    assert!(bench.state.is_asking());
    take_dropped(&mut bench.state, &mut bench.work, &["site".into()]);
    assert!(!bench.state.opening.is_asking());
}

#[test]
fn a_project_that_was_left_while_it_was_opened_opens_no_dialog() {
    let (mut bench, folder) = without_site();
    bench.request(ProjectRequest::OpenNow(folder));
    close_project(&mut bench.state, &mut bench.work);
    bench.settle();
    assert!(!bench.state.opening.is_asking() && bench.state.session.is_none());
}

#[test]
fn a_project_that_is_open_elsewhere_is_waited_for_and_opened_when_it_is_free() {
    let (mut bench, folder) = without_site();
    let lock = ProjectLock::take(&folder).unwrap();
    bench.request(ProjectRequest::Open(folder.clone()));
    bench.settle();
    assert_eq!(bench.state.opening.held.as_ref().map(|held| &held.folder), Some(&folder));
    watch(&mut bench, 10.0);
    bench.settle();
    assert!(bench.state.opening.held.is_some(), "it is still held");
    drop(lock);
    watch(&mut bench, 20.0);
    bench.settle();
    assert!(bench.state.opening.held.is_none());
    assert_eq!(relinking(&bench).folder, folder, "it was opened, and its site is missing");
}

// ---- the assistant ----

#[test]
fn a_search_fills_in_nothing_where_nothing_is_found_and_suggests_a_folder() {
    let mut bench = TestBench::empty();
    let root = bench.folder().to_path_buf();
    dialog(&mut bench, DialogRequest::New(Some(root)));
    bench.settle();
    let assistant = assistant(&mut bench);
    assert!(assistant.places.iter().all(|place| place.searched && place.typed.is_empty()));
    assert!(assistant.root_error.is_none() && !assistant.folder.typed.is_empty());
}

#[test]
fn a_search_of_a_folder_that_does_not_exist_says_so_in_the_dialog() {
    let mut bench = TestBench::empty();
    dialog(&mut bench, DialogRequest::New(None));
    assistant(&mut bench).root = bench.folder().join("none").display().to_string();
    dialog(&mut bench, DialogRequest::Search);
    bench.settle();
    assert!(assistant(&mut bench).root_error.is_some());
    assert!(bench.said().is_empty(), "{:?}", bench.said());
}

#[test]
fn a_project_that_cannot_be_created_leaves_the_assistant_open_with_the_errors() {
    let mut bench = TestBench::empty();
    dialog(&mut bench, DialogRequest::New(None));
    let folder = bench.folder().to_path_buf();
    let it = assistant(&mut bench);
    SitePart::ALL.into_iter().for_each(|part| it.places[part as usize].set(&folder.join("none")));
    it.goes_to(&folder.join("project"));
    dialog(&mut bench, DialogRequest::Create);
    assert!(bench.state.running.runs(JobKind::Open));
    bench.settle();
    let it = assistant(&mut bench);
    let errors = it.places.iter().map(|place| place.errors.len()).sum::<usize>() + it.folder.errors.len();
    assert!(errors > 0 && bench.state.session.is_none());
}

#[test]
fn a_model_that_cannot_be_suggested_says_why_in_the_line_of_the_model_and_leaves_no_file() {
    let mut bench = TestBench::empty();
    dialog(&mut bench, DialogRequest::New(None));
    let folder = bench.folder().to_path_buf();
    let it = assistant(&mut bench);
    it.root = folder.display().to_string();
    [SitePart::Photos, SitePart::Cameras].into_iter().for_each(|part| it.places[part as usize].set(&folder));
    dialog(&mut bench, DialogRequest::SuggestModel);
    assert!(bench.state.running.runs(JobKind::Model));
    bench.settle();
    let model = &assistant(&mut bench).places[SitePart::Model as usize];
    assert!(model.typed.is_empty() && model.errors.len() == 1, "{:?}", model.errors);
    assert!(bench.said().is_empty() && !folder.join("suggested.obj").exists());
}

#[test]
fn cancelling_closes_the_dialogs_and_stops_their_searches() {
    let mut bench = TestBench::empty();
    let root = bench.folder().to_path_buf();
    dialog(&mut bench, DialogRequest::New(Some(root)));
    dialog(&mut bench, DialogRequest::Cancel);
    assert!(!bench.state.opening.is_asking());
    bench.settle();
    assert!(!bench.state.opening.is_asking() && bench.said().is_empty(), "{:?}", bench.said());
}

#[test]
fn the_paths_in_the_assistant_are_looked_at_once_nothing_is_typed_any_more() {
    let mut bench = TestBench::empty();
    dialog(&mut bench, DialogRequest::New(None));
    assistant(&mut bench).places[SitePart::Model as usize].typed = "a.obj".into();
    watch(&mut bench, 1.0);
    assert!(bench.state.running.is_idle() && bench.state.window.next_frame_s.is_some());
    watch(&mut bench, 1.5);
    assert!(bench.state.running.runs(JobKind::Paths));
    bench.settle();
    let look = bench.state.opening.looking.now().expect("the paths were looked at");
    assert!(look.error(SitePart::Model).is_some(), "there is no such file");
    assistant(&mut bench).places[SitePart::Model as usize].typed = "b.obj".into();
    watch(&mut bench, 1.6);
    assert!(bench.state.opening.looking.now().is_none(), "the result is that of other paths");
}

// ---- dialogs of the system ----

#[test]
fn a_path_that_was_chosen_goes_where_it_was_asked_for() {
    let mut bench = TestBench::empty();
    dialog(&mut bench, DialogRequest::New(None));
    let mut choose =
        |purpose, path: &str| take_choice(&mut bench.state, &mut bench.work, purpose, path.into());
    choose(Purpose::Part(SitePart::Cameras, PathKind::Folder), "sparse");
    choose(Purpose::Part(SitePart::Cameras, PathKind::File), "transforms.json");
    choose(Purpose::Folder, "project");
    let it = assistant(&mut bench);
    assert_eq!(it.parts(), SiteParts { cameras: "transforms.json".into(), ..SiteParts::default() });
    assert_eq!(it.folder.path(), PathBuf::from("project"));
}

#[test]
fn where_no_dialog_is_shown_a_project_is_typed_and_the_rest_is_explained() {
    let mut bench = TestBench::empty();
    without_dialog(&mut bench.state, &Purpose::Project);
    assert!(bench.state.opening.typing && bench.state.has_dialog() && bench.said().is_empty());
    without_dialog(&mut bench.state, &Purpose::Folder);
    assert!(!bench.state.opening.typing);
    assert_eq!(bench.said().len(), 1);
}

// ---- missing parts ----

#[test]
fn new_places_that_cannot_be_used_are_refused_in_the_dialog_and_change_nothing() {
    let (mut bench, folder) = without_site();
    let before = bench.saved();
    bench.request(ProjectRequest::Open(folder));
    bench.settle();
    assert_eq!(relinking(&bench).asked, SitePart::ALL);
    dialog(&mut bench, DialogRequest::Relink);
    bench.settle();
    assert_eq!(relinking(&bench).errors.len(), 1);
    assert_eq!(bench.saved(), before);
}

#[test]
fn a_photo_s_file_is_copied_to_where_it_is_missing_or_the_dialog_says_why_not() {
    let mut bench = TestBench::new();
    bench.request(ProjectRequest::ShowMissing);
    assert!(relinking(&bench).photos.is_empty());
    let mut with_photo = relinking(&bench).clone();
    with_photo.was.photos = bench.folder().join("photos");
    with_photo.photos = vec!["a.jpg".into()];
    bench.state.opening.dialogs.relinking = Some(with_photo);
    let file = bench.folder().join("none.jpg");
    take_choice(&mut bench.state, &mut bench.work, Purpose::Photo("a.jpg".into()), file);
    bench.settle();
    assert_eq!((relinking(&bench).photos.len(), relinking(&bench).errors.len()), (1, 1));
}

#[test]
fn a_path_that_was_found_moves_the_guesses_of_the_others() {
    let site = tempfile::tempdir().unwrap();
    for part in ["images", "sparse"] {
        std::fs::create_dir(site.path().join(part)).unwrap();
    }
    let was = |name: &str| PathBuf::from("/gone/site").join(name);
    let parts = SiteParts { photos: was("images"), cameras: was("sparse"), model: was("a.obj") };
    let mut relinking = Relinking::of_parts(site.path().join("project"), parts, &SitePart::ALL);
    relinking.found(SitePart::Photos, &site.path().join("images"));
    assert_eq!(relinking.parts().cameras, site.path().join("sparse"));
    assert!(relinking.guessed.contains(&SitePart::Cameras));
    assert!(!relinking.guessed.contains(&SitePart::Photos), "the user said where it is");
}

// ---- the sample project ----

/// Opens the dialog of the sample project with a folder in it.
fn asking_for_sample(bench: &mut TestBench, folder: &std::path::Path) {
    dialog(bench, DialogRequest::Sample);
    bench.state.opening.dialogs.sample.as_mut().expect("the dialog is open").set(folder);
}

#[test]
fn the_sample_project_is_copied_and_opened_and_a_second_time_only_opened() {
    let mut bench = TestBench::empty();
    let folder = bench.folder().join("sample");
    for round in 0..2 {
        asking_for_sample(&mut bench, &folder);
        assert!(bench.state.opening.is_asking());
        dialog(&mut bench, DialogRequest::OpenSample);
        bench.settle();
        assert!(!bench.state.opening.is_asking(), "round {round}");
        let session = bench.state.session.as_ref().expect("the project is open");
        assert_eq!(session.folder, folder.join("project"));
        assert_eq!(session.opened.site.photos.len(), 9);
        close_project(&mut bench.state, &mut bench.work);
        std::fs::write(folder.join("notes.txt"), "kept").unwrap();
    }
    assert_eq!(std::fs::read(folder.join("notes.txt")).unwrap(), b"kept");
}

#[test]
fn a_folder_that_cannot_take_the_sample_says_why_in_the_dialog() {
    let mut bench = TestBench::empty();
    let folder = bench.folder().to_path_buf();
    std::fs::write(folder.join("mine.txt"), "mine").unwrap();
    asking_for_sample(&mut bench, &folder);
    dialog(&mut bench, DialogRequest::OpenSample);
    bench.settle();
    let errors = &bench.state.opening.dialogs.sample.as_ref().expect("the dialog stays open").errors;
    assert!(errors[0].contains("not empty"), "{errors:?}");
    take_choice(&mut bench.state, &mut bench.work, Purpose::Sample, folder.clone());
    let field = bench.state.opening.dialogs.sample.as_ref().unwrap();
    assert_eq!(field.path().parent(), Some(folder.as_path()), "a folder below the chosen one");
    dialog(&mut bench, DialogRequest::Cancel);
    assert!(!bench.state.opening.is_asking());
}
