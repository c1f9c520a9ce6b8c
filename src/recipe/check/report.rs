//! What a check found, as a program reads it (`--json`).

use std::path::PathBuf;

use serde::Serialize;

use crate::scene::{FaceId, Model};

/// Names that a list gives; its count says how many there are.
pub(super) const NAMED: usize = 100;

/// Does the model stand where the photos are?
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Yes.
    Fits,
    /// Partly: too much of it is missing, or it is moved or turned.
    Poor,
    /// No.
    Misses,
}

/// The result of [`super::check_site`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CheckReport {
    /// Does the model stand where the photos are?
    pub verdict: Verdict,
    /// Share of the sightings of sparse points at which the model is first met within 1 % of the
    /// distance; none where there are too few sightings to tell.
    pub agreement: Option<f64>,
    /// Median over the photos of the share of pixels that the model covers.
    pub covered: f64,
    /// A transform that does better, where the model does not fit.
    pub suggestion: Option<Suggestion>,
    /// In the site's order.
    pub photos: Vec<PhotoReport>,
    /// The model's faces.
    pub faces: FaceReport,
}

/// A transform that does better.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Suggestion {
    /// The value for `--model-transform`.
    pub transform: String,
    /// The agreement that it reaches, where it was judged by points.
    pub agreement: Option<f64>,
    /// Otherwise: the share of the photos that it covers.
    pub covered: Option<f64>,
    /// Without points, transforms that do nearly as well: look at the pictures.
    pub alternatives: Vec<String>,
}

/// What one photo sees.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhotoReport {
    /// Its unique name.
    pub name: String,
    /// Share of the model's vertices in front of the camera.
    pub in_front: f64,
    /// Share of the model's vertices within the photo.
    pub inside: f64,
    /// Share of the photo that the model covers.
    pub covered: f64,
    /// Faces that are visible at one pixel at least.
    pub faces: usize,
    /// The photo with the model's edges over it.
    pub picture: Option<PathBuf>,
    /// Why there is no picture.
    pub problem: Option<String>,
}

/// What is wrong with faces, and what is worth knowing about them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceReport {
    /// Faces of the model.
    pub count: usize,
    /// Without area: they get no texture.
    pub degenerate: Names,
    /// Treated triangle by triangle.
    pub not_planar: Names,
    /// The same corners in the same order as an earlier face.
    pub duplicate: Names,
    /// Seen from behind by most photos that see them; not billboards, nor walls with two sides. Empty where the model misses the photos.
    pub flipped: Names,
    /// Seen by no photo. Empty where the model misses the photos.
    pub unseen: Names,
    /// Pairs of faces that run through each other.
    pub crossing_pairs: usize,
    /// There are so many overlapping faces that the search was given up.
    pub crossing_gave_up: bool,
    /// The deepest of them.
    pub crossing: Vec<Crossing>,
}

/// How many, and the first hundred by name.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Names {
    /// How many there are.
    pub count: usize,
    /// `object[index]`, in model order.
    pub names: Vec<String>,
}

impl Names {
    pub(super) fn of(model: &Model, faces: impl Iterator<Item = FaceId>) -> Self {
        let faces: Vec<FaceId> = faces.collect();
        let names = faces.iter().take(NAMED).map(|&face| model.face_name(face)).collect();
        Self { count: faces.len(), names }
    }
}

/// Two faces that run through each other.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Crossing {
    /// Their names, in model order.
    pub faces: [String; 2],
    /// How far, in world units.
    pub depth: f64,
}

impl Crossing {
    pub(super) fn of(model: &Model, pair: [FaceId; 2], depth: f64) -> Self {
        Self { faces: pair.map(|face| model.face_name(face)), depth }
    }
}
