//! The sort on invented scenes whose answer is known.

use crate::layers::{LayerConstraints, Options, SoftwareRasteriser, Sorted, sort_photo};
use crate::scene::synthetic::{Scene, Truth, closed_form};
use crate::task::Task;

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
