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
//! ([`meter`]). A view from a photo's own camera has the photo's exposure. Which rule suits a site is decided by leaving out whole
//! photos ([`rule`], [`whole`]).
//!
//! Panoramas are equalised in the same way (Brown & Lowe, *Automatic Panoramic Image Stitching using
//! Invariant Features*, 2007, section 6); there the overlaps are whole images, here single points.

pub mod camera;
pub mod gain_support;
pub mod groups;
pub mod light;
pub mod measured;
pub mod meter;
pub mod near;
pub mod optics;
pub mod patch;
pub mod points;
pub mod ratios;
pub mod rule;
pub mod seen;
pub mod solve;
pub mod surface_gains;
pub mod surroundings;
pub mod white;
pub mod whole;

pub use camera::CameraExposures;
pub use gain_support::{GainSupport, gain_support};
pub use groups::{GroupSupport, LightGroups};
pub use light::SiteLight;
pub use measured::MeasuredColours;
pub use meter::Meter;
pub use near::{Shares, ViewExposure};
pub use optics::solve_optics;
pub use points::{
    PointPatch, RayVisibility, SharedPoint, SpreadPoint, Visibility, shared_points, spread_points,
};
pub use ratios::{Ratio, pairwise_ratios};
pub use rule::{ExposureRule, Lead, RuleScore};
pub use seen::{resolution, shares_of_view, visible_shares};
pub use solve::{GainFit, solve_gains, solve_in_groups};
pub use surface_gains::{JoinedFaces, SurfaceFactors, SurfaceGains};
pub use surroundings::{SurroundingsExposure, SurroundingsGains};
pub use white::kept_white;
pub use whole::PhotoPlace;

use std::borrow::Cow;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use self::camera::fit_with_cameras;
use self::groups::Evidence;
use self::points::typical_distance;
use self::solve::median_residual;
use super::Projector;
use quadratura_base::scene::PhotoId;
use quadratura_view::optics::Optics;

/// The photos' gains, their optics, and the model of exposure metering.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Gains {
    /// The gain of each photo, in the order of [`super::Sources::photos`]: natural logarithm of photo /
    /// common exposure in linear light, per channel R, G, B.
    pub of_photo: Vec<[f64; 3]>,
    /// The vignetting and offset of each photo; neutral where they were not estimated.
    pub optics: Vec<Optics>,
    /// The model that predicts a view's exposure, where the photos' exposures followed their meters; empty where each group
    /// of light has its own.
    pub meter: Meter,
    /// The rule by which views are exposed.
    #[serde(default)]
    pub rule: ExposureRule,
    /// The groups of light; empty for one group.
    #[serde(default)]
    pub light: SiteLight,
    /// Whether views are darkened towards their corners as the photos' lenses darken photos.
    #[serde(default)]
    pub keeps_vignetting: bool,
    /// The exposures that cameras wrote down.
    #[serde(default)]
    pub camera: CameraExposures,
    /// The gains of the surroundings, which are estimated after all others.
    #[serde(skip)]
    pub surroundings: Arc<SurroundingsGains>,
}

impl Gains {
    /// Returns gains of 0 and neutral optics, which leave all photos unchanged.
    pub fn none(photo_count: usize) -> Self {
        let optics = vec![Optics::default(); photo_count];
        let of_photo = vec![[0.0; 3]; photo_count];
        Self {
            of_photo,
            optics,
            meter: Meter::default(),
            rule: ExposureRule::default(),
            light: SiteLight::default(),
            keeps_vignetting: false,
            camera: CameraExposures::default(),
            surroundings: Arc::default(),
        }
    }

    /// Returns the group of a photo.
    pub fn group(&self, photo: PhotoId) -> usize {
        self.light.groups.of(photo)
    }

    /// Returns how closely exposures followed their meters, R, G, B, 0 to 1; the mean over groups of light.
    pub fn follows(&self) -> [f64; 3] {
        let meters = &self.light.meters;
        let mean = |c: usize| meters.iter().map(|meter| meter.follows[c]).sum::<f64>() / meters.len() as f64;
        if meters.is_empty() { self.meter.follows } else { [0, 1, 2].map(mean) }
    }

    /// Returns true when some photo's corners are darker.
    fn has_vignetting(&self) -> bool {
        self.optics.iter().any(|optics| optics.falloff != [0.0; 2])
    }
}

/// What is done about the darkening of corners by lenses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Vignetting {
    /// Nothing.
    Ignored,
    /// It is removed from photos before they are blended; views have none.
    Removed,
    /// It is removed from photos before they are blended, and views get that of the lenses of the photos that they show, if
    /// left-out photos are predicted better so; else it is ignored.
    #[default]
    Kept,
}

/// Options of the estimation of gains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExposureOptions {
    /// The number of surface points looked for in a photo, on a regular grid.
    pub points_per_photo: u32,
    /// Half the side of the square over which a colour is averaged, in pixels of the photo.
    pub half_patch_px: f64,
    /// The additional width, in pixels of the photo, in which the surface around a patch has to be visible:
    /// edges of a coarse model are off by a few pixels, and lenses and noise filters smear.
    pub border_px: f64,
    /// What is done about vignetting.
    pub vignetting: Vignetting,
    /// True when the offset of each photo, light added everywhere, is estimated.
    pub offset: bool,
}

impl Default for ExposureOptions {
    fn default() -> Self {
        Self {
            points_per_photo: 384,
            half_patch_px: 6.0,
            border_px: 6.0,
            vignetting: Vignetting::Ignored,
            offset: false,
        }
    }
}

/// The result of the estimation of gains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The gains.
    pub gains: Gains,
    /// How well each rule of exposure predicts photos that are left out; empty where nothing can be compared.
    pub rules: Vec<RuleScore>,
    /// By how many dB left-out photos are predicted better in the exposure that their cameras wrote down than by the best rule;
    /// `None` where none is known or nothing can be compared.
    #[serde(default)]
    pub camera_lead: Option<f64>,
    /// The PSNR, in dB, with which the colours of each photo that was left out are predicted at common points by each rule, in the
    /// order of [`ExposureRule::ALL`].
    #[serde(default)]
    pub left_out_psnr: Vec<[f64; 4]>,
    /// The lead of views that lean to the groups of light that they show most of over those with all photos in one group; `None`
    /// where all photos are one group, and where nothing can be compared.
    #[serde(default)]
    pub leaning_lead: Option<Lead>,
    /// The lead of gains per surface, by which other groups are brought over to the light of a photo's group; `None` as for
    /// `leaning_lead`.
    #[serde(default)]
    pub surfaces_lead: Option<Lead>,
    /// By how many dB left-out photos are predicted better where views keep the vignetting of lenses; `None` where none was
    /// found or it was not compared.
    pub vignetting_lead: Option<f64>,
    /// The support of each photo's gain.
    #[serde(rename = "grounds")]
    pub gain_support: Vec<GainSupport>,
    /// The typical distance between surfaces and their cameras, in world units; movements of the camera are
    /// measured relative to it ([`Shares::new`]).
    pub reach: f64,
    /// The number of surface points that two photos or more show with usable colours.
    pub points: usize,
    /// The number of compared pairs of photos, over all points.
    pub pairs: usize,
    /// What speaks for the groups of light.
    #[serde(default)]
    pub group_support: GroupSupport,
    /// Photos that share no point with another one; their gain is unknown, and 0.
    pub alone: Vec<PhotoId>,
    /// The number of groups of photos that share points, not counting photos alone.
    pub components: usize,
    /// Median of the absolute log ratios, R, G, B, of the unchanged photos.
    pub before: [f64; 3],
    /// Median of the absolute log ratios, R, G, B, after gains and optics are removed: the rest is due to
    /// misregistered textures, reflections and changed light.
    pub after: [f64; 3],
}

/// The colour of a patch; `None` where the photo does not show all of it.
pub type PatchColour = Option<MeanColour>;

/// The mean colour of a patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanColour {
    /// The mean in linear light, R, G, B, full range 1.
    pub mean: [f64; 3],
    /// True when no pixel is clipped or near black, so that ratios of the colour are ratios of exposures.
    pub usable: bool,
}

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
    Evidence { photos, points: &measured.points, colours: &colours, ratios: &ratios }.groups()
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
    let lead = rule::best_psnr(&kept).zip(rule::best_psnr(&ignored)).map(|(kept, ignored)| kept - ignored);
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
    let scores = rule::rule_scores(photos, measured, groups, options);
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

/// Measured colours without the optics of their cameras.
struct Corrected<'a> {
    colours: Cow<'a, [Vec<PatchColour>]>,
    optics: Vec<Optics>,
    ratios: Vec<Ratio>,
    /// Median of the absolute log ratios of the unchanged photos.
    before: [f64; 3],
}

/// Estimates optics as far as that is asked for, and removes them from the colours.
fn corrected<'a>(
    photos: &[Projector],
    measured: &'a MeasuredColours,
    options: &ExposureOptions,
) -> Corrected<'a> {
    let points = &measured.points;
    let mut colours = Cow::Borrowed(measured.colours.as_slice());
    let mut ratios = pairwise_ratios(points, &colours);
    let before = [0, 1, 2].map(|c| median_residual(&ratios, c, &vec![0.0; photos.len()]));
    let optics = solve_optics(photos, &ratios, options);
    if optics.iter().any(|optics| *optics != Optics::default()) {
        optics::undo(photos, points, colours.to_mut(), &optics);
        ratios = pairwise_ratios(points, &colours);
    }
    Corrected { colours, optics, ratios, before }
}

/// Estimates gains; no rule of exposure is tried.
fn fitted(
    photos: &[Projector],
    measured: &MeasuredColours,
    groups: &LightGroups,
    options: &ExposureOptions,
) -> Estimate {
    let points = &measured.points;
    let keeps_vignetting = options.vignetting == Vignetting::Kept;
    let Corrected { colours, optics, ratios, before } = corrected(photos, measured, options);
    let (fit, camera) = fit_with_cameras(&measured.camera_logs, &ratios, groups);
    let usable = |colours: &&Vec<PatchColour>| colours.iter().flatten().filter(|c| c.usable).count() >= 2;
    let shared = colours.iter().filter(usable).count();
    let reach = typical_distance(points);
    let (meter, meters) = if groups.is_one() {
        (Meter::new(photos, points, &colours, (&fit.of_photo, &fit.component), reach), Vec::new())
    } else {
        let corrected = MeasuredColours {
            colours: colours.to_vec(),
            points: points.clone(),
            joined: Vec::new(),
            places: Vec::new(),
            place_colours: Vec::new(),
            camera_logs: vec![None; photos.len()],
        };
        (Meter::default(), group_meters(photos, &corrected, groups, &fit, reach))
    };
    let means = if groups.is_one() { Vec::new() } else { group_means(groups, &fit) };
    let surfaces = match groups.is_one() {
        true => SurfaceGains::default(),
        false => SurfaceGains::new(points, &colours, &fit.of_photo, groups, &measured.joined),
    };
    Estimate {
        gain_support: gain_support(photos.len(), points, &colours, &ratios, &fit.of_photo),
        gains: Gains {
            of_photo: fit.of_photo,
            optics,
            meter,
            rule: ExposureRule::default(),
            light: SiteLight { groups: groups.clone(), blended: None, meters, means, surfaces },
            keeps_vignetting,
            camera,
            surroundings: Arc::default(),
        },
        rules: Vec::new(),
        camera_lead: None,
        left_out_psnr: Vec::new(),
        group_support: GroupSupport::default(),
        leaning_lead: None,
        surfaces_lead: None,
        vignetting_lead: None,
        reach,
        points: shared,
        pairs: ratios.len(),
        alone: fit.alone,
        components: fit.components,
        before,
        after: fit.after,
    }
}

/// Returns the mean log gain of each group of light, without photos that have none.
fn group_means(groups: &LightGroups, fit: &GainFit) -> Vec<[f64; 3]> {
    let mut sums = vec![([0.0; 3], 0u32); groups.count()];
    for (photo, gain) in PhotoId::all(fit.of_photo.len()).zip(&fit.of_photo) {
        if !fit.alone.contains(&photo) {
            let (sum, count) = &mut sums[groups.of(photo)];
            (0..3).for_each(|c| sum[c] += gain[c]);
            *count += 1;
        }
    }
    sums.into_iter().map(|(sum, count)| sum.map(|sum| sum / f64::from(count.max(1)))).collect()
}

/// Builds the model of metering of each group of light, from its own photos.
fn group_meters(
    photos: &[Projector],
    corrected: &MeasuredColours,
    groups: &LightGroups,
    fit: &GainFit,
    reach: f64,
) -> Vec<Meter> {
    let of_group = |group: usize| {
        let kept: Vec<PhotoId> =
            PhotoId::all(photos.len()).filter(|photo| groups.of(*photo) == group).collect();
        let own: Vec<Projector> = kept.iter().map(|photo| photos[photo.index()].clone()).collect();
        let gains: Vec<[f64; 3]> = kept.iter().map(|photo| fit.of_photo[photo.index()]).collect();
        let component: Vec<usize> = kept.iter().map(|photo| fit.component[photo.index()]).collect();
        let MeasuredColours { points, colours, .. } = corrected.of_photos(&kept);
        // Photos without common points have no readings, and views no meter.
        if points.is_empty() {
            return Meter::default();
        }
        Meter::new(&own, &points, &colours, (&gains, &component), reach).among(&kept, photos.len())
    };
    (0..groups.count()).map(of_group).collect()
}

impl Gains {
    /// Numbers the photos, which are the `kept` ones (in rising order) of `count`, as among all.
    fn among(self, kept: &[PhotoId], count: usize) -> Self {
        let mut gains = Self::none(count);
        for (i, photo) in kept.iter().map(|photo| photo.index()).enumerate() {
            gains.of_photo[photo] = self.of_photo[i];
            gains.optics[photo] = self.optics[i];
        }
        gains.meter = self.meter.among(kept, count);
        let SiteLight { groups, blended, meters, means, surfaces } = self.light;
        let meters = meters.into_iter().map(|meter| meter.among(kept, count)).collect();
        let blended = blended.map(|blended| Box::new(blended.among(kept, count)));
        gains.light = SiteLight { groups: groups.among(kept, count), blended, meters, means, surfaces };
        (gains.rule, gains.keeps_vignetting) = (self.rule, self.keeps_vignetting);
        gains.camera = self.camera.among(kept.iter().map(|photo| photo.index()), count);
        gains
    }
}

impl Estimate {
    /// Decides whether views lean to groups of light, given what is estimated with all photos in one group. A wrong guess at the
    /// light costs several dB, a right one brings as much: few photos decide only where they clearly say the same.
    fn decide_leaning(&mut self, one: Self) {
        self.leaning_lead = rule::lead_over(self, &one);
        if self.leaning_lead.is_some_and(|lead| !lead.is_clear()) {
            (self.rules, self.left_out_psnr) = (one.rules, one.left_out_psnr);
            self.camera_lead = one.camera_lead;
            self.vignetting_lead = one.vignetting_lead;
            self.gains.rule = one.gains.rule;
            self.gains.light.blended = Some(Box::new(one.gains));
        }
    }

    /// Numbers the photos, which are the `kept` ones (in rising order) of `count`, as among all.
    fn among(self, kept: &[PhotoId], count: usize) -> Self {
        let mut gain_support = vec![GainSupport::default(); count];
        for (i, photo) in kept.iter().map(|photo| photo.index()).enumerate() {
            gain_support[photo] = self.gain_support[i];
        }
        let has_gain =
            |photo: &PhotoId| kept.binary_search(photo).is_ok_and(|i| !self.alone.contains(&PhotoId::new(i)));
        let alone = PhotoId::all(count).filter(|photo| !has_gain(photo)).collect();
        let gains = self.gains.among(kept, count);
        Self { gains, gain_support, alone, ..self }
    }
}

#[cfg(test)]
mod tests;
