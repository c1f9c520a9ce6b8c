//! Tests of images of sub-objects, of walks, and of pictures that are drawn from images.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};

use super::{draft, plant_of, square};
use crate::{
    BakeOptions, Corner, Directions, Drawn, ImageCopy, LayeredOptions, LightCorrection, MBuffer, Material,
    ObjectImages, OutdoorLight, Part, Plant, PlantImages, Primitive, Projection, Shape, Species,
    TriangleList, View, WalkOptions, assemble, bake, draw, draw_layered, grow, similarity, walk,
};
use quadratura_base::scene::synthetic::{Rng, centred, look_at};
use quadratura_base::task::Task;
use quadratura_view::Picture;

const MAPLE: &str = include_str!("../../../examples/maple.json");
pub const SMALL: BakeOptions = BakeOptions { side: 96, least_side: 96, most_side: 96, ..BakeOptions::LAYERS };

/// A branch of the maple: 17,048 polygons in 955 sub-objects.
pub fn branch() -> Plant {
    let maple = grow(&serde_json::from_str::<Species>(MAPLE).unwrap()).unwrap();
    let root = maple.objects.iter().position(|object| object.counts.polygons == 17_048).unwrap();
    Plant { objects: maple.objects[..=root].to_vec(), root, ..maple }
}

/// A ball of bark of radius 1 with smooth normals.
pub fn ball() -> Plant {
    let (rows, columns) = (24u32, 48u32);
    let corners = (0..=rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    let corner = |(row, column): (u32, u32)| {
        let latitude = std::f64::consts::PI * (f64::from(row) / f64::from(rows) - 0.5);
        let longitude = std::f64::consts::TAU * f64::from(column) / f64::from(columns);
        let (sin, cos) = latitude.sin_cos();
        let position = DVec3::new(cos * longitude.cos(), cos * longitude.sin(), sin);
        Corner { position, normal: position, texture: DVec2::ZERO }
    };
    let at = |row: u32, column: u32| row * columns + column % columns;
    let triangles =
        (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))).flat_map(|(r, c)| {
            [[at(r, c), at(r, c + 1), at(r + 1, c + 1)], [at(r, c), at(r + 1, c + 1), at(r + 1, c)]]
        });
    let list = TriangleList { corners: corners.map(corner).collect(), triangles: triangles.collect() };
    let primitive = Primitive { shape: Shape::Triangles(list), material: Arc::new(Material::default()) };
    assemble(vec![draft("ball", vec![primitive], &[])], 0, DVec3::Z, 1.0).unwrap()
}

/// A view of all of a plant from a direction, `side` pixels wide.
pub fn from(plant: &Plant, towards: DVec3, side: u32) -> View {
    let ball = plant.whole().bounds.ball;
    let pose = look_at(ball.middle + 4.0 * ball.radius * towards.normalize(), ball.middle);
    View::perspective(centred(side, side, 1.9 * f64::from(side)), &pose, &ball)
}

fn layered(plant: &Plant, images: &PlantImages, view: &View, options: &LayeredOptions) -> Picture {
    draw_layered(plant, images, view, &OutdoorLight::day(plant.up), options, &Task::silent()).unwrap().0
}

pub fn brute(plant: &Plant, view: &View) -> Picture {
    draw(plant, view, &OutdoorLight::day(plant.up), &Task::silent()).unwrap().picture
}

#[test]
fn from_images_a_branch_looks_as_its_polygons_do_from_any_side_and_distance() {
    let plant = branch();
    // A pixel of a coarse image holds several leaves, which are lit by their mean normal: seen against the sun, up to 9 % darker.
    let fine = BakeOptions { side: 192, least_side: 192, most_side: 192, ..SMALL };
    let images = bake(&plant, &fine, &Task::silent()).unwrap();
    let directions = [DVec3::new(1.0, 0.2, 0.1), DVec3::new(-0.3, 1.0, 0.5), DVec3::new(0.4, -0.6, -0.9)];
    let mut all = Vec::new();
    for (side, options, least) in [
        (30, LayeredOptions::FINAL, 0.93),
        (60, LayeredOptions::PREVIEW, 0.92),
        (30, LayeredOptions::PREVIEW, 0.90),
    ] {
        for towards in directions {
            let view = from(&plant, towards, side);
            let light = OutdoorLight::day(plant.up);
            let (picture, cost) =
                draw_layered(&plant, &images, &view, &light, &options, &Task::silent()).unwrap();
            let found = similarity(&brute(&plant, &view), &picture).unwrap();
            let within = |ratio: f64, most: f64| (ratio - 1.0).abs() < most;
            let is_like = found.ssim > least && within(found.coverage, 0.05) && within(found.light, 0.1);
            all.push((is_like && cost.images > 0 && cost.samples > 0, side, found, cost));
        }
    }
    assert!(all.iter().all(|(is_like, ..)| *is_like), "{all:#?}");
}

#[test]
fn sub_objects_have_images_as_fine_as_wanted_or_with_two_samples_for_each_polygon() {
    let plant = branch();
    let images = bake(&plant, &BakeOptions { side: 192, ..SMALL }, &Task::silent()).unwrap();
    let mut are_as_wanted = Vec::new();
    for (index, (object, images)) in plant.objects.iter().zip(&images.objects).enumerate() {
        let Some(images) = images else { continue };
        let (finest, across) = (&images.copies[0], 2.0 * object.bounds.ball.radius);
        let samples: usize = [0, 2, 4].map(|side: usize| finest.views[side].samples.len()).iter().sum();
        let per_polygon = samples as f64 / (3 * object.counts.polygons) as f64;
        let wanted = if index == plant.root { 96.0 } else { 192.0 };
        let is_as_wanted = across / finest.delta > 0.99 * wanted;
        // The next finer image has at most about twice as many samples, and more than two for each polygon: 1.1 is the least here.
        assert!(
            per_polygon <= 2.0 && (is_as_wanted || per_polygon > 1.0),
            "{}: {per_polygon}, {} pixels",
            object.name,
            finest.side
        );
        let ratios: Vec<f64> = images.copies.iter().map(|copy| copy.delta / finest.delta).collect();
        assert_eq!(ratios, [1.0, 2.0, 4.0, 8.0][..ratios.len()], "{}", object.name);
        let coarsest = across / images.copies[ratios.len() - 1].delta;
        assert!((23.99..47.99).contains(&coarsest), "{}: {coarsest} pixels", object.name);
        if index != plant.root {
            are_as_wanted.push(is_as_wanted);
        }
    }
    assert!(images.objects[0].is_none(), "a leaf has two polygons");
    assert!(are_as_wanted.contains(&false), "some parts are coarser");
}

#[test]
fn coarser_images_than_wanted_are_made_of_what_is_used_as_often_as_there_are_directions() {
    let leaf = draft("leaf", vec![square(Material::default())], &[]);
    // From above they cover each other, so that with 96 pixels across there are too many samples, and with 24 there are not.
    let at = |i: u32| DVec3::new(f64::from(i % 10), f64::from(i / 10 % 10), f64::from(i / 100));
    let moved = |step: f64, i: u32| DAffine3::from_translation(step * at(i));
    let twig: Vec<_> = (0..1200).map(|i| (0, moved(1.0, i))).collect();
    let options = BakeOptions { least_side: 24, most_side: 24, ..SMALL };
    let has_images = |directions: Directions, count: u32| {
        let uses: Vec<_> = (0..count).map(|i| (1, moved(20.0, i))).collect();
        let drafts = vec![leaf.clone(), draft("twig", Vec::new(), &twig), draft("branch", Vec::new(), &uses)];
        let branch = assemble(drafts, 2, DVec3::Z, 1.0).unwrap();
        let images = bake(&branch, &BakeOptions { directions, ..options }, &Task::silent()).unwrap();
        if let Some(of_twig) = &images.objects[1] {
            assert!(of_twig.copies[0].side < 90, "as fine as wanted: {}", of_twig.copies[0].side);
        }
        images.objects.iter().map(Option::is_some).collect::<Vec<_>>()
    };
    assert_eq!(has_images(Directions::Around, 21), [false, false, true]);
    assert_eq!(has_images(Directions::Around, 22), [false, true, true]);
    assert_eq!(has_images(Directions::Axes, 5), [false, false, true]);
    assert_eq!(has_images(Directions::Axes, 6), [false, true, true]);
}

#[test]
fn a_flat_spray_that_is_used_once_has_no_images_since_from_above_it_has_many_samples() {
    let leaf = draft("leaf", vec![square(Material::default())], &[]);
    let at = |i: u32| DVec3::new(2.0 * f64::from(i % 10), 2.0 * f64::from(i / 10), 0.0);
    let uses: Vec<_> = (0..100).map(|i| (0, DAffine3::from_translation(at(i)))).collect();
    let once = [(1, DAffine3::IDENTITY)];
    let drafts = vec![leaf, draft("spray", Vec::new(), &uses), draft("twig", Vec::new(), &once)];
    let twig = assemble(drafts, 2, DVec3::Z, 1.0).unwrap();
    let images = bake(&twig, &SMALL, &Task::silent()).unwrap();
    // From the side alone it has no samples at all, fewer than polygons.
    assert_eq!(images.objects[1], None);
}

#[test]
fn no_background_shines_through_a_ball_of_bark() {
    let plant = ball();
    let images = bake(&plant, &BakeOptions { side: 24, least_side: 24, ..SMALL }, &Task::silent()).unwrap();
    assert!(images.objects[0].is_some());
    let mut rng = Rng::new(31);
    for side in [26, 20] {
        let mut axis = || rng.between(-1.0, 1.0);
        let view = from(&plant, DVec3::new(axis(), axis(), axis()), side);
        // The finest image has 24 pixels across the ball, which takes some 24 and 19 pixels here; a pixel of it on the near side takes up
        // to one and a half.
        let options = LayeredOptions { walk: WalkOptions { threshold: 9.0 }, ..LayeredOptions::PREVIEW };
        let (truth, picture) = (brute(&plant, &view), layered(&plant, &images, &view, &options));
        let inside = truth.pixels().iter().zip(picture.pixels()).filter(|(truth, _)| truth[3] == 255);
        let (count, open) = inside.fold((0u32, 0.0), |(count, open), (_, pixel)| {
            (count + 1, open + 1.0 - f64::from(pixel[3]) / 255.0)
        });
        assert!(count > 150 && open / f64::from(count) < 0.01, "{side}: {open} of {count}");
    }
}

#[test]
fn a_square_covers_its_area_at_any_turn() {
    let mut plant = plant_of(Material::default());
    // One polygon is no reason for an image, so this one is made of many.
    let uses: Vec<_> = (0..400).map(|_| (1, DAffine3::IDENTITY)).collect();
    let drafts =
        vec![draft("stack", Vec::new(), &uses), draft("square", vec![square(Material::default())], &[])];
    plant.objects = assemble(drafts, 0, DVec3::Z, 1.0).unwrap().objects;
    plant.root = 1;
    let options = BakeOptions { side: 16, least_side: 16, most_side: 16, ..SMALL };
    let images = bake(&plant, &options, &Task::silent()).unwrap();
    let mut rng = Rng::new(33);
    for _ in 0..12 {
        // From above, turned about the line of sight, up to 40 degrees from it.
        let (turn, lean) = (rng.between(0.0, 6.3), rng.between(0.0, 0.7));
        let turned = DQuat::from_rotation_z(rng.between(0.0, 6.3))
            * DQuat::from_rotation_x(std::f64::consts::PI + lean);
        let rotation = DMat3::from_quat(turned * DQuat::from_rotation_z(turn));
        let projection =
            Projection::Parallel { width: 30, height: 30, scale: 6.0, centre_px: DVec2::new(15.3, 14.8) };
        let view_from_plant = DAffine3::from_mat3(rotation);
        let view = View { projection, view_from_plant, light_from_view: rotation.transpose() };
        let walk = WalkOptions { threshold: 9.0 };
        let picture = layered(&plant, &images, &view, &LayeredOptions { walk, ..LayeredOptions::FINAL });
        let area =
            |picture: &Picture| -> f64 { picture.pixels().iter().map(|p| f64::from(p[3]) / 255.0).sum() };
        let ratio = area(&picture) / area(&brute(&plant, &view));
        // An outline is known to a quarter of an image's pixel, of which the square has eleven to a side.
        assert!((ratio - 1.0).abs() < 0.08, "{turn} {lean}: {ratio}");
    }
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let plant = branch();
    let view = from(&plant, DVec3::new(0.7, 0.3, 0.2), 150);
    let drawn = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let images = bake(&plant, &BakeOptions { side: 48, ..SMALL }, &Task::silent()).unwrap();
            let picture = layered(&plant, &images, &view, &LayeredOptions::PREVIEW);
            (images, picture)
        })
    };
    let first = drawn(1);
    assert!(first.1.pixels().iter().filter(|pixel| pixel[3] > 0).count() > 1000);
    for threads in [2, 5] {
        assert!(drawn(threads) == first, "{threads} threads");
    }
}

/// Images without content, of random objects.
fn any_images(plant: &Plant, rng: &mut Rng) -> PlantImages {
    let objects = plant.objects.iter().map(|object| {
        (rng.between(0.0, 1.0) < 0.6).then(|| {
            let delta = object.bounds.ball.radius / rng.between(4.0, 200.0);
            let copy = |step: i32| ImageCopy {
                delta: delta * f64::from(1 << step),
                side: 2,
                views: vec![MBuffer::default(); 22],
                correction: LightCorrection::none(22),
            };
            ObjectImages { copies: (0..3).map(copy).collect(), through: glam::Vec3::ONE }
        })
    });
    PlantImages { directions: Directions::Around, from_parts: false, objects: objects.collect() }
}

/// A random graph without cycles; every object has primitives of its own.
fn any_plant(rng: &mut Rng) -> Plant {
    let count = 3 + (rng.bits() % 5) as usize;
    let drafts = (0..count).map(|object| {
        let primitives = (0..1 + rng.bits() % 3).map(|_| square(Material::default())).collect();
        let uses: Vec<(usize, DAffine3)> = (0..rng.bits() % 4)
            .filter(|_| object + 1 < count)
            .map(|_| {
                let child = object + 1 + (rng.bits() as usize) % (count - object - 1);
                let mut axis = || rng.between(-3.0, 3.0);
                let shift = DVec3::new(axis(), axis(), axis());
                let turn = DQuat::from_rotation_y(axis());
                let scale = DVec3::splat(0.2 + 0.1 * axis().abs());
                (child, DAffine3::from_scale_rotation_translation(scale, turn, shift))
            })
            .collect();
        draft(&format!("{object}"), primitives, &uses)
    });
    assemble(drafts.collect(), 0, DVec3::Z, 1.0).unwrap()
}

#[test]
fn a_walk_draws_every_instance_in_each_sub_pixel_exactly_once_itself_or_by_one_above_it() {
    let mut rng = Rng::new(34);
    let (mut by_image, mut by_polygons, mut in_part) = (0, 0, 0);
    for _ in 0..300 {
        let plant = any_plant(&mut rng);
        let images = any_images(&plant, &mut rng);
        let view = from(&plant, DVec3::new(1.0, 0.5, 0.3), 64);
        let options = WalkOptions { threshold: rng.between(0.05, 3.0) };
        let drawn = walk(&plant, &images, &view, &options, 5);
        let mut triangles = |Drawn { object, part, stipple, .. }: &Drawn| {
            in_part += u32::from(!stipple.is_wide());
            let of = &plant.objects[*object];
            match part {
                Part::Image(_) => {
                    by_image += 1;
                    of.counts.triangles
                }
                Part::Polygons(_) => {
                    by_polygons += 1;
                    of.primitives.iter().map(|primitive| primitive.shape.triangles()).sum()
                }
            }
        };
        let triangles: Vec<u64> = drawn.iter().map(&mut triangles).collect();
        for (x, y) in [(0, 0), (17, 40), (63, 9)] {
            let open = |drawn: &Drawn| u64::from(drawn.stipple.open_at(x, y).count_ones());
            let in_sub_pixels =
                drawn.iter().zip(&triangles).map(|(drawn, triangles)| open(drawn) * triangles);
            assert_eq!(in_sub_pixels.sum::<u64>(), 16 * plant.whole().counts.triangles);
        }
        let key = |drawn: &Drawn| match drawn.part {
            Part::Image(copy) => (drawn.path, copy),
            Part::Polygons(_) => (drawn.path, usize::MAX),
        };
        let mut parts: Vec<_> = drawn.iter().map(key).collect();
        parts.sort_unstable();
        parts.dedup();
        assert_eq!(parts.len(), drawn.len(), "each instance has a way of its own");
    }
    assert!(by_image > 100 && by_polygons > 100 && in_part > 50, "{by_image} {by_polygons} {in_part}");
}

#[test]
fn the_coarsest_image_that_is_fine_enough_serves_and_none_behind_or_around_the_viewer() {
    let plant = branch();
    let objects = vec![None; plant.objects.len()];
    let mut images = PlantImages { directions: Directions::Around, from_parts: false, objects };
    let radius = plant.whole().bounds.ball.radius;
    let copy = |delta: f64| ImageCopy {
        delta,
        side: 2,
        views: vec![MBuffer::default(); 22],
        correction: LightCorrection::none(22),
    };
    let copies = [0.01, 0.02, 0.04].map(|share| copy(share * radius)).to_vec();
    images.objects[plant.root] = Some(ObjectImages { copies, through: glam::Vec3::ONE });
    let parts = |view: &View, threshold: f64| {
        let drawn = walk(&plant, &images, view, &WalkOptions { threshold }, 0);
        drawn.iter().map(|drawn| drawn.part).collect::<Vec<_>>()
    };
    // The nearest point is 3 radii away: a radius has 76 pixels there at most.
    let view = from(&plant, DVec3::X, 120);
    let of_radius = 1.9 * 120.0 / 3.0;
    for (copy, share) in [0.01, 0.02, 0.04].into_iter().enumerate() {
        let needed = share * of_radius;
        let alone = needed / WalkOptions { threshold: 1.0 }.alone();
        assert_eq!(parts(&view, 1.02 * alone), [Part::Image(copy)]);
        // The dissolve of an instance ends at the threshold or up to a tenth below it: it has begun here, and has not ended.
        assert_eq!(parts(&view, 1.15 * needed)[0], Part::Image(copy));
        assert!(parts(&view, 1.15 * needed).len() > 1);
        assert!(!parts(&view, 0.98 * needed).contains(&Part::Image(copy)));
    }
    let ball = plant.whole().bounds.ball;
    let inside =
        View::perspective(centred(64, 64, 64.0), &look_at(ball.middle, ball.middle + DVec3::X), &ball);
    assert!(matches!(parts(&inside, 1e9)[0], Part::Polygons(_)));
    let away = look_at(ball.middle + 3.0 * radius * DVec3::X, ball.middle + 9.0 * radius * DVec3::X);
    assert_eq!(parts(&View::perspective(centred(64, 64, 64.0), &away, &ball), 1e9), []);
}
