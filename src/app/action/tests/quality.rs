//! Tests of fillings and exposures: the facts that panels ask for, and the decisions.

use super::bench::{PHOTOS, TestBench};
use crate::state::request::{DecideRequest, FlightRequest, QualityRequest};
use quadratura_base::scene::PhotoId;
use quadratura_layers::fill::{FillOptions, Invent};
use quadratura_stacks::fill::seen::{EditedPaint, Seen, SeenEdit};
use quadratura_stacks::fill::viewpoints::Viewpoints;
use quadratura_views::colour::ColourEdit;

/// Asks until no job runs any more; returns in how many of three frames a job was started.
fn starts(bench: &mut TestBench, request: fn() -> QualityRequest) -> usize {
    let started = |bench: &mut TestBench| {
        bench.request(request());
        let started = !bench.state.running.is_idle();
        bench.settle();
        started
    };
    // What an edit has started before is no answer to this request.
    bench.settle();
    (0..3).filter(|_| started(bench)).count()
}

fn colour(bench: &mut TestBench, edit: ColourEdit, goes_on: bool) {
    bench.request(QualityRequest::Colour { edits: vec![edit], goes_on });
}

// ---- fillings ----

#[test]
fn what_a_panel_asks_for_in_every_frame_is_computed_once() {
    let mut bench = TestBench::new();
    assert_eq!(starts(&mut bench, || QualityRequest::WantPainters), 1);
    assert!(bench.state.quality.fill.painters.found().is_some_and(Vec::is_empty));
    assert_eq!(starts(&mut bench, || QualityRequest::WantWorst), 1);
    assert!(bench.state.quality.fill.worst.found().is_some_and(|worst| worst.layers.is_empty()));
}

#[test]
fn a_fact_that_cannot_be_found_out_is_reported_once() {
    let mut bench = TestBench::new();
    let stack = bench.folder().join("stacks").join(PHOTOS[0]);
    std::fs::create_dir_all(&stack).unwrap();
    std::fs::write(stack.join("stack.json"), "{").unwrap();
    assert_eq!(starts(&mut bench, || QualityRequest::WantShares(PhotoId(0))), 1);
    let shares = &bench.state.quality.fill.shares[&PhotoId(0)];
    assert!(shares.failed(&bench.state.running) && bench.said().len() == 1, "{:?}", bench.said());
}

#[test]
fn other_viewpoints_rank_layers_again_and_views_of_photos_do_not() {
    let mut bench = TestBench::new();
    assert_eq!(bench.state.quality.fill.seen_from(&bench.project()), Viewpoints::Photos);
    starts(&mut bench, || QualityRequest::WantWorst);
    bench.request(QualityRequest::SeeFrom(Viewpoints::Photos));
    bench.request(FlightRequest::KeepView);
    assert_eq!(starts(&mut bench, || QualityRequest::WantWorst), 0, "a bookmark is no camera of a photo");
    bench.request(QualityRequest::SeeFrom(Viewpoints::Kept));
    assert_eq!(starts(&mut bench, || QualityRequest::WantWorst), 1);
    assert_eq!(bench.state.quality.fill.worst.found().unwrap().views.len(), 1);
    bench.request(FlightRequest::KeepView);
    assert_eq!(starts(&mut bench, || QualityRequest::WantWorst), 1);
}

#[test]
fn facts_are_asked_for_again_after_fillings_have_changed_and_choices_stay() {
    let mut bench = TestBench::new();
    bench.request(QualityRequest::SeeFrom(Viewpoints::Kept));
    bench.request(QualityRequest::TypeWithout(Some("tree".into())));
    starts(&mut bench, || QualityRequest::WantPainters);
    bench.state.quality.forget_fillings();
    assert_eq!(starts(&mut bench, || QualityRequest::WantPainters), 1);
    bench.state.quality.forget_stacks();
    assert_eq!(starts(&mut bench, || QualityRequest::WantPainters), 1);
    assert_eq!(bench.state.quality.fill.seen_from(&bench.project()), Viewpoints::Kept);
    assert_eq!(bench.state.quality.fill.without.as_deref(), Some("tree"));
    bench.request(QualityRequest::TypeWithout(None));
    assert_eq!(bench.state.quality.fill.without, None);
}

#[test]
fn options_of_filling_are_steps_named_by_what_changes() {
    let mut bench = TestBench::new();
    let before = bench.project().fill;
    bench.request(QualityRequest::Fill(FillOptions { invent: Invent::Diffusion, ..before.clone() }));
    let named = bench.undoes().map(str::to_owned);
    bench.request(QualityRequest::Fill(FillOptions { invent: Invent::Exemplar, ..before.clone() }));
    assert!(named.is_some() && bench.undoes() == Some("fill options"));
    bench.request(QualityRequest::Fill(FillOptions { propagate: vec!["*".into()].into(), ..before.clone() }));
    assert_eq!(bench.undoes(), Some("choice of propagated paint"));
    assert!(bench.session().has_propagated());
    bench.request(DecideRequest::Undo);
    assert!(!bench.session().has_propagated());
}

#[test]
fn where_paint_is_seen_is_a_step_for_each_switch_and_the_question_ends_with_an_answer() {
    let mut bench = TestBench::new();
    assert!(!bench.state.asks_where_paint_is_seen(), "there is no paint");
    bench.state.round_trip.painted.insert("a.jpg".into());
    assert!(bench.state.asks_where_paint_is_seen());
    let see = |paint, seen| QualityRequest::See(SeenEdit { paint, seen });
    bench.request(see(EditedPaint::OfImport(3), Seen::OnlyHere));
    assert!(bench.project().fill.only_here.imports.contains(&3));
    assert_eq!(bench.undoes(), Some("choice of propagated paint"));
    bench.request(DecideRequest::Undo);
    assert!(bench.project().fill.only_here.imports.is_empty());
    bench.request(see(EditedPaint::All, Seen::OnlyHere));
    assert!(!bench.state.asks_where_paint_is_seen(), "it is answered");
    bench.request(DecideRequest::Undo);
    assert!(bench.state.asks_where_paint_is_seen(), "and the answer undone");
    bench.request(QualityRequest::ChooseLater);
    assert!(!bench.state.asks_where_paint_is_seen());
    assert!(bench.project().fill.propagate.is_undecided());
}

// ---- exposures ----

#[test]
fn a_drag_of_an_exposure_is_one_step() {
    let mut bench = TestBench::new();
    for (stops, goes_on) in [(0.1, true), (0.2, true), (0.3, false)] {
        colour(&mut bench, ColourEdit::Fix(PHOTOS[0].into(), [stops; 3]), goes_on);
    }
    assert_eq!(bench.project().colour.fixed[PHOTOS[0]], [0.3; 3]);
    assert_eq!(bench.undoes(), Some(format!("exposure of {}", PHOTOS[0]).as_str()));
    bench.request(DecideRequest::Undo);
    assert!(bench.project().colour.is_default() && bench.undoes().is_none());
}

#[test]
fn groups_of_light_are_steps_that_are_taken_back_one_by_one() {
    let mut bench = TestBench::new();
    let evening = |photo: &str| ColourEdit::Group("Light 2".into(), vec![photo.into()]);
    colour(&mut bench, evening(PHOTOS[0]), false);
    colour(&mut bench, evening(PHOTOS[1]), false);
    let members = |bench: &TestBench| {
        bench.project().colour.groups.as_ref().map_or(0, |groups| groups["Light 2"].len())
    };
    assert_eq!((members(&bench), bench.undoes()), (2, Some("groups of light")));
    bench.request(DecideRequest::Undo);
    assert_eq!(members(&bench), 1);
    bench.request(DecideRequest::Undo);
    assert!(bench.project().colour.is_default() && bench.undoes().is_none());
    colour(&mut bench, ColourEdit::OneGroup, false);
    assert!(bench.project().colour.groups.as_ref().unwrap().is_empty());
}

#[test]
fn two_drags_are_two_steps() {
    let mut bench = TestBench::new();
    for stops in [0.1, 0.2] {
        colour(&mut bench, ColourEdit::Fix(PHOTOS[0].into(), [stops; 3]), false);
    }
    bench.request(DecideRequest::Undo);
    assert_eq!(bench.project().colour.fixed[PHOTOS[0]], [0.1; 3]);
}

#[test]
fn an_exposure_of_a_photo_that_is_not_there_is_a_problem_and_no_step() {
    let mut bench = TestBench::new();
    colour(&mut bench, ColourEdit::LeaveOut("no such".into()), false);
    assert_eq!((bench.undoes(), bench.said().len()), (None, 1));
}

#[test]
fn photos_that_cannot_be_compared_are_compared_again_only_when_one_requests() {
    let mut bench = TestBench::new();
    assert_eq!(starts(&mut bench, || QualityRequest::WantEstimate), 1);
    let colour = &bench.state.quality.colour;
    assert!(colour.failed(&bench.state.running) || colour.estimate.is_some(), "{:?}", bench.said());
    bench.request(QualityRequest::EstimateAgain);
    assert!(!bench.state.quality.colour.failed(&bench.state.running));
    assert_eq!(starts(&mut bench, || QualityRequest::WantEstimate), 1);
}

#[test]
fn an_estimate_is_made_again_for_decisions_that_it_depends_on() {
    let mut bench = TestBench::new();
    starts(&mut bench, || QualityRequest::WantEstimate);
    colour(&mut bench, ColourEdit::Even(false), false);
    assert_eq!(starts(&mut bench, || QualityRequest::WantEstimate), 0, "it does not depend on that");
    colour(&mut bench, ColourEdit::LeaveOut(PHOTOS[1].into()), false);
    assert_eq!(starts(&mut bench, || QualityRequest::WantEstimate), 1);
}
