//! Tests of the flat views: what is framed, what is loaded, and what is reported.

use glam::{DVec2, Vec2};

use super::bench::TestBench;
use crate::action::flat::slot::{ResultRequest, want};
use crate::state::flat::levels::{Levels, levels_of};
use crate::state::flat::placement::ScreenRect;
use crate::state::panes::Pane;
use crate::state::request::{FlatRequest, SelectRequest, SpaceRequest, WindowRequest};
use crate::state::selection::Selection;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::{FaceId, PhotoId};
use quadratura_layers::LayerIndex;
use quadratura_view::Picture;

const VIEW: ScreenRect = ScreenRect { min: Vec2::ZERO, max: Vec2::new(424.0, 324.0) };

fn picture() -> Levels {
    levels_of(Picture { width: 2, height: 1, rgba: vec![255; 8] })
}

/// Requests the photo of a file that does not exist, which `make` makes.
fn want_photo(bench: &mut TestBench, file: &str, gives_up: bool, make: fn() -> Result<Levels>) {
    let request = ResultRequest {
        key: file.into(),
        name: "Reading the photo",
        gives_up,
        slot: |state| &mut state.flat.loading.photos,
    };
    want(&mut bench.state, &mut bench.work, request, move |_| make());
}

fn has_photo(bench: &TestBench, file: &str) -> bool {
    bench.state.flat.loading.photos.get(&file.into()).is_some()
}

// ---- loading ----

#[test]
fn a_photo_whose_file_is_gone_is_reported_once() {
    let mut bench = TestBench::new();
    for _ in 0..3 {
        bench.request(FlatRequest::WantPhoto(PhotoId(0)));
        bench.settle();
    }
    let notes = bench.state.notes.list();
    assert_eq!((notes.len(), notes[0].times), (1, 1), "{:?}", bench.said());
    assert!(!bench.state.flat.loading.is_busy());
}

#[test]
fn a_large_picture_that_cannot_be_made_is_reported_once() {
    let mut bench = TestBench::new();
    for _ in 0..3 {
        bench.request(FlatRequest::WantLargePicture(PhotoId(1)));
        bench.settle();
    }
    assert_eq!(bench.state.notes.list().iter().map(|note| note.times).sum::<u32>(), 1, "{:?}", bench.said());
}

#[test]
fn a_photo_that_the_site_does_not_have_is_not_looked_for() {
    let mut bench = TestBench::new();
    bench.request(FlatRequest::WantPhoto(PhotoId(99)));
    assert!(bench.state.running.is_idle());
}

#[test]
fn an_image_layer_is_loaded_only_where_one_was_selected_and_is_built() {
    let mut bench = TestBench::new();
    bench.request(FlatRequest::WantImageLayer);
    bench.request(SelectRequest::Only(Selection::Layer { photo: PhotoId(0), layer: LayerIndex(0) }));
    bench.request(FlatRequest::WantImageLayer);
    assert!(bench.state.running.is_idle() && bench.said().is_empty());
}

#[test]
fn a_result_is_made_once_and_kept() {
    let mut bench = TestBench::new();
    want_photo(&mut bench, "a", true, || Ok(picture()));
    bench.settle();
    assert!(has_photo(&bench, "a"));
    want_photo(&mut bench, "a", true, || panic!("it is there"));
    assert!(bench.state.running.is_idle());
}

#[test]
fn a_result_that_is_wanted_more_stops_the_one_that_is_being_made() {
    let mut bench = TestBench::new();
    want_photo(&mut bench, "a", true, || Err(Error::Cancelled));
    want_photo(&mut bench, "b", true, || Ok(picture()));
    bench.settle();
    assert!(has_photo(&bench, "b") && !has_photo(&bench, "a") && bench.said().is_empty());
    want_photo(&mut bench, "a", true, || Ok(picture()));
    bench.settle();
    assert!(has_photo(&bench, "a"), "one that was stopped has not failed");
}

#[test]
fn a_result_that_does_not_give_up_is_finished_before_the_next_one() {
    let mut bench = TestBench::new();
    want_photo(&mut bench, "a", false, || Ok(picture()));
    want_photo(&mut bench, "b", false, || Ok(picture()));
    bench.settle();
    assert!(has_photo(&bench, "a") && !has_photo(&bench, "b"));
    want_photo(&mut bench, "b", false, || Ok(picture()));
    bench.settle();
    assert!(has_photo(&bench, "a") && has_photo(&bench, "b"));
}

// ---- what is framed ----

#[test]
fn the_view_in_use_is_zoomed_and_the_other_one_is_not() {
    let mut bench = TestBench::new();
    bench.state.flat.photo.view.rect = Some(VIEW);
    bench.state.flat.layer.view.rect = Some(VIEW);
    bench.state.panes.show(Pane::Layer);
    bench.request(FlatRequest::Zoom(2.0));
    let scales = |bench: &TestBench| {
        [bench.state.flat.photo.view, bench.state.flat.layer.view].map(|view| view.placement.scale())
    };
    assert_eq!(scales(&bench), [1.0, 2.0]);
    bench.state.panes.show(Pane::Photo);
    bench.state.window.density = 2.0;
    bench.request(FlatRequest::ShowPixels);
    assert_eq!(scales(&bench), [0.5, 2.0]);
    bench.request(FlatRequest::Fit);
    assert!(bench.state.flat.photo.view.placement.is_fitted());
    assert!(!bench.state.flat.layer.view.placement.is_fitted());
}

#[test]
fn a_photo_that_is_not_built_has_no_layers_to_take_off() {
    let mut bench = TestBench::new();
    bench.request(FlatRequest::Peel(1));
    assert_eq!(bench.state.flat.photo.hidden_layers, 0);
    assert!(bench.state.panes.is_shown(Pane::Photo));
}

#[test]
fn the_list_of_untextured_faces_brings_the_photo_to_the_front_when_it_opens() {
    let mut bench = TestBench::new();
    bench.request(FlatRequest::ListUntextured);
    assert!(bench.state.flat.photo.reasons_shown && bench.state.panes.is_shown(Pane::Photo));
    bench.request(WindowRequest::ShowPane(Pane::Space));
    bench.request(FlatRequest::ListUntextured);
    assert!(!bench.state.flat.photo.reasons_shown && bench.state.panes.is_shown(Pane::Space));
}

#[test]
fn a_rectangle_is_framed_with_its_surroundings() {
    let mut bench = TestBench::new();
    bench.request(SelectRequest::ShowRect(PhotoId(0), PixelRect { x: 100, y: 40, w: 20, h: 10 }));
    let pane = &mut bench.state.flat.photo;
    pane.show_sought(VIEW);
    assert_eq!(pane.view.placement.middle(), DVec2::new(110.0, 45.0));
    assert_eq!(pane.view.placement.scale(), 300.0 / 50.0, "a margin of its longer side around it");
}

#[test]
fn a_face_that_the_photo_does_not_show_is_not_framed_in_it() {
    let mut bench = TestBench::new();
    bench.request(SelectRequest::Only(Selection::Face(FaceId(0))));
    assert!(!bench.state.frame_in_photo());
    bench.request(SelectRequest::Only(Selection::Photo(PhotoId(1))));
    bench.state.flat.photo.view.placement.pan(Vec2::X);
    assert!(bench.state.frame_in_photo() && bench.state.flat.photo.view.placement.is_fitted());
}

#[test]
fn everything_is_shown_in_the_view_in_use() {
    let mut bench = TestBench::new();
    bench.state.flat.layer.view.placement.pan(Vec2::X);
    bench.state.panes.show(Pane::Layer);
    bench.request(SpaceRequest::ShowAll);
    assert!(bench.state.flat.layer.view.placement.is_fitted());
}

#[test]
fn a_pixel_outside_of_the_photo_shows_nothing_and_one_inside_has_no_colour_before_it_is_loaded() {
    let bench = TestBench::new();
    assert!(bench.state.flat.pointed_in_photo(bench.session(), PhotoId(0), (-1, 5), 0).is_none());
    let width = bench.session().opened.site.photos[0].camera.width as i32;
    assert!(bench.state.flat.pointed_in_photo(bench.session(), PhotoId(0), (width, 5), 0).is_none());
    let pointed = bench.state.flat.pointed_in_photo(bench.session(), PhotoId(0), (width - 1, 5), 0).unwrap();
    assert!(pointed.colour.is_none() && pointed.hits.is_empty() && pointed.version.is_none());
}

#[test]
fn a_pixel_of_a_loaded_photo_has_the_colour_of_its_file() {
    let mut bench = TestBench::new();
    let file = bench.session().opened.site.photos[0].file.clone();
    want_photo(&mut bench, file.to_str().unwrap(), true, || {
        Ok(levels_of(Picture { width: 2, height: 1, rgba: vec![1, 2, 3, 255, 4, 5, 6, 0] }))
    });
    bench.settle();
    let colour =
        |x| bench.state.flat.pointed_in_photo(bench.session(), PhotoId(0), (x, 0), 0).unwrap().colour;
    assert_eq!([colour(0), colour(1)], [Some([1, 2, 3]), None]);
    let (session, views) = (bench.session(), &bench.state.flat);
    let (_, hidden) = views
        .loading
        .shown(session, PhotoId(0), &bench.state.flat.peeling(bench.session(), PhotoId(0), 2))
        .unwrap();
    assert!(hidden.is_none(), "without layers the photo itself is shown");
}
