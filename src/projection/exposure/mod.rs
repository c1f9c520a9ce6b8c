//! Exposure: the brightness of each photo relative to a common exposure.
//!
//! Photos of one site differ by shutter, aperture and white balance, that is, by a factor per channel in
//! linear light. Its natural logarithm is the *gain*. Gains are estimated from small patches around surface
//! points that two photos or more show ([`points`]), the ratios of their mean colours ([`ratios`]), and the
//! gains that explain these best, robustly ([`solve`]). The photos do *not* tell how bright the site was:
//! gains are relative, 0 on average.
//!
//! A view has an exposure, too: a blend of the photos' gains by their part in the view ([`seen`]), corrected
//! by the difference between what the view's exposure meter would read and what the photos' meters read
//! ([`meter`]). A view from a photo's own camera has the photo's exposure.
//!
//! Panoramas are equalised in the same way (Brown & Lowe, *Automatic Panoramic Image Stitching using
//! Invariant Features*, 2007, section 6); there the overlaps are whole images, here single points.

pub mod gain_support;
pub mod meter;
pub mod near;
pub mod optics;
pub mod patch;
pub mod points;
pub mod ratios;
pub mod seen;
pub mod solve;

pub use gain_support::{GainSupport, gain_support};
pub use meter::Meter;
pub use near::Shares;
pub use optics::{Optics, solve_optics};
pub use points::{PointPatch, RayVisibility, SharedPoint, Visibility, shared_points};
pub use ratios::{Ratio, pairwise_ratios};
pub use seen::visible_shares;
pub use solve::{GainFit, solve_gains};

use glam::DVec2;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use self::solve::median_residual;
use super::Projector;
use crate::error::Result;
use crate::raster::robust::upper_median;
use crate::scene::PhotoId;
use crate::task::Task;

/// The photos' gains, their optics, and the model of exposure metering.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Gains {
    /// The gain of each photo, in the order of [`super::Sources::photos`]: natural logarithm of photo /
    /// common exposure in linear light, per channel R, G, B.
    pub of_photo: Vec<[f64; 3]>,
    /// The vignetting and offset of each photo; neutral where they were not estimated.
    pub optics: Vec<Optics>,
    /// The model that predicts a view's exposure, where the photos' exposures followed their meters.
    pub meter: Meter,
}

impl Gains {
    /// Returns gains of 0 and neutral optics, which leave all photos unchanged.
    pub fn none(photo_count: usize) -> Self {
        let optics = vec![Optics::default(); photo_count];
        Self { of_photo: vec![[0.0; 3]; photo_count], optics, meter: Meter::default() }
    }
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
    /// True when the vignetting of each camera is estimated.
    pub vignetting: bool,
    /// True when the offset of each photo, light added everywhere, is estimated.
    pub offset: bool,
}

impl Default for ExposureOptions {
    fn default() -> Self {
        Self { points_per_photo: 384, half_patch_px: 6.0, border_px: 6.0, vignetting: false, offset: false }
    }
}

/// The result of the estimation of gains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The gains.
    pub gains: Gains,
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

/// Estimates the gains of `photos`. `colours` measures patches of one photo, given their centres in its
/// pixels, in the same order; it is called once per photo, for several photos in parallel. The result does
/// not depend on the number of threads.
///
/// # Errors
/// The errors of `colours`, and [`crate::Error::Cancelled`].
pub fn estimate_gains(
    photos: &[Projector],
    visibility: &impl Visibility,
    colours: &(impl Fn(PhotoId, &[DVec2]) -> Result<Vec<PatchColour>> + Sync),
    options: &ExposureOptions,
    task: &Task,
) -> Result<Estimate> {
    let points = shared_points(photos, visibility, options, task)?;
    let mut measured = task.timed("measure colours", || measure(photos.len(), &points, colours))?;
    task.go_on()?;
    let mut ratios = pairwise_ratios(&points, &measured);
    let before = [0, 1, 2].map(|c| median_residual(&ratios, c, &vec![0.0; photos.len()]));
    let optics = solve_optics(photos, &ratios, options);
    if optics.iter().any(|optics| *optics != Optics::default()) {
        optics::undo(photos, &points, &mut measured, &optics);
        ratios = pairwise_ratios(&points, &measured);
    }
    let fit = solve_gains(photos.len(), &ratios);
    let usable = |colours: &&Vec<PatchColour>| colours.iter().flatten().filter(|c| c.usable).count() >= 2;
    let shared = measured.iter().filter(usable).count();
    let reach = typical_distance(&points);
    let meter = Meter::new(photos, &points, &measured, (&fit.of_photo, &fit.component), reach);
    Ok(Estimate {
        gain_support: gain_support(photos.len(), &points, &measured, &ratios, &fit.of_photo),
        gains: Gains { of_photo: fit.of_photo, optics, meter },
        reach,
        points: shared,
        pairs: ratios.len(),
        alone: fit.alone,
        components: fit.components,
        before,
        after: fit.after,
    })
}

/// Measures the colours of all patches, per point.
fn measure(
    photo_count: usize,
    points: &[SharedPoint],
    colours: &(impl Fn(PhotoId, &[DVec2]) -> Result<Vec<PatchColour>> + Sync),
) -> Result<Vec<Vec<PatchColour>>> {
    // Grouped by photo, so that each photo is read once: (point, index among its patches, centre).
    let mut wanted: Vec<Vec<(usize, usize, DVec2)>> = vec![Vec::new(); photo_count];
    for (p, point) in points.iter().enumerate() {
        for (k, patch) in point.patches.iter().enumerate() {
            wanted[patch.photo.index()].push((p, k, patch.center_px));
        }
    }
    let of_photo = |(photo, wanted): (usize, &Vec<(usize, usize, DVec2)>)| {
        let centers: Vec<DVec2> = wanted.iter().map(|(_, _, center)| *center).collect();
        if centers.is_empty() { Ok(Vec::new()) } else { colours(PhotoId::new(photo), &centers) }
    };
    let found: Vec<Vec<PatchColour>> = wanted.par_iter().enumerate().map(of_photo).collect::<Result<_>>()?;
    let mut measured: Vec<Vec<PatchColour>> = points.iter().map(|p| vec![None; p.patches.len()]).collect();
    for (wanted, found) in wanted.iter().zip(found) {
        for ((p, k, _), colour) in wanted.iter().zip(found) {
            measured[*p][*k] = colour;
        }
    }
    Ok(measured)
}

/// Returns the median distance between points and the cameras that see them; 1 without any.
fn typical_distance(points: &[SharedPoint]) -> f64 {
    let mut distances: Vec<f64> = points.iter().flat_map(|p| &p.patches).map(|p| p.distance).collect();
    upper_median(&mut distances).unwrap_or(1.0)
}

#[cfg(test)]
mod tests;
