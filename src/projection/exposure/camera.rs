//! What cameras wrote down about their exposures: time, aperture and sensitivity.
//!
//! They tell the gains of photos up to a constant, unless something between light and file is not written down: a filter in front of
//! the lens, a sensitivity that was set by hand on an old lens or film, a raw file that was developed brighter. So they are compared
//! with what common points say, and only those that agree with it are used: as a prior of the gains, which decides for photos that
//! share few points or none, and for views that are to look like a photo whose camera wrote down its exposure.

use serde::{Deserialize, Serialize};

use super::groups::LightGroups;
use super::ratios::Ratio;
use super::solve::{GainFit, solve_gains, solve_in_groups};
use quadratura_base::raster::robust::upper_median;

/// The distance, as a natural logarithm, from what common points say at which a camera is not believed: half a stop. Apertures and
/// shutters keep their numbers within a sixth, and meters of brightness within a quarter.
const MOST_OFF: f64 = 0.35;

/// The share of the photos that can be checked from which on all are believed.
const MOST_AGREE: f64 = 2.0 / 3.0;

/// The least number of photos that can check each other.
const FEWEST: usize = 3;

/// The exposures that cameras wrote down, as far as they are believed.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CameraExposures {
    /// The exposure of each photo as a natural logarithm, 0 on average over those that are known; `None` for photos of which none is
    /// written down or believed. Empty where none is.
    pub of_photo: Vec<Option<f64>>,
    /// What was subtracted to make them so.
    pub level: f64,
    /// How many photos have one written down.
    pub written: usize,
    /// The median distance, as a natural logarithm, of those that could be checked from what common points say; `None` where none
    /// could.
    pub off: Option<f64>,
    /// Whether left-out photos are predicted at least as well in the exposure that their cameras wrote down as by the rule.
    pub suits_views: bool,
}

impl CameraExposures {
    /// Decides which exposures are believed. `logs` are those that are written down, as natural logarithms; `fit` are the gains
    /// without them.
    pub(super) fn believed(logs: &[Option<f64>], fit: &GainFit) -> Self {
        let written = logs.iter().flatten().count();
        if written == 0 {
            return Self::default();
        }
        let distances = distances(logs, fit);
        let is_near = |distance: &f64| *distance <= MOST_OFF;
        let checked: Vec<f64> = distances.iter().flatten().copied().collect();
        let near = checked.iter().filter(|distance| is_near(distance)).count();
        let off = upper_median(&mut checked.clone());
        if (near as f64) < MOST_AGREE * checked.len() as f64 {
            return Self { written, off, ..Self::default() };
        }
        let believed = |(log, distance): (&Option<f64>, &Option<f64>)| {
            log.filter(|_| distance.as_ref().is_none_or(is_near))
        };
        let mut of_photo: Vec<Option<f64>> = logs.iter().zip(&distances).map(believed).collect();
        let level = of_photo.iter().flatten().sum::<f64>() / of_photo.iter().flatten().count().max(1) as f64;
        of_photo.iter_mut().flatten().for_each(|log| *log -= level);
        Self { of_photo, level, written, off, suits_views: false }
    }

    /// Returns how many photos' exposures are believed.
    pub fn used(&self) -> usize {
        self.of_photo.iter().flatten().count()
    }

    /// Numbers the photos, which are the `kept` ones of `count`, as among all.
    pub(super) fn among(self, kept: impl Iterator<Item = usize>, count: usize) -> Self {
        if self.of_photo.is_empty() {
            return self;
        }
        let mut of_photo = vec![None; count];
        kept.zip(self.of_photo).for_each(|(photo, log)| of_photo[photo] = log);
        Self { of_photo, ..self }
    }
}

/// Finds gains from ratios, with what cameras wrote down as a prior where the ratios bear it out. Between groups of light the light
/// differs, too, so that there cameras say nothing.
pub(super) fn fit_with_cameras(
    logs: &[Option<f64>],
    ratios: &[Ratio],
    groups: &LightGroups,
) -> (GainFit, CameraExposures) {
    let fit = solve_in_groups(logs.len(), ratios, groups);
    if !groups.is_one() {
        return (fit, CameraExposures::default());
    }
    let camera = CameraExposures::believed(logs, &fit);
    if camera.used() == 0 { (fit, camera) } else { (solve_gains(&camera.of_photo, ratios), camera) }
}

/// Returns how far each photo's written exposure is from what its points say, relative to the median of the photos that share points
/// with it; `None` where too few do.
fn distances(logs: &[Option<f64>], fit: &GainFit) -> Vec<Option<f64>> {
    let difference = |photo: usize| {
        let mean = fit.of_photo[photo].iter().sum::<f64>() / 3.0;
        Some(mean - logs[photo]?)
    };
    let usual = |component: usize| {
        let own = (0..logs.len()).filter(|photo| fit.component[*photo] == component);
        let mut differences: Vec<f64> = own.filter_map(difference).collect();
        if differences.len() < FEWEST { None } else { upper_median(&mut differences) }
    };
    let distance = |photo: usize| Some((difference(photo)? - usual(fit.component[photo])?).abs());
    (0..logs.len()).map(distance).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(gains: &[f64], component: &[usize]) -> GainFit {
        GainFit {
            of_photo: gains.iter().map(|gain| [*gain; 3]).collect(),
            component: component.to_vec(),
            alone: Vec::new(),
            components: 1,
            after: [0.0; 3],
        }
    }

    #[test]
    fn cameras_are_believed_where_points_agree_and_a_stray_one_is_not() {
        let logs = [Some(3.0), Some(3.5), Some(2.0), Some(4.0), None, Some(9.0)];
        let points = fit(&[0.0, 0.5, -1.0, 0.0, 0.2, 0.0], &[0, 0, 0, 0, 0, 5]);
        let found = CameraExposures::believed(&logs, &points);
        // A filter took one stop and a half from the fourth; nobody shares a point with the last.
        let level = (3.0 + 3.5 + 2.0 + 9.0) / 4.0;
        let expected =
            [3.0, 3.5, 2.0, f64::NAN, f64::NAN, 9.0].map(|log: f64| (!log.is_nan()).then_some(log - level));
        assert_eq!((found.of_photo, found.level, found.written), (expected.to_vec(), level, 5));
    }

    #[test]
    fn where_most_disagree_none_is_believed_and_where_none_can_be_checked_all_are() {
        let logs = [Some(3.0), Some(3.0), Some(3.0), Some(3.0)];
        let by_hand = fit(&[0.0, 1.0, -1.0, 0.1], &[0; 4]);
        let found = CameraExposures::believed(&logs, &by_hand);
        assert_eq!((found.used(), found.written), (0, 4));
        assert!(found.off.is_some_and(|off| off > MOST_OFF));
        let apart = CameraExposures::believed(&[Some(1.0), Some(2.0)], &fit(&[0.0; 2], &[0, 1]));
        assert_eq!((apart.of_photo, apart.off), (vec![Some(-0.5), Some(0.5)], None));
        assert_eq!(CameraExposures::believed(&[None; 4], &by_hand), CameraExposures::default());
    }
}
