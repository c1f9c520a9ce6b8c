//! Fits a pose to the points near which it lies already.

use glam::{DQuat, DVec3};

use quadratura_base::geometry::Similarity;

use super::linear::solve;
use super::score::{Ray, agrees, cast, judge};
use super::surface::Surface;

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

/// Makes one step that lays faces on the points that they are near to. `None` where nothing agrees.
pub fn step(surface: &Surface, rays: &[Ray], pose: &Similarity, tolerance: f64) -> Option<Similarity> {
    let hits = cast(surface, rays, pose, 1.0 + tolerance);
    let mut matrix = [[0.0; 7]; 7];
    let mut right = [0.0; 7];
    let mut count = 0;
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
    (0..7).for_each(|i| matrix[i][i] += HELD.powi(-2));
    let by = solve(matrix, right).filter(|_| count > 6)?;
    Some(moved(pose, by))
}

/// Makes several steps with a tolerance that shrinks from the first to the last.
pub fn refined(
    surface: &Surface,
    rays: &[Ray],
    start: &Similarity,
    steps: usize,
    [from, to]: [f64; 2],
) -> Similarity {
    let mut pose = *start;
    for i in 0..steps {
        let tolerance = from * (to / from).powf(i as f64 / (steps - 1).max(1) as f64);
        let Some(next) = step(surface, rays, &pose, tolerance) else { return pose };
        pose = next;
    }
    pose
}

/// The tolerances at which the last pixels are judged: the finer one draws, the coarser one keeps sight of the rest.
const FINE: [f64; 2] = [0.003, 0.008];

/// Searches the best pose near one, by steps in each unknown that are halved when none of them helps.
pub fn polished(
    surface: &Surface,
    rays: &[Ray],
    start: &Similarity,
    reach: f64,
    halvings: usize,
) -> Similarity {
    let value = |pose: &Similarity| {
        let hits = cast(surface, rays, pose, 1.0 + 1.5 * FINE[1]);
        FINE.map(|tolerance| judge(surface, rays, &hits, pose, tolerance).capped).iter().sum::<f64>()
    };
    let (mut best, mut pose, mut reach) = (value(start), *start, reach);
    for _ in 0..=halvings {
        // A few rounds find the way along a valley; what is still better after them is found at the next size.
        for _ in 0..3 {
            let before = best;
            for unknown in 0..7 {
                for sign in [1.0, -1.0] {
                    let mut by = [0.0; 7];
                    by[unknown] = sign * reach;
                    let next = moved(&pose, by);
                    let found = value(&next);
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
        reach *= 0.5;
    }
    pose
}
