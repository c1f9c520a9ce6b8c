//! The order of drawing: nearer depth pixels come last.

use glam::{DMat3, DVec2, DVec3, IVec2};

use super::super::layout::DepthPixel;
use super::super::order::quadrants;
use super::super::splat::{Canvas, Dot};
use super::super::warp::{DrawingOrder, WarpOptions, drawn_in_order, last_drawn};
use super::{of_model, step_aside, with_level};
use crate::{DepthPixelOrigin, Ldi, ResolutionLevel, Splat};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::synthetic::{Rng, centred, closed_form, look_at, random};
use quadratura_base::task::Task;
use quadratura_view::Shot;

/// A frame whose pixel centres can be epipoles in all nine places.
const WIDE: u32 = 48;
const HIGH: u32 = 40;

fn reference() -> Pinhole {
    Pinhole { width: WIDE, height: HIGH, fx: 40.0, fy: 44.0, cx: 21.0, cy: 23.0 }
}

fn pixel(inverse_depth: f64) -> DepthPixel {
    let splat = Splat::new(0, DepthPixelOrigin::Photo);
    DepthPixel { inverse_depth: inverse_depth as f32, colour: [255; 4], surface: 0, splat }
}

/// Points of the frame on one ray of the picture's camera: pixel, inverse depth, and distance along the ray.
type PointsOnRay = Vec<(IVec2, f64, f64)>;

/// Returns rays through pixel centres for an epipole at the pixel centre `e` with C2 at depth `lambda` there: on the ray of
/// slope m along the lattice direction g, the points are p = e + k g with d = (1 - m k) / lambda, at k / d.
fn rays_around(e: IVec2, lambda: f64, rng: &mut Rng) -> Vec<PointsOnRay> {
    let mut rays = Vec::new();
    for g in [IVec2::new(1, 0), IVec2::new(0, 1), IVec2::new(1, 1), IVec2::new(2, -1), IVec2::new(-1, 3)] {
        for sign in [1, -1] {
            let m = rng.between(-0.2, 0.2);
            let mut ray: PointsOnRay = Vec::new();
            for k in 1..120 {
                let p = e + sign * k * g;
                let d = (1.0 - m * f64::from(sign * k)) / lambda;
                if p.x >= 0 && p.y >= 0 && p.x < WIDE as i32 && p.y < HIGH as i32 && d > 1e-3 {
                    ray.push((p, d, f64::from(k) / d));
                }
            }
            rays.push(ray);
        }
    }
    if e.x >= 0 && e.y >= 0 && e.x < WIDE as i32 && e.y < HIGH as i32 {
        // Through the epipole itself: both sides of C2, of which one is a layered depth pixel's part.
        let depths = [0.05, 0.11, 0.23, 0.49, 1.3].map(|d| (e, d, (1.0 / d - lambda).abs()));
        let (before, behind) = depths.into_iter().partition(|(_, d, _)| 1.0 / d > lambda);
        rays.extend([before, behind]);
    }
    rays
}

/// Returns a layered depth image of all points of some rays, and for each ray its points as index and distance.
fn of_rays(rays: &[PointsOnRay]) -> (Ldi, Vec<Vec<(usize, f64)>>) {
    let mut points: Vec<(i32, i32, f64, usize, f64)> = Vec::new();
    for (number, ray) in rays.iter().enumerate() {
        points.extend(ray.iter().map(|(p, d, distance)| (p.y, p.x, *d, number, *distance)));
    }
    points.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(b.2.total_cmp(&a.2)));
    let row = |y: u32| {
        let of_row = points.iter().filter(move |point| point.0 == y as i32);
        of_row.map(|point| (point.1 as u16, pixel(point.2))).collect()
    };
    let level = ResolutionLevel::of_rows(reference(), (0..HIGH).map(row));
    let mut by_ray = vec![Vec::new(); rays.len()];
    points.iter().enumerate().for_each(|(index, point)| by_ray[point.3].push((index, point.4)));
    (with_level(level, Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO }, Vec::new()), by_ray)
}

/// Records the order in which depth pixels before the camera are drawn.
struct Recorder(Vec<usize>);

impl Canvas for Recorder {
    const SPACED: bool = false;
    const REACH: f32 = f32::INFINITY;

    fn draw(&mut self, dot: &Dot) {
        if dot.u.is_finite() {
            self.0.push(dot.index);
        }
    }
}

/// Counts the pairs of points on one ray that are drawn, and those whose nearer point comes first.
fn pairs(ldi: &Ldi, by_ray: &[Vec<(usize, f64)>], shot: &Shot, order: DrawingOrder) -> (u64, u64) {
    let options = WarpOptions { order, level: Some(0), unculled: true, ..WarpOptions::default() };
    let drawn = drawn_in_order(ldi, shot, &options, Recorder(Vec::new())).0;
    let place = |index: usize| drawn.iter().position(|drawn| *drawn == index);
    let (mut all, mut wrong) = (0, 0);
    for ray in by_ray {
        let drawn: Vec<(usize, f64)> =
            ray.iter().filter_map(|(index, distance)| Some((place(*index)?, *distance))).collect();
        for (i, a) in drawn.iter().enumerate() {
            for b in &drawn[..i] {
                all += 1;
                wrong += u64::from((a.0 < b.0) != (a.1 > b.1));
            }
        }
    }
    (all, wrong)
}

/// A camera at `centre` that looks in a direction chosen by `rng`; a quarter of them look back.
fn looking_anywhere(centre: DVec3, rng: &mut Rng) -> Shot {
    let mut unit =
        || DVec3::from_array(std::array::from_fn(|_| rng.between(-1.0, 1.0))).normalize_or(DVec3::Z);
    let forward = unit();
    let right = forward.cross(unit()).normalize_or(forward.any_orthonormal_vector());
    let rotation = DMat3::from_cols(right, forward.cross(right), forward).transpose();
    Shot::new(centred(64, 64, 20.0), Pose { rotation, translation: -(rotation * centre) })
}

#[test]
fn on_one_ray_nearer_depth_pixels_come_last_whatever_the_place_and_sign_of_the_epipole() {
    let mut rng = Rng::new(1);
    let places = [-9, 17, 60];
    let (mut all, mut reversed_right) = (0, 0);
    for (x, y) in places.into_iter().flat_map(|x| places.map(|y| (x, y))) {
        for lambda in [4.0, 0.7, -0.7, -3.0] {
            let e = IVec2::new(x, y);
            let (ldi, by_ray) = of_rays(&rays_around(e, lambda, &mut rng));
            let centre =
                lambda * reference().ray_in_camera(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
            for _ in 0..6 {
                let shot = looking_anywhere(centre, &mut rng);
                let (pairs_here, wrong) = pairs(&ldi, &by_ray, &shot, DrawingOrder::McMillan);
                assert_eq!(wrong, 0, "of {pairs_here} with the epipole at {e} and C2 at depth {lambda}");
                let (_, wrong) = pairs(&ldi, &by_ray, &shot, DrawingOrder::Reversed);
                all += pairs_here;
                reversed_right += pairs_here - wrong;
            }
        }
    }
    assert!(all > 5000, "{all} pairs");
    assert_eq!(reversed_right, 0, "the reversed order has pairs right");
}

#[test]
fn with_parallel_epipolar_lines_the_order_holds_too() {
    let mut rng = Rng::new(2);
    let (mut all, mut reversed_right) = (0, 0);
    for g in [IVec2::new(1, 0), IVec2::new(0, -1), IVec2::new(-1, 1), IVec2::new(2, 1)] {
        // C2 is beside the camera, at lambda K^-1 (g, 0): at infinity in the image. On its rays are the points p = o + k g
        // with d = c + k / lambda, at 1 / d.
        let (Pinhole { fx, fy, .. }, lambda) = (reference(), rng.between(2.0, 20.0));
        let centre = lambda * DVec3::new(f64::from(g.x) / fx, f64::from(g.y) / fy, 0.0);
        let ray = |row: i32| {
            let (origin, c) = (IVec2::new(row % WIDE as i32, row), rng.between(0.2, 2.0));
            let points = (-40..40).map(|k| (origin + k * g, c + f64::from(k) / lambda));
            let inside = points
                .filter(|(p, d)| p.x >= 0 && p.y >= 0 && p.x < WIDE as i32 && p.y < HIGH as i32 && *d > 1e-3);
            inside.map(|(p, d)| (p, d, 1.0 / d)).collect()
        };
        let (ldi, by_ray) = of_rays(&(0..HIGH as i32).map(ray).collect::<Vec<PointsOnRay>>());
        for _ in 0..6 {
            let shot = looking_anywhere(centre, &mut rng);
            let (pairs_here, wrong) = pairs(&ldi, &by_ray, &shot, DrawingOrder::McMillan);
            assert_eq!(wrong, 0, "of {pairs_here} with epipolar lines along {g}");
            let (_, wrong) = pairs(&ldi, &by_ray, &shot, DrawingOrder::Reversed);
            all += pairs_here;
            reversed_right += pairs_here - wrong;
        }
    }
    assert!(all > 5000, "{all} pairs");
    assert_eq!(reversed_right, 0, "the reversed order has pairs right");
}

/// Counts the pixels of a view at which something is drawn; of these, those whose last drawn depth pixel is more than 1 %
/// behind the nearest one there; of these, those whose nearest one is more than 3 pixels of the frame away.
fn behind_the_nearest(ldi: &Ldi, shot: &Shot, order: DrawingOrder) -> [u64; 3] {
    let options = WarpOptions { order, level: Some(0), ..WarpOptions::default() };
    let last = last_drawn(ldi, shot, &options, &Task::silent()).unwrap();
    let level = &ldi.levels[0];
    let transfer = super::super::transfer::Transfer::new(&ldi.camera, &ldi.pose, &shot.camera, &shot.pose);
    let mut nearest = vec![(0.0f64, IVec2::ZERO); last.len()];
    let mut places = vec![IVec2::ZERO; level.len()];
    let mut depths = vec![0.0f64; level.len()];
    for y in 0..ldi.camera.height {
        for index in level.row(y) {
            let x = level.columns[index];
            places[index] = IVec2::new(i32::from(x), y as i32);
            let position = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let depth = f64::from(level.inverse_depths[index]);
            let Some((at, omega)) = transfer.position(position, depth) else { continue };
            depths[index] = depth / omega;
            if at.x >= 0.0
                && at.y >= 0.0
                && at.x < f64::from(shot.camera.width)
                && at.y < f64::from(shot.camera.height)
            {
                let pixel = &mut nearest[at.y as usize * shot.camera.width as usize + at.x as usize];
                if depth / omega > pixel.0 {
                    *pixel = (depth / omega, places[index]);
                }
            }
        }
    }
    let mut counts = [0; 3];
    for (last, (depth, place)) in last.iter().zip(nearest) {
        let Some(index) = last.checked_sub(1).map(|index| index as usize) else { continue };
        let behind = depth > 1.01 * depths[index];
        let far = behind && (places[index] - place).abs().max_element() > 3;
        counts = [counts[0] + 1, counts[1] + u64::from(behind), counts[2] + u64::from(far)];
    }
    counts
}

#[test]
fn in_pictures_the_last_drawn_is_nearly_always_the_nearest_and_reversed_it_is_not() {
    let mut rng = Rng::new(3);
    let (mut right, mut reversed) = ([0u64; 3], [0u64; 3]);
    let mut scenes: Vec<_> = (0..4).map(|seed| random::boxes(seed, 8)).collect();
    scenes.extend([closed_form::three_beams(), closed_form::crossing_boxes(), closed_form::stairs()]);
    for scene in scenes.into_iter().map(|scene| scene.resized(160)) {
        let ldi = of_model(&scene.model, scene.camera, scene.pose, |_, _| [255; 4]);
        let eye = scene.pose.center_in_world();
        let middle = scene.model.vertices.iter().sum::<DVec3>() / scene.model.vertices.len() as f64;
        for _ in 0..6 {
            let apart = 0.25 * eye.distance(middle);
            let turned = |rng: &mut Rng| step_aside(rng, eye, middle, apart);
            let shot = Shot::new(scene.camera, turned(&mut rng));
            let add = |sum: &mut [u64; 3], order| {
                let counts = behind_the_nearest(&ldi, &shot, order);
                sum.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
            };
            add(&mut right, DrawingOrder::McMillan);
            add(&mut reversed, DrawingOrder::Reversed);
        }
    }
    let share = |count: u64, counts: [u64; 3]| count as f64 / counts[0] as f64;
    assert!(right[0] > 100_000, "{} pixels", right[0]);
    // Points within one pixel of the picture lie on slightly different rays, between which the order may fail; they are
    // neighbours in the frame.
    assert!(share(right[1], right) <= 0.01 && share(right[2], right) <= 1e-4, "{right:?}");
    assert!(share(reversed[1], reversed) > 0.05 && share(reversed[2], reversed) > 1e-3, "{reversed:?}");
}

#[test]
fn the_number_of_quadrants_is_that_of_the_epipole_s_place() {
    let of = |x: f64, y: f64, z: f64| quadrants([10, 8], DVec3::new(x, y, z)).len();
    for sign in [1.0, -1.0] {
        assert_eq!(of(5.0 * sign, 4.0 * sign, sign), 4, "inside");
        assert_eq!(of(50.0 * sign, 4.0 * sign, sign), 2, "beside");
        assert_eq!(of(-5.0 * sign, -4.0 * sign, sign), 1, "beyond a corner");
    }
    assert_eq!((of(1.0, -1.0, 0.0), of(0.0, 0.0, 0.0)), (1, 1), "at infinity, and nowhere");
}

#[test]
fn an_epipole_that_runs_to_infinity_changes_nothing_abruptly() {
    for (x, y) in [(1.0, 0.3), (-1.0, 2.0), (0.5, -1.0)] {
        let at_infinity = quadrants([100, 80], DVec3::new(x, y, 0.0));
        for z in [1e-9, -1e-9] {
            assert_eq!(quadrants([100, 80], DVec3::new(x, y, z)), at_infinity);
        }
    }
}

#[test]
fn a_camera_that_looks_at_its_own_reference_draws_the_last_layer_first() {
    let pose = look_at(DVec3::ZERO, DVec3::Y);
    let rows = |y: u32| if y == 2 { vec![(3, pixel(1.0)), (3, pixel(0.5))] } else { Vec::new() };
    let ldi = with_level(ResolutionLevel::of_rows(reference(), (0..HIGH).map(rows)), pose, Vec::new());
    let options = WarpOptions { level: Some(0), ..WarpOptions::default() };
    let drawn = drawn_in_order(&ldi, &Shot::new(reference(), pose), &options, Recorder(Vec::new()));
    assert_eq!(drawn.0, [1, 0]);
}
