//! Tests of saving, autosaving, leaving, closing, opening and recovering projects.

use super::bench::{TestBench, project};
use crate::action::end::end;
use crate::action::life::{happens, offer_recovery};
use crate::action::saving::keep_now;
use crate::state::life::{Goal, LifeEvent, Phase};
use crate::state::notes::{Note, Weight};
use crate::state::request::{DecideRequest, ProjectRequest};
use crate::state::running::JobKind;
use crate::state::space::brush::DrawnStroke;
use crate::state::space::brush::tests::a_stroke;
use quadratura_document::Project;
use quadratura_document::history::Gesture;
use quadratura_files::lock::ProjectLock;
use quadratura_io::project::write_project;
use quadratura_io::recovery::{read_unsaved, write_unsaved};

/// Returns the project with this margin, by which tests recognise it.
fn with_margin(bench: &TestBench, margin: u32) -> Box<Project> {
    let mut project = bench.project();
    project.options.margin = margin;
    Box::new(project)
}

fn edit(bench: &mut TestBench, margin: u32) {
    let project = with_margin(bench, margin);
    bench.request(DecideRequest::Edit("margin".into(), project, None));
}

fn leave(bench: &mut TestBench, goal: Goal) {
    bench.request(ProjectRequest::Life(LifeEvent::Leave(goal)));
}

fn life(bench: &mut TestBench, event: LifeEvent) {
    bench.request(ProjectRequest::Life(event));
}

// ---- saving and autosaving ----

#[test]
fn an_edit_is_a_step_that_is_not_saved() {
    let mut bench = TestBench::new();
    assert!(!bench.state.is_dirty());
    edit(&mut bench, 9);
    assert!(bench.state.is_dirty());
    assert_eq!((bench.project().options.margin, bench.undoes()), (9, Some("margin")));
    assert_ne!(bench.saved().options.margin, 9);
}

#[test]
fn an_edit_is_kept_at_once() {
    let mut bench = TestBench::new();
    edit(&mut bench, 9);
    assert!(bench.state.running.runs(JobKind::Keep));
    bench.settle();
    assert_eq!(bench.kept().unwrap().options.margin, 9);
}

#[test]
fn a_gesture_is_one_step_and_kept_when_it_has_ended() {
    let mut bench = TestBench::new();
    for margin in 5..9 {
        let project = with_margin(&bench, margin);
        bench.request(DecideRequest::Edit("margin".into(), project, Some(Gesture(1))));
    }
    assert!(!bench.state.running.runs(JobKind::Keep));
    bench.request(DecideRequest::EndGesture);
    bench.settle();
    assert_eq!(bench.kept().unwrap().options.margin, 8);
    bench.request(DecideRequest::Undo);
    assert_eq!(bench.undoes(), None);
}

#[test]
fn a_save_writes_the_project_and_forgets_what_was_kept() {
    let mut bench = TestBench::new();
    edit(&mut bench, 9);
    bench.settle();
    bench.request(ProjectRequest::Save);
    assert_eq!((bench.saved().options.margin, bench.state.is_dirty()), (9, false));
    assert!(bench.kept().is_none());
}

#[test]
fn a_save_that_fails_says_so_and_keeps_everything() {
    let mut bench = TestBench::new();
    edit(&mut bench, 9);
    bench.settle();
    let (file, aside) = (bench.folder().join("project.json"), bench.folder().join("aside.json"));
    std::fs::rename(&file, &aside).unwrap();
    std::fs::create_dir(&file).unwrap();
    bench.request(ProjectRequest::Save);
    assert!(bench.state.is_dirty());
    assert!(
        bench.said().iter().any(|text| text.starts_with("The project was not saved: ")),
        "{:?}",
        bench.said()
    );
    std::fs::remove_dir(&file).unwrap();
    std::fs::rename(&aside, &file).unwrap();
    assert_eq!(bench.kept().unwrap().options.margin, 9);
}

#[test]
fn an_edit_that_is_undone_leaves_nothing_to_be_kept() {
    let mut bench = TestBench::new();
    edit(&mut bench, 9);
    bench.settle();
    bench.request(DecideRequest::Undo);
    bench.settle();
    assert!(!bench.state.is_dirty() && bench.kept().is_none());
    bench.request(DecideRequest::Redo);
    bench.settle();
    assert_eq!(bench.kept().unwrap().options.margin, 9);
}

#[test]
fn a_window_that_ends_without_asking_keeps_what_is_not_saved() {
    let mut bench = TestBench::new();
    let project = with_margin(&bench, 9);
    bench.request(DecideRequest::Edit("margin".into(), project, Some(Gesture(1))));
    end(&mut bench.state, &mut bench.work);
    assert_eq!(bench.kept().unwrap().options.margin, 9);
}

#[test]
fn what_was_edited_just_before_a_fault_is_kept_though_nobody_was_told_of_it() {
    let mut bench = TestBench::new();
    let project = with_margin(&bench, 9);
    bench.state.edit("margin", *project, None);
    keep_now(&mut bench.state, &mut bench.work);
    assert_eq!(bench.kept().unwrap().options.margin, 9);
}

// ---- leaving ----

#[test]
fn a_project_without_changes_is_closed_at_once() {
    let mut bench = TestBench::new();
    leave(&mut bench, Goal::Close);
    assert!(bench.state.session.is_none() && bench.work.autosave.is_none());
}

#[test]
fn a_project_with_changes_is_asked_about_and_stays() {
    let mut bench = TestBench::new();
    edit(&mut bench, 9);
    leave(&mut bench, Goal::Close);
    assert!(bench.state.is_asking() && bench.state.has_dialog() && bench.state.session.is_some());
    life(&mut bench, LifeEvent::Stay);
    assert!(!bench.state.is_asking() && bench.state.session.is_some() && bench.state.is_dirty());
}

#[test]
fn a_project_is_saved_and_left() {
    let mut bench = TestBench::new();
    edit(&mut bench, 9);
    leave(&mut bench, Goal::Close);
    life(&mut bench, LifeEvent::Save);
    assert!(bench.state.session.is_none());
    assert_eq!(bench.saved().options.margin, 9);
    assert!(bench.kept().is_none());
}

#[test]
fn a_project_is_left_without_saving() {
    let mut bench = TestBench::new();
    let before = bench.saved();
    edit(&mut bench, 9);
    bench.settle();
    leave(&mut bench, Goal::Close);
    life(&mut bench, LifeEvent::Discard);
    bench.settle();
    assert!(bench.state.session.is_none());
    assert_eq!(bench.saved(), before);
    assert!(bench.kept().is_none(), "it was given up");
}

#[test]
fn a_save_that_fails_on_leaving_leaves_nothing() {
    let mut bench = TestBench::new();
    edit(&mut bench, 9);
    let (file, aside) = (bench.folder().join("project.json"), bench.folder().join("aside.json"));
    std::fs::rename(&file, &aside).unwrap();
    std::fs::create_dir(&file).unwrap();
    leave(&mut bench, Goal::Quit);
    life(&mut bench, LifeEvent::Save);
    assert!(matches!(&bench.state.life.phase, Phase::Asking { failed: Some(_), .. }));
    assert!(bench.state.session.is_some() && !bench.state.window.closes);
    std::fs::remove_dir(&file).unwrap();
    std::fs::rename(&aside, &file).unwrap();
    life(&mut bench, LifeEvent::Save);
    assert!(bench.state.window.closes);
    assert_eq!(bench.saved().options.margin, 9);
}

#[test]
fn a_job_that_writes_is_asked_about_stopped_and_then_the_project_is_left() {
    let mut bench = TestBench::new();
    let running = &mut bench.state.running;
    bench.work.jobs.start(running, JobKind::Export, "Exporting", |task| {
        loop {
            task.check_cancelled()?;
            std::thread::yield_now();
        }
    });
    leave(&mut bench, Goal::Close);
    assert!(bench.state.life.asks_about_writing() && bench.state.session.is_some());
    life(&mut bench, LifeEvent::Stop);
    bench.settle();
    happens(&mut bench.state, &mut bench.work, LifeEvent::Frame);
    assert!(bench.state.session.is_none());
}

#[test]
fn a_project_is_free_for_others_once_it_is_closed() {
    let mut bench = TestBench::new();
    let folder = bench.folder().to_path_buf();
    assert!(ProjectLock::take(&folder).is_err());
    leave(&mut bench, Goal::Close);
    bench.settle();
    ProjectLock::take(&folder).unwrap();
}

#[test]
fn quitting_closes_the_window_and_nothing_is_asked_any_more() {
    let mut bench = TestBench::new();
    leave(&mut bench, Goal::Quit);
    assert!(bench.state.window.closes && bench.state.life.quits());
}

// ---- after a crash ----

/// Returns a bench whose project has autosaved, unsaved changes.
fn with_something_kept() -> TestBench {
    let mut bench = TestBench::new();
    let lost = with_margin(&bench, 7);
    write_unsaved(bench.folder(), &lost).unwrap();
    let found = read_unsaved(bench.folder(), &bench.saved()).unwrap().unwrap();
    offer_recovery(&mut bench.state, &mut bench.work, found);
    bench
}

#[test]
fn what_was_found_after_a_crash_is_asked_about_and_stays_on_disk_meanwhile() {
    let mut bench = with_something_kept();
    assert!(bench.state.is_asking());
    edit(&mut bench, 9);
    bench.settle();
    assert_eq!(bench.kept().unwrap().options.margin, 7);
}

#[test]
fn what_was_found_is_restored_as_a_step() {
    let mut bench = with_something_kept();
    bench.request(ProjectRequest::Recover(true));
    assert_eq!((bench.project().options.margin, bench.undoes()), (7, Some("recovery")));
    assert!(!bench.state.is_asking() && bench.state.is_dirty());
    bench.settle();
    assert_eq!(bench.kept().unwrap().options.margin, 7);
}

#[test]
fn what_was_found_is_discarded() {
    let mut bench = with_something_kept();
    bench.request(ProjectRequest::Recover(false));
    assert!(!bench.state.is_asking() && !bench.state.is_dirty() && bench.kept().is_none());
    assert!(bench.said().iter().any(|text| text == "Unsaved changes were discarded"));
}

// ---- opening ----

#[test]
fn a_project_is_opened_and_remembered() {
    let mut bench = TestBench::empty();
    write_project(bench.folder(), &project()).unwrap();
    let folder = bench.folder().to_path_buf();
    bench.request(ProjectRequest::Open(folder.clone()));
    assert!(bench.state.running.runs(JobKind::Open));
    bench.settle();
    // The site is missing: a note reports it, and a dialog asks for the missing parts.
    assert!(bench.state.session.is_none() && bench.state.opening.is_asking(), "{:?}", bench.said());
    bench.request(ProjectRequest::Forget(folder));
    assert!(bench.state.settings.known.recent.is_empty());
}

#[test]
fn a_folder_without_a_project_is_a_problem_that_is_told() {
    let mut bench = TestBench::empty();
    let folder = bench.folder().join("none");
    bench.request(ProjectRequest::Open(folder));
    bench.settle();
    assert_eq!(bench.state.notes.list().len(), 1);
    assert!(bench.state.settings.notes_shown && bench.state.session.is_none());
}

// ---- strokes of the brush ----

/// Adds a stroke that waits to become paint. Its job fails, because no photo has layers.
fn stroke(bench: &mut TestBench) {
    let drawn = DrawnStroke { viewpoint: bench.state.space.viewpoint, stroke: a_stroke() };
    bench.state.space.brush.stroke = Some(drawn);
    bench.state.space.brush.end();
}

fn frame(bench: &mut TestBench) {
    bench.settle();
    life(bench, LifeEvent::Frame);
    bench.pass(0.1);
}

#[test]
fn strokes_that_wait_are_painted_before_the_project_is_left() {
    let mut bench = TestBench::new();
    (0..2).for_each(|_| stroke(&mut bench));
    leave(&mut bench, Goal::Close);
    assert!(bench.state.life.asks_about_writing());
    life(&mut bench, LifeEvent::Wait);
    frame(&mut bench);
    assert!(bench.state.session.is_some() && bench.state.space.brush.is_painting, "the first one is in work");
    frame(&mut bench);
    assert_eq!(bench.state.space.brush.unpainted(), 1);
    assert_eq!(bench.said().iter().filter(|text| text.contains("was not painted")).count(), 1, "and is told");
    frame(&mut bench);
    frame(&mut bench);
    assert!(bench.state.session.is_none());
}

#[test]
fn strokes_that_wait_are_lost_only_where_that_was_chosen() {
    let mut bench = TestBench::new();
    stroke(&mut bench);
    leave(&mut bench, Goal::Close);
    life(&mut bench, LifeEvent::Stop);
    frame(&mut bench);
    assert!(bench.state.session.is_none());
}

#[test]
fn the_end_of_the_window_paints_strokes_that_wait() {
    let mut bench = TestBench::new();
    (0..3).for_each(|_| stroke(&mut bench));
    end(&mut bench.state, &mut bench.work);
    assert_eq!(bench.state.space.brush.unpainted(), 0);
    let note = bench.state.notes.list().iter().find(|note| note.text.to_string().contains("was not painted"));
    assert_eq!(note.map(|note| note.times), Some(3), "all were tried");
}

#[test]
fn undo_takes_back_the_last_stroke_that_waits() {
    let mut bench = TestBench::new();
    edit(&mut bench, 9);
    (0..2).for_each(|_| stroke(&mut bench));
    bench.request(DecideRequest::Undo);
    assert_eq!((bench.state.space.brush.unpainted(), bench.undoes()), (1, Some("margin")));
    bench.request(DecideRequest::Undo);
    assert_eq!((bench.state.space.brush.unpainted(), bench.undoes()), (0, Some("margin")));
    bench.request(DecideRequest::Undo);
    assert_eq!(bench.undoes(), None);
}

// ---- messages ----

#[test]
fn messages_about_a_project_go_with_it() {
    let mut bench = TestBench::new();
    bench.state.notify(Note::new(Weight::Warning, "the layers are out of date"));
    bench.work.jobs.start(&mut bench.state.running, JobKind::Check, "Checking", |task| {
        loop {
            task.step("photos", 1, 2)?;
        }
    });
    leave(&mut bench, Goal::Close);
    bench.settle();
    assert_eq!(bench.said(), [""; 0]);
}
