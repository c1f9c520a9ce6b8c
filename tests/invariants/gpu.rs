//! The same invariants where the GPU draws: its coverage differs at edges, so its results are judged
//! by their own fragments and not compared with those of the twin.

use quadratura::testing::layers::Rasteriser;
use quadratura::testing::scene::synthetic::{Scene, closed_form, random};
use rayon::prelude::*;

use crate::oracle::Oracle;
use crate::peeling::check_against_exact_peeling;
use crate::sorted::Case;
use crate::{common, image_layers, sorted};

fn check(scene: &Scene, rasteriser: &dyn Rasteriser) {
    let case = Case::new(scene, rasteriser);
    case.check_truth(&scene.truth);
    Oracle::new(&case).check();
    image_layers::check(&case);
    check_against_exact_peeling(&case, rasteriser);
}

#[test]
fn the_invariants_hold_on_the_gpu() {
    let Some(rasteriser) = common::gpu_rasteriser() else { return };
    let mut scenes = closed_form::all();
    scenes.extend((0..80).map(|seed| random::soup(5000 + seed, 4 + (seed % 37) as u32)));
    scenes.extend((0..40).map(|seed| random::boxes(5000 + seed, 2 + (seed % 9) as u32)));
    scenes.par_iter().for_each(|scene| check(scene, &rasteriser));
}

#[test]
fn any_number_of_threads_gives_the_same_result_on_the_gpu() {
    let Some(rasteriser) = common::gpu_rasteriser() else { return };
    let scenes = [random::soup(5, 40), random::boxes(5, 9), closed_form::crossing_boxes()];
    let result = |scene: &Scene| Case::new(scene, &rasteriser).sorted;
    let results = [1, 2, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads can be made").install(|| scenes.par_iter().map(result).collect::<Vec<_>>())
    });
    assert!(results[0] == results[1] && results[0] == results[2]);
}

#[test]
fn closed_form_scenes_have_the_same_layers_on_the_gpu_and_on_its_twin() {
    let Some(rasteriser) = common::gpu_rasteriser() else { return };
    for scene in closed_form::all() {
        let (drawn, plain) = (Case::new(&scene, &rasteriser).sorted, sorted(&scene).sorted);
        assert_eq!(drawn.nodes, plain.nodes, "{}", scene.name);
        assert_eq!(drawn.layers.elements, plain.layers.elements, "{}", scene.name);
        let orders = |s: &quadratura::testing::layers::Sorted| -> Vec<u32> {
            s.clusters.list.iter().map(|cluster| cluster.order).collect()
        };
        assert_eq!(orders(&drawn), orders(&plain), "{}", scene.name);
    }
}
