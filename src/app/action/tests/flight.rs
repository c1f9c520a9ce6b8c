//! Tests of bookmarks, of the flight, and of the dialog for pictures and videos.

use super::bench::TestBench;
use crate::state::flight::export::{Export, Rendering};
use crate::state::request::{DecideRequest, FlightRequest, SpaceRequest};
use crate::state::running::JobKind;
use crate::state::space::memory::SpaceMemory;
use quadratura_document::bookmark::BookmarkIndex;
use quadratura_document::camera_path::KeyframeIndex;
use quadratura_view::navigation::Viewpoint;
use quadratura_views::render::PictureFormat;

/// The time after which every flight of the view has ended, in seconds.
const LANDED_S: f64 = 2.0;

/// Makes a bench with a flight of two keyframes, 2 s apart: from the first photo back to where all is seen. Returns the
/// viewpoints of both.
fn with_flight() -> (TestBench, [Viewpoint; 2]) {
    let mut bench = TestBench::new();
    let first = bench.state.space.viewpoint;
    bench.request(FlightRequest::AddKeyframe);
    bench.request(SpaceRequest::ShowAll);
    bench.pass(LANDED_S);
    let last = bench.state.space.viewpoint;
    bench.request(FlightRequest::AddKeyframe);
    assert!(first.position().distance(last.position()) > 1e-3);
    (bench, [first, last])
}

fn is_at(bench: &TestBench, there: &Viewpoint) -> bool {
    bench.state.space.viewpoint.position().distance(there.position()) < 1e-6
}

fn keyframe_times(bench: &TestBench) -> Vec<f64> {
    bench
        .project()
        .flight
        .map(|path| path.keyframes.iter().map(|frame| frame.t).collect())
        .unwrap_or_default()
}

#[test]
fn a_keyframe_at_the_end_follows_the_last_one_and_one_at_a_time_replaces_what_is_there() {
    let (mut bench, _) = with_flight();
    assert_eq!(keyframe_times(&bench), [0.0, 2.0]);
    bench.request(FlightRequest::AddKeyframe);
    assert_eq!(keyframe_times(&bench), [0.0, 2.0, 4.0]);
    bench.request(FlightRequest::GoTo(2.0));
    bench.request(FlightRequest::AddKeyframe);
    assert_eq!(keyframe_times(&bench), [0.0, 2.0, 4.0]);
    assert_eq!(bench.state.flights.keyframe, Some(KeyframeIndex(1)));
}

#[test]
fn the_flight_shows_each_keyframe_at_its_time() {
    let (mut bench, [first, last]) = with_flight();
    bench.request(FlightRequest::GoTo(0.0));
    assert!(is_at(&bench, &first));
    bench.request(FlightRequest::GoTo(1.0));
    assert!(!is_at(&bench, &first) && !is_at(&bench, &last));
    bench.request(FlightRequest::GoTo(2.0));
    assert!(is_at(&bench, &last));
    assert_eq!(bench.state.flights.time_s, 2.0);
}

#[test]
fn a_paused_flight_stays_where_it_is() {
    let (mut bench, _) = with_flight();
    bench.request(FlightRequest::GoTo(0.0));
    bench.request(FlightRequest::Play);
    bench.pass(0.5);
    bench.request(FlightRequest::Pause);
    bench.pass(0.5);
    assert!(!bench.state.plays());
    assert!((bench.state.flights.time_s - 0.5).abs() < 1e-9, "{}", bench.state.flights.time_s);
}

#[test]
fn a_flight_at_its_end_is_played_from_the_start_and_one_in_between_goes_on() {
    let (mut bench, _) = with_flight();
    bench.request(FlightRequest::GoTo(2.0));
    bench.request(FlightRequest::Play);
    bench.pass(0.25);
    assert!((bench.state.flights.time_s - 0.25).abs() < 1e-9);
    bench.request(FlightRequest::Play);
    bench.request(FlightRequest::GoTo(1.5));
    bench.request(FlightRequest::Play);
    bench.pass(0.25);
    assert!((bench.state.flights.time_s - 1.75).abs() < 1e-9);
}

#[test]
fn the_selected_keyframe_is_the_one_that_is_removed() {
    let (mut bench, _) = with_flight();
    bench.request(FlightRequest::SelectKeyframe(KeyframeIndex(0)));
    bench.request(FlightRequest::RemoveKeyframe);
    assert_eq!(keyframe_times(&bench), [2.0]);
    bench.request(FlightRequest::RemoveKeyframe);
    assert_eq!(keyframe_times(&bench), [2.0], "none is selected any more");
    bench.request(DecideRequest::Undo);
    assert_eq!(keyframe_times(&bench), [0.0, 2.0]);
}

#[test]
fn a_kept_view_is_flown_to_and_one_that_is_not_there_is_not() {
    let mut bench = TestBench::new();
    let kept = bench.state.space.viewpoint;
    bench.request(FlightRequest::KeepView);
    bench.request(SpaceRequest::ShowAll);
    bench.pass(LANDED_S);
    bench.request(FlightRequest::FlyToView(BookmarkIndex(7)));
    bench.pass(LANDED_S);
    assert!(!is_at(&bench, &kept));
    bench.request(FlightRequest::FlyToView(BookmarkIndex(0)));
    bench.pass(LANDED_S);
    assert!(is_at(&bench, &kept));
}

#[test]
fn a_project_that_is_left_takes_its_flight_along_and_the_panel_stays() {
    let (mut bench, _) = with_flight();
    bench.request(FlightRequest::ChooseFilm);
    assert!(bench.state.flights.is_asking());
    bench.state.flights.forget();
    let flights = &bench.state.flights;
    assert!(flights.shown && !flights.is_asking() && flights.keyframe.is_none() && flights.time_s == 0.0);
}

#[test]
fn a_picture_is_offered_at_twice_the_size_of_the_view_with_even_sides() {
    let mut bench = TestBench::new();
    for (view, offered) in [([801, 601], [1602, 1202]), ([9000, 333], [7680, 666])] {
        let it = SpaceMemory::new(&bench.state);
        SpaceMemory { size_px: view, ..it }.put_back(&mut bench.state);
        bench.request(FlightRequest::ChooseStill);
        assert_eq!(bench.state.flights.export.take().unwrap().size, offered);
    }
}

#[test]
fn a_film_is_offered_only_where_there_is_a_flight() {
    let mut bench = TestBench::new();
    bench.request(FlightRequest::ChooseFilm);
    assert!(!bench.state.has_dialog());
    let (mut bench, _) = with_flight();
    bench.request(FlightRequest::ChooseFilm);
    assert!(bench.state.has_dialog());
    let export = bench.state.flights.export.take().unwrap();
    let offered = if export.has_ffmpeg { Rendering::Video } else { Rendering::Sequence };
    assert_eq!((export.what, export.problem()), (offered, None), "{}", export.file().display());
    assert!(export.file().starts_with(bench.folder()), "{}", export.file().display());
}

#[test]
fn a_film_has_a_frame_for_each_moment_and_a_picture_is_the_view() {
    let (mut bench, [first, last]) = with_flight();
    let (project, folder) = (bench.folder().to_path_buf(), "out".into());
    let mut film = Export {
        what: Rendering::Sequence,
        project,
        folder,
        name: "flight".into(),
        format: PictureFormat::Exr,
        size: [320, 180],
        has_ffmpeg: false,
    };
    let fps = bench.project().flight.unwrap().fps;
    let views = bench.state.views_of(&film).unwrap();
    assert_eq!(views.len() as f64, 2.0 * fps + 1.0);
    assert_eq!(
        (views[0].name.as_str(), views[0].camera.width, views[0].camera.height),
        ("flight-00001", 320, 180)
    );
    assert!(views[0].pose.center_in_world().distance(first.position()) < 1e-6);
    assert!(views[views.len() - 1].pose.center_in_world().distance(last.position()) < 1e-6);
    film.what = Rendering::Picture;
    let views = bench.state.views_of(&film).unwrap();
    assert_eq!((views.len(), views[0].pose), (1, bench.state.space.viewpoint.pose));
}

#[test]
fn nothing_is_rendered_where_no_painter_runs() {
    let mut bench = TestBench::new();
    bench.request(FlightRequest::ChooseStill);
    let export = bench.state.flights.export.take().unwrap();
    bench.request(FlightRequest::Render(export));
    assert!(!bench.state.running.runs(JobKind::Render));
}
