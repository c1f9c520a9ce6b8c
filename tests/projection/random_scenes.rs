//! The GPU's pictures against the twin's, on scenes that nobody chose.

use std::sync::Arc;

use quadratura::task::Task;
use quadratura::testing::geometry::Pinhole;
use quadratura::testing::projection::exposure::{LightGroups, Meter, SurfaceGains};
use quadratura::testing::projection::relief::Relief;
use quadratura::testing::projection::{LayerTextureId, Projector, Renders, SiteRenderer};
use quadratura::testing::scene::PhotoId;
use quadratura::testing::scene::synthetic::{Rng, Scene, look_at, random};
use quadratura::testing::view::legend::{CONFIDENCE, COVERAGE, DENSITY, colour_at, colour_of_number};
use quadratura::testing::view::{DisplayMode, Mode, Quality, Shot};

use crate::bench::{Bench, apart};
use crate::gpu_twin::{Difference, difference, hills};
use crate::impostors::turning;
use crate::mattes::put_mattes;
use crate::shoot::Shoot;

/// Seven photos, so that a point of which three share the best is one of a choice.
const SHOOT: Shoot = Shoot { photos: 7, depth: 9.0, angle_rad: 1.2, difference: 50.0 };

/// A site of the scene; some objects are billboards, and photos' exposures differ.
pub fn bench(mut scene: Scene, rng: &mut Rng) -> Option<Bench> {
    let model = Arc::make_mut(&mut scene.model);
    model.objects.iter_mut().for_each(|object| object.billboard |= rng.chance(0.15));
    let folder = tempfile::tempdir().unwrap();
    let site = SHOOT.site(&scene, rng, folder.path());
    let mut bench = Bench::of(site, folder)?;
    bench.gains.of_photo.iter_mut().for_each(|gain| *gain = [(); 3].map(|()| rng.between(-0.2, 0.2)));
    Some(bench)
}

/// A view from elsewhere, of another size and lens: half of them show more of the photos than these
/// have, the others less.
pub fn view(scene: &Scene, rng: &mut Rng) -> Shot {
    let zoom = (2.0_f64).powf(rng.between(-1.0, 2.0));
    let focal = scene.camera.fx * 144.0 / f64::from(scene.camera.width) * zoom;
    let (cx, cy) = (rng.between(40.0, 100.0), rng.between(30.0, 66.0));
    let camera = Pinhole { width: 144, height: 96, fx: focal, fy: focal, cx, cy };
    let mut shot = Shot::new(camera, SHOOT.pose(scene, rng, 0.4));
    shot.blend.photos = rng.whole(1, 5);
    shot
}

/// Pictures of all modes in both qualities, of sites of so many scenes, whose benches are changed by `prepare`.
pub fn compare(
    scenes: impl Iterator<Item = Scene>,
    prepare: impl Fn(&mut Bench, &mut Rng),
    relief: impl Fn(&Bench) -> Relief,
    what: &str,
) {
    // One pixel in a thousand may lie where an edge in a photo, or the edge of what serves, is a matter of
    // rounding.
    compare_within(1e-3, scenes, prepare, relief, what);
}

/// [`compare`], of which this share of the pixels of *final* pictures may differ.
fn compare_within(
    share: f64,
    scenes: impl Iterator<Item = Scene>,
    prepare: impl Fn(&mut Bench, &mut Rng),
    relief: impl Fn(&Bench) -> Relief,
    what: &str,
) {
    let mut all = [Difference::default(); 2];
    for (seed, scene) in (1..).zip(scenes) {
        let mut rng = Rng::new(seed);
        let Some(mut bench) = bench(scene.clone(), &mut rng) else { return };
        prepare(&mut bench, &mut rng);
        let relief = relief(&bench);
        let (mut gpu, mut twin) = (bench.renderer(&relief), bench.twin(&relief));
        for mode in Mode::ALL {
            for (all, quality) in all.iter_mut().zip([Quality::Preview, Quality::Final]) {
                let mut shot = view(&scene, &mut rng);
                (shot.blend.mode, shot.quality) = (mode, quality);
                shot.blend.without_transients = quality == Quality::Final && !bench.agreement.is_full();
                let found = difference(&mut gpu, &mut twin, &shot);
                println!("{}, {mode}, {quality:?}: {found}", scene.name);
                *all += found;
            }
        }
    }
    let [preview, last] = all;
    println!("{what}, preview: {preview}\n{what}, final: {last}");
    for all in all {
        assert!(all.display > 0.3 * all.pixels, "{what}: next to nothing shown: {all}");
        assert!(all.flipped < 1e-3 * all.pixels, "{what}: faces differ: {all}");
        assert!(all.surroundings > 0.01 * all.pixels, "{what}: no surroundings: {all}");
    }
    assert!(last.far < share * last.inside && last.mean() < 0.75, "{what}, final: {last}");
    // Of three channels one is mostly off by the quartic's 0.7 steps; where a photo's own edges cross a face, it
    // matters in which encoding they are filtered; and lookups of 8 bits, as llvmpipe does them on processors without
    // SSSE3 (docs/quality.md), round once a direction and once between levels, up to half a step each. A wrong photo or
    // texel would be off by tens of steps.
    assert!(preview.far < 3e-2 * preview.inside && preview.mean() < 2.5, "{what}, preview: {preview}");
}

#[test]
fn the_gpu_and_its_twin_show_polygons_in_all_attitudes_alike() {
    let scenes = (1..=6).map(|seed| random::soup(seed, 24));
    compare(scenes, |_, _| (), |_| Relief::default(), "soups");
}

#[test]
fn the_gpu_and_its_twin_show_boxes_on_a_ground_alike() {
    let scenes = (1..=6).map(|seed| random::boxes(seed, 8));
    compare(scenes, |_, _| (), |_| Relief::default(), "boxes");
}

#[test]
fn the_gpu_and_its_twin_show_faces_that_are_pinned_to_a_photo_alike() {
    let scenes = (21..=23).flat_map(|seed| [random::soup(seed, 24), random::boxes(seed, 8)]);
    compare(scenes, |bench, rng| bench.pin(0.6, rng), |_| Relief::default(), "pinned");
}

#[test]
fn the_gpu_and_its_twin_show_reliefs_of_random_scenes_alike() {
    let scenes = (11..=13).flat_map(|seed| [random::soup(seed, 24), random::boxes(seed, 8)]);
    compare(scenes, |_, _| (), |bench| hills(&bench.site.model), "reliefs");
}

#[test]
fn the_gpu_and_its_twin_lean_to_the_same_groups_of_light() {
    let scenes = (51..=53).flat_map(|seed| [random::soup(seed, 24), random::boxes(seed, 8)]);
    let groups = |bench: &mut Bench, rng: &mut Rng| {
        let of_photo: Vec<u32> = (0..SHOOT.photos).map(|_| rng.whole(0, 2)).collect();
        bench.gains.light.groups = LightGroups::new(&of_photo);
        bench.gains.light.meters = vec![Meter::default(); 3];
        // The last faces have no gains of their own.
        let of_face = (0..60).map(|_| [0; 3].map(|_: i32| rng.between(-0.5, 0.5)));
        bench.gains.light.surfaces =
            SurfaceGains::from_faces(bench.gains.light.groups.count(), of_face.collect());
    };
    compare(scenes, groups, |_| Relief::default(), "groups of light");
}

#[test]
fn the_gpu_and_its_twin_weight_photos_that_contradict_each_other_alike() {
    let scenes = || (41..=43).flat_map(|seed| [random::soup(seed, 24), random::boxes(seed, 8)]);
    let contradict = |bench: &mut Bench, rng: &mut Rng| {
        bench.pin(0.2, rng);
        bench.contradict(12, rng);
    };
    compare(scenes(), contradict, |_| Relief::default(), "contradicted");
    // They make a difference, so that there was something to compare.
    let (scene, mut rng) = (random::boxes(41, 8), Rng::new(2));
    let Some(mut bench) = bench(scene.clone(), &mut rng) else { return };
    bench.contradict(12, &mut rng);
    let with = view(&scene, &mut rng);
    let mut without = with.clone();
    without.blend.agreement = false;
    let mut gpu = bench.renderer(&Relief::default());
    let shot = with.clone();
    let [with, without] = [with, without].map(|shot| gpu.picture(&shot, &Task::silent()).unwrap().rgba);
    let changed = with.chunks(4).zip(without.chunks(4)).filter(|(a, b)| apart(a, b) > 3).count();
    assert!(changed > 200, "{changed} pixels");
    // Where paint has full agreement, the grids of the painted layers alone are uploaded again.
    let ids = (0..bench.sources.layer_textures.len() as u32).map(LayerTextureId);
    let painted: Vec<_> = ids.filter(|id| bench.agreement.of(*id).is_some()).step_by(2).collect();
    for id in &painted {
        let grid = bench.agreement.of_texture[id.0 as usize].as_mut().unwrap();
        let rect = grid.rect();
        grid.spare(rect.pixels());
    }
    gpu.renew_agreement(&bench.agreement, &painted).unwrap();
    let renewed = gpu.picture(&shot, &Task::silent()).unwrap().rgba;
    let anew = bench.renderer(&Relief::default()).picture(&shot, &Task::silent()).unwrap().rgba;
    assert!(renewed == anew && renewed != with && renewed != without);
}

#[test]
fn the_gpu_and_its_twin_see_through_what_is_sky_within_outlines_alike() {
    let scenes = || (71..=73).flat_map(|seed| [random::soup(seed, 24), random::boxes(seed, 8)]);
    let end = |bench: &mut Bench, rng: &mut Rng| {
        bench.pin(0.2, rng);
        bench.end_within(12, rng);
    };
    // Shares of sky come from lookups of 8 bits and become alpha, so more pixels are a step too far off than elsewhere: 3 in a thousand,
    // or 8 on processors without SSSE3. A wrong share would be off by tens of steps within all discs.
    compare_within(2e-2, scenes(), end, |_| Relief::default(), "outlines");
    let (scene, mut rng) = (random::boxes(71, 8), Rng::new(2));
    let Some(mut bench) = bench(scene.clone(), &mut rng) else { return };
    bench.end_within(12, &mut rng);
    let mut gpu = bench.renderer(&Relief::default());
    let mut changed = |shot: &Shot| {
        let mut without = shot.clone();
        without.blend.agreement = false;
        let [with, without] = [shot, &without].map(|shot| gpu.picture(shot, &Task::silent()).unwrap().rgba);
        with.chunks(4).zip(without.chunks(4)).filter(|(a, b)| apart(a, b) > 3 || a[3] != b[3]).count()
    };
    let shot = view(&scene, &mut rng);
    assert!(changed(&shot) > 200, "one sees the surroundings");
    let plain = Shot { surroundings: false, ..shot.clone() };
    assert!(changed(&plain) > 200, "or nothing");
    // The own camera of a photo shows the photo as it is, but where two faces share a sample: there the later one is laid over the other.
    let Projector { camera, pose, .. } = bench.sources.photos[0].clone();
    let without = (1..bench.sources.photos.len()).map(|at| PhotoId(at as u32)).collect();
    let own = Shot { camera, pose, without, ..shot };
    assert!(changed(&own) < (camera.width * camera.height / 1000) as usize);
}

#[test]
fn the_gpu_and_its_twin_show_what_stands_on_outlines_alike() {
    let scenes = || (61..=63).flat_map(|seed| [random::soup(seed, 24), random::boxes(seed, 8)]);
    // The outlines of skirts are none of faces, and *final* pictures have several samples there, the twin has one.
    compare_within(3e-3, scenes(), |bench, rng| bench.stand(6, rng), |_| Relief::default(), "skirts");
    // It makes a difference where no face is, and only there.
    let (scene, mut rng) = (random::boxes(61, 8), Rng::new(2));
    let Some(mut bench) = bench(scene.clone(), &mut rng) else { return };
    bench.stand(6, &mut rng);
    let shot = view(&scene, &mut rng);
    let task = Task::silent();
    let mut with = bench.renderer(&Relief::default());
    let faces = with.faces(&shot, &task).unwrap();
    bench.skirts = false;
    let mut without = bench.renderer(&Relief::default());
    assert!(faces == without.faces(&shot, &task).unwrap(), "skirts are no faces that one could click on");
    let [with, without] = [&mut with, &mut without].map(|of| of.picture(&shot, &task).unwrap().rgba);
    let changed: Vec<usize> =
        (0..faces.len()).filter(|i| apart(&with[4 * i..], &without[4 * i..]) > 3).collect();
    assert!(changed.len() > 50, "{} pixels", changed.len());
    // A pixel with several samples has the colour of its neighbours along an outline.
    let width = shot.camera.width as usize;
    let is_beside =
        |i: &&usize| [**i, **i - 1, **i + 1, **i - width, **i + width].iter().any(|at| faces[*at] == 0);
    assert_eq!(changed.iter().filter(is_beside).count(), changed.len());
}

/// The same view from the other side of what the photos look at.
fn from_behind(shot: Shot, scene: &Scene) -> Shot {
    let target = scene.pose.world_from_camera(glam::DVec3::Z * SHOOT.depth);
    Shot { pose: look_at(2.0 * target - shot.viewpoint(), target), ..shot }
}

#[test]
fn the_gpu_and_its_twin_leave_the_same_backs_out() {
    let scenes = (31..=36).map(|seed| random::soup(seed, 24));
    let (mut all, mut left_out) = (Difference::default(), 0);
    for (seed, scene) in (1..).zip(scenes) {
        let mut rng = Rng::new(seed);
        let Some(bench) = bench(scene.clone(), &mut rng) else { return };
        let (mut gpu, mut twin) = (bench.renderer(&Relief::default()), bench.twin(&Relief::default()));
        let with = from_behind(view(&scene, &mut rng), &scene);
        let without = Shot { backs: false, ..with.clone() };
        all += difference(&mut gpu, &mut twin, &without);
        let task = Task::silent();
        let (with, without) = (gpu.faces(&with, &task).unwrap(), gpu.faces(&without, &task).unwrap());
        left_out += with.iter().zip(&without).filter(|(with, without)| with != without).count();
    }
    println!("without backs: {all}; {left_out} pixels show something else");
    assert!(left_out > 500, "there are backs in the views: {left_out}");
    assert!(all.flipped < 1e-3 * all.pixels && all.far < 1e-3 * all.inside, "{all}");
}

#[test]
fn a_picture_in_slices_is_the_picture() {
    slice(random::boxes(41, 8), |_| ());
}

#[test]
fn a_picture_in_slices_is_the_picture_where_one_sees_through_impostors() {
    slice(turning(random::boxes(61, 8)), put_mattes);
}

/// Compares a picture of a scene that is drawn in slices with one that is drawn at once.
fn slice(scene: Scene, prepare: impl Fn(&mut Bench)) {
    let mut rng = Rng::new(1);
    let Some(mut bench) = bench(scene.clone(), &mut rng) else { return };
    prepare(&mut bench);
    let mut gpu = bench.renderer(&Relief::default());
    let mut shot = view(&scene, &mut rng);
    // Five times as large: several slices.
    let camera = &mut shot.camera;
    (camera.width, camera.height) = (camera.width * 5, camera.height * 5);
    [&mut camera.fx, &mut camera.fy, &mut camera.cx, &mut camera.cy]
        .into_iter()
        .for_each(|value| *value *= 5.0);
    let whole = gpu.picture(&shot, &Task::silent()).unwrap();
    let (mut sliced, mut slices) = (gpu.begin(&shot, &Task::silent()).unwrap(), 1);
    while !gpu.advance(&mut sliced, &Task::silent()).unwrap() {
        // Whatever is drawn between two slices.
        gpu.picture(&view(&scene, &mut Rng::new(9)), &Task::silent()).unwrap();
        slices += 1;
    }
    let sliced = sliced.picture();
    assert!(slices > 1 && (sliced.width, sliced.height) == (whole.width, whole.height));
    let pairs = sliced.rgba.chunks(4).zip(whole.rgba.chunks(4));
    let far = pairs.filter(|(a, b)| a[3] != b[3] || apart(a, b) > 1).count();
    println!("{slices} slices: {far} of {} pixels differ by more than a step", whole.rgba.len() / 4);
    assert!(far * 1000 <= whole.rgba.len() / 4, "{far}");
}

#[test]
fn colours_of_photos_and_ramps_are_those_of_the_legend() {
    let scene = random::boxes(42, 6);
    let mut rng = Rng::new(2);
    let Some(bench) = bench(scene.clone(), &mut rng) else { return };
    let mut gpu = bench.renderer(&Relief::default());
    let mut shot = Shot { quality: Quality::Preview, ..view(&scene, &mut rng) };
    let photos: Vec<[u8; 3]> = (0..7).map(colour_of_number).collect();
    let ramp = |ramp| (0..=1000).map(|i| colour_at(ramp, i as f32 / 1000.0)).collect::<Vec<_>>();
    let expected = [
        (DisplayMode::BestPhoto, photos),
        // A photo may serve a place twice, where pieces of a face meet.
        (
            DisplayMode::Coverage,
            (1..=14).map(|n: u8| colour_at(COVERAGE, f32::from(n).log2() / 3.0)).collect(),
        ),
        (DisplayMode::Density, ramp(DENSITY)),
        (DisplayMode::Confidence, ramp(CONFIDENCE)),
    ];
    for (display, colours) in expected {
        shot.display = display;
        let picture = gpu.picture(&shot, &Task::silent()).unwrap();
        let served: Vec<_> = picture.rgba.as_chunks::<4>().0.iter().filter(|pixel| pixel[3] == 255).collect();
        assert!(served.len() > 500, "{display:?}: {}", served.len());
        let message = |pixel: &[u8; 4]| colours.iter().any(|colour| apart(pixel, colour) <= 2);
        let untold = served.iter().filter(|pixel| !message(pixel)).count();
        assert_eq!(untold, 0, "{display:?}: of {}", served.len());
    }
}
