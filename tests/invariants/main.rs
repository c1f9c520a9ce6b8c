//! What every result of the visibility sort must be, on scenes whose answer is known, on hundreds
//! of random ones, and on the castle.

#[path = "../common/mod.rs"]
mod common;
mod constraints;
mod gpu;
mod gpu_twin;
mod image_layers;
mod oracle;
mod peeling;
mod rays;
mod sites;
mod sorted;
mod tolerated;

use oracle::Oracle;
use quadratura::testing::layers::{Options, SoftwareRasteriser, count_pairs};
use quadratura::testing::scene::synthetic::{Scene, closed_form, large, random};
use rayon::prelude::*;
use sorted::Case;

/// Hundreds of scenes that nobody thought of.
fn random_scenes() -> Vec<Scene> {
    let soups = (0..240).map(|seed| random::soup(seed, 4 + (seed % 37) as u32));
    let boxes = (0..120).map(|seed| random::boxes(seed, 2 + (seed % 9) as u32));
    soups.chain(boxes).collect()
}

fn sorted(scene: &Scene) -> Case {
    Case::new(scene, &SoftwareRasteriser)
}

#[test]
fn scenes_with_a_known_answer_get_it() {
    for scene in closed_form::all() {
        let case = sorted(&scene);
        case.check_truth(&scene.truth);
        Oracle::new(&case).check();
    }
}

#[test]
fn every_result_is_a_partition_in_front_order_and_as_early_as_can_be() {
    random_scenes().par_iter().for_each(|scene| Oracle::new(&sorted(scene)).check());
}

#[test]
fn the_invariants_hold_for_any_tolerance_and_any_support() {
    let options = [(1e-5, 0), (1e-4, 3), (1e-3, 40), (1e-2, 400)].map(|(tolerance, min_support)| Options {
        tolerance,
        min_support,
        ..Options::default()
    });
    (0..60_u64).into_par_iter().for_each(|seed| {
        let scenes = [random::soup(3000 + seed, 24), random::boxes(3000 + seed, 7)];
        for (scene, options) in scenes.iter().zip(options.iter().cycle().skip(seed as usize % 4)) {
            Oracle::new(&Case::with(scene, &SoftwareRasteriser, options.clone())).check();
        }
    });
}

#[test]
fn a_street_of_many_layers_holds_the_invariants() {
    let street = sorted(&large::street(400).resized(240));
    Oracle::new(&street).check();
    assert!(street.sorted.layers.count() > 10, "{} layers", street.sorted.layers.count());
}

#[test]
fn the_table_of_occlusions_is_that_of_the_fragment_lists() {
    for scene in random_scenes().iter().step_by(7) {
        let Case { sorted, fragments, options, .. } = sorted(scene);
        assert_eq!(count_pairs(&sorted.view, &fragments.lists, options.tolerance), fragments.occlusions);
    }
}

#[test]
fn any_number_of_threads_gives_the_same_result() {
    let scenes = [random::soup(5, 40), random::boxes(5, 9), large::street(300).resized(200)];
    let results = [1, 2, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads can be made").install(|| scenes.each_ref().map(sorted))
    });
    assert!(results[0] == results[1] && results[0] == results[2]);
}

/// The oracle itself: it must see what is wrong.
mod spoiled {
    use super::*;

    fn stairs() -> Case {
        sorted(&closed_form::stairs())
    }

    #[test]
    #[should_panic(expected = "forgiven pairs")]
    fn an_element_before_its_occluder_is_seen() {
        let mut stairs = stairs();
        stairs.sorted.layers.elements[2].visibility_layer = 1;
        stairs.sorted.layers.elements[3].visibility_layer = 2;
        stairs.sorted.layers.elements[4].visibility_layer = 3;
        Oracle::new(&stairs).check();
    }

    #[test]
    #[should_panic(expected = "stands too far back")]
    fn a_late_element_is_seen() {
        let mut stairs = stairs();
        stairs.sorted.layers.elements[4].visibility_layer = 5;
        stairs.sorted.layers.elements[3].visibility_layer = 4;
        stairs.sorted.layers.elements[2].visibility_layer = 3;
        Oracle::new(&stairs).earliest_of_all();
    }

    #[test]
    #[should_panic(expected = "not every node once")]
    fn a_face_in_two_elements_is_seen() {
        let mut stairs = stairs();
        let node = stairs.sorted.layers.elements[0].nodes[0];
        stairs.sorted.layers.elements[1].nodes.push(node);
        Oracle::new(&stairs).check();
    }

    #[test]
    #[should_panic(expected = "forgiven without a cycle")]
    fn a_pair_that_was_forgiven_without_need_is_seen() {
        let mut stairs = stairs();
        stairs.options.min_support = u32::MAX;
        stairs.sorted.layers.elements.iter_mut().for_each(|element| element.visibility_layer = 0);
        let edges = std::mem::take(&mut stairs.sorted.layers.occlusions.edges);
        stairs.sorted.layers.against = edges;
        Oracle::new(&stairs).check();
    }
}
