//! Rasterisation against ray casting: another way to the same pixels, in f64 from end to end.

use glam::{DVec2, DVec3, dvec2};
use quadratura::testing::geometry::InverseDepth;
use quadratura::testing::layers::rasteriser::{Presence, VISIBLE};
use quadratura::testing::layers::{Item, SoftwareRasteriser};
use quadratura::testing::scene::synthetic::{Scene, closed_form, random};
use rayon::prelude::*;

use crate::oracle::each_pixel;
use crate::sorted::Case;

/// Rays go through points so far from a pixel's centre (in pixels); where they disagree about a
/// face, its outline passes the centre and either answer is right.
const AROUND: f64 = 0.01;
/// Roundings of f32 on the way to a depth, each of half a unit in the last place.
const ROUNDINGS: f64 = 8.0;

/// What is hidden everywhere lies behind by so much at least, relative: the tie of the working set
/// less the rounding of two depths.
const HIDDEN: f64 = 1e-6;

/// The depth at which the ray through an image point meets a triangle given in the camera's frame.
fn depth_of_hit(scene: &Scene, [a, b, c]: [DVec3; 3], point_px: DVec2) -> Option<f64> {
    let ray = scene.camera.ray_in_camera(point_px);
    let volumes = [ray.dot(b.cross(c)), ray.dot(c.cross(a)), ray.dot(a.cross(b))];
    let one_side = volumes.iter().all(|v| *v > 0.0) || volumes.iter().all(|v| *v < 0.0);
    let depth = a.dot((b - a).cross(c - a)) / ray.dot((b - a).cross(c - a));
    (one_side && depth > 0.0).then_some(depth)
}

/// The triangles of an item in the camera's frame.
fn triangles(scene: &Scene, item: &Item) -> Vec<[DVec3; 3]> {
    let in_camera = |v: u32| scene.pose.camera_from_world(scene.model.vertices[v as usize]);
    let all = scene.model.face_triangles(item.face).iter().map(|t| t.map(in_camera));
    match item.triangle {
        None => all.collect(),
        Some(only) => all.skip(only as usize).take(1).collect(),
    }
}

/// `Some(depth)` where the item surely covers the pixel centre, `Some(None)` where it surely does
/// not, `None` where its outline passes.
fn cast(scene: &Scene, triangles: &[[DVec3; 3]], x: u32, y: u32) -> Option<Option<f64>> {
    let centre = dvec2(f64::from(x) + 0.5, f64::from(y) + 0.5);
    let hit = |at: DVec2| triangles.iter().find_map(|&t| depth_of_hit(scene, t, at));
    let around = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let hits = around.map(|(dx, dy)| hit(centre + AROUND * dvec2(dx, dy)).is_some());
    match hits {
        // A hole in a triangulation may be hit; between neighbours the centre itself may be.
        [true, true, true, true] => hit(centre).map(Some),
        [false, false, false, false] => Some(None),
        _ => None,
    }
}

/// How far rounding may take an inverse depth: its terms may be large and cancel, which they do
/// where a face is seen almost edge-on.
fn rounding(plane: &InverseDepth, x: u32, y: u32) -> f64 {
    let InverseDepth { a, b, c, u0, v0 } = *plane;
    let terms = [a * (x as f32 + 0.5 - u0), b * (y as f32 + 0.5 - v0), c];
    let largest: f32 = terms.iter().map(|term| term.abs()).sum();
    ROUNDINGS * 0.5 * f64::from(f32::EPSILON) * f64::from(largest)
}

fn compare(scene: &Scene) {
    let Case { sorted, fragments, .. } = Case::new(scene, &SoftwareRasteriser);
    let items: Vec<_> = sorted.view.items.iter().map(|item| triangles(scene, item)).collect();
    for (x, y, entries) in each_pixel(&fragments.lists) {
        for (index, item) in items.iter().enumerate() {
            let Some(expected) = cast(scene, item, x, y) else { continue };
            let drawn = entries.iter().any(|entry| (entry & !VISIBLE) as usize == index);
            let place = || format!("{}: item {index} at {x}, {y}", scene.name);
            match expected {
                None => assert!(!drawn, "{} is not there", place()),
                Some(_) if sorted.presence[index] != Presence::Working => {}
                Some(depth) => {
                    assert!(drawn, "{} is missing", place());
                    let plane = &sorted.view.items[index].inverse_depth;
                    let (found, expected) = (f64::from(plane.at(x, y)), 1.0 / depth);
                    let close = (found - expected).abs() <= rounding(plane, x, y);
                    assert!(close, "{}: {found} is not {expected}", place());
                }
            }
        }
    }
}

#[test]
fn fragments_and_their_depths_are_those_of_ray_casting() {
    let scenes: Vec<Scene> = closed_form::all()
        .into_iter()
        .chain((0..24).map(|seed| random::soup(1000 + seed, 12)))
        .chain((0..12).map(|seed| random::boxes(1000 + seed, 3)))
        .collect();
    scenes.par_iter().for_each(compare);
}

#[test]
fn a_face_outside_the_working_set_is_hidden_wherever_a_ray_meets_it() {
    for seed in 0..20 {
        let scene = random::boxes(2000 + seed, 4);
        let Case { sorted, .. } = Case::new(&scene, &SoftwareRasteriser);
        let items: Vec<_> = sorted.view.items.iter().map(|item| triangles(&scene, item)).collect();
        for (index, presence) in sorted.presence.iter().enumerate() {
            let Presence::Hidden { x, y, by } = *presence else { continue };
            let (own, front) = (cast(&scene, &items[index], x, y), cast(&scene, &items[by as usize], x, y));
            if let (Some(own), Some(front)) = (own, front) {
                let (own, front) = (own.expect("it covers this pixel"), front.expect("so does its occluder"));
                assert!(front * (1.0 + HIDDEN) < own, "{}: item {index} at {x}, {y}", scene.name);
            }
        }
    }
}
