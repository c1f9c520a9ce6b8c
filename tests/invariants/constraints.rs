//! What was asked of image layers is done wherever the method allows, whatever was asked, and the
//! invariants hold all the same.

use quadratura::testing::layers::together::{Obstacle, Unsatisfied};
use quadratura::testing::layers::{BoxShape, Faces, LayerConstraints, Method, Options, SoftwareRasteriser};
use quadratura::testing::scene::synthetic::{Rng, Scene, closed_form, random};
use quadratura::testing::scene::{FaceIndex, Model};
use rayon::prelude::*;

use crate::image_layers;
use crate::oracle::Oracle;
use crate::sorted::Case;

/// Some faces of some object, or all of them.
fn some_faces(model: &Model, rng: &mut Rng) -> Faces {
    let object = &model.objects[rng.whole(0, model.objects.len() as u32 - 1) as usize];
    let mut faces: Vec<FaceIndex> =
        (0..object.faces.len() as u32).map(FaceIndex).filter(|_| rng.chance(0.4)).collect();
    if rng.chance(0.5) {
        faces.clear();
    }
    Faces { object: object.name.clone(), faces }
}

fn some_constraints(model: &Model, seed: u64) -> LayerConstraints {
    let mut rng = Rng::new(seed);
    let list = |rng: &mut Rng| (0..rng.whole(1, 3)).map(|_| some_faces(model, rng)).collect::<Vec<_>>();
    let merge = (0..rng.whole(0, 4)).map(|_| list(&mut rng)).collect();
    let split =
        (0..rng.whole(0, 2)).map(|_| (0..rng.whole(1, 2)).map(|_| list(&mut rng)).collect()).collect();
    let keep = list(&mut rng);
    let tolerate = if rng.chance(0.3) { list(&mut rng) } else { Vec::new() };
    LayerConstraints { merge, split, keep, tolerate }
}

/// The faces of an element, with their object's name.
fn faces_of(case: &Case, element: u32) -> Vec<(String, FaceIndex)> {
    let nodes = &case.sorted.layers.elements[element as usize].nodes;
    let face = |node: u32| {
        let item = case.sorted.nodes.list[node as usize].item;
        let face = case.model.face(case.sorted.view.items[item as usize].face);
        (case.model.object(face.object).name.clone(), face.index)
    };
    nodes.iter().map(|node| face(node.0)).collect()
}

fn holds(list: &[Faces], faces: &[(String, FaceIndex)]) -> bool {
    faces.iter().any(|(object, face)| list.iter().any(|named| named.holds(object, *face)))
}

fn cluster_of(case: &Case, element: u32) -> usize {
    let clusters = case.sorted.clusters.list.iter();
    let holding = |(_, c): &(usize, &quadratura::testing::layers::cluster::Cluster)| {
        c.patches.iter().any(|p| p.element.0 == element)
    };
    clusters.enumerate().find(holding).expect("every element has an image layer").0
}

/// The elements of a merge that were not left out of it, for each.
fn merged(case: &Case, constraints: &LayerConstraints) -> Vec<Vec<u32>> {
    let elements = 0..case.sorted.layers.elements.len() as u32;
    let left_out = |merge: usize, element: u32| {
        case.sorted.clusters.unsatisfied.iter().any(|u| u.merge as usize == merge && u.item == element)
    };
    let of_merge = |(number, merge): (usize, &Vec<Faces>)| {
        let asked = elements.clone().filter(|e| holds(merge, &faces_of(case, *e)));
        asked.filter(|e| !left_out(number, *e)).collect()
    };
    constraints.merge.iter().enumerate().map(of_merge).collect()
}

fn check(scene: &Scene, options: Options, constraints: &LayerConstraints) {
    let case = Case::wished(scene, &SoftwareRasteriser, options, constraints);
    if case.options.method == Method::Graph {
        Oracle::new(&case).check();
    }
    image_layers::check(&case);
    let named =
        |object: &str, face| constraints.merge.iter().flatten().any(|faces| faces.holds(object, face));
    let kept = |object: &str, face| constraints.keep.iter().any(|faces| faces.holds(object, face));
    Oracle::new(&case).leftovers(|object, face| named(object, face) || kept(object, face));
    for together in merged(&case, constraints) {
        let places: Vec<usize> = together.iter().map(|element| cluster_of(&case, *element)).collect();
        assert!(places.iter().all(|place| *place == places[0]), "{}: {constraints:?}: {places:?}", case.name);
    }
    splits_are_kept(&case, constraints);
    what_was_left_out_had_to_be(&case, constraints);
}

/// By the names of faces, one pair after the other.
fn splits_are_kept(case: &Case, constraints: &LayerConstraints) {
    for cluster in &case.sorted.clusters.list {
        let faces: Vec<_> = cluster.patches.iter().flat_map(|p| faces_of(case, p.element.0)).collect();
        for split in &constraints.split {
            let groups = |face: &(String, FaceIndex)| {
                split.iter().position(|group| holds(group, std::slice::from_ref(face)))
            };
            let found: Vec<Option<usize>> = faces.iter().map(groups).collect();
            let mut named = found.iter().flatten();
            let first = named.next();
            // A random split may name a face in two groups; the last one counts.
            let doubtful = overlapping(split);
            assert!(doubtful || named.all(|group| Some(group) == first), "{}: {split:?}", case.name);
            let alone = split.len() == 1 && first.is_some();
            assert!(!alone || found.iter().all(Option::is_some), "{}: {split:?} has company", case.name);
        }
    }
}

fn overlapping(split: &[Vec<Faces>]) -> bool {
    let [a, b] = split else { return false };
    a.iter().any(|a| b.iter().any(|b| a.object == b.object))
}

/// With all merges that were made contracted, a path of occlusions still ties what was left out to what it
/// should have joined, or it is too large, or a split or a forgiven pair lies between.
fn what_was_left_out_had_to_be(case: &Case, constraints: &LayerConstraints) {
    let count = case.sorted.layers.elements.len();
    let mut group: Vec<usize> = (0..count).collect();
    for together in merged(case, constraints) {
        for pair in together.windows(2) {
            let (old, new) = (group[pair[1] as usize], group[pair[0] as usize]);
            group.iter_mut().filter(|g| **g == old).for_each(|g| *g = new);
        }
    }
    let edges: Vec<(usize, usize)> = case
        .sorted
        .layers
        .occlusions
        .edges
        .iter()
        .map(|e| (group[e.0 as usize], group[e.1 as usize]))
        .collect();
    let leads = |from: usize, to: usize| {
        let mut reached = vec![false; count];
        let mut open = vec![from];
        while let Some(at) = open.pop() {
            for &(_, next) in edges.iter().filter(|(front, _)| *front == at) {
                if !std::mem::replace(&mut reached[next], true) {
                    open.push(next);
                }
            }
        }
        reached[to]
    };
    for Unsatisfied { item, with, why, .. } in case.sorted.clusters.unsatisfied.iter().copied() {
        let (item, with) = (group[item as usize], group[with as usize]);
        if why == Obstacle::Occluded {
            assert!(
                leads(item, with) || leads(with, item),
                "{}: {constraints:?}: left out without need",
                case.name
            );
        }
    }
}

#[test]
fn whatever_is_asked_the_invariants_hold_and_what_is_possible_is_done() {
    (0..240_u64).into_par_iter().for_each(|seed| {
        let scenes = [
            random::soup(5000 + seed, 4 + (seed % 29) as u32),
            random::boxes(5000 + seed, 2 + (seed % 8) as u32),
        ];
        for scene in scenes {
            check(&scene, Options::default(), &some_constraints(&scene.model, seed));
        }
    });
}

#[test]
fn so_it_is_with_every_option() {
    let default = Options::default;
    let options = [
        Options { boxes: BoxShape::Exact, margin: 0, ..default() },
        Options { largest_side: 64, ..default() },
        Options { method: Method::Stencil, ..default() },
        Options { min_visible: 400, min_share: 0.3, ..default() },
        Options { min_visible: u32::MAX, min_share: 1.0, ..default() },
        Options { tolerated: 0.1, ..default() },
    ];
    (0..40_u64).into_par_iter().for_each(|seed| {
        let scene = random::boxes(6000 + seed, 6);
        for options in &options {
            check(&scene, options.clone(), &some_constraints(&scene.model, seed));
        }
    });
}

#[test]
fn scenes_with_a_known_answer_take_wishes_too() {
    for (scene, seed) in closed_form::all().iter().zip(0..) {
        check(scene, Options::default(), &some_constraints(&scene.model, seed));
    }
}

#[test]
fn without_a_wish_nothing_changes_and_the_order_of_faces_in_one_does_not_matter() {
    for seed in 0..20 {
        let scene = random::boxes(7000 + seed, 6);
        let case = |constraints: &LayerConstraints| {
            Case::wished(&scene, &SoftwareRasteriser, Options::default(), constraints)
        };
        let plain = case(&LayerConstraints::default());
        assert!(plain == Case::new(&scene, &SoftwareRasteriser));
        let constraints = some_constraints(&scene.model, seed);
        let mut turned = constraints.clone();
        turned.merge.iter_mut().for_each(|merge| merge.reverse());
        assert!(case(&constraints) == case(&turned));
    }
}

/// A pane, one behind it, and one beside them.
fn panes() -> Scene {
    let mut m = quadratura::testing::scene::synthetic::Modeller::new();
    m.object("front").screen(3.0, [-0.5, -0.5, 0.5, 0.5]);
    m.object("back").screen(5.0, [-1.0, -0.8, 0.8, 0.8]);
    m.object("beside").screen(4.0, [1.2, -0.5, 1.7, 0.5]);
    Scene { model: m.finish(), ..closed_form::two_quads() }
}

#[test]
fn panes_beside_each_other_merge_and_panes_behind_each_other_are_refused_with_the_reason() {
    let merge = |names: &[&str]| LayerConstraints {
        merge: vec![names.iter().map(|n| Faces::whole(*n)).collect()],
        ..LayerConstraints::default()
    };
    let case = |constraints: &LayerConstraints| {
        Case::wished(&panes(), &SoftwareRasteriser, Options::default(), constraints)
    };
    let plain = case(&LayerConstraints::default());
    assert_eq!(plain.sorted.clusters.list.len(), 3);
    let merged = case(&merge(&["front", "beside"]));
    assert_eq!(merged.sorted.clusters.list.len(), 2);
    assert!(merged.sorted.clusters.unsatisfied.is_empty());
    let refused = case(&merge(&["back", "front"]));
    assert_eq!(refused.sorted.clusters.list, plain.sorted.clusters.list);
    assert_eq!(refused.sorted.clusters.unsatisfied[0].why, Obstacle::Occluded);
}
