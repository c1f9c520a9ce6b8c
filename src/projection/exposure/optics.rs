//! Vignetting and offset: lenses darken the image towards the corners, and stray light or a wrong black level
//! adds a little light everywhere.
//!
//! Both are estimated from the same log ratios as the gains, together with these: from points that two photos
//! show at different distances from their centres, and from the different ratios of dark and bright points.
//! Both are small, so that, with the light L, the logarithm of what a photo shows is
//!
//! ```text
//! ln I = gain + ln L + a r^2 + b r^4 + offset / (e^gain L)
//! ```
//!
//! to first order in the offset. This is a linear system, solved like that of the gains ([`super::solve`]),
//! over the mean of the channels' logarithms, because neither effect depends on colour. Unknowns that the
//! ratios do not determine are kept near 0 by priors. (Goldman & Chen, *Vignette and Exposure Calibration and
//! Compensation*, 2005, do so for panoramas, with a response curve that is not estimated here.)

use super::options::{ExposureOptions, Vignetting};
use super::patch::PatchColour;
use super::points::SharedPoint;
use super::ratios::Ratio;
use super::solve::{CORRELATED, HUBER, LEAST_SIGMA, cholesky_solve};
use crate::Projector;
use quadratura_base::geometry::Pinhole;
use quadratura_base::raster::robust::sigma;
use quadratura_view::optics::{Optics, squared_radius};

/// The least number of photos of a camera for which its falloff is estimated; with fewer, dark corners may as
/// well be part of the site.
const FEWEST_PHOTOS: u32 = 4;
/// The least number of comparisons of a camera's photos; a tenth of these are independent ([`CORRELATED`]).
const FEWEST_RATIOS: u32 = 500;

/// Standard deviations assumed for the falloff's coefficients: together half a stop in the corner.
const FALLOFF_PRIOR: [f64; 2] = [0.3, 0.2];
/// The standard deviation assumed for offsets: as much light as lenses scatter in bright surroundings, a
/// fiftieth of white.
const OFFSET_PRIOR: f64 = 0.02;

/// The number of standard deviations from which a falloff at the corner counts; smaller ones may be chance.
const CERTAIN: f64 = 3.0;

const MOST_ROUNDS: u32 = 30;
const GOOD_ENOUGH: f64 = 1e-6;

/// Estimates the optics of each photo, as far as `options` ask for them; neutral where they cannot be
/// determined.
pub fn solve_optics(photos: &[Projector], ratios: &[Ratio], options: &ExposureOptions) -> Vec<Optics> {
    let none = vec![Optics::default(); photos.len()];
    if !(options.vignetting != Vignetting::Ignored || options.offset) || ratios.is_empty() {
        return none;
    }
    let unknowns = Unknowns::new(photos, ratios, options);
    let mut found = vec![0.0; unknowns.count];
    let mut sigma = sigma_of_residuals(&unknowns, ratios, &found);
    for _ in 0..MOST_ROUNDS {
        let next = unknowns.reweighted(ratios, &found, sigma);
        let moved = found.iter().zip(&next).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        found = next;
        sigma = sigma_of_residuals(&unknowns, ratios, &found);
        if moved < GOOD_ENOUGH {
            break;
        }
    }
    let certain = |camera: usize| unknowns.corner_is_certain(ratios, &found, sigma, camera);
    let certain: Vec<bool> = (0..unknowns.cameras).map(certain).collect();
    (0..photos.len()).map(|photo| unknowns.optics(photo, &found, &certain)).collect()
}

/// The numbering of the unknowns: the gains of photos first, then two coefficients per camera, then the
/// offsets.
struct Unknowns {
    photos: usize,
    /// The camera of each photo; `None` where too few photos or comparisons of it exist.
    camera: Vec<Option<usize>>,
    cameras: usize,
    offsets: bool,
    count: usize,
    /// The intrinsics of each photo.
    pinholes: Vec<Pinhole>,
}

/// The coefficients of one ratio: at most two gains, four falloff coefficients, two offsets.
type CoefficientRow = Vec<(usize, f64)>;

impl Unknowns {
    fn new(photos: &[Projector], ratios: &[Ratio], options: &ExposureOptions) -> Self {
        let pinholes: Vec<Pinhole> = photos.iter().map(|photo| photo.camera).collect();
        let first = |photo: &Pinhole| pinholes.iter().position(|p| p == photo).expect("itself at least");
        let group: Vec<usize> = pinholes.iter().map(first).collect();
        let (mut in_group, mut comparisons) = (vec![0u32; photos.len()], vec![0u32; photos.len()]);
        group.iter().for_each(|g| in_group[*g] += 1);
        for ratio in ratios {
            comparisons[group[ratio.a.0 as usize]] += 1;
            comparisons[group[ratio.b.0 as usize]] += 1;
        }
        let enough = |g: usize| in_group[g] >= FEWEST_PHOTOS && comparisons[g] >= FEWEST_RATIOS;
        let eligible: Vec<usize> = (0..photos.len())
            .filter(|g| options.vignetting != Vignetting::Ignored && in_group[*g] > 0 && enough(*g))
            .collect();
        let camera = group.iter().map(|g| eligible.iter().position(|e| e == g)).collect();
        let offsets = if options.offset { photos.len() } else { 0 };
        let count = photos.len() + 2 * eligible.len() + offsets;
        let cameras = eligible.len();
        Self { photos: photos.len(), camera, cameras, offsets: options.offset, count, pinholes }
    }

    fn row(&self, ratio: &Ratio, found: &[f64]) -> CoefficientRow {
        let mut row = Vec::with_capacity(8);
        let photos = [ratio.a, ratio.b].map(|photo| photo.index());
        // The light that both photos show on average, so that noise in one of them does not bias the offset.
        let between = (f64::from(ratio.light[0]) * f64::from(ratio.light[1])).sqrt();
        let half_step = 0.5 * (found[photos[0]] - found[photos[1]]);
        for (side, sign) in [(0, 1.0), (1, -1.0)] {
            let photo = photos[side];
            row.push((photo, sign));
            if let Some(camera) = self.camera[photo] {
                let r2 = squared_radius(&self.pinholes[photo], ratio.at_px[side].as_dvec2());
                row.extend([(self.falloff(camera), sign * r2), (self.falloff(camera) + 1, sign * r2 * r2)]);
            }
            if self.offsets {
                row.push((self.offset(photo), sign / (between * (sign * half_step).exp())));
            }
        }
        row
    }

    fn falloff(&self, camera: usize) -> usize {
        self.photos + 2 * camera
    }

    fn offset(&self, photo: usize) -> usize {
        self.photos + 2 * self.cameras + photo
    }

    /// Returns the prior standard deviation of an unknown.
    fn prior(&self, unknown: usize) -> f64 {
        match unknown.checked_sub(self.photos) {
            None => super::solve::PRIOR,
            Some(index) if index < 2 * self.cameras => FALLOFF_PRIOR[index % 2],
            Some(_) => OFFSET_PRIOR,
        }
    }

    /// Does one round of reweighted least squares, as in [`super::solve`].
    fn reweighted(&self, ratios: &[Ratio], found: &[f64], sigma: f64) -> Vec<f64> {
        let (normal, right) = self.normal(ratios, found, sigma);
        cholesky_solve(normal, right)
    }

    /// Computes the normal matrix and the right side, with weights and light for the current solution.
    fn normal(&self, ratios: &[Ratio], found: &[f64], sigma: f64) -> (Vec<f64>, Vec<f64>) {
        let n = self.count;
        let (mut normal, mut right) = (vec![0.0; n * n], vec![0.0; n]);
        for ratio in ratios {
            let row = self.row(ratio, found);
            let off = (grey(ratio) - predicted(&row, found)).abs();
            let weight = f64::from(ratio.weight) * (HUBER * sigma / off).min(1.0);
            for (i, x) in &row {
                right[*i] += weight * x * grey(ratio);
                row.iter().for_each(|(j, y)| normal[i * n + j] += weight * x * y);
            }
        }
        (0..n).for_each(|i| normal[i * n + i] += CORRELATED * (sigma / self.prior(i)).powi(2));
        (normal, right)
    }

    /// Returns true when the falloff at the corner is significant, by the variance of the sum of its
    /// coefficients.
    fn corner_is_certain(&self, ratios: &[Ratio], found: &[f64], sigma: f64, camera: usize) -> bool {
        let at = self.falloff(camera);
        let (normal, _) = self.normal(ratios, found, sigma);
        let mut sum = vec![0.0; self.count];
        (sum[at], sum[at + 1]) = (1.0, 1.0);
        let variance = cholesky_solve(normal, sum);
        let deviation = (CORRELATED * (variance[at] + variance[at + 1])).sqrt() * sigma;
        (found[at] + found[at + 1]).abs() > CERTAIN * deviation
    }

    fn optics(&self, photo: usize, found: &[f64], certain: &[bool]) -> Optics {
        let of_camera = |camera: usize| [found[self.falloff(camera)], found[self.falloff(camera) + 1]];
        let camera = self.camera[photo].filter(|camera| certain[*camera]);
        let offset = if self.offsets { found[self.offset(photo)] } else { 0.0 };
        Optics { falloff: camera.map_or([0.0; 2], of_camera), offset }
    }
}

/// Returns the mean of the channels.
fn grey(ratio: &Ratio) -> f64 {
    ratio.log.iter().map(|log| f64::from(*log)).sum::<f64>() / 3.0
}

fn predicted(row: &CoefficientRow, found: &[f64]) -> f64 {
    row.iter().map(|(i, x)| x * found[*i]).sum()
}

/// Estimates the residuals' standard deviation from their median.
fn sigma_of_residuals(unknowns: &Unknowns, ratios: &[Ratio], found: &[f64]) -> f64 {
    let off = |ratio: &Ratio| grey(ratio) - predicted(&unknowns.row(ratio, found), found);
    let mut residuals: Vec<f64> = ratios.iter().map(off).collect();
    sigma(&mut residuals).expect("there is a ratio at least").max(LEAST_SIGMA)
}

/// Removes the optics from the colours of patches.
pub fn undo(
    photos: &[Projector],
    points: &[SharedPoint],
    colours: &mut [Vec<PatchColour>],
    optics: &[Optics],
) {
    for (point, colours) in points.iter().zip(colours) {
        for (patch, colour) in point.patches.iter().zip(colours) {
            let photo = patch.photo.index();
            if let Some(colour) = colour {
                colour.mean =
                    optics[photo].undone(colour.mean, squared_radius(&photos[photo].camera, patch.center_px));
            }
        }
    }
}
