//! Tests of images that are made from the images of parts.

use glam::DVec3;

use super::bushy;
use super::layered::{brute, from};
use crate::{
    BakeOptions, FlakeOptions, LayeredOptions, OutdoorLight, PlantImages, WalkOptions, bake, draw_flakes,
    draw_layered, similarity,
};
use quadratura_base::task::Task;

/// Small bushels, so that they have images, in a large bush.
const LAYERS: BakeOptions = BakeOptions { side: 12, least_side: 64, most_side: 64, ..BakeOptions::LAYERS };
const SLABS: BakeOptions =
    BakeOptions { directions: BakeOptions::SLABS.directions, slabs: 6, layers: 2, ..LAYERS };

#[test]
fn images_made_from_those_of_parts_look_nearly_as_those_made_from_all_polygons() {
    let (plant, task) = (bushy(), Task::silent());
    let (view, light) = (from(&plant, DVec3::new(1.0, 0.4, 0.3), 48), OutdoorLight::day(plant.up));
    let truth = brute(&plant, &view);
    let walk = WalkOptions { threshold: 4.0 };
    for options in [LAYERS, SLABS] {
        let made = |from_parts: bool| bake(&plant, &BakeOptions { from_parts, ..options }, &task).unwrap();
        let [whole, parts] = [false, true].map(made);
        let (bushel, bush) = (1, 2);
        assert!(parts.from_parts && parts.objects[bushel].is_some() && parts.objects[bush].is_some());
        assert!(whole.objects[bushel] == parts.objects[bushel], "it has no parts with images");
        assert!(whole.objects[bush] != parts.objects[bush], "it has parts with images");
        let like = |images: &PlantImages| {
            let (picture, cost) = match options.slabs {
                1 => {
                    let options = LayeredOptions { walk, ..LayeredOptions::FINAL };
                    draw_layered(&plant, images, &view, &light, &options, &task).unwrap()
                }
                _ => {
                    let options = FlakeOptions { walk, ..FlakeOptions::FINAL };
                    draw_flakes(&plant, images, &view, &light, &options, &task).unwrap()
                }
            };
            assert_eq!((cost.images, cost.triangles), (1, 0), "the whole bush is drawn by its image");
            similarity(&truth, &picture).unwrap()
        };
        let [whole, parts] = [&whole, &parts].map(like);
        // Each sample of a part stands for several leaves, and comes with the sub-pixels of its own image: here SSIM was 0.007 lower,
        // coverage 0.036 and light 0.035 off at most.
        let near = |a: f64, b: f64, most: f64| (a - b).abs() < most;
        assert!(
            parts.ssim > whole.ssim - 0.05
                && near(parts.coverage, whole.coverage, 0.05)
                && near(parts.light, whole.light, 0.05),
            "{whole:#?} {parts:#?}"
        );
    }
}
