//! Tests of what changes from frame to frame of a flight.

use glam::DVec2;

use super::layered::{branch, brute};
use crate::{
    BakeOptions, FlakeOptions, OutdoorLight, Plant, PlantImages, View, WalkOptions, bake, draw_flakes, jump,
};
use quadratura_base::scene::synthetic::{centred, look_at};
use quadratura_base::task::Task;
use quadratura_view::Picture;

/// The view at a share of a spiral towards a plant: two turns, from 30 radii away to 3.
fn on_spiral(plant: &Plant, share: f64) -> View {
    let ball = plant.whole().bounds.ball;
    let (turn, distance) = (2.0 * std::f64::consts::TAU * share, 30.0 * 0.1f64.powf(share));
    let towards = DVec2::from_angle(turn).extend(0.15).normalize();
    let eye = ball.middle + distance * ball.radius * towards;
    View::perspective(centred(120, 120, 160.0), &look_at(eye, ball.middle), &ball)
}

fn drawn(plant: &Plant, images: &PlantImages, view: &View, walk: WalkOptions) -> Picture {
    let options = FlakeOptions { walk, ..FlakeOptions::PREVIEW };
    draw_flakes(plant, images, view, &OutdoorLight::day(plant.up), &options, &Task::silent()).unwrap().0
}

#[test]
fn on_a_spiral_towards_a_plant_nothing_jumps_that_does_not_with_polygons() {
    let plant = branch();
    let options = BakeOptions { side: 96, least_side: 96, most_side: 96, ..BakeOptions::SLABS };
    let images = bake(&plant, &options, &Task::silent()).unwrap();
    let preview = FlakeOptions::PREVIEW.walk;
    let pairs = 60;
    let found = (0..pairs).filter_map(|pair| {
        let share = f64::from(pair) / f64::from(pairs);
        let views = [share, share + 0.001].map(|share| on_spiral(&plant, share));
        let truth = views.map(|view| brute(&plant, &view));
        let pictures = views.map(|view| drawn(&plant, &images, &view, preview));
        jump(truth.each_ref(), pictures.each_ref())
    });
    let found: Vec<_> = found.collect();
    assert_eq!(found.len(), pairs as usize);
    let mean = found.iter().map(|jump| jump.mean).sum::<f64>() / f64::from(pairs);
    let most = found.iter().map(|jump| jump.most).fold(0.0, f64::max);
    // What a hard change of images at the threshold would be: all of the plant in one frame.
    let threshold_met = on_spiral(&plant, 0.8);
    let truth = brute(&plant, &threshold_met);
    let [finer, coarser] =
        [1e-3, 9.0].map(|threshold| drawn(&plant, &images, &threshold_met, WalkOptions { threshold }));
    let hard = jump([&truth, &truth], [&finer, &coarser]).unwrap();
    // The goals of the design; 0.2 and 2.0 were seen.
    assert!(mean < 1.0 && most < 4.0, "{mean} {most}");
    assert!(hard.mean > 2.0 * mean && hard.most > most, "{hard:?}, {mean}, {most}");
}
