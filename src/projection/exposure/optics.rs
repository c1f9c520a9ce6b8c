//! What a camera does to light besides exposing it: its lens darkens the picture towards the corners
//! (vignetting), and stray light or a wrong black level adds a little everywhere.
//!
//! Both are told by the same log ratios as the gains, together with them: where two photos show a point at
//! different distances from their centres, or a dark point and a bright one differ by different ratios.
//! Both are small, so that the logarithm of what a photo shows of the light L is
//!
//! ```text
//! ln I = gain + ln L + a r^2 + b r^4 + offset / (e^gain L)
//! ```
//!
//! to first order in the offset: a linear system, solved like that of the gains ([`super::solve`]), over the
//! mean of the channels' logarithms, because neither knows colours. What is not in the ratios is held near 0
//! by priors. (Goldman & Chen, *Vignette and Exposure Calibration and Compensation*, 2005, do so for
//! panoramas, with a response curve that is not estimated here.)

use serde::{Deserialize, Serialize};

use super::solve::{CORRELATED, HUBER, LEAST_SIGMA, cholesky_solve};
use super::{ExposureOptions, PatchColour, Ratio, SharedPoint};
use crate::geometry::Pinhole;
use crate::projection::Projector;
use crate::raster::robust::sigma;

/// What one photo's camera does to light.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Optics {
    /// The logarithm of the light at a distance r from the principal point, against that at it:
    /// `falloff[0] r^2 + falloff[1] r^4`, r in halves of the picture's diagonal.
    pub falloff: [f64; 2],
    /// Light that is added everywhere, in all channels alike; white is 1.
    pub offset: f64,
}

impl Optics {
    /// The logarithm of the light at a squared distance from the principal point, in squared halves of the
    /// picture's diagonal.
    pub fn log_light(&self, r2: f64) -> f64 {
        (self.falloff[0] + self.falloff[1] * r2) * r2
    }

    /// Linear light without what the camera did to it. What is darker than the offset is almost black.
    pub fn undone(&self, light: [f64; 3], r2: f64) -> [f64; 3] {
        /// Darker than half a step of 8 bits: 1 / 255 / 12.92 / 2.
        const ALMOST_BLACK: f64 = 1.5e-4;
        if *self == Self::default() {
            return light;
        }
        let brighter = (-self.log_light(r2)).exp();
        light.map(|light| (light - self.offset).max(light.min(ALMOST_BLACK)) * brighter)
    }
}

/// The squared distance of an image point from the principal point, in squared halves of the diagonal.
pub fn radius2(camera: &Pinhole, px: glam::DVec2) -> f64 {
    let half_diagonal2 = 0.25 * (f64::from(camera.width).powi(2) + f64::from(camera.height).powi(2));
    px.distance_squared(glam::DVec2::new(camera.cx, camera.cy)) / half_diagonal2
}

/// With fewer photos of a camera its falloff is not asked for: what stands in the corners of three photos is as
/// likely a matter of the site.
const FEWEST_PHOTOS: u32 = 4;
/// Nor with fewer comparisons of its photos: a tenth of these speak for themselves ([`CORRELATED`]).
const FEWEST_RATIOS: u32 = 500;

/// Standard deviations of falloffs' coefficients and of offsets, where nothing is known: together half a stop in
/// the corner; and as much as lenses scatter of a bright surrounding, a fiftieth of white.
const FALLOFF_PRIOR: [f64; 2] = [0.3, 0.2];
/// See [`FALLOFF_PRIOR`].
const OFFSET_PRIOR: f64 = 0.02;

/// A falloff counts from so many standard deviations of its corner on: below, it may be chance.
const CERTAIN: f64 = 3.0;

const MOST_ROUNDS: u32 = 30;
const GOOD_ENOUGH: f64 = 1e-6;

/// By photo, what `options` ask for; nothing where the photos do not tell.
pub fn solve_optics(photos: &[Projector], ratios: &[Ratio], options: &ExposureOptions) -> Vec<Optics> {
    let none = vec![Optics::default(); photos.len()];
    if !(options.vignetting || options.offset) || ratios.is_empty() {
        return none;
    }
    let unknowns = Unknowns::of(photos, ratios, options);
    let mut found = vec![0.0; unknowns.count];
    let mut sigma = spread(&unknowns, ratios, &found);
    for _ in 0..MOST_ROUNDS {
        let next = unknowns.reweighted(ratios, &found, sigma);
        let moved = found.iter().zip(&next).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        found = next;
        sigma = spread(&unknowns, ratios, &found);
        if moved < GOOD_ENOUGH {
            break;
        }
    }
    let certain = |camera: usize| unknowns.corner_is_certain(ratios, &found, sigma, camera);
    let certain: Vec<bool> = (0..unknowns.cameras).map(certain).collect();
    (0..photos.len()).map(|photo| unknowns.optics(photo, &found, &certain)).collect()
}

/// Which number is which: gains of photos first, then two of each camera, then the offsets.
struct Unknowns {
    photos: usize,
    /// By photo, its camera; none where too little is known of it.
    camera: Vec<Option<usize>>,
    cameras: usize,
    offsets: bool,
    count: usize,
    /// By photo.
    pinholes: Vec<Pinhole>,
}

/// What one ratio says of the unknowns: at most two gains, four coefficients, two offsets.
type Row = Vec<(usize, f64)>;

impl Unknowns {
    fn of(photos: &[Projector], ratios: &[Ratio], options: &ExposureOptions) -> Self {
        let pinholes: Vec<Pinhole> = photos.iter().map(|photo| photo.camera).collect();
        let first = |photo: &Pinhole| pinholes.iter().position(|p| p == photo).expect("itself at least");
        let group: Vec<usize> = pinholes.iter().map(first).collect();
        let (mut in_group, mut told) = (vec![0u32; photos.len()], vec![0u32; photos.len()]);
        group.iter().for_each(|g| in_group[*g] += 1);
        for ratio in ratios {
            told[group[ratio.a.0 as usize]] += 1;
            told[group[ratio.b.0 as usize]] += 1;
        }
        let enough = |g: usize| in_group[g] >= FEWEST_PHOTOS && told[g] >= FEWEST_RATIOS;
        let eligible: Vec<usize> =
            (0..photos.len()).filter(|g| options.vignetting && in_group[*g] > 0 && enough(*g)).collect();
        let camera = group.iter().map(|g| eligible.iter().position(|e| e == g)).collect();
        let offsets = if options.offset { photos.len() } else { 0 };
        let count = photos.len() + 2 * eligible.len() + offsets;
        let cameras = eligible.len();
        Self { photos: photos.len(), camera, cameras, offsets: options.offset, count, pinholes }
    }

    fn row(&self, ratio: &Ratio, found: &[f64]) -> Row {
        let mut row = Vec::with_capacity(8);
        let places = [ratio.a, ratio.b].map(|photo| photo.0 as usize);
        // The light as both photos together show it: noise in one of them then leans to neither side.
        let between = (f64::from(ratio.light[0]) * f64::from(ratio.light[1])).sqrt();
        let half_step = 0.5 * (found[places[0]] - found[places[1]]);
        for (side, sign) in [(0, 1.0), (1, -1.0)] {
            let photo = places[side];
            row.push((photo, sign));
            if let Some(camera) = self.camera[photo] {
                let r2 = radius2(&self.pinholes[photo], ratio.at_px[side].as_dvec2());
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

    /// The standard deviation of an unknown before anything is seen.
    fn prior(&self, unknown: usize) -> f64 {
        match unknown.checked_sub(self.photos) {
            None => super::solve::PRIOR,
            Some(place) if place < 2 * self.cameras => FALLOFF_PRIOR[place % 2],
            Some(_) => OFFSET_PRIOR,
        }
    }

    /// One round, as [`super::solve`]'s.
    fn reweighted(&self, ratios: &[Ratio], found: &[f64], sigma: f64) -> Vec<f64> {
        let (normal, right) = self.normal(ratios, found, sigma);
        cholesky_solve(normal, right)
    }

    /// The normal matrix and the right side, weights and lights as `found` has them.
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

    /// Whether the falloff at the corner is more than chance, by the variance of its two coefficients' sum.
    fn corner_is_certain(&self, ratios: &[Ratio], found: &[f64], sigma: f64, camera: usize) -> bool {
        let at = self.falloff(camera);
        let (normal, _) = self.normal(ratios, found, sigma);
        let mut sum = vec![0.0; self.count];
        (sum[at], sum[at + 1]) = (1.0, 1.0);
        let spread = cholesky_solve(normal, sum);
        let deviation = (CORRELATED * (spread[at] + spread[at + 1])).sqrt() * sigma;
        (found[at] + found[at + 1]).abs() > CERTAIN * deviation
    }

    fn optics(&self, photo: usize, found: &[f64], certain: &[bool]) -> Optics {
        let of_camera = |camera: usize| [found[self.falloff(camera)], found[self.falloff(camera) + 1]];
        let camera = self.camera[photo].filter(|camera| certain[*camera]);
        let offset = if self.offsets { found[self.offset(photo)] } else { 0.0 };
        Optics { falloff: camera.map_or([0.0; 2], of_camera), offset }
    }
}

/// The mean of the channels.
fn grey(ratio: &Ratio) -> f64 {
    ratio.log.iter().map(|log| f64::from(*log)).sum::<f64>() / 3.0
}

fn predicted(row: &Row, found: &[f64]) -> f64 {
    row.iter().map(|(i, x)| x * found[*i]).sum()
}

/// The residuals' standard deviation, by their median.
fn spread(unknowns: &Unknowns, ratios: &[Ratio], found: &[f64]) -> f64 {
    let off = |ratio: &Ratio| grey(ratio) - predicted(&unknowns.row(ratio, found), found);
    let mut residuals: Vec<f64> = ratios.iter().map(off).collect();
    sigma(&mut residuals).expect("there is a ratio at least").max(LEAST_SIGMA)
}

/// The colours of patches without what cameras did to them.
pub fn undo(
    photos: &[Projector],
    points: &[SharedPoint],
    colours: &mut [Vec<PatchColour>],
    optics: &[Optics],
) {
    for (point, colours) in points.iter().zip(colours) {
        for (patch, colour) in point.patches.iter().zip(colours) {
            let photo = patch.photo.0 as usize;
            if let Some(colour) = colour {
                colour.mean =
                    optics[photo].undone(colour.mean, radius2(&photos[photo].camera, patch.center_px));
            }
        }
    }
}
