//! Fits a pose to the points near which it lies already.

use glam::{DQuat, DVec3};
use rayon::prelude::*;

use quadratura_base::geometry::Similarity;

use super::linear::{eigen, solve};
use super::score::{ObservedRay, agrees, cast};
use super::surface::NormalisedModel;

/// How firmly each unknown of a step is held: directions that no point holds (sliding along a wall, the scale of a
/// wall) stay as they are. In units of the points' distance, and radians.
const HELD: f64 = 0.02;

/// Moves a pose by a turn about the origin (radians), a change of the logarithm of the scale, and a shift, all in
/// coordinates of the points.
pub fn moved(pose: &Similarity, by: [f64; 7]) -> Similarity {
    let turn = DQuat::from_scaled_axis(DVec3::new(by[0], by[1], by[2]));
    let growth = by[3].exp();
    // Rounding adds up over many steps, so the rotation is made one again.
    let rotation = glam::DMat3::from_quat((turn * DQuat::from_mat3(&pose.rotation)).normalize());
    Similarity {
        scale: pose.scale * growth,
        rotation,
        translation: turn * (pose.translation * growth) + DVec3::new(by[4], by[5], by[6]),
    }
}

/// What a fit may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Free {
    /// Turn, scale and shift.
    All,
    /// Scale and shift.
    ScaleAndShift,
    /// The shift.
    Shift,
}

/// Holds an unknown as it is.
const FIXED: f64 = 1e30;

/// Makes one step that lays faces on the points that they are near to. `None` where nothing agrees.
fn step(
    surface: &NormalisedModel,
    rays: &[ObservedRay],
    pose: &Similarity,
    tolerance: f64,
    free: Free,
) -> Option<Similarity> {
    let ((mut matrix, right), count) = normal_equations(surface, rays, pose, tolerance);
    for (i, row) in matrix.iter_mut().enumerate() {
        let is_free = match free {
            Free::All => true,
            Free::ScaleAndShift => i >= 3,
            Free::Shift => i >= 4,
        };
        row[i] += if is_free { HELD.powi(-2) } else { FIXED };
    }
    let by = solve(matrix, right).filter(|_| count > 6)?;
    Some(moved(pose, by))
}

type Equations = ([[f64; 7]; 7], [f64; 7]);

/// Returns the normal equations of the distances between points and faces that agree, in units of the tolerance, and the
/// number of these points.
fn normal_equations(
    surface: &NormalisedModel,
    rays: &[ObservedRay],
    pose: &Similarity,
    tolerance: f64,
) -> (Equations, u32) {
    let hits = cast(surface, rays, pose, 1.0 + tolerance);
    let (mut matrix, mut right, mut count) = ([[0.0; 7]; 7], [0.0; 7], 0);
    for (ray, hit) in rays.iter().zip(hits) {
        let Some(hit) = hit.filter(|hit| agrees(surface, ray, pose, *hit, tolerance)) else { continue };
        let n = pose.rotation * surface.normals[hit.1 as usize];
        let q = ray.eye.lerp(ray.point, hit.0);
        let turn = q.cross(n);
        let row = [turn.x, turn.y, turn.z, q.dot(n), n.x, n.y, n.z];
        let residual = (ray.point - q).dot(n);
        let tukey = (1.0 - ((hit.0 - 1.0) / tolerance).powi(2)).powi(2);
        let weight = tukey / (tolerance * ray.eye.distance(ray.point)).powi(2);
        for i in 0..7 {
            right[i] += weight * row[i] * residual;
            for j in 0..7 {
                matrix[i][j] += weight * row[i] * row[j];
            }
        }
        count += 1;
    }
    ((matrix, right), count)
}

/// Makes several steps with a tolerance that shrinks from the first to the last.
pub fn refined(
    surface: &NormalisedModel,
    rays: &[ObservedRay],
    start: &Similarity,
    steps: usize,
    [from, to]: [f64; 2],
    free: Free,
) -> Similarity {
    let mut pose = *start;
    for i in 0..steps {
        let tolerance = from * (to / from).powf(i as f64 / (steps - 1).max(1) as f64);
        let Some(next) = step(surface, rays, &pose, tolerance, free) else { return pose };
        pose = next;
    }
    pose
}

/// Fits a pose as exactly as the points allow: a pattern search along directions that the points hold apart, each with a
/// step as large as they allow in it, halved four times. Along a wall and in its size, only faces that lie before or
/// behind others hold a pose; there are no derivatives of that, but a value.
pub fn polished(surface: &NormalisedModel, rays: &[ObservedRay], start: &Similarity) -> Similarity {
    let (mut best, mut pose) = (exactness(surface, rays, start), *start);
    let mut part = 1.0;
    for _ in 0..=HALVINGS {
        // A few rounds find the way along a valley; what is still better after them is found at the next size.
        for _ in 0..3 {
            let before = best;
            let (held, count) = normal_equations(surface, rays, &pose, FINE[1]);
            for (firm, direction) in eigen(held.0) {
                // So far, the points that agree are off by their tolerance on average.
                let step = part * (f64::from(count) / firm.max(1e-9)).sqrt().min(LARGEST_STEP);
                for sign in [1.0, -1.0] {
                    let next = moved(&pose, direction.map(|x| sign * step * x));
                    let found = exactness(surface, rays, &next);
                    if found > best {
                        (best, pose) = (found, next);
                        break;
                    }
                }
            }
            if best <= before {
                break;
            }
        }
        part *= 0.5;
    }
    pose
}

const HALVINGS: usize = 4;

/// The largest step, in units of the points' distance and radians: 20 cm at 20 m.
const LARGEST_STEP: f64 = 0.012;

/// Tolerances at which the last pixels are judged: the finer one draws, the coarser one keeps sight of the rest.
const FINE: [f64; 2] = [0.002, 0.006];

/// No region counts for more than this share of the points in the last judgement. It may be more than in
/// [`super::score`], because the pose is right already.
const MOST_PER_REGION: f64 = 0.2;

/// The price of a point that is hidden.
const BLOCKED: f64 = 0.5;

/// How exactly points lie on faces, by their distance across the face, so that slanted faces count as others do.
fn exactness(surface: &NormalisedModel, rays: &[ObservedRay], pose: &Similarity) -> f64 {
    let of = |rays: &[ObservedRay]| {
        let hits = cast(surface, rays, pose, 1.0 + 1.5 * FINE[1]);
        let (mut regions, mut blocked) = (vec![0.0; surface.region_count], 0.0);
        for (ray, hit) in rays.iter().zip(hits) {
            let Some((q, triangle)) = hit else { continue };
            let normal = pose.rotation * surface.normals[triangle as usize];
            let along = (ray.point - ray.eye).normalize();
            let off = (q - 1.0).abs() * along.dot(normal).abs();
            if agrees(surface, ray, pose, (1.0, triangle), FINE[1]) {
                let value = |tolerance: f64| (1.0 - (off / tolerance).powi(2)).max(0.0);
                regions[surface.regions[triangle as usize] as usize] += value(FINE[0]) + value(FINE[1]);
            }
            if q < 1.0 - 2.5 * FINE[1] {
                blocked += 1.0;
            }
        }
        (regions, blocked)
    };
    // Sums of fixed parts are the same for any number of threads.
    let parts: Vec<(Vec<f64>, f64)> = rays.par_chunks(1000).map(of).collect();
    let most = 2.0 * MOST_PER_REGION * rays.len() as f64;
    let regions = (0..surface.region_count).map(|i| parts.iter().map(|(regions, _)| regions[i]).sum::<f64>());
    let limited: f64 = regions.map(|value| value.min(most) + 0.05 * (value - most).max(0.0)).sum();
    limited - BLOCKED * parts.iter().map(|(_, blocked)| blocked).sum::<f64>()
}
