//! Colours of a thing as a few normal distributions of log colour.

use glam::{Mat3, Vec3};

/// Linear light below which differences are noise.
const DARK: f32 = 0.01;

/// The variance of log colour that every distribution has at least: a tenth of the light, the noise and shading of one
/// surface.
const LEAST_VARIANCE: f32 = 0.01;

/// The number of distributions: leaves in sun and shade, stems, and what shines through make six.
const MOST: usize = 6;

/// The number of rounds in which samples are given to the nearest distribution; later ones change little.
const ROUNDS: usize = 12;

/// The least number of samples of a distribution, and their least share: fewer are strays.
const LEAST_SAMPLES: usize = 20;
const LEAST_SHARE: f32 = 0.02;

/// Returns the log colour of linear light.
pub fn log_colour(light: Vec3) -> Vec3 {
    (light.clamp(Vec3::ZERO, Vec3::ONE) + DARK).map(f32::ln)
}

/// A normal distribution with its share.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Normal {
    mean: Vec3,
    inverse: Mat3,
    /// The logarithm of share over the root of the determinant of the covariance.
    log_factor: f32,
}

/// The colours of a thing.
#[derive(Debug, Clone, PartialEq)]
pub struct ColourModel {
    parts: Vec<Normal>,
}

impl ColourModel {
    /// Fits a model to samples of log colour; `None` for too few of them. The result depends on their order.
    pub fn fit(samples: &[Vec3]) -> Option<Self> {
        if samples.len() < LEAST_SAMPLES {
            return None;
        }
        let mut means = seeds(samples);
        let mut group = vec![0; samples.len()];
        for _ in 0..ROUNDS {
            for (sample, group) in samples.iter().zip(&mut group) {
                *group = nearest(&means, *sample);
            }
            for (index, mean) in means.iter_mut().enumerate() {
                let (sum, count) = samples
                    .iter()
                    .zip(&group)
                    .filter(|(_, group)| **group == index)
                    .fold((Vec3::ZERO, 0usize), |(sum, count), (sample, _)| (sum + *sample, count + 1));
                *mean = if count > 0 { sum / count as f32 } else { *mean };
            }
        }
        let of_group = |index: usize| {
            let own: Vec<Vec3> =
                samples.iter().zip(&group).filter(|(_, group)| **group == index).map(|(s, _)| *s).collect();
            let share = own.len() as f32 / samples.len() as f32;
            (own.len() >= LEAST_SAMPLES && share >= LEAST_SHARE).then(|| Normal::of(&own, share))
        };
        let parts: Vec<Normal> = (0..means.len()).filter_map(of_group).collect();
        (!parts.is_empty()).then_some(Self { parts })
    }

    /// Returns the logarithm of the density at a log colour, up to a constant that all models share.
    pub fn log_density(&self, colour: Vec3) -> f32 {
        let mut values = [f32::NEG_INFINITY; MOST];
        for (value, part) in values.iter_mut().zip(&self.parts) {
            let off = colour - part.mean;
            *value = part.log_factor - 0.5 * off.dot(part.inverse * off);
        }
        let most = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        most + values.iter().map(|value| (value - most).exp()).sum::<f32>().ln()
    }
}

impl Normal {
    fn of(samples: &[Vec3], share: f32) -> Self {
        let mean = samples.iter().sum::<Vec3>() / samples.len() as f32;
        let mut covariance = Mat3::ZERO;
        for sample in samples {
            let off = *sample - mean;
            covariance += Mat3::from_cols(off * off.x, off * off.y, off * off.z);
        }
        let covariance =
            covariance * (1.0 / samples.len() as f32) + Mat3::from_diagonal(Vec3::splat(LEAST_VARIANCE));
        let log_factor = share.ln() - 0.5 * covariance.determinant().ln();
        Self { mean, inverse: covariance.inverse(), log_factor }
    }
}

/// Returns the first means: that of all samples, and then each time a sample that is farther from the means than all but
/// one in a hundred.
fn seeds(samples: &[Vec3]) -> Vec<Vec3> {
    let mut means = vec![samples.iter().sum::<Vec3>() / samples.len() as f32];
    let mut far: Vec<(f32, usize)> = Vec::with_capacity(samples.len());
    while means.len() < MOST {
        far.clear();
        let distance = |sample: &Vec3| {
            means.iter().map(|mean| mean.distance_squared(*sample)).fold(f32::INFINITY, f32::min)
        };
        far.extend(samples.iter().map(distance).zip(0..));
        let rank = samples.len() * 99 / 100;
        let (_, chosen, _) = far.select_nth_unstable_by(rank, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        means.push(samples[chosen.1]);
    }
    means
}

fn nearest(means: &[Vec3], sample: Vec3) -> usize {
    let distance = |index: &usize| means[*index].distance_squared(sample);
    (0..means.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    #[test]
    fn samples_of_two_colours_are_likely_and_what_lies_between_them_is_not() {
        let mut rng = Rng::new(5);
        let mut around = |light: Vec3| {
            let noise = Vec3::from_array([0.0; 3].map(|_: f32| rng.between(-0.05, 0.05) as f32));
            log_colour(light) + noise
        };
        let (leaf, stem) = (Vec3::new(0.05, 0.2, 0.02), Vec3::new(0.3, 0.2, 0.1));
        let samples: Vec<Vec3> = (0..400).map(|i| around(if i % 4 == 0 { stem } else { leaf })).collect();
        let model = ColourModel::fit(&samples).unwrap();
        let density = |light: Vec3| model.log_density(log_colour(light));
        assert!(density(leaf) > density(0.5 * (leaf + stem)) + 3.0);
        assert!(density(stem) > density(0.5 * (leaf + stem)) + 3.0);
        assert!(density(leaf) > density(Vec3::new(0.3, 0.5, 0.9)) + 20.0);
        assert_eq!(ColourModel::fit(&samples[..5]), None);
    }
}
