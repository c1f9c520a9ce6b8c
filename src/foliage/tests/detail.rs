//! Levels of detail of polygons.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};

use super::draft;
use super::layered::{branch, from};
use crate::layered::{LayeredOptions, draw_layered};
use crate::mesh::Mesh;
use crate::primitive::{Limb, Shape};
use crate::walk::WalkOptions;
use crate::{
    CurvePoint, Directions, Material, OutdoorLight, Plant, PlantImages, Primitive, assemble, similarity,
};
use quadratura_base::geometry::bvh::Bvh;
use quadratura_base::scene::synthetic::Rng;
use quadratura_base::task::Task;

/// The points of a limb of two pieces that bends and becomes thinner.
fn bent(rng: &mut Rng) -> Vec<CurvePoint> {
    let mut point = CurvePoint { position: DVec3::ZERO, radius: rng.between(0.1, 0.4) };
    let mut next = || {
        let last = point;
        point.position += DVec3::new(rng.between(-0.3, 0.3), rng.between(-0.3, 0.3), rng.between(0.4, 0.8));
        point.radius *= rng.between(0.7, 1.0);
        last
    };
    (0..7).map(|_| next()).collect()
}

/// A plant of one limb of 16 sides, anyhow turned and stretched.
fn limb_of(segments: u32, points: Vec<CurvePoint>, rng: &mut Rng) -> Plant {
    let scale = DVec3::new(rng.between(0.5, 2.0), 1.0, rng.between(0.5, 2.0));
    let turn = DQuat::from_rotation_x(rng.between(0.0, 6.0));
    let object_from_limb = DAffine3::from_scale_rotation_translation(scale, turn, DVec3::X);
    let limb = Limb { points, sides: 16, segments, object_from_limb };
    let primitive = Primitive { shape: Shape::Limb(limb), material: Arc::new(Material::default()) };
    assemble(vec![draft("limb", vec![primitive], &[])], 0, DVec3::Z, 1.0).unwrap()
}

/// Returns how far points of one mesh, corners and the middles of triangles, are from another at most.
fn farthest(of: &Mesh, from: &Mesh) -> f64 {
    let triangles = |mesh: &Mesh| -> Vec<[DVec3; 3]> {
        let corners = |triangle: &[u32; 3]| triangle.map(|index| mesh.corners[index as usize].position);
        mesh.triangles.iter().map(corners).collect()
    };
    let surface = Bvh::new(triangles(from));
    let middles = triangles(of).into_iter().map(|corners| corners.iter().sum::<DVec3>() / 3.0);
    let points = of.corners.iter().map(|corner| corner.position).chain(middles);
    let apart = |point: DVec3| surface.nearest(point).unwrap().1.distance(point);
    points.map(apart).fold(0.0, f64::max)
}

#[test]
fn coarser_limbs_are_no_farther_from_full_detail_than_their_level_says() {
    let mut rng = Rng::new(81);
    let mut counts = Vec::new();
    for segments in [1, 3, 5, 7, 13, 24].repeat(5) {
        let plant = limb_of(segments, bent(&mut rng), &mut rng);
        let detail = &plant.objects[0].detail;
        let given = &Mesh::of(&plant.objects[0])[0];
        let mut polygons = given.triangles.len();
        for level in 1..detail.count() {
            let deviation = detail.deviation(level);
            let coarser = &Mesh::of_level(&plant.objects[0], level)[0];
            assert_eq!((detail.level(deviation), detail.level(0.99 * deviation)), (level, level - 1));
            let apart = farthest(coarser, given).max(farthest(given, coarser));
            assert!(apart <= deviation, "level {level}: {apart} is more than {deviation}");
            assert!(coarser.triangles.len() as f64 <= 0.75 * polygons as f64);
            polygons = coarser.triangles.len();
        }
        counts.push((segments, detail.count(), polygons));
    }
    // Three sides, and a few segments where there were many.
    let is_coarse = |(segments, levels, polygons): &(u32, usize, usize)| {
        *levels > 1 && *polygons <= 2 * 3 * (*segments).min(6) as usize
    };
    assert!(counts.iter().all(is_coarse), "{counts:?}");
}

#[test]
fn a_limb_with_a_sharp_joint_keeps_it() {
    // Two straight pieces at a right angle, whose middle no smaller number of segments than an even one has.
    let ends = [DVec3::ZERO, DVec3::new(0.0, 0.0, 3.0), DVec3::new(3.0, 0.0, 3.0)];
    let on = |from: usize, share: f64| CurvePoint {
        position: ends[from].lerp(ends[from + 1], share),
        radius: 0.1,
    };
    let thirds = [0.0, 1.0 / 3.0, 2.0 / 3.0];
    let points: Vec<_> = thirds
        .map(|share| on(0, share))
        .into_iter()
        .chain(thirds.map(|share| on(1, share)))
        .chain([on(1, 1.0)])
        .collect();
    for segments in [2, 3, 4, 5, 7, 11, 12, 13] {
        let plant = limb_of(segments, points.clone(), &mut Rng::new(5));
        let object = &plant.objects[0];
        let given = &Mesh::of(object)[0];
        for level in 1..object.detail.count() {
            let coarser = &Mesh::of_level(object, level)[0];
            let apart = farthest(coarser, given).max(farthest(given, coarser));
            assert!(apart <= object.detail.deviation(level), "{segments} segments, level {level}: {apart}");
        }
    }
}

#[test]
fn coarser_limbs_look_as_wide() {
    // A straight limb far from its ends, from all around: the coarsest level has three sides.
    let point = |z: f64| CurvePoint { position: DVec3::new(0.0, 0.0, z), radius: 1.0 };
    let limb = Limb {
        points: (0..4).map(|i| point(f64::from(i))).collect(),
        sides: 24,
        segments: 4,
        object_from_limb: DAffine3::IDENTITY,
    };
    let primitive = Primitive { shape: Shape::Limb(limb), material: Arc::new(Material::default()) };
    let plant = assemble(vec![draft("limb", vec![primitive], &[])], 0, DVec3::Z, 1.0).unwrap();
    let width = |level: usize| {
        let mesh = &Mesh::of_level(&plant.objects[0], level)[0];
        let across = |turn: f64| {
            let along = mesh
                .corners
                .iter()
                .map(|corner| corner.position.dot(DVec3::new(turn.cos(), turn.sin(), 0.0)));
            let (low, high) = along.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
            high - low
        };
        (0..360).map(|degree| across(f64::from(degree).to_radians())).sum::<f64>() / 360.0
    };
    let coarsest = plant.objects[0].detail.count() - 1;
    assert_eq!(Mesh::of_level(&plant.objects[0], coarsest)[0].triangles.len(), 6);
    for level in 1..=coarsest {
        // 360 directions: the mean over a triangle's is known to a thousandth.
        assert!((width(level) / width(0) - 1.0).abs() < 1e-3, "level {level}: {} {}", width(level), width(0));
    }
}

#[test]
fn near_by_a_branch_looks_the_same_with_half_of_its_triangles() {
    let plant = branch();
    // Without images everything is drawn as polygons.
    let images = PlantImages {
        directions: Directions::Around,
        from_parts: false,
        objects: vec![None; plant.objects.len()],
    };
    for towards in [DVec3::new(1.0, 0.2, 0.1), DVec3::new(-0.3, 1.0, -0.5)] {
        let view = from(&plant, towards, 150);
        let draw = |threshold: f64| {
            let options = LayeredOptions { walk: WalkOptions { threshold }, ..LayeredOptions::FINAL };
            let light = OutdoorLight::day(plant.up);
            draw_layered(&plant, &images, &view, &light, &options, &Task::silent()).unwrap()
        };
        // A threshold near 0 asks for full detail.
        let (all, of_all) = draw(1e-9);
        let (less, of_less) = draw(WalkOptions::FINAL.threshold);
        let found = similarity(&all, &less).unwrap();
        // 0.08 pixels are a third of a sub-pixel: some sub-pixels along outlines of limbs change.
        assert!(found.ssim > 0.99 && (found.coverage - 1.0).abs() < 0.005, "{found:?}");
        assert!(2 * of_less.triangles < of_all.triangles, "{of_less:?} {of_all:?}");
    }
}
