//! Tests of the fit with trees that are drawn: the real one is another one of its kind.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec3, Vec3};

use super::fit::{Fit, PixelBlock, fit, ground_of_sky};
use quadratura_base::scene::synthetic::{centred, look_at};
use quadratura_base::task::Task;
use quadratura_foliage::{InLights, OutdoorLight, Plant, Species, View, draw_in_lights, grow};

/// Pixels of the drawing across and down, of 2 x 2 a block.
const SIDE: usize = 192;

fn oak(seed: u64) -> Plant {
    let species: Species = serde_json::from_str(include_str!("../../../examples/oak.json")).unwrap();
    grow(&Species { seed, ..species }).unwrap()
}

/// Draws a plant in sunlight and in skylight from a side of it, as a share of a turn.
fn seen(plant: &Plant, turn: f64) -> Vec<InLights> {
    let ball = plant.whole().bounds.ball;
    let side = DVec3::new((TAU * turn).cos(), (TAU * turn).sin(), 0.1);
    let pose = look_at(ball.middle + 4.0 * ball.radius * side, ball.middle);
    let view = View::of_tree(centred(192, 192, 330.0), &pose, &DAffine3::IDENTITY, &ball);
    let none =
        OutdoorLight { sun: Vec3::ZERO, sky: Vec3::ZERO, ground: Vec3::ZERO, ..OutdoorLight::day(plant.up) };
    let sun = OutdoorLight { sun: Vec3::ONE, ..none };
    let sky = OutdoorLight { sky: Vec3::ONE, ground: ground_of_sky().as_vec3(), ..none };
    draw_in_lights(plant, &view, [sun, sky], &[0.0; SIDE * SIDE], None, &Task::silent()).unwrap()
}

/// Returns what a block shows: how many of its 64 sub-pixels, and their mean light in both lights.
fn in_block(drawn: &[InLights], column: usize, row: usize) -> (u32, [DVec3; 2]) {
    let pixels = [0, 1].map(|y| &drawn[(2 * row + y) * SIDE + 2 * column..][..2]);
    let pixels = || pixels.iter().copied().flatten();
    let covered = pixels().map(|pixel| u32::from(pixel.covered)).sum::<u32>();
    let mean =
        |of: usize| pixels().map(|pixel| pixel.sums[of].as_dvec3()).sum::<DVec3>() / f64::from(covered);
    (covered, [mean(0), mean(1)])
}

/// Returns the blocks of photos of a tree in some light that a stand-in covers, as the blocks of a site are.
fn blocks(real: &Plant, stand_in: &Plant, photos: usize, sun: DVec3, sky: DVec3) -> Vec<PixelBlock> {
    let mut blocks = Vec::new();
    for photo in 0..photos {
        let turn = photo as f64 / photos as f64;
        let (real, own) = (seen(real, turn), seen(stand_in, turn));
        for (row, column) in (0..SIDE / 2).flat_map(|row| (0..SIDE / 2).map(move |column| (row, column))) {
            let (covered, parts) = in_block(&own, column, row);
            let (shown, [s, k]) = in_block(&real, column, row);
            if covered >= 58 && shown >= 58 {
                blocks.push(PixelBlock { photo, sun: parts[0], sky: parts[1], light: s * sun + k * sky });
            }
        }
    }
    blocks
}

fn truth() -> (DVec3, DVec3) {
    (DVec3::new(2.4, 2.2, 1.9), DVec3::new(0.4, 0.55, 0.8))
}

/// Returns how much too bright the stand-in is on average, and sun and sky, all relative to the truth.
fn errors(real: u64, stand_in: u64, photos: usize) -> (Fit, DVec3, [DVec3; 2]) {
    let (sun, sky) = truth();
    let blocks = blocks(&oak(real), &oak(stand_in), photos, sun, sky);
    let found = fit(&blocks).unwrap();
    let [s, k] = [found.strength.sun, found.strength.sky].map(DVec3::from_array);
    let shown = blocks.iter().map(|block| block.sun * s + block.sky * k).sum::<DVec3>();
    let mean = shown / blocks.iter().map(|block| block.light).sum::<DVec3>();
    (found, mean, [s / sun, k / sky])
}

#[test]
fn a_known_light_on_the_same_tree_comes_back_and_on_another_one_its_mean_does() {
    // The same tree: only the prior is in the way, which is worth 100 blocks of some thousands.
    let (same, mean, [sun, sky]) = errors(1, 1, 6);
    assert!(same.is_split && same.blocks > 2000, "{same:?}");
    assert!((mean - 1.0).abs().max_element() < 0.005, "{mean}");
    assert!((sun - 1.0).abs().max_element() < 0.05 && (sky - 1.0).abs().max_element() < 0.08, "{sun} {sky}");
    // Another one: its leaves are elsewhere, which makes the sun too weak and the sky too bright. Blocks that do not count shift
    // the mean.
    let (other, mean, [sun, sky]) = errors(2, 1, 6);
    assert!(other.is_split, "{other:?}");
    assert!((mean - 1.0).abs().max_element() < 0.03, "{mean}");
    assert!(sun.min_element() > 0.6 && sun.max_element() < 1.05 && sky.min_element() > 0.95, "{sun} {sky}");
    // One photo: the mean and the usual ratio.
    let (one, mean, _) = errors(2, 1, 1);
    assert!(!one.is_split && (mean - 1.0).abs().max_element() < 0.03, "{mean}");
}
