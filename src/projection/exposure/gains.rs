//! The gains of photos, with all that views are exposed by.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::camera::CameraExposures;
use super::light::SiteLight;
use super::meter::Meter;
use super::rule::ExposureRule;
use super::surroundings::SurroundingsGains;
use quadratura_base::scene::PhotoId;
use quadratura_view::optics::Optics;

/// The photos' gains, their optics, and the model of exposure metering.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Gains {
    /// The gain of each photo, in the order of [`crate::Sources::photos`]: natural logarithm of photo /
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
    pub(super) fn has_vignetting(&self) -> bool {
        self.optics.iter().any(|optics| optics.falloff != [0.0; 2])
    }

    /// Returns the same with these gains of the surroundings.
    pub fn with_surroundings(self, surroundings: Arc<SurroundingsGains>) -> Self {
        Self { surroundings, ..self }
    }

    /// Numbers the photos, which are the `kept` ones (in rising order) of `count`, as among all.
    pub(super) fn among(self, kept: &[PhotoId], count: usize) -> Self {
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
