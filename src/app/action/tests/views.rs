//! Tests of the selection, of decisions about it, and of viewpoints.

use super::bench::{PHOTOS, TestBench};
use crate::state::panes::Pane;
use crate::state::request::{DecideRequest, FlightRequest, SelectRequest, SpaceRequest, WindowRequest};
use crate::state::selection::Selection;
use quadratura_base::scene::{FaceId, ObjectId, PhotoId};
use quadratura_layers::LayerIndex;
use quadratura_view::DisplayMode;

// ---- selection ----

#[test]
fn a_photo_that_is_selected_is_the_one_that_commands_mean() {
    let mut bench = TestBench::new();
    assert_eq!(bench.state.selected_photo_name().as_deref(), Some(PHOTOS[0]));
    bench.request(SelectRequest::Only(Selection::Photo(PhotoId(2))));
    assert_eq!(bench.state.selected_photo_name().as_deref(), Some(PHOTOS[2]));
    bench.request(SelectRequest::Only(Selection::Nothing));
    assert_eq!(bench.state.selected_photo(), Some(PhotoId(2)), "it stays the one");
}

#[test]
fn photos_are_stepped_through_in_a_circle() {
    let mut bench = TestBench::new();
    bench.request(SelectRequest::StepPhoto(1));
    bench.request(SelectRequest::StepPhoto(1));
    assert_eq!(bench.state.selected_photo(), Some(PhotoId(2)));
    bench.request(SelectRequest::StepPhoto(1));
    assert_eq!(bench.state.selected_photo(), Some(PhotoId(0)));
    bench.request(SelectRequest::StepPhoto(-1));
    assert_eq!(bench.state.selected_photo(), Some(PhotoId(2)));
}

#[test]
fn layers_are_added_to_the_selection_and_taken_out() {
    let mut bench = TestBench::new();
    let layer = |layer| Selection::Layer { photo: PhotoId(1), layer };
    bench.request(SelectRequest::Only(layer(LayerIndex(3))));
    bench.request(SelectRequest::Toggle(PhotoId(1), LayerIndex(5)));
    assert_eq!(bench.state.selection.layers(), (PhotoId(1), vec![LayerIndex(3), LayerIndex(5)]));
    bench.request(SelectRequest::Toggle(PhotoId(1), LayerIndex(3)));
    assert_eq!(bench.state.selection.layers(), (PhotoId(1), vec![LayerIndex(5)]));
    bench.request(SelectRequest::Toggle(PhotoId(1), LayerIndex(5)));
    assert_eq!(bench.state.selection.layers(), (PhotoId(1), vec![LayerIndex(5)]), "one is always left");
    bench.request(SelectRequest::Toggle(PhotoId(0), LayerIndex(1)));
    assert_eq!(bench.state.selection.layers(), (PhotoId(0), vec![LayerIndex(1)]), "of one photo only");
}

#[test]
fn a_face_is_shown_in_a_photo() {
    let mut bench = TestBench::new();
    bench.request(SelectRequest::ShowInPhoto(PhotoId(1), FaceId(0), Some([3, 4])));
    assert!(bench.state.panes.is_shown(Pane::Photo));
    assert_eq!(bench.state.selected_photo(), Some(PhotoId(1)));
}

// ---- decisions ----

#[test]
fn an_object_is_switched_off_and_on_by_steps() {
    let mut bench = TestBench::new();
    let object = bench.session().model().objects[0].name.clone();
    bench.request(DecideRequest::SwitchObject(object.clone(), false));
    assert!(bench.project().objects_off.contains(&object));
    bench.request(DecideRequest::AllObjectsOn);
    assert!(bench.project().objects_off.is_empty());
    bench.request(DecideRequest::Undo);
    assert!(bench.project().objects_off.contains(&object));
}

#[test]
fn what_was_decided_about_an_object_is_removed_by_one_step() {
    let mut bench = TestBench::new();
    let object = bench.session().model().objects[0].name.clone();
    bench.request(DecideRequest::TurnObject(object.clone(), true));
    bench.request(DecideRequest::SeeThroughObject(object.clone(), true));
    let decided = bench.project();
    assert!(bench.session().is_decided_about(&object));
    bench.request(DecideRequest::FreeObject(object.clone()));
    assert!(!bench.session().is_decided_about(&object));
    assert!(bench.project().impostors.is_empty() && bench.project().see_through.is_empty());
    bench.request(DecideRequest::Undo);
    assert!(bench.project() == decided, "undone");
}

#[test]
fn the_model_without_an_object_is_taken_after_a_moment() {
    let mut bench = TestBench::new();
    let object = bench.session().model().objects[0].name.clone();
    let before = bench.session().model().objects.len();
    bench.request(SelectRequest::Only(Selection::Object(ObjectId(1))));
    bench.request(DecideRequest::SwitchObject(object, false));
    bench.settle();
    assert_eq!(bench.session().model().objects.len(), before);
    bench.pass(1.0);
    bench.settle();
    assert_eq!(bench.session().model().objects.len(), before - 1);
    assert_eq!(bench.state.selection.main, Selection::Object(ObjectId(0)), "by its name");
}

#[test]
fn an_object_that_is_not_there_is_a_problem_and_no_step() {
    let mut bench = TestBench::new();
    bench.request(DecideRequest::SwitchObject("no such".into(), false));
    assert_eq!((bench.undoes(), bench.said().len()), (None, 1));
}

#[test]
fn a_photo_without_layers_has_nothing_to_merge_or_split() {
    let mut bench = TestBench::new();
    for request in [DecideRequest::Merge, DecideRequest::Split] {
        bench.request(request);
    }
    assert_eq!(bench.undoes(), None);
}

#[test]
fn a_face_is_excluded_from_the_selected_photo() {
    let mut bench = TestBench::new();
    bench.request(SelectRequest::Only(Selection::Face(FaceId(0))));
    bench.request(DecideRequest::Exclude);
    assert!(bench.project().decisions.photos.contains_key(PHOTOS[0]), "{:?}", bench.said());
    bench.request(DecideRequest::Reset);
    assert!(!bench.project().decisions.photos.contains_key(PHOTOS[0]));
}

// ---- views ----

#[test]
fn a_photo_is_flown_into_in_the_3d_view() {
    let mut bench = TestBench::new();
    bench.request(WindowRequest::ShowPane(Pane::Photo));
    bench.request(SpaceRequest::FlyToPhoto(PhotoId(2)));
    assert!(bench.state.panes.is_shown(Pane::Space));
    assert_eq!(bench.state.selection.main, Selection::Photo(PhotoId(2)));
}

#[test]
fn the_picture_shows_what_is_chosen() {
    let mut bench = TestBench::new();
    bench.request(SpaceRequest::Display(DisplayMode::Coverage));
    assert_eq!(bench.state.space.look.display, DisplayMode::Coverage);
}

#[test]
fn a_view_is_kept_by_the_first_free_name_and_can_be_undone() {
    let mut bench = TestBench::new();
    bench.request(FlightRequest::KeepView);
    bench.request(FlightRequest::KeepView);
    let names: Vec<String> = bench.project().views.iter().map(|view| view.name.clone()).collect();
    assert_eq!(names, ["View 1", "View 2"]);
    assert!(bench.state.flights.shown);
    bench.request(DecideRequest::Undo);
    assert_eq!(bench.project().views.len(), 1);
}

#[test]
fn keyframes_follow_each_other_and_are_removed() {
    let mut bench = TestBench::new();
    bench.request(FlightRequest::AddKeyframe);
    assert!(!bench.state.can_fly());
    bench.request(FlightRequest::AddKeyframe);
    assert!(bench.state.can_fly() && bench.state.has_keyframe());
    bench.request(FlightRequest::RemoveKeyframe);
    assert!(!bench.state.can_fly() && !bench.state.has_keyframe());
}

#[test]
fn a_flight_is_played_to_its_end() {
    let mut bench = TestBench::new();
    bench.request(FlightRequest::AddKeyframe);
    bench.request(FlightRequest::AddKeyframe);
    bench.request(FlightRequest::Play);
    assert!(bench.state.plays());
    bench.pass(0.5);
    assert!(bench.state.plays() && bench.state.window.next_frame_s == Some(0.0));
    bench.pass(60.0);
    assert!(!bench.state.plays());
}
