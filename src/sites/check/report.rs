//! The report of a check, as written by `--json`.

use std::path::PathBuf;

use serde::Serialize;

use super::alignment::SearchOutcome;
use super::unexplained::Unexplained;
use quadratura_base::scene::{FaceId, Model};

/// The number of names that a list contains at most; its count is always complete.
pub(super) const NAMED: usize = 100;

/// The verdict whether the model is aligned with the photos.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The model is aligned.
    Fits,
    /// The model is partly aligned: much of it is missing, or it is moved or rotated.
    Poor,
    /// The model is not aligned.
    Misses,
}

/// The result of [`super::check_site`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CheckReport {
    /// The verdict whether the model is aligned with the photos.
    pub verdict: Verdict,
    /// The share of sparse-point observations at which the model is hit first within 1 % of the distance; `None`
    /// where there are too few observations.
    pub agreement: Option<f64>,
    /// The median over the photos of the share of pixels that the model covers.
    pub covered: f64,
    /// A better transform, where the model is not aligned.
    pub suggestion: Option<AlignmentSuggestion>,
    /// How the search for it by the sparse points ended; `None` where the model is aligned, or there are no points.
    pub search: Option<SearchOutcome>,
    /// The photos, in the site's order.
    pub photos: Vec<PhotoReport>,
    /// The model's faces.
    pub faces: FaceReport,
    /// The distances between sparse points and the faces nearest to them, by object, the largest first. It is empty
    /// where the model is not aligned.
    pub distances: Vec<ObjectDistances>,
    /// The sparse points that no face explains; `None` where the model is not aligned, or too few points can be judged.
    pub unexplained: Option<Unexplained>,
}

/// The distances of sparse points from the faces of the object that is nearest to them, in world units. Points that are
/// far from every face belong to something that is not modelled and do not count.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObjectDistances {
    /// The object's unique name.
    pub object: String,
    /// The number of points.
    pub points: usize,
    /// The median distance.
    pub median: f64,
    /// The distance that 95 % of the points do not exceed.
    pub most: f64,
    /// The largest distance.
    pub largest: f64,
}

/// A transform that aligns the model better.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AlignmentSuggestion {
    /// The value for `--model-transform`.
    pub transform: String,
    /// The agreement that it achieves, where it was judged by points.
    pub agreement: Option<f64>,
    /// The share of the photos that the model covers with it, where there are no points.
    pub covered: Option<f64>,
    /// Transforms that do nearly as well, the best one first; the pictures show which is right.
    pub alternatives: Vec<AlternativeTransform>,
}

/// Another transform that aligns the model nearly as well.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AlternativeTransform {
    /// The value for `--model-transform`.
    pub transform: String,
    /// The agreement that it achieves, where it was judged by points.
    pub agreement: Option<f64>,
    /// The share of the photos that the model covers with it, where there are no points.
    pub covered: Option<f64>,
}

/// The model as seen by one photo.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhotoReport {
    /// The photo's unique name.
    pub name: String,
    /// The share of the model's vertices in front of the camera.
    pub in_front: f64,
    /// The share of the model's vertices within the photo.
    pub inside: f64,
    /// The share of the photo that the model covers.
    pub covered: f64,
    /// The number of faces that are visible at one pixel or more.
    pub faces: usize,
    /// The picture of the photo with the model's edges.
    pub picture: Option<PathBuf>,
    /// The reason why there is no picture.
    pub problem: Option<String>,
}

/// Defects and properties of the model's faces.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceReport {
    /// The number of faces of the model.
    pub count: usize,
    /// Faces without area, which get no texture.
    pub degenerate: Names,
    /// Non-planar faces, which are treated triangle by triangle.
    pub not_planar: Names,
    /// Faces with the same corners in the same order as an earlier face.
    pub duplicate: Names,
    /// Faces that the photos show from behind at more pixels than from the front, except billboards and walls with two sides. It is empty where the
    /// model is not aligned.
    pub flipped: Names,
    /// Faces that no photo sees. It is empty where the model is not aligned.
    pub unseen: Names,
    /// Faces that an impostor of another object crosses when it turns towards cameras.
    pub turning: Names,
    /// The number of pairs of intersecting faces, without [`Self::sunk_pairs`].
    pub crossing_pairs: usize,
    /// The number of pairs of faces of which one ends behind the other where no photo shows it, as a wall does that is
    /// sunk into the ground.
    pub sunk_pairs: usize,
    /// Whether the search was abandoned because too many faces overlap.
    pub crossing_gave_up: bool,
    /// The deepest intersections.
    pub crossing: Vec<Intersection>,
}

/// A count of faces, with the names of the first hundred.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Names {
    /// The number of faces.
    pub count: usize,
    /// The names as `object[index]`, in model order.
    pub names: Vec<String>,
}

impl Names {
    /// Counts and names faces.
    pub(super) fn new(model: &Model, faces: impl Iterator<Item = FaceId>) -> Self {
        let faces: Vec<FaceId> = faces.collect();
        let names = faces.iter().take(NAMED).map(|&face| model.face_name(face)).collect();
        Self { count: faces.len(), names }
    }
}

/// A pair of intersecting faces.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Intersection {
    /// The names of the faces, in model order.
    pub faces: [String; 2],
    /// The depth of the intersection, in world units.
    pub depth: f64,
}

impl Intersection {
    /// Names a pair of faces.
    pub(super) fn new(model: &Model, pair: [FaceId; 2], depth: f64) -> Self {
        Self { faces: pair.map(|face| model.face_name(face)), depth }
    }
}
