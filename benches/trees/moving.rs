//! A view that moves among the trees of an avenue, which shade the ground.

use std::sync::Arc;
use std::time::{Duration, Instant};

use criterion::Criterion;
use glam::{DVec3, dvec3};
use quadratura::task::Task;
use quadratura::testing::foliage::{BakeOptions, PlacedTrees, Placing, Plant, PlantImages};
use quadratura::testing::geometry::PixelRect;
use quadratura::testing::gpu::Gpu;
use quadratura::testing::one_photo;
use quadratura::testing::projection::{LayerTextureId, LayerTexturePixels, Renders, Sources, Texels};
use quadratura::testing::scene::Model;
use quadratura::testing::scene::synthetic::{Modeller, centred, look_at};
use quadratura::testing::view::{Quality, Shot};

use super::{
    FOCAL, SIZE, baked, few, grown, is_wanted, maple_species, placed_trees, renderer_of, species, timed,
};

/// What trees may take in a picture of a view that moves, as in the window.
const TREES_WITHIN: Duration = Duration::from_millis(30);
/// The side of the photo of the avenue's ground, in pixels.
const SIDE: u32 = 64;
/// The side of the ground, in metres.
const GROUND: f64 = 60.0;

/// A ground of one grey that a photo from above shows.
struct Grey;

impl Texels for Grey {
    fn layer_texture(&self, _: LayerTextureId) -> quadratura::Result<LayerTexturePixels> {
        let rect = PixelRect::of_size(SIDE, SIDE);
        let pixels = (SIDE * SIDE) as usize;
        let rgba = [190, 185, 175, 255].repeat(pixels);
        Ok(LayerTexturePixels { rect, rgba, needed: vec![1; pixels], matte: None })
    }
}

/// The ground that trees stand on and shade.
fn ground() -> (Arc<Model>, Arc<Sources>) {
    let corner = dvec3(-0.5 * GROUND, -0.5 * GROUND, 0.0);
    let model = Modeller::new().object("ground").quad(corner, GROUND * DVec3::X, GROUND * DVec3::Y).finish();
    let camera = centred(SIDE, SIDE, 0.5 * f64::from(SIDE));
    let pose = look_at(dvec3(0.0, -1.0, 1.1 * GROUND), DVec3::ZERO);
    let sources = one_photo(camera, pose, model.faces.len());
    (model, Arc::new(sources))
}

/// Trees in two rows along the ground, with their shadows; each is about nine metres tall.
fn avenue(maple: &Arc<Plant>, images: &Arc<PlantImages>, count: u32) -> PlacedTrees {
    let along = 0.9 * GROUND / f64::from(count / 2);
    let placing = |i: u32| Placing {
        at: dvec3(
            if i.is_multiple_of(2) { -5.0 } else { 5.0 },
            along * f64::from(i / 2) - 0.45 * GROUND,
            0.0,
        ),
        up: DVec3::Z,
        height: Some(9.0),
        width: None,
        turn: 137.508 * f64::from(i),
        unit: 1.0,
    };
    let mut placed =
        placed_trees(species(maple, Some(images)), (0..count).map(|i| placing(i).world_from_plant(maple)));
    placed.trees.iter_mut().for_each(|tree| tree.casts = true);
    placed
}

/// Steps of a drag.
const STEPS: u32 = 60;
/// A drag ends after this time, however far it came.
const DRAG: Duration = Duration::from_secs(30);

/// Times a view that walks between the trees as the window draws it: its first picture, those that follow, and the preview of where it
/// stops, where the device is fast enough for one.
pub fn moving(c: &mut Criterion) {
    if !is_wanted("moving among trees") {
        return;
    }
    let Ok(gpu) = Gpu::headless() else { return };
    let maple = grown(&maple_species());
    let images = baked(&maple, &BakeOptions::SLABS);
    let ground = ground();
    let mut group = c.benchmark_group("moving among trees");
    few(&mut group);
    for count in [20, 200, 1000] {
        let avenue = avenue(&maple, &images, count);
        let shot = |step: f64| {
            let eye = dvec3(0.8, -0.3 * GROUND + 0.1 * step, 1.7);
            let target = eye + dvec3((0.05 * step).sin(), 4.0, 0.1);
            let shot = Shot::new(centred(SIZE[0], SIZE[1], FOCAL), look_at(eye, target));
            Shot { quality: Quality::Preview, trees_within: Some(TREES_WITHIN), ..shot }
        };
        // In a new renderer each time, which has made nothing and knows nothing about the device.
        let drag = timed(&mut group, &format!("{count} trees"), || {
            let (model, sources) = ground.clone();
            let mut renderer = renderer_of(&gpu, model, sources, Arc::new(Grey), avenue.clone());
            let mut seconds = |shot: &Shot| {
                let began = Instant::now();
                renderer.picture(shot, &Task::silent()).expect("the adapter works");
                began.elapsed().as_secs_f64()
            };
            let began = Instant::now();
            let steps = (0..STEPS).map(f64::from).take_while(|_| began.elapsed() < DRAG);
            let times: Vec<f64> = steps.map(|step| seconds(&shot(step))).collect();
            let stops = Shot { trees_within: None, ..shot(f64::from(STEPS)) };
            let is_fast = times.len() == STEPS as usize;
            (times, is_fast.then(|| seconds(&stops)))
        });
        let Some((_, (times, stops))) = drag else { continue };
        let (first, mut others) = (times[0], times[1..].to_vec());
        others.sort_by(f64::total_cmp);
        let within =
            |share: f64| others.get((share * others.len() as f64) as usize).map_or(f64::NAN, |t| 1e3 * t);
        print!(
            "{count} trees: first {:.0} ms; of {} more, half within {:.0} ms, 90 % within {:.0} ms",
            1e3 * first,
            others.len(),
            within(0.5),
            within(0.9)
        );
        match stops {
            Some(seconds) => println!("; where it stops {:.0} ms", 1e3 * seconds),
            None => println!("; the drag took more than {} s", DRAG.as_secs()),
        }
    }
    group.finish();
}
