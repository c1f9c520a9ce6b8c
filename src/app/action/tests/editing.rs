//! Tests of edits, and of the updates that follow from them.

use super::bench::TestBench;
use crate::state::notes::{NoteRemedy, Weight};
use crate::state::pending::Invalidation;
use crate::state::request::{DecideRequest, JobRequest};
use crate::state::running::JobKind;
use quadratura_base::geometry::Similarity;
use quadratura_stacks::decide::LayerEdit;

fn edit(bench: &mut TestBench, change: impl FnOnce(&mut quadratura_document::Project)) {
    let mut project = bench.project();
    change(&mut project);
    bench.request(DecideRequest::Edit("edit".into(), Box::new(project), None));
    bench.settle();
}

fn move_model(bench: &mut TestBench) {
    edit(bench, |project| project.world_from_model = Similarity { scale: 2.0, ..Similarity::IDENTITY });
}

#[test]
fn what_follows_from_an_edit_begins_when_there_was_none_for_a_moment() {
    let mut bench = TestBench::new();
    edit(&mut bench, |project| project.options.margin += 1);
    bench.pass(0.1);
    assert!(!bench.state.running.runs(JobKind::Survey));
    bench.pass(0.3);
    assert!(bench.state.running.runs(JobKind::Survey));
}

#[test]
fn an_edit_that_changes_nothing_is_followed_by_nothing() {
    let mut bench = TestBench::new();
    edit(&mut bench, |_| ());
    assert_eq!(bench.session().pending.invalidation, None);
    assert!(!bench.state.is_dirty());
}

#[test]
fn a_site_that_cannot_be_read_again_stays_as_it_was_and_can_be_read_later() {
    let mut bench = TestBench::new();
    move_model(&mut bench);
    assert!(bench.session().is_behind());
    bench.pass(1.0);
    assert!(bench.state.running.runs(JobKind::Open));
    bench.settle();
    let note = bench.state.notes.list().last().unwrap();
    assert_eq!((note.weight, &note.remedies[0].1), (Weight::Problem, &NoteRemedy::ReadAgain));
    assert_eq!(bench.session().photos.len(), super::bench::PHOTOS.len());
    assert_eq!(bench.session().pending.invalidation, Some(Invalidation::Site));
    bench.pass(1.0);
    assert!(bench.state.running.is_idle(), "it is not tried again by itself");
}

#[test]
fn layers_are_not_built_from_a_site_that_is_behind() {
    let mut bench = TestBench::new();
    move_model(&mut bench);
    bench.request(JobRequest::Build(Vec::new()));
    assert!(bench.state.running.runs(JobKind::Open) && !bench.state.running.runs(JobKind::Build));
    bench.settle();
    assert!(bench.session().is_behind());
}

#[test]
fn an_undo_is_followed_like_an_edit() {
    let mut bench = TestBench::new();
    edit(&mut bench, |project| project.options.margin += 1);
    bench.pass(1.0);
    bench.settle();
    assert_eq!(bench.session().pending.invalidation, None);
    bench.request(DecideRequest::Undo);
    assert_eq!(bench.session().pending.invalidation, Some(Invalidation::Stacks));
}

#[test]
fn a_decision_that_is_not_possible_is_a_problem_that_is_told_and_no_step() {
    let mut bench = TestBench::new();
    let before = bench.said().len();
    let merge = LayerEdit::Split { photo: "a.jpg".into(), groups: Vec::new() };
    bench.request(DecideRequest::Layers(Box::new(merge)));
    assert_eq!((bench.said().len(), bench.undoes()), (before + 1, None));
    let merge = LayerEdit::Split { photo: "a.jpg".into(), groups: Vec::new() };
    let mut empty = TestBench::empty();
    empty.request(DecideRequest::Layers(Box::new(merge)));
    assert_eq!(empty.said(), ["no project is open"]);
}

#[test]
fn an_import_is_a_step_until_it_is_forgotten() {
    let mut bench = TestBench::new();
    bench.state.remember_import(3, None, vec!["a.psd".into()], Vec::new());
    assert_eq!(bench.undoes(), Some("import 3"));
    bench.state.forget_import(3);
    assert_eq!(bench.undoes(), None);
}
