//! The GPU's pictures against the twin's, on scenes that nobody chose.

use std::sync::Arc;

use quadratura::geometry::Pinhole;
use quadratura::projection::relief::Relief;
use quadratura::projection::{Mode, Quality, Shot};
use quadratura::scene::synthetic::{Dice, Scene, random};

use crate::bench::Bench;
use crate::gpu_twin::{Difference, difference, hills};
use crate::shoot::Shoot;

/// Seven photos, so that a point of which three share the best is one of a choice.
const SHOOT: Shoot = Shoot { photos: 7, depth: 9.0, spread_rad: 1.2, difference: 50.0 };

/// A site of the scene; some objects are billboards, and photos' exposures differ.
fn bench(mut scene: Scene, dice: &mut Dice) -> Option<Bench> {
    let model = Arc::make_mut(&mut scene.model);
    model.objects.iter_mut().for_each(|object| object.billboard = dice.chance(0.15));
    let folder = tempfile::tempdir().unwrap();
    let site = SHOOT.site(&scene, dice, folder.path());
    let mut bench = Bench::of(site, folder)?;
    bench.gains.of_photo.iter_mut().for_each(|gain| *gain = [(); 3].map(|()| dice.between(-0.2, 0.2)));
    Some(bench)
}

/// A view from elsewhere, of another size and lens: half of them show more of the photos than these
/// have, the others less.
fn view(scene: &Scene, dice: &mut Dice) -> Shot {
    let zoom = (2.0_f64).powf(dice.between(-1.0, 2.0));
    let focal = scene.camera.fx * 144.0 / f64::from(scene.camera.width) * zoom;
    let (cx, cy) = (dice.between(40.0, 100.0), dice.between(30.0, 66.0));
    let camera = Pinhole { width: 144, height: 96, fx: focal, fy: focal, cx, cy };
    let mut shot = Shot::new(camera, SHOOT.pose(scene, dice, 0.4));
    shot.blend.photos = dice.whole(1, 5);
    shot
}

/// Pictures of all modes in both qualities, of sites of so many scenes, with a share of the faces pinned.
fn compare(scenes: impl Iterator<Item = Scene>, pinned: f64, relief: impl Fn(&Bench) -> Relief, what: &str) {
    let mut all = [Difference::default(); 2];
    for (seed, scene) in (1..).zip(scenes) {
        let mut dice = Dice::new(seed);
        let Some(mut bench) = bench(scene.clone(), &mut dice) else { return };
        bench.pin(pinned, &mut dice);
        let relief = relief(&bench);
        let (mut gpu, mut twin) = (bench.renderer(&relief), bench.twin(&relief));
        for mode in Mode::ALL {
            for (all, quality) in all.iter_mut().zip([Quality::Preview, Quality::Final]) {
                let mut shot = view(&scene, &mut dice);
                (shot.blend.mode, shot.quality) = (mode, quality);
                let found = difference(&mut gpu, &mut twin, &shot);
                println!("{}, {mode}, {quality:?}: {found}", scene.name);
                *all += found;
            }
        }
    }
    let [preview, last] = all;
    println!("{what}, preview: {preview}\n{what}, final: {last}");
    for all in all {
        assert!(all.shown > 0.3 * all.pixels, "{what}: next to nothing shown: {all}");
        assert!(all.flipped < 1e-3 * all.pixels, "{what}: faces differ: {all}");
    }
    // One pixel in a thousand may lie where an edge in a photo, or the edge of what serves, is a matter of
    // rounding.
    assert!(last.far < 1e-3 * last.inside && last.mean() < 0.75, "{what}, final: {last}");
    // Of three channels one is mostly off by the quartic's 0.7 steps; and where a photo's own edges cross a
    // face, it matters in which encoding they are filtered.
    assert!(preview.far < 1e-2 * preview.inside && preview.mean() < 1.5, "{what}, preview: {preview}");
}

#[test]
fn the_gpu_and_its_twin_show_polygons_in_all_attitudes_alike() {
    let scenes = (1..=6).map(|seed| random::soup(seed, 24));
    compare(scenes, 0.0, |_| Relief::default(), "soups");
}

#[test]
fn the_gpu_and_its_twin_show_boxes_on_a_ground_alike() {
    let scenes = (1..=6).map(|seed| random::boxes(seed, 8));
    compare(scenes, 0.0, |_| Relief::default(), "boxes");
}

#[test]
fn the_gpu_and_its_twin_show_faces_that_are_pinned_to_a_photo_alike() {
    let scenes = (21..=23).flat_map(|seed| [random::soup(seed, 24), random::boxes(seed, 8)]);
    compare(scenes, 0.6, |_| Relief::default(), "pinned");
}

#[test]
fn the_gpu_and_its_twin_show_reliefs_of_random_scenes_alike() {
    let scenes = (11..=13).flat_map(|seed| [random::soup(seed, 24), random::boxes(seed, 8)]);
    compare(scenes, 0.0, |bench| hills(&bench.site.model), "reliefs");
}
