//! Tests of what whole photos and cameras say of exposures.

use super::*;

/// Photos in a ring that look to the horizon, so that most of each is sky.
fn under_the_sky() -> Shoot {
    let mut photos = ring(DVec3::ZERO, 10);
    for photo in &mut photos {
        let eye = photo.pose.center_in_world();
        photo.pose = look_at(eye, DVec3::new(0.0, 0.1, eye.z + 0.5));
    }
    Shoot::new(courtyard(DVec3::ZERO), photos)
}

fn mean_at_points(estimate: &Estimate, rule: ExposureRule) -> f64 {
    let at = ExposureRule::ALL.iter().position(|other| *other == rule).unwrap();
    let photos = &estimate.left_out_psnr;
    photos.iter().map(|psnr| psnr[at]).sum::<f64>() / photos.len() as f64
}

#[test]
fn a_rule_is_chosen_by_whole_photos_even_where_their_common_points_say_otherwise() {
    let mut shoot = under_the_sky();
    let of_surfaces = shoot.estimate();
    assert_ne!(of_surfaces.gains.rule, ExposureRule::Raw, "{:?}", of_surfaces.rules);
    shoot.sky = Some(0.8);
    let found = shoot.estimate();
    let lead = mean_at_points(&found, of_surfaces.gains.rule) - mean_at_points(&found, ExposureRule::Raw);
    assert!(lead > 0.1, "at common points raw is worse: {lead}");
    assert_eq!(found.gains.rule, ExposureRule::Raw, "{:?}", found.rules);
}

#[test]
fn a_white_sky_speaks_for_no_rule() {
    let mut shoot = under_the_sky();
    let without = shoot.estimate();
    shoot.sky = Some(1.0);
    let found = shoot.estimate();
    assert_eq!(found.gains.rule, without.gains.rule, "{:?} {:?}", found.rules, without.rules);
}

/// Returns what cameras wrote down where the gains are theirs alone.
fn written(shoot: &mut Shoot) {
    shoot.gains.iter_mut().for_each(|gain| *gain = [gain[0]; 3]);
    shoot.camera_logs = shoot.gains.iter().map(|gain| Some(gain[0] - 7.0)).collect();
}

#[test]
fn a_photo_that_shares_no_point_has_the_gain_that_its_camera_wrote_down() {
    let mut photos = ring(DVec3::ZERO, 9);
    let aside = look_at(DVec3::new(400.0, 0.0, 4.0), DVec3::new(500.0, 0.0, 4.0));
    photos.push(Projector { name: "9".into(), pose: aside, ..photos[0].clone() });
    let mut shoot = Shoot::new(courtyard(DVec3::ZERO), photos);
    written(&mut shoot);
    let found = shoot.estimate();
    assert_eq!((found.alone.len(), found.gains.camera.used()), (0, 10));
    assert!(shoot.worst(&found.gains, 0..10) < 0.02, "{:?} {:?}", found.gains.of_photo, shoot.gains);
    shoot.camera_logs.clear();
    let found = shoot.estimate();
    assert_eq!(found.alone, [PhotoId(9)]);
}

/// Returns the gains of a view from a photo that is left out: as its camera wrote down, and by the rule.
fn gains_of_view(shoot: &Shoot, estimate: &Estimate, own: PhotoId, log: f64) -> [f64; 2] {
    [Exposure::AsTaken(log), Exposure::Decided].map(|exposure| {
        let projector = &shoot.photos[own.index()];
        let mut shot = Shot::new(projector.camera, projector.pose);
        (shot.exposure, shot.without) = (exposure, vec![own]);
        let shares = Shares::new(&shot.pose, estimate.reach, &shoot.photos, &shot.without);
        let factor = estimate.gains.factors(&shot, || shares)[0][1];
        factor.ln() + estimate.gains.of_photo[0][1]
    })
}

#[test]
fn a_view_whose_camera_wrote_down_its_exposure_has_it_unless_cameras_contradict_what_photos_show() {
    let mut shoot = Shoot::new(courtyard(DVec3::ZERO), ring(DVec3::ZERO, 10));
    written(&mut shoot);
    let own = PhotoId(3);
    let log = shoot.camera_logs[own.index()].unwrap();
    let found = shoot.estimate_without(&[own]);
    assert!(found.camera_lead.is_some_and(|lead| lead > 1.0), "{:?}", found.camera_lead);
    let others = (0..10).filter(|photo| *photo != own.index()).map(|photo| shoot.gains[photo][1]);
    let truth = shoot.gains[own.index()][1] - others.sum::<f64>() / 9.0;
    let [taken, by_rule] = gains_of_view(&shoot, &found, own, log);
    assert!((taken - truth).abs() < 0.02 && (by_rule - truth).abs() > 0.05, "{taken} {by_rule} {truth}");
    // The same sensitivity everywhere, whatever was set: the numbers say nothing.
    shoot.camera_logs = vec![Some(-7.0); 10];
    shoot.gains.iter_mut().enumerate().for_each(|(k, gain)| *gain = [0.9 * (k as f64 - 4.5).signum(); 3]);
    let found = shoot.estimate_without(&[own]);
    assert_eq!((found.gains.camera.used(), found.gains.camera.written), (0, 9));
    let [taken, by_rule] = gains_of_view(&shoot, &found, own, log);
    assert_eq!(taken, by_rule);
}
