//! Tests the alignment of the model with the photos, and searches a better one.
//!
//! The criterion is the sparse points. A ray from a camera to a point observed in its photo has to hit the model
//! first at that point; a wall in front of it, or no surface at all, is a mismatch. The tolerance is relative to
//! the ray's length, so that neither a huge nor a tiny model has an advantage.
//!
//! The search goes through the 24 axis conventions. For each, scale and shift are fitted to the points by iterative
//! closest points (robustly weighted) from several starts: the present transform, scales between common units, and
//! the size of the points relative to the model's.

use glam::{DMat3, DMat4, DVec3, DVec4};
use rayon::prelude::*;

use quadratura_base::error::Result;
use quadratura_base::geometry::bvh::Bvh;
use quadratura_base::geometry::{Similarity, axes};
use quadratura_base::raster::robust::upper_median;
use quadratura_base::task::Task;

/// An observation: a camera sees a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// The camera centre, in the world.
    pub eye: DVec3,
    /// The point, in the world.
    pub point: DVec3,
}

/// A correction of the model's transform, with its quality.
#[derive(Debug, Clone, PartialEq)]
pub struct Alignment {
    /// The transform from the world as the model is placed now to where it should be.
    pub correction: Similarity,
    /// The share of observations that match after the correction.
    pub agreement: f64,
}

/// An observation matches when the ray hits the model within this share of its length from the point: 20 cm at 20
/// m, the detail that a coarse model leaves out.
const AGREEMENT: f64 = 0.01;

/// Returns the share of observations that match the model moved by `correction`; 0 when there are none.
pub fn agreement(tree: &Bvh, correction: &Similarity, sightings: &[Observation]) -> f64 {
    let back = correction.inverse();
    let agrees = |sighting: &&Observation| {
        let eye = back.apply(sighting.eye);
        let ray = back.apply(sighting.point) - eye;
        tree.first_hit(eye, ray, 1.0 + 2.0 * AGREEMENT).is_some_and(|(t, _)| (t - 1.0).abs() <= AGREEMENT)
    };
    sightings.iter().filter(agrees).count() as f64 / sightings.len().max(1) as f64
}

/// The largest plausible ratio between the sizes of model and points, either way: the model may be a town around
/// photos of a square, or a statue in photos of that square. Beyond this ratio, a single face is enlarged until it
/// lies under all points, or the model becomes a speck among them.
const TIMES_LARGER: f64 = 30.0;

/// Returns true when the model, moved by `correction`, has a size and position similar to the points'. Without this
/// test, almost any model can be stretched until it matches some of the points.
pub fn is_plausible(tree: &Bvh, correction: &Similarity, sightings: &[Observation]) -> bool {
    if tree.triangles().is_empty() || sightings.is_empty() {
        return false;
    }
    let model = PointSpread::from_points(tree.triangles().iter().flatten().copied());
    let points = PointSpread::from_points(sightings.iter().map(|sighting| sighting.point));
    let size = correction.scale * model.size;
    let away = correction.apply(model.middle).distance(points.middle);
    let like = (points.size / TIMES_LARGER..=points.size * TIMES_LARGER).contains(&size);
    like && away <= size.max(points.size)
}

/// The effort of a stage of the search: the numbers of observations and of fitting steps.
struct Effort {
    sightings: usize,
    steps: usize,
}

/// The effort for every start of a convention.
const FIRST: Effort = Effort { sightings: 100, steps: 8 };
const SECOND: Effort = Effort { sightings: 300, steps: 10 };
const LAST: Effort = Effort { sightings: 3000, steps: 30 };

/// The number of starts of a convention that reach the second stage.
const SEEDED: usize = 8;

/// The number of conventions that reach the last stage.
const FINALISTS: usize = 4;

/// Returns the best alignment over all axis conventions; `None` without observations or triangles. The result is
/// deterministic.
///
/// # Errors
/// Returns [`quadratura_base::Error::Cancelled`] on request.
pub fn best_alignment(tree: &Bvh, sightings: &[Observation], task: &Task) -> Result<Option<Alignment>> {
    if tree.triangles().is_empty() || sightings.is_empty() {
        return Ok(None);
    }
    let model = PointSpread::from_points(tree.triangles().iter().flatten().copied());
    let rough = axes::conventions().into_par_iter().map(|(_, rotation)| {
        task.check_cancelled()?;
        Ok(fit_convention(tree, rotation, sightings, &model))
    });
    let mut rough: Vec<Alignment> = rough.collect::<Result<_>>()?;
    rough.sort_by(|a, b| b.agreement.total_cmp(&a.agreement));
    rough.truncate(FINALISTS);
    let many = sample(sightings, LAST.sightings);
    let polished = rough.into_par_iter().map(|alignment| {
        task.check_cancelled()?;
        let start = alignment.correction;
        let fine = fitted(tree, start, &many, LAST.steps, Scale::Free);
        let whole = fitted(tree, in_whole_units(&fine, &many), &many, LAST.steps, Scale::Kept);
        Ok(best(tree, [unmoved_if_near(&fine, &many), whole, fine, start].into_iter(), &many))
    });
    let polished: Vec<Alignment> = polished.collect::<Result<_>>()?;
    Ok(polished.into_iter().reduce(|best, next| if next.agreement > best.agreement { next } else { best }))
}

/// Fits scale and shift for one rotation: a short fit from every start, and a longer one from those that came
/// closest.
fn fit_convention(tree: &Bvh, rotation: DMat3, sightings: &[Observation], model: &PointSpread) -> Alignment {
    let (few, more) = (sample(sightings, FIRST.sightings), sample(sightings, SECOND.sightings));
    let short = |start| {
        let fitted = fitted(tree, start, &few, FIRST.steps, Scale::Free);
        (closeness(tree, &fitted, &few), start, fitted)
    };
    let mut seeded: Vec<_> = starts(rotation, &more, model).into_iter().map(short).collect();
    seeded.sort_by(|a, b| b.0.total_cmp(&a.0));
    let seeded = different(seeded, PointSpread::from_points(more.iter().map(|s| s.point)));
    let candidates = seeded.into_iter().flat_map(|(_, start, near)| {
        // The start itself may be exact and need no fit.
        [start, fitted(tree, near, &more, SECOND.steps, Scale::Free)]
    });
    best(tree, candidates, &more)
}

/// Returns the first [`SEEDED`] seeds whose short fits did not converge to an earlier one's.
fn different(
    seeded: Vec<(f64, Similarity, Similarity)>,
    spread: PointSpread,
) -> Vec<(f64, Similarity, Similarity)> {
    let mut kept: Vec<(f64, Similarity, Similarity)> = Vec::new();
    for seed in seeded {
        let known = kept.iter().any(|(_, _, other)| {
            let apart = seed.2.apply(other.inverse().apply(spread.middle)).distance(spread.middle);
            (seed.2.scale / other.scale - 1.0).abs() < 2.0 * NEARLY && apart < 2.0 * NEARLY * spread.size
        });
        if !known && kept.len() < SEEDED {
            kept.push(seed);
        }
    }
    kept
}

/// Returns a sum over the points of their closeness to the model: 1 on it, 0 from a twentieth of their ray's length
/// on.
fn closeness(tree: &Bvh, correction: &Similarity, sightings: &[Observation]) -> f64 {
    let back = correction.inverse();
    let of = |sighting: &Observation| {
        let (eye, point) = (back.apply(sighting.eye), back.apply(sighting.point));
        let distance = tree.nearest(point).map_or(f64::INFINITY, |(_, foot)| foot.distance(point));
        (1.0 - distance / (0.05 * eye.distance(point))).max(0.0)
    };
    sightings.iter().map(of).sum()
}

/// Returns the candidate with the highest agreement. An earlier candidate wins unless a later one is clearly
/// better, so that round numbers are not replaced by a fit that gains nothing.
fn best(tree: &Bvh, candidates: impl Iterator<Item = Similarity>, sightings: &[Observation]) -> Alignment {
    let judged = |correction| Alignment { correction, agreement: agreement(tree, &correction, sightings) };
    let clearly = |a: &Alignment, b: &Alignment| b.agreement > a.agreement + 0.01;
    let best = candidates.map(judged).reduce(|best, next| if clearly(&best, &next) { next } else { best });
    best.expect("every convention has a start")
}

/// Returns the fit with its scale rounded to the ratio of two units where it is close: a model in centimetres is
/// smaller by exactly 100, not by 99.8. Whether it fits as well is found by the caller, after the shift was fitted again.
fn in_whole_units(fine: &Similarity, sightings: &[Observation]) -> Similarity {
    let near = |unit: &f64| (fine.scale / unit - 1.0).abs() < ROUNDED;
    let Some(scale) = UNITS.into_iter().chain([1.0]).find(near) else { return *fine };
    let middle = PointSpread::from_points(sightings.iter().map(|s| s.point)).middle;
    let middle_in_model = fine.inverse().apply(middle);
    Similarity { scale, translation: middle - fine.rotation * (middle_in_model * scale), ..*fine }
}

/// Returns the rotation alone where the fitted scale and shift are negligible.
fn unmoved_if_near(fine: &Similarity, sightings: &[Observation]) -> Similarity {
    let bare = Similarity { rotation: fine.rotation, ..Similarity::IDENTITY };
    let spread = PointSpread::from_points(sightings.iter().map(|s| s.point));
    let moved = bare.inverse().apply(spread.middle).distance(fine.inverse().apply(spread.middle));
    let near = (fine.scale - 1.0).abs() < NEARLY && moved < NEARLY * spread.size;
    if near { bare } else { *fine }
}

/// The relative distance to a ratio of units from which the ratio is tried. Points stand before coarse facades, and
/// draw a free scale by some percent.
const ROUNDED: f64 = 0.05;

/// The relative error that a fit to a coarse model may have.
const NEARLY: f64 = 0.01;

/// Selects every n-th observation, so that about `count` are left.
fn sample(sightings: &[Observation], count: usize) -> Vec<Observation> {
    sightings.iter().step_by(sightings.len().div_ceil(count).max(1)).copied().collect()
}

/// The location and size of a point set, robust against a sky dome or outliers.
struct PointSpread {
    middle: DVec3,
    /// The diagonal of the box between the first and last deciles along each axis.
    size: f64,
}

impl PointSpread {
    fn from_points(points: impl Iterator<Item = DVec3>) -> Self {
        let mut points: Vec<DVec3> = points.collect();
        let (mut middle, mut extent) = (DVec3::ZERO, DVec3::ZERO);
        for axis in 0..3 {
            points.sort_unstable_by(|a, b| a[axis].total_cmp(&b[axis]));
            let at = |share: f64| points[((points.len() - 1) as f64 * share) as usize][axis];
            middle[axis] = at(0.5);
            extent[axis] = at(0.9) - at(0.1);
        }
        Self { middle, size: extent.length() }
    }
}

/// World units per model unit for commonly confused units: inches, feet, millimetres, centimetres, metres,
/// kilometres.
const UNITS: [f64; 8] = [0.001, 0.01, 0.0254, 0.3048, 1.0 / 0.3048, 1.0 / 0.0254, 100.0, 1000.0];

/// Factors by which the ratio of the sizes is varied as a start, because it may be off either way.
const GUESSES: [f64; 9] = [0.4, 0.55, 0.7, 0.85, 1.0, 1.2, 1.45, 1.8, 2.4];

/// Returns the starting transforms for one rotation.
fn starts(rotation: DMat3, sightings: &[Observation], model: &PointSpread) -> Vec<Similarity> {
    let bare = Similarity { rotation, ..Similarity::IDENTITY };
    let points = PointSpread::from_points(sightings.iter().map(|s| s.point));
    let middles_met = |scale: f64| Similarity {
        scale,
        rotation,
        translation: points.middle - rotation * (model.middle * scale),
    };
    let guess = points.size / model.size;
    let mut starts = vec![bare, middles_met(1.0)];
    starts.extend(UNITS.map(|scale| Similarity { scale, ..bare }));
    if guess.is_finite() && guess > 0.0 {
        starts.extend(GUESSES.map(|factor| middles_met(guess * factor)));
    }
    starts
}

/// Whether a fit changes the scale.
#[derive(Clone, Copy, PartialEq)]
enum Scale {
    Free,
    Kept,
}

/// Fits scale and shift in several steps to the points' closest points on the model; the rotation is kept.
fn fitted(
    tree: &Bvh,
    start: Similarity,
    sightings: &[Observation],
    steps: usize,
    scale: Scale,
) -> Similarity {
    let mut current = start;
    let spread = PointSpread::from_points(sightings.iter().map(|s| s.point));
    for _ in 0..steps {
        let Some(next) = step(tree, &current, sightings, &spread, scale) else { return current };
        current = next;
    }
    current
}

/// Distances beyond this share of the points' size lose weight: objects that are not modelled (trees, people,
/// neighbouring houses) should have little influence, except where nothing else constrains a direction.
const NEAR: f64 = 0.005;

/// Makes one Gauss-Newton step on the distances between the model and the points, transformed to its frame as `u
/// (R^T (x - m)) + s` with the unknowns u and s and Cauchy weights. `None` where the step fails.
fn step(
    tree: &Bvh,
    current: &Similarity,
    sightings: &[Observation],
    spread: &PointSpread,
    scale: Scale,
) -> Option<Similarity> {
    let back = current.inverse();
    let residual = |sighting: &Observation| {
        let point = back.apply(sighting.point);
        let (_, foot) = tree.nearest(point)?;
        let away = point - foot;
        Some((away.length(), away.normalize_or_zero(), back.rotation * (sighting.point - spread.middle)))
    };
    let residuals: Vec<_> = sightings.iter().filter_map(residual).collect();
    let mut distances: Vec<f64> = residuals.iter().map(|r| r.0).collect();
    let near = upper_median(&mut distances)?.max(NEAR * spread.size * back.scale);
    let (mut matrix, mut right) = (DMat4::ZERO, DVec4::ZERO);
    for (distance, gradient, from_middle) in &residuals {
        let weight = 1.0 / (1.0 + (distance / near).powi(2));
        let grows = if scale == Scale::Free { gradient.dot(*from_middle) / spread.size } else { 0.0 };
        let row = gradient.extend(grows);
        matrix += DMat4::from_cols(row * row.x, row * row.y, row * row.z, row * row.w) * weight;
        right -= row * (weight * distance);
    }
    // A direction that no face constrains stays unchanged.
    let stiffness = DMat4::from_diagonal(DVec4::splat(1e-4 * residuals.len() as f64));
    let solution = (matrix + stiffness).inverse() * right;
    let growth = (solution.w / spread.size / back.scale).clamp(-0.3, 0.3);
    moved(&back, spread.middle, growth, solution.truncate())
}

/// Returns the inverse of `back` after scaling it around the middle and shifting it; `None` where that is not
/// finite.
fn moved(back: &Similarity, middle: DVec3, growth: f64, shift: DVec3) -> Option<Similarity> {
    let scale = back.scale * (1.0 + growth);
    let middle_in_model = back.apply(middle) + shift;
    let translation = middle_in_model - back.rotation * (middle * scale);
    let moved = Similarity { scale, rotation: back.rotation, translation };
    (scale.is_finite() && translation.is_finite()).then(|| moved.inverse())
}
