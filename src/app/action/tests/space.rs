//! Tests of the 3D view: flights, what it remembers, picking, and layers pulled apart.

use glam::DVec2;

use super::bench::TestBench;
use crate::command::images;
use crate::state::panes::Pane;
use crate::state::request::{Flag, ImagesRequest, SelectRequest, SpaceRequest, WindowRequest};
use crate::state::round_trip::dialogs::DialogPurpose;
use crate::state::save_image::ImageFormat;
use crate::state::selection::Selection;
use crate::state::space::FrameFacts;
use crate::state::space::images::DrawnFrom;
use crate::state::space::memory::SpaceMemory;
use crate::state::space::picking::{ViewPixel, ball_of, faces_of};
use crate::state::space::picture::{PaintedPicture, PictureRequest};
use crate::state::space::scene::ShownScene;
use quadratura_base::scene::{FaceId, ObjectId, PhotoId};
use quadratura_images::live::LiveStatus;
use quadratura_layers::LayerIndex;
use quadratura_view::Picture;
use quadratura_view::navigation::Viewpoint;

/// The time after which every flight of the view has ended, in seconds.
const LANDED_S: f64 = 2.0;

fn scene(bench: &TestBench) -> ShownScene<'_> {
    bench.state.scene().expect("a project is open")
}

/// Makes a bench whose view has moved back until all is seen: it looks through no photo.
fn far_away() -> TestBench {
    let mut bench = TestBench::new();
    bench.request(SpaceRequest::ShowAll);
    bench.pass(LANDED_S);
    assert_eq!(bench.state.space.through(), None);
    bench
}

fn eye(bench: &TestBench) -> glam::DVec3 {
    bench.state.space.viewpoint.position()
}

// ---- flights ----

#[test]
fn a_flight_into_a_photo_takes_its_time_and_ends_in_its_camera() {
    let mut bench = far_away();
    let from = eye(&bench);
    bench.request(SpaceRequest::FlyToPhoto(PhotoId(2)));
    bench.pass(0.3);
    let there = bench.session().viewpoint_of(PhotoId(2));
    assert!(eye(&bench).distance(from) > 1e-6 && eye(&bench).distance(there.position()) > 1e-6);
    assert_eq!(bench.state.space.through(), None);
    bench.pass(0.4);
    assert_eq!((bench.state.space.viewpoint, bench.state.space.through()), (there, Some(PhotoId(2))));
}

#[test]
fn the_frame_in_which_a_flight_ends_is_its_last() {
    let mut bench = far_away();
    bench.request(SpaceRequest::FlyToPhoto(PhotoId(1)));
    for _ in 0..2 {
        assert!(bench.state.space.flies(bench.state.window.now_s));
        bench.pass(0.4);
    }
    assert_eq!(bench.state.space.through(), Some(PhotoId(1)));
    assert!(bench.state.space.flies(bench.state.window.now_s));
    bench.pass(0.1);
    assert!(!bench.state.space.flies(bench.state.window.now_s));
}

#[test]
fn the_same_command_flies_into_the_photo_and_back() {
    let mut bench = far_away();
    let before = eye(&bench);
    bench.request(SpaceRequest::Snap);
    bench.pass(LANDED_S);
    assert_eq!(bench.state.space.through(), Some(PhotoId(0)));
    bench.request(SpaceRequest::Snap);
    bench.pass(LANDED_S);
    assert_eq!(bench.state.space.through(), None);
    assert!(eye(&bench).distance(before) < 1e-9);
}

#[test]
fn flying_into_a_photo_a_second_time_stays_there() {
    let mut bench = far_away();
    for _ in 0..2 {
        bench.request(SpaceRequest::FlyInto);
        bench.pass(LANDED_S);
        assert_eq!(bench.state.space.through(), Some(PhotoId(0)));
    }
}

#[test]
fn the_next_photo_is_flown_to_only_while_the_view_looks_through_one() {
    let mut bench = far_away();
    let before = eye(&bench);
    bench.request(SelectRequest::StepPhoto(1));
    bench.pass(LANDED_S);
    assert_eq!((bench.state.selected_photo(), eye(&bench)), (Some(PhotoId(1)), before));
    bench.request(SpaceRequest::FlyInto);
    bench.pass(LANDED_S);
    bench.request(SelectRequest::StepPhoto(1));
    bench.pass(LANDED_S);
    assert_eq!(bench.state.space.through(), Some(PhotoId(2)));
}

#[test]
fn a_view_that_is_hidden_waits_with_its_flight() {
    let mut bench = far_away();
    bench.request(SpaceRequest::FlyToPhoto(PhotoId(1)));
    bench.request(WindowRequest::ShowPane(Pane::Photo));
    bench.pass(LANDED_S);
    assert_eq!(bench.state.space.through(), None);
    bench.request(WindowRequest::ShowPane(Pane::Space));
    bench.pass(0.1);
    assert_eq!(bench.state.space.through(), Some(PhotoId(1)));
}

#[test]
fn framing_nothing_shows_everything_and_framing_a_face_holds_its_ball() {
    let mut bench = far_away();
    let all = eye(&bench);
    bench.request(SelectRequest::Only(Selection::Nothing));
    bench.request(SpaceRequest::Frame);
    bench.pass(LANDED_S);
    assert!(eye(&bench).distance(all) < 1e-9);
    let face = Selection::Face(FaceId(0));
    bench.request(SelectRequest::Only(face));
    bench.request(SpaceRequest::Frame);
    bench.pass(LANDED_S);
    let (center, radius) = ball_of(face, bench.session()).unwrap();
    assert!(bench.state.space.viewpoint.pivot.distance(center) < 1e-9);
    assert!(eye(&bench).distance(center) > radius && eye(&bench).distance(all) > 1e-3);
}

#[test]
fn a_tilted_view_is_levelled_without_leaving_its_place() {
    let mut bench = far_away();
    let up = bench.session().scene_frame.up;
    let roll = glam::DMat3::from_rotation_z(0.4);
    let pose = &mut bench.state.space.viewpoint.pose;
    (pose.rotation, pose.translation) = (roll * pose.rotation, roll * pose.translation);
    let before = eye(&bench);
    let tilt = |bench: &TestBench| bench.state.space.viewpoint.pose.rotation.row(0).dot(up).abs();
    assert!(tilt(&bench) > 0.1);
    bench.request(SpaceRequest::Level);
    bench.pass(LANDED_S);
    assert!(tilt(&bench) < 1e-9 && eye(&bench).distance(before) < 1e-6);
}

// ---- what the view remembers ----

#[test]
fn a_movement_by_hand_leaves_the_photo_and_ends_a_flight() {
    let mut bench = far_away();
    bench.request(SpaceRequest::FlyToPhoto(PhotoId(1)));
    bench.pass(0.1);
    let mut it = SpaceMemory::new(&bench.state);
    it.viewpoint.pan(DVec2::new(10.0, 0.0), 600.0);
    let moved = it.viewpoint;
    it.put_back(&mut bench.state);
    bench.pass(LANDED_S);
    assert_eq!((bench.state.space.viewpoint, bench.state.space.through()), (moved, None));
}

#[test]
fn a_view_that_is_only_drawn_stays_in_its_photo_and_keeps_what_was_chosen() {
    let mut bench = TestBench::new();
    let before = bench.state.space.viewpoint;
    let mut it = SpaceMemory::new(&bench.state);
    (it.size_px, it.photo_over, it.wipe, it.apart, it.hints) = ([640, 480], true, 0.25, 3.5, false);
    it.hovered = Some(FaceId(1));
    it.put_back(&mut bench.state);
    let space = &bench.state.space;
    assert_eq!((space.viewpoint, space.through(), space.size_px()), (before, Some(PhotoId(0)), [640, 480]));
    assert_eq!((space.photo_over, space.wipe, space.exploded.apart), (true, 0.25, 3.5));
    assert_eq!(
        (SpaceMemory::new(&bench.state).hovered, bench.state.settings.hints),
        (Some(FaceId(1)), false)
    );
}

// ---- pictures ----

#[test]
fn a_view_without_painter_requests_nothing_and_wakes_nobody() {
    let mut bench = TestBench::new();
    bench.state.window.next_frame_s = None;
    bench.request(SpaceRequest::Draw(FrameFacts { background: [0; 3], moves: true }));
    assert_eq!(bench.state.window.next_frame_s, None);
    let (request, _) = bench.state.space.due(FrameFacts { background: [0; 3], moves: true }, 0.0, false);
    assert!(request.is_some(), "it is still to be requested");
}

#[test]
fn the_status_says_of_which_photos_the_layered_depth_image_is_and_which_are_being_combined() {
    let mut bench = TestBench::new();
    assert_eq!(bench.state.images_in_words(), None);
    bench.request(WindowRequest::Flip(Flag::Images));
    assert_eq!(bench.state.images_in_words(), None, "there is no picture yet");
    let mut status =
        LiveStatus { building: vec![PhotoId(1), PhotoId(0), PhotoId(2)], ..LiveStatus::default() };
    let mut words = |status: &LiveStatus| {
        bench.state.space.images.status = Some((status.clone(), std::time::Duration::from_millis(14)));
        bench.state.images_in_words().unwrap()
    };
    assert_eq!(
        words(&status),
        "The model is shown until there is a layered depth image · building b with a, c"
    );
    (status.photos, status.depth_complexity) = (vec![PhotoId(2)], 1.237);
    assert_eq!(words(&status), "c · depth complexity 1.24 · 14 ms · building b with a, c");
    (status.building, status.fault) = (Vec::new(), Some("no stack".into()));
    assert_eq!(words(&status), "c · depth complexity 1.24 · 14 ms · not built: no stack");
    bench.request(SpaceRequest::ShowObject(bench.session().model().objects[0].name.clone(), false));
    assert_eq!(
        bench.state.images_in_words().unwrap(),
        "The model is shown instead of layered depth images: they cannot hide objects"
    );
    bench.request(WindowRequest::Flip(Flag::Images));
    assert_eq!(bench.state.images_in_words(), None);
}

#[test]
fn a_photo_without_layers_is_not_saved_as_a_layered_depth_image() {
    let mut bench = TestBench::new();
    for command in [&images::SAVE, &images::PAGE] {
        let request = command.requested(&bench.state);
        bench.request(request);
        assert!(bench.state.dialogs.save_image.is_none());
        let said = bench.said();
        assert!(said.last().is_some_and(|it| it.contains("build the layers first")), "{said:?}");
    }
}

#[test]
fn the_dialog_proposes_a_file_of_the_photos_name_and_takes_the_path_that_was_chosen() {
    let mut bench = TestBench::new();
    bench.request(ImagesRequest::Choose(ImageFormat::Ldi));
    let dialog = bench.state.dialogs.save_image.as_ref().unwrap();
    assert_eq!(dialog.out(), bench.folder().join("ldi/a.ldi"));
    assert!(bench.state.has_dialog());
    bench.state.take_chosen(DialogPurpose::ImageFile, &["/elsewhere/b.ldi".into()]);
    let dialog = bench.state.dialogs.save_image.take().unwrap();
    assert_eq!(dialog.out(), std::path::Path::new("/elsewhere/b.ldi"));
    // It fails with a reason, because the photo has no layers.
    bench.request(ImagesRequest::Save(dialog));
    bench.settle();
    assert!(bench.said().last().is_some_and(|it| it.contains("has no stack yet")), "{:?}", bench.said());
}

// ---- picking ----

/// Shows a picture of the current viewpoint with one pixel for each of these faces, side by side.
fn show_faces(bench: &mut TestBench, faces: &[u32]) -> Viewpoint {
    let view = bench.state.space.viewpoint;
    let camera = view.camera(faces.len() as u32, 1);
    let shot = bench.state.space.look.shot(camera, view.pose);
    let from = DrawnFrom::Model;
    let request =
        PictureRequest { shot, lens: view.lens, from, yields: false, background: [0; 3], revision: 0 };
    let image = Picture { width: faces.len() as u32, height: 1, rgba: vec![255; 4 * faces.len()] };
    let surface = bench.session().solid.clone();
    let spent = std::time::Duration::from_millis(10);
    bench.state.space.show(PaintedPicture {
        request,
        image,
        faces: faces.to_vec(),
        surface,
        spent,
        images: None,
    });
    view
}

#[test]
fn the_face_under_the_pointer_is_the_one_that_the_picture_shows() {
    let mut bench = TestBench::new();
    let viewpoint = show_faces(&mut bench, &[3, 0, 1]);
    let at = |x: f64| ViewPixel { viewpoint, size_px: [300, 100], at_px: DVec2::new(x, 50.0) };
    let found = [0.0, 99.0, 101.0, 299.0].map(|x| scene(&bench).face_at(&at(x)));
    assert_eq!(found, [Some(FaceId(2)), Some(FaceId(2)), None, Some(FaceId(0))]);
}

#[test]
fn the_face_of_a_view_without_picture_is_the_one_that_the_ray_meets() {
    let mut bench = TestBench::new();
    let viewpoint = bench.session().viewpoint_of(PhotoId(0));
    let pixel = ViewPixel { viewpoint, size_px: [300, 200], at_px: DVec2::new(150.0, 100.0) };
    let face = scene(&bench).face_at(&pixel).expect("the photo shows a face in its middle");
    let point = scene(&bench).point_at(&pixel).unwrap();
    let plane = &bench.session().model().face(face).plane;
    assert!(plane.normal.dot(point - plane.point).abs() < 1e-9);
    // A picture of another viewpoint says nothing about this one.
    let other = FaceId(face.0 + 1);
    show_faces(&mut bench, &[other.0 + 1]);
    let mut moved = pixel;
    moved.viewpoint.pose.translation.x += 1e-6;
    assert_eq!(scene(&bench).face_at(&moved), Some(face));
    assert_eq!(scene(&bench).face_at(&pixel), Some(other));
}

#[test]
fn the_point_under_the_pointer_is_on_the_face_that_the_picture_shows_through_others() {
    let mut bench = TestBench::new();
    let viewpoint = bench.session().viewpoint_of(PhotoId(0));
    let hits = |pixel: &ViewPixel| {
        let (session, culling) = (bench.session(), bench.state.space.look.culling());
        let all = session.model().face_ids().collect();
        session.solid.through(viewpoint.position(), pixel.ray(), &all, culling)
    };
    let size_px = [300, 200];
    let pixels = (0..300).map(|x| ViewPixel { viewpoint, size_px, at_px: DVec2::new(f64::from(x), 120.0) });
    let (pixel, far) = pixels
        .filter_map(|pixel| Some((pixel, hits(&pixel))).filter(|(_, hits)| hits.len() > 1))
        .map(|(pixel, hits)| (pixel, hits[0]))
        .next()
        .expect("some stairs are before others");
    let (_, nearest) = scene(&bench).surface_at(&pixel).unwrap();
    assert_ne!(nearest, far.face, "a ray meets the nearest face");
    bench.state.space.viewpoint = viewpoint;
    show_faces(&mut bench, &[far.face.0 + 1]);
    let (point, face) = scene(&bench).surface_at(&pixel).unwrap();
    assert_eq!(face, far.face);
    assert!(point.distance(viewpoint.position() + pixel.ray() * far.t) < 1e-9);
    show_faces(&mut bench, &[0]);
    assert!(scene(&bench).surface_at(&pixel).is_none(), "the picture shows none");
}

#[test]
fn the_faces_of_a_selection_are_in_its_ball() {
    let bench = TestBench::new();
    let session = bench.session();
    let object = Selection::Object(ObjectId(0));
    let faces = faces_of(object, session);
    assert_eq!(faces, session.model().object(ObjectId(0)).faces);
    let (center, radius) = ball_of(object, session).unwrap();
    let points = faces.iter().flat_map(|face| session.model().ring_points(*face));
    assert!(points.into_iter().all(|point| point.distance(center) <= radius + 1e-9));
    for nothing in [
        Selection::Nothing,
        Selection::Photo(PhotoId(0)),
        Selection::Layer { photo: PhotoId(0), layer: LayerIndex(0) },
    ] {
        assert!(ball_of(nothing, session).is_none());
    }
}

// ---- layers pulled apart ----

#[test]
fn layers_are_pulled_apart_and_put_together_where_the_view_was() {
    let mut bench = TestBench::new();
    let before = bench.state.space.viewpoint;
    bench.request(WindowRequest::ShowPane(Pane::Photo));
    bench.request(SpaceRequest::PullApart);
    assert!(bench.state.space.exploded.is_on() && bench.state.panes.is_shown(Pane::Space));
    bench.pass(LANDED_S);
    assert!(eye(&bench).distance(before.position()) > 1e-3, "it looks from the side");
    bench.request(SpaceRequest::PullApart);
    bench.pass(LANDED_S);
    assert!(!bench.state.space.exploded.is_on());
    assert_eq!((bench.state.space.viewpoint, bench.state.space.through()), (before, Some(PhotoId(0))));
}

#[test]
fn the_layers_of_the_photo_that_is_selected_are_the_ones_pulled_apart() {
    let mut bench = TestBench::new();
    bench.request(SpaceRequest::FollowSelection);
    assert!(!bench.state.space.exploded.is_on(), "nothing is pulled apart");
    bench.request(SpaceRequest::PullApart);
    bench.state.space.exploded.now_apart = 1.0;
    bench.request(SelectRequest::Only(Selection::Photo(PhotoId(2))));
    bench.request(SpaceRequest::FollowSelection);
    assert_eq!(bench.state.space.exploded.photo, Some(PhotoId(2)));
    assert_eq!(bench.state.space.exploded.now_apart, 0.0, "they open from the beginning");
    bench.state.space.exploded.now_apart = 1.0;
    bench.request(SpaceRequest::FollowSelection);
    assert_eq!(bench.state.space.exploded.now_apart, 1.0, "once");
}

#[test]
fn a_photo_without_layers_has_no_pictures_to_pull_apart() {
    let mut bench = TestBench::new();
    bench.request(SpaceRequest::PullApart);
    bench.request(SpaceRequest::WantLayerPictures);
    assert!(bench.state.running.is_idle() && scene(&bench).panes_apart().is_none());
    let pixel = SpaceMemory::new(&bench.state).pixel_at(DVec2::ZERO);
    assert!(scene(&bench).layer_at(&pixel, 1.0).is_none());
}
