//! Groups of light: photos of one site that were taken in rounds, at another hour or under another sky.

use serde::{Deserialize, Serialize};

use quadratura_base::scene::PhotoId;

/// The least factor of the say of photos of other groups: 1 over this multiplies their penalties at most.
pub(super) const LEAST_SAY: f64 = 0.1;

/// The groups of light of a site's photos.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct LightGroups {
    /// The group of each photo; empty where all are one group.
    of_photo: Vec<u32>,
}

impl LightGroups {
    /// Takes the group of each photo, numbered in any way. Groups are numbered anew, in the order of their first photos.
    pub fn new(of_photo: &[u32]) -> Self {
        let mut seen: Vec<u32> = Vec::new();
        for group in of_photo {
            if !seen.contains(group) {
                seen.push(*group);
            }
        }
        if seen.len() < 2 {
            return Self::default();
        }
        let number = |group: &u32| seen.iter().position(|other| other == group).unwrap_or(0) as u32;
        Self { of_photo: of_photo.iter().map(number).collect() }
    }

    /// Returns true when all photos are one group.
    pub fn is_one(&self) -> bool {
        self.of_photo.is_empty()
    }

    /// Returns the number of groups, at least one.
    pub fn count(&self) -> usize {
        self.of_photo.iter().max().map_or(1, |last| *last as usize + 1)
    }

    /// Returns a photo's group.
    pub fn of(&self, photo: PhotoId) -> usize {
        self.of_photo.get(photo.index()).map_or(0, |group| *group as usize)
    }

    /// Returns the groups of the `kept` photos (in rising order) alone, numbered as these are.
    pub(super) fn of_photos(&self, kept: &[PhotoId]) -> Self {
        Self::new(&kept.iter().map(|photo| self.of(*photo) as u32).collect::<Vec<_>>())
    }

    /// Numbers the photos, which are the `kept` ones of `count`, as among all. Others are in the first group.
    pub(super) fn among(self, kept: &[PhotoId], count: usize) -> Self {
        if self.is_one() {
            return self;
        }
        let mut of_photo = vec![0; count];
        kept.iter().zip(&self.of_photo).for_each(|(photo, group)| of_photo[photo.index()] = *group);
        Self { of_photo }
    }

    /// Returns each group's part of the given shares of photos.
    pub fn parts(&self, of_photo: &[f64]) -> Vec<f64> {
        let mut parts = vec![0.0; self.count()];
        for (photo, share) in PhotoId::all(of_photo.len()).zip(of_photo) {
            parts[self.of(photo)] += share;
        }
        parts
    }

    /// Returns the factors of photos' penalties in a view in which the groups have these parts: 1 in the group with the
    /// largest part, up to 10 in others. They are 1 throughout where no group has a part.
    pub fn leaning(&self, parts: &[f64], photos: usize) -> Vec<f64> {
        let most = parts.iter().copied().fold(0.0, f64::max);
        let factor = |photo: PhotoId| match most > 0.0 {
            true => 1.0 / (parts[self.of(photo)] / most).powi(2).max(LEAST_SAY),
            false => 1.0,
        };
        PhotoId::all(photos).map(factor).collect()
    }

    /// Returns each group's share of a view's exposure, by the squares of their parts; `None` where no group has a part.
    pub fn exposure_shares(parts: &[f64]) -> Option<Vec<f64>> {
        let all: f64 = parts.iter().map(|part| part * part).sum();
        (all > 0.0).then(|| parts.iter().map(|part| part * part / all).collect())
    }
}
