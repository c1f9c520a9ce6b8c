//! Tests of shadows and openness in closed form.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};

use super::{draft, plant_of, square};
use crate::{
    Ball, Caster, Material, Openness, OutdoorLight, Plant, Projection, Shades, Shadow, Species, SunShade,
    View, assemble, draw, draw_in_lights, draw_shaded, grow,
};
use quadratura_base::scene::light::linear_of_srgb;
use quadratura_base::task::Task;
use quadratura_view::Picture;

/// A wide square at z = 0 below a square of half its side at z = 1.
fn table() -> Plant {
    let at = |scale: f64, z: f64| {
        DAffine3::from_mat3_translation(DMat3::from_diagonal(DVec3::splat(scale)), DVec3::new(0.0, 0.0, z))
    };
    let one = draft("square", vec![square(Material::default())], &[]);
    let both = draft("table", Vec::new(), &[(0, at(2.0, 0.0)), (0, at(0.5, 1.0))]);
    assemble(vec![one, both], 1, DVec3::Z, 1.0).unwrap()
}

fn shadow(plant: &Plant, towards_sun: DVec3) -> Shadow {
    let caster = Caster { plant, frame_from_plant: DAffine3::IDENTITY };
    let ball = plant.whole().bounds.ball;
    Shadow::cast(&[caster], &ball, towards_sun.normalize(), &Task::silent()).unwrap()
}

#[test]
fn the_shadow_of_a_square_is_where_the_sun_throws_it_and_nowhere_else() {
    let (plant, towards_sun) = (table(), DVec3::new(1.0, 0.0, 2.0).normalize());
    let shadow = shadow(&plant, towards_sun);
    let lit = |point: DVec3| {
        let in_sun = shadow.sun_from_frame().transform_point3(point);
        shadow.lit(in_sun, towards_sun.z)
    };
    // The square at z = 1 reaches from -0.5 to 0.5 and throws its shadow half as far away as it is high.
    for i in -180..180 {
        let x = f64::from(i) / 100.0;
        let inside = (-1.0..0.0).contains(&x);
        let at_border = (x + 1.0).abs() < 0.03 || x.abs() < 0.03;
        let found = lit(DVec3::new(x, 0.2, 0.0));
        assert!(at_border || found == f32::from(u8::from(!inside)), "{x}: {found}");
    }
    assert_eq!(lit(DVec3::new(0.1, 0.2, 1.0)), 1.0, "no shadow on itself");
    assert_eq!(lit(DVec3::new(-3.2, 0.2, -6.0)), 0.0, "below the ground");
    assert_eq!(lit(DVec3::new(90.0, 0.0, 0.0)), 1.0, "nothing is known beyond what was drawn");
}

#[test]
fn a_surface_at_any_slope_to_the_sun_has_no_shadow_on_itself() {
    let plant = plant_of(Material::default());
    for degrees in [0.0f64, 30.0, 60.0, 70.0] {
        let towards_sun = DVec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
        let shadow = shadow(&plant, towards_sun);
        for i in 0..100 {
            let point = DVec3::new(f64::from(i) * 0.018 - 0.9, f64::from(i % 7) * 0.2 - 0.6, 0.0);
            assert_eq!(
                shadow.lit(shadow.sun_from_frame().transform_point3(point), towards_sun.z),
                1.0,
                "{degrees}: {point}"
            );
        }
    }
}

#[test]
fn other_plants_cast_shadows_too() {
    let plant = plant_of(Material::default());
    let above = Caster { plant: &plant, frame_from_plant: DAffine3::from_translation(DVec3::Z * 3.0) };
    let below = Caster { plant: &plant, frame_from_plant: DAffine3::IDENTITY };
    let ball = Ball { middle: DVec3::ZERO, radius: 2.0 };
    let lit = |casters: &[Caster<'_>]| {
        let shadow = Shadow::cast(casters, &ball, DVec3::Z, &Task::silent()).unwrap();
        shadow.lit(shadow.sun_from_frame().transform_point3(DVec3::ZERO), 1.0)
    };
    assert_eq!([lit(&[below]), lit(&[below, above]), lit(&[above])], [1.0, 0.0, 0.0]);
}

#[test]
fn a_point_is_open_where_nothing_is_and_half_open_beside_a_wall() {
    // A wall of a hundred times its distance from the point.
    let plant = plant_of(Material::default());
    let openness = Openness::bake(&plant, &Task::silent()).unwrap();
    let (_, cell, _) = openness.grid();
    assert!(cell > 0.0);
    let middle = openness.at(DVec3::ZERO, DVec3::X);
    assert!((0.0..=1.0).contains(&middle));
    // One small square in a large box: far from it everything is open.
    let far = DAffine3::from_translation(DVec3::new(40.0, 40.0, 40.0));
    let one = draft("square", vec![square(Material::default())], &[]);
    let two = draft("two", Vec::new(), &[(0, DAffine3::IDENTITY), (0, far)]);
    let plant = assemble(vec![one, two], 1, DVec3::Z, 1.0).unwrap();
    let openness = Openness::bake(&plant, &Task::silent()).unwrap();
    for normal in [DVec3::X, -DVec3::Y, DVec3::Z] {
        assert!(openness.at(DVec3::new(10.0, 30.0, 20.0), normal) > 0.98, "{normal}");
    }
}

#[test]
fn below_a_roof_the_sky_is_closed_and_the_ground_is_open() {
    // Two roofs, far apart, so that the box is as high as it is wide.
    let at = |z: f64| {
        DAffine3::from_mat3_translation(DMat3::from_diagonal(DVec3::splat(10.0)), DVec3::new(0.0, 0.0, z))
    };
    let one = draft("square", vec![square(Material::default())], &[]);
    let both = draft("roofs", Vec::new(), &[(0, at(0.0)), (0, at(20.0))]);
    let plant = assemble(vec![one, both], 1, DVec3::Z, 1.0).unwrap();
    let openness = Openness::bake(&plant, &Task::silent()).unwrap();
    let below = DVec3::new(0.0, 0.0, 18.0);
    let (up, down) = (openness.at(below, DVec3::Z), openness.at(below, -DVec3::Z));
    // Open are the 8 level directions, 38 % of the sphere, and the 6 that go down at 45 degrees, 27 %: 0.65 on average. The
    // vector of the latter is 0.27 sin 45 degrees long, and counts twice.
    assert!((up - 0.27).abs() < 0.02, "{up}");
    assert!(down > 0.98, "{down}");
    let above = DVec3::new(0.0, 0.0, 20.0);
    assert!(openness.at(above, DVec3::Z) > openness.at(below, DVec3::Z) + 0.3);
}

fn light_of(picture: &Picture) -> (f64, f64) {
    let (mut covered, mut light) = (0.0, 0.0);
    for [_, g, _, a] in picture.pixels() {
        covered += f64::from(*a) / 255.0;
        light += f64::from(*a) / 255.0 * linear_of_srgb(f64::from(*g) / 255.0);
    }
    (covered, light / covered)
}

#[test]
fn an_oak_with_shadows_covers_the_same_and_is_darker_inside() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/oak.json");
    let species: Species = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let plant = grow(&species).unwrap();
    let (light, ball) = (OutdoorLight::day(plant.up), plant.whole().bounds.ball);
    // In parallel from the sun, as its own view is.
    let centre_px = DVec2::splat(50.0);
    let projection = Projection::Parallel { width: 100, height: 100, scale: 48.0 / ball.radius, centre_px };
    let shadow = shadow(&plant, light.towards_sun);
    let view_from_plant = shadow.sun_from_frame();
    let light_from_view = view_from_plant.matrix3.transpose();
    let view = View { projection, view_from_plant, light_from_view };
    let openness = Openness::bake(&plant, &Task::silent()).unwrap();
    let shades = Shades {
        sun: SunShade::Shadow { shadow: &shadow, frame_from_plant: DAffine3::IDENTITY },
        openness: &openness,
    };
    let plain = draw(&plant, &view, &light, &Task::silent()).unwrap().picture;
    let shaded = draw_shaded(&plant, &view, &light, Some(&shades), &Task::silent()).unwrap().picture;
    let ((covered, bright), (same, dark)) = (light_of(&plain), light_of(&shaded));
    assert_eq!(covered, same);
    assert!((0.3..0.95).contains(&(dark / bright)), "{dark} of {bright}");
    // What the sun sees is lit by it, but for the borders of leaves, over which shadows are interpolated: a pixel of the sun's
    // view on either side, where a leaf is some five of them wide.
    let sun = OutdoorLight { sky: Vec3::ZERO, ground: Vec3::ZERO, ..light };
    let nothing = vec![f32::NEG_INFINITY; 100 * 100];
    let parts = |shades: Option<&Shades<'_>>| {
        let drawn = draw_in_lights(&plant, &view, [sun, light], &nothing, shades, &Task::silent()).unwrap();
        drawn.iter().map(|pixel| pixel.sums[0].y).sum::<f32>()
    };
    let share = parts(Some(&shades)) / parts(None);
    assert!((0.7..=1.0).contains(&share), "{share}");
}

#[test]
fn the_sun_lights_a_crown_that_is_known_cell_by_cell_as_much_as_one_that_is_known_leaf_by_leaf() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/oak.json");
    let species: Species = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let plant = grow(&species).unwrap();
    let ball = plant.whole().bounds.ball;
    let openness = Openness::bake(&plant, &Task::silent()).unwrap();
    // The plant lies in the world: the direction to the sun comes back to its frame.
    let world_from_plant = DMat3::from_rotation_x(1.0);
    let projection = Projection::Parallel {
        width: 100,
        height: 100,
        scale: 48.0 / ball.radius,
        centre_px: DVec2::splat(50.0),
    };
    let view_from_world = DMat3::from_rotation_y(2.0);
    let linear = view_from_world * world_from_plant;
    let view = View {
        projection,
        view_from_plant: DAffine3::from_mat3_translation(linear, -(linear * ball.middle)),
        light_from_view: view_from_world.transpose(),
    };
    for towards_sun in [DVec3::new(0.5, 0.2, 0.8), DVec3::new(-0.9, 0.1, 0.1), DVec3::new(0.1, -0.7, -0.7)] {
        let towards_sun = towards_sun.normalize();
        let light =
            OutdoorLight { towards_sun, up: DVec3::Z, sun: Vec3::ONE, sky: Vec3::ZERO, ground: Vec3::ZERO };
        let shadow = shadow(&plant, world_from_plant.transpose() * towards_sun);
        let sum = |sun: Option<SunShade<'_>>| {
            let shades = sun.map(|sun| Shades { sun, openness: &openness });
            let nothing = vec![f32::NEG_INFINITY; 100 * 100];
            let drawn = draw_in_lights(&plant, &view, [light; 2], &nothing, shades.as_ref(), &Task::silent())
                .unwrap();
            drawn.iter().map(|pixel| pixel.sums[0].y).sum::<f32>()
        };
        let by_leaf = sum(Some(SunShade::Shadow { shadow: &shadow, frame_from_plant: DAffine3::IDENTITY }));
        let by_cell = sum(Some(SunShade::Crown { towards_sun, sunlit: None }));
        // A cell is a third of a metre wide: what leaves within it take from each other is missing, and directions are mixed from
        // those around that are up to 45 degrees away.
        let (ratio, all) = (by_cell / by_leaf, sum(None) / by_leaf);
        assert!((0.75..1.35).contains(&ratio) && ratio < 0.8 * all, "{towards_sun}: {ratio}, all {all}");
    }
}

#[test]
fn two_lights_are_drawn_as_each_alone_where_nothing_hides_the_plant() {
    let plant = plant_of(Material::default());
    let projection =
        Projection::Parallel { width: 8, height: 8, scale: 3.0, centre_px: DVec2::new(4.0, 4.0) };
    let view = View { projection, view_from_plant: DAffine3::IDENTITY, light_from_view: DMat3::IDENTITY };
    let day = OutdoorLight::day(DVec3::Z);
    let lights = [
        OutdoorLight { sun: Vec3::ZERO, ..day },
        OutdoorLight { sky: Vec3::ZERO, ground: Vec3::ZERO, ..day },
    ];
    let mut hiding = vec![f32::NEG_INFINITY; 64];
    hiding[3 * 8 + 3] = 1.0;
    let drawn = draw_in_lights(&plant, &view, lights, &hiding, None, &Task::silent()).unwrap();
    let picture = draw(&plant, &view, &day, &Task::silent()).unwrap().picture;
    for (at, (pixel, [_, g, _, a])) in drawn.iter().zip(picture.pixels()).enumerate() {
        if at == 3 * 8 + 3 {
            assert_eq!(pixel.covered, 0);
            continue;
        }
        assert_eq!((u32::from(pixel.covered) * 255 + 8) / 16, u32::from(*a));
        // Pictures hold no more than white.
        let sum = ((pixel.sums[0] + pixel.sums[1]).y / f32::from(pixel.covered.max(1))).min(1.0);
        assert!((f64::from(sum) - linear_of_srgb(f64::from(*g) / 255.0)).abs() < 0.01, "{sum} {g}");
    }
}
