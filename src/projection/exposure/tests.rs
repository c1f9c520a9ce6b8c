//! Tests on photos of a synthetic courtyard whose exposures are known.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use super::*;
use quadratura_base::geometry::Pose;
use quadratura_base::scene::Model;
use quadratura_base::scene::synthetic::{Modeller, Rng, centred, look_at};
use quadratura_base::task::Task;
use quadratura_view::optics::{Optics, ViewLens, squared_radius, squared_tangent};
use quadratura_view::{Exposure, Shot};

mod light;
mod whole;

/// Builds a floor with four boxes on it, at the world point `at`.
fn courtyard(at: DVec3) -> Arc<Model> {
    let mut m = Modeller::new();
    m.object("floor").quad(at + DVec3::new(-8.0, -8.0, 0.0), DVec3::X * 16.0, DVec3::Y * 16.0);
    for (k, angle) in [0.3, 1.9, 3.3, 4.9].into_iter().enumerate() {
        let centre = at + DVec3::new(4.0 * f64::cos(angle), 4.0 * f64::sin(angle), 1.0);
        m.object(format!("box {k}")).cuboid(centre, DVec3::ONE, DMat3::from_rotation_z(angle));
    }
    m.finish()
}

/// Arranges photos in a ring around `at`, looking inwards.
fn ring(at: DVec3, count: u32) -> Vec<Projector> {
    let photo = |k: u32| {
        let angle = TAU * f64::from(k) / f64::from(count);
        let eye = at + DVec3::new(9.0 * angle.cos(), 9.0 * angle.sin(), 4.0);
        let pose = look_at(eye, at + DVec3::new(0.0, 0.1, 0.5));
        Projector { name: format!("{k}"), camera: centred(600, 400, 420.0), pose }
    };
    (0..count).map(photo).collect()
}

/// The logarithm of the light in the shadow, over that in the sun: about a third.
const SHADOW: f64 = -1.1;

/// Photos with their true exposures, and the disturbances to simulate.
struct Shoot {
    model: Arc<Model>,
    photos: Vec<Projector>,
    gains: Vec<[f64; 3]>,
    /// The approximate standard deviation of a patch's log colour.
    noise: f64,
    /// The photos in which a person in white covers columns 200 to 240.
    visited: Vec<u32>,
    /// The logarithm by which one side of the courtyard is brighter.
    sunny: f64,
    /// The optics of each photo; below, whether vignetting and offset are estimated.
    optics: Vec<Optics>,
    asked: [bool; 2],
    /// Whether views may keep the vignetting.
    keeps_vignetting: bool,
    /// The photos that were taken when the sun stood elsewhere: in another half of the courtyard there is shadow.
    later: Vec<u32>,
    /// The groups of light, if they are decided.
    groups: Option<LightGroups>,
    /// The light of the sky, which all photos show as bright whatever their exposure; `None` where it is not valid.
    sky: Option<f64>,
    /// What cameras wrote down; empty where they did not.
    camera_logs: Vec<Option<f64>>,
}

impl Shoot {
    fn new(model: Arc<Model>, photos: Vec<Projector>) -> Self {
        let mut rng = Rng::new(7);
        let gains = photos.iter().map(|_| [0; 3].map(|_: i32| rng.between(-0.4, 0.4))).collect();
        let optics = vec![Optics::default(); photos.len()];
        let (visited, asked) = (Vec::new(), [false; 2]);
        Self {
            model,
            photos,
            gains,
            noise: 0.02,
            visited,
            sunny: 0.0,
            optics,
            asked,
            keeps_vignetting: false,
            later: Vec::new(),
            groups: None,
            sky: None,
            camera_logs: Vec::new(),
        }
    }

    fn estimate(&self) -> Estimate {
        self.estimate_without(&[])
    }

    fn estimate_without(&self, left_out: &[PhotoId]) -> Estimate {
        let visibility = RayVisibility::new(&self.model, &self.photos);
        let colours = |photo: PhotoId, centers: &[DVec2]| {
            // By name, so that the same photo has the same noise in a site of fewer photos.
            let mut rng = Rng::new(self.photos[photo.index()].name.parse().unwrap());
            let colour = |px: &DVec2| self.colour(&visibility, photo, *px, &mut rng);
            Ok(centers.iter().map(colour).collect())
        };
        let [vignetting, offset] = self.asked;
        let vignetting = match (vignetting, self.keeps_vignetting) {
            (_, true) => Vignetting::Kept,
            (true, _) => Vignetting::Removed,
            (false, _) => Vignetting::Ignored,
        };
        let options = ExposureOptions { vignetting, offset, ..ExposureOptions::default() };
        let mut measured =
            MeasuredColours::measure(&self.photos, &visibility, &colours, &options, &Task::silent()).unwrap();
        if !self.camera_logs.is_empty() {
            measured.camera_logs.clone_from(&self.camera_logs);
        }
        estimate_gains(&self.photos, &measured, left_out, self.groups.as_ref(), &options)
    }

    fn colour(&self, seen: &RayVisibility, photo: PhotoId, px: DVec2, rng: &mut Rng) -> PatchColour {
        if self.visited.contains(&photo.0) && (200.0..240.0).contains(&px.x) {
            return Some(MeanColour { mean: [0.9; 3], usable: true });
        }
        let Some((_, p)) = seen.surface_at(photo, px) else {
            return Some(MeanColour { mean: [self.sky?; 3], usable: true });
        };
        let gain = self.gains[photo.index()];
        let pattern = |k: f64| 0.3 + 0.1 * (k * p.x).sin() + 0.1 * (k * p.y + p.z).cos();
        let noise = (rng.unit() + rng.unit() + rng.unit() - 1.5) * 2.0 * self.noise;
        let is_later = self.later.contains(&self.photos[photo.index()].name.parse().unwrap());
        let shadow = if self.later.is_empty() || (p.x + 0.4 * p.y < 1.0) == is_later { 0.0 } else { SHADOW };
        let sun = self.sunny * p.y.atan2(p.x).sin() + shadow;
        let Optics { falloff: [a, b], offset } = self.optics[photo.index()];
        let r2 = squared_radius(&self.photos[photo.index()].camera, px);
        let lens = a * r2 + b * r2 * r2;
        let mean = [0, 1, 2].map(|c| pattern(1.0 + c as f64) * (sun + gain[c] + lens + noise).exp() + offset);
        Some(MeanColour { mean, usable: true })
    }

    /// Returns the largest error of a gain among `photos`, after removing the mean error.
    fn worst(&self, found: &Gains, photos: std::ops::Range<usize>) -> f64 {
        let mut worst: f64 = 0.0;
        for c in 0..3 {
            let truth = || self.gains[photos.clone()].iter().map(|gain| gain[c]);
            let mean = truth().sum::<f64>() / photos.len() as f64;
            let found = found.of_photo[photos.clone()].iter().map(|gain| gain[c]);
            worst = found.zip(truth()).map(|(f, t)| (f - (t - mean)).abs()).fold(worst, f64::max);
        }
        worst
    }
}

#[test]
fn known_exposures_are_found_to_one_percent() {
    let shoot = Shoot::new(courtyard(DVec3::ZERO), ring(DVec3::ZERO, 10));
    let found = shoot.estimate();
    assert!(shoot.worst(&found.gains, 0..10) < 0.01, "{found:?}");
    assert!(found.after[0] < 0.04 && found.before[0] > 0.1, "{found:?}");
    assert_eq!((found.alone.len(), found.components), (0, 1));
    assert!((8.0..12.0).contains(&found.reach), "{}", found.reach);
}

#[test]
fn a_photo_that_is_left_out_might_as_well_not_exist() {
    let mut shoot = Shoot::new(courtyard(DVec3::ZERO), panorama(9));
    // Noise is drawn patch by patch, of which there are fewer without the photo.
    (shoot.sunny, shoot.asked, shoot.noise) = (0.7, [true, true], 0.0);
    let without = shoot.estimate_without(&[PhotoId(3)]);
    assert!(without.gains != shoot.estimate().gains);
    let mut fewer = Shoot { gains: shoot.gains.clone(), ..Shoot::new(shoot.model.clone(), panorama(9)) };
    (fewer.sunny, fewer.asked, fewer.noise) = (0.7, [true, true], 0.0);
    fewer.photos.remove(3);
    fewer.gains.remove(3);
    fewer.optics.remove(3);
    let kept: Vec<PhotoId> = PhotoId::all(9).filter(|photo| *photo != PhotoId(3)).collect();
    assert!(without == fewer.estimate().among(&kept, 9));
    assert_eq!((without.gains.of_photo[3], &without.alone[..]), ([0.0; 3], &[PhotoId(3)][..]));
    let view = look_at(DVec3::new(1.0, -2.0, 3.0), DVec3::new(4.0, 3.0, 0.5));
    let of_fewer = near(&view, &fewer.estimate().gains, &fewer.photos, &[]);
    let found = near(&view, &without.gains, &shoot.photos, &[PhotoId(3)]);
    assert!((0..3).all(|c| (of_fewer[c] - found[c]).abs() < 1e-12), "{of_fewer:?} {found:?}");
}

/// Returns the rule that is found, and the scores of all.
fn rule_of(shoot: &Shoot) -> (ExposureRule, Vec<RuleScore>) {
    let found = shoot.estimate();
    (found.gains.rule, found.rules)
}

#[test]
fn exposures_that_follow_the_place_are_predicted_by_place() {
    let mut shoot = Shoot::new(courtyard(DVec3::ZERO), ring(DVec3::ZERO, 12));
    // One side is photographed a stop brighter than the other.
    let towards = |photo: &Projector| photo.pose.center_in_world().y / 9.0;
    shoot.gains = shoot.photos.iter().map(|photo| [0.35 * towards(photo); 3]).collect();
    let (rule, scores) = rule_of(&shoot);
    assert_eq!(rule, ExposureRule::Near, "{scores:?}");
}

#[test]
fn exposures_that_were_drawn_by_lot_are_predicted_by_their_mean() {
    let shoot = Shoot::new(courtyard(DVec3::ZERO), ring(DVec3::ZERO, 12));
    let (rule, scores) = rule_of(&shoot);
    assert_eq!(rule, ExposureRule::Common, "{scores:?}");
    assert_eq!(scores.len(), ExposureRule::ALL.len());
}

#[test]
fn photos_without_anything_in_common_are_exposed_by_place() {
    let away = look_at(DVec3::new(100.0, 0.0, 2.0), DVec3::new(200.0, 1.0, 2.0));
    let photos = vec![Projector { pose: away, ..ring(DVec3::ZERO, 1).remove(0) }];
    let shoot = Shoot::new(courtyard(DVec3::ZERO), photos);
    assert_eq!(rule_of(&shoot), (ExposureRule::Near, Vec::new()));
}

#[test]
fn what_a_gain_rests_on_is_counted_and_a_photo_that_disagrees_shows_it() {
    let mut shoot = Shoot::new(courtyard(DVec3::ZERO), ring(DVec3::ZERO, 10));
    shoot.visited = vec![2];
    let found = shoot.estimate();
    let most = found.points as u32;
    assert!(
        found.gain_support.iter().all(|of| of.points > 50 && of.points <= most),
        "{:?}",
        found.gain_support
    );
    let residual = |photo: usize| found.gain_support[photo].residual;
    assert!(
        (0..10).all(|photo| residual(photo) > 0.005 && residual(photo) < 0.05),
        "{:?}",
        found.gain_support
    );
    let others = (0..10).filter(|photo| *photo != 2).map(residual).fold(0.0, f64::max);
    assert!(residual(2) > others, "{:?}", found.gain_support);
}

#[test]
fn somebody_in_white_in_two_photos_does_not_disturb() {
    let mut shoot = Shoot::new(courtyard(DVec3::ZERO), ring(DVec3::ZERO, 10));
    shoot.visited = vec![2, 7];
    let found = shoot.estimate();
    assert!(shoot.worst(&found.gains, 0..10) < 0.01, "{found:?}");
}

#[test]
fn far_from_the_origin_nothing_changes() {
    let at = DVec3::new(5e6, -3e6, 100.0);
    let shoot = Shoot::new(courtyard(at), ring(at, 6));
    assert!(shoot.worst(&shoot.estimate().gains, 0..6) < 0.01);
}

#[test]
fn two_courts_that_do_not_see_each_other_are_two_components() {
    let (here, there) = (DVec3::ZERO, DVec3::new(0.0, 500.0, 0.0));
    let mut photos = ring(here, 8);
    photos.extend(ring(there, 5));
    // One photo looks away from the model.
    let away = look_at(DVec3::new(100.0, 0.0, 2.0), DVec3::new(200.0, 1.0, 2.0));
    photos.push(Projector { pose: away, ..photos[0].clone() });
    let model = joined(&courtyard(here), &courtyard(there));
    let shoot = Shoot::new(model, photos);
    let found = shoot.estimate();
    assert_eq!((found.components, &found.alone[..]), (2, &[PhotoId(13)][..]));
    assert!(shoot.worst(&found.gains, 0..8) < 0.01 && shoot.worst(&found.gains, 8..13) < 0.01);
    assert_eq!(found.gains.of_photo[13], [0.0; 3]);
}

/// Joins two models, with the faces of the first before those of the second.
fn joined(first: &Model, second: &Model) -> Arc<Model> {
    let mut m = Modeller::new();
    for (position, model) in [("here", first), ("there", second)] {
        for face in model.face_ids() {
            let corners: Vec<DVec3> = model.ring_points(face).collect();
            m.object(format!("{} {position}", model.object(model.face(face).object).name)).polygon(&corners);
        }
    }
    m.finish()
}

/// Arranges photos at the centre of the courtyard, looking in all directions.
fn panorama(count: u32) -> Vec<Projector> {
    let photo = |k: u32| {
        let angle = TAU * f64::from(k) / f64::from(count);
        let outwards = DVec3::new(angle.cos(), angle.sin(), 0.0);
        let pose = look_at(DVec3::Z * 4.0 - outwards * 2.0, outwards * 4.0);
        Projector { name: format!("{k}"), camera: centred(600, 400, 420.0), pose }
    };
    (0..count).map(photo).collect()
}

/// Computes the log gain of a view by nearness; surfaces are about 10 units away.
fn near(view: &Pose, gains: &Gains, photos: &[Projector], without: &[PhotoId]) -> [f64; 3] {
    gains.of_view(view, &Shares::new(view, 10.0, photos, without))
}

/// Computes the root mean square error of the gains when each is predicted from the other photos.
fn left_out(gains: &Gains, photos: &[Projector]) -> f64 {
    let error = |(i, photo): (u32, &Projector)| {
        let predicted = near(&photo.pose, gains, photos, &[PhotoId(i)]);
        (predicted[1] - gains.of_photo[i as usize][1]).powi(2)
    };
    ((0..).zip(photos).map(error).sum::<f64>() / photos.len() as f64).sqrt()
}

#[test]
fn where_exposures_were_metered_the_view_is_metered_too() {
    let mut shoot = Shoot::new(courtyard(DVec3::ZERO), panorama(16));
    (shoot.sunny, shoot.noise) = (0.7, 0.01);
    shoot.gains = vec![[0.0; 3]; 16];
    let seen = RayVisibility::new(&shoot.model, &shoot.photos);
    // Automatic exposure renders the centre of the image as mid-grey.
    let metered = |photo: u32| {
        let (mut light, mut all) = (0.0, 0.0);
        for (u, v) in (0..30 * 20).map(|k| (f64::from(k % 30) / 30.0, f64::from(k / 30) / 20.0)) {
            let px = DVec2::new(u * 600.0, v * 400.0);
            let weight = (-0.5 * ((u - 0.5).powi(2) + (v - 0.5).powi(2)) / 0.0225).exp();
            if let Some(colour) = shoot.colour(&seen, PhotoId(photo), px, &mut Rng::new(1)) {
                light += weight * colour.mean[1];
                all += weight;
            }
        }
        [-f64::ln(light / all); 3]
    };
    let gains = (0..16).map(metered).collect();
    shoot.gains = gains;
    let gains = shoot.estimate().gains;
    assert!(gains.meter.follows.iter().all(|follows| *follows > 0.8), "{:?}", gains.meter.follows);
    let with = left_out(&gains, &shoot.photos);
    let without = left_out(&Gains { meter: Meter::default(), ..gains.clone() }, &shoot.photos);
    assert!(with < 0.5 * without, "{with} with the meter, {without} without");
    for (photo, gain) in shoot.photos.iter().zip(&gains.of_photo) {
        assert_eq!(near(&photo.pose, &gains, &shoot.photos, &[]), *gain);
    }
}

#[test]
fn where_exposures_were_drawn_by_lot_the_meter_is_not_asked() {
    let mut shoot = Shoot::new(courtyard(DVec3::ZERO), panorama(16));
    shoot.sunny = 0.7;
    let gains = shoot.estimate().gains;
    let without = Gains { meter: Meter::default(), ..gains.clone() };
    let (with, without) = (left_out(&gains, &shoot.photos), left_out(&without, &shoot.photos));
    assert!(with < 1.1 * without, "{with} with the meter, {without} without");
}

#[test]
fn the_metered_gain_changes_little_by_little() {
    let mut shoot = Shoot::new(courtyard(DVec3::ZERO), panorama(8));
    shoot.sunny = 0.7;
    let mut gains = shoot.estimate().gains;
    gains.meter.follows = [1.0; 3];
    let at = |t: f64| {
        let pose = look_at(DVec3::new(t, -t, 3.0), DVec3::new(4.0 * t.cos(), 4.0 * t.sin(), 0.5));
        near(&pose, &gains, &shoot.photos, &[])[0]
    };
    let largest = |steps: u32| {
        let position = |k: u32| f64::from(k) / f64::from(steps);
        (0..steps).map(|k| (at(position(k)) - at(position(k + 1))).abs()).fold(0.0, f64::max)
    };
    let (coarse, fine) = (largest(1000), largest(2000));
    assert!(fine < 0.6 * coarse && coarse < 0.01, "{coarse} {fine}");
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let shoot = Shoot::new(courtyard(DVec3::ZERO), ring(DVec3::ZERO, 5));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| shoot.estimate())
    };
    assert_eq!(with(1), with(4));
}

/// The largest error allowed for a falloff at the corner, as a logarithm: a tenth of a stop.
const CORNER: f64 = 0.07;

#[test]
fn a_lens_that_darkens_the_corners_is_found_and_another_one_beside_it() {
    let mut photos = ring(DVec3::ZERO, 12);
    photos[6..].iter_mut().for_each(|photo| photo.camera.fx += 1.0);
    let mut shoot = Shoot::new(courtyard(DVec3::ZERO), photos);
    let [dark, clear] = [[-0.5, -0.2], [0.0, 0.0]];
    for (photo, optics) in shoot.optics.iter_mut().enumerate() {
        optics.falloff = if photo < 6 { dark } else { clear };
    }
    let blind = shoot.estimate();
    shoot.asked = [true, false];
    let found = shoot.estimate();
    let corner = |photo: usize| found.gains.optics[photo].log_light(1.0);
    assert!((corner(0) + 0.7).abs() < CORNER && corner(11).abs() < CORNER, "{:?}", found.gains.optics);
    // Halfway to the corner: a quarter of the first term and a sixteenth of the second.
    let halfway = found.gains.optics[0].log_light(0.25);
    assert!((halfway + 0.1375).abs() < 0.5 * CORNER, "{halfway}");
    let (with, without) = (shoot.worst(&found.gains, 0..12), shoot.worst(&blind.gains, 0..12));
    assert!(with < 0.02 && found.after[0] < 0.9 * blind.after[0], "{with} {without} {found:?}");
    assert_eq!(blind.gains.optics, vec![Optics::default(); 12], "not requested");
}

#[test]
fn views_keep_a_vignetting_that_predicts_photos_and_no_other() {
    let mut shoot = Shoot::new(courtyard(DVec3::ZERO), ring(DVec3::ZERO, 12));
    shoot.keeps_vignetting = true;
    let clear = shoot.estimate();
    assert!(!clear.gains.keeps_vignetting, "{:?}", clear.vignetting_lead);
    shoot.optics.iter_mut().for_each(|optics| optics.falloff = [-0.5, -0.2]);
    let dark = shoot.estimate();
    assert!(dark.gains.keeps_vignetting, "{:?}", dark.vignetting_lead);
    // In a photo's own camera it is exactly that of the photo, at any size and with any lens.
    let mut shot = Shot::new(shoot.photos[4].camera, shoot.photos[4].pose);
    shot.exposure = Exposure::Of(PhotoId(4));
    let exposed = dark.gains.exposed(&shot, &shoot.photos, || unreachable!("the photo is named"));
    for px in [DVec2::ZERO, DVec2::new(300.0, 200.0), DVec2::new(470.0, 20.0)] {
        let own = dark.gains.optics[4].log_light(squared_radius(&shot.camera, px)).exp();
        let found = exposed.lens.factor(squared_tangent(&shot.camera, px));
        assert!((own - found).abs() < 1e-12, "{own} {found}");
    }
    // A wider view is no darker than the photos' corners.
    assert_eq!(exposed.lens.factor(9.0), exposed.lens.factor(exposed.lens.widest));
    shot.exposure = Exposure::Raw;
    assert_eq!(dark.gains.exposed(&shot, &shoot.photos, || unreachable!()).lens, ViewLens::default());
}

#[test]
fn where_lenses_are_clear_or_photos_are_few_no_falloff_is_found() {
    let mut shoot = Shoot::new(courtyard(DVec3::ZERO), ring(DVec3::ZERO, 10));
    shoot.asked = [true, false];
    let clear = shoot.estimate();
    assert!(clear.gains.optics[0].log_light(1.0).abs() < CORNER, "{:?}", clear.gains.optics[0]);
    let mut few = Shoot::new(courtyard(DVec3::ZERO), ring(DVec3::ZERO, 3));
    few.asked = [true, false];
    few.optics.iter_mut().for_each(|optics| optics.falloff = [-0.5, -0.2]);
    assert_eq!(few.estimate().gains.optics, vec![Optics::default(); 3]);
}

#[test]
fn light_that_was_added_to_one_photo_is_found_and_to_the_others_next_to_nothing() {
    let mut shoot = Shoot::new(courtyard(DVec3::ZERO), ring(DVec3::ZERO, 10));
    shoot.optics[4].offset = 0.02;
    shoot.asked = [false, true];
    let found = shoot.estimate().gains;
    let offset = |photo: usize| found.optics[photo].offset;
    assert!((0.01..0.025).contains(&offset(4)), "{:?}", found.optics);
    assert!((0..10).all(|photo| photo == 4 || offset(photo).abs() < 0.006), "{:?}", found.optics);
    assert!(shoot.worst(&found, 0..10) < 0.04, "{found:?}");
}
