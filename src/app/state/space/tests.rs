//! Tests of the requests for pictures of the 3D view, and of what it shows of them.

use std::sync::Arc;
use std::time::Duration;

use super::*;
use quadratura_base::scene::PhotoId;
use quadratura_base::scene::synthetic::closed_form::stairs;
use quadratura_projection::model_surface::ModelSurface;
use quadratura_view::Picture;

const AT_REST: FrameFacts = FrameFacts { background: [1, 2, 3], moves: false };
const MOVING: FrameFacts = FrameFacts { background: [1, 2, 3], moves: true };

fn view() -> SpaceView {
    SpaceView { size_px: [4000, 3000], ..SpaceView::default() }
}

/// Requests a picture, which must be due.
fn requested(space: &mut SpaceView, frame: FrameFacts, now_s: f64) -> PictureRequest {
    space.due(frame, now_s, false).0.expect("a picture is due")
}

/// Shows a small picture as the one that was requested.
fn shows(space: &mut SpaceView, request: PictureRequest) {
    let small = painted(PictureRequest { shot: small(request.shot.clone()), ..request.clone() });
    space.show(PaintedPicture { request, ..small });
}

fn painted(request: PictureRequest) -> PaintedPicture {
    let (width, height) = (request.shot.camera.width, request.shot.camera.height);
    let count = (width * height) as usize;
    PaintedPicture {
        request,
        image: Picture { width, height, rgba: vec![255; 4 * count] },
        faces: vec![1; count],
        surface: ModelSurface::from_model(&stairs().model).into(),
        spent: Duration::from_millis(20),
        images: None,
    }
}

#[test]
fn a_view_is_drawn_coarsely_while_it_moves_and_finally_when_it_rests() {
    let mut space = view();
    space.moved(10.0);
    let moving = requested(&mut space, MOVING, 10.0);
    assert_eq!((moving.shot.quality, moving.yields), (Quality::Preview, false));
    assert!(moving.shot.camera.width < 4000, "it is smaller than the view");
    shows(&mut space, moving);
    let (stopped, again_s) = space.due(AT_REST, 10.1, false);
    let stopped = stopped.unwrap();
    assert_eq!((stopped.shot.quality, stopped.yields), (Quality::Preview, true));
    assert_eq!((stopped.shot.camera.width, stopped.shot.camera.height), (4000, 3000));
    assert!((again_s.unwrap() - 0.15).abs() < 1e-9, "{again_s:?}");
    assert_eq!(space.due(AT_REST, 10.3, true), (None, None), "it is shown before the final one is begun");
    shows(&mut space, stopped);
    let (rests, again_s) = space.due(AT_REST, 10.3, false);
    assert_eq!((rests.unwrap().shot.quality, again_s), (Quality::Final, None));
}

#[test]
fn a_view_that_shows_nothing_yet_gets_a_coarse_picture_before_the_final_one() {
    let mut space = view();
    let (first, again_s) = space.due(AT_REST, 5.0, false);
    let first = first.unwrap();
    assert_eq!((first.shot.quality, first.yields), (Quality::Preview, true));
    assert!(first.shot.trees_within.is_some());
    assert_eq!(again_s, None, "it waits for the picture, not for a time");
    assert_eq!(space.due(AT_REST, 5.1, true), (None, None));
    shows(&mut space, first);
    let last = requested(&mut space, AT_REST, 6.0);
    assert_eq!((last.shot.quality, last.shot.trees_within), (Quality::Final, None));
}

#[test]
fn a_view_whose_size_changes_at_rest_has_a_coarse_picture_of_it_a_final_one_and_no_more() {
    let mut space = view();
    let first = requested(&mut space, AT_REST, 5.0);
    shows(&mut space, first);
    let last = requested(&mut space, AT_REST, 6.0);
    shows(&mut space, last);
    space.size_px = [400, 300];
    let coarse = requested(&mut space, AT_REST, 7.0);
    assert_eq!((coarse.shot.quality, coarse.shot.camera.width), (Quality::Preview, 400));
    shows(&mut space, coarse);
    let last = requested(&mut space, AT_REST, 7.0);
    assert_eq!(last.shot.quality, Quality::Final);
    shows(&mut space, last);
    assert_eq!(space.due(AT_REST, 8.0, false), (None, None));
}

#[test]
fn what_stands_in_for_the_model_while_the_view_moves_is_followed_by_a_coarse_picture_of_the_model() {
    // So small that it is drawn in full while it moves.
    let mut space = SpaceView { size_px: [400, 300], ..SpaceView::default() };
    space.images.stands_in = true;
    let first = requested(&mut space, AT_REST, 4.0);
    shows(&mut space, first);
    space.moved(5.0);
    let moving = requested(&mut space, MOVING, 5.0);
    assert!(matches!(moving.from, DrawnFrom::StandIn(_)) && moving.shot.camera.width == 400);
    shows(&mut space, moving);
    let coarse = requested(&mut space, AT_REST, 6.0);
    assert_eq!((coarse.shot.quality, &coarse.from), (Quality::Preview, &DrawnFrom::Model));
    shows(&mut space, coarse);
    assert_eq!(requested(&mut space, AT_REST, 6.0).shot.quality, Quality::Final);
}

#[test]
fn a_picture_is_requested_once_unless_it_shows_a_former_state() {
    let mut space = view();
    let first = requested(&mut space, AT_REST, 5.0);
    assert_eq!(space.due(AT_REST, 5.1, false), (None, None));
    space.refresh();
    let again = requested(&mut space, AT_REST, 5.2);
    assert_eq!((&again.shot, again.yields), (&first.shot, first.yields));
    assert!(!again.shows_the_same(&first), "the first one shows a former state");
}

#[test]
fn a_view_of_another_size_or_background_is_drawn_again() {
    let mut space = view();
    let first = requested(&mut space, AT_REST, 5.0);
    let light = requested(&mut space, FrameFacts { background: [9, 9, 9], ..AT_REST }, 5.0);
    assert_eq!((first.background, light.background), ([1, 2, 3], [9, 9, 9]));
    space.size_px = [200, 100];
    let small = requested(&mut space, AT_REST, 5.0).shot.camera;
    assert_eq!((small.width, small.height), (200, 100));
}

#[test]
fn a_moving_view_waits_for_a_busy_painter_and_one_at_rest_does_not() {
    let mut space = view();
    assert_eq!(space.due(MOVING, 1.0, true), (None, None));
    assert!(space.due(AT_REST, 1.0, true).0.is_some());
}

#[test]
fn changed_content_is_drawn_quickly_first_and_finally_after_a_moment() {
    let mut space = view();
    let first = requested(&mut space, AT_REST, 5.0);
    shows(&mut space, first);
    assert_eq!(requested(&mut space, AT_REST, 5.0).shot.quality, Quality::Final);
    space.redraw();
    let quick = requested(&mut space, AT_REST, 6.0);
    assert_eq!((quick.shot.quality, quick.yields), (Quality::Preview, false));
    let (whole, again_s) = space.due(AT_REST, 6.1, false);
    let whole = whole.unwrap();
    assert_eq!(whole.shot.camera.width, 4000);
    assert!(again_s.is_some());
    shows(&mut space, whole);
    assert_eq!(requested(&mut space, AT_REST, 6.5).shot.quality, Quality::Final);
}

#[test]
fn content_that_changes_while_the_painter_is_busy_is_drawn_when_it_is_free() {
    let mut space = view();
    let first = requested(&mut space, MOVING, 4.0);
    shows(&mut space, first);
    space.redraw();
    assert_eq!(space.due(AT_REST, 5.0, true).0, None);
    let later = requested(&mut space, AT_REST, 7.0);
    assert_eq!(
        (later.shot.quality, later.yields),
        (Quality::Preview, false),
        "it has waited as changed content"
    );
}

#[test]
fn a_view_that_moves_gives_up_the_final_picture_and_waits_for_that_of_a_moving_view() {
    let mut space = view();
    let first = requested(&mut space, AT_REST, 5.0);
    shows(&mut space, first);
    assert!(requested(&mut space, AT_REST, 6.0).yields);
    space.moved(6.1);
    let moving = space.due(MOVING, 6.1, true).0.expect("the final picture is given up");
    assert_eq!((moving.shot.quality, moving.yields), (Quality::Preview, false));
    let mut there = space.viewpoint;
    there.orbit(0.3, 0.0, glam::DVec3::Z);
    space.show_from(there, 6.2);
    assert_eq!(space.due(MOVING, 6.2, true).0, None);
    assert!(space.due(MOVING, 6.3, false).0.is_some());
}

#[test]
fn the_time_of_the_first_picture_is_not_that_of_those_that_follow() {
    // So small that it is drawn in full while it moves.
    let small_view = || SpaceView { size_px: [400, 300], ..SpaceView::default() };
    let mut space = small_view();
    let first = requested(&mut space, AT_REST, 5.0);
    let slow = |request: PictureRequest| PaintedPicture {
        spent: Duration::from_secs(9),
        ..painted(PictureRequest { shot: small(request.shot.clone()), ..request })
    };
    assert_eq!(requested(&mut small_view(), MOVING, 6.0).shot.camera.width, 400);
    space.show(slow(first));
    assert_eq!(requested(&mut space, MOVING, 6.0).shot.camera.width, 400);
    let second = requested(&mut space, AT_REST, 7.0);
    space.show(slow(PictureRequest {
        shot: Shot { quality: Quality::Preview, ..second.shot.clone() },
        ..second
    }));
    assert!(requested(&mut space, MOVING, 8.0).shot.camera.width < 400);
}

#[test]
fn a_reason_why_nothing_is_drawn_is_new_once() {
    let mut space = view();
    let request = requested(&mut space, AT_REST, 5.0);
    shows(&mut space, request);
    assert!(space.has_picture());
    assert!(space.fail("no driver") && !space.fail("no driver"));
    assert!(!space.has_picture() && space.trouble.as_deref() == Some("no driver"));
    assert!(space.fail("the device is lost"));
    assert!(space.due(AT_REST, 5.0, false).0.is_some(), "the picture is requested again");
}

fn small(mut shot: quadratura_view::Shot) -> quadratura_view::Shot {
    (shot.camera.width, shot.camera.height) = (2, 1);
    shot
}

#[test]
fn the_picture_stays_when_faces_are_forgotten_and_goes_with_its_site() {
    let mut space = view();
    let request = requested(&mut space, AT_REST, 5.0);
    space.show(painted(PictureRequest { shot: small(request.shot.clone()), ..request }));
    space.hovered = Some(FaceId(3));
    assert_eq!(space.picture().unwrap().faces, [1, 1]);
    space.forget_faces();
    assert!(space.picture().unwrap().faces.is_empty() && space.hovered.is_none());
    space.through = Some(PhotoId(1));
    space.forget_site();
    assert_eq!((space.has_picture(), space.through()), (false, None));
}

#[test]
fn a_view_that_has_moved_is_seen_from_where_its_picture_was_drawn() {
    let mut space = view();
    assert!(space.seen_from() == space.viewpoint, "there is no picture");
    let request = requested(&mut space, AT_REST, 5.0);
    let before = space.viewpoint;
    space.show(painted(PictureRequest { shot: small(request.shot.clone()), ..request }));
    assert!(space.seen_from() == before, "not rounded to its pixels");
    let mut there = before;
    there.orbit(0.3, 0.0, glam::DVec3::Z);
    space.show_from(there, 6.0);
    assert_eq!((space.seen_from().pose, space.seen_from().lens), (before.pose, before.lens));
    let request = requested(&mut space, AT_REST, 7.0);
    space.show(painted(PictureRequest { shot: small(request.shot.clone()), ..request }));
    assert!(space.seen_from() == there);
}

#[test]
fn a_stroke_is_previewed_until_the_first_picture_that_contains_it() {
    use super::brush::{DrawnStroke, UnseenStroke, tests::a_stroke};
    let mut space = view();
    let shown = requested(&mut space, AT_REST, 5.0);
    let drawn = Arc::new(DrawnStroke { viewpoint: space.viewpoint, stroke: a_stroke() });
    let revision = space.next_revision();
    space.brush.unseen.push(UnseenStroke { drawn, number: 1, revision });
    space.redraw();
    // A picture that was requested before comes first.
    space.show(painted(PictureRequest { shot: small(shown.shot.clone()), ..shown }));
    assert_eq!(space.brush.previews().count(), 1);
    let next = requested(&mut space, AT_REST, 6.0);
    space.show(painted(PictureRequest { shot: small(next.shot.clone()), ..next }));
    assert_eq!(space.brush.previews().count(), 0);
}

#[test]
fn a_picture_of_weights_knows_which_colours_it_contains() {
    let mut space = view();
    let mut request = requested(&mut space, AT_REST, 5.0);
    request.shot = small(request.shot.clone());
    space.show(painted(request.clone()));
    assert!(!space.picture().unwrap().contains([255; 3]), "colours of photos stand for nothing");
    request.shot.display = DisplayMode::Weights;
    space.show(painted(request));
    let contains = |colour| space.picture().unwrap().contains(colour);
    assert!(contains([255; 3]) && contains([254, 255, 254]) && !contains([253, 255, 255]));
}

#[test]
fn layered_depth_images_stand_in_only_while_the_view_moves_and_what_they_stand_for_is_not_behind() {
    let mut space = view();
    space.images.stands_in = true;
    space.moved(1.0);
    let moving = requested(&mut space, MOVING, 1.0);
    assert!(matches!(moving.from, DrawnFrom::StandIn(options) if options.larger > 1.0), "{:?}", moving.from);
    let rests = requested(&mut space, AT_REST, 2.0);
    assert_eq!(rests.from, DrawnFrom::Model);
    assert!(moving.shows_the_same(&rests));
    // Drawn from them at rest, too, a picture of the model is not what is asked for.
    space.images.on = true;
    let images = requested(&mut space, AT_REST, 3.0);
    assert!(matches!(images.from, DrawnFrom::Images(options) if options.larger == 1.0));
    assert!(!images.shows_the_same(&rests));
    space.images.peeled = 2;
    assert!(!requested(&mut space, AT_REST, 4.0).shows_the_same(&images));
}

#[test]
fn what_layered_depth_images_cannot_show_is_drawn_from_the_model_and_said() {
    let mut space = view();
    space.images.on = true;
    assert_eq!(space.why_no_images(), None);
    space.look.display = DisplayMode::Weights;
    assert_eq!(requested(&mut space, AT_REST, 1.0).from, DrawnFrom::Model);
    assert!(space.why_no_images().is_some_and(|why| why.contains("display mode")));
    space.look.display = DisplayMode::Colour;
    space.brush.on = true;
    assert_eq!(requested(&mut space, AT_REST, 2.0).from, DrawnFrom::Model);
    space.brush.on = false;
    assert!(matches!(requested(&mut space, AT_REST, 3.0).from, DrawnFrom::Images(_)));
}
