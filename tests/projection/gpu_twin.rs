//! The GPU's pictures against the twin's.

use std::fmt::{self, Display, Formatter};
use std::ops::AddAssign;
use std::sync::Arc;

use quadratura::task::Task;
use quadratura::testing::geometry::Pose;
use quadratura::testing::geometry::polygon::PlaneFrame;
use quadratura::testing::gpu::Renderer;
use quadratura::testing::projection::Renders;
use quadratura::testing::projection::exposure::SurroundingsGains;
use quadratura::testing::projection::exposure::surroundings::{GRID, SurroundingsFactors};
use quadratura::testing::projection::framing::scaled;
use quadratura::testing::projection::relief::{FaceRelief, Relief};
use quadratura::testing::projection::twin::ReferenceRenderer;
use quadratura::testing::scene::Model;
use quadratura::testing::scene::synthetic::{Rng, centred, look_at};
use quadratura::testing::view::optics::Optics;
use quadratura::testing::view::{Exposure, Mode, Picture, Quality, Shot};

use crate::bench::{Bench, apart, apart_over_grey};

/// A step beside a photo, closer than the photos' own pixels, so that every lookup is at level 0.
fn close_up(bench: &Bench, photo: usize, target_px: [f64; 2]) -> Shot {
    let photo = &bench.site.photos[photo];
    let eye = photo.pose.center_in_world() + glam::DVec3::new(0.3, -0.2, 0.1);
    let towards = photo.pose.rotation.transpose() * photo.camera.ray_in_camera(target_px.into());
    Shot::new(centred(240, 160, 6.0 * photo.camera.fx), look_at(eye, eye + towards))
}

/// Colours differ beyond this only where an edge falls on a pixel's centre: 8-bit bilinear shares are
/// off by up to 1/512 of a texel's contrast, in linear light, which in the dark is 2 steps of sRGB; and
/// previews take sRGB for a quartic, which is off by 0.7 steps.
const STEPS: u8 = 3;

/// How far pictures are from their twins, in pixels.
#[derive(Debug, Clone, Copy, Default)]
pub struct Difference {
    pub pixels: f64,
    /// Those that show another face.
    pub flipped: f64,
    /// Those that show the same as their four neighbours: the twin has one sample a pixel, so that at
    /// outlines it is another matter.
    pub inside: f64,
    /// Those of them that are textured.
    pub display: f64,
    /// Those of these that show the surroundings.
    pub surroundings: f64,
    /// Those that differ by more than [`STEPS`].
    pub far: f64,
    /// Of what is inside, in steps of 8 bits.
    pub sum: f64,
}

impl Difference {
    /// Steps of 8 bits a pixel.
    pub fn mean(&self) -> f64 {
        self.sum / self.inside.max(1.0)
    }
}

impl AddAssign for Difference {
    fn add_assign(&mut self, other: Self) {
        self.pixels += other.pixels;
        self.flipped += other.flipped;
        self.inside += other.inside;
        self.display += other.display;
        self.surroundings += other.surroundings;
        self.far += other.far;
        self.sum += other.sum;
    }
}

impl Display for Difference {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { pixels, flipped, inside, display, surroundings, far, .. } = self;
        write!(
            f,
            "of {pixels} pixels {flipped} have another face; of {inside} inside faces {display} are shown ({surroundings} \
             surroundings), {far} off by more than {STEPS}, {:.3} on average",
            self.mean()
        )
    }
}

/// Between the two pictures of a shot.
pub fn difference(gpu: &mut Renderer, twin: &mut ReferenceRenderer, shot: &Shot) -> Difference {
    let task = Task::silent();
    let (found, expected) = (gpu.picture(shot, &task).unwrap(), twin.picture(shot, &task).unwrap());
    let (gpu_faces, faces) = (gpu.faces(shot, &task).unwrap(), twin.faces(shot, &task).unwrap());
    let mut difference = Difference { pixels: faces.len() as f64, ..Difference::default() };
    difference.flipped = gpu_faces.iter().zip(&faces).filter(|(a, b)| a != b).count() as f64;
    let width = shot.camera.width as usize;
    let inside = |i: usize| {
        let around = [i.wrapping_sub(1), i + 1, i.wrapping_sub(width), i + width];
        around.iter().all(|other| faces.get(*other) == Some(&faces[i]))
    };
    let pixels = found.rgba.chunks(4).zip(expected.rgba.chunks(4)).enumerate();
    for (i, (a, b)) in pixels.filter(|(i, _)| inside(*i)) {
        difference.inside += 1.0;
        difference.display += f64::from(u8::from(b[3] > 0));
        difference.surroundings += f64::from(u8::from(b[3] > 0 && faces[i] == 0));
        // What is not textured is grey in both; its colour is no part of the picture.
        // What one sees through in part has an alpha from lookups of 8 bits, too.
        let (apart, alpha_steps) = match b[3] {
            0 => (0.0, 0),
            u8::MAX => (f64::from(apart(a, b)), 0),
            _ => (apart_over_grey(a, b), STEPS),
        };
        let is_far = a[3].abs_diff(b[3]) > alpha_steps || apart > f64::from(STEPS);
        difference.far += f64::from(u8::from(is_far));
        difference.sum += apart;
    }
    difference
}

fn compare(bench: &Bench, relief: &Relief, shot: &Shot, what: &str) {
    let found = difference(&mut bench.renderer(relief), &mut bench.twin(relief), shot);
    println!("{what}: {found}");
    assert!(found.flipped < 0.005 * found.pixels, "{what}: faces differ: {found}");
    assert!(found.display > 0.3 * found.pixels, "{what}: next to nothing shown: {found}");
    assert!(found.far < 0.002 * found.pixels && found.mean() < 0.75, "{what}: {found}");
}

#[test]
fn the_gpu_and_its_twin_show_the_piazza_alike_in_every_mode() {
    let Some(bench) = Bench::piazza(&["01", "02", "03", "08"]) else { return };
    let views = [(0, [1100.0, 900.0]), (1, [1300.0, 700.0]), (2, [700.0, 750.0]), (3, [700.0, 1200.0])];
    for (mode, (photo, target)) in Mode::ALL.into_iter().zip(views) {
        let mut shot = close_up(&bench, photo, target);
        shot.blend.mode = mode;
        compare(&bench, &Relief::default(), &shot, &format!("{mode}"));
    }
    let mut shot = close_up(&bench, 0, views[0].1);
    for exposure in [Exposure::Common, Exposure::Raw] {
        shot.exposure = exposure;
        compare(&bench, &Relief::default(), &shot, &format!("{exposure:?}"));
    }
}

/// Looks over the roofs and up, where photos end.
fn up_from(bench: &Bench, photo: usize, focal_px: f64) -> Shot {
    let photo = &bench.site.photos[photo];
    let eye = photo.pose.center_in_world() + glam::DVec3::new(0.8, -0.5, 0.2);
    let towards = photo.pose.rotation.transpose() * glam::DVec3::new(0.3, -0.8, 1.0);
    Shot::new(centred(240, 160, focal_px), look_at(eye, eye + towards))
}

#[test]
fn the_gpu_and_its_twin_show_the_dome_alike_and_nothing_around_the_model_stays_a_hole() {
    let Some(mut bench) = Bench::piazza(&["01", "02", "03"]) else { return };
    let flat = Relief::default();
    let shot = up_from(&bench, 0, 110.0);
    let holes = |bench: &Bench, shot: &Shot| {
        let mut renderer = bench.renderer(&flat);
        let faces = renderer.faces(shot, &Task::silent()).unwrap();
        let picture = renderer.picture(shot, &Task::silent()).unwrap();
        let open = picture.pixels().iter().zip(&faces).filter(|(_, face)| **face == 0);
        open.filter(|(pixel, _)| pixel[3] == 0).count()
    };
    assert!(holes(&bench, &shot) > 1000, "photos end within the view");
    bench.put_dome(224);
    assert_eq!(holes(&bench, &shot), 0);
    for mode in [Mode::Smooth, Mode::Debevec, Mode::Lumigraph] {
        for quality in [Quality::Preview, Quality::Final] {
            // Finer than photos and dome: their levels of detail are compared elsewhere.
            let mut shot = Shot { quality, ..up_from(&bench, 1, 600.0) };
            shot.blend.mode = mode;
            let found = difference(&mut bench.renderer(&flat), &mut bench.twin(&flat), &shot);
            println!("{mode} {quality:?}: {found}");
            assert!(found.surroundings > 0.3 * found.pixels, "{found}");
            // On smooth light the rounding to 8 bits and the quartic of previews add up at every pixel: 0.5 and 0.7.
            assert!(found.far < 0.002 * found.pixels && found.mean() < 1.2, "{mode} {quality:?}: {found}");
        }
    }
}

#[test]
fn the_gpu_and_its_twin_bring_photos_to_one_sky_alike() {
    let Some(mut bench) = Bench::piazza(&["01", "02", "03"]) else { return };
    let flat = Relief::default();
    bench.put_dome(224);
    let shot = up_from(&bench, 1, 600.0);
    let plain = bench.twin(&flat).picture(&shot, &Task::silent()).unwrap();
    let factors = |phase: f32| {
        let cell = |at: usize| {
            let (x, y) = ((at % GRID) as f32, (at / GRID) as f32);
            [0.4 * (0.3 * x + phase).sin(), 0.3 * (0.2 * y + phase).cos(), 0.02 * (x - y)]
        };
        Some(SurroundingsFactors { offset: [0.1, -0.1, phase], cells: (0..GRID * GRID).map(cell).collect() })
    };
    let of_photo = vec![factors(0.0), None, factors(0.3)];
    let scale = bench.sources.surroundings_scale;
    bench.gains.surroundings = Arc::new(SurroundingsGains { of_photo, dome_white: 1.5, scale });
    let changed = bench.twin(&flat).picture(&shot, &Task::silent()).unwrap();
    assert_ne!(changed, plain, "so there was something to compare");
    let found = difference(&mut bench.renderer(&flat), &mut bench.twin(&flat), &shot);
    // As for the dome alone.
    assert!(found.surroundings > 0.3 * found.pixels, "{found}");
    assert!(found.far < 0.002 * found.pixels && found.mean() < 1.2, "{found}");
    // A photo's own camera shows the photo: others count beside outlines and at its frame alone.
    let own = bench.own(0);
    let shown = bench.renderer(&flat).picture(&own, &Task::silent()).unwrap();
    let of_photo = vec![None; 3];
    bench.gains.surroundings = Arc::new(SurroundingsGains { of_photo, dome_white: 1.5, scale });
    let before = bench.renderer(&flat).picture(&own, &Task::silent()).unwrap();
    let is_off = |(a, b): (&[u8; 4], &[u8; 4])| (0..3).any(|c| a[c].abs_diff(b[c]) > 1);
    let off = shown.pixels().iter().zip(before.pixels()).filter(|pair| is_off(*pair)).count();
    let all = shown.pixels().len();
    println!("{off} of {all} pixels of a photo's own camera change");
    assert!(10_000 * off < all, "{off} of {all}");
}

#[test]
fn the_gpu_and_its_twin_undo_what_lenses_did_alike() {
    let Some(mut bench) = Bench::piazza(&["01", "02"]) else { return };
    let shot = close_up(&bench, 0, [1100.0, 900.0]);
    let plain = bench.twin(&Relief::default()).picture(&shot, &Task::silent()).unwrap();
    let dark = Optics { falloff: [-0.6, -0.3], offset: 0.01 };
    bench.gains.optics = vec![dark, Optics { falloff: [0.2, -0.5], offset: -0.005 }];
    compare(&bench, &Relief::default(), &shot, "lenses");
    let undone = bench.twin(&Relief::default()).picture(&shot, &Task::silent()).unwrap();
    assert_ne!(undone, plain, "so there was something to compare");
    // The same piece as a crop of a picture that looks where the photo does: the view's own lens darkens it.
    let (photo, mut crop) = (&bench.site.photos[0], shot.clone());
    let eye = shot.pose.center_in_world();
    crop.pose = Pose { rotation: photo.pose.rotation, translation: -(photo.pose.rotation * eye) };
    crop.camera.cx -= 6.0 * (1100.0 - photo.camera.cx);
    crop.camera.cy -= 6.0 * (900.0 - photo.camera.cy);
    let without = bench.twin(&Relief::default()).picture(&crop, &Task::silent()).unwrap();
    bench.gains.keeps_vignetting = true;
    compare(&bench, &Relief::default(), &crop, "lenses of views");
    let kept = bench.twin(&Relief::default()).picture(&crop, &Task::silent()).unwrap();
    assert_ne!(kept, without, "so there was something to compare");
}

#[test]
fn in_its_own_camera_a_photo_has_its_vignetting_back() {
    let Some(mut bench) = Bench::piazza(&["01", "02"]) else { return };
    let photo = &bench.site.photos[0];
    let shot = Shot::new(scaled(&photo.camera, 0.25), photo.pose);
    let picture = |bench: &Bench| bench.twin(&Relief::default()).picture(&shot, &Task::silent()).unwrap();
    let plain = picture(&bench);
    bench.gains.optics = vec![Optics { falloff: [-0.6, -0.3], offset: 0.0 }; 2];
    let differing = |other: Picture| {
        let bytes = plain.rgba.iter().zip(&other.rgba);
        bytes.filter(|(a, b)| a.abs_diff(**b) > 1).count() as f64 / plain.rgba.len() as f64
    };
    assert!(differing(picture(&bench)) > 0.1, "without it the corners are brighter");
    bench.gains.keeps_vignetting = true;
    // What this photo does not show of the surfaces in its view, the other one does.
    assert!(differing(picture(&bench)) < 0.01);
}

#[test]
fn the_gpu_and_its_twin_move_points_on_a_relief_alike() {
    let Some(bench) = Bench::piazza(&["01", "02", "03", "08"]) else { return };
    let relief = hills(&bench.site.model);
    for (photo, target) in [(0, [1100.0, 900.0]), (1, [1300.0, 700.0])] {
        compare(&bench, &relief, &close_up(&bench, photo, target), &format!("relief before photo {photo}"));
    }
}

/// Every planar face with gentle heights of up to 5 cm.
pub fn hills(model: &Model) -> Relief {
    let mut rng = Rng::new(31);
    let mut of_face = Vec::new();
    for face in model.face_ids() {
        let frame = PlaneFrame::from_plane(&model.face(face).plane);
        let flat: Vec<_> = model.ring_points(face).map(|p| frame.flat(p)).collect();
        let low = flat.iter().copied().reduce(glam::DVec2::min).unwrap();
        let high = flat.iter().copied().reduce(glam::DVec2::max).unwrap();
        let cell = ((high - low).max_element() / 8.0).max(0.5);
        let size = ((high - low) / cell).ceil().max(glam::DVec2::ONE).as_uvec2().to_array();
        let heights = (0..size[0] * size[1]).map(|_| rng.between(-0.05, 0.05) as f32).collect();
        of_face.push(model.face(face).planar.then_some(FaceRelief { frame, low, cell, size, heights }));
    }
    Relief { of_face }
}
