//! Tests of brute force in closed form.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};

use super::{draft, plant_of, square};
use crate::leaf_picture::leaf_picture;
use crate::{
    LeafShape, Material, OutdoorLight, Pixels, Plant, Projection, Species, View, assemble, draw, grow,
};
use quadratura_base::error::Error;
use quadratura_base::geometry::Pinhole;
use quadratura_base::scene::light::{linear_of_srgb, srgb_from_linear};
use quadratura_base::scene::synthetic::{centred, look_at};
use quadratura_base::task::Task;
use quadratura_view::Picture;

fn sun(towards_sun: DVec3) -> OutdoorLight {
    let none = Vec3::ZERO;
    OutdoorLight { towards_sun, up: DVec3::Z, sun: Vec3::ONE, sky: none, ground: none }
}

fn drawn(plant: &Plant, view: &View, light: &OutdoorLight) -> Picture {
    draw(plant, view, light, &Task::silent()).unwrap().picture
}

/// A parallel view along z of 2 units around the origin, `side` pixels wide.
fn along_z(side: u32) -> View {
    let centre_px = DVec2::splat(0.5 * f64::from(side));
    let projection =
        Projection::Parallel { width: side, height: side, scale: 0.5 * f64::from(side), centre_px };
    View { projection, view_from_plant: DAffine3::IDENTITY, light_from_view: DMat3::IDENTITY }
}

fn byte(light: f64) -> u8 {
    (255.0 * srgb_from_linear(light)).round() as u8
}

#[test]
fn a_square_fills_its_view_parallel_and_in_perspective_with_its_light() {
    let plant = plant_of(Material { reflected: [0.2, 0.4, 0.6], ..Material::default() });
    let camera = Pinhole { width: 24, height: 24, fx: 60.0, fy: 60.0, cx: 12.0, cy: 12.0 };
    let away = DAffine3::from_translation(DVec3::new(0.0, 0.0, 5.0));
    let projection = Projection::Perspective { camera, near: 0.01 };
    let perspective = View { projection, view_from_plant: away, light_from_view: DMat3::IDENTITY };
    for view in [along_z(24), perspective] {
        let picture = drawn(&plant, &view, &sun(DVec3::Z));
        assert_eq!(picture.pixels(), vec![[byte(0.2), byte(0.4), byte(0.6), 255]; 24 * 24]);
    }
}

#[test]
fn half_a_pixel_is_half_covered_and_keeps_its_colour() {
    let plant = plant_of(Material { reflected: [0.5; 3], ..Material::default() });
    let mut view = along_z(8);
    // The square ends in the middle of pixels.
    view.view_from_plant = DAffine3::from_translation(DVec3::new(0.125, 0.0, 0.0));
    let picture = drawn(&plant, &view, &sun(DVec3::Z));
    for row in picture.pixels().chunks(8) {
        assert_eq!(
            (row[0], row[1]),
            ([byte(0.5), byte(0.5), byte(0.5), 128], [byte(0.5), byte(0.5), byte(0.5), 255])
        );
    }
}

#[test]
fn a_white_leaf_lit_from_behind_is_through_and_from_either_side_the_same() {
    let through = [0.25, 0.5, 0.75];
    let leaf = Material { reflected: [1.0; 3], through, leaf: true, ..Material::default() };
    let plant = plant_of(leaf);
    // The viewer of a view along z is on the side of -z.
    let lit = byte(0.25)..=byte(0.25);
    for turn in [0.0, std::f64::consts::PI] {
        let mut view = along_z(8);
        view.view_from_plant = DAffine3::from_rotation_x(turn);
        view.light_from_view = view.view_from_plant.matrix3.inverse();
        let behind = view.light_from_view * DVec3::Z;
        let pixels = drawn(&plant, &view, &sun(behind)).pixels().to_vec();
        assert!(lit.contains(&pixels[9][0]));
        assert_eq!(pixels[9], [byte(0.25), byte(0.5), byte(0.75), 255]);
        assert_eq!(drawn(&plant, &view, &sun(-behind)).pixels()[9], [255; 4]);
    }
}

#[test]
fn the_nearer_square_hides_the_other_in_whatever_order() {
    let material = |red: f32| Material { reflected: [red, 0.0, 0.0], ..Material::default() };
    let at = |z: f64| DAffine3::from_translation(DVec3::new(0.0, 0.0, z));
    for (first, second) in [(3.0, 4.0), (4.0, 3.0)] {
        let drafts = vec![
            draft("both", Vec::new(), &[(1, at(first)), (2, at(second))]),
            draft("a", vec![square(material(0.25))], &[]),
            draft("b", vec![square(material(0.75))], &[]),
        ];
        let plant = assemble(drafts, 0, DVec3::Z, 1.0).unwrap();
        let nearer = if first < second { 0.25 } else { 0.75 };
        assert_eq!(drawn(&plant, &along_z(8), &sun(DVec3::Z)).pixels()[20][0], byte(nearer));
    }
}

#[test]
fn a_picture_is_cut_out_by_its_alpha_and_colours_what_stays() {
    // The left half is empty.
    let rgba = vec![[255, 255, 255, 0], [255, 0, 0, 255]];
    let picture = Some(Arc::new(Pixels::new(2, 1, rgba)));
    let reflected = [0.5, 1.0, 1.0];
    let plant = plant_of(Material { cutout: Some(0.5), picture, reflected, ..Material::default() });
    let pixels = drawn(&plant, &along_z(8), &sun(DVec3::Z)).pixels().to_vec();
    assert_eq!((pixels[3], pixels[4]), ([0; 4], [byte(0.5), 0, 0, 255]));
}

/// A parallel view along z of 2 units around the origin, `side` pixels wide and moved by a part of a pixel.
fn from_far(side: u32, moved_px: DVec2) -> View {
    let mut view = along_z(side + 2);
    if let Projection::Parallel { scale, centre_px, .. } = &mut view.projection {
        (*scale, *centre_px) = (0.5 * f64::from(side), *centre_px + moved_px);
    }
    view
}

#[test]
fn a_leaf_covers_the_same_share_and_has_the_same_light_from_near_and_from_far() {
    let picture = Some(Arc::new(leaf_picture(LeafShape::Palmate, [0.1, 0.3, 0.05])));
    let reflected = [1.0; 3];
    let plant = plant_of(Material { cutout: Some(0.5), picture, reflected, ..Material::default() });
    let seen = |side: u32| {
        let moves = (0..25).map(|i| 0.2 * DVec2::new(f64::from(i % 5), f64::from(i / 5)));
        let (mut covered, mut light) = (0.0, 0.0);
        for moved_px in moves {
            for [_, green, _, alpha] in drawn(&plant, &from_far(side, moved_px), &sun(DVec3::Z)).pixels() {
                covered += f64::from(*alpha) / 255.0;
                light += f64::from(*alpha) / 255.0 * linear_of_srgb(f64::from(*green) / 255.0);
            }
        }
        (covered / (25.0 * f64::from(side * side)), light / covered)
    };
    let (share, light) = seen(192);
    assert!(share > 0.2 && share < 0.4, "{share}");
    for side in [48, 12, 6, 3] {
        let (far_share, far_light) = seen(side);
        // 25 x 16 x 9 samples at least, on a grid: they err far less than as many at random, by less than 1 / 100.
        assert!((far_share / share - 1.0).abs() < 0.02, "{side} pixels: {far_share}, {share}");
        assert!((far_light / light - 1.0).abs() < 0.03, "{side} pixels: {far_light}, {light}");
    }
}

#[test]
fn stripes_that_are_finer_than_pixels_are_grey_and_do_not_flicker() {
    let rgba = (0..64 * 64).map(|i| if i % 2 == 0 { [0, 0, 0, 255] } else { [255; 4] }).collect();
    let picture = Some(Arc::new(Pixels::new(64, 64, rgba)));
    let plant = plant_of(Material { picture, reflected: [1.0; 3], ..Material::default() });
    for side in [31, 12, 5] {
        let picture = drawn(&plant, &from_far(side, DVec2::new(0.3, 0.1)), &sun(DVec3::Z));
        let whole = picture.pixels().iter().filter(|pixel| pixel[3] == 255);
        // Between copies of one and of two columns a little of the stripes is left at 31 pixels for 64 columns.
        let about = if side == 31 { 12 } else { 1 };
        whole.for_each(|pixel| assert!(pixel[0].abs_diff(byte(0.5)) <= about, "{side}: {pixel:?}"));
    }
}

#[test]
fn a_ground_that_reaches_behind_the_camera_is_cut_off_and_fills_what_is_below_the_horizon() {
    let drafts = vec![
        draft("ground", Vec::new(), &[(1, DAffine3::from_scale(DVec3::new(1e4, 1e4, 1.0)))]),
        draft("square", vec![square(Material::default())], &[]),
    ];
    let plant = assemble(drafts, 0, DVec3::Z, 1.0).unwrap();
    let pose = look_at(DVec3::new(0.3, 0.1, 1.7), DVec3::new(3.0, 5.0, 1.7));
    let view = View::perspective(centred(40, 40, 30.0), &pose, &plant.whole().bounds.ball);
    let picture = drawn(&plant, &view, &sun(DVec3::Z));
    let alpha: Vec<u8> = picture.pixels().iter().map(|pixel| pixel[3]).collect();
    assert!(alpha[..19 * 40].iter().all(|alpha| *alpha == 0), "nothing is above the horizon");
    assert!(alpha[21 * 40..].iter().all(|alpha| *alpha == 255), "the ground has no gaps");
}

/// A small tree with all that the generator makes.
fn small_tree() -> Plant {
    let species: Species = serde_json::from_str(include_str!("../../../examples/oak.json")).unwrap();
    let levels = species.levels[..3].to_vec();
    grow(&Species { levels, ..species }).unwrap()
}

#[test]
fn pictures_have_the_same_bytes_for_any_number_of_threads() {
    let plant = small_tree();
    let pose = look_at(DVec3::new(14.0, -9.0, 4.0), DVec3::new(0.0, 0.0, 6.0));
    let view = View::perspective(centred(70, 90, 80.0), &pose, &plant.whole().bounds.ball);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| draw(&plant, &view, &OutdoorLight::day(DVec3::Z), &Task::silent()).unwrap())
    };
    let [one, two, three] = [1, 2, 3].map(with);
    assert!(one == two && two == three);
    let covered = one.picture.pixels().iter().filter(|pixel| pixel[3] > 0).count();
    assert!(covered > 500, "the tree is in the picture: {covered} pixels");
}

#[test]
fn an_instance_is_drawn_as_its_polygons_would_be_in_place() {
    let turn = DAffine3::from_mat3_translation(
        DMat3::from_rotation_y(0.7) * DMat3::from_diagonal(DVec3::new(0.5, -0.8, 0.3)),
        DVec3::new(0.1, -0.2, 0.4),
    );
    let used = assemble(
        vec![
            draft("tree", Vec::new(), &[(1, turn)]),
            draft("square", vec![square(Material::default())], &[]),
        ],
        0,
        DVec3::Z,
        1.0,
    );
    let alone = plant_of(Material::default());
    let view = along_z(40);
    let placed = View { view_from_plant: turn, ..view };
    let light = OutdoorLight { sky: Vec3::ZERO, ..sun(DVec3::Z) };
    let alpha = |picture: Picture| picture.pixels().iter().map(|pixel| pixel[3]).collect::<Vec<_>>();
    // Light stays in the plant's frame, which differs; what is covered does not.
    let covered = alpha(drawn(&used.unwrap(), &view, &light));
    assert_eq!(covered, alpha(drawn(&alone, &placed, &light)));
    assert!(covered.contains(&255) && covered.contains(&0));
}

#[test]
fn plants_of_nothing_and_of_too_many_triangles_are_refused_with_their_counts() {
    let refused = |plant: &Plant| match draw(plant, &along_z(4), &sun(DVec3::Z), &Task::silent()) {
        Err(Error::Request(text)) => text,
        other => panic!("{other:?}"),
    };
    let empty = assemble(vec![draft("nothing", Vec::new(), &[])], 0, DVec3::Z, 1.0).unwrap();
    assert!(refused(&empty).contains("no polygons"));
    let uses = |child: usize| vec![(child, DAffine3::IDENTITY); 100];
    let drafts = (0..7).map(|i| match i {
        6 => draft("leaf", vec![square(Material::default())], &[]),
        _ => draft(&format!("level {i}"), Vec::new(), &uses(i + 1)),
    });
    let many = assemble(drafts.collect(), 0, DVec3::Z, 1.0).unwrap();
    let text = refused(&many);
    assert!(text.contains("2000000000000 triangles in 1000000000000 sub-objects"), "{text}");
}

#[test]
fn drawing_stops_on_request() {
    let task = Task::silent();
    task.stop_flag().store(true, std::sync::atomic::Ordering::Relaxed);
    let stopped = draw(&small_tree(), &along_z(8), &sun(DVec3::Z), &task);
    assert!(matches!(stopped, Err(Error::Cancelled)));
}
