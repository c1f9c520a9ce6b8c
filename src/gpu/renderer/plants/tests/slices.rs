//! Tests of trees that are handed to the device in slices.

use std::sync::Arc;

use super::{oak, placed, renderer, shot, with_images};
use crate::left_out::on_adapter;
use crate::renderer::tests::cancelled_before_drawing;
use crate::{Gpu, Renderer};
use quadratura_base::error::Error;
use quadratura_base::scene::Model;
use quadratura_base::task::Task;
use quadratura_projection::Renders;
use quadratura_view::{Quality, Shot, TreeMethod};

/// Pretends that a renderer's device was seen to take these seconds for each sample.
fn takes(renderer: &mut Renderer, seconds: f64) {
    let view = &mut renderer.plants.as_mut().unwrap().view;
    view.pace.get_mut().learn(1.0, seconds);
}

#[test]
fn trees_drawn_in_slices_are_the_same_and_can_be_given_up() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let plant = oak();
    let placed = with_images(placed(plant.clone()));
    for (trees, quality) in [
        (TreeMethod::Flakes, Quality::Final),
        (TreeMethod::Flakes, Quality::Preview),
        (TreeMethod::Polygons, Quality::Preview),
    ] {
        let made = || renderer(&gpu, Arc::new(Model::default()), Some(placed.clone()));
        let shot = Shot { trees, ..shot(&plant, quality) };
        let (mut whole, mut sliced) = (made(), made());
        // All is handed over at once, and in slices as small as they become.
        takes(&mut whole, 1e-9);
        takes(&mut sliced, 60.0);
        let of_whole = &mut whole.plants.as_mut().unwrap().view;
        // What is drawn is looked at in between where parts are tested.
        of_whole.polygons.least_of_batch = None;
        let expected = whole.picture(&shot, &Task::silent()).unwrap();
        assert!(expected.pixels().iter().any(|pixel| pixel[3] == 255), "trees are in view");
        let given_up = sliced.picture(&shot, &cancelled_before_drawing());
        assert!(matches!(given_up, Err(Error::Cancelled)), "{trees:?}, {quality:?}: {:?}", given_up.err());
        // What is drawn next is not what was left behind.
        assert_eq!(sliced.picture(&shot, &Task::silent()).unwrap(), expected, "{trees:?}, {quality:?}");
        // Without slices there is nothing between which it could be given up.
        assert_eq!(whole.picture(&shot, &cancelled_before_drawing()).unwrap(), expected);
    }
}
