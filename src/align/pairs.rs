//! Aligns by pairs that a person points out: a corner of the model, and where a photo shows it.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use quadratura_base::geometry::{Pinhole, Pose, Similarity};
use quadratura_base::raster::robust::{median, upper_median};
use quadratura_base::scene::SparsePoint;

use super::horn::similarity;
use super::linear::solve;
use super::refine::moved;

/// A corner of the model, and the pixel of a photo at which it is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CornerPair {
    /// The corner, in the model's coordinates.
    pub corner: DVec3,
    /// The index of the camera.
    pub photo: usize,
    /// The place in the pinhole image, in pixels.
    pub px: DVec2,
}

/// The transform that pairs give.
#[derive(Debug, Clone, PartialEq)]
pub struct PairFit {
    /// From the model's coordinates to the cameras' world.
    pub world_from_model: Similarity,
    /// For each pair, how far from its pixel the corner is seen then, in pixels; infinite behind the camera.
    pub residuals_px: Vec<f64>,
    /// The pair without which all others fit far better, if there is one.
    pub doubtful: Option<usize>,
}

/// Why pairs give no transform.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unpaired {
    /// Fewer than three pairs.
    TooFew,
    /// All pairs are in photos from one place, which leaves the size of the model open: a larger model farther away looks
    /// the same.
    OnePlace,
    /// The corners lie on one line, or the pixels contradict each other.
    NoFit,
}

/// Fewer pairs fit almost any pixels, so their residuals say little.
pub const SURE: usize = 5;

/// Residuals count fully up to this, in pixels, and by their root beyond: clicks are off by a few pixels, wrong corners by
/// many.
const SOFT_PX: f64 = 4.0;

/// Finds the similarity with which the photos show the corners at the pixels, by least squares on robust residuals from
/// several starts: depths are taken from the nearest sparse points, or guessed where there are none.
///
/// # Errors
/// Says why there is none.
pub fn from_pairs(
    pairs: &[CornerPair],
    cameras: &[(Pinhole, Pose)],
    points: &[SparsePoint],
) -> Result<PairFit, Unpaired> {
    if pairs.len() < 3 {
        return Err(Unpaired::TooFew);
    }
    let eye = |pair: &CornerPair| cameras[pair.photo].1.center_in_world();
    let places: Vec<DVec3> = places(pairs, cameras, points);
    let reach = pairs.iter().zip(&places).map(|(pair, place)| eye(pair).distance(*place)).fold(0.0, f64::max);
    let one_place = pairs.iter().all(|pair| eye(pair).distance(eye(&pairs[0])) < 1e-4 * reach);
    // In the only photo of a site every size looks the same, so that any does.
    if one_place && cameras.len() > 1 {
        return Err(Unpaired::OnePlace);
    }
    let best = fit(pairs, &places, cameras).ok_or(Unpaired::NoFit)?;
    let residuals_px: Vec<f64> = pairs.iter().map(|pair| residual(pair, cameras, &best)).collect();
    let doubtful = doubtful(pairs, &places, cameras, &residuals_px);
    Ok(PairFit { world_from_model: best, residuals_px, doubtful })
}

/// Returns the pair that all others contradict: left out, they fit with less than a third of the residual, and it is far
/// off.
fn doubtful(
    pairs: &[CornerPair],
    places: &[DVec3],
    cameras: &[(Pinhole, Pose)],
    residuals: &[f64],
) -> Option<usize> {
    if pairs.len() <= SURE {
        return None;
    }
    let usual = median(&mut residuals.to_vec())?.max(SOFT_PX);
    let without = |left_out: usize| {
        let rest = |i: &usize| *i != left_out;
        let others: Vec<CornerPair> = (0..pairs.len()).filter(rest).map(|i| pairs[i]).collect();
        let there: Vec<DVec3> = (0..pairs.len()).filter(rest).map(|i| places[i]).collect();
        let fit = fit(&others, &there, cameras)?;
        let worst = others.iter().map(|pair| residual(pair, cameras, &fit)).fold(0.0, f64::max);
        Some((left_out, worst, residual(&pairs[left_out], cameras, &fit)))
    };
    let all: Vec<_> = (0..pairs.len()).filter_map(without).collect();
    let (pair, worst, off) = all.into_iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    (off > 5.0 * worst.max(usual / 3.0) && worst < residuals.iter().copied().fold(0.0, f64::max) / 3.0)
        .then_some(pair)
}

/// How far from its pixel a corner is seen.
fn residual(pair: &CornerPair, cameras: &[(Pinhole, Pose)], pose: &Similarity) -> f64 {
    let (camera, at) = &cameras[pair.photo];
    let px = camera.image_from_camera(at.camera_from_world(pose.apply(pair.corner)));
    px.map_or(f64::INFINITY, |px| px.distance(pair.px))
}

/// Guesses where in the world each pixel's corner is: at the median depth of the seven sparse points that the photo shows
/// nearest to it.
fn places(pairs: &[CornerPair], cameras: &[(Pinhole, Pose)], points: &[SparsePoint]) -> Vec<DVec3> {
    let mut shown: BTreeMap<usize, Vec<(DVec2, f64)>> = BTreeMap::new();
    for photo in pairs.iter().map(|pair| pair.photo) {
        shown.entry(photo).or_insert_with(|| {
            let (camera, pose) = &cameras[photo];
            let seen = points.iter().filter(|point| point.observations.iter().any(|o| o.0 as usize == photo));
            let px = |point: &SparsePoint| {
                let place = pose.camera_from_world(point.position);
                Some((camera.image_from_camera(place)?, place.z))
            };
            seen.filter_map(px).collect()
        });
    }
    // Without points, as far away as the cameras are from each other.
    let eyes: Vec<DVec3> = cameras.iter().map(|(_, pose)| pose.center_in_world()).collect();
    let middle = eyes.iter().sum::<DVec3>() / eyes.len().max(1) as f64;
    let mut apart: Vec<f64> = eyes.iter().map(|eye| eye.distance(middle)).collect();
    let usual = upper_median(&mut apart).filter(|apart| *apart > 0.0).unwrap_or(1.0) * 2.0;
    let place = |pair: &CornerPair| {
        let (camera, pose) = &cameras[pair.photo];
        let mut near = shown[&pair.photo].clone();
        near.sort_by(|a, b| a.0.distance(pair.px).total_cmp(&b.0.distance(pair.px)));
        let mut depths: Vec<f64> = near.iter().take(7).map(|(_, depth)| *depth).collect();
        let depth = upper_median(&mut depths).unwrap_or(usual);
        pose.world_from_camera(camera.ray_in_camera(pair.px) * depth)
    };
    pairs.iter().map(place).collect()
}

/// The most triples of pairs from which the fit is started, besides all pairs together.
const TRIPLES: usize = 60;

fn fit(pairs: &[CornerPair], places: &[DVec3], cameras: &[(Pinhole, Pose)]) -> Option<Similarity> {
    let middle = places.iter().sum::<DVec3>() / places.len() as f64;
    let size = places.iter().map(|place| place.distance(middle)).fold(0.0, f64::max);
    let guess: Vec<(DVec3, DVec3)> =
        pairs.iter().map(|pair| pair.corner).zip(places.iter().copied()).collect();
    let mut starts: Vec<Similarity> = similarity(&guess).into_iter().collect();
    let count = pairs.len();
    let triples =
        (0..count).flat_map(|a| (a + 1..count).flat_map(move |b| (b + 1..count).map(move |c| [a, b, c])));
    let triples: Vec<[usize; 3]> = triples.collect();
    let step = triples.len().div_ceil(TRIPLES).max(1);
    starts.extend(triples.into_iter().step_by(step).filter_map(|of| similarity(&of.map(|i| guess[i]))));
    let fitted = starts.into_iter().map(|start| least_squares(pairs, cameras, start, middle, size));
    fitted.filter(|(cost, _)| cost.is_finite()).min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, pose)| pose)
}

/// The soft sum of residuals.
fn cost(pairs: &[CornerPair], cameras: &[(Pinhole, Pose)], pose: &Similarity) -> f64 {
    pairs.iter().map(|pair| (1.0 + (residual(pair, cameras, pose) / SOFT_PX).powi(2)).sqrt() - 1.0).sum()
}

/// Levenberg and Marquardt's method on the seven unknowns, with derivatives by differences.
fn least_squares(
    pairs: &[CornerPair],
    cameras: &[(Pinhole, Pose)],
    start: Similarity,
    middle: DVec3,
    size: f64,
) -> (f64, Similarity) {
    // About the middle of the places, in units of their extent, all unknowns are of one size.
    let frame = Similarity { scale: size, translation: middle, ..Similarity::IDENTITY };
    let moved = |pose: &Similarity, by: [f64; 7]| frame.compose(&moved(&frame.inverse().compose(pose), by));
    let px = |pair: &CornerPair, pose: &Similarity| {
        let (camera, at) = &cameras[pair.photo];
        camera.image_from_camera(at.camera_from_world(pose.apply(pair.corner)))
    };
    let (mut pose, mut best, mut damping) = (start, cost(pairs, cameras, &start), 1e-3);
    for _ in 0..60 {
        const SMALL: f64 = 1e-6;
        let (mut matrix, mut right) = ([[0.0; 7]; 7], [0.0; 7]);
        for pair in pairs {
            let Some(now) = px(pair, &pose) else { continue };
            let off = pair.px - now;
            let weight = 1.0 / (1.0 + (off.length() / SOFT_PX).powi(2)).sqrt();
            let row: [DVec2; 7] = std::array::from_fn(|i| {
                let mut by = [0.0; 7];
                by[i] = SMALL;
                px(pair, &moved(&pose, by)).map_or(DVec2::ZERO, |px| (px - now) / SMALL)
            });
            for i in 0..7 {
                right[i] += weight * row[i].dot(off);
                for j in 0..7 {
                    matrix[i][j] += weight * row[i].dot(row[j]);
                }
            }
        }
        // What no pair holds, such as the scale in a single photo, stays as it is.
        let usual = (0..7).map(|i| matrix[i][i]).sum::<f64>() / 7.0;
        (0..7).for_each(|i| matrix[i][i] += damping * (matrix[i][i] + 1e-6 * usual));
        let Some(by) = solve(matrix, right) else { break };
        let next = moved(&pose, by);
        let found = cost(pairs, cameras, &next);
        if found < best {
            let gain = best - found;
            (pose, best, damping) = (next, found, (damping * 0.3).max(1e-9));
            if gain < 1e-9 * (1.0 + best) {
                break;
            }
        } else if damping > 1e9 {
            break;
        } else {
            damping *= 10.0;
        }
    }
    (best, pose)
}
