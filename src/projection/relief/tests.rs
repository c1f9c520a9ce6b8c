//! Tests of relief on a wall whose window is set back, which the model does not show.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::*;
use crate::Projector;
use crate::model_surface::ModelSurface;
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::PhotoId;
use quadratura_base::scene::synthetic::{Modeller, Rng, camera_is_world, centred};
use quadratura_base::scene::{FaceId, Model, PhotoPixels, Samples};
use quadratura_base::task::Task;

/// The distance by which the window is set back. The wall is at depth 10, the window where both coordinates
/// are below 1 in absolute value.
const SET_BACK: f64 = 0.4;

/// The positions of the cameras, which look along z.
const EYES: [[f64; 2]; 5] = [[-2.5, -1.2], [2.5, -1.0], [0.0, 0.2], [-1.2, 1.5], [2.2, 1.4]];

/// Builds the model: a wall without a window.
fn wall() -> Arc<Model> {
    Modeller::new().object("wall").screen(10.0, [-4.0, -3.0, 4.0, 3.0]).finish()
}

/// A reproducible texture of spots of several sizes, 0 to 1: smoothed noise.
struct Spots(Vec<f64>);

impl Spots {
    const SIDE: usize = 64;

    fn new() -> Self {
        let mut rng = Rng::new(3);
        Self((0..Self::SIDE * Self::SIDE).map(|_| rng.unit()).collect())
    }

    fn at(&self, point: DVec2) -> f64 {
        // Spots of 0.4, 0.2 and 0.1 units, which are 24, 12 and 6 pixels.
        [2.5, 5.0, 10.0].map(|scale| self.smooth(point * scale)).iter().sum::<f64>() / 3.0
    }

    fn smooth(&self, at: DVec2) -> f64 {
        let (cell, within) = (at.floor().as_ivec2(), at - at.floor());
        let [x, y] = within.to_array().map(|t| t * t * (3.0 - 2.0 * t));
        let side = Self::SIDE as i32;
        let value = |i: i32, j: i32| {
            let (column, row) = ((cell.x + i).rem_euclid(side), (cell.y + j).rem_euclid(side));
            self.0[(row * side + column) as usize]
        };
        let across = |j: i32| value(0, j) * (1.0 - x) + value(1, j) * x;
        across(0) * (1.0 - y) + across(1) * y
    }
}

/// The true surface behind the model.
#[derive(Clone, Copy, PartialEq)]
enum Truth {
    /// The window is set back.
    Window,
    /// The wall is flat and of a single colour.
    Blank,
}

const CAMERA: Pinhole = Pinhole { width: 800, height: 600, fx: 600.0, fy: 600.0, cx: 400.0, cy: 300.0 };

fn brightness(truth: Truth, spots: &Spots, eye: DVec3, ray: DVec3) -> f64 {
    let at = |depth: f64| (eye + ray * (depth - eye.z)).truncate();
    let (front, back) = (at(10.0), at(10.0 + SET_BACK));
    match truth {
        Truth::Blank => 0.5,
        Truth::Window if front.abs().max_element() > 1.0 => spots.at(front),
        Truth::Window if back.abs().max_element() > 1.0 => 0.5,
        Truth::Window => spots.at(back + 17.0),
    }
}

fn projector(eye: [f64; 2]) -> Projector {
    let pose = Pose { translation: DVec3::new(-eye[0], -eye[1], 0.0), ..camera_is_world() };
    Projector { name: String::new(), camera: CAMERA, pose }
}

fn photographed(truth: Truth, projector: &Projector) -> PhotoPixels {
    let (spots, eye) = (Spots::new(), projector.pose.center_in_world());
    let pixel = |x: u32, y: u32| {
        let ray = CAMERA.ray_in_camera(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        [(brightness(truth, &spots, eye, ray) * 255.0).round() as u8; 3]
    };
    let samples = (0..CAMERA.height).flat_map(|y| (0..CAMERA.width).flat_map(move |x| pixel(x, y)));
    let samples = Samples::U8(samples.collect());
    PhotoPixels { width: CAMERA.width, height: CAMERA.height, channels: 3, samples, icc: None }
}

fn sweep_views(model: &Model, truth: Truth, change: impl Fn(usize, &mut PhotoPixels)) -> Vec<Arc<SweepView>> {
    let surface = ModelSurface::from_model(model);
    let sweep_view = |(i, eye): (usize, &[f64; 2])| {
        let projector = projector(*eye);
        let mut pixels = photographed(truth, &projector);
        change(i, &mut pixels);
        Arc::new(SweepView::new(&projector, &pixels, &surface))
    };
    EYES.iter().enumerate().map(sweep_view).collect()
}

/// Returns options for photos of 800 pixels, which cannot resolve small heights.
fn options() -> ReliefOptions {
    ReliefOptions { reach: 0.06, ..ReliefOptions::default() }
}

fn estimate(model: &Model, sweep_views: &[Arc<SweepView>]) -> Relief {
    estimate_with(model, sweep_views, &options(), &Task::silent()).unwrap()
}

fn estimate_with(
    model: &Model,
    sweep_views: &[Arc<SweepView>],
    options: &ReliefOptions,
    task: &Task,
) -> quadratura_base::Result<Relief> {
    estimate_relief(model, &sweep_views.to_vec(), &shown(model, sweep_views), options, task)
}

/// Lists the faces that each photo shows.
fn shown(model: &Model, sweep_views: &[Arc<SweepView>]) -> Vec<Vec<(FaceId, u32)>> {
    sweep_views.iter().map(|view| seen_faces(model, view)).collect()
}

/// Returns the heights towards the cameras on a grid around the centre, with the positions on the wall.
fn heights(relief: &Relief) -> Vec<(DVec2, f64)> {
    let relief = relief.of(FaceId(0)).expect("five photos show it");
    // The face's normal points to the cameras if its outline is counter-clockwise as seen from there.
    let side = if relief.frame.u.cross(relief.frame.v).z < 0.0 { 1.0 } else { -1.0 };
    let points = (0..400).map(|k| DVec2::new(f64::from(k % 20) - 9.5, f64::from(k / 20) - 9.5) * 0.2);
    points.map(|p| (p, side * relief.height(DVec3::new(p.x, p.y, 10.0)))).collect()
}

/// Selects the heights inside the window and those outside of it, away from its edge and from the photos'
/// borders.
fn window_and_wall(heights: &[(DVec2, f64)]) -> [Vec<f64>; 2] {
    let of = |from: f64, to: f64| {
        let within = heights.iter().filter(|(p, _)| (from..to).contains(&p.abs().max_element()));
        within.map(|(_, height)| *height).collect()
    };
    [of(0.0, 0.7), of(1.4, 2.0)]
}

fn assert_window_is_found(relief: &Relief) {
    for (heights, truth) in window_and_wall(&heights(relief)).into_iter().zip([-SET_BACK, 0.0]) {
        assert!(!heights.is_empty());
        let worst = heights.iter().copied().fold(truth, |worst: f64, height| {
            if (height - truth).abs() > (worst - truth).abs() { height } else { worst }
        });
        // A quarter of a texel between the outermost photos: 4 px / 4 / (5.0 * 600 px / 10^2).
        assert!((worst - truth).abs() < 0.033, "{worst} for {truth}, {heights:.2?}");
    }
}

#[test]
fn a_window_that_is_set_back_is_found_behind_its_wall() {
    let model = wall();
    assert_window_is_found(&estimate(&model, &sweep_views(&model, Truth::Window, |_, _| ())));
}

#[test]
fn exposure_and_somebody_in_the_way_of_one_photo_change_nothing() {
    let model = wall();
    let change = |photo: usize, pixels: &mut PhotoPixels| {
        let Samples::U8(samples) = &mut pixels.samples else { return };
        match photo {
            1 => samples.iter_mut().for_each(|sample| *sample /= 2),
            // An obstacle of 30 x 300 pixels in front of the wall.
            3 => (0..300).for_each(|row| {
                let start = ((100 + row) * 800 + 560) * 3;
                let stripes = (0..90).map(|k| if (k / 21 + row / 9) % 2 == 0 { 200 } else { 40 });
                samples[start..start + 90].iter_mut().zip(stripes).for_each(|(s, stripe)| *s = stripe);
            }),
            _ => (),
        }
    };
    assert_window_is_found(&estimate(&model, &sweep_views(&model, Truth::Window, change)));
}

#[test]
fn where_there_is_nothing_to_see_it_is_flat() {
    let model = wall();
    let relief = estimate(&model, &sweep_views(&model, Truth::Blank, |_, _| ()));
    assert_eq!(relief.of(FaceId(0)).map(FaceRelief::largest), Some(0.0));
}

#[test]
fn photos_that_see_a_face_obliquely_have_no_say() {
    let model = wall();
    let sweep_views = sweep_views(&model, Truth::Window, |_, _| ());
    // No point of the wall is seen this frontally by two cameras.
    let options = ReliefOptions { least_cosine: 0.9999, ..options() };
    let relief = estimate_with(&model, &sweep_views, &options, &Task::silent()).unwrap();
    let within = heights(&relief).into_iter().filter(|(p, _)| p.abs().max_element() < 0.7);
    assert!(within.map(|(_, height)| height.abs()).fold(0.0, f64::max) < 1e-6);
}

#[test]
fn a_photo_left_out_has_no_say() {
    let model = wall();
    let mut all = sweep_views(&model, Truth::Window, |_, _| ());
    let relief = estimate(&model, &all);
    let without = relief_without(
        &relief,
        &[PhotoId(2)],
        &model,
        &all,
        &shown(&model, &all),
        &options(),
        &Task::silent(),
    )
    .unwrap();
    all.remove(2);
    assert_eq!(without, estimate(&model, &all));
    assert_ne!(without, relief);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let model = wall();
    let sweep_views = sweep_views(&model, Truth::Window, |_, _| ());
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| estimate(&model, &sweep_views))
    };
    assert_eq!(with(1), with(5));
}

#[test]
fn billboards_and_faces_that_one_photo_shows_have_none() {
    let mut modeller = Modeller::new();
    modeller.object("wall").screen(10.0, [-4.0, -3.0, 4.0, 3.0]);
    modeller.object("tree").screen(8.0, [-1.0, -2.0, 1.0, 2.0]);
    // Outside of the first photo, and behind the wall in the second one.
    modeller.object("beyond").screen(11.0, [5.2, -3.0, 6.2, 3.0]);
    let mut model = (*modeller.finish()).clone();
    model.objects[1].billboard = true;
    let sweep_views = sweep_views(&model, Truth::Window, |_, _| ());
    let relief = estimate(&model, &sweep_views[..2]);
    assert!(sweep_views[1].faces().iter().any(|(face, _)| *face == FaceId(2)));
    assert_eq!([0, 1, 2].map(|face| relief.of(FaceId(face)).is_some()), [true, false, false]);
}

#[test]
fn a_point_on_relief_stays_on_its_ray() {
    let model = wall();
    let relief = estimate(&model, &sweep_views(&model, Truth::Window, |_, _| ()));
    let face = relief.of(FaceId(0)).unwrap();
    let plane = model.face(FaceId(0)).plane;
    let (eye, point) = (DVec3::new(1.5, -0.4, 1.0), DVec3::new(0.3, 0.2, 10.0));
    let met = face.meet(eye, point, plane.normal);
    assert!((met - eye).cross(point - eye).length() < 1e-9);
    assert!((plane.signed_distance(met) - face.height(met)).abs() < 0.01, "two steps come this near");
}

#[test]
fn a_request_to_stop_is_heard() {
    let model = wall();
    let sweep_views = sweep_views(&model, Truth::Blank, |_, _| ());
    let task = Task::silent();
    task.stop_flag().store(true, Ordering::Relaxed);
    let stopped = estimate_with(&model, &sweep_views, &options(), &task);
    assert!(matches!(stopped, Err(quadratura_base::Error::Cancelled)));
}

#[test]
fn a_photo_of_an_empty_view_is_no_trouble() {
    let model = wall();
    let surface = ModelSurface::from_model(&model);
    let away = Projector { camera: centred(40, 30, 900.0), ..projector([99.0, 0.0]) };
    let samples = Samples::U8(vec![7; 40 * 30 * 3]);
    let pixels = PhotoPixels { width: 40, height: 30, channels: 3, samples, icc: None };
    let sweep_view = Arc::new(SweepView::new(&away, &pixels, &surface));
    assert_eq!(sweep_view.faces(), []);
    assert_eq!(estimate(&model, &[sweep_view.clone(), sweep_view]).of_face, [None]);
}
