//! Texture memory, by what it costs: pyramids by megapixel, tiles cut and brought to the device, a changed
//! layer.
//!
//! `cargo bench --bench textures`; one group alone: `cargo bench --bench textures -- pyramid`.

use std::sync::Arc;
use std::time::Duration;

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use quadratura::Result;
use quadratura::render::TextureOptions;
use quadratura::task::Task;
use quadratura::testing::geometry::PixelRect;
use quadratura::testing::gpu::{Gpu, TileStore};
use quadratura::testing::projection::pyramid::{PyramidOptions, pyramid};
use quadratura::testing::projection::tiles::{Occupancy, SLOT, TileKey};
use quadratura::testing::projection::{LayerTexture, LayerTextureId, LayerTexturePixels, Sources, Texels};
use quadratura::testing::scene::PhotoId;

/// A layer of a photo: two thirds of the texels in several parts with ragged outlines.
fn layer(side: u32) -> LayerTexturePixels {
    let rect = PixelRect { x: 0, y: 0, w: side, h: side };
    let mut pixels = LayerTexturePixels { rect, rgba: Vec::new(), needed: Vec::new(), matte: None };
    for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
        let ragged = (f64::from(x) / 90.0 + (f64::from(y) / 7.0).sin() * 0.1).sin();
        let held = ragged + (f64::from(y) / 130.0).sin() > -0.5;
        let value = ((x * 7) ^ (y * 13)) as u8;
        pixels.rgba.extend([value, value / 2, 255 - value, if held { 255 } else { 0 }]);
        pixels.needed.push(u8::from(held));
    }
    pixels
}

/// The same picture for every layer texture.
struct Same(LayerTexturePixels);

impl Texels for Same {
    fn layer_texture(&self, _: LayerTextureId) -> Result<LayerTexturePixels> {
        Ok(self.0.clone())
    }
}

fn by_megapixel(c: &mut Criterion) {
    let mut group = c.benchmark_group("pyramid by texels");
    for side in [256u32, 1024, 2048] {
        let pixels = layer(side);
        group.throughput(Throughput::Elements(pixels.rect.area()));
        let options = PyramidOptions::default();
        group.bench_function(BenchmarkId::from_parameter(side), |b| {
            b.iter(|| pyramid(pixels.rect, &pixels, &options));
        });
    }
}

/// From a pyramid to slots, without a device.
fn packing(c: &mut Criterion) {
    let mut group = c.benchmark_group("tile packing");
    let pixels = layer(2048);
    let levels = pyramid(pixels.rect, &pixels, &PyramidOptions::default());
    group.bench_function("which tiles are occupied", |b| b.iter(|| Occupancy::from_pyramid(&levels)));
    let tiles: Vec<[u32; 2]> = Occupancy::from_pyramid(&levels).tiles(0).collect();
    let mut slot = vec![0; (4 * SLOT * SLOT) as usize];
    group.throughput(Throughput::Elements(tiles.len() as u64));
    group.bench_function("cut tiles", |b| {
        b.iter(|| {
            for &[x, y] in &tiles {
                levels.cut(
                    TileKey { layer_texture: LayerTextureId(0), level: 0, x, y },
                    &mut slot,
                    4 * SLOT as usize,
                );
            }
        });
    });
}

fn store(gpu: &Gpu, layer_textures: u32, pixels: &LayerTexturePixels) -> TileStore {
    let layer_texture =
        |i: u32| LayerTexture { photo: PhotoId(0), id: i.to_string(), rect: pixels.rect, see_through: false };
    let sources =
        Sources { layer_textures: (0..layer_textures).map(layer_texture).collect(), ..Sources::default() };
    TileStore::new(gpu, &sources, Arc::new(Same(pixels.clone())), TextureOptions::default())
        .expect("the device works")
}

/// Sheets from decoded pixels to the device; a frame that needs nothing new; a layer that was painted on.
fn upload(c: &mut Criterion) {
    let Ok(gpu) = Gpu::headless() else { return };
    let task = Task::silent();
    let load = |store: &mut TileStore| store.load_all(&task).expect("the device works");
    let mut group = c.benchmark_group("upload");
    let pixels = layer(1024);
    let tiles = load(&mut store(&gpu, 16, &pixels)).tiles;
    group.throughput(Throughput::Elements(tiles as u64));
    group.bench_function("tiles of 16 layers", |b| {
        let fresh = || store(&gpu, 16, &pixels);
        b.iter_batched_ref(fresh, load, BatchSize::PerIteration);
    });
    group.throughput(Throughput::Elements(1));
    let large = layer(2048);
    let mut loaded = store(&gpu, 2, &large);
    load(&mut loaded);
    group.bench_function("nothing new", |b| b.iter(|| load(&mut loaded)));
    let mut painted = large.clone();
    group.bench_function("a changed layer of 4 Mpx", |b| {
        b.iter(|| {
            let at = 4 * (1024 * 2048 + 700);
            painted.rgba[at..at + 400].iter_mut().for_each(|value| *value ^= 0x40);
            loaded.replace_texture(LayerTextureId(0), &painted).expect("the device works")
        });
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2));
    targets = by_megapixel, packing, upload
}
criterion_main!(benches);
