//! What a score says, by photo, on average, and by object.

use std::path::PathBuf;

use serde::Serialize;

use crate::error::Error;
use crate::projection::likeness::{Likeness, Tally};
use crate::scene::Model;

/// All of it.
#[derive(Debug, Default, Serialize)]
pub struct ScoreReport {
    /// In the order of the questions.
    pub views: Vec<ViewScore>,
    /// None without a view.
    pub mean: Option<MeanScore>,
    /// Those that are seen in some view, the largest share of the error first.
    pub objects: Vec<ObjectScore>,
    /// Photos that could not be compared, with the reason.
    #[serde(skip)]
    pub failed: Vec<(String, Error)>,
}

/// One photo.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ViewScore {
    /// Its name.
    pub photo: String,
    /// Size at which it was compared, in pixels.
    pub width: u32,
    /// See `width`.
    pub height: u32,
    /// Share of the pixels that were predicted, 0..1.
    pub coverage: f64,
    /// Over these; none where there is none.
    pub covered: Option<Likeness>,
    /// Over all pixels, black where nothing was predicted.
    pub with_holes: Likeness,
    /// Photo, prediction and difference side by side.
    pub picture: Option<PathBuf>,
}

/// Means over photos, each counting the same.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeanScore {
    /// Photos.
    pub views: usize,
    /// As [`ViewScore::coverage`].
    pub coverage: f64,
    /// Over photos with covered pixels; none where there is no such photo.
    pub covered: Option<MeanLikeness>,
    /// As [`ViewScore::with_holes`].
    pub with_holes: MeanLikeness,
}

/// Means of a [`Likeness`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeanLikeness {
    /// In dB.
    pub psnr: f64,
    /// In dB.
    pub psnr_fitted: f64,
    /// Over photos that have one.
    pub ssim: Option<f64>,
}

/// One object, over all views.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObjectScore {
    /// Its name; none for pixels that show no surface of the model.
    pub object: Option<String>,
    /// Pixels that were predicted.
    pub pixels: u64,
    /// Pixels that were not.
    pub holes: u64,
    /// Of the predicted pixels, in dB.
    pub psnr: Option<f64>,
    /// Share of the squared error of all predicted pixels, 0..1.
    pub error_share: f64,
}

impl MeanScore {
    /// Of some views; none without any.
    pub fn of(views: &[ViewScore]) -> Option<Self> {
        let covered: Vec<Likeness> = views.iter().filter_map(|view| view.covered).collect();
        let with_holes: Vec<Likeness> = views.iter().map(|view| view.with_holes).collect();
        let coverage = mean(views.iter().map(|view| view.coverage))?;
        let covered = MeanLikeness::of(&covered);
        let with_holes = MeanLikeness::of(&with_holes)?;
        Some(Self { views: views.len(), coverage, covered, with_holes })
    }
}

impl MeanLikeness {
    fn of(list: &[Likeness]) -> Option<Self> {
        Some(Self {
            psnr: mean(list.iter().map(|likeness| likeness.psnr))?,
            psnr_fitted: mean(list.iter().map(|likeness| likeness.psnr_fitted))?,
            ssim: mean(list.iter().filter_map(|likeness| likeness.ssim)),
        })
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0u32), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// From tallies by object, the last one of the background.
pub(super) fn objects(model: &Model, tallies: &[Tally]) -> Vec<ObjectScore> {
    let all: u64 = tallies.iter().map(|tally| tally.squared_error).sum();
    let score = |(object, tally): (usize, &Tally)| ObjectScore {
        object: model.objects.get(object).map(|object| object.name.clone()),
        pixels: tally.covered,
        holes: tally.holes,
        psnr: tally.psnr(),
        error_share: if all > 0 { tally.squared_error as f64 / all as f64 } else { 0.0 },
    };
    let seen = tallies.iter().enumerate().filter(|(_, tally)| tally.covered + tally.holes > 0);
    let mut objects: Vec<ObjectScore> = seen.map(score).collect();
    // The sort is stable: ties stay in the model's order.
    objects.sort_by(|a, b| b.error_share.total_cmp(&a.error_share).then(b.holes.cmp(&a.holes)));
    objects
}
