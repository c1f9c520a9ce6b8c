//! Walls without points: plumb planes along the directions of known walls are swept, and those that photos agree about where
//! nothing else explains them are added.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use quadratura_base::error::Result;
use quadratura_base::geometry::Plane;
use quadratura_base::task::Task;

use super::chart::regions;
use super::compare::Comparer;
use super::label::{FAR, LabelCandidates, PhotoLabels, UNKNOWN, is_front};
use super::planes::{PlaneKind, PlaneOfPoints, is_on};
use super::points::NormalisedPoint;
use super::support::middle;
use super::view::WorkingPhoto;

/// The stage that is reported.
const STAGE: &str = "sweep walls";
/// The most directions, with those across them.
const DIRECTIONS: usize = 8;
/// Distances of planes from the cameras' middle that are tried, ...
const DISTANCES: usize = 60;
/// ... from the nearest to the farthest, in median distances of points.
const RANGE: [f64; 2] = [0.2, 5.0];
/// Photos in which planes are swept.
const PHOTOS: usize = 8;
/// Other photos with which each is compared.
const OTHERS: usize = 3;
/// The agreement cost of a label above which a pixel is not explained.
const POOR: f32 = 0.6;
/// The largest disagreement about a plane.
const AGREED: f32 = 0.45;
/// What a plane has to gain at a pixel.
const GAIN: f32 = 0.15;
/// The least texture of a pixel.
const TEXTURED: f32 = 0.5;
/// The smallest region, in pixels of half the working size.
const LEAST_REGION: usize = 12;
/// The most planes that are added, and the least share of the swept pixels of each.
const MOST: usize = 6;
const LEAST_SHARE: f64 = 0.0015;
/// Planes are twins within this cosine, of 6 degrees, and this distance.
const TWIN: (f64, f64) = (0.9945, 0.02);
/// Steps of a disagreement that is kept in a byte; the last one stands for none.
const STEPS: f32 = 250.0;
const NONE: u8 = u8::MAX;

/// A photo at half the working size.
struct Swept<'a> {
    view: &'a WorkingPhoto,
    /// What the present label costs by agreement; NaN where a pixel is explained, or tells nothing.
    cost: Vec<f32>,
}

/// Returns the planes that explain what the labels do not.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`] on request.
pub fn swept(
    coarse: &[WorkingPhoto],
    near: &[Vec<u32>],
    points: &[NormalisedPoint],
    sky: &[Vec<f32>],
    labels: &[PhotoLabels],
    candidates: &LabelCandidates,
    task: &Task,
) -> Result<Vec<PlaneOfPoints>> {
    let step = coarse.len().div_ceil(PHOTOS).max(1);
    let chosen: Vec<usize> = (0..coarse.len()).step_by(step).collect();
    let comparers: Vec<Comparer<'_>> =
        chosen.iter().map(|of| Comparer::new(coarse, *of, &near[*of], OTHERS)).collect();
    let mut photos: Vec<Swept<'_>> = chosen
        .iter()
        .zip(&comparers)
        .map(|(of, comparer)| Swept {
            view: &coarse[*of],
            cost: unexplained(coarse, *of, comparer, labels, sky),
        })
        .collect();
    let pixels: usize = photos.iter().map(|photo| photo.cost.len()).sum();
    let middle_eye = coarse.iter().map(|view| view.eye).sum::<DVec3>() / coarse.len() as f64;
    let trials = trials(candidates, middle_eye);
    let done = AtomicU64::new(0);
    let judge = |plane: &Plane| -> Result<Vec<Vec<u8>>> {
        task.step(STAGE, done.fetch_add(1, Ordering::Relaxed), trials.len() as u64)?;
        let each = photos.iter().zip(&comparers);
        Ok(each.map(|(photo, comparer)| disagreements(photo, comparer, plane, candidates.ground())).collect())
    };
    let all: Vec<Vec<Vec<u8>>> = trials.par_iter().map(judge).collect::<Result<_>>()?;
    let mut found: Vec<PlaneOfPoints> = Vec::new();
    let mut is_used = vec![false; trials.len()];
    while found.len() < MOST {
        task.check_cancelled()?;
        let scores: Vec<f64> = (0..trials.len())
            .into_par_iter()
            .map(|i| if is_used[i] { 0.0 } else { score(&photos, &all[i]).0 })
            .collect();
        let Some(best) = (0..trials.len()).max_by(|a, b| scores[*a].total_cmp(&scores[*b])) else { break };
        is_used[best] = true;
        if score(&photos, &all[best]).1 < (LEAST_SHARE * pixels as f64) as usize {
            break;
        }
        let (plane, own) = refined(&photos, &comparers, trials[best], middle_eye, candidates.ground());
        let known = candidates.planes.iter().chain(&found);
        if known.into_iter().any(|other| is_twin(&other.plane, &plane)) {
            continue;
        }
        let places = places(&mut photos, &own, &plane);
        let members = (0..).zip(points).filter(|(_, point)| is_on(point, &plane)).map(|(i, _)| i).collect();
        found.push(PlaneOfPoints { plane, kind: PlaneKind::Plumb, members, places });
    }
    Ok(found)
}

/// Returns what the label of each pixel at half size costs; NaN where it is explained or plain.
fn unexplained(
    coarse: &[WorkingPhoto],
    of: usize,
    comparer: &Comparer<'_>,
    labels: &[PhotoLabels],
    sky: &[Vec<f32>],
) -> Vec<f32> {
    let [w, h] = coarse[of].size();
    let wide = labels[of].of.len() / (labels[of].of.len() / (2 * w).max(1)).max(1);
    let cost = |at: usize| {
        let full = (2 * (at / w)).min(2 * h) * wide + 2 * (at % w);
        let (Some(label), Some(cost)) = (labels[of].of.get(full), labels[of].cost.get(full)) else {
            return f32::NAN;
        };
        let is_open = *label == FAR && sky[of][full] < 0.5;
        let is_poor = *label != FAR && *label != UNKNOWN && *cost > POOR;
        let tells = comparer.texture[at] > TEXTURED;
        if tells && (is_open || is_poor) { cost.max(POOR) } else { f32::NAN }
    };
    (0..w * h).map(cost).collect()
}

/// Returns the planes that are tried: along and across the largest walls, at all distances in front of the cameras.
fn trials(candidates: &LabelCandidates, eye: DVec3) -> Vec<Plane> {
    let mut walls: Vec<&PlaneOfPoints> =
        candidates.planes.iter().filter(|plane| plane.kind == PlaneKind::Plumb).collect();
    walls.sort_by_key(|plane| std::cmp::Reverse(plane.members.len()));
    let mut directions: Vec<DVec3> = Vec::new();
    for wall in walls {
        let across = wall.plane.normal.cross(candidates.up);
        for direction in [wall.plane.normal, across, -across, -wall.plane.normal] {
            if directions.len() < DIRECTIONS && directions.iter().all(|other| other.dot(direction) < TWIN.0) {
                directions.push(direction);
            }
        }
    }
    let distance = |k: usize| RANGE[0] * (RANGE[1] / RANGE[0]).powf(k as f64 / (DISTANCES - 1) as f64);
    let at = |normal: DVec3| (0..DISTANCES).map(move |k| Plane { normal, point: eye - normal * distance(k) });
    directions.into_iter().flat_map(at).collect()
}

/// Returns how much photos disagree about a plane at the pixels that are not explained, in steps.
fn disagreements(
    photo: &Swept<'_>,
    comparer: &Comparer<'_>,
    plane: &Plane,
    ground: Option<&Plane>,
) -> Vec<u8> {
    let mut found = vec![NONE; photo.cost.len()];
    if !is_front(photo.view, plane) || photo.cost.iter().all(|cost| cost.is_nan()) {
        return found;
    }
    let depth = photo.view.inverse_depth(plane);
    let ground =
        ground.filter(|ground| is_front(photo.view, ground)).map(|ground| photo.view.inverse_depth(ground));
    let at = |x: usize, y: usize| {
        let inverse = depth.at(x, y);
        let is_below = ground.as_ref().is_some_and(|ground| ground.at(x, y) > 1.02 * inverse);
        if inverse > 1e-3 && !is_below { inverse } else { -1.0 }
    };
    for (found, own) in found.iter_mut().zip(comparer.disagreement(at, comparer.whole())) {
        if own < 1.0 {
            *found = (own * STEPS) as u8;
        }
    }
    found
}

/// Returns what a plane gains at a pixel.
#[inline]
fn gain(cost: f32, own: u8) -> f32 {
    let own = f32::from(own) / STEPS;
    // The larger one of 0 and NaN is 0.
    if own < AGREED { (cost - own - GAIN).max(0.0) } else { 0.0 }
}

/// Returns the gain of a plane in all photos, and the number of pixels that it is from; small regions count nothing.
fn score(photos: &[Swept<'_>], all: &[Vec<u8>]) -> (f64, usize) {
    let mut sum = (0.0, 0);
    for (photo, own) in photos.iter().zip(all) {
        let gains: Vec<f32> = photo.cost.iter().zip(own).map(|(cost, own)| gain(*cost, *own)).collect();
        let gains_any: Vec<bool> = gains.iter().map(|gain| *gain > 0.0).collect();
        let (number, sizes) = regions(&gains_any, photo.view.size());
        for at in (0..gains.len()).filter(|at| gains_any[*at] && sizes[number[*at] as usize] >= LEAST_REGION)
        {
            sum = (sum.0 + f64::from(gains[at]), sum.1 + 1);
        }
    }
    sum
}

/// Moves a plane along its normal to where it gains most.
fn refined(
    photos: &[Swept<'_>],
    comparers: &[Comparer<'_>],
    start: Plane,
    eye: DVec3,
    ground: Option<&Plane>,
) -> (Plane, Vec<Vec<u8>>) {
    let judge = |plane: &Plane| -> Vec<Vec<u8>> {
        photos
            .iter()
            .zip(comparers)
            .map(|(photo, comparer)| disagreements(photo, comparer, plane, ground))
            .collect()
    };
    let mut best = start;
    for step in [0.02, 0.007, 0.0025] {
        let away = best.signed_distance(eye);
        let tried: Vec<Plane> = (-2..=2)
            .map(|k| Plane { point: best.point - best.normal * (away * step * f64::from(k)), ..best })
            .collect();
        let scores: Vec<f64> = tried.par_iter().map(|plane| score(photos, &judge(plane)).0).collect();
        best = tried[(0..tried.len()).max_by(|a, b| scores[*a].total_cmp(&scores[*b])).unwrap_or(2)];
    }
    (best, judge(&best))
}

fn is_twin(a: &Plane, b: &Plane) -> bool {
    a.normal.dot(b.normal) > TWIN.0 && a.signed_distance(b.point).abs() < TWIN.1
}

/// Returns the places at which photos agree about a plane, and takes their pixels as explained.
fn places(photos: &mut [Swept<'_>], all: &[Vec<u8>], plane: &Plane) -> Vec<DVec3> {
    let mut places = Vec::new();
    for (photo, own) in photos.iter_mut().zip(all) {
        let (w, depth) = (photo.view.size()[0], photo.view.inverse_depth(plane));
        let is_won: Vec<bool> =
            photo.cost.iter().zip(own).map(|(cost, own)| gain(*cost, *own) > 0.0).collect();
        let (number, sizes) = regions(&is_won, photo.view.size());
        for at in (0..own.len()).filter(|at| is_won[*at] && sizes[number[*at] as usize] >= LEAST_REGION) {
            photo.cost[at] = f32::NAN;
            let (x, y) = (at % w, at / w);
            places.push(photo.view.eye + photo.view.ray(middle(x, y)) / depth.at(x, y));
        }
    }
    places
}
