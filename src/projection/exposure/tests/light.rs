//! Tests on photos of the courtyard in two lights.

use super::*;

/// Twelve photos in a ring, every other one of which was taken later.
fn two_rounds() -> Shoot {
    let mut shoot = Shoot::new(courtyard(DVec3::ZERO), ring(DVec3::ZERO, 12));
    shoot.later = (1..12).step_by(2).collect();
    shoot
}

/// Returns the group of each photo.
fn groups_of(found: &Estimate, count: usize) -> Vec<usize> {
    PhotoId::all(count).map(|photo| found.gains.group(photo)).collect()
}

#[test]
fn photos_with_other_shadows_are_another_group_of_light_whose_gains_are_found_by_themselves() {
    let shoot = two_rounds();
    let found = shoot.estimate();
    assert_eq!(groups_of(&found, 12), [0, 1].repeat(6), "{:?}", found.group_support);
    let GroupSupport { within, between, lead } = found.group_support;
    assert!(between > 2.0 * within && lead.unwrap() > 0.3, "{:?}", found.group_support);
    // Within a group gains are as well known as where there is one.
    for group in [0, 1] {
        let members = || (group..12).step_by(2);
        for c in 0..3 {
            let off = |photo: usize| found.gains.of_photo[photo][c] - shoot.gains[photo][c];
            let mean = members().map(off).sum::<f64>() / 6.0;
            assert!(members().all(|photo| (off(photo) - mean).abs() < 0.01), "{group} {:?}", found.gains);
        }
    }
    assert_eq!((found.alone.len(), found.components, found.gains.light.meters.len()), (0, 1, 2));
}

#[test]
fn photos_of_one_round_are_one_group_of_light_and_nothing_changes() {
    let mut shoot = Shoot::new(courtyard(DVec3::ZERO), ring(DVec3::ZERO, 12));
    // Somebody in white, sun from one side, and noise of a fifth are no other light.
    (shoot.visited, shoot.sunny, shoot.noise) = (vec![2, 7], 0.7, 0.2);
    let found = shoot.estimate();
    assert!(found.gains.light == SiteLight::default(), "{:?}", found.group_support);
    shoot.groups = Some(LightGroups::new(&[3; 12]));
    assert!(shoot.estimate() == found, "one group is one group");
}

#[test]
fn views_lean_to_groups_of_light_only_where_left_out_photos_are_clearly_predicted_better() {
    let mut shoot = two_rounds();
    let best = |found: &Estimate| best_psnr(found).unwrap();
    // Next to each photo are photos of the other round, so that nobody knows the light of a view.
    let mixed = shoot.estimate();
    assert!(mixed.gains.light.blended.is_some(), "{:?}", mixed.leaning_lead);
    shoot.groups = Some(LightGroups::default());
    let one = shoot.estimate();
    assert_eq!((one.leaning_lead, best(&mixed)), (None, best(&one)));
    assert_eq!(mixed.gains.light.blended.as_deref(), Some(&one.gains), "views are as with one group");
    // A lead in each photo decides; the same on average, from luck with some and bad luck with others, does not.
    let decided = |lead: fn(usize) -> f64| {
        let mut better = one.clone();
        for (photo, psnr) in better.left_out_psnr.iter_mut().enumerate() {
            psnr.iter_mut().for_each(|psnr| *psnr += lead(photo));
        }
        better.decide_leaning(one.clone());
        (better.leaning_lead.unwrap(), better.gains.light.blended.is_none())
    };
    let (lead, leans) = decided(|photo| if photo % 2 == 0 { 1.0 } else { 1.1 });
    assert!(leans && (lead.mean - 1.05).abs() < 0.01 && lead.error < 0.02, "{lead:?}");
    let (lead, leans) = decided(|photo| if photo % 2 == 0 { 5.0 } else { -3.0 });
    assert!(!leans && lead.mean > 0.5 && lead.error > 1.0, "{lead:?}");
}

#[test]
fn a_left_out_photo_has_no_say_in_groups_of_light() {
    // With it the later photos are a group; without it they are one photo, which is none.
    let mut shoot = Shoot::new(courtyard(DVec3::ZERO), ring(DVec3::ZERO, 12));
    (shoot.later, shoot.noise) = ((1..12).step_by(2).collect(), 0.0);
    let left_out = [PhotoId(3)];
    let before = shoot.estimate_without(&left_out);
    assert_eq!(before.gains.light.groups.count(), 2, "{:?}", before.group_support);
    shoot.later.retain(|photo| *photo != 3);
    shoot.gains[3] = [0.9, -0.9, 0.2];
    shoot.visited = vec![3];
    assert!(shoot.estimate_without(&left_out) == before, "whatever it shows");
}

#[test]
fn a_site_by_night_and_by_day_in_equal_numbers_is_two_groups_and_one_photo_in_another_light_is_none() {
    let mut shoot = two_rounds();
    // The lamps are five stops darker than the sun, and orange.
    (1..12).step_by(2).for_each(|photo| shoot.gains[photo] = [-2.5, -3.2, -4.0]);
    let found = shoot.estimate();
    assert_eq!(groups_of(&found, 12), [0, 1].repeat(6), "{:?}", found.group_support);
    shoot.later = vec![5];
    assert!(shoot.estimate().gains.light.groups.is_one());
}

#[test]
fn groups_that_are_decided_are_kept_and_a_view_leans_to_the_one_that_it_shows_most_of() {
    let mut shoot = two_rounds();
    let decided = LightGroups::new(&[0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1]);
    shoot.groups = Some(decided.clone());
    let mut gains = shoot.estimate().gains;
    assert!(gains.light.groups == decided);
    gains.light.blended = None;
    let shot = Shot::new(shoot.photos[0].camera, shoot.photos[0].pose);
    let exposed = |shot: &Shot, first: f64| {
        let of_photo = (0..12).map(|i| if i < 6 { first / 6.0 } else { (1.0 - first) / 6.0 }).collect();
        let shares = Shares { of_photo, of_common: 0.0, takes_part: vec![true; 12] };
        gains.exposed(shot, &shoot.photos, || shares)
    };
    // Half as much: a quarter of the say. A tenth is the least.
    let leaning = exposed(&shot, 2.0 / 3.0).leaning;
    assert!(leaning[0] == 1.0 && (leaning[6] - 4.0).abs() < 1e-9, "{leaning:?}");
    assert_eq!(exposed(&shot, 0.9).leaning[11], 10.0);
    let turned = exposed(&shot, 0.1).leaning;
    assert_eq!((turned[0], turned[11]), (10.0, 1.0));
    // Continuous, and the same from both sides of a tie.
    let steps: Vec<ViewExposure> = (0..=4000).map(|i| exposed(&shot, f64::from(i) / 4000.0)).collect();
    for pair in steps.windows(2) {
        for photo in [0, 6] {
            assert!((pair[0].leaning[photo] - pair[1].leaning[photo]).abs() < 0.05);
            let log = |at: usize| pair[at].factors[photo][1].ln();
            assert!((log(0) - log(1)).abs() < 2e-3, "{} {}", log(0), log(1));
        }
    }
    // Like a photo: its exposure and its group, whatever the view shows.
    let like = Shot { exposure: Exposure::Of(PhotoId(8)), ..shot.clone() };
    let of_one = exposed(&like, 1.0);
    assert_eq!((of_one.leaning[0], of_one.leaning[8], of_one.factors[8]), (10.0, 1.0, [1.0; 3]));
    // Where leaning predicts photos worse, that is the only way to lean.
    gains.light.blended = Some(Box::new(Gains::none(12)));
    let exposed = |shot: &Shot| {
        let of_photo = (0..12).map(|i| if i < 6 { 0.9 / 6.0 } else { 0.1 / 6.0 }).collect();
        let shares = Shares { of_photo, of_common: 0.0, takes_part: vec![true; 12] };
        gains.exposed(shot, &shoot.photos, || shares)
    };
    assert!(exposed(&shot).leaning.is_empty());
    assert_eq!(exposed(&like), of_one);
}
