//! Gains and optics that explain measured colours, before any rule of exposure is tried.

use std::borrow::Cow;
use std::sync::Arc;

use super::camera::fit_with_cameras;
use super::estimate::Estimate;
use super::gain_support::gain_support;
use super::gains::Gains;
use super::grouping::GroupSupport;
use super::groups::LightGroups;
use super::light::SiteLight;
use super::measured::MeasuredColours;
use super::meter::Meter;
use super::optics::{self, solve_optics};
use super::options::{ExposureOptions, Vignetting};
use super::patch::PatchColour;
use super::points::typical_distance;
use super::ratios::{Ratio, pairwise_ratios};
use super::rule::ExposureRule;
use super::solve::{GainFit, median_residual};
use super::surface_gains::SurfaceGains;
use crate::Projector;
use quadratura_base::scene::PhotoId;
use quadratura_view::optics::Optics;

/// Measured colours without the optics of their cameras.
pub(super) struct Corrected<'a> {
    pub colours: Cow<'a, [Vec<PatchColour>]>,
    pub optics: Vec<Optics>,
    pub ratios: Vec<Ratio>,
    /// Median of the absolute log ratios of the unchanged photos.
    pub before: [f64; 3],
}

/// Estimates optics as far as that is asked for, and removes them from the colours.
pub(super) fn corrected<'a>(
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
pub(super) fn fitted(
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
        (Meter::new(photos, points, &colours, &fit.of_photo, &fit.component, reach), Vec::new())
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
        Meter::new(&own, &points, &colours, &gains, &component, reach).among(&kept, photos.len())
    };
    (0..groups.count()).map(of_group).collect()
}
