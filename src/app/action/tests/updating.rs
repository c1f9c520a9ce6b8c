//! Tests of the updates in the background: when they begin, what comes first, and what stops them.

use std::any::Any;
use std::path::Path;

use super::bench::{PHOTOS, TestBench};
use super::layered::layered;
use crate::action::known::{leave_known, remember_opened};
use crate::state::masking::keeping::MaskWork;
use crate::state::request::{DecideRequest, Flag, JobRequest, MaskRequest, WindowRequest};
use crate::state::running::{Job, JobId, JobKind};
use crate::state::session::PhotoStatus;
use crate::state::updating::Updating;
use crate::work::known::KnownFile;
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;
use quadratura_document::decisions::PhotoDecisions;
use quadratura_document::{CameraPath, Project};
use quadratura_stacks::turns::UpdateSource;

fn updates(bench: &TestBench) -> bool {
    bench.state.running.runs(JobKind::Update)
}

/// Switches updates on, as if the first one had ended. (The stacks of the bench are not on disk, so that none can.)
fn keeping(mut bench: TestBench) -> TestBench {
    bench.pass(1.0);
    bench.request(WindowRequest::Flip(Flag::KeepUpToDate));
    bench.state.updating.begin();
    bench.pass(1.0);
    assert!(!updates(&bench), "nothing is left to do");
    bench
}

fn edit(bench: &mut TestBench, change: impl FnOnce(&mut Project)) {
    let mut project = bench.project();
    change(&mut project);
    bench.request(DecideRequest::Edit("edit".into(), Box::new(project), None));
}

fn widen(bench: &mut TestBench) {
    edit(bench, |project| project.options.margin += 1);
}

/// Goes on after an edit, as if the states of the stacks had been looked at.
fn follow(bench: &mut TestBench) {
    bench.pass(0.1);
    assert!(!updates(bench), "first it is looked at which stacks are out of date");
    let _ = bench.state.session.as_mut().unwrap().pending.take();
    bench.pass(0.1);
}

#[test]
fn it_is_on_in_a_new_window_and_remembered() {
    assert!(crate::state::settings::Settings::default().keep_up_to_date);
    let before: crate::state::settings::Settings = serde_json::from_str("{}").unwrap();
    assert!(before.keep_up_to_date, "settings of an earlier version");
}

#[test]
fn updates_are_paused_for_one_project_in_all_windows_and_not_for_the_next_one() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("projects.json");
    let window = || {
        let mut bench = TestBench::new();
        bench.work.known = KnownFile::new(file.clone());
        bench
    };
    let reopen = |bench: &mut TestBench, project: &Path| {
        leave_known(&mut bench.state);
        (bench.state.updating, bench.state.settings.keep_up_to_date) = (Updating::default(), true);
        remember_opened(&mut bench.state, &mut bench.work, project);
    };
    let mut bench = window();
    let project = bench.folder().to_path_buf();
    reopen(&mut bench, &project);
    bench.pass(1.0);
    assert!(bench.state.settings.keep_up_to_date);
    bench.request(WindowRequest::Flip(Flag::KeepUpToDate));
    bench.pass(1.0);
    reopen(&mut bench, folder.path());
    assert!(bench.state.settings.keep_up_to_date, "another project");
    let mut other = window();
    reopen(&mut other, &project);
    assert!(!other.state.settings.keep_up_to_date, "the same project in another window");
    assert_eq!(other.state.settings.known.recent[0], project.canonicalize().unwrap());
    assert_eq!(other.state.settings.known.recent.len(), 2, "what the first window has opened is known");
}

#[test]
fn a_project_that_is_opened_is_updated_where_it_has_stacks() {
    let mut bench = layered();
    bench.pass(1.0);
    assert!(!updates(&bench), "it is switched off");
    bench.request(WindowRequest::Flip(Flag::KeepUpToDate));
    bench.pass(1.0);
    assert!(updates(&bench));
    let mut bare = TestBench::new();
    bare.request(WindowRequest::Flip(Flag::KeepUpToDate));
    bare.pass(1.0);
    assert!(!updates(&bare), "a photo that was never built is left to the user");
}

#[test]
fn a_decision_is_followed_and_a_bookmark_is_not() {
    let mut bench = keeping(layered());
    edit(&mut bench, |project| project.flight = Some(CameraPath::empty([64, 48])));
    follow(&mut bench);
    assert!(!updates(&bench));
    let mut bench = keeping(layered());
    widen(&mut bench);
    follow(&mut bench);
    assert!(updates(&bench));
}

#[test]
fn what_the_user_starts_comes_first_and_stops_it() {
    let mut bench = keeping(layered());
    bench.state.updating.want();
    bench.state.running.begun(JobId(900), Job::new(JobKind::Export, "Exporting".into()));
    bench.pass(1.0);
    assert!(!updates(&bench));
    bench.state.running.ended(JobId(900));
    bench.pass(1.0);
    assert!(updates(&bench));
    bench.state.running.begun(JobId(901), Job::new(JobKind::Build, "Building layers".into()));
    bench.pass(0.1);
    let stopping = bench.state.running.all().find(|(_, job)| job.kind == JobKind::Update);
    assert!(stopping.is_none_or(|(_, job)| job.is_stopping()));
    assert!(bench.state.updating.is_wanted(), "it goes on afterwards");
    bench.state.running.ended(JobId(901));
    bench.settle();
}

#[test]
fn imports_and_masks_go_before_the_next_photo() {
    let mut bench = keeping(layered());
    let task = Task::silent();
    task.stop_flag().store(true, std::sync::atomic::Ordering::Relaxed);
    let free = |bench: &TestBench| bench.work.live.is_free_now();
    assert!(free(&bench));
    let paints = bench.work.live.paint.take();
    assert!(!free(&bench), "an import writes paint");
    drop(paints);
    bench.state.running.begun(JobId(900), Job::new(JobKind::Import, "Importing".into()));
    bench.pass(0.1);
    assert!(!free(&bench), "an import has begun");
    bench.state.running.ended(JobId(900));
    bench.pass(0.1);
    assert!(free(&bench));
    let photo = PHOTOS[0].to_owned();
    let work = MaskWork::Object { photo, object: "no such object".into(), margin_px: 0 };
    bench.request(MaskRequest::Mask("mask".into(), work));
    bench.work.live.give_way(bench.state.updates_wait());
    assert!(!free(&bench), "a mask waits to be written");
    let stacks = bench.work.live.stacks.take();
    assert!(bench.work.live.right(&task).is_err());
    drop(stacks);
}

#[test]
fn the_photo_in_view_comes_first() {
    let mut bench = layered();
    bench.state.selection.photo = Some(PhotoId(2));
    assert_eq!(bench.state.in_view_first(PhotoId::all(3).collect())[0], PhotoId(2));
}

#[test]
fn the_button_at_its_progress_switches_it_off() {
    let mut bench = layered();
    bench.request(WindowRequest::Flip(Flag::KeepUpToDate));
    bench.pass(1.0);
    let id = bench.state.running.all().find(|(_, job)| job.kind == JobKind::Update).unwrap().0;
    bench.request(JobRequest::Stop(id));
    assert!(!bench.state.settings.keep_up_to_date);
    let mut bench = layered();
    let waits = |bench: &TestBench| bench.state.paused_updates();
    assert_eq!(waits(&bench).outdated, 0);
    let unfilled = bench.session().photos.iter().filter(|photo| photo.lacks_filling()).count();
    assert!(unfilled > 0, "the sample has occluded areas");
    assert_eq!(waits(&bench).unfilled, unfilled);
    bench.state.session.as_mut().unwrap().photos[0].word = "stale";
    assert_eq!(waits(&bench).outdated, 1);
    bench.state.settings.keep_up_to_date = true;
    assert_eq!(waits(&bench).in_words(), None);
}

#[test]
fn an_update_stops_for_the_photos_whose_inputs_change_and_for_no_other() {
    let mut bench = keeping(layered());
    let stops = bench.work.live.new_stops();
    let stopped = || -> Vec<bool> {
        PHOTOS.iter().map(|photo| stops[*photo].load(std::sync::atomic::Ordering::Relaxed)).collect()
    };
    let before = bench.work.live.project(&Task::silent()).unwrap();
    edit(&mut bench, |project| {
        let mut decided = PhotoDecisions::default();
        decided.options.margin = Some(9);
        project.decisions.set(PHOTOS[1], decided);
    });
    bench.pass(0.1);
    assert_eq!(stopped(), [false, true, false]);
    let now = bench.work.live.project(&Task::silent()).unwrap();
    assert!(
        !std::sync::Arc::ptr_eq(&before, &now) && now.project == bench.project(),
        "unsaved decisions count"
    );
    widen(&mut bench);
    bench.pass(0.1);
    assert_eq!(stopped(), [true; 3], "these are options of all photos");
}

#[test]
fn while_the_model_is_not_what_the_decisions_say_nothing_is_made_of_it() {
    let mut bench = keeping(layered());
    let object = bench.session().model().objects[0].name.clone();
    bench.request(DecideRequest::SwitchObject(object, false));
    assert!(bench.session().is_behind());
    bench.work.live.publish(None::<&crate::state::session::Session>);
    let right: Result<Box<dyn Any>, _> = bench.work.live.right(&Task::silent());
    assert!(right.is_err() && bench.work.live.project(&Task::silent()).is_err());
    bench.pass(0.0);
    assert!(!updates(&bench));
}

#[test]
fn reloading_waits_for_a_running_job_and_happens_after_it() {
    let mut bench = TestBench::new();
    let reads = |bench: &TestBench| bench.state.running.runs(JobKind::Open);
    bench.state.running.begun(JobId(900), Job::new(JobKind::Export, "Exporting".into()));
    bench.request(JobRequest::Reread(None));
    bench.pass(0.1);
    assert!(!reads(&bench));
    assert!(bench.said().last().unwrap().contains("waits until “Exporting” has ended"));
    bench.state.running.ended(JobId(900));
    bench.pass(0.1);
    assert!(reads(&bench));
    bench.settle();
    bench.pass(0.1);
    assert!(!reads(&bench), "once");
}

#[test]
fn reloading_waits_for_an_update_and_comes_before_the_next_one() {
    let mut bench = keeping(layered());
    bench.state.running.begun(JobId(900), Job::new(JobKind::Update, "Updating layers".into()));
    bench.request(JobRequest::Reread(None));
    bench.pass(0.1);
    assert!(!bench.state.running.runs(JobKind::Open), "the update goes on");
    assert!(bench.said().last().unwrap().contains("waits until “Updating layers” has ended or is paused"));
    bench.state.running.ended(JobId(900));
    bench.state.updating.want();
    bench.pass(0.1);
    assert!(bench.state.running.runs(JobKind::Open) && !updates(&bench));
    bench.settle();
}

#[test]
fn the_bar_of_an_update_that_was_stopped_goes_on_where_it_was() {
    let mut bench = keeping(layered());
    let share = |bench: &TestBench| bench.state.running.progress(JobKind::Update).unwrap().share();
    let mut job = Job::new(JobKind::Update, "Updating layers".into());
    job.step("fill", String::new(), 2, 5);
    bench.state.running.begun(JobId(900), job);
    bench.pass(0.1);
    let reached = share(&bench);
    assert!(reached > Some(0.3));
    bench.state.running.ended(JobId(900));
    bench.state.updating.want();
    bench.pass(0.1);
    assert!(share(&bench) >= reached);
    bench.settle();
}

#[test]
fn a_photo_is_listed_as_built_while_others_are_still_being_built() {
    let mut bench = layered();
    let built = bench.session().photos.clone();
    let without = |status: &PhotoStatus| PhotoStatus { word: "not built", stack: None, ..status.clone() };
    bench.state.session.as_mut().unwrap().photos = built.iter().map(without).collect();
    let seen = vec![built[0].clone(), without(&built[1]), without(&built[2])];
    let folder = bench.folder().to_path_buf();
    let listed = |bench: &TestBench| -> Vec<bool> {
        bench.session().photos.iter().map(PhotoStatus::is_current).collect()
    };
    bench.state.list_built(&folder, seen.clone());
    assert_eq!(listed(&bench), [false; 3], "the build has ended, and says itself what it has made");
    bench.state.running.begun(JobId(900), Job::new(JobKind::Build, "Building layers".into()));
    bench.state.list_built(&folder, seen);
    assert_eq!(listed(&bench), [true, false, false]);
    assert!(!bench.state.running.runs(JobKind::Preview), "the view waits for all of them");
}

#[test]
fn what_was_looked_at_later_counts_in_whatever_order_it_arrives() {
    let mut bench = layered();
    let now = bench.session().photos.clone();
    let mut former = now.clone();
    (former[0].word, former[0].look) = ("stale", 0);
    bench.state.session.as_mut().unwrap().photos[0].look = 7;
    let session = bench.session();
    assert_eq!(session.newest(former.clone())[0].word, now[0].word, "an earlier look arrives late");
    former[0].look = 8;
    assert_eq!(session.newest(former)[0].word, "stale");
}

#[test]
fn layers_that_will_be_one_are_known_before_they_are_built() {
    let mut bench = layered();
    let layers: Vec<_> = bench.session().stack_of(PhotoId(0)).unwrap().layer_indices().take(2).collect();
    assert!(bench.session().layers_to_merge(PhotoId(0), &bench.state.running).is_empty());
    let stack = bench.session().stack_of(PhotoId(0)).unwrap().clone();
    edit(&mut bench, |project| {
        let of = layers
            .iter()
            .flat_map(|layer| quadratura_stacks::decide::faces_of_layer(&stack, *layer))
            .collect();
        project.decisions.set(PHOTOS[0], PhotoDecisions { merge: vec![of], ..PhotoDecisions::default() });
    });
    assert_eq!(
        bench.session().layers_to_merge(PhotoId(0), &bench.state.running),
        std::slice::from_ref(&layers),
        "at once"
    );
    let _ = bench.state.session.as_mut().unwrap().pending.take();
    assert!(
        bench.session().layers_to_merge(PhotoId(0), &bench.state.running).is_empty(),
        "the stack has what could be merged"
    );
    bench.state.session.as_mut().unwrap().photos[0].word = "stale";
    assert_eq!(bench.session().layers_to_merge(PhotoId(0), &bench.state.running), [layers]);
    assert!(bench.session().layers_to_merge(PhotoId(1), &bench.state.running).is_empty(), "of another photo");
}
