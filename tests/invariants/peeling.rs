//! Peeling: the exact kind gives the same layers as the graph, the published kind does not.

use quadratura::task::Task;
use quadratura::testing::layers::cycles::Resolved;
use quadratura::testing::layers::rasteriser::{Rasteriser, StencilLayers};
use quadratura::testing::layers::{Method, Occlusion, Options, SoftwareRasteriser};
use quadratura::testing::scene::synthetic::{closed_form, random};
use rayon::prelude::*;

use crate::oracle::Oracle;
use crate::random_scenes;
use crate::sorted::Case;

/// The layer of every working item by rounds of [`Rasteriser::occluded`].
fn peel(case: &Case, resolved: &Resolved, rasteriser: &dyn Rasteriser) -> Vec<Option<u32>> {
    let item_of = |node: u32| resolved.nodes.list[node as usize].item;
    let mut forgiven: Vec<(u32, u32)> =
        resolved.kept.refused.iter().map(|r| (item_of(r.0), item_of(r.1))).collect();
    forgiven.sort_unstable();
    let mut alive = case.working();
    let mut layer = vec![None; alive.len()];
    for round in 0.. {
        if !alive.contains(&true) {
            break;
        }
        let hidden = rasteriser
            .occluded(&case.sorted.view, case.options.tolerance, &alive, &forgiven)
            .expect("the rasteriser works");
        let free: Vec<usize> = (0..alive.len()).filter(|&i| alive[i] && !hidden[i]).collect();
        assert!(!free.is_empty(), "{}: exact peeling found a cycle", case.name);
        for item in free {
            (layer[item], alive[item]) = (Some(round), false);
        }
    }
    layer
}

/// Exact peeling of faces gives the layers of the graph, and that of elements the layers of the
/// result.
pub fn check_against_exact_peeling(case: &Case, rasteriser: &dyn Rasteriser) {
    let layers: Vec<u32> = case.sorted.layers.elements.iter().map(|e| e.visibility_layer).collect();
    assert_eq!(Oracle::new(case).peeled(), layers, "{}", case.name);
    // A rasteriser draws items, it knows no pieces.
    if case.sorted.cuts == 0 {
        let resolved = case.resolved();
        let mut expected = vec![None; case.sorted.view.items.len()];
        let longest = resolved.kept.graph.longest_paths();
        for (node, layer) in resolved.nodes.list.iter().zip(longest) {
            expected[node.item as usize] = Some(layer);
        }
        assert_eq!(peel(case, &resolved, rasteriser), expected, "{}", case.name);
    }
}

fn stencil(case: &Case) -> StencilLayers {
    SoftwareRasteriser
        .stencil_peeling(&case.sorted.view, case.options.tolerance, &case.working(), &Task::silent())
        .expect("nobody stops it")
}

#[test]
fn exact_peeling_gives_the_same_layers() {
    let mut scenes = closed_form::all();
    scenes.extend(random_scenes());
    scenes.par_iter().for_each(|scene| {
        check_against_exact_peeling(&Case::new(scene, &SoftwareRasteriser), &SoftwareRasteriser);
    });
}

#[test]
fn stencil_peeling_parts_from_exact_peeling_in_its_trap() {
    let options = Options { method: Method::Stencil, ..Options::default() };
    let case = Case::with(&closed_form::stencil_trap(), &SoftwareRasteriser, options);
    // Objects a, y, x, z in model order: x stands in the first layer, before y, which hides it.
    assert_eq!(stencil(&case).layer, [Some(0), Some(1), Some(0), Some(2)]);
    let layers = &case.sorted.layers;
    assert_eq!(layers.against.len(), 1, "one pair is told to contradict the order");
    let (front, back, px) = layers.against[0];
    let name = |element: u32| &case.model.object(layers.elements[element as usize].object).name;
    assert_eq!((name(front).as_str(), name(back).as_str()), ("y", "x"));
    let y_before_x = case.fragments.occlusions.iter().find(|o| (o.front, o.back) == (1, 2));
    assert_eq!(px, y_before_x.expect("y hides x").px);
}

#[test]
fn within_a_layer_of_stencil_peeling_nothing_hides_anything() {
    (0..100_u64).into_par_iter().for_each(|seed| {
        let case = Case::new(&random::soup(seed, 20), &SoftwareRasteriser);
        let peeled = stencil(&case);
        let last = peeled.layer.iter().flatten().max();
        for pair in &case.fragments.occlusions {
            let [front, back] = [pair.front, pair.back].map(|item| peeled.layer[item as usize]);
            let locked = peeled.locked > 0 && front.as_ref() == last;
            assert!(front != back || locked, "{}: {pair:?}", case.name);
        }
    });
}

#[test]
fn stencil_peeling_breaks_the_order_of_scenes_that_have_one() {
    let contradicts = |seed: u64| {
        let case = Case::new(&random::boxes(seed, 8), &SoftwareRasteriser);
        let layer = stencil(&case).layer;
        let wrong = |pair: &Occlusion| layer[pair.front as usize] >= layer[pair.back as usize];
        let has_an_order = case.sorted.cuts == 0 && case.resolved().kept.refused.is_empty();
        has_an_order && case.fragments.occlusions.iter().any(wrong)
    };
    let broken = (0..100_u64).into_par_iter().filter(|&seed| contradicts(seed)).count();
    assert!(broken > 0, "the baseline has become better than its paper says");
}
