//! The exposure of a view: a blend of the photos' gains, by their shares of the image or by nearness,
//! corrected by the reading of the view's exposure meter.

use super::gains::Gains;
use super::groups::LightGroups;
use super::meter::Meter;
use super::near::Shares;
use super::surface_gains::SurfaceFactors;
use super::surroundings::SurroundingsExposure;
use crate::Projector;
use quadratura_base::geometry::Pose;
use quadratura_base::scene::PhotoId;
use quadratura_view::optics::{Optics, ViewLens};
use quadratura_view::{Exposure, Shot};

/// The share of a view from which on a photo's own exposure counts under any rule; only one photo can have as much.
const OWN_FROM: f64 = 0.9;

/// What a view does with the light of photos.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ViewExposure {
    /// The factors on the photos' linear colours, R, G, B.
    pub factors: Vec<[f64; 3]>,
    /// The factor on linear colours in the common exposure, such as those of the dome.
    pub of_common: [f64; 3],
    /// The lens that darkens the view.
    pub lens: ViewLens,
    /// The factors of the photos' penalties, 1 or more: a view leans to the groups of light that it shows most of. Empty
    /// where all photos are one group, and where views do not lean.
    pub leaning: Vec<f64>,
    /// The factors that bring photos of other groups to the light to which the view leans, by surface.
    pub surfaces: SurfaceFactors,
    /// What the view does with the surroundings.
    pub surroundings: SurroundingsExposure,
}

impl ViewExposure {
    /// Returns the exposure that shows photos unchanged.
    pub fn neutral(photo_count: usize) -> Self {
        Self { factors: vec![[1.0; 3]; photo_count], of_common: [1.0; 3], ..Self::default() }
    }

    /// Returns the factor of a photo's penalties; 1 for the dome, whose ids follow the photos'.
    pub fn leaning_of(&self, photo: PhotoId) -> f64 {
        self.leaning.get(photo.index()).copied().unwrap_or(1.0)
    }

    /// Returns the factor on a photo's linear colours, or on those of the dome, whose ids follow the photos'.
    pub fn factor(&self, photo: PhotoId) -> [f64; 3] {
        let SurroundingsExposure { of_sky, dome_white, .. } = self.surroundings;
        let of_dome = || [0, 1, 2].map(|c| self.of_common[c] * of_sky[c] * dome_white);
        self.factors.get(photo.index()).copied().unwrap_or_else(of_dome)
    }
}

impl Gains {
    /// Computes the exposure of a view of `photos`. `shares` is called only when it is needed.
    pub fn exposed(
        &self,
        shot: &Shot,
        photos: &[Projector],
        shares: impl FnOnce() -> Shares,
    ) -> ViewExposure {
        let exposed = self.exposed_surfaces(shot, photos, shares);
        let around = &self.surroundings;
        let surroundings = match self.exposure(shot) {
            Exposure::Raw => SurroundingsExposure {
                left: around.left(shot, photos),
                dome_white: f64::from(around.dome_white),
                ..SurroundingsExposure::default()
            },
            Exposure::Of(photo) => around.exposed(shot, photos, &Shares::of_one(photo, photos.len())),
            _ => {
                let reach = around.scale.max(f64::MIN_POSITIVE);
                around.exposed(shot, photos, &Shares::new(&shot.pose, reach, photos, &shot.without))
            }
        };
        ViewExposure { surroundings, ..exposed }
    }

    /// Computes the exposure of what is near.
    fn exposed_surfaces(
        &self,
        shot: &Shot,
        photos: &[Projector],
        shares: impl FnOnce() -> Shares,
    ) -> ViewExposure {
        let exposure = self.exposure(shot);
        if let Some(blended) = self.blended(shot) {
            return blended.exposed_surfaces(shot, photos, shares);
        }
        if !self.light.groups.is_one() {
            return self.exposed_in_groups(shot, photos, exposure, shares);
        }
        if !self.keeps_vignetting || exposure == Exposure::Raw {
            return self.view_exposure(shot, shares, ViewLens::default());
        }
        let shares = match exposure {
            Exposure::Of(photo) => Shares::of_one(photo, photos.len()),
            _ => shares(),
        };
        let lens = self.lens(photos, &shares);
        self.view_exposure(shot, || shares, lens)
    }

    /// Returns the gains of a view that does not lean, although there are several groups.
    fn blended(&self, shot: &Shot) -> Option<&Self> {
        self.light.blended.as_deref().filter(|_| !matches!(self.exposure(shot), Exposure::Of(_)))
    }

    fn view_exposure(&self, shot: &Shot, shares: impl FnOnce() -> Shares, lens: ViewLens) -> ViewExposure {
        let factors = self.factors(shot, shares);
        // Every photo's factor is the view's gain over its own.
        let of_common = match (factors.first(), self.of_photo.first()) {
            (Some(factor), Some(gain)) if self.exposure(shot) != Exposure::Raw => {
                [0, 1, 2].map(|c| factor[c] * gain[c].exp())
            }
            _ => [1.0; 3],
        };
        ViewExposure { factors, of_common, lens, ..ViewExposure::default() }
    }

    /// Computes the exposure of a view of several groups of light. With the exposure of one photo it leans to that photo's
    /// group alone, else to the groups that it shows most of.
    fn exposed_in_groups(
        &self,
        shot: &Shot,
        photos: &[Projector],
        exposure: Exposure,
        shares: impl FnOnce() -> Shares,
    ) -> ViewExposure {
        let groups = &self.light.groups;
        let shares = match exposure {
            Exposure::Of(photo) => Shares::of_one(photo, photos.len()),
            _ => shares(),
        };
        let parts = groups.parts(&shares.of_photo);
        let surfaces = LightGroups::exposure_shares(&parts).filter(|_| exposure != Exposure::Raw);
        let surfaces =
            surfaces.map(|shares| self.light.surfaces.towards(&shares, groups)).unwrap_or_default();
        let (leaning, shares) = (groups.leaning(&parts, photos.len()), shares.leaned(groups, &parts));
        let lens = if exposure == Exposure::Raw { ViewLens::default() } else { self.lens(photos, &shares) };
        ViewExposure { leaning, surfaces, ..self.view_exposure(shot, || shares, lens) }
    }

    /// Computes the log gain of a view by its meter reading alone.
    pub(super) fn metered(&self, view: &Pose, shares: &Shares) -> [f64; 3] {
        if self.light.groups.is_one() {
            return self.meter.metered(view, shares);
        }
        let (says, common) = (self.light.metered(view, shares, Meter::metered), self.common(shares));
        [0, 1, 2].map(|c| says[c] + common[c])
    }

    /// Computes the log gain of a view in the common exposure of the groups of light that it shows; 0 for one group.
    pub(super) fn common(&self, shares: &Shares) -> [f64; 3] {
        if self.light.groups.is_one() {
            return [0.0; 3];
        }
        let parts = self.light.groups.parts(&shares.of_photo);
        [0, 1, 2].map(|c| parts.iter().zip(&self.light.means).map(|(part, mean)| part * mean[c]).sum())
    }

    /// Returns the lens of a view to which photos contribute with these shares; neutral where views keep no vignetting, and
    /// where no photo contributes.
    pub(super) fn lens(&self, photos: &[Projector], shares: &Shares) -> ViewLens {
        if !self.keeps_vignetting {
            return ViewLens::default();
        }
        let of_photo = photos.iter().zip(&self.optics).zip(&shares.of_photo);
        ViewLens::mean(of_photo.map(|((photo, optics), share)| (optics, &photo.camera, *share)))
    }

    /// Computes the factors on the photos' linear colours in a view, R, G, B. `shares` is called only when
    /// the view has an exposure of its own.
    pub fn factors(&self, shot: &Shot, shares: impl FnOnce() -> Shares) -> Vec<[f64; 3]> {
        let view = match self.exposure(shot) {
            Exposure::Near | Exposure::Decided => self.of_view(&shot.pose, &shares()),
            Exposure::Raw => return vec![[1.0; 3]; self.of_photo.len()],
            Exposure::AsTaken(log) => self.as_taken(log, &shares()),
            exposure if is_decided(shot.exposure) => self.near_photos(exposure, shot, &shares()),
            Exposure::Metered => self.metered(&shot.pose, &shares()),
            Exposure::Common => [0.0; 3],
            Exposure::Of(photo) => self.of_photo[photo.index()],
        };
        self.of_photo.iter().map(|gain| [0, 1, 2].map(|c| (view[c] - gain[c]).exp())).collect()
    }

    /// Computes the log gain of a view by the site's rule, which is metered or common. Where a photo has nearly all of the
    /// view, the gain goes over to that photo's: a photo's own camera shows the photo under any rule.
    fn near_photos(&self, exposure: Exposure, shot: &Shot, shares: &Shares) -> [f64; 3] {
        let rule = match exposure {
            Exposure::Metered => self.metered(&shot.pose, shares),
            _ => self.common(shares),
        };
        let own = |share: f64| {
            let t = ((share - OWN_FROM) / (1.0 - OWN_FROM)).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        };
        let of_photo = shares.of_photo.iter().zip(&self.of_photo);
        of_photo
            .fold(rule, |view, (share, gain)| [0, 1, 2].map(|c| view[c] + own(*share) * (gain[c] - rule[c])))
    }

    /// Returns the vignetting and offset that have to be removed from a photo's colours before [`Self::factors`] are
    /// applied. They are neutral where the view shows the photos unchanged, and for the dome, which was made
    /// without them.
    pub fn optics(&self, shot: &Shot, photo: PhotoId) -> Optics {
        let optics = self.blended(shot).map_or(&self.optics, |blended| &blended.optics);
        let of_photo = optics.get(photo.index()).filter(|_| self.exposure(shot) != Exposure::Raw);
        of_photo.copied().unwrap_or_default()
    }

    /// Returns the exposure of a view after the site's rule was applied. The exposure of a photo that is left out is
    /// unknown, so that it is that of a new view from there.
    fn exposure(&self, shot: &Shot) -> Exposure {
        match shot.exposure {
            Exposure::Decided => self.rule.exposure(),
            Exposure::AsTaken(_) if !self.camera.suits_views => self.rule.exposure(),
            Exposure::Of(photo) if shot.without.contains(&photo) => self.rule.exposure(),
            exposure => exposure,
        }
    }

    /// Computes the log gain of a view whose camera wrote down this exposure, as a natural logarithm. What gains have beside the
    /// cameras' exposures, white balance and filters, comes from the photos of the view.
    pub(super) fn as_taken(&self, log: f64, shares: &Shares) -> [f64; 3] {
        let (mut sum, mut all) = ([0.0; 3], 0.0);
        for ((camera, gain), share) in self.camera.of_photo.iter().zip(&self.of_photo).zip(&shares.of_photo) {
            let Some(camera) = camera else { continue };
            (0..3).for_each(|c| sum[c] += share * (gain[c] - camera));
            all += share;
        }
        let beside = if all > 0.0 { sum.map(|sum| sum / all) } else { [0.0; 3] };
        beside.map(|beside| beside + log - self.camera.level)
    }

    /// Computes the log gain of a view, R, G, B, to which the photos contribute with these shares. Where the
    /// photos' exposures followed their meters ([`super::Meter`]), the gains are corrected by the difference
    /// of the view's meter reading: the gain of a nearby photo is misleading when the view, for example,
    /// looks into the light.
    pub fn of_view(&self, view: &Pose, shares: &Shares) -> [f64; 3] {
        let own = |c: usize| {
            let of_photo = shares.of_photo.iter().zip(&self.of_photo);
            of_photo.map(|(share, gain)| share * gain[c]).sum::<f64>()
        };
        let carried = match self.light.groups.is_one() {
            true => self.meter.carried(view, shares),
            false => self.light.metered(view, shares, Meter::carried),
        };
        [0, 1, 2].map(|c| own(c) + carried[c])
    }
}

/// Returns true when the site's rule may decide on an exposure.
fn is_decided(exposure: Exposure) -> bool {
    matches!(exposure, Exposure::Decided | Exposure::AsTaken(_))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exposure::{CameraExposures, ExposureRule};
    use glam::DVec3;
    use quadratura_base::scene::synthetic::{Rng, centred, look_at};

    fn photos(rng: &mut Rng, count: usize) -> (Vec<Projector>, Gains) {
        let mut position = || DVec3::new(rng.between(-9.0, 9.0), rng.between(-9.0, 9.0), 2.0);
        let poses: Vec<Pose> = (0..count).map(|_| look_at(position(), position() + DVec3::Z)).collect();
        let camera = centred(300, 200, 300.0);
        let projector = |pose| Projector { name: String::new(), camera, pose };
        let of_photo = (0..count).map(|_| [0; 3].map(|_: i32| rng.between(-0.5, 0.5))).collect();
        let gains = Gains { of_photo, ..Gains::none(count) };
        (poses.into_iter().map(projector).collect(), gains)
    }

    /// Computes the gain of a view by nearness; surfaces are 8 units away.
    fn near(view: &Pose, gains: &Gains, photos: &[Projector], without: &[PhotoId]) -> [f64; 3] {
        gains.of_view(view, &Shares::new(view, 8.0, photos, without))
    }

    #[test]
    fn a_photos_own_camera_has_exactly_its_gain() {
        let (photos, gains) = photos(&mut Rng::new(11), 30);
        for (photo, gain) in photos.iter().zip(&gains.of_photo) {
            assert_eq!(near(&photo.pose, &gains, &photos, &[]), *gain);
        }
    }

    #[test]
    fn with_the_exposure_of_a_photo_that_one_stays_as_it_is_and_the_others_follow() {
        let (photos, gains) = photos(&mut Rng::new(15), 4);
        let mut shot = Shot::new(photos[0].camera, photos[1].pose);
        shot.exposure = Exposure::Of(PhotoId(2));
        let factors = gains.factors(&shot, || unreachable!("no view decides"));
        assert_eq!(factors[2], [1.0; 3]);
        for (factor, gain) in factors.iter().zip(&gains.of_photo) {
            let brought = (0..3).all(|c| (gain[c] + factor[c].ln() - gains.of_photo[2][c]).abs() < 1e-12);
            assert!(brought, "{factor:?} {gain:?}");
        }
    }

    #[test]
    fn the_sites_rule_decides_unless_an_exposure_is_asked_for() {
        let (photos, mut gains) = photos(&mut Rng::new(16), 4);
        let away = look_at(DVec3::new(0.5, -0.5, 2.0), DVec3::new(3.0, 4.0, 2.5));
        let mut shot = Shot::new(photos[0].camera, away);
        let shares = |shot: &Shot| Shares::new(&shot.pose, 8.0, &photos, &shot.without);
        let factors = |gains: &Gains, shot: &Shot| gains.factors(shot, || shares(shot));
        let near = factors(&gains, &shot);
        for (rule, exposure) in [(ExposureRule::Raw, Exposure::Raw), (ExposureRule::Common, Exposure::Common)]
        {
            gains.rule = rule;
            shot.exposure = Exposure::Decided;
            let decided = factors(&gains, &shot);
            shot.exposure = exposure;
            assert_eq!(decided, factors(&gains, &shot));
            assert_ne!(decided, near);
            shot.exposure = Exposure::Near;
            assert_eq!(factors(&gains, &shot), near);
        }
        // Under any rule a photo's own camera shows the photo.
        (gains.rule, shot.exposure, shot.pose) = (ExposureRule::Common, Exposure::Decided, photos[1].pose);
        assert!(factors(&gains, &shot)[1].iter().all(|factor| (factor - 1.0).abs() < 1e-9));
        (shot.exposure, shot.pose) = (Exposure::Near, away);
        // The photo whose exposure is asked for is the one to be predicted: it is that of a new view.
        shot.without = vec![PhotoId(2)];
        let near = factors(&gains, &shot);
        shot.exposure = Exposure::Decided;
        let decided = factors(&gains, &shot);
        shot.exposure = Exposure::Of(PhotoId(2));
        assert_eq!(factors(&gains, &shot), decided);
        assert_ne!(decided, near);
    }

    #[test]
    fn a_photo_left_out_does_not_tell_its_gain() {
        let (photos, mut gains) = photos(&mut Rng::new(12), 5);
        let own = PhotoId(2);
        let before = near(&photos[2].pose, &gains, &photos, &[own]);
        gains.of_photo[2] = [9.0; 3];
        assert_eq!(near(&photos[2].pose, &gains, &photos, &[own]), before);
    }

    #[test]
    fn a_small_step_of_the_camera_is_a_small_step_of_the_gain() {
        let (photos, gains) = photos(&mut Rng::new(13), 12);
        let eye = photos[3].pose.center_in_world();
        let at = |step: f64| {
            let pose = look_at(eye + DVec3::new(step, 0.3 * step, 0.0), DVec3::new(0.0, 1.0, 2.0 + step));
            near(&pose, &gains, &photos, &[])[0]
        };
        let largest = |steps: i32| {
            let position = |k: i32| f64::from(k) / f64::from(steps);
            (-steps..steps).map(|k| (at(position(k)) - at(position(k + 1))).abs()).fold(0.0, f64::max)
        };
        let (coarse, fine) = (largest(500), largest(1000));
        assert!(fine < 0.6 * coarse && coarse < 0.02, "{coarse} {fine}");
    }

    #[test]
    fn far_from_every_photo_the_exposure_is_the_common_one() {
        let (photos, gains) = photos(&mut Rng::new(14), 4);
        let pose = look_at(DVec3::new(900.0, 0.0, 2.0), DVec3::new(1000.0, 1.0, 2.0));
        assert!(near(&pose, &gains, &photos, &[]).iter().all(|gain| gain.abs() < 1e-3));
        assert_eq!(near(&pose, &Gains::none(0), &[], &[]), [0.0; 3]);
    }

    #[test]
    fn a_view_has_what_its_camera_wrote_down_and_the_white_balance_of_its_photos() {
        let mut gains = Gains::none(3);
        gains.of_photo = vec![[0.1, 0.0, -0.1], [0.6, 0.5, 0.4], [5.0; 3]];
        gains.camera =
            CameraExposures { of_photo: vec![Some(0.0), Some(0.5), None], level: 2.0, ..Default::default() };
        let shares = Shares { of_photo: vec![0.25, 0.25, 0.5], of_common: 0.0, takes_part: vec![true; 3] };
        let view = gains.as_taken(2.7, &shares);
        assert!(
            view.iter().zip([0.8, 0.7, 0.6]).all(|(gain, truth)| (gain - truth).abs() < 1e-12),
            "{view:?}"
        );
    }
}
