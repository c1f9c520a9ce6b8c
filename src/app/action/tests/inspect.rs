//! Tests of what the inspector knows of the selection.

use super::bench::{PHOTOS, TestBench};
use super::layered::layered;
use crate::state::first_steps::FirstStep;
use crate::state::next_steps::{NextStep, SiteStep};
use crate::state::panels::Tab;
use crate::state::panes::Pane;
use crate::state::request::{DecideRequest, Flag, SelectRequest, WindowRequest};
use crate::state::selection::Selection;
use quadratura_base::scene::{FaceId, ObjectId, PhotoId};
use quadratura_layers::LayerIndex;
use quadratura_stacks::decide::EXCLUDED;
use quadratura_stacks::untextured::FaceTexture;

const FACE: FaceId = FaceId(0);
const OBJECT: ObjectId = ObjectId(0);

fn next_steps(bench: &TestBench, photo: PhotoId) -> Vec<NextStep> {
    bench.session().next_steps(photo, &bench.state.quality.fill)
}

fn site_steps(bench: &TestBench, object: Option<ObjectId>) -> Vec<SiteStep> {
    bench.session().next_steps_of_site(object, &bench.state.quality.fill, &bench.state.selection.facts)
}

fn with_face(mut bench: TestBench) -> TestBench {
    bench.request(SelectRequest::Only(Selection::Face(FACE)));
    bench.state.look_up_selection();
    bench
}

#[test]
fn a_selected_face_is_looked_up_in_every_photo() {
    let bench = with_face(layered());
    let found = bench.state.selection.facts.photos_of_face(FACE).unwrap();
    assert_eq!(found.photos.len(), PHOTOS.len());
    assert!(found.photos.iter().all(|photo| matches!(photo.given, FaceTexture::Texture { .. })));
    assert!(
        bench.state.selection.facts.photos_of_face(FaceId(1)).is_none(),
        "another face was not asked for"
    );
}

#[test]
fn a_photo_without_layers_is_told_apart_from_one_that_has_nothing_of_the_face() {
    let bench = with_face(TestBench::new());
    let found = bench.state.selection.facts.photos_of_face(FACE).unwrap();
    assert!(found.photos.iter().all(|photo| matches!(photo.given, FaceTexture::NotBuilt)));
}

#[test]
fn a_decision_about_the_face_is_known_after_the_next_look_and_undone_with_it() {
    let mut bench = with_face(layered());
    bench.request(DecideRequest::Exclude);
    bench.state.look_up_selection();
    let decided =
        |bench: &TestBench| bench.state.selection.facts.photos_of_face(FACE).unwrap().photos[0].decided;
    assert_eq!(decided(&bench), Some("excluded"));
    bench.request(DecideRequest::Undo);
    bench.state.look_up_selection();
    assert_eq!(decided(&bench), None);
}

#[test]
fn a_pinned_face_names_its_photo() {
    let mut bench = with_face(layered());
    bench.request(SelectRequest::StepPhoto(1));
    bench.request(SelectRequest::Only(Selection::Face(FACE)));
    bench.request(DecideRequest::Pin);
    bench.state.look_up_selection();
    assert_eq!(bench.state.selection.facts.photos_of_face(FACE).unwrap().pinned_to, Some(PhotoId(1)));
}

#[test]
fn photos_are_counted_for_each_face_of_an_object_without_those_that_are_excluded() {
    let mut bench = layered();
    bench.request(SelectRequest::Only(Selection::Object(OBJECT)));
    bench.state.look_up_selection();
    let faces = bench.session().model().object(OBJECT).faces.len();
    assert_eq!(bench.state.selection.facts.photos_of_object(OBJECT), vec![PHOTOS.len() as u32; faces]);
    bench.request(DecideRequest::Exclude);
    bench.state.look_up_selection();
    assert_eq!(bench.state.selection.facts.photos_of_object(OBJECT), vec![PHOTOS.len() as u32 - 1; faces]);
}

#[test]
fn nothing_is_looked_up_while_another_tab_or_no_side_is_shown() {
    for hide in [WindowRequest::ShowTab(Tab::Fill), WindowRequest::Flip(Flag::Side)] {
        let mut bench = layered();
        bench.request(hide);
        bench = with_face(bench);
        assert!(bench.state.selection.facts.photos_of_face(FACE).is_none());
        bench.request(WindowRequest::ShowTab(Tab::Selection));
        bench.state.settings.side_shown = true;
        bench.state.look_up_selection();
        assert!(bench.state.selection.facts.photos_of_face(FACE).is_some());
    }
}

#[test]
fn a_stack_that_was_made_anew_is_looked_at_anew() {
    let mut bench = with_face(layered());
    let session = bench.state.session.as_mut().unwrap();
    session.photos[2].stack = None;
    bench.state.look_up_selection();
    let given = &bench.state.selection.facts.photos_of_face(FACE).unwrap().photos[2].given;
    assert!(matches!(given, FaceTexture::NotBuilt));
}

#[test]
fn a_face_of_no_such_photo_is_shown_nowhere() {
    let mut bench = TestBench::new();
    bench.request(SelectRequest::ShowInPhoto(PhotoId::new(PHOTOS.len()), FACE, None));
    assert!(!bench.state.panes.is_shown(Pane::Photo));
}

#[test]
fn what_to_do_next_begins_with_building_and_goes_on_to_filling_painting_and_masking() {
    let photo = PhotoId(0);
    let bench = TestBench::new();
    assert_eq!(next_steps(&bench, photo), [NextStep::Build { again: false }, NextStep::Mask]);
    let mut bench = layered();
    let steps = next_steps(&bench, photo);
    let [NextStep::Fill, NextStep::Paint(areas), NextStep::Mask] = &steps[..] else { panic!("{steps:?}") };
    assert!(areas.count > 0 && areas.largest.len() <= 3, "{areas:?}");
    let hidden = |layer: &quadratura_document::ImageLayer| layer.texels_used - layer.texels_visible;
    let stack = bench.session().stack_of(photo).unwrap();
    let most = stack.layers_of_faces().map(hidden).max().unwrap();
    assert_eq!(hidden(&stack.image_layers[areas.largest[0].0.index()]), most, "the largest comes first");
    bench.state.session.as_mut().unwrap().photos[0].word = "stale";
    assert_eq!(next_steps(&bench, photo)[0], NextStep::Build { again: true });
}

#[test]
fn the_project_and_an_object_say_what_to_do_next_with_all_photos() {
    let all = PHOTOS.len();
    assert_eq!(site_steps(&TestBench::new(), None), [SiteStep::Build(all)]);
    let mut bench = layered();
    let steps = site_steps(&bench, None);
    let [SiteStep::Fill(photos), SiteStep::Paint(of_site)] = &steps[..] else { panic!("{steps:?}") };
    assert_eq!((*photos, of_site.photos), (all, all));
    let hidden = |(_, _, share): &(PhotoId, LayerIndex, f64)| *share;
    assert!(of_site.largest.iter().map(hidden).all(|share| share > 0.0 && share <= 1.0));
    // What stands in front of all else has no hidden areas, and what is behind it has.
    let of_objects: Vec<usize> = (0..bench.session().model().objects.len() as u32)
        .map(|object| site_steps(&bench, Some(ObjectId(object))))
        .map(|steps| match steps.iter().find(|step| matches!(step, SiteStep::Paint(_))) {
            Some(SiteStep::Paint(areas)) => areas.count,
            _ => 0,
        })
        .collect();
    assert!(
        of_objects.iter().any(|count| *count > 0) && of_objects.iter().all(|count| *count <= of_site.count)
    );
    assert!(of_objects.contains(&0) || of_objects.iter().sum::<usize>() >= of_site.count, "{of_objects:?}");
    bench.state.session.as_mut().unwrap().photos[0].word = "stale";
    let steps = site_steps(&bench, None);
    assert_eq!(steps[..2], [SiteStep::Build(1), SiteStep::Fill(all - 1)]);
}

#[test]
fn an_object_that_a_photo_does_not_texture_any_more_says_so_and_is_given_back() {
    let mut bench = layered();
    bench.request(SelectRequest::Only(Selection::Object(OBJECT)));
    assert!(bench.session().decided_about_object(OBJECT).is_empty());
    bench.state.selection.photo = Some(PhotoId(1));
    bench.request(DecideRequest::Exclude);
    assert_eq!(bench.session().decided_about_object(OBJECT), [(PhotoId(1), EXCLUDED)]);
    bench.request(DecideRequest::Undo);
    assert!(bench.session().decided_about_object(OBJECT).is_empty());
}

#[test]
fn the_first_steps_lead_to_the_first_painted_layer() {
    assert_eq!(TestBench::new().session().next_first_step(false), Some(FirstStep::Build));
    let bench = layered();
    assert_eq!(bench.session().next_first_step(false), Some(FirstStep::Fill));
    let is_done = |step| bench.session().is_done(step, true);
    assert!(is_done(FirstStep::Edit) && is_done(FirstStep::Save));
}
