//! What overhangs the outline of a house and is missing in the model is not continued on the backdrop behind it.

use quadratura::testing::layers::Options;
use quadratura::testing::layers::fill::FillOptions;

use super::bench::{Bench, noise};

/// A line of trees.
fn leaves(point: glam::DVec3) -> [f64; 3] {
    let [dark, ..] = noise((point * 4.0).floor());
    [0.1 + 0.1 * dark, 0.4 + 0.3 * dark, 0.1]
}

#[test]
fn bricks_that_overhang_the_outline_of_a_house_are_not_continued_in_the_trees_behind_it() {
    let bench = Bench::before_a_backdrop(leaves);
    // The cube hides the wall from -1.5 to 2.5 and up to 2.53; eleven pixels are 0.18 on the wall.
    let overhangs = |point: glam::DVec3| {
        let within = |wider: f64| {
            (-1.5 - wider..2.5 + wider).contains(&point.x) && (0.0..2.53 + wider).contains(&point.z)
        };
        within(0.17) && !within(0.0)
    };
    bench.repaint(0, [190, 60, 40], overhangs);
    bench.build(Options::default());
    let filled = bench.fill(&FillOptions::default());
    let stack = filled[0].stack.as_ref().unwrap();
    let texels = bench.texels(0, stack);
    let of_trees: Vec<_> =
        texels.iter().filter(|texel| stack.image_layers[texel.layer].name.starts_with("trees")).collect();
    assert!(of_trees.len() > 10_000, "{}", of_trees.len());
    let red = of_trees.iter().filter(|texel| texel.rgb[0] > texel.rgb[1]).count();
    assert_eq!(red, 0, "of {} texels", of_trees.len());
}
