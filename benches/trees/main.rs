//! Trees from images beside brute force, which draws every polygon of every instance with as many samples a pixel, in one run: 13 maples
//! on the processor and on the device, larger ones and 1,000 on the device; the time by number of trees and by polygons of a tree, with
//! straight lines through it; the walk alone; and a view that moves among the trees of an avenue, which shade the ground.
//!
//! `cargo bench --bench trees`; one group alone: `cargo bench --bench trees -- wood`. Ratios and lines are printed at the end of each group.

mod moving;

use std::sync::Arc;
use std::time::{Duration, Instant};

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, SamplingMode, criterion_group, criterion_main};
use glam::{DAffine3, DVec3, Vec3, dvec3};
use quadratura::render::TextureOptions;
use quadratura::task::Task;
use quadratura::testing::foliage::{
    BakeOptions, FlakeOptions, LayeredOptions, OutdoorLight, PlacedSpecies, PlacedTrees, Placing, Plant,
    PlantImages, Species, Tree, View, WalkOptions, bake, draw, draw_flakes, draw_layered, grow, in_view,
    similarity, walk,
};
use quadratura::testing::gpu::{Gpu, Renderer, TileStore};
use quadratura::testing::projection::relief::Relief;
use quadratura::testing::projection::{Gains, LayerTextureId, LayerTexturePixels, Renders, Sources, Texels};
use quadratura::testing::scene::Model;
use quadratura::testing::scene::synthetic::{centred, look_at};
use quadratura::testing::view::{Picture, Quality, Shot, TreeMethod};

/// Columns and rows of the pictures.
const SIZE: [u32; 2] = [960, 540];
/// Those of the large ones.
const LARGE: [u32; 2] = [1920, 1080];
/// The focal length of the pictures of woods, in pixels.
const FOCAL: f64 = 800.0;
/// What takes longer than this, in seconds, is run [`FEW`] times, or once where that takes too long, whatever criterion asks for.
const SLOW: f64 = 0.5;
/// See [`SLOW`].
const FEW: f64 = 3.0;

type Group<'a> = BenchmarkGroup<'a, WallTime>;

fn maple_species() -> Species {
    serde_json::from_str(include_str!("../../examples/maple.json")).expect("the example is a species")
}

fn grown(species: &Species) -> Arc<Plant> {
    Arc::new(grow(species).expect("it is within the limits"))
}

fn baked(plant: &Plant, options: &BakeOptions) -> Arc<PlantImages> {
    Arc::new(bake(plant, options, &Task::silent()).expect("nobody stops it"))
}

fn species(plant: &Arc<Plant>, images: Option<&Arc<PlantImages>>) -> PlacedSpecies {
    PlacedSpecies { plant: plant.clone(), unpainted: None, images: images.cloned(), openness: None }
}

/// The trees of a species in these places.
fn placed_trees(species: PlacedSpecies, places: impl Iterator<Item = DAffine3>) -> PlacedTrees {
    let tree = |(number, world_from_plant): (u32, DAffine3)| Tree {
        number,
        name: format!("tree {number}"),
        species: 0,
        world_from_plant,
        tint: Vec3::ONE,
        casts: false,
        ratios: Arc::default(),
        sunlit: None,
    };
    let light = OutdoorLight::day(species.plant.up);
    PlacedTrees { trees: (0..).zip(places).map(tree).collect(), species: vec![species], light }
}

/// A site without photos has no texels.
struct NoTexels;

impl Texels for NoTexels {
    fn layer_texture(&self, _: LayerTextureId) -> quadratura::Result<LayerTexturePixels> {
        Err(quadratura::Error::Request("the site has no photos".into()))
    }
}

fn renderer(gpu: &Gpu, placed: PlacedTrees) -> Renderer {
    renderer_of(gpu, Arc::default(), Arc::default(), Arc::new(NoTexels), placed)
}

/// A renderer of a model and the trees that stand on it.
fn renderer_of(
    gpu: &Gpu,
    model: Arc<Model>,
    sources: Arc<Sources>,
    texels: Arc<dyn Texels>,
    placed: PlacedTrees,
) -> Renderer {
    let tiles = TileStore::new(gpu, &sources, texels, TextureOptions::default())
        .expect("page tables fit into any device");
    let gains = Gains::none(sources.photos.len());
    let mut renderer =
        Renderer::new(gpu, model, sources, gains, &Relief::default(), tiles).expect("shaders are valid");
    renderer.set_trees(Some(Arc::new(placed))).expect("the device has room for the trees");
    renderer
}

fn median(times: &[f64]) -> Option<f64> {
    let mut times = times.to_vec();
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied()
}

/// Times what is run: by criterion, or where it takes longer than [`SLOW`], a few times. Returns the median of its seconds and what it
/// gave, or `None` where another benchmark was asked for.
fn timed<T>(group: &mut Group<'_>, name: &str, mut run: impl FnMut() -> T) -> Option<(f64, T)> {
    let (mut times, mut last) = (Vec::new(), None);
    group.bench_function(name, |b| {
        b.iter_custom(|count| {
            let mut took = Duration::ZERO;
            for _ in 0..count {
                // Criterion asks for ten at least; what is slow is not run again for them.
                let slow = median(&times).filter(|median| times.len() as f64 * median > SLOW * FEW);
                let seconds = slow.unwrap_or_else(|| {
                    let began = Instant::now();
                    last = Some(run());
                    times.push(began.elapsed().as_secs_f64());
                    times[times.len() - 1]
                });
                took += Duration::from_secs_f64(seconds);
            }
            took
        });
    });
    median(&times).zip(last)
}

/// Prints how many times faster a method is than brute force, and how like its picture is.
fn report(name: &str, brute: &Option<(f64, Picture)>, found: &Option<(f64, Picture)>) {
    let (Some((brute, truth)), Some((seconds, picture))) = (brute, found) else { return };
    let Some(like) = similarity(truth, picture) else { return };
    let off = |ratio: f64| 100.0 * (ratio - 1.0);
    println!(
        "{name}: {:.1} ms, {:.1} x faster; SSIM {:.3}, coverage {:+.1} %, light {:+.1} %",
        1e3 * seconds,
        brute / seconds,
        like.ssim,
        off(like.coverage),
        off(like.light)
    );
}

/// Prints the straight line through times that has the least squares, with the root mean square of what is left of the mean time.
fn report_line(name: &str, unit: &str, times: &[(f64, Option<f64>)]) {
    let points: Vec<(f64, f64)> = times.iter().filter_map(|(x, seconds)| Some((*x, (*seconds)?))).collect();
    if points.len() < times.len() {
        return;
    }
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(&|point| point.0), mean(&|point| point.1));
    let slope = mean(&|point| (point.0 - x) * (point.1 - y)) / mean(&|point| (point.0 - x).powi(2));
    let residual = mean(&|point| (point.1 - y - slope * (point.0 - x)).powi(2)).sqrt();
    println!(
        "{name}: {:.2} ms + {:.4} ms {unit}, residual {:.1} % of the mean",
        1e3 * (y - slope * x),
        1e3 * slope,
        100.0 * residual / y
    );
}

/// 13 maples and a view of them.
struct ThirteenMaples {
    maple: Arc<Plant>,
    placed: Plant,
    shot: Shot,
}

impl ThirteenMaples {
    /// The view has `size` pixels, and the nearest maple is about `rows` pixels tall in it.
    fn new(size: [u32; 2], rows: f64) -> Self {
        let one = maple_species();
        let placed = grow(&Species { trees: 13, ..one.clone() }).expect("it is within the limits");
        let ball = placed.whole().bounds.ball;
        let tallest = placed.whole().bounds.space.high.z;
        let focal = FOCAL * f64::from(size[0]) / f64::from(SIZE[0]);
        let distance = focal * tallest / rows + ball.radius;
        let eye = ball.middle + dvec3(0.0, -distance, 2.0 - ball.middle.z);
        let shot = Shot::new(centred(size[0], size[1], focal), look_at(eye, ball.middle));
        Self { maple: grown(&one), placed, shot }
    }

    /// The places of the maples.
    fn places(&self) -> impl Iterator<Item = DAffine3> {
        self.placed.whole().uses.iter().map(|used| used.parent_from_child)
    }

    /// The images of the maple for the wood, whose other sub-objects are the same.
    fn images_of_wood(&self, images: &PlantImages) -> PlantImages {
        let names =
            |plant: &Plant| plant.objects.iter().map(|object| object.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&self.maple), names(&self.placed)[..self.maple.objects.len()]);
        let mut images = images.clone();
        images.objects.push(None);
        images
    }

    fn view(&self) -> View {
        View::perspective(self.shot.camera, &self.shot.pose, &self.placed.whole().bounds.ball)
    }
}

/// The groups.
const GROUPS: [&str; 8] = [
    "wood of 13 on the processor",
    "wood of 13 on the device",
    "large pictures of 13 on the device",
    "1,000 maples on the device",
    "picture by number of trees",
    "picture by polygons of a tree",
    "walk, one thread",
    "moving among trees",
];

/// Returns false where a word is asked for that is part of other groups' names alone, so that nothing is made for this one.
fn is_wanted(group: &str) -> bool {
    let words: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with('-')).collect();
    let [word] = &words[..] else { return true };
    group.contains(word) || !GROUPS.iter().any(|other| other.contains(word.as_str()))
}

fn few(group: &mut Group<'_>) {
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    group.warm_up_time(Duration::from_millis(1)).measurement_time(Duration::from_secs(1));
}

fn thirteen_maples(c: &mut Criterion) {
    if !GROUPS[..2].iter().any(|group| is_wanted(group)) {
        return;
    }
    let scene = ThirteenMaples::new(SIZE, 200.0);
    let images = images_of(&scene.maple);
    on_processor(c, &scene, [&images[0], &images[1]]);
    on_device(c, GROUPS[1], (&scene.maple, scene.places()), &scene.shot, &images);
}

/// The images of slabs and of layers.
fn images_of(maple: &Plant) -> [Arc<PlantImages>; 2] {
    [BakeOptions::SLABS, BakeOptions::LAYERS].map(|options| baked(maple, &options))
}

fn large_pictures(c: &mut Criterion) {
    if !is_wanted(GROUPS[2]) {
        return;
    }
    let scene = ThirteenMaples::new(LARGE, 500.0);
    let images = images_of(&scene.maple);
    on_device(c, GROUPS[2], (&scene.maple, scene.places()), &scene.shot, &images);
}

/// 1,000 maples in rows of 25, 12 metres apart, which are all in view, from about 90 pixels tall to 30.
fn thousand_maples(c: &mut Criterion) {
    // Software adapters would take a quarter of an hour for each picture of all 2.5 thousand million triangles.
    if !is_wanted(GROUPS[3]) || Gpu::headless().is_ok_and(|gpu| gpu.is_software()) {
        return;
    }
    let maple = grown(&maple_species());
    let at = |i: u32| 12.0 * dvec3(f64::from(i % 25) - 12.0, f64::from(i / 25), 0.0);
    let places = (0..1000).map(|i| placed(&maple, at(i), i));
    let shot = Shot::new(centred(LARGE[0], LARGE[1], 1600.0), look_at(dvec3(0.0, -250.0, 40.0), DVec3::ZERO));
    on_device(c, GROUPS[3], (&maple, places), &shot, &images_of(&maple));
}

fn on_processor(c: &mut Criterion, scene: &ThirteenMaples, images: [&PlantImages; 2]) {
    let (view, light, task) = (scene.view(), OutdoorLight::day(scene.placed.up), Task::silent());
    let [slabs, layers] = images.map(|images| scene.images_of_wood(images));
    let mut group = c.benchmark_group("wood of 13 on the processor");
    few(&mut group);
    let brute = || draw(&scene.placed, &view, &light, &task).expect("nobody stops it").picture;
    let truth = timed(&mut group, "brute force", brute);
    let of_texels = |images: &PlantImages, options: &FlakeOptions| {
        draw_flakes(&scene.placed, images, &view, &light, options, &task).expect("nobody stops it").0
    };
    let of_layers = |options: &LayeredOptions| {
        draw_layered(&scene.placed, &layers, &view, &light, options, &task).expect("nobody stops it").0
    };
    let mut found = Vec::new();
    for (name, images, options) in [
        ("flakes of slabs, preview", &slabs, FlakeOptions::PREVIEW),
        ("flakes of slabs, final", &slabs, FlakeOptions::FINAL),
        ("flakes of layers, preview", &layers, FlakeOptions::PREVIEW),
        ("flakes of layers, final", &layers, FlakeOptions::FINAL),
        ("planes, preview", &slabs, FlakeOptions::PREVIEW_PLANES),
    ] {
        found.push((name, timed(&mut group, name, || of_texels(images, &options))));
    }
    for (name, options) in
        [("layers, preview", LayeredOptions::PREVIEW), ("layers, final", LayeredOptions::FINAL)]
    {
        found.push((name, timed(&mut group, name, || of_layers(&options))));
    }
    group.finish();
    found.iter().for_each(|(name, found)| report(name, &truth, found));
}

/// Draws maples at places by all their polygons and from both kinds of images.
fn on_device(
    c: &mut Criterion,
    name: &str,
    (maple, places): (&Arc<Plant>, impl Iterator<Item = DAffine3>),
    shot: &Shot,
    [slabs, layers]: &[Arc<PlantImages>; 2],
) {
    let (Ok(gpu), task) = (Gpu::headless(), Task::silent()) else { return };
    let places: Vec<DAffine3> = places.collect();
    let of = |images| renderer(&gpu, placed_trees(species(maple, images), places.iter().copied()));
    let mut group = c.benchmark_group(name);
    few(&mut group);
    let picture =
        |renderer: &mut Renderer, shot: &Shot| renderer.picture(shot, &task).expect("the adapter works");
    let mut found = Vec::new();
    for (quality, of_quality) in [(Quality::Preview, "preview"), (Quality::Final, "final")] {
        let polygons = Shot { quality, trees: TreeMethod::Polygons, ..shot.clone() };
        let mut brute = of(None);
        let name = format!("brute force, {of_quality}");
        let truth = timed(&mut group, &name, || picture(&mut brute, &polygons));
        for (kind, images) in [("slabs", slabs), ("layers", layers)] {
            let mut drawn = of(Some(images));
            let shot = Shot { trees: TreeMethod::Flakes, ..polygons.clone() };
            let name = format!("flakes of {kind}, {of_quality}");
            let drawn = timed(&mut group, &name, || picture(&mut drawn, &shot));
            found.push((name, truth.clone(), drawn));
        }
    }
    group.finish();
    found.iter().for_each(|(name, truth, found)| report(name, truth, found));
}

/// Returns the map to the world of the maple of this number at a place.
fn placed(maple: &Plant, at: DVec3, number: u32) -> DAffine3 {
    let turn = 137.508 * f64::from(number);
    Placing { at, up: DVec3::Z, height: None, width: None, turn, unit: 1.0 }.world_from_plant(maple)
}

/// Trees in rows of 40, 12 metres apart, of which each is about 16 pixels tall in the view; and that view.
fn rows_of_trees(maple: &Arc<Plant>, images: &Arc<PlantImages>, count: u32) -> (PlacedTrees, Shot) {
    let at = |i: u32| 12.0 * dvec3(f64::from(i % 40) - 19.5, f64::from(i / 40) - 12.0, 0.0);
    let places = (0..count).map(|i| placed(maple, at(i), i));
    let eye = dvec3(0.0, -700.0, 700.0);
    let shot = Shot::new(centred(SIZE[0], SIZE[1], 1600.0), look_at(eye, DVec3::ZERO));
    let quality = Quality::Preview;
    (placed_trees(species(maple, Some(images)), places), Shot { quality, ..shot })
}

fn by_trees(c: &mut Criterion) {
    if !is_wanted("picture by number of trees") {
        return;
    }
    let Ok(gpu) = Gpu::headless() else { return };
    let maple = grown(&maple_species());
    let images = baked(&maple, &BakeOptions::SLABS);
    let mut group = c.benchmark_group("picture by number of trees");
    few(&mut group);
    let mut times = Vec::new();
    for count in [1, 10, 100, 1000] {
        let (placed, shot) = rows_of_trees(&maple, &images, count);
        let mut renderer = renderer(&gpu, placed);
        let picture = || renderer.picture(&shot, &Task::silent()).expect("the adapter works");
        let timed = timed(&mut group, &count.to_string(), picture);
        times.push((f64::from(count), timed.map(|(seconds, _)| seconds)));
    }
    group.finish();
    report_line("flakes of slabs, preview", "a tree", &times);
}

fn by_polygons(c: &mut Criterion) {
    if !is_wanted("picture by polygons of a tree") {
        return;
    }
    let mut group = c.benchmark_group("picture by polygons of a tree");
    few(&mut group);
    let (mut of_images, mut of_polygons) = (Vec::new(), Vec::new());
    for (leaves, finer) in [(1, 1), (4, 1), (16, 1), (4, 3)] {
        let mut species = maple_species();
        species.leaf.count = leaves;
        species.levels.iter_mut().for_each(|level| level.segments *= finer);
        let plant = grown(&species);
        let images = baked(&plant, &BakeOptions::SLABS);
        let ball = plant.whole().bounds.ball;
        let eye = ball.middle + dvec3(0.0, -FOCAL * 2.0 * ball.radius / 100.0, 2.0);
        let pose = look_at(eye, ball.middle);
        let view = View::perspective(centred(SIZE[0], SIZE[1], FOCAL), &pose, &ball);
        let (light, task) = (OutdoorLight::day(plant.up), Task::silent());
        let polygons = plant.whole().counts.polygons as f64 / 1e6;
        let name = format!("{leaves} leaves a twig, {polygons:.2} million polygons");
        let flaked = || draw_flakes(&plant, &images, &view, &light, &FlakeOptions::PREVIEW, &task);
        let flaked = timed(&mut group, &name, || flaked().expect("nobody stops it"));
        of_images.push((polygons, flaked.map(|(seconds, _)| seconds)));
        let brute = || draw(&plant, &view, &light, &task).expect("nobody stops it");
        let brute = timed(&mut group, &format!("brute force, {name}"), brute);
        of_polygons.push((polygons, brute.map(|(seconds, _)| seconds)));
    }
    group.finish();
    report_line("flakes of slabs, preview", "a million polygons", &of_images);
    report_line("brute force", "a million polygons", &of_polygons);
}

fn walks(c: &mut Criterion) {
    if !is_wanted("walk, one thread") {
        return;
    }
    let maple = grown(&maple_species());
    let images = baked(&maple, &BakeOptions::SLABS);
    let (far, shot) = rows_of_trees(&maple, &images, 1000);
    let ball = maple.whole().bounds.ball;
    let near = ThirteenMaples::new(SIZE, 200.0);
    // Among the trees, at a metre and a half from the nearest trunk.
    let foot = near.placed.whole().uses[0].parent_from_child.translation;
    let eye = foot + dvec3(1.5, 0.0, 1.7);
    let look = look_at(eye, near.placed.whole().bounds.ball.middle);
    let near_shot = Shot::new(centred(SIZE[0], SIZE[1], FOCAL), look);
    let near = placed_trees(species(&maple, Some(&images)), near.places());
    let mut group = c.benchmark_group("walk, one thread");
    few(&mut group);
    for (name, placed, shot) in [("1,000 far trees", &far, &shot), ("13 near trees", &near, &near_shot)] {
        let view = |tree: &Tree| View::of_tree(shot.camera, &shot.pose, &tree.world_from_plant, &ball);
        let options: WalkOptions = FlakeOptions::PREVIEW.walk;
        let number = |tree: &Tree| u64::from(tree.number);
        let trees = || placed.trees.iter();
        let drawn = || trees().map(|tree| walk(&maple, &images, &view(tree), &options, number(tree)).len());
        let seen =
            || trees().map(|tree| in_view(&maple, &images, &view(tree), &options, number(tree)).images.len());
        println!("{name}: {} parts, {} images", drawn().sum::<usize>(), seen().sum::<usize>());
        timed(&mut group, name, || drawn().sum::<usize>());
        timed(&mut group, &format!("{name}, with the images that serve"), || seen().sum::<usize>());
    }
    group.finish();
}

criterion_group!(
    benches,
    thirteen_maples,
    large_pictures,
    thousand_maples,
    by_trees,
    by_polygons,
    walks,
    moving::moving
);
criterion_main!(benches);
