//! The sort on invented scenes whose answer is known.

use crate::{Faces, LayerConstraints, Options, SoftwareRasteriser, Sorted, sort_photo};
use quadratura_base::scene::synthetic::{Modeller, Scene, Truth, camera_is_world, centred, closed_form};
use quadratura_base::task::Task;

fn sorted(scene: &Scene) -> Sorted {
    let task = Task::silent();
    sort_photo(
        &scene.model,
        &scene.camera,
        &scene.pose,
        &SoftwareRasteriser,
        &Options::default(),
        &LayerConstraints::default(),
        &task,
    )
    .expect("it is not stopped")
}

fn names_by_layer(scene: &Scene, sorted: &Sorted) -> Vec<Vec<String>> {
    let mut layers = vec![Vec::new(); sorted.layers.count() as usize];
    for element in &sorted.layers.elements {
        layers[element.visibility_layer as usize].push(scene.model.object(element.object).name.clone());
    }
    layers.iter_mut().for_each(|l| l.sort());
    layers
}

#[test]
fn closed_form_scenes_give_the_layers_that_they_must() {
    for scene in closed_form::all() {
        let sorted = sorted(&scene);
        match &scene.truth {
            Truth::Layers(layers) => assert_eq!(&names_by_layer(&scene, &sorted), layers, "{}", scene.name),
            Truth::Cycle => assert!(sorted.cuts > 0, "{}: nothing was cut", scene.name),
            Truth::Unknown => (),
        }
        assert!(
            sorted.refused.iter().all(|r| r.2 <= Options::default().min_support),
            "{}: {:?} was left",
            scene.name,
            sorted.refused
        );
    }
}

/// A dormer between two rows of far trees, all of one object `trees`, whose box holds it.
fn dormer_between(trees: &str) -> Scene {
    let mut m = Modeller::new();
    m.object(trees).screen(10.0, [-6.0, -3.0, -1.0, 3.0]).screen(10.0, [1.0, -3.0, 6.0, 3.0]);
    m.object("dormer").screen(8.0, [-0.5, -1.0, 0.5, 1.0]);
    let (camera, pose) = (centred(160, 120, 120.0), camera_is_world());
    Scene { name: trees.into(), model: m.finish(), camera, pose, truth: Truth::Unknown }
}

#[test]
fn a_backdrop_shares_no_image_layer_with_anything_else_unless_it_is_merged_by_hand() {
    let clusters = |trees: &str, constraints: &LayerConstraints| {
        let Scene { model, camera, pose, .. } = dormer_between(trees);
        let (options, task) = (Options::default(), Task::silent());
        let sorted = sort_photo(&model, &camera, &pose, &SoftwareRasteriser, &options, constraints, &task);
        sorted.expect("it is not stopped").clusters.list.len()
    };
    let none = LayerConstraints::default();
    assert_eq!(clusters("trees", &none), 1, "the dormer costs no texels in the layer of other things");
    assert_eq!(clusters("trees.backdrop", &none), 2);
    let whole = |object: &str| Faces { object: object.into(), faces: Vec::new() };
    let merge = vec![vec![whole("trees.backdrop"), whole("dormer")]];
    let merged = LayerConstraints { merge, ..LayerConstraints::default() };
    assert_eq!(clusters("trees.backdrop", &merged), 1, "a decision stays what it is");
}
