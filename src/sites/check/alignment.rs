//! Tests the alignment of the model with the photos, and searches a better one.
//!
//! The criterion is the sparse points. A ray from a camera to a point observed in its photo has to hit the model
//! first at that point; a wall in front of it, or no surface at all, is a mismatch. The tolerance is relative to
//! the ray's length, so that neither a huge nor a tiny model has an advantage.
//!
//! [`quadratura_align`] searches any similarity. Here its result is rounded to what is likely: an axis convention, the
//! ratio of two units, no shift.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use serde::Serialize;

use quadratura_align::refine::Free;
use quadratura_align::{Aligner, AlignmentAnswer, AlignmentCandidate, Unsearchable};
use quadratura_base::error::Result;
use quadratura_base::geometry::bvh::Bvh;
use quadratura_base::geometry::{Similarity, axes};
use quadratura_base::scene::{Model, Site, SparsePoint};
use quadratura_base::task::Task;

/// An observation: a camera sees a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// The camera centre, in the world.
    pub eye: DVec3,
    /// The point, in the world.
    pub point: DVec3,
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

/// How a search for a better alignment ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SearchOutcome {
    /// One transform aligns the model far better than every other.
    Found,
    /// Several transforms do nearly as well: the site is symmetric, or the model has too few faces.
    Several,
    /// The model is where it belongs as far as the points can tell.
    Kept,
    /// No transform explains more points than a model of another site does.
    Foreign,
    /// As mirrored, the model would be found: its axes are left-handed.
    Mirrored,
    /// The model has no face with an area that is part of the site.
    #[serde(rename = "no faces")]
    NoFaces,
    /// Too few sparse points are seen by a photo.
    #[serde(rename = "few points")]
    FewPoints,
    /// The sparse points lie on no planes.
    #[serde(rename = "no planes")]
    NoPlanes,
}

/// The most transforms that a search offers.
const OFFERED: usize = 4;

/// The score that a present or rounded transform may lack: models are coarse, so that the points draw even an exact one
/// a little. Where exact transforms are known, others had up to 0.034 more.
const DRAWN: f64 = 0.04;

/// Searches corrections of the model's place in the world, the best one first, and says how the search ended. There are
/// corrections only where it found some.
///
/// # Errors
/// Returns [`quadratura_base::Error::Cancelled`] on request.
pub fn best_alignments(
    site: &Site,
    points: &[SparsePoint],
    task: &Task,
) -> Result<(SearchOutcome, Vec<Similarity>)> {
    let cameras: Vec<_> = site.photos.iter().map(|photo| (photo.camera, photo.pose)).collect();
    let aligner = match Aligner::new(&site.model, &cameras, points) {
        Ok(aligner) => aligner,
        Err(reason) => return Ok((unsearched(reason), Vec::new())),
    };
    let (answer, found) = aligner.search(task)?;
    let now = aligner.judge(&Similarity::IDENTITY).score;
    let best = found.first().map_or(0.0, |best| best.score);
    match answer {
        AlignmentAnswer::Foreign => {
            let mirrored = Aligner::new(&mirrored(&site.model), &cameras, points);
            let answer = mirrored.ok().map(|aligner| aligner.search(task)).transpose()?;
            let is_mirrored = answer.is_some_and(|(answer, _)| answer == AlignmentAnswer::Aligned);
            Ok((if is_mirrored { SearchOutcome::Mirrored } else { SearchOutcome::Foreign }, Vec::new()))
        }
        _ if now >= best - DRAWN => Ok((SearchOutcome::Kept, Vec::new())),
        AlignmentAnswer::Aligned => Ok((SearchOutcome::Found, vec![rounded(&aligner, &found[0])])),
        AlignmentAnswer::Several => {
            let near =
                found.iter().take(OFFERED).filter(|it| it.score * quadratura_align::CLEAR_RATIO > best);
            Ok((SearchOutcome::Several, near.map(|found| rounded(&aligner, found)).collect()))
        }
    }
}

fn unsearched(reason: Unsearchable) -> SearchOutcome {
    match reason {
        Unsearchable::NoFaces => SearchOutcome::NoFaces,
        Unsearchable::FewPoints => SearchOutcome::FewPoints,
        Unsearchable::NoPlanes => SearchOutcome::NoPlanes,
    }
}

/// Returns the model as a mirror shows it.
fn mirrored(model: &Arc<Model>) -> Model {
    let mut model = Model::clone(model);
    model.vertices.iter_mut().for_each(|vertex| vertex.x = -vertex.x);
    model
}

/// World units per model unit for commonly confused units: inches, feet, millimetres, centimetres, metres,
/// kilometres.
const UNITS: [f64; 9] = [1.0, 0.001, 0.01, 0.0254, 0.3048, 1.0 / 0.3048, 1.0 / 0.0254, 100.0, 1000.0];

/// The relative distance to a ratio of units from which the ratio is tried.
const ROUNDED: f64 = 0.02;

/// The turn, in radians, from which an axis convention is tried.
const CONVENTIONAL: f64 = 0.02;

/// Returns the roundest correction that explains the points as well as the one that was found: a model in centimetres is
/// smaller by exactly 100, not by 99.8.
fn rounded(aligner: &Aligner, found: &AlignmentCandidate) -> Similarity {
    let exact = found.world_from_model;
    let near = |rotation: &DMat3| turn(rotation, &exact.rotation) < CONVENTIONAL;
    let Some(rotation) = axes::conventions().into_iter().map(|(_, rotation)| rotation).find(near) else {
        return exact;
    };
    // About the points' middle, so that the shift stays small.
    let middle = aligner.points.origin;
    let in_model = exact.inverse().apply(middle);
    let with =
        |scale: f64| Similarity { scale, rotation, translation: middle - rotation * (in_model * scale) };
    let is_good = |candidate: &AlignmentCandidate| candidate.score >= found.score - DRAWN;
    let unit = UNITS.into_iter().find(|unit| (exact.scale / unit - 1.0).abs() < ROUNDED);
    let bare = unit.map(|scale| aligner.judge(&Similarity { scale, rotation, translation: DVec3::ZERO }));
    let shifted = || unit.map(|scale| aligner.fitted(&with(scale), Free::Shift));
    let scaled = || Some(aligner.fitted(&with(exact.scale), Free::ScaleAndShift));
    let rounded =
        bare.filter(is_good).or_else(|| shifted().filter(is_good)).or_else(|| scaled().filter(is_good));
    rounded.map_or(exact, |candidate| candidate.world_from_model)
}

/// Returns the angle between two rotations.
fn turn(a: &DMat3, b: &DMat3) -> f64 {
    let between = *a * b.transpose();
    (0.5 * (between.x_axis.x + between.y_axis.y + between.z_axis.z - 1.0)).clamp(-1.0, 1.0).acos()
}
