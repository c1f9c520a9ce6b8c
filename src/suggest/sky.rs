//! How likely each pixel shows the sky: what is above all points, plain and light, and stays where it is when one walks.

use glam::DVec3;
use rayon::prelude::*;

use quadratura_base::raster::robust::quantile;

use super::chart::regions;
use super::points::NormalisedPoint;
use super::support::middle;
use super::view::{PlaneDepth, Warp, WorkingPhoto};

/// The steepest gradient of sky, in greys a pixel.
const PLAIN: f32 = 4.0;
/// The least grey of sky, as a share of the site's 99th percentile.
const LIGHT: f32 = 0.72;
/// The largest mean difference of grey between photos that show the same sky. White walls of one site had 73 and more, true skies
/// under changing clouds up to 27.
const SAME: f32 = 40.0;
/// Steps of the histograms: of each colour, and of gradients.
const STEPS: usize = 8;
/// Columns about a pixel in which points count as below or above it.
const BESIDE: usize = 2;
/// The distance in pixels from a point within which a pixel is no sky.
const NEAR: usize = 4;
/// With fewer seeds in all photos there is no sky.
const FEWEST_SEEDS: f64 = 400.0;
/// Photos that are asked about a region.
const ASKED: usize = 4;

/// Returns the probability of sky at each pixel of each photo.
pub fn skies(
    views: &[WorkingPhoto],
    points: &[NormalisedPoint],
    near: &[Vec<u32>],
    up: DVec3,
) -> Vec<Vec<f32>> {
    let mut greys: Vec<f32> =
        views.iter().flat_map(|view| view.greys.values.iter().step_by(7).copied()).collect();
    let light = LIGHT * quantile(&mut greys, 0.99).unwrap_or(255.0);
    let evidence: Vec<SkyEvidence> =
        views.par_iter().map(|view| SkyEvidence::new(view, points, up, light)).collect();
    let (mut sky, mut rest) = (vec![1.0f64; STEPS.pow(4)], vec![1.0f64; STEPS.pow(4)]);
    for of in &evidence {
        for (at, bin) in of.bins.iter().enumerate() {
            sky[usize::from(*bin)] += f64::from(u8::from(of.is_seed[at]));
            rest[usize::from(*bin)] += f64::from(u8::from(of.is_near_point[at]));
        }
    }
    let (seeds, others) = (sky.iter().sum::<f64>(), rest.iter().sum::<f64>());
    // Each step began with one.
    if seeds < sky.len() as f64 + FEWEST_SEEDS {
        return views.iter().map(|view| vec![0.0; view.known.len()]).collect();
    }
    let likely: Vec<f32> =
        sky.iter().zip(&rest).map(|(s, r)| (s / seeds / (s / seeds + r / others)) as f32).collect();
    let of_view = |i: usize| {
        let mut sky: Vec<f32> = evidence[i].bins.iter().map(|bin| likely[usize::from(*bin)]).collect();
        keep_true(&mut sky, views, i, &near[i]);
        sky
    };
    (0..views.len()).into_par_iter().map(of_view).collect()
}

/// What one photo says.
struct SkyEvidence {
    bins: Vec<u16>,
    is_seed: Vec<bool>,
    is_near_point: Vec<bool>,
}

impl SkyEvidence {
    fn new(view: &WorkingPhoto, points: &[NormalisedPoint], up: DVec3, light: f32) -> Self {
        let [w, h] = view.size();
        let slope = gradients(&view.greys.values, [w, h]);
        let mut highest = vec![h; w];
        let mut is_near_point = vec![false; w * h];
        for (px, _) in points.iter().filter_map(|point| view.project(point.at)) {
            let (x, y) = ((px.x as usize).min(w - 1), (px.y as usize).min(h - 1));
            for column in &mut highest[x.saturating_sub(BESIDE)..(x + BESIDE + 1).min(w)] {
                *column = y.min(*column);
            }
            for row in y.saturating_sub(NEAR)..(y + NEAR + 1).min(h) {
                is_near_point[row * w + x.saturating_sub(NEAR)..row * w + (x + NEAR + 1).min(w)].fill(true);
            }
        }
        let is_seed = |at: usize| {
            let (x, y) = (at % w, at / w);
            y + NEAR < highest[x]
                && slope[at] < PLAIN
                && view.greys.values[at] > light
                && view.known[at]
                && view.ray(middle(x, y)).dot(up) > 0.0
        };
        let step = |value: f32| ((value * STEPS as f32 / 256.0) as usize).min(STEPS - 1);
        let bin = |at: usize| {
            let [r, g, b] = view.colours[at].map(step);
            let slope = ((slope[at] / PLAIN) as usize).min(STEPS - 1);
            (((r * STEPS + g) * STEPS + b) * STEPS + slope) as u16
        };
        let is_seed = (0..w * h).map(is_seed).collect();
        Self { bins: (0..w * h).map(bin).collect(), is_seed, is_near_point }
    }
}

/// The largest difference to the neighbours to the right and below, in greys.
fn gradients(greys: &[f32], [w, h]: [usize; 2]) -> Vec<f32> {
    let slope = |at: usize| {
        let (x, y) = (at % w, at / w);
        let right = if x + 1 < w { (greys[at + 1] - greys[at]).abs() } else { 0.0 };
        let below = if y + 1 < h { (greys[at + w] - greys[at]).abs() } else { 0.0 };
        right.max(below)
    };
    (0..greys.len()).map(slope).collect()
}

/// Keeps the regions that touch the top and that other photos show in the same direction.
fn keep_true(sky: &mut [f32], views: &[WorkingPhoto], of: usize, near: &[u32]) {
    let view = &views[of];
    let [w, _] = view.size();
    let likely: Vec<bool> = sky.iter().map(|sky| *sky > 0.5).collect();
    let (number, sizes) = regions(&likely, view.size());
    let mut touches = vec![false; sizes.len()];
    (0..w).for_each(|x| touches[number[x] as usize] = true);
    let mut sums = vec![(0.0f32, 0u32); sizes.len()];
    for other in near.iter().take(ASKED).map(|i| &views[*i as usize]) {
        let warp = Warp::new((view.camera(), &view.pose), (other.camera(), &other.pose));
        for at in (0..sky.len()).filter(|at| likely[*at]) {
            let inverse = PlaneDepth::FAR.at(at % w, at / w);
            let there = warp.at(middle(at % w, at / w), inverse).and_then(|px| other.greys.at(px));
            if let Some(grey) = there {
                let sum = &mut sums[number[at] as usize];
                *sum = (sum.0 + (grey - view.greys.values[at]).abs(), sum.1 + 1);
            }
        }
    }
    let is_true = |region: usize| {
        touches[region] && sums[region].1 > 0 && sums[region].0 < SAME * sums[region].1 as f32
    };
    for (at, sky) in sky.iter_mut().enumerate() {
        if !is_true(number[at] as usize) {
            *sky = 0.0;
        }
    }
}
