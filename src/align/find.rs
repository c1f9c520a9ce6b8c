//! The search: planes on planes, then rays, then fits, each stage with fewer poses and more points.

use glam::DMat3;
use rayon::prelude::*;

use quadratura_base::error::Result;
use quadratura_base::geometry::Similarity;
use quadratura_base::task::Task;

use super::directions::directions;
use super::heights::{Anchor, PlaneHeights, starts};
use super::points::Points;
use super::refine::{Free, polished, refined};
use super::score::{ObservedRay, Worth, rays, score};
use super::surface::NormalisedModel;

/// A pose of the model in normalised coordinates, and what it is worth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundPose {
    pub pose: Similarity,
    pub worth: Worth,
}

/// The planes of the points on which planes of the model are laid, at most.
const ANCHORS: usize = 4;

/// ... as far as they have this share of the points.
const LEAST_ANCHOR: f64 = 0.02;

/// Points counted in a map of heights, and how many of them lie on the plane itself. At most 255.
const COUNTED: usize = 160;
const COUNTED_ON_IT: usize = 32;

/// The poses left after the first and the second rays, and at the end.
const FIRST: usize = 90;
const SECOND: usize = 15;
const LAST: usize = 6;

/// Two poses are one when turn (radians), logarithm of the scale and shift (in the points' unit) differ by less.
const SAME_START: f64 = 0.04;
const SAME_POSE: f64 = 0.08;

/// The search ends early with a pose that is worth so much, and so much more than the second one.
const ENOUGH: f64 = 0.16;
const CLEARLY: f64 = 1.5;

/// Rays by which poses are judged, the same for all poses.
pub struct JudgingRays {
    pub first: Vec<ObservedRay>,
    pub fit: Vec<ObservedRay>,
    pub second: Vec<ObservedRay>,
    pub last: Vec<ObservedRay>,
    pub polish: Vec<ObservedRay>,
}

/// The tolerance of the last judgement.
pub const LAST_TOLERANCE: f64 = 0.006;

impl JudgingRays {
    /// Draws them.
    pub fn new(points: &Points) -> Self {
        let of = |count: usize, seed: u64| rays(points, &points.sample(count, seed));
        Self {
            first: of(200, 1),
            fit: of(300, 2),
            second: of(600, 3),
            last: of(2000, 4),
            polish: of(4000, 9),
        }
    }

    /// Judges a pose finally.
    pub fn judged(&self, surface: &NormalisedModel, pose: Similarity) -> FoundPose {
        FoundPose { pose, worth: score(surface, &self.last, &pose, LAST_TOLERANCE) }
    }
}

/// Returns the best distinct poses, the best first; at most six.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`] on request.
pub fn search(
    surface: &NormalisedModel,
    points: &Points,
    samples: &JudgingRays,
    task: &Task,
) -> Result<Vec<FoundPose>> {
    let least = LEAST_ANCHOR * points.sights.len() as f64;
    let large = |i: &usize| points.planes[*i].members.len() as f64 >= least;
    let anchors: Vec<Anchor> = (0..points.planes.len().min(ANCHORS))
        .filter(large)
        .map(|i| Anchor::new(points, i, &directions(points, i), &counted(points, i)))
        .collect();
    let total = 2 * anchors.len() as u64;
    let (mut kept, mut reliefs): (Vec<FoundPose>, Vec<PlaneHeights>) = (Vec::new(), Vec::new());
    for (round, anchor) in (0..total).zip(anchors.iter().cycle()) {
        task.step("search the alignment", round, total)?;
        // First the faces' front sides.
        if round % anchors.len() as u64 == 0 {
            let side = if round == 0 { 1.0 } else { -1.0 };
            reliefs = surface.planes.par_iter().map(|on| PlaneHeights::new(surface, on, side)).collect();
        }
        let laid = reliefs.par_iter().map(|relief| {
            task.check_cancelled()?;
            Ok(starts(relief, anchor))
        });
        let laid: Vec<Similarity> = laid.collect::<Result<Vec<_>>>()?.concat();
        kept.extend(funnel(surface, samples, &laid, task)?);
        kept = distinct(kept, SAME_POSE, LAST);
        let second = kept.get(1).map_or(0.0, |found| found.worth.capped);
        if kept.first().is_some_and(|best| best.worth.capped > ENOUGH && best.worth.capped > CLEARLY * second)
        {
            break;
        }
    }
    // The best is laid as exactly as the points allow, and the second one, too, where it comes near.
    let best = kept.first().map_or(0.0, |found| found.worth.capped);
    for found in kept.iter_mut().take(2).filter(|found| found.worth.capped > 0.5 * best) {
        task.check_cancelled()?;
        let better = samples.judged(surface, polished(surface, &samples.polish, &found.pose));
        if better.worth.capped > found.worth.capped - 0.02 {
            *found = better;
        }
    }
    Ok(distinct(kept, SAME_POSE, LAST))
}

/// Draws the points that are counted over the plane with this index.
fn counted(points: &Points, index: usize) -> Vec<u32> {
    let own = &points.planes[index].members;
    let step = own.len().div_ceil(COUNTED_ON_IT).max(1);
    let mut all: Vec<u32> = own.iter().step_by(step).copied().collect();
    let others = points.sample(2 * COUNTED, 5 + index as u64);
    let elsewhere = |i: &u32| points.sights[*i as usize].plane != Some(index as u32);
    let others: Vec<u32> = others.into_iter().filter(elsewhere).collect();
    let wanted = COUNTED - all.len();
    let step = (others.len() as f64 / wanted as f64).max(1.0);
    all.extend((0..wanted).filter_map(|i| others.get((i as f64 * step) as usize)));
    all
}

/// Narrows the poses of one plane of the points down.
fn funnel(
    surface: &NormalisedModel,
    samples: &JudgingRays,
    laid: &[Similarity],
    task: &Task,
) -> Result<Vec<FoundPose>> {
    let scored = |rays: &[ObservedRay], tolerance: f64, poses: Vec<Similarity>| {
        let score = |pose: Similarity| {
            task.check_cancelled()?;
            Ok(FoundPose { pose, worth: score(surface, rays, &pose, tolerance) })
        };
        poses.into_par_iter().map(score).collect::<Result<Vec<FoundPose>>>()
    };
    let first = scored(&samples.first, 0.02, laid.to_vec())?;
    let first = distinct(first, SAME_START, FIRST);
    let fitted: Vec<Similarity> = first
        .par_iter()
        .map(|found| refined(surface, &samples.fit, &found.pose, 4, [0.03, 0.012], Free::All))
        .collect();
    let second = distinct(scored(&samples.second, 0.01, fitted)?, SAME_START, SECOND);
    let fitted: Vec<Similarity> = second
        .par_iter()
        .map(|found| refined(surface, &samples.second, &found.pose, 5, [0.012, 0.005], Free::All))
        .collect();
    scored(&samples.last, LAST_TOLERANCE, fitted)
}

/// Returns how far two poses are apart, the largest of turn, logarithm of the scale, and shift at the points' middle.
pub fn apart(a: &Similarity, b: &Similarity) -> f64 {
    let between: DMat3 = a.rotation * b.rotation.transpose();
    let trace = between.x_axis.x + between.y_axis.y + between.z_axis.z;
    let turn = (0.5 * (trace - 1.0)).clamp(-1.0, 1.0).acos();
    let shift = a.apply(b.inverse().apply(glam::DVec3::ZERO)).length();
    turn.max((a.scale / b.scale).ln().abs()).max(shift)
}

/// Sorts poses by worth and leaves out those near to a better one.
pub fn distinct(mut found: Vec<FoundPose>, same: f64, most: usize) -> Vec<FoundPose> {
    found.sort_by(|a, b| b.worth.capped.total_cmp(&a.worth.capped));
    let mut kept: Vec<FoundPose> = Vec::new();
    for next in found {
        if kept.len() == most {
            break;
        }
        if kept.iter().all(|other| apart(&next.pose, &other.pose) > same) {
            kept.push(next);
        }
    }
    kept
}
