//! Photos predicted from the other photos over the suggested faces, to judge a face by what is predicted with and without it.

use glam::DVec2;
use rayon::prelude::*;

use quadratura_base::error::Result;
use quadratura_base::task::Task;

use super::face::NormalisedFace;
use super::support::middle;
use super::view::{Warp, WorkingPhoto};

/// The stage that is reported.
const STAGE: &str = "predict photos";
/// Photos from which a pixel is predicted.
const BLENDED: usize = 4;
/// Photos that are asked, best first.
const ASKED: usize = 12;
/// Photos in which a face is judged.
const JUDGED: usize = 6;
/// A surface is the one that another photo shows when their depths differ by less than this share.
const SAME: f64 = 0.02;
/// The squared error that counts in full, per channel of 255: more is a difference of things, not of places.
const MOST_ERROR: f64 = 60.0 * 60.0;
/// The squared error of a pixel that no other photo serves, and that has to be invented.
const UNSERVED: f64 = 40.0 * 40.0;
/// A face is dropped when it multiplies the squared error by more than this. Six photos are few: of faces between this and 1, which were
/// dropped first, most helped photos that were held out.
pub const HARM: f64 = 1.1;
/// What is added to a model has to help: of a wall that runs on into the sky nothing is seen.
pub const HARM_OF_ADDED: f64 = 0.97;
/// A face is too small below this share of all pixels of the photos.
const LEAST_SHARE: f64 = 2e-4;

/// The given model's place in lists of faces.
const GIVEN: u16 = u16::MAX;

/// What a judgement of a face found.
#[derive(Debug, Clone, Copy, Default)]
pub struct Judgement {
    /// Pixels at which the face is nearest.
    pub pixels: usize,
    /// Pixels that are predicted both with it and without it.
    pub compared: usize,
    /// The sum of the squared errors with the face.
    pub with: f64,
    /// The sum without it.
    pub without: f64,
}

impl Judgement {
    /// Returns by how much the root mean square error is lower with the face, of 255; `None` where nothing was compared.
    pub fn gain(&self) -> Option<f64> {
        let count = self.compared as f64;
        (self.compared > 0).then(|| (self.without / count).sqrt() - (self.with / count).sqrt())
    }

    /// Adds what was found elsewhere.
    pub fn and(self, other: &Self) -> Self {
        Self {
            pixels: self.pixels + other.pixels,
            compared: self.compared + other.compared,
            with: self.with + other.with,
            without: self.without + other.without,
        }
    }
}

/// The faces that cover the pixels of a photo.
struct FaceCoverage {
    first: Vec<u32>,
    entries: Vec<CoverageEntry>,
}

#[derive(Clone, Copy)]
struct CoverageEntry {
    face: u16,
    inverse: f32,
    next: u32,
}

const END: u32 = u32::MAX;

impl FaceCoverage {
    fn new(view: &WorkingPhoto, faces: &[NormalisedFace], given: Option<&[f32]>) -> Self {
        let mut coverage = Self { first: vec![END; view.known.len()], entries: Vec::new() };
        for (number, face) in (0..).zip(faces) {
            face.pixels(view, |pixel, inverse| coverage.add(pixel, number, inverse as f32));
        }
        for (pixel, inverse) in given.into_iter().flatten().enumerate().filter(|(_, inverse)| **inverse > 0.0)
        {
            coverage.add(pixel, GIVEN, *inverse);
        }
        coverage
    }

    fn add(&mut self, pixel: usize, face: u16, inverse: f32) {
        self.entries.push(CoverageEntry { face, inverse, next: self.first[pixel] });
        self.first[pixel] = (self.entries.len() - 1) as u32;
    }

    /// Returns the nearest face at a pixel and its inverse depth.
    #[inline]
    fn nearest(&self, pixel: usize, is_there: impl Fn(u16) -> bool) -> Option<(u16, f32)> {
        let mut best: Option<(u16, f32)> = None;
        let mut at = self.first[pixel];
        while at != END {
            let entry = self.entries[at as usize];
            if best.is_none_or(|(_, inverse)| entry.inverse > inverse) && is_there(entry.face) {
                best = Some((entry.face, entry.inverse));
            }
            at = entry.next;
        }
        best
    }
}

/// The photos with the faces that cover them.
pub struct Predictor<'a> {
    views: &'a [WorkingPhoto],
    coverage: Vec<FaceCoverage>,
    /// Of each photo the others that are asked.
    others: Vec<Vec<(usize, Warp)>>,
    is_there: Vec<bool>,
}

impl<'a> Predictor<'a> {
    /// Prepares the prediction; `given` is the inverse depth of a model that stays.
    pub fn new(
        views: &'a [WorkingPhoto],
        near: &[Vec<u32>],
        faces: &[NormalisedFace],
        given: Option<&[Vec<f32>]>,
    ) -> Self {
        let coverage = views
            .par_iter()
            .enumerate()
            .map(|(i, view)| FaceCoverage::new(view, faces, given.map(|given| given[i].as_slice())))
            .collect();
        let asked = |i: usize| {
            let warp = |other: &u32| {
                let other = *other as usize;
                let to = (views[other].camera(), &views[other].pose);
                (other, Warp::new((views[i].camera(), &views[i].pose), to))
            };
            near[i].iter().take(ASKED).map(warp).collect()
        };
        let others = (0..views.len()).map(asked).collect();
        Self { views, coverage, others, is_there: vec![true; faces.len()] }
    }

    fn is_there(&self, face: u16, without: Option<u16>) -> bool {
        face == GIVEN || (Some(face) != without && self.is_there[usize::from(face)])
    }

    /// Drops faces that hardly show, and those that multiply the squared error by more than `harm`, small ones first. Returns which
    /// stay, and what was found about each.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`] on request.
    pub fn useful(
        &mut self,
        faces: &[NormalisedFace],
        harm: f64,
        task: &Task,
    ) -> Result<(Vec<bool>, Vec<Judgement>)> {
        let pixels: usize = self.views.iter().map(|view| view.known.len()).sum();
        let mut order: Vec<(usize, usize)> =
            (0..faces.len()).map(|face| (self.shown(face as u16).iter().sum(), face)).collect();
        order.sort_unstable();
        let mut judgements = vec![Judgement::default(); faces.len()];
        for (done, (_, face)) in order.into_iter().enumerate() {
            task.step(STAGE, done as u64, faces.len() as u64)?;
            let judgement = self.judged(face as u16);
            let is_small = (judgement.pixels as f64) < LEAST_SHARE * pixels as f64;
            let harms = judgement.compared == 0 || judgement.with > harm * judgement.without;
            if is_small || harms {
                self.is_there[face] = false;
            }
            judgements[face] = judgement;
        }
        Ok((self.is_there.clone(), judgements))
    }

    /// Returns the mean squared error of all photos, each predicted from the others over the faces that stay.
    pub fn error(&self) -> f64 {
        let of_photo = |of: usize| {
            let (view, coverage) = (&self.views[of], &self.coverage[of]);
            let known = (0..view.known.len()).filter(|pixel| view.known[*pixel]);
            let off = |pixel: usize| {
                let nearest =
                    coverage.nearest(pixel, |f| self.is_there(f, None)).map_or(0.0, |(_, inverse)| inverse);
                self.predicted(of, pixel, nearest, None)
                    .map_or(UNSERVED, |colour| error(colour, view.colours[pixel]))
            };
            known.fold((0.0, 0usize), |sum, pixel| (sum.0 + off(pixel), sum.1 + 1))
        };
        let each: Vec<(f64, usize)> = (0..self.views.len()).into_par_iter().map(of_photo).collect();
        let (sum, count) = each.into_iter().fold((0.0, 0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
        sum / count.max(1) as f64
    }

    /// Returns the number of pixels of each photo at which a face is nearest.
    fn shown(&self, face: u16) -> Vec<usize> {
        let count = |coverage: &FaceCoverage| {
            let nearest = |pixel| coverage.nearest(pixel, |f| self.is_there(f, None));
            (0..coverage.first.len()).filter(|pixel| nearest(*pixel).is_some_and(|(f, _)| f == face)).count()
        };
        self.coverage.par_iter().map(count).collect()
    }

    /// Predicts the photos that show a face most, with it and without it.
    fn judged(&self, face: u16) -> Judgement {
        let shown = self.shown(face);
        let mut of: Vec<usize> = (0..shown.len()).filter(|i| shown[*i] > 0).collect();
        of.sort_by_key(|i| std::cmp::Reverse(shown[*i]));
        of.truncate(JUDGED);
        let each: Vec<Judgement> = of.par_iter().map(|of| self.judged_in(*of, face)).collect();
        let start = Judgement { pixels: shown.iter().sum(), ..Judgement::default() };
        each.iter().fold(start, Judgement::and)
    }

    fn judged_in(&self, of: usize, face: u16) -> Judgement {
        let (view, coverage) = (&self.views[of], &self.coverage[of]);
        let mut judgement = Judgement::default();
        for pixel in (0..view.known.len()).filter(|pixel| view.known[*pixel]) {
            let Some((nearest, inverse)) = coverage.nearest(pixel, |f| self.is_there(f, None)) else {
                continue;
            };
            if nearest != face {
                continue;
            }
            let behind = coverage.nearest(pixel, |f| self.is_there(f, Some(face)));
            let with = self.predicted(of, pixel, inverse, None);
            let without = self.predicted(of, pixel, behind.map_or(0.0, |(_, inverse)| inverse), Some(face));
            // Pixels that no other photo serves in either case say nothing.
            if with.is_none() && without.is_none() {
                continue;
            }
            let shown = view.colours[pixel];
            let off = |predicted: Option<[f64; 3]>| predicted.map_or(UNSERVED, |colour| error(colour, shown));
            judgement.compared += 1;
            judgement.with += off(with);
            judgement.without += off(without);
        }
        judgement
    }

    /// Predicts a pixel from other photos that show the same surface, those of the nearest directions.
    fn predicted(&self, of: usize, pixel: usize, inverse: f32, without: Option<u16>) -> Option<[f64; 3]> {
        let view = &self.views[of];
        let (w, inverse) = (view.size()[0], f64::from(inverse));
        let px = middle(pixel % w, pixel / w);
        let point = (inverse > 0.0).then(|| view.eye + view.ray(px) / inverse);
        let mut found: Vec<(f64, [f64; 3])> = Vec::with_capacity(ASKED);
        for (other, warp) in &self.others[of] {
            let (target, coverage) = (&self.views[*other], &self.coverage[*other]);
            let Some((at, scale)) = warp.with_scale(px, inverse) else { continue };
            if !target.camera().rect().contains_position(at) {
                continue;
            }
            let index = target.index(at);
            let nearest = coverage.nearest(index, |f| self.is_there(f, without));
            let there = nearest.map_or(0.0, |(_, inverse)| f64::from(inverse));
            let is_same =
                if inverse > 0.0 { (there * scale / inverse - 1.0).abs() < SAME } else { nearest.is_none() };
            if is_same && target.known[index] {
                let angle = point.map_or(0.0, |p| (view.eye - p).angle_between(target.eye - p));
                found.push((angle, colour(target, at)));
            }
        }
        if point.is_some() {
            found.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        found.truncate(BLENDED);
        let weight = |angle: f64| 1.0 / (angle + 0.03);
        let total: f64 = found.iter().map(|(angle, _)| weight(*angle)).sum();
        (!found.is_empty()).then(|| {
            [0, 1, 2].map(|c| found.iter().map(|(angle, rgb)| weight(*angle) * rgb[c]).sum::<f64>() / total)
        })
    }
}

fn error(predicted: [f64; 3], shown: [f32; 3]) -> f64 {
    let square = |c: usize| (predicted[c] - f64::from(shown[c])).powi(2).min(MOST_ERROR);
    (square(0) + square(1) + square(2)) / 3.0
}

/// Interpolates the colour of a photo.
fn colour(view: &WorkingPhoto, at: DVec2) -> [f64; 3] {
    use quadratura_base::raster::bilinear::Clamped;
    let (w, taps) = (view.size()[0], Clamped::new(at, view.size()).taps());
    [0, 1, 2].map(|c| taps.iter().map(|(x, y, weight)| f64::from(weight * view.colours[y * w + x][c])).sum())
}
