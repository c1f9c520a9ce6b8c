//! Exposure: how much brighter each photo is than the exposure that all are brought to.
//!
//! Photos of one site differ by shutter, aperture and white balance: per channel a factor in linear
//! light, here kept as its natural logarithm, the *gain*. It is estimated from what the photos have in
//! common: small patches around surface points that two photos or more show ([`points`]), the ratios
//! of their mean colours ([`ratios`]), and the gains that explain those best, robustly ([`solve`]).
//! What the photos do *not* tell is how bright the site was: gains are relative, 0 on average.
//!
//! A view has an exposure, too: a blend of the photos' gains by what they show of it ([`seen`]), carried to what the
//! view's exposure meter would read where the photos were metered ([`meter`]); a photo's own camera shows
//! the photo as it is.
//!
//! Panoramas are evened out in the same way (Brown & Lowe, *Automatic Panoramic Image Stitching using
//! Invariant Features*, 2007, section 6); there the overlaps are whole images, here single points.

pub mod grounds;
pub mod meter;
pub mod near;
pub mod optics;
pub mod patch;
pub mod points;
pub mod ratios;
pub mod seen;
pub mod solve;

pub use grounds::{Grounds, grounds};
pub use meter::Meter;
pub use near::Shares;
pub use optics::{Optics, solve_optics};
pub use points::{Patch, RayVisibility, SharedPoint, Visibility, spread_points};
pub use ratios::{Ratio, pairwise_ratios};
pub use seen::seen_shares;
pub use solve::{Fit, solve_gains};

use glam::DVec2;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use self::solve::median_residual;
use super::{PhotoId, Projector};
use crate::error::Result;
use crate::raster::robust::upper_median;
use crate::task::Task;

/// The photos' gains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Gains {
    /// By photo, as [`super::Sources::photos`]: natural logarithm of photo / common exposure in linear
    /// light, per channel R, G, B.
    pub of_photo: Vec<[f64; 3]>,
    /// By photo: what its camera did to light besides exposing it; nothing where that was not asked for.
    pub optics: Vec<Optics>,
    /// Tells from a view what its exposure would be, where the photos' exposures were told so.
    pub meter: Meter,
}

impl Gains {
    /// All photos as they are.
    pub fn none(photos: usize) -> Self {
        let optics = vec![Optics::default(); photos];
        Self { of_photo: vec![[0.0; 3]; photos], optics, meter: Meter::default() }
    }
}

/// How gains are estimated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExposureOptions {
    /// Surface points looked for in a photo, on a regular grid.
    pub points_per_photo: u32,
    /// Half the side of the square that a colour is the mean of, in pixels of the photo.
    pub half_patch_px: f64,
    /// The surface around a patch has to be visible so much further: a coarse model's edges are off by
    /// a few pixels, and lenses and noise filters smear.
    pub border_px: f64,
    /// Cameras are asked how their lenses darken the corners.
    pub vignetting: bool,
    /// Photos are asked how much light was added to them everywhere.
    pub offset: bool,
}

impl Default for ExposureOptions {
    fn default() -> Self {
        Self { points_per_photo: 384, half_patch_px: 6.0, border_px: 6.0, vignetting: false, offset: false }
    }
}

/// What came of an estimate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The gains.
    pub gains: Gains,
    /// By photo, what its gain rests on.
    pub grounds: Vec<Grounds>,
    /// How far from their cameras surfaces typically are, in world units: what a step of the camera is
    /// measured by ([`Shares::of`]).
    pub reach: f64,
    /// Surface points that two photos or more show, with usable colours.
    pub points: usize,
    /// Pairs of photos at points.
    pub pairs: usize,
    /// Photos that share no point with another one have no gain to speak of: it is 0.
    pub alone: Vec<PhotoId>,
    /// Groups of photos that share points, not counting those alone.
    pub components: usize,
    /// Median of the absolute log ratios, R, G, B, photos as they are.
    pub before: [f64; 3],
    /// The same once the gains, and what else cameras did, are taken out: what is left are textures out of register, reflections,
    /// light that has changed.
    pub after: [f64; 3],
}

/// The colour of a patch; none where the photo does not show all of it.
pub type PatchColour = Option<Colour>;

/// The mean colour of a patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colour {
    /// In linear light, R, G, B, full range 1.
    pub mean: [f64; 3],
    /// No pixel is clipped or near black: ratios of it are ratios of exposures.
    pub usable: bool,
}

/// Estimates the gains of `photos`. `colours` measures patches of one photo, given their centres in
/// its pixels, in the same order; it is called once a photo, several at a time. The result does not
/// depend on the number of threads.
///
/// # Errors
/// What `colours` fails with, and [`crate::Error::Cancelled`].
pub fn estimate_gains(
    photos: &[Projector],
    visibility: &impl Visibility,
    colours: &(impl Fn(PhotoId, &[DVec2]) -> Result<Vec<PatchColour>> + Sync),
    options: &ExposureOptions,
    task: &Task,
) -> Result<Estimate> {
    let points = spread_points(photos, visibility, options, task)?;
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
    let meter = Meter::of(photos, &points, &measured, (&fit.of_photo, &fit.component), reach);
    Ok(Estimate {
        grounds: grounds(photos.len(), &points, &measured, &ratios, &fit.of_photo),
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

/// For each point the colours of its patches.
fn measure(
    photos: usize,
    points: &[SharedPoint],
    colours: &(impl Fn(PhotoId, &[DVec2]) -> Result<Vec<PatchColour>> + Sync),
) -> Result<Vec<Vec<PatchColour>>> {
    // Photo by photo, so that each is read once: (point, place among its patches, centre).
    let mut wanted: Vec<Vec<(usize, usize, DVec2)>> = vec![Vec::new(); photos];
    for (p, point) in points.iter().enumerate() {
        for (k, patch) in point.patches.iter().enumerate() {
            wanted[patch.photo.0 as usize].push((p, k, patch.center_px));
        }
    }
    let of_photo = |(photo, wanted): (usize, &Vec<(usize, usize, DVec2)>)| {
        let centers: Vec<DVec2> = wanted.iter().map(|(_, _, center)| *center).collect();
        if centers.is_empty() { Ok(Vec::new()) } else { colours(PhotoId(photo as u32), &centers) }
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

/// The median distance between a point and the cameras that see it; 1 without any.
fn typical_distance(points: &[SharedPoint]) -> f64 {
    let mut distances: Vec<f64> = points.iter().flat_map(|p| &p.patches).map(|p| p.distance).collect();
    upper_median(&mut distances).unwrap_or(1.0)
}

#[cfg(test)]
mod tests;
