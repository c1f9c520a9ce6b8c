//! Trees on the device against brute force on the CPU, and beside faces.

mod behind;
mod hidden;
mod motion;
mod photographed;
mod slices;

use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3};

use crate::left_out::on_adapter;
use crate::{Gpu, Renderer, TileStore};
use quadratura_base::scene::light::linear_of_srgb;
use quadratura_base::scene::synthetic::{Modeller, centred, look_at};
use quadratura_base::scene::{FaceId, Model};
use quadratura_base::task::Task;
use quadratura_foliage::{
    BakeOptions, FlakeOptions, LightCorrection, Openness, OutdoorLight, PaintField, PlacedSpecies,
    PlacedTrees, Plant, PlantImages, Shades, SlabFrame, Species, SunShade, Sunlit, Tree, View, bake, draw,
    draw_flakes, draw_shaded, finest_copy, grow, painted, painted_slabs, similarity, slab_pictures,
};
use quadratura_projection::TextureOptions;
use quadratura_projection::relief::Relief;
use quadratura_projection::{Gains, Renders, Sources, TREE, shown_face};
use quadratura_view::{DisplayMode, Picture, Quality, Shot, TreeMethod};

pub(super) fn oak() -> Plant {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/oak.json");
    let species: Species = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    grow(&species).unwrap()
}

/// A plant in two places: upright in the origin, and turned, squeezed and mirrored beside it.
fn placed(plant: Plant) -> PlacedTrees {
    let light = OutdoorLight::day(plant.up);
    let squeezed = DMat3::from_rotation_z(1.0) * DMat3::from_diagonal(DVec3::new(0.7, -0.5, 0.9));
    let tree = |number: u32, world_from_plant: DAffine3, tint: f32| Tree {
        number,
        name: format!("tree {number}"),
        species: 0,
        world_from_plant,
        tint: Vec3::splat(tint),
        casts: false,
        ratios: Arc::default(),
        sunlit: None,
    };
    let beside = DAffine3::from_mat3_translation(squeezed, DVec3::new(4.0, 3.0, 0.0));
    let trees = vec![tree(0, DAffine3::IDENTITY, 1.0), tree(1, beside, 0.5)];
    PlacedTrees {
        species: vec![PlacedSpecies {
            plant: Arc::new(plant),
            unpainted: None,
            images: None,
            openness: None,
        }],
        trees,
        light,
    }
}

fn renderer(gpu: &Gpu, model: Arc<Model>, placed: Option<PlacedTrees>) -> Renderer {
    let of_face = vec![0..0; model.faces.len()];
    let sources = Arc::new(Sources { of_face, ..Sources::default() });
    let texels = Arc::new(super::super::tests::NoTextures);
    let tiles = TileStore::new(gpu, &sources, texels, TextureOptions::default()).unwrap();
    let mut renderer = Renderer::new(gpu, model, sources, Gains::none(0), &Relief::default(), tiles).unwrap();
    renderer.set_trees(placed.map(Arc::new)).unwrap();
    renderer
}

fn shot(plant: &Plant, quality: Quality) -> Shot {
    let ball = plant.whole().bounds.ball;
    let eye = ball.middle + DVec3::new(1.0, -3.2, 0.4) * ball.radius;
    Shot { quality, ..Shot::new(centred(240, 200, 250.0), look_at(eye, ball.middle)) }
}

/// Returns covered pixels, and mean linear light of the covered part.
fn measured(picture: &Picture) -> (f64, DVec3) {
    let (mut covered, mut light) = (0.0, DVec3::ZERO);
    for [r, g, b, a] in picture.pixels() {
        let share = f64::from(*a) / 255.0;
        covered += share;
        light += share * DVec3::from_array([r, g, b].map(|byte| linear_of_srgb(f64::from(*byte) / 255.0)));
    }
    (covered, light / covered)
}

#[test]
fn a_tree_on_the_device_covers_what_brute_force_covers_in_the_same_light() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let plant = oak();
    let only = |number: usize| {
        let mut placed = placed(plant.clone());
        placed.trees = vec![placed.trees.swap_remove(number)];
        placed
    };
    for number in [0, 1] {
        let placed = only(number);
        let tree = &placed.trees[0];
        let mut on_device = renderer(&gpu, Arc::new(Model::default()), Some(placed.clone()));
        let shot = shot(&plant, Quality::Final);
        let found = on_device.picture(&shot, &Task::silent()).unwrap();
        let ball = &plant.whole().bounds.ball;
        let view = View::of_tree(shot.camera, &shot.pose, &tree.world_from_plant, ball);
        // As bright as the tree's tint makes it.
        let OutdoorLight { sun, sky, ground, .. } = placed.light;
        let scaled = OutdoorLight {
            sun: sun * tree.tint,
            sky: sky * tree.tint,
            ground: ground * tree.tint,
            ..placed.light
        };
        let expected = draw(&plant, &view, &scaled, &Task::silent()).unwrap().picture;
        let ((area, light), (area_expected, light_expected)) = (measured(&found), measured(&expected));
        // 4 samples a pixel against 16: of 1,000 covered pixels a few on outlines differ.
        assert!(
            (area / area_expected - 1.0).abs() < 0.01,
            "tree {number}: {area} and {area_expected} pixels"
        );
        // Each of 4 samples is lit by itself, and the middle of what is covered of 16: bark, which is thin, differs most, by 2 % of blue.
        let off = (light / light_expected - 1.0).abs().max_element();
        assert!(off < 0.03, "tree {number}: {light} and {light_expected}");
        // Pixels that are wholly covered or wholly empty are so on both.
        let flipped = found.pixels().iter().zip(expected.pixels()).filter(|(a, b)| a[3].abs_diff(b[3]) > 250);
        let (flipped, all) = (flipped.count(), found.pixels().len());
        assert!(flipped * 1000 < all, "tree {number}: {flipped} of {all} pixels");
    }
}

/// An oak whose upper half is red as seen from +x, and whose outermost leaves on one side are erased.
fn painted_oak() -> Plant {
    let (plant, options) = (oak(), BakeOptions { least_side: 96, most_side: 96, ..BakeOptions::SLABS });
    let copy = finest_copy(&plant, &options, &Task::silent()).unwrap().unwrap();
    let frame = SlabFrame::of(&plant.whole().bounds, &copy, options.slabs);
    let pictures = slab_pictures(&copy.views[0], &frame, 0);
    let texels = (0..frame.side / 2).flat_map(|y| (0..frame.side).map(move |x| (x, y)));
    let painted_texel = |(x, y): (u32, u32), shown: [u8; 4]| {
        let colour =
            if x < 9 * frame.side / 20 { [0; 4] } else { [50_000, 4_000, 3_000, 257 * u16::from(shown[3])] };
        (shown[3] > 0).then_some((x, y, colour))
    };
    let of_slab = |(slab, picture): (usize, &Vec<[u8; 4]>)| {
        let shown = |(x, y): (u32, u32)| picture[(y * frame.side + x) as usize];
        (slab, texels.clone().filter_map(|at| painted_texel(at, shown(at))).collect())
    };
    let pixels = pictures.iter().enumerate().map(of_slab).collect();
    let slabs =
        painted_slabs(&copy.views[0], &frame, 0, &pixels).into_values().map(|(slab, _)| slab).collect();
    let field = Arc::new(PaintField::new(vec![slabs]));
    painted(&plant, plant.root, &[(plant.root, field)].into()).plant
}

#[test]
fn a_painted_tree_on_the_device_is_as_red_as_by_brute_force_and_covers_as_much() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let (bare, plant) = (oak(), painted_oak());
    let shot = shot(&plant, Quality::Final);
    let mut placed = placed(plant.clone());
    placed.trees.truncate(1);
    let ball = &plant.whole().bounds.ball;
    let view = View::of_tree(shot.camera, &shot.pose, &DAffine3::IDENTITY, ball);
    let drawn = |plant: &Plant| {
        measured(&draw(plant, &view, &OutdoorLight::day(plant.up), &Task::silent()).unwrap().picture)
    };
    let found =
        renderer(&gpu, Arc::new(Model::default()), Some(placed)).picture(&shot, &Task::silent()).unwrap();
    let ((area, light), (expected_area, expected), (bare_area, bare)) =
        (measured(&found), drawn(&plant), drawn(&bare));
    assert!(
        expected_area < 0.97 * bare_area && expected.x / expected.y > 1.3 * bare.x / bare.y,
        "{expected} {bare}"
    );
    // Paint is found at the corners of polygons here, and at each fragment there.
    assert!((area / expected_area - 1.0).abs() < 0.02, "{area} and {expected_area} pixels");
    // 11 % less red were seen.
    assert!((light / expected - 1.0).abs().max_element() < 0.15, "{light} and {expected}");
}

#[test]
fn faces_hide_trees_and_trees_hide_faces_and_both_have_their_numbers() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let plant = oak();
    let shot = shot(&plant, Quality::Preview);
    let (placed, eye) = (placed(plant), shot.viewpoint());
    // Walls before and behind the trees: on the left before them, all over behind them.
    let mut model = Modeller::new();
    let across = |at: f64, from: f64, to: f64| {
        let forward = shot.pose.rotation.row(2);
        let (right, down) = (shot.pose.rotation.row(0), shot.pose.rotation.row(1));
        let origin = eye + at * (forward + from * right - 2.0 * down);
        [origin, at * (to - from) * right, at * 4.0 * down]
    };
    for (name, [origin, u, v]) in [("front", across(0.5, -2.0, 0.0)), ("back", across(60.0, -2.0, 2.0))] {
        model.object(name).quad(origin, u, v);
    }
    let model = model.finish();
    let mut with = renderer(&gpu, model.clone(), Some(placed));
    let mut without = renderer(&gpu, model, None);
    let [found, bare] =
        [&mut with, &mut without].map(|renderer| renderer.faces(&shot, &Task::silent()).unwrap());
    let trees = |numbers: &[u32]| numbers.iter().filter(|number| **number & TREE != 0).count();
    assert_eq!(trees(&bare), 0);
    for (at, (number, bare)) in found.iter().zip(&bare).enumerate() {
        let left = at % 240 < 120;
        assert_eq!(shown_face(*bare), Some(FaceId(u32::from(!left))));
        match number & TREE != 0 {
            true => assert!(!left && number & !TREE < 2, "a tree before the front wall at {at}"),
            false => assert_eq!(number, bare),
        }
    }
    assert!(trees(&found) > 1000, "{} pixels of trees", trees(&found));
    let none = Shot { trees: TreeMethod::None, ..shot.clone() };
    assert_eq!(with.faces(&none, &Task::silent()).unwrap(), bare);
    for quality in [Quality::Preview, Quality::Final] {
        let (none, shot) = (Shot { quality, ..none.clone() }, Shot { quality, ..shot.clone() });
        let bare = without.picture(&shot, &Task::silent()).unwrap();
        assert_eq!(with.picture(&none, &Task::silent()).unwrap(), bare, "nothing changes without trees");
        let picture = with.picture(&shot, &Task::silent()).unwrap();
        // Faces without photos are transparent. One sample a pixel or four, trees cover as much on average.
        let opaque = picture.pixels().iter().map(|pixel| f64::from(pixel[3]) / 255.0).sum::<f64>();
        assert!((opaque / trees(&found) as f64 - 1.0).abs() < 0.03, "{opaque} opaque pixels");
    }
    // One colour a tree, and nothing of them where views show photos.
    let shows = |renderer: &mut Renderer, display: DisplayMode| {
        let shot = Shot { display, quality: Quality::Preview, ..shot.clone() };
        let picture = renderer.picture(&shot, &Task::silent()).unwrap();
        let mut colours: Vec<[u8; 4]> = picture.pixels().to_vec();
        colours.sort_unstable();
        colours.dedup();
        colours
    };
    assert_eq!(shows(&mut with, DisplayMode::Item).len(), 4, "two faces and two trees");
    assert_eq!(shows(&mut with, DisplayMode::Confidence), [[128, 128, 128, 0]]);
}

/// Returns the wood with images of its plant.
fn with_images(mut placed: PlacedTrees) -> PlacedTrees {
    let options = BakeOptions { least_side: 192, most_side: 192, ..BakeOptions::SLABS };
    for species in &mut placed.species {
        species.images = Some(Arc::new(bake(&species.plant, &options, &Task::silent()).unwrap()));
    }
    placed
}

#[test]
fn a_tree_from_images_is_like_the_one_of_polygons_near_and_far() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let plant = oak();
    let mut placed = with_images(placed(plant.clone()));
    placed.trees.truncate(1);
    let mut renderer = renderer(&gpu, Arc::new(Model::default()), Some(placed.clone()));
    let ball = plant.whole().bounds.ball;
    // As tall as the picture; an eighth of it, where four samples a pixel of polygons are no truth; and so near that branches are drawn by themselves.
    for (distance, quality, like) in
        [(3.2, Quality::Final, 0.9), (25.0, Quality::Final, 0.8), (1.2, Quality::Preview, 0.8)]
    {
        let eye = ball.middle + distance * ball.radius * DVec3::new(0.4, -0.9, 0.2).normalize();
        let shot = Shot { quality, ..Shot::new(centred(240, 200, 250.0), look_at(eye, ball.middle)) };
        let found = renderer.picture(&shot, &Task::silent()).unwrap();
        let polygons = Shot { trees: TreeMethod::Polygons, ..shot.clone() };
        let expected = renderer.picture(&polygons, &Task::silent()).unwrap();
        assert!(found != expected, "images were drawn at {distance}");
        let ((area, light), (area_expected, light_expected)) = (measured(&found), measured(&expected));
        // The goals of section 6 of the design for single views of previews: 5 % of coverage and light.
        assert!(
            (area / area_expected - 1.0).abs() < 0.05,
            "at {distance}: {area} and {area_expected} pixels"
        );
        // In single views of small trees, bark, which is little, makes blue differ most.
        let off = (light / light_expected - 1.0).abs().max_element();
        let most = if distance > 10.0 { 0.07 } else { 0.05 };
        assert!(off < most, "at {distance}: {light} and {light_expected}");
        let similar = similarity(&expected, &found).unwrap().ssim;
        assert!(similar > like, "at {distance}: SSIM {similar}");
        // Numbers are where colours are, but for the filter of a preview.
        let numbers =
            renderer.faces(&Shot { quality: Quality::Preview, ..shot.clone() }, &Task::silent()).unwrap();
        let numbered = numbers.iter().filter(|number| **number == TREE).count();
        assert!((numbered as f64 / area - 1.0).abs() < 0.05, "at {distance}: {numbered} numbers");
    }
}

#[test]
fn what_is_known_of_the_normals_of_samples_changes_light_as_much_on_the_device_as_on_the_processor() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let plant = oak();
    let both = with_images(placed(plant.clone()));
    let images = both.species[0].images.clone().expect("they were made");
    let mut bare = (*images).clone();
    for copy in bare.objects.iter_mut().flatten().flat_map(|of| &mut of.copies) {
        copy.correction = LightCorrection::none(images.directions.count());
    }
    let bare = Arc::new(bare);
    let mut renderer = renderer(&gpu, Arc::new(Model::default()), None);
    // Upright; and turned, squeezed and mirrored.
    for tree in &both.trees {
        let ball = plant.whole().bounds.ball.mapped(&tree.world_from_plant);
        let mut placed = PlacedTrees { trees: vec![tree.clone()], ..both.clone() };
        // So far that all is images, of which a sample is several leaves.
        let shots = [(0.5, -0.8), (0.9, 0.3), (-0.6, 0.7)].map(|(x, y)| {
            let eye = ball.middle + 14.0 * ball.radius * DVec3::new(x, y, 0.1).normalize();
            Shot { quality: Quality::Final, ..Shot::new(centred(160, 120, 300.0), look_at(eye, ball.middle)) }
        });
        for towards_sun in [DVec3::Z, DVec3::X, DVec3::Y, DVec3::new(0.8, 0.6, 0.0)] {
            placed.light = OutdoorLight { towards_sun, sky: Vec3::ZERO, ground: Vec3::ZERO, ..placed.light };
            let mut lights = |images: &Arc<PlantImages>| {
                placed.species[0].images = Some(images.clone());
                renderer.set_trees(Some(Arc::new(placed.clone()))).unwrap();
                let mut sums = [DVec3::ZERO; 2];
                for shot in &shots {
                    sums[0] += measured(&renderer.picture(shot, &Task::silent()).unwrap()).1;
                    let in_plant = &plant.whole().bounds.ball;
                    let view = View::of_tree(shot.camera, &shot.pose, &tree.world_from_plant, in_plant);
                    let options = FlakeOptions::FINAL;
                    let drawn =
                        draw_flakes(&plant, images, &view, &placed.light, &options, &Task::silent()).unwrap();
                    assert!(drawn.1.images > 0 && drawn.1.triangles == 0, "{:?}", drawn.1);
                    sums[1] += measured(&drawn.0).1;
                }
                sums
            };
            let (with, without) = (lights(&images), lights(&bare));
            let [device, processor] = [0, 1].map(|on| with[on] / without[on]);
            // 4 samples and 16 of a pixel, of 900 pixels in all: the light itself differs by up to 5 % in a view, what changes it by 1.4 %.
            let off = (device / processor - 1.0).abs().max_element();
            assert!(off < 0.02, "tree {}, {towards_sun}: {device} and {processor}", tree.number);
        }
    }
}

#[test]
fn crowns_and_what_shades_them_keep_as_much_light_on_the_device_as_on_the_processor() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let plant = oak();
    let openness = Openness::bake(&plant, &Task::silent()).unwrap();
    let mut placed = with_images(placed(plant.clone()));
    placed.trees.iter_mut().for_each(|tree| tree.tint = Vec3::ONE);
    placed.species[0].openness = Some(Arc::new(openness.clone()));
    // The tree that is turned, squeezed and mirrored, first alone, then behind one that is out of sight and in the shade, too.
    let space = openness.space();
    let middle = 0.5 * (space.low + space.high);
    let in_shade = |share: f32| {
        Sunlit::new(
            space,
            |point| if (point - middle).dot(DVec3::new(1.0, 0.4, 0.7)) > 0.0 { 1.0 } else { share },
        )
    };
    let mut other = placed.trees.swap_remove(0);
    let ball = plant.whole().bounds.ball.mapped(&placed.trees[0].world_from_plant);
    let eye = ball.middle + ball.radius * DVec3::new(1.0, -3.0, 0.4);
    other.world_from_plant.translation += 2.0 * (eye - ball.middle);
    other.sunlit = in_shade(0.7).map(Arc::new);
    let shot =
        Shot { quality: Quality::Final, ..Shot::new(centred(240, 200, 250.0), look_at(eye, ball.middle)) };
    let tree = placed.trees[0].clone();
    let view = View::of_tree(shot.camera, &shot.pose, &tree.world_from_plant, &plant.whole().bounds.ball);
    let (_, plain) = measured(&draw(&plant, &view, &placed.light, &Task::silent()).unwrap().picture);
    let mut renderer = renderer(&gpu, Arc::new(Model::default()), Some(placed.clone()));
    let mut least = 0.8 * plain.y;
    for sunlit in [None, in_shade(0.0)] {
        let sun = SunShade::Crown { towards_sun: placed.light.towards_sun, sunlit: sunlit.as_ref() };
        let shades = Shades { sun, openness: &openness };
        let shaded =
            draw_shaded(&plant, &view, &placed.light, Some(&shades), &Task::silent()).unwrap().picture;
        let (_, expected) = measured(&shaded);
        assert!(expected.y < least, "{expected} where it had been {least}");
        least = 0.8 * expected.y;
        if let Some(sunlit) = sunlit {
            let shaded = Tree { sunlit: Some(Arc::new(sunlit)), ..tree.clone() };
            placed.trees = vec![other.clone(), shaded];
            renderer.set_trees(Some(Arc::new(placed.clone()))).unwrap();
        }
        // The device looks up the grids where a pixel has its centre, with weights of 8 bits.
        for (trees, tolerance) in [(TreeMethod::Polygons, 0.04), (TreeMethod::Flakes, 0.07)] {
            let found = renderer.picture(&Shot { trees, ..shot.clone() }, &Task::silent()).unwrap();
            let (_, light) = measured(&found);
            let off = (light / expected - 1.0).abs().max_element();
            assert!(off < tolerance, "{trees:?}: {light} and {expected}");
        }
    }
}

#[test]
fn two_runs_of_narrow_words_find_what_one_run_of_wide_words_finds() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    if !gpu.has_wide_atomics() {
        return;
    }
    let plant = oak();
    let placed = with_images(placed(plant.clone()));
    let drawn = |gpu: &Gpu| {
        let mut renderer = renderer(gpu, Arc::new(Model::default()), Some(placed.clone()));
        renderer.picture(&shot(&plant, Quality::Final), &Task::silent()).unwrap()
    };
    let (wide, narrow) = (drawn(&gpu), drawn(&gpu.without_wide_atomics()));
    let different = wide.pixels().iter().zip(narrow.pixels()).filter(|(a, b)| a != b).count();
    // Two runs cannot tell samples apart whose depths differ by the last bits. On the software device no pixel is different; another
    // device may round depths otherwise.
    let covered = wide.pixels().iter().filter(|pixel| pixel[3] > 0).count();
    assert!(different * 1000 <= covered, "{different} of {covered} pixels");
}

#[test]
fn trees_from_images_hide_faces_and_faces_hide_them() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let plant = oak();
    let shot = shot(&plant, Quality::Preview);
    let forward = shot.pose.rotation.row(2);
    let (right, down) = (shot.pose.rotation.row(0), shot.pose.rotation.row(1));
    let wall = |at: f64| {
        let mut model = Modeller::new();
        model.object("wall").quad(
            shot.viewpoint() + at * (forward - 2.0 * right - 2.0 * down),
            at * 4.0 * right,
            at * 4.0 * down,
        );
        model.finish()
    };
    let placed = with_images(placed(plant));
    let trees = |model: Arc<Model>| {
        let mut renderer = renderer(&gpu, model, Some(placed.clone()));
        renderer.faces(&shot, &Task::silent()).unwrap().iter().filter(|number| **number & TREE != 0).count()
    };
    let (alone, before_a_wall) = (trees(Arc::new(Model::default())), trees(wall(60.0)));
    assert!(alone > 1000 && before_a_wall == alone, "{alone} {before_a_wall}");
    assert_eq!(trees(wall(0.5)), 0);
}
