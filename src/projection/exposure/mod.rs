//! Exposure: the brightness of each photo relative to a common exposure.
//!
//! Photos of one site differ by shutter, aperture and white balance, that is, by a factor per channel in
//! linear light. Its natural logarithm is the *gain*. Gains are estimated from small patches around surface
//! points that two photos or more show ([`points`]), the ratios of their mean colours ([`ratios`]), and the
//! gains that explain these best, robustly ([`solve`]). The photos do *not* tell how bright the site was:
//! gains are relative, 0 on average.
//!
//! What cameras wrote down about their exposures is a prior ([`camera`]), where it agrees with what the points say. Clipped pixels
//! take no part, and no gain turns them grey ([`white`]).
//!
//! A view has an exposure, too: a blend of the photos' gains by their part in the view ([`seen`]), corrected
//! by the difference between what the view's exposure meter would read and what the photos' meters read
//! ([`meter`]). A view from a photo's own camera has the photo's exposure ([`view`]). Which rule suits a site is decided by leaving
//! out whole photos ([`rule`], [`whole`]). Photos of several rounds are in groups of light ([`groups`], [`grouping`]).
//!
//! Panoramas are equalised in the same way (Brown & Lowe, *Automatic Panoramic Image Stitching using
//! Invariant Features*, 2007, section 6); there the overlaps are whole images, here single points.

pub mod camera;
pub mod estimate;
mod fit;
pub mod gain_support;
pub mod gains;
pub mod grouping;
pub mod groups;
mod left_out;
pub mod light;
pub mod measured;
pub mod meter;
pub mod near;
pub mod optics;
pub mod options;
pub mod patch;
pub mod points;
pub mod ratios;
pub mod rule;
pub mod seen;
pub mod solve;
pub mod surface_gains;
pub mod surroundings;
pub mod view;
pub mod white;
pub mod whole;

pub use camera::CameraExposures;
pub use estimate::Estimate;
pub use gain_support::{GainSupport, gain_support};
pub use gains::Gains;
pub use grouping::GroupSupport;
pub use groups::LightGroups;
pub use light::SiteLight;
pub use measured::MeasuredColours;
pub use meter::Meter;
pub use near::Shares;
pub use optics::solve_optics;
pub use options::{ExposureOptions, Vignetting};
pub use patch::{MeanColour, PatchColour};
pub use points::{
    PointPatch, RayVisibility, SharedPoint, SpreadPoint, Visibility, shared_points, spread_points,
};
pub use ratios::{Ratio, pairwise_ratios};
pub use rule::{ExposureRule, Lead, RuleScore};
pub use seen::{resolution, shares_of_view, visible_shares};
pub use solve::{GainFit, solve_gains, solve_in_groups};
pub use surface_gains::{JoinedFaces, SurfaceFactors, SurfaceGains};
pub use surroundings::{SurroundingsExposure, SurroundingsGains};
pub use view::ViewExposure;
pub use white::kept_white;
pub use whole::PhotoPlace;

use self::estimate::best_psnr;
use self::fit::{Corrected, corrected, fitted};
use self::grouping::GroupingEvidence;
use super::Projector;
use quadratura_base::scene::PhotoId;

/// Estimates the gains of `photos` from measured colours. The photos in `left_out` have no influence: everything is as
/// if the site did not have them, and their own gains are 0. `groups` are the groups of light, which are found where
/// there are none.
pub fn estimate_gains(
    photos: &[Projector],
    measured: &MeasuredColours,
    left_out: &[PhotoId],
    groups: Option<&LightGroups>,
    options: &ExposureOptions,
) -> Estimate {
    let kept: Vec<PhotoId> = PhotoId::all(photos.len()).filter(|photo| !left_out.contains(photo)).collect();
    if kept.len() == photos.len() {
        return with_groups(photos, measured, groups.cloned(), options);
    }
    let subset: Vec<Projector> = kept.iter().map(|photo| photos[photo.index()].clone()).collect();
    let groups = groups.map(|groups| groups.of_photos(&kept));
    with_groups(&subset, &measured.of_photos(&kept), groups, options).among(&kept, photos.len())
}

/// Finds the groups of light unless they are decided, and estimates all else.
fn with_groups(
    photos: &[Projector],
    measured: &MeasuredColours,
    decided: Option<LightGroups>,
    options: &ExposureOptions,
) -> Estimate {
    let (found, support) = found_groups(photos, measured, options);
    let groups = decided.unwrap_or(found);
    let mut estimate = with_rule(photos, measured, &groups, options);
    if !groups.is_one() {
        estimate.decide_leaning(with_rule(photos, measured, &LightGroups::default(), options));
    }
    Estimate { group_support: support, ..estimate }
}

/// Finds the groups of light, and what speaks for them.
fn found_groups(
    photos: &[Projector],
    measured: &MeasuredColours,
    options: &ExposureOptions,
) -> (LightGroups, GroupSupport) {
    let Corrected { colours, ratios, .. } = corrected(photos, measured, options);
    GroupingEvidence { photos, points: &measured.points, colours: &colours, ratios: &ratios }.groups()
}

/// Estimates gains, and decides on the rule of exposure, and on vignetting where that is to be decided.
fn with_rule(
    photos: &[Projector],
    measured: &MeasuredColours,
    groups: &LightGroups,
    options: &ExposureOptions,
) -> Estimate {
    if options.vignetting != Vignetting::Kept {
        return scored(photos, measured, groups, options);
    }
    let ignoring = ExposureOptions { vignetting: Vignetting::Ignored, ..*options };
    let mut ignored = scored(photos, measured, groups, &ignoring);
    if !fitted(photos, measured, groups, options).gains.has_vignetting() {
        return ignored;
    }
    let mut kept = scored(photos, measured, groups, options);
    let lead = best_psnr(&kept).zip(best_psnr(&ignored)).map(|(kept, ignored)| kept - ignored);
    (kept.vignetting_lead, ignored.vignetting_lead) = (lead, lead);
    if lead.is_some_and(|lead| lead > rule::CLEAR_DB) { kept } else { ignored }
}

/// Estimates gains, and decides on the rule of exposure.
fn scored(
    photos: &[Projector],
    measured: &MeasuredColours,
    groups: &LightGroups,
    options: &ExposureOptions,
) -> Estimate {
    let mut estimate = fitted(photos, measured, groups, options);
    let scores = left_out::rule_scores(photos, measured, groups, options);
    estimate.surfaces_lead = scores.surfaces_lead;
    estimate.left_out_psnr = scores.of_photos;
    if !estimate.surfaces_lead.is_some_and(|lead| lead.is_clear()) {
        estimate.gains.light.surfaces = SurfaceGains::default();
    }
    estimate.rules = scores.rules;
    estimate.gains.rule = rule::best_rule(&estimate.rules);
    estimate.camera_lead = rule::camera_lead(&scores.by_camera, estimate.gains.rule);
    estimate.gains.camera.suits_views = estimate.camera_lead.is_some_and(|lead| lead >= 0.0);
    estimate
}

#[cfg(test)]
mod tests;
