//! The gains that explain the ratios best: least squares made robust by Huber's weights.

use rayon::prelude::*;

use super::groups::LightGroups;
use super::ratios::Ratio;
use quadratura_base::raster::robust::{SIGMA_PER_MAD, upper_median};
use quadratura_base::scene::PhotoId;

/// The result of fitting gains to ratios.
#[derive(Debug, Clone, PartialEq)]
pub struct GainFit {
    /// The log gain of each photo, R, G, B; 0 on average in each component.
    pub of_photo: Vec<[f64; 3]>,
    /// For each photo, the first photo of its component, which is the group that ratios connect it with.
    pub component: Vec<usize>,
    /// The photos without any ratio.
    pub alone: Vec<PhotoId>,
    /// The number of groups of photos connected by ratios.
    pub components: usize,
    /// Median absolute residual, R, G, B.
    pub after: [f64; 3],
}

/// The standard deviation assumed for a gain before any measurement: 0.7 EV.
pub(super) const PRIOR: f64 = 0.5;

/// The same about the exposure that the camera wrote down: a fifth of a stop for shutter, aperture and white balance.
const CAMERA_PRIOR: f64 = 0.15;

/// The number of ratios that count as one against the prior, because ratios at neighbouring points have
/// correlated errors.
pub(super) const CORRELATED: f64 = 10.0;

/// The number of standard deviations beyond which residuals count by their sign rather than by their size; 95
/// % as efficient as least squares on normal errors (Huber 1981).
pub(super) const HUBER: f64 = 1.345;

/// The least standard deviation assumed; ratios of 8-bit values are not more precise, nor need gains be.
pub(super) const LEAST_SIGMA: f64 = 1e-3;

const MOST_ROUNDS: u32 = 50;
const GOOD_ENOUGH: f64 = 1e-7;

/// Finds gains `g` of photos such that each ratio's `log` is about `g[a] - g[b]`: it minimises Huber's loss
/// by reweighted least squares, each channel separately. A weak prior pulls each gain towards what its camera wrote down
/// (`camera`, one value per photo), else towards 0, which matters only to photos with a handful of ratios. Then each component is
/// shifted to the mean of what its cameras wrote down, else to mean 0, and all of them to mean 0.
pub fn solve_gains(camera: &[Option<f64>], ratios: &[Ratio]) -> GainFit {
    let component = components(camera.len(), ratios);
    let channels: Vec<Channel> =
        (0..3).into_par_iter().map(|channel| solve_channel(camera, ratios, channel, &component)).collect();
    let of_photo = (0..camera.len()).map(|photo| [0, 1, 2].map(|c| channels[c].gains[photo])).collect();
    let (mut alone, components) = alone_and_components(&component);
    alone.retain(|photo| camera[photo.index()].is_none());
    GainFit { of_photo, alone, components, after: [0, 1, 2].map(|c| channels[c].after), component }
}

/// As [`solve_gains`], from ratios within groups of light alone. The groups are then shifted against each other so that they
/// agree best at common points, where shadows count as little as other outliers.
pub fn solve_in_groups(photo_count: usize, ratios: &[Ratio], groups: &LightGroups) -> GainFit {
    let no_camera = vec![None; photo_count];
    if groups.is_one() {
        return solve_gains(&no_camera, ratios);
    }
    let (within, across): (Vec<Ratio>, Vec<Ratio>) =
        ratios.iter().partition(|ratio| groups.of(ratio.a) == groups.of(ratio.b));
    let inner = solve_gains(&no_camera, &within);
    let shifted = across.into_iter().map(|ratio| {
        let [a, b] = [ratio.a, ratio.b].map(|photo| photo.index());
        let gain = |c: usize| inner.of_photo[a][c] - inner.of_photo[b][c];
        let log = [0, 1, 2].map(|c| (f64::from(ratio.log[c]) - gain(c)) as f32);
        let [a, b] = [a, b].map(|photo| PhotoId::new(inner.component[photo]));
        Ratio { a, b, log, ..ratio }
    });
    let outer = solve_gains(&no_camera, &shifted.collect::<Vec<_>>());
    let component: Vec<usize> = inner.component.iter().map(|unit| outer.component[*unit]).collect();
    let mut of_photo = vec![[0.0; 3]; photo_count];
    for c in 0..3 {
        let gain = |photo: usize| inner.of_photo[photo][c] + outer.of_photo[inner.component[photo]][c];
        let mut gains: Vec<f64> = (0..photo_count).map(gain).collect();
        centre(&mut gains, &component, &no_camera);
        of_photo.iter_mut().zip(gains).for_each(|(of_photo, gain)| of_photo[c] = gain);
    }
    let (alone, components) = alone_and_components(&component);
    GainFit { of_photo, component, alone, components, after: inner.after }
}

/// Returns the photos that are components of their own, and the number of all other components.
fn alone_and_components(component: &[usize]) -> (Vec<PhotoId>, usize) {
    let mut sizes = vec![0u32; component.len()];
    component.iter().for_each(|root| sizes[*root] += 1);
    let alone = (0..component.len()).filter(|photo| sizes[component[*photo]] == 1);
    (alone.map(PhotoId::new).collect(), sizes.iter().filter(|size| **size > 1).count())
}

struct Channel {
    gains: Vec<f64>,
    after: f64,
}

fn solve_channel(camera: &[Option<f64>], ratios: &[Ratio], channel: usize, component: &[usize]) -> Channel {
    let mut gains = vec![0.0; camera.len()];
    let mut median = median_residual(ratios, channel, &gains);
    for _ in 0..MOST_ROUNDS {
        let sigma = (SIGMA_PER_MAD * median).max(LEAST_SIGMA);
        let next = reweighted(ratios, channel, &gains, sigma, camera);
        let moved = gains.iter().zip(&next).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        gains = next;
        median = median_residual(ratios, channel, &gains);
        if moved < GOOD_ENOUGH {
            break;
        }
    }
    centre(&mut gains, component, camera);
    Channel { after: median_residual(ratios, channel, &gains), gains }
}

/// Does one round: finds the minimum of the quadratic that touches Huber's loss at `gains`.
fn reweighted(
    ratios: &[Ratio],
    channel: usize,
    gains: &[f64],
    sigma: f64,
    camera: &[Option<f64>],
) -> Vec<f64> {
    let n = gains.len();
    let mut normal = vec![0.0; n * n];
    let mut right = vec![0.0; n];
    for ratio in ratios {
        let (a, b) = (ratio.a.0 as usize, ratio.b.0 as usize);
        let log = f64::from(ratio.log[channel]);
        let off = (log - (gains[a] - gains[b])).abs();
        let weight = f64::from(ratio.weight) * (HUBER * sigma / off).min(1.0);
        normal[a * n + a] += weight;
        normal[b * n + b] += weight;
        normal[a * n + b] -= weight;
        normal[b * n + a] -= weight;
        right[a] += weight * log;
        right[b] -= weight * log;
    }
    for (i, camera) in camera.iter().enumerate() {
        let deviation = if camera.is_some() { CAMERA_PRIOR } else { PRIOR };
        let prior = CORRELATED * (sigma / deviation).powi(2);
        normal[i * n + i] += prior;
        right[i] += prior * camera.unwrap_or(0.0);
    }
    cholesky_solve(normal, right)
}

/// Solves `a x = b` for a symmetric positive definite `a` (n x n, by rows), in place.
pub(super) fn cholesky_solve(mut a: Vec<f64>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for j in 0..n {
        let (above, below) = a.split_at_mut((j + 1) * n);
        let row = &mut above[j * n..];
        let pivot = (row[j] - row[..j].iter().map(|l| l * l).sum::<f64>()).sqrt();
        row[j] = pivot;
        for lower in below.chunks_exact_mut(n) {
            let known: f64 = lower[..j].iter().zip(&row[..j]).map(|(x, y)| x * y).sum();
            lower[j] = (lower[j] - known) / pivot;
        }
    }
    for i in 0..n {
        let known: f64 = (0..i).map(|k| a[i * n + k] * b[k]).sum();
        b[i] = (b[i] - known) / a[i * n + i];
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|k| a[k * n + i] * b[k]).sum();
        b[i] = (b[i] - known) / a[i * n + i];
    }
    b
}

/// Returns the median absolute residual of a channel; 0 without ratios.
pub(super) fn median_residual(ratios: &[Ratio], channel: usize, gains: &[f64]) -> f64 {
    let off = |r: &Ratio| (f64::from(r.log[channel]) - (gains[r.a.0 as usize] - gains[r.b.0 as usize])).abs();
    let mut residuals: Vec<f64> = ratios.iter().map(off).collect();
    upper_median(&mut residuals).unwrap_or(0.0)
}

/// Returns, for each photo, the first photo of its component.
fn components(photo_count: usize, ratios: &[Ratio]) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..photo_count).collect();
    fn root(parent: &mut [usize], mut at: usize) -> usize {
        while parent[at] != at {
            parent[at] = parent[parent[at]];
            at = parent[at];
        }
        at
    }
    for ratio in ratios {
        let (a, b) = (root(&mut parent, ratio.a.0 as usize), root(&mut parent, ratio.b.0 as usize));
        parent[a.max(b)] = a.min(b);
    }
    (0..photo_count).map(|photo| root(&mut parent, photo)).collect()
}

/// Shifts each component to the mean of what its cameras wrote down, or to mean 0 where none did; then all of them together to
/// mean 0.
fn centre(gains: &mut [f64], component: &[usize], camera: &[Option<f64>]) {
    let by_camera =
        |root: usize| component.iter().zip(camera).any(|(own, log)| *own == root && log.is_some());
    let knows: Vec<bool> = (0..gains.len()).map(|root| component[root] == root && by_camera(root)).collect();
    let mut sums = vec![(0.0, 0u32); gains.len()];
    for ((gain, root), camera) in gains.iter().zip(component).zip(camera) {
        if camera.is_some() || !knows[*root] {
            sums[*root].0 += gain - camera.unwrap_or(0.0);
            sums[*root].1 += 1;
        }
    }
    for (gain, root) in gains.iter_mut().zip(component) {
        *gain -= sums[*root].0 / f64::from(sums[*root].1);
    }
    if knows.contains(&true) {
        let mean = gains.iter().sum::<f64>() / gains.len() as f64;
        gains.iter_mut().for_each(|gain| *gain -= mean);
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    #[test]
    fn a_positive_definite_system_is_solved() {
        let mut rng = Rng::new(1);
        let n = 9;
        let m: Vec<f64> = (0..n * n).map(|_| rng.between(-1.0, 1.0)).collect();
        let row = |i: usize| &m[i * n..(i + 1) * n];
        let product = |i: usize, j: usize| -> f64 { row(i).iter().zip(row(j)).map(|(x, y)| x * y).sum() };
        let a: Vec<f64> =
            (0..n * n).map(|k| product(k / n, k % n) + f64::from(u8::from(k / n == k % n))).collect();
        let x: Vec<f64> = (0..n).map(|i| i as f64 - 4.0).collect();
        let b: Vec<f64> = (0..n).map(|i| (0..n).map(|j| a[i * n + j] * x[j]).sum()).collect();
        let found = cholesky_solve(a, b);
        assert!(found.iter().zip(&x).all(|(f, x)| (f - x).abs() < 1e-9), "{found:?}");
    }

    fn ratio(a: u32, b: u32, log: f32) -> Ratio {
        let (light, at_px) = ([0.5; 2], [Vec2::ZERO; 2]);
        Ratio { a: PhotoId(a), b: PhotoId(b), log: [log; 3], weight: 1.0, light, at_px }
    }

    #[test]
    fn a_single_doubtful_ratio_moves_a_photo_less_than_many() {
        let noisy = |k: u32| 0.05 * f64::from(k).sin() as f32;
        let known: Vec<Ratio> = (0..500).map(|k| ratio(0, 1, 0.2 + noisy(k))).collect();
        let many: Vec<Ratio> = (0..500).map(|k| ratio(2, 0, 0.4 + noisy(k))).collect();
        let step = |weak: &[Ratio]| {
            let fit = solve_gains(&[None; 3], &[&known, weak].concat());
            fit.of_photo[2][0] - fit.of_photo[0][0]
        };
        assert!((step(&many) - 0.4).abs() < 0.005, "{}", step(&many));
        let single = step(&[ratio(2, 0, 0.4)]);
        assert!(single > 0.1 && single < 0.39, "{single}");
    }

    #[test]
    fn without_ratios_there_are_no_gains() {
        let fit = solve_gains(&[None; 3], &[]);
        assert_eq!(fit.of_photo, [[0.0; 3]; 3]);
        assert_eq!((fit.alone.len(), fit.components), (3, 0));
        assert_eq!(solve_gains(&[], &[]).of_photo, Vec::<[f64; 3]>::new());
    }

    #[test]
    fn what_cameras_wrote_down_joins_photos_that_share_no_point_and_yields_to_many_that_do() {
        let known: Vec<Ratio> = (0..500).map(|k| ratio(0, 1, 0.2 + 0.05 * (k as f32).sin())).collect();
        // The first two are 0.2 apart by their points and 0.3 by their cameras; the third is known by its camera alone.
        let fit = solve_gains(&[Some(0.2), Some(-0.1), Some(-0.1)], &known);
        let gain = |photo: usize| fit.of_photo[photo][1];
        assert!((gain(0) - gain(1) - 0.2).abs() < 0.01, "{:?}", fit.of_photo);
        assert!((0.5 * (gain(0) + gain(1)) - gain(2) - 0.15).abs() < 1e-6, "{:?}", fit.of_photo);
        assert!((gain(0) + gain(1) + gain(2)).abs() < 1e-9 && fit.alone.is_empty());
        let without = solve_gains(&[Some(0.2), Some(-0.1), None], &known);
        assert_eq!(without.alone, [PhotoId(2)]);
    }
}
