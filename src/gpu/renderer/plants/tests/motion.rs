//! Trees in views that move: parts that dissolve, and images that keep up.

use std::sync::Arc;
use std::time::Duration;

use glam::DVec3;

use super::{measured, oak, placed, renderer, with_images};
use crate::Gpu;
use crate::left_out::on_adapter;
use quadratura_base::scene::synthetic::{Modeller, centred, look_at};
use quadratura_base::scene::{FaceId, Model};
use quadratura_base::task::Task;
use quadratura_foliage::{PlacedTrees, View, WalkOptions, in_view, jump};
use quadratura_projection::{Renders, TREE};
use quadratura_view::{Picture, Quality, Shot, TreeMethod};

/// One oak with images.
fn one_oak() -> PlacedTrees {
    let mut placed = with_images(placed(oak()));
    placed.trees.truncate(1);
    placed
}

/// A view from so many radii away.
fn from(placed: &PlacedTrees, distance: f64, quality: Quality) -> Shot {
    let ball = placed.species[0].plant.whole().bounds.ball;
    let eye = ball.middle + distance * ball.radius * DVec3::new(0.4, -0.9, 0.2).normalize();
    Shot { quality, ..Shot::new(centred(240, 200, 250.0), look_at(eye, ball.middle)) }
}

#[test]
fn images_and_the_parts_that_they_dissolve_into_share_the_samples() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let placed = one_oak();
    let mut renderer = renderer(&gpu, Arc::new(Model::default()), Some(placed.clone()));
    let mut in_part = [0, 0];
    for step in 0..9 {
        let distance = 1.3 * 1.45f64.powi(step);
        for (quality, walk) in
            [(Quality::Preview, WalkOptions::PREVIEW), (Quality::Final, WalkOptions::FINAL)]
        {
            let shot = from(&placed, distance, quality);
            let (species, tree) = (&placed.species[0], &placed.trees[0]);
            let ball = species.plant.whole().bounds.ball;
            let view = View::of_tree(shot.camera, &shot.pose, &tree.world_from_plant, &ball);
            let seen = in_view(&species.plant, species.images.as_ref().unwrap(), &view, &walk, 0);
            in_part[0] += seen.images.iter().filter(|image| !image.of_part.is_wide()).count();
            in_part[1] += seen.polygons.iter().filter(|polygons| !polygons.stipple.is_wide()).count();
            let found = renderer.picture(&shot, &Task::silent()).unwrap();
            let polygons = Shot { trees: TreeMethod::Polygons, ..shot };
            let expected = renderer.picture(&polygons, &Task::silent()).unwrap();
            let ((area, _), (area_expected, _)) = (measured(&found), measured(&expected));
            // The goal for coverage at any height; of 100 covered pixels, as many are 5 %.
            let off = (area - area_expected).abs();
            assert!(off < 0.05 * area_expected + 3.0, "{distance}, {quality:?}: {area} and {area_expected}");
        }
    }
    assert!(in_part[0] > 10 && in_part[1] > 100, "{in_part:?}");
}

#[test]
fn where_trees_may_take_no_time_they_are_coarse_at_once_and_become_fine_picture_by_picture_where_they_may() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let placed = one_oak();
    let mut renderer = renderer(&gpu, Arc::new(Model::default()), Some(placed.clone()));
    let mut drawn = |shot: &Shot, within: Option<Duration>| -> Picture {
        renderer.picture(&Shot { trees_within: within, ..shot.clone() }, &Task::silent()).unwrap()
    };
    let shot = from(&placed, 3.2, Quality::Preview);
    let fine = drawn(&shot, None);
    let (none, plenty) = (Some(Duration::from_nanos(1)), Some(Duration::from_secs(3600)));
    // The first picture is the same, since nothing is known of the device before it.
    assert!(drawn(&shot, none) == fine);
    // A nanosecond is far too little, so the next picture is as coarse as is allowed.
    let coarse = drawn(&shot, none);
    assert!(coarse != fine && drawn(&shot, none) == coarse);
    let ((area, _), (area_fine, _)) = (measured(&coarse), measured(&fine));
    assert!((area / area_fine - 1.0).abs() < 0.1, "{area} {area_fine}");
    // What is not limited is as fine as it is at once.
    assert!(drawn(&shot, None) == fine);
    let rest = from(&placed, 3.2, Quality::Final);
    assert!(drawn(&rest, none) == drawn(&rest, None), "final pictures take their time");
    // What may take its time becomes fine by steps.
    let mut pictures = vec![coarse];
    // What is coarser than two pixels becomes finer at once; then steps of 2 % lead from 2 to 0.8 pixels in 47 pictures.
    pictures.extend((0..60).map(|_| drawn(&shot, plenty)));
    assert!(pictures[60] == fine && pictures[59] == fine);
    let change = |before: &Picture, after: &Picture| jump([&fine, &fine], [before, after]).unwrap().mean;
    let changes: Vec<f64> = pictures.windows(2).map(|pair| change(&pair[0], &pair[1])).collect();
    // After the second one no sample is seen as a square any more.
    let (all, most) = (change(&pictures[2], &fine), changes[2..].iter().copied().fold(0.0, f64::max));
    // With steps of 5 %, from fine to coarse, the largest one, in which most of the tree changed to coarser images, was 0.7 of all.
    assert!(most < 0.6 * all, "no step is most of the change of {all}: {changes:?}");
}

#[test]
fn numbers_are_those_of_the_picture_before_them_and_of_no_other_view_or_trees() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let placed = one_oak();
    let none = Some(Duration::from_nanos(1));
    let task = Task::silent();
    let new = || renderer(&gpu, Arc::new(Model::default()), Some(placed.clone()));
    let shot = from(&placed, 3.2, Quality::Preview);
    let fine = new().faces(&shot, &task).unwrap();
    let mut renderer = new();
    // The first picture finds out that the device is too slow; the second one is coarse, and so are its numbers.
    let moving = Shot { trees_within: none, ..shot.clone() };
    renderer.picture(&moving, &task).unwrap();
    let coarse = renderer.picture(&moving, &task).unwrap();
    let numbers = renderer.seen_faces(&moving, &task).unwrap();
    assert!(numbers != fine);
    let both =
        numbers.iter().zip(coarse.pixels()).filter(|(number, pixel)| (**number == TREE) == (pixel[3] > 0));
    assert_eq!(both.count(), numbers.len());
    renderer.picture(&shot, &task).unwrap();
    assert_eq!(renderer.seen_faces(&shot, &task).unwrap(), fine);
    // Those of a view at rest are those of its preview.
    let rest = Shot { quality: Quality::Final, ..shot.clone() };
    renderer.picture(&rest, &task).unwrap();
    assert_eq!(renderer.seen_faces(&rest, &task).unwrap(), fine);
    let other = from(&placed, 4.0, Quality::Preview);
    assert_eq!(renderer.seen_faces(&other, &task).unwrap(), new().faces(&other, &task).unwrap());
    // After numbers of another drawing, those of no picture are taken.
    renderer.faces(&other, &task).unwrap();
    assert_eq!(renderer.seen_faces(&shot, &task).unwrap(), fine);
    // Trees that have moved.
    renderer.picture(&shot, &task).unwrap();
    let mut moved = placed.clone();
    moved.trees[0].world_from_plant.translation += DVec3::X;
    renderer.set_trees(Some(moved.clone().into())).unwrap();
    let expected =
        super::renderer(&gpu, Arc::new(Model::default()), Some(moved)).faces(&shot, &task).unwrap();
    assert!(expected != fine && renderer.seen_faces(&shot, &task).unwrap() == expected);
}

#[test]
fn trees_behind_a_face_that_is_hidden_now_have_their_numbers() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let placed = one_oak();
    let task = Task::silent();
    let shot = from(&placed, 3.2, Quality::Preview);
    let [right, down, forward] = [0, 1, 2].map(|axis| shot.pose.rotation.row(axis));
    let mut model = Modeller::new();
    let at = placed.species[0].plant.whole().bounds.ball.radius;
    model.object("wall").quad(
        shot.viewpoint() + at * (forward - right - down),
        2.0 * at * right,
        2.0 * at * down,
    );
    let mut renderer = renderer(&gpu, model.finish(), Some(placed));
    let trees = |numbers: Vec<u32>| numbers.iter().filter(|number| **number == TREE).count();
    renderer.picture(&shot, &task).unwrap();
    assert_eq!(trees(renderer.seen_faces(&shot, &task).unwrap()), 0);
    let hidden = Shot { hidden: std::iter::once(FaceId(0)).collect(), ..shot };
    assert!(trees(renderer.seen_faces(&hidden, &task).unwrap()) > 1000);
}
