//! Exposure gains of real photos, and their cache.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use crate::common;
use glam::DVec2;
use quadratura::task::{Event, Task};
use quadratura::testing::document::{ColourDecisions, Stack};
use quadratura::testing::projection::exposure::{Estimate, RayVisibility, Shares, Visibility};
use quadratura::testing::projection::{Gains, Projector};
use quadratura::testing::scene::light::{linear_of_srgb, srgb_from_linear};
use quadratura::testing::scene::{Photo, PhotoId, Site};
use quadratura::testing::stacks::gains::{estimate_of_photos, photo_gains};

const MEMORY: u64 = 1 << 30;

fn piazza() -> (PathBuf, Site) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("projects/piazza");
    let site = common::site(&folder, "photos", "piazza.obj");
    (folder, site)
}

/// The exposures, in EV, that `make/cameras.py` says the photos were developed with.
fn true_exposures(folder: &Path) -> Vec<(String, f64)> {
    let text = fs::read_to_string(folder.join("make/cameras.py")).unwrap();
    let photos = text.lines().filter_map(|line| line.trim().strip_prefix("Camera(\""));
    photos
        .map(|line| {
            let name = line.split('"').next().unwrap().to_owned();
            let after = line.split("exposure_ev=").nth(1);
            // 08_portrait gives it by position, as the last number.
            let last = line.trim_end_matches("),").rsplit(", ").next().unwrap();
            let text = after.map(|rest| rest.trim_end_matches("),"));
            let by_position = (line.split(", ").count() > 8).then_some(last);
            (name, text.or(by_position).map_or(0.0, |ev| ev.parse().unwrap()))
        })
        .collect()
}

fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let mean = pairs.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / n, sum.1 + p.1 / n));
    let product =
        |f: &dyn Fn(f64, f64) -> f64| -> f64 { pairs.iter().map(|p| f(p.0 - mean.0, p.1 - mean.1)).sum() };
    product(&|x, y| x * y) / (product(&|x, _| x * x) * product(&|_, y| y * y)).sqrt()
}

/// Root mean square, over photos and channels, of the gains, and of the errors with which each photo's
/// is predicted from the others, by nearness and the meter.
fn left_out(site: &Site, Estimate { gains, reach, .. }: &Estimate) -> (f64, f64) {
    let projector = |p: &Photo| Projector { name: p.name.clone(), camera: p.camera, pose: p.pose };
    let photos: Vec<Projector> = site.photos.iter().map(projector).collect();
    let (mut known, mut missed) = (0.0, 0.0);
    for (i, gain) in gains.of_photo.iter().enumerate() {
        let view = &photos[i].pose;
        let predicted = gains.of_view(view, &Shares::new(view, *reach, &photos, &[PhotoId(i as u32)]));
        for c in 0..3 {
            known += gain[c] * gain[c];
            missed += (predicted[c] - gain[c]).powi(2);
        }
    }
    let count = 3.0 * photos.len() as f64;
    ((known / count).sqrt(), (missed / count).sqrt())
}

fn print(site: &Site, found: &Estimate) {
    let gains = &found.gains;
    for (photo, [r, g, b]) in site.photos.iter().zip(&gains.of_photo) {
        println!("{:24} {r:+.4} {g:+.4} {b:+.4}", photo.name);
    }
    let (known, missed) = left_out(site, found);
    println!("the meter is followed by {:.3?}", gains.meter.follows);
    println!("gains {known:.4} rms, predicted from the others with {missed:.4} rms error");
}

#[test]
fn the_piazzas_exposures_are_found_as_its_film_shows_them() {
    let (folder, site) = piazza();
    let found = estimate_of_photos(&site, &ColourDecisions::default(), MEMORY, &Task::silent()).unwrap();
    println!(
        "{} points, {} pairs, {:.4?} before, {:.4?} after",
        found.points, found.pairs, found.before, found.after
    );
    print(&site, &found);
    let truth = true_exposures(&folder);
    let of = |name: &str| truth.iter().find(|(photo, _)| photo == name).unwrap().1;
    for c in 0..3 {
        let pairs: Vec<_> =
            site.photos.iter().zip(&found.gains.of_photo).map(|(p, gain)| (of(&p.name), gain[c])).collect();
        // Not the same: between exposure and pixels is a film curve, flatter in the light and flattest
        // where it desaturates.
        assert!(correlation(&pairs) > 0.95, "channel {c}: {pairs:?}");
    }
    assert!((0..3).all(|c| found.after[c] < 0.75 * found.before[c]), "{found:?}");
    assert!(found.alone.is_empty() && found.components == 1, "{found:?}");
    assert!(found.gains.light.groups.is_one(), "{:?}", found.group_support);
    let (known, missed) = left_out(&site, &found);
    assert!(missed < known, "the nearest photos say less than none: {missed} of {known}");
}

/// The light in the shadow of the altered photos, over that in the sun, R, G, B: it is bluer.
const SHADOW: [f64; 3] = [0.25, 0.3, 0.4];
/// The white balance of the altered photos.
const EVENING: [f64; 3] = [1.15, 0.9, 0.65];

/// Writes a photo as it would be in the evening, with a shadow on all surfaces on one side of the site, and returns it.
fn in_the_evening(photo: &Photo, id: PhotoId, seen: &impl Visibility, folder: &Path) -> Photo {
    /// The side of the squares whose centres tell the surface, in pixels.
    const BLOCK: u32 = 4;
    let mut image = image::open(&photo.file).unwrap().to_rgb8();
    let (width, height) = image.dimensions();
    for y in (0..height).step_by(BLOCK as usize) {
        for x in (0..width).step_by(BLOCK as usize) {
            let px = DVec2::new(f64::from(x), f64::from(y)) + 0.5 * f64::from(BLOCK);
            let in_shadow = seen.surface_at(id, px).is_some_and(|(_, point)| point.x + 0.3 * point.y > 0.0);
            let factor = [0, 1, 2].map(|c| EVENING[c] * if in_shadow { SHADOW[c] } else { 1.0 });
            for (u, v) in
                (y..(y + BLOCK).min(height)).flat_map(|v| (x..(x + BLOCK).min(width)).map(move |u| (u, v)))
            {
                let pixel = &mut image.get_pixel_mut(u, v).0;
                for c in 0..3 {
                    let light = factor[c] * linear_of_srgb(f64::from(pixel[c]) / 255.0);
                    pixel[c] = (255.0 * srgb_from_linear(light.min(1.0))).round() as u8;
                }
            }
        }
    }
    let file = folder.join(format!("{}.png", id.0));
    image.save(&file).unwrap();
    Photo { file, ..photo.clone() }
}

#[test]
fn photos_of_the_piazza_in_another_light_are_a_group_and_views_are_predicted_no_worse_than_with_one() {
    let (_, mut site) = piazza();
    let folder = tempfile::tempdir().unwrap();
    let projector = |p: &Photo| Projector { name: p.name.clone(), camera: p.camera, pose: p.pose };
    let photos: Vec<Projector> = site.photos.iter().map(projector).collect();
    let seen = RayVisibility::new(&site.model, &photos);
    let later = |photo: usize| photo % 2 == 1;
    let altered: Vec<Photo> = (0..photos.len())
        .map(|photo| match later(photo) {
            true => in_the_evening(&site.photos[photo], PhotoId(photo as u32), &seen, folder.path()),
            false => site.photos[photo].clone(),
        })
        .collect();
    site.photos = altered;
    let estimate =
        |colour: &ColourDecisions| estimate_of_photos(&site, colour, MEMORY, &Task::silent()).unwrap();
    let found = estimate(&ColourDecisions::default());
    let groups: Vec<bool> =
        (0..photos.len()).map(|photo| found.gains.group(PhotoId(photo as u32)) == 1).collect();
    assert_eq!(groups, (0..photos.len()).map(later).collect::<Vec<_>>(), "{:?}", found.group_support);
    let one = estimate(&ColourDecisions { groups: Some(BTreeMap::new()), ..ColourDecisions::default() });
    assert!(one.gains.light.groups.is_one());
    let best = |found: &Estimate| found.rules.iter().map(|score| score.psnr).fold(0.0, f64::max);
    println!("{:?}: {:.2} dB in groups, {:.2} dB in one", found.group_support, best(&found), best(&one));
    println!("leaning {:?}", found.leaning_lead);
    // The alteration says little of where a view is: leaning is not clearly better, and views have the rules of one group.
    let lead = found.leaning_lead.unwrap();
    assert!(lead.error > 0.0 && lead.mean < 2.0 * lead.error, "{lead:?}");
    let blended = found.gains.light.blended.as_ref().expect("views do not lean");
    assert!(blended.light.groups.is_one() && found.rules == one.rules, "{:?} {:?}", found.rules, one.rules);
}

#[test]
fn the_castles_exposures_follow_the_view_and_are_predicted() {
    let Some(folder) = common::castle() else { return };
    let site = common::site(&folder, "images", "castle.obj");
    let found = estimate_of_photos(&site, &ColourDecisions::default(), MEMORY, &Task::silent()).unwrap();
    println!(
        "{} points, {} pairs, {:.4?} before, {:.4?} after",
        found.points, found.pairs, found.before, found.after
    );
    print(&site, &found);
    assert!((0..3).all(|c| found.after[c] < 0.6 * found.before[c]), "{found:?}");
    assert!(found.gains.light.groups.is_one(), "{:?}", found.group_support);
    let (known, missed) = left_out(&site, &found);
    assert!(missed < 0.25 * known, "{missed} of {known}");
}

#[test]
fn gains_are_kept_until_something_changes_and_broken_photos_do_without() {
    let (_, mut site) = piazza();
    site.photos.truncate(3);
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("broken.jpg");
    fs::write(&broken, "no photo").unwrap();
    site.photos[2].file = broken;
    let notes: Arc<Mutex<Vec<String>>> = Arc::default();
    let task = {
        let notes = notes.clone();
        Task::new(move |event| {
            if let Event::Note { subject, .. } = event {
                notes.lock().unwrap().push(subject);
            }
        })
    };
    let stacks: [Option<Stack>; 3] = [None, None, None];
    let gains = |site: &Site| {
        photo_gains(site, &stacks, &ColourDecisions::default(), folder.path(), MEMORY, &task).unwrap()
    };
    let first = gains(&site);
    assert_eq!(*notes.lock().unwrap(), [site.photos[2].name.clone()]);
    assert!(first.of_photo[0] != [0.0; 3] && first.of_photo[2] == [0.0; 3], "{first:?}");

    // From the cache: nobody looks at the broken photo.
    assert_eq!(gains(&site), first);
    assert_eq!(notes.lock().unwrap().len(), 1);

    let file = folder.path().join("cache/gains.bin");
    fs::write(&file, "{").unwrap();
    assert_eq!(gains(&site), first);
    assert_eq!(notes.lock().unwrap().len(), 2);

    site.photos[1].camera.cx += 40.0;
    assert_ne!(gains(&site), first);
    assert_eq!(notes.lock().unwrap().len(), 3);
}

#[test]
fn what_is_decided_changes_the_photo_it_is_about_and_nothing_else() {
    let (_, mut site) = piazza();
    site.photos.truncate(4);
    let folder = tempfile::tempdir().unwrap();
    let stacks: [Option<Stack>; 4] = [const { None }; 4];
    let name = |photo: usize| site.photos[photo].name.clone();
    let gains = |site: &Site, colour: &ColourDecisions| {
        photo_gains(site, &stacks, colour, folder.path(), MEMORY, &Task::silent()).unwrap()
    };
    let estimated = gains(&site, &ColourDecisions::default());

    let mut colour = ColourDecisions::default();
    colour.fixed.insert(name(1), [1.0, 0.0, -0.5]);
    let fixed = gains(&site, &colour);
    assert_eq!(fixed.of_photo[1], [1.0, 0.0, -0.5].map(|stops: f64| stops * std::f64::consts::LN_2));
    for photo in [0, 2, 3] {
        assert_eq!(fixed.of_photo[photo], estimated.of_photo[photo]);
    }
    colour.even = false;
    assert_eq!(gains(&site, &colour), Gains::none(4));

    // A photo that is left out is not even looked at.
    let left_out = ColourDecisions { left_out: [name(3)].into(), ..ColourDecisions::default() };
    let file = site.photos[3].file.clone();
    site.photos[3].file = folder.path().join("nowhere");
    let without = gains(&site, &left_out).of_photo;
    assert_eq!(without[3], [0.0; 3]);
    for c in 0..3 {
        let sum: f64 = without.iter().map(|gain| gain[c]).sum();
        // Four gains are each rounded by half of 1/512 at most.
        assert!(sum.abs() <= 4.0 / 1024.0, "{without:?}");
    }
    assert!(without[..3] != estimated.of_photo[..3], "it had a say in the others' gains");
    site.photos[3].file = file;
    assert_eq!(gains(&site, &ColourDecisions::default()), estimated, "all is taken back");
}
