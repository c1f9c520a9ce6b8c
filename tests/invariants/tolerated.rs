//! Tolerated overlaps: parts of one object that occlude each other a little are one element, and what is behind in it
//! is textured by no piece.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec2, DVec3};
use quadratura::testing::layers::pieces::pieces_of_nodes;
use quadratura::testing::layers::tolerated::Overlap;
use quadratura::testing::layers::{Faces, LayerConstraints, Options, SoftwareRasteriser, is_behind};
use quadratura::testing::scene::synthetic::{Modeller, Scene, closed_form, random};
use rayon::prelude::*;

use crate::image_layers;
use crate::oracle::{Oracle, each_pixel};
use crate::peeling::check_against_exact_peeling;
use crate::sorted::Case;

fn tolerating(share: f32) -> Options {
    Options { tolerated: share, ..Options::default() }
}

/// A bracket of two sheets: the nearer one hides a strip of the farther one, `overlap` wide, of 3.
fn bracket(overlap: f64) -> Scene {
    let mut m = Modeller::new();
    m.object("bracket").screen(4.0, [-1.5, -1.0, 0.0, 1.0]);
    // The same rays at twice the distance.
    m.object("bracket").screen(8.0, [-2.0 * overlap, -2.0, 3.0, 2.0]);
    Scene { model: m.finish(), ..closed_form::two_quads() }
}

fn elements(scene: &Scene, options: Options) -> usize {
    Case::with(scene, &SoftwareRasteriser, options).sorted.layers.elements.len()
}

#[test]
fn an_object_stays_whole_up_to_the_share_and_falls_apart_above_it() {
    let scene = bracket(0.03);
    // The strip is 2 % of either sheet.
    assert_eq!(elements(&scene, tolerating(0.0)), 2);
    assert_eq!(elements(&scene, tolerating(0.01)), 2);
    assert_eq!(elements(&scene, tolerating(0.05)), 1);
    assert_eq!(elements(&bracket(0.3), tolerating(0.05)), 2);
    let own = [("bracket".to_owned(), 1.0)].map(|(object, share)| {
        (object, quadratura::testing::layers::ObjectOptions { tolerated: Some(share), ..Default::default() })
    });
    assert_eq!(elements(&bracket(0.3), Options { objects: own.into(), ..tolerating(0.0) }), 1);
}

#[test]
fn what_is_between_two_parts_keeps_them_apart_whatever_is_tolerated() {
    let mut m = Modeller::new();
    m.object("bracket").screen(4.0, [-1.5, -1.0, 0.0, 1.0]);
    m.object("pole").screen(6.0, [-0.3, -1.2, 0.3, 1.2]);
    m.object("bracket").screen(8.0, [-0.1, -2.0, 3.0, 2.0]);
    let scene = Scene { model: m.finish(), ..closed_form::two_quads() };
    assert_eq!(elements(&scene, tolerating(1.0)), 3);
}

#[test]
fn what_is_asked_to_tolerate_does_so_without_limit_and_a_split_prevents_it() {
    let scene = bracket(0.9);
    let tolerate =
        LayerConstraints { tolerate: vec![Faces::whole("bracket")], ..LayerConstraints::default() };
    let case = |constraints: &LayerConstraints| {
        Case::wished(&scene, &SoftwareRasteriser, tolerating(0.0), constraints).sorted.layers
    };
    let layers = case(&tolerate);
    assert_eq!((layers.elements.len(), layers.tolerated.len()), (1, 1));
    let face = |index: u32| Faces {
        object: "bracket".into(),
        faces: vec![quadratura::testing::scene::FaceIndex(index)],
    };
    let apart = LayerConstraints { split: vec![vec![vec![face(0)], vec![face(1)]]], ..tolerate };
    assert_eq!(case(&apart).elements.len(), 2);
}

#[test]
fn a_share_of_0_gives_the_same_result_as_before() {
    for seed in 0..30 {
        let scene = random::boxes(seed, 7);
        let [none, all] = [0.0, 1.0].map(|share| Case::with(&scene, &SoftwareRasteriser, tolerating(share)));
        assert!(none.sorted.layers.tolerated.is_empty());
        // What is tolerated unites elements and takes none apart.
        let united: BTreeMap<u32, BTreeSet<u32>> =
            none.sorted.layers.element_of.iter().zip(&all.sorted.layers.element_of).fold(
                BTreeMap::new(),
                |mut map, (part, element)| {
                    map.entry(part.0).or_default().insert(element.0);
                    map
                },
            );
        assert!(united.values().all(|elements| elements.len() == 1), "seed {seed}");
    }
}

#[test]
fn the_invariants_hold_with_tolerated_overlaps_and_what_is_behind_has_no_piece() {
    let united = (0..160_u64).into_par_iter().map(|seed| {
        let share = [0.05, 0.3, 1.0, 1.0][seed as usize % 4];
        let soup = random::soup(8000 + seed, 8 + (seed % 29) as u32);
        let scenes = [soup, random::boxes(8000 + seed, 3 + (seed % 7) as u32)];
        let mut united = 0;
        for scene in scenes {
            let case = Case::with(&scene, &SoftwareRasteriser, tolerating(share));
            Oracle::new(&case).check();
            image_layers::check(&case);
            check_against_exact_peeling(&case, &SoftwareRasteriser);
            pieces_are_in_sight(&scene, &case);
            the_share_is_kept(&scene, &case, share);
            united += case.sorted.layers.tolerated.len();
        }
        united
    });
    let united: usize = united.sum();
    assert!(united > 40, "only {united} overlaps were tolerated: the scenes are no test");
}

/// Where exactly two parts are united, they occlude each other at no more than the share of the smaller one's visible
/// pixels.
fn the_share_is_kept(scene: &Scene, case: &Case, share: f32) {
    let parts = Case::with(scene, &SoftwareRasteriser, tolerating(0.0)).sorted.layers;
    let layers = &case.sorted.layers;
    let visible = Oracle::new(case).visible_of_nodes();
    for (index, element) in layers.elements.iter().enumerate() {
        let part_of = |node: u32| parts.element_of[node as usize];
        let of: BTreeSet<_> = element.nodes.iter().map(|node| part_of(node.0)).collect();
        if of.len() != 2 {
            continue;
        }
        let within = |o: &&Overlap| layers.element_of[o.front as usize].index() == index;
        let overlap: u32 = layers.tolerated.iter().filter(within).map(|o| o.px).sum();
        let visible = |part| {
            let nodes = element.nodes.iter().filter(|node| part_of(node.0) == part);
            nodes.map(|node| visible[node.0 as usize]).sum::<u32>()
        };
        let smaller = of.into_iter().map(visible).min().unwrap();
        assert!(
            f64::from(overlap) <= f64::from(share) * f64::from(smaller.max(1)) + 1e-6,
            "{}: {overlap} px of {smaller}",
            case.name
        );
    }
}

/// The pieces of a node hold those of its pixels that are not behind its own element, and no others. Pixels whose
/// neighbours differ are left out: outlines pass there.
fn pieces_are_in_sight(scene: &Scene, case: &Case) {
    let Case { sorted, model, .. } = case;
    let pieces = pieces_of_nodes(model, &sorted.view, &sorted.nodes, &sorted.layers.tolerated, &scene.pose);
    let backs: BTreeSet<u32> = sorted.layers.tolerated.iter().map(|overlap| overlap.back).collect();
    let oracle = Oracle::new(case);
    let at: BTreeMap<(u32, u32), Vec<(u32, f32)>> = each_pixel(&case.fragments.lists)
        .zip(oracle.nodes_by_pixel())
        .map(|((x, y, _), nodes)| ((x, y), nodes))
        .collect();
    let state = |back: u32, x: u32, y: u32| -> Option<bool> {
        let nodes = at.get(&(x, y))?;
        let depth = nodes.iter().find(|(node, _)| *node == back)?.1;
        let fronts = sorted.layers.tolerated.iter().filter(|overlap| overlap.back == back);
        let fronts: BTreeSet<u32> = fronts.map(|overlap| overlap.front).collect();
        let nearer = |(node, of): &(u32, f32)| fronts.contains(node) && *of > depth;
        let behind =
            |(node, of): &(u32, f32)| fronts.contains(node) && is_behind(depth, *of, case.options.tolerance);
        let any_behind = nodes.iter().any(behind);
        // Between the two, depths are too close to tell.
        (any_behind || !nodes.iter().any(nearer)).then_some(!any_behind)
    };
    for back in backs {
        let Some(of_node) = &pieces[back as usize] else { panic!("{}: {back} has no pieces", case.name) };
        let face = &sorted.view.items[sorted.nodes.list[back as usize].item as usize];
        if face.triangle.is_some() {
            continue;
        }
        let plane = model.face(face.face).plane;
        for &(x, y) in at.keys() {
            let Some(in_sight) = state(back, x, y) else { continue };
            let near = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
            let same = |(dx, dy): (i32, i32)| {
                let [x, y] = [x as i32 + dx, y as i32 + dy];
                x >= 0 && y >= 0 && state(back, x as u32, y as u32) == Some(in_sight)
            };
            if !near.into_iter().all(same) {
                continue;
            }
            let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let eye = scene.pose.center_in_world();
            let ray = scene.pose.rotation.transpose() * scene.camera.ray_in_camera(px);
            let point = eye - ray * (plane.signed_distance(eye) / plane.normal.dot(ray));
            let held = of_node.rings.iter().any(|ring| holds(ring, point, plane.normal));
            assert_eq!(held, in_sight, "{}: node {back} at {x}, {y}", case.name);
        }
    }
}

/// Whether a point of its plane is within a ring.
fn holds(ring: &[DVec3], point: DVec3, normal: DVec3) -> bool {
    let away = normal.abs();
    let flat = |p: DVec3| match away.max_element() {
        most if most == away.x => DVec2::new(p.y, p.z),
        most if most == away.y => DVec2::new(p.x, p.z),
        _ => DVec2::new(p.x, p.y),
    };
    let p = flat(point);
    let crossed = |i: &usize| {
        let (a, b) = (flat(ring[*i]), flat(ring[(*i + 1) % ring.len()]));
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    (0..ring.len()).filter(crossed).count() % 2 == 1
}
