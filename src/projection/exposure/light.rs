//! The light of a site with several groups: which photos share it, and their exposure meters.

use serde::{Deserialize, Serialize};

use super::gains::Gains;
use super::groups::LightGroups;
use super::meter::Meter;
use super::near::Shares;
use super::surface_gains::SurfaceGains;
use quadratura_base::geometry::Pose;
use quadratura_base::scene::PhotoId;

/// The light of a site. For a site with one group it is empty: there is nothing to tell apart.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SiteLight {
    /// The groups of light.
    pub groups: LightGroups,
    /// The gains with all photos in one group, for views without the exposure of one photo, where that predicts photos better
    /// than leaning to the groups that a view shows most of.
    pub blended: Option<Box<Gains>>,
    /// The model of metering of each group.
    pub meters: Vec<Meter>,
    /// The mean log gain of each group, of the photos that have one.
    pub means: Vec<[f64; 3]>,
    /// The light of the groups on single surfaces; empty where that predicts photos no better.
    pub surfaces: SurfaceGains,
}

impl SiteLight {
    /// Returns the sum over groups of what each meter says of a view, with the shares of its photos alone.
    pub(super) fn metered(
        &self,
        view: &Pose,
        shares: &Shares,
        says: impl Fn(&Meter, &Pose, &Shares) -> [f64; 3],
    ) -> [f64; 3] {
        let parts = self.groups.parts(&shares.of_photo);
        let mut sum = [0.0; 3];
        for (group, (meter, part)) in
            self.meters.iter().zip(&parts).enumerate().filter(|(_, (_, part))| **part > 0.0)
        {
            let said = says(meter, view, &shares.of_group(&self.groups, group, *part));
            (0..3).for_each(|c| sum[c] += part * said[c]);
        }
        sum
    }
}

impl Shares {
    /// Returns the shares of a view that leans to the groups that it shows most of: within a group the photos keep their
    /// proportions, and groups have the squares of their parts.
    pub(super) fn leaned(&self, groups: &LightGroups, parts: &[f64]) -> Self {
        let Some(exposure) = LightGroups::exposure_shares(parts) else { return self.clone() };
        let all: f64 = self.of_photo.iter().sum();
        let factor =
            |group: usize| if parts[group] > 0.0 { all * exposure[group] / parts[group] } else { 0.0 };
        let of_photo = PhotoId::all(self.of_photo.len()).zip(&self.of_photo);
        let of_photo = of_photo.map(|(photo, share)| share * factor(groups.of(photo))).collect();
        Self { of_photo, ..self.clone() }
    }

    /// Returns the shares as if one group, which has this part, were all.
    fn of_group(&self, groups: &LightGroups, group: usize, part: f64) -> Self {
        let is_its = |photo: PhotoId| groups.of(photo) == group;
        let photos = || PhotoId::all(self.of_photo.len());
        let share = |(photo, share): (PhotoId, &f64)| if is_its(photo) { share / part } else { 0.0 };
        Self {
            of_photo: photos().zip(&self.of_photo).map(share).collect(),
            of_common: 0.0,
            takes_part: photos()
                .zip(&self.takes_part)
                .map(|(photo, takes)| *takes && is_its(photo))
                .collect(),
        }
    }
}
