//! Photos are left out and predicted from the others, which tells the rule of exposure that suits a site.
//!
//! Photos of one site that were exposed by their cameras differ with the place; photos that were exposed by hand, or
//! developed together, do not; and photos of several rounds differ without any rule. Which of these a site is, its photos
//! tell: each is left out in turn, the gains are estimated from the others, and the whole photo, on a grid of places, is
//! predicted from theirs as views are drawn, once by each rule. Common points alone would flatter gains: there colours are compared
//! where they can be compared best. Whether views lean to the groups of light that they show most of is decided at
//! common points, in the same way. Nothing is known of a photo that is left out but its camera, as of a view: not its group
//! either.

use glam::DVec2;
use rayon::prelude::*;

use super::estimate::Estimate;
use super::fit::fitted;
use super::groups::LightGroups;
use super::measured::MeasuredColours;
use super::near::Shares;
use super::options::ExposureOptions;
use super::patch::{MeanColour, PatchColour};
use super::points::{PointPatch, penalties_of};
use super::rule::{ExposureRule, Lead, RuleScore};
use super::surface_gains::{SurfaceFactors, SurfaceGains};
use super::white::kept_white;
use crate::Projector;
use quadratura_base::raster::robust::quantile;
use quadratura_base::scene::light::srgb_from_linear;
use quadratura_base::scene::{FaceId, PhotoId};
use quadratura_view::optics::{squared_radius, squared_tangent};
use quadratura_view::weights::weights;
use quadratura_view::{Blend, Exposure};

/// The largest number of photos that are left out in turn; more hardly change the mean, and each costs an estimate.
const MOST_LEFT_OUT: usize = 24;
/// The least number of compared points of a photo: fewer may all lie on one thing that moved.
const FEWEST_POINTS: usize = 20;

/// What leaving photos out says of a site.
#[derive(Debug, Default)]
pub(super) struct RuleScores {
    /// The scores of all rules, in the order of [`ExposureRule::ALL`]; empty where no photo can be left out.
    pub rules: Vec<RuleScore>,
    /// The same at common points for each photo that was left out.
    pub of_photos: Vec<[f64; 4]>,
    /// For each photo that was left out and whose camera wrote down its exposure: the PSNR in that exposure, and by each rule.
    pub by_camera: Vec<(f64, [f64; 4])>,
    /// The lead of gains per surface in the light of the photos' own groups; `None` where all photos are one group.
    pub surfaces_lead: Option<Lead>,
}

/// Scores the rules by leaving photos out. Where there are several groups, views lean.
pub(super) fn rule_scores(
    photos: &[Projector],
    measured: &MeasuredColours,
    groups: &LightGroups,
    options: &ExposureOptions,
) -> RuleScores {
    let count = photos.len().min(MOST_LEFT_OUT);
    let left_out: Vec<PhotoId> = (0..count).map(|k| PhotoId::new(k * photos.len() / count)).collect();
    let of_photos: Vec<PhotoScores> = left_out
        .into_par_iter()
        .filter_map(|photo| scores_of_photo(photos, measured, photo, groups, options))
        .collect();
    if of_photos.is_empty() {
        return RuleScores::default();
    }
    let mean =
        |rule: usize| of_photos.iter().map(|photo| photo.whole[rule]).sum::<f64>() / of_photos.len() as f64;
    let rules = ExposureRule::ALL.into_iter().enumerate();
    let leads: Vec<f64> = of_photos.iter().filter_map(|photo| photo.surfaces_lead).collect();
    RuleScores {
        rules: rules.map(|(i, rule)| RuleScore { rule, psnr: mean(i) }).collect(),
        surfaces_lead: Lead::of(&leads),
        by_camera: of_photos.iter().filter_map(|photo| Some((photo.by_camera?, photo.whole))).collect(),
        of_photos: of_photos.into_iter().map(|photo| photo.at_points).collect(),
    }
}

/// How well one photo that is left out is predicted.
struct PhotoScores {
    /// The PSNR of the whole photo by each rule.
    whole: [f64; 4],
    /// The same at common points.
    at_points: [f64; 4],
    /// The PSNR of the whole photo in the exposure that its camera wrote down.
    by_camera: Option<f64>,
    /// The lead of gains per surface in the light of its group, where the others show something of that.
    surfaces_lead: Option<f64>,
}

/// Predicts a photo from the others; `None` where it has too few points in common with them.
fn scores_of_photo(
    photos: &[Projector],
    measured: &MeasuredColours,
    photo: PhotoId,
    groups: &LightGroups,
    options: &ExposureOptions,
) -> Option<PhotoScores> {
    let predicted = PredictedPoints::at_points(photos, measured, photo);
    if predicted.points.len() < FEWEST_POINTS {
        return None;
    }
    let whole = PredictedPoints::all_over(photos, measured, photo);
    let kept: Vec<PhotoId> = PhotoId::all(photos.len()).filter(|other| *other != photo).collect();
    let others: Vec<Projector> = kept.iter().map(|photo| photos[photo.index()].clone()).collect();
    let estimate = fitted(&others, &measured.of_photos(&kept), &groups.of_photos(&kept), options)
        .among(&kept, photos.len());
    let by_rules = |predicted: &PredictedPoints| {
        ExposureRule::ALL.map(|rule| predicted.psnr(rule.exposure(), &estimate, photos))
    };
    if groups.is_one() {
        let log = measured.camera_logs[photo.index()].filter(|_| estimate.gains.camera.used() > 0);
        let by_camera = log.map(|log| whole.psnr(Exposure::AsTaken(log), &estimate, photos));
        let (whole, at_points) = (by_rules(&whole), by_rules(&predicted));
        return Some(PhotoScores { whole, at_points, by_camera, surfaces_lead: None });
    }
    let surfaces = &estimate.gains.light.surfaces;
    let parts = groups.parts(&predicted.shares.of_photo);
    let mut own = vec![0.0; parts.len()];
    own[groups.of(photo)] = parts[groups.of(photo)];
    let surfaces_lead = own.iter().any(|part| *part > 0.0).then(|| {
        let mut own_light = predicted.clone().leaned(groups, &own, None);
        let without = own_light.psnr(Exposure::Near, &estimate, photos);
        let shares = LightGroups::exposure_shares(&own).unwrap_or_default();
        own_light.surfaces = surfaces.towards(&shares, groups);
        own_light.psnr(Exposure::Near, &estimate, photos) - without
    });
    let leaned = |points: PredictedPoints| by_rules(&points.leaned(groups, &parts, Some(surfaces)));
    let (whole, at_points) = (leaned(whole), leaned(predicted));
    Some(PhotoScores { whole, at_points, by_camera: None, surfaces_lead })
}

/// The points on the grid of a photo that is left out, with the photos that predict them.
#[derive(Clone)]
struct PredictedPoints {
    photo: PhotoId,
    points: Vec<PredictedPoint>,
    shares: Shares,
    surfaces: SurfaceFactors,
    /// The share of the points whose errors count.
    counted: f64,
}

#[derive(Clone)]
struct PredictedPoint {
    /// The face; `None` for surroundings.
    face: Option<FaceId>,
    /// The position in the photo that is left out, and its colour there.
    px: DVec2,
    truth: [f64; 3],
    /// The other photos' patches, with their colours and weights.
    others: Vec<(PointPatch, MeanColour, f64)>,
    /// The penalties of these patches.
    penalties: Vec<f64>,
}

impl PredictedPoint {
    /// Weights the patches again after their penalties were multiplied by these factors of photos.
    fn lean(&mut self, leaning: &[f64]) {
        let factor = |(patch, ..): &(PointPatch, MeanColour, f64)| leaning[patch.photo.index()];
        let leaned: Vec<f64> =
            self.penalties.iter().zip(&self.others).map(|(q, other)| q * factor(other)).collect();
        let weights = weights(&leaned, &Blend::default());
        self.others.iter_mut().zip(weights).for_each(|((.., share), weight)| *share = weight);
    }
}

impl PredictedPoints {
    /// Returns the common points of the photo, without the tenth with the largest errors.
    fn at_points(photos: &[Projector], measured: &MeasuredColours, photo: PhotoId) -> Self {
        let points = measured.points.iter().zip(&measured.colours).filter(|(point, _)| point.own == photo);
        let predicted = points.filter_map(|(point, colours)| {
            predicted_point(photos, photo, Some(point.face), &point.patches, colours)
        });
        Self::new(photos, photo, predicted.collect(), KEPT)
    }

    /// Returns the places all over the photo.
    fn all_over(photos: &[Projector], measured: &MeasuredColours, photo: PhotoId) -> Self {
        let places =
            measured.places.iter().zip(&measured.place_colours).filter(|(place, _)| place.own == photo);
        let predicted = places.filter_map(|(place, colours)| {
            predicted_point(photos, photo, place.face, &place.patches, colours)
        });
        Self::new(photos, photo, predicted.collect(), 1.0)
    }

    fn new(photos: &[Projector], photo: PhotoId, points: Vec<PredictedPoint>, counted: f64) -> Self {
        let mut of_photo = vec![0.0; photos.len()];
        for (patch, _, weight) in points.iter().flat_map(|point| &point.others) {
            of_photo[patch.photo.index()] += weight / points.len() as f64;
        }
        let takes_part = PhotoId::all(photos.len()).map(|other| other != photo).collect();
        let shares = Shares { of_photo, of_common: 0.0, takes_part };
        Self { photo, points, shares, surfaces: SurfaceFactors::default(), counted }
    }

    /// Leans to the groups of light that have these parts, and brings the photos of others over by surface.
    fn leaned(mut self, groups: &LightGroups, parts: &[f64], surfaces: Option<&SurfaceGains>) -> Self {
        let leaning = groups.leaning(parts, self.shares.of_photo.len());
        self.points.iter_mut().for_each(|point| point.lean(&leaning));
        self.shares = self.shares.leaned(groups, parts);
        let shares = LightGroups::exposure_shares(parts);
        if let Some((surfaces, shares)) = surfaces.zip(shares) {
            self.surfaces = surfaces.towards(&shares, groups);
        }
        self
    }

    /// Computes the PSNR of the colours predicted in an exposure.
    fn psnr(&self, exposure: Exposure, estimate: &Estimate, photos: &[Projector]) -> f64 {
        let gains = &estimate.gains;
        let pose = &photos[self.photo.index()].pose;
        let view = match exposure {
            Exposure::Metered => gains.metered(pose, &self.shares),
            Exposure::Common => gains.common(&self.shares),
            Exposure::AsTaken(log) => gains.as_taken(log, &self.shares),
            Exposure::Raw => [0.0; 3],
            _ => gains.of_view(pose, &self.shares),
        };
        let is_raw = exposure == Exposure::Raw;
        let lens = gains.lens(photos, &self.shares);
        let camera = &photos[self.photo.index()].camera;
        let colour = |point: &PredictedPoint, (patch, colour, weight): &(PointPatch, MeanColour, f64)| {
            if is_raw {
                return colour.mean.map(|light| weight * light);
            }
            let i = patch.photo.index();
            let r2 = squared_radius(&photos[i].camera, patch.center_px);
            let light = gains.optics[i].undone(colour.mean, r2);
            let on_face = point.face.map_or([1.0; 3], |face| self.surfaces.of(face, patch.photo));
            let lens = lens.factor(squared_tangent(camera, point.px));
            let factor = |c: usize| lens * on_face[c] * (view[c] - gains.of_photo[i][c]).exp();
            let exposed = [0, 1, 2].map(|c| light[c] * factor(c));
            kept_white(colour.mean, exposed).map(|light| weight * light)
        };
        let error = |point: &PredictedPoint| {
            let blended = point
                .others
                .iter()
                .map(|other| colour(point, other))
                .fold([0.0; 3], |sum, light| [0, 1, 2].map(|c| sum[c] + light[c]));
            let off = |c: usize| srgb_from_linear(blended[c].min(1.0)) - srgb_from_linear(point.truth[c]);
            (0..3).map(|c| off(c).powi(2)).sum::<f64>() / 3.0
        };
        let errors: Vec<f64> = self.points.iter().map(error).collect();
        let Some(largest) = quantile(&mut errors.clone(), self.counted) else { return 0.0 };
        let kept = || errors.iter().filter(|error| **error <= largest);
        let mean = kept().sum::<f64>() / kept().count() as f64;
        -10.0 * mean.max(LEAST_ERROR).log10()
    }
}

/// The share of common points whose errors count: the others are where the model is wrong or something moved.
const KEPT: f64 = 0.9;
/// The least mean squared error, that of rounding to 8 bits.
const LEAST_ERROR: f64 = 1.0 / (12.0 * 255.0 * 255.0);

/// Weights the photos that predict a point as a renderer does; `None` where none does, or the colour is unknown.
fn predicted_point(
    photos: &[Projector],
    photo: PhotoId,
    face: Option<FaceId>,
    patches: &[PointPatch],
    colours: &[PatchColour],
) -> Option<PredictedPoint> {
    let measured = || patches.iter().zip(colours).filter_map(|(patch, colour)| Some((*patch, (*colour)?)));
    let (own, truth) = measured().find(|(patch, _)| patch.photo == photo)?;
    let others: Vec<(PointPatch, MeanColour)> =
        measured().filter(|(patch, _)| patch.photo != photo).collect();
    let blend = Blend::default();
    let penalties = penalties_of(photos, &own, others.iter().map(|(patch, _)| patch), &blend);
    let weights = weights(&penalties, &blend);
    if weights.iter().all(|weight| *weight <= 0.0) {
        return None;
    }
    let others = others.into_iter().zip(weights).map(|((patch, colour), weight)| (patch, colour, weight));
    let px = own.center_px;
    Some(PredictedPoint { face, px, truth: truth.mean, others: others.collect(), penalties })
}
