//! Lays a coarse polygon model on the sparse points of calibrated photos by a similarity: any turn, scale and shift.
//!
//! A model of a survey is level and metric, the world of structure from motion is neither. One plane of the points is laid on
//! one plane of the model, which leaves the turn within the plane, the scale and two shifts; these are searched in
//! full. Poses are judged along rays: an observer has to see the model first where it sees the point. Then the pose is
//! fitted to the points. This package knows points, cameras and faces, and neither files nor devices.
//!
//! | modules | contents |
//! |---|---|
//! | [`linear`] | eigenvectors, systems of equations |
//! | [`surface`], `planes`, [`points`] | what is aligned: the model's planes and regions; the points, their observers and planes |
//! | `directions`, `heights` | the search over one plane of the points and one of the model |
//! | [`score`], [`refine`] | what a pose is worth, and how it is fitted |
//! | [`find`] | the search over all planes |
//! | [`horn`], [`centres`], [`pairs`] | the transform from places, from cameras in common, and from corners that a person points out in photos |
//!
//! A module uses only modules of its own row and of rows above it in this table.

pub mod centres;
mod directions;
pub mod find;
mod heights;
pub mod horn;
pub mod linear;
pub mod pairs;
mod planes;
pub mod points;
pub mod refine;
pub mod score;
pub mod surface;
#[cfg(test)]
mod tests;

use quadratura_base::error::Result;
use quadratura_base::geometry::{Pinhole, Pose, Similarity};
use quadratura_base::scene::{Model, SparsePoint};
use quadratura_base::task::Task;

use find::{FoundPose, JudgingRays, search};
use points::Points;
use refine::{Free, refined};
use surface::NormalisedModel;

/// What is aligned, in the form that the search uses. Build it once and ask it several times.
pub struct Aligner {
    /// The model.
    pub surface: NormalisedModel,
    /// The points.
    pub points: Points,
    samples: JudgingRays,
}

/// Why nothing is searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unsearchable {
    /// The model has no face with an area that is part of the site.
    NoFaces,
    /// Fewer points than [`points::FEWEST`] are seen by a camera.
    FewPoints,
    /// The points have no plane in common.
    NoPlanes,
}

/// A transform of the model, and how well it explains the points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlignmentCandidate {
    /// From the model's coordinates to the cameras' world.
    pub world_from_model: Similarity,
    /// The weighted share of sparse points at which cameras see the model first, where no region of the model counts for
    /// more than [`score::MOST_PER_REGION`]. From some 0.13 on a pose is no chance.
    pub score: f64,
}

/// The answer of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AlignmentAnswer {
    /// The first candidate is far better than every other.
    Aligned,
    /// Several candidates do nearly as well: the site is symmetric, or the model has too few faces.
    Several,
    /// No candidate explains more than a model of another site does.
    Foreign,
}

/// The least score of a candidate that is no chance. True poses have 0.138 and more, models of other sites 0.111 and less, but
/// sometimes 0.188; the ratio to the second candidate decides then.
pub const LEAST_SCORE: f64 = 0.13;

/// The score from which a model that is not symmetric is offered in several places. Foreign models with two such places had up
/// to 0.188.
pub const STRONG_SCORE: f64 = 0.2;

/// How many times the second candidate's score the first one has at least when it alone is right.
pub const CLEAR_RATIO: f64 = 1.4;

impl Aligner {
    /// Prepares the search.
    ///
    /// # Errors
    /// Says why there is nothing to search.
    pub fn new(
        model: &Model,
        cameras: &[(Pinhole, Pose)],
        points: &[SparsePoint],
    ) -> std::result::Result<Self, Unsearchable> {
        let surface = NormalisedModel::new(model).ok_or(Unsearchable::NoFaces)?;
        let points = Points::new(cameras, points).ok_or(Unsearchable::FewPoints)?;
        if points.planes.is_empty() {
            return Err(Unsearchable::NoPlanes);
        }
        let samples = JudgingRays::new(&points);
        Ok(Self { surface, points, samples })
    }

    /// Searches the transforms of the model that explain the points best, the best one first; at most six.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`] on request.
    pub fn search(&self, task: &Task) -> Result<(AlignmentAnswer, Vec<AlignmentCandidate>)> {
        let found = search(&self.surface, &self.points, &self.samples, task)?;
        let answer = self.answer(&found);
        Ok((answer, found.iter().map(|found| self.candidate(found)).collect()))
    }

    /// Fits a transform to the points near which the model is already, and judges it.
    pub fn fitted(&self, world_from_model: &Similarity, free: Free) -> AlignmentCandidate {
        let start = self.inward(world_from_model);
        let pose = refined(&self.surface, &self.samples.polish, &start, 8, [0.012, 0.004], free);
        self.candidate(&self.samples.judged(&self.surface, pose))
    }

    /// Judges a transform as the search does.
    pub fn judge(&self, world_from_model: &Similarity) -> AlignmentCandidate {
        let pose = self.inward(world_from_model);
        let found = self.samples.judged(&self.surface, pose);
        AlignmentCandidate { world_from_model: *world_from_model, score: found.worth.capped }
    }

    fn candidate(&self, found: &FoundPose) -> AlignmentCandidate {
        AlignmentCandidate { world_from_model: self.outward(&found.pose), score: found.worth.capped }
    }

    /// From normalised coordinates of the points to the world, and of the model to its own.
    fn frames(&self) -> (Similarity, Similarity) {
        let frame = |scale: f64, translation| Similarity { scale, translation, ..Similarity::IDENTITY };
        (frame(self.points.unit, self.points.origin), frame(self.surface.radius, self.surface.origin))
    }

    fn outward(&self, pose: &Similarity) -> Similarity {
        let (world, model) = self.frames();
        world.compose(pose).compose(&model.inverse())
    }

    fn inward(&self, world_from_model: &Similarity) -> Similarity {
        let (world, model) = self.frames();
        world.inverse().compose(world_from_model).compose(&model)
    }

    /// Decides by the best score and its ratio to the second one.
    fn answer(&self, found: &[FoundPose]) -> AlignmentAnswer {
        let Some(best) = found.first() else { return AlignmentAnswer::Foreign };
        // A model of few regions cannot reach the score, so it has to explain most points.
        let few = self.surface.region_count < FEW_REGIONS;
        let is_chance = if few { best.worth.plain < MOST_POINTS } else { best.worth.capped < LEAST_SCORE };
        let second = found.get(1);
        let is_clear = second.is_none_or(|second| best.worth.capped >= CLEAR_RATIO * second.worth.capped);
        // Where several do as well, the model is symmetric, or explains more than foreign ones do.
        let is_strong = || few || best.worth.capped >= STRONG_SCORE;
        let is_symmetric =
            || second.is_some_and(|second| self.surface.repeats(&best.pose.inverse().compose(&second.pose)));
        match is_chance {
            false if is_clear => AlignmentAnswer::Aligned,
            false if is_strong() || is_symmetric() => AlignmentAnswer::Several,
            _ => AlignmentAnswer::Foreign,
        }
    }
}

/// Fewer regions than these are few.
const FEW_REGIONS: usize = 8;

/// The share of points that a model of few regions explains where it belongs.
const MOST_POINTS: f64 = 0.6;
