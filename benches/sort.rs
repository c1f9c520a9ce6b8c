//! The visibility sort, by what it costs: faces, depth complexity, pixels; the graph against
//! stencil peeling; clustering by elements.
//!
//! `cargo bench --bench sort`; one group alone: `cargo bench --bench sort -- pixels`.

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use quadratura::task::Task;
use quadratura::testing::geometry::PixelRect;
use quadratura::testing::gpu::{Gpu, GpuRasteriser};
use quadratura::testing::layers::cluster::cluster;
use quadratura::testing::layers::constraints::{ElementConstraints, ResolvedConstraints};
use quadratura::testing::layers::cycles::resolve_cycles;
use quadratura::testing::layers::parts::gather_parts;
use quadratura::testing::layers::rasteriser::Presence;
use quadratura::testing::layers::runs::Runs;
use quadratura::testing::layers::{
    LayerConstraints, Options, ProjectedModel, Rasteriser, SoftwareRasteriser, Sorted, sort_photo,
};
use quadratura::testing::scene::synthetic::{Scene, large};

fn sort(scene: &Scene, rasteriser: &dyn Rasteriser) -> Sorted {
    let Scene { model, camera, pose, .. } = scene;
    sort_photo(
        model,
        camera,
        pose,
        rasteriser,
        &Options::default(),
        &LayerConstraints::default(),
        &Task::silent(),
    )
    .expect("the rasteriser works and nobody stops it")
}

/// The rasterisers of this machine: the plain one, and the GPU where there is an adapter.
fn rasterisers() -> Vec<(&'static str, Box<dyn Rasteriser>)> {
    let mut found: Vec<(&str, Box<dyn Rasteriser>)> = vec![("software", Box::new(SoftwareRasteriser))];
    if let Ok(gpu) = Gpu::headless().and_then(|gpu| GpuRasteriser::new(&gpu)) {
        found.push(("gpu", Box::new(gpu)));
    }
    found
}

/// The same photo of towns of more and more faces.
fn by_faces(c: &mut Criterion) {
    let mut group = c.benchmark_group("sort by faces");
    for faces in [1_000, 10_000, 100_000] {
        let town = large::town(faces);
        group.throughput(Throughput::Elements(faces.into()));
        for (name, rasteriser) in &rasterisers() {
            group.bench_function(BenchmarkId::new(*name, faces), |b| {
                b.iter(|| sort(&town, rasteriser.as_ref()));
            });
        }
    }
}

/// The same pixels with more and more surfaces one behind the other.
fn by_depth(c: &mut Criterion) {
    let mut group = c.benchmark_group("sort by panes");
    for panes in [4, 16, 64] {
        let fan = large::fan(panes);
        group.throughput(Throughput::Elements(panes.into()));
        for (name, rasteriser) in &rasterisers() {
            group.bench_function(BenchmarkId::new(*name, panes), |b| {
                b.iter(|| sort(&fan, rasteriser.as_ref()));
            });
        }
    }
}

/// The same street in larger and larger photos.
fn by_pixels(c: &mut Criterion) {
    let mut group = c.benchmark_group("sort by pixels");
    for width in [480, 960, 1920] {
        let street = large::street(1000).resized(width);
        group.throughput(Throughput::Elements(u64::from(width) * u64::from(street.camera.height)));
        for (name, rasteriser) in &rasterisers() {
            group.bench_function(BenchmarkId::new(*name, width), |b| {
                b.iter(|| sort(&street, rasteriser.as_ref()));
            });
        }
    }
}

/// From a view to visibility layers: all pairs at once, with cycles cut and parts gathered, against
/// the passes of stencil peeling alone, which get their working set for nothing. A street of 1000
/// faces, seven deep where there are houses.
fn graph_against_stencil(c: &mut Criterion) {
    let mut group = c.benchmark_group("graph against stencil");
    let street = large::street(1000).resized(960);
    let (model, options, task) = (&street.model, Options::default(), Task::silent());
    let view = ProjectedModel::new(model, &street.camera, &street.pose);
    for (name, rasteriser) in &rasterisers() {
        let draw = || rasteriser.fragments(&view, options.tolerance, &task).expect("the rasteriser works");
        let is_working = |presence: &Presence| *presence == Presence::Working;
        let working: Vec<bool> = draw().presence.iter().map(is_working).collect();
        group.bench_function(format!("{name}/graph"), |b| {
            b.iter(|| {
                let drawn = draw();
                let runs = Runs::new(drawn.lists);
                let resolved = resolve_cycles(&view, &runs, &working, &drawn.occlusions, &options);
                gather_parts(model, &view, &runs, &resolved, &options, &ResolvedConstraints::default())
            });
        });
        group.bench_function(format!("{name}/stencil"), |b| {
            b.iter(|| {
                let peeled = rasteriser.stencil_peeling(&view, options.tolerance, &working, &task);
                peeled.expect("the rasteriser works")
            });
        });
    }
}

/// Image layers for more and more elements.
fn clustering(c: &mut Criterion) {
    let mut group = c.benchmark_group("cluster by elements");
    for faces in [1_000, 10_000, 40_000] {
        let town = large::town(faces);
        let sorted = sort(&town, &SoftwareRasteriser);
        let bounds = bounds_of_elements(&sorted);
        let photo = PixelRect { x: 0, y: 0, w: town.camera.width, h: town.camera.height };
        group.throughput(Throughput::Elements(bounds.len() as u64));
        group.bench_function(bounds.len().to_string(), |b| {
            b.iter(|| {
                cluster(
                    &town.model,
                    &sorted.layers,
                    &bounds,
                    photo,
                    &Options::default(),
                    &ElementConstraints::default(),
                )
            });
        });
    }
}

/// The bounding boxes of whole faces, as the sort itself takes them.
fn bounds_of_elements(sorted: &Sorted) -> Vec<PixelRect> {
    let item_bounds = |node: usize| sorted.view.items[sorted.nodes.list[node].item as usize].bounds;
    let of_element = |nodes: &[quadratura::testing::layers::nodes::NodeId]| {
        let bounds = nodes.iter().map(|node| item_bounds(node.0 as usize));
        bounds.reduce(|a, b| a.union(&b)).expect("an element holds a node at least")
    };
    sorted.layers.elements.iter().map(|element| of_element(&element.nodes)).collect()
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2));
    targets = by_faces, by_depth, by_pixels, graph_against_stencil, clustering
}
criterion_main!(benches);
