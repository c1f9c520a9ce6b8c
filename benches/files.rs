//! Writing and reading layered files: PSD, XCF and PNG, 24 layers of a photo of six million pixels.
//!
//! `cargo bench --bench files`. Elements per second are pixels; the format's own compression is
//! part of the time, the disk is not: what is written goes to memory, what is read lies there.

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use quadratura::testing::geometry::PixelRect;
use quadratura::testing::layered_files::psd::{self, PsdVariant};
use quadratura::testing::layered_files::xcf::{self, XcfVersion};
use quadratura::testing::layered_files::{
    Depth, FormatFit, Group, LayerNode, LayeredDocument, PixelLayer, Raster, png, read_layered,
};
use quadratura::testing::scene::Samples;
use quadratura::testing::scene::synthetic::Rng;
use rayon::prelude::*;

const WIDTH: u32 = 3072;
const HEIGHT: u32 = 2048;
const LAYERS: u32 = 24;

/// What a photo is to a compressor: slow gradients under noise of two or three bits.
fn photo_like(width: u32, height: u32) -> Vec<u8> {
    let mut rng = Rng::new(3);
    let mut samples = Vec::with_capacity(4 * width as usize * height as usize);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let noise = rng.bits();
        let shade = |k: u32| ((x + k * y) / (9 + k)) as u8;
        let grain = |k: u32| (noise >> (8 * k)) as u8 % 6;
        samples.extend([0, 1, 2].map(|k| shade(k).wrapping_add(grain(k))));
        samples.push(255);
    }
    samples
}

/// An image layer as they are: opaque in a triangle, transparent elsewhere.
fn layer_raster(width: u32, height: u32) -> Raster {
    let mut samples = photo_like(width, height);
    for (pixel, rgba) in samples.chunks_exact_mut(4).enumerate() {
        let (x, y) = (pixel as u32 % width, pixel as u32 / width);
        if x * height > y * width {
            rgba.fill(0);
        }
    }
    Raster::new(width, height, Samples::U8(samples))
}

fn layer(number: u32, raster: &Arc<Raster>) -> PixelLayer<'static> {
    let (raster, w, h) = (raster.clone(), raster.width(), raster.height());
    let rect = PixelRect { x: (number * 97 % 2000) as i32, y: (number * 61 % 1000) as i32, w, h };
    PixelLayer::new(format!("surface [{number}]"), rect, Box::new(move || Ok(raster.clone())))
}

fn document(photo: &Arc<Raster>, raster: &Arc<Raster>) -> LayeredDocument<'static> {
    let layers = (0..LAYERS).map(|number| layer(number, raster)).collect();
    let merged = photo.clone();
    LayeredDocument {
        width: WIDTH,
        height: HEIGHT,
        depth: Depth::Eight,
        icc: None,
        key: "0".into(),
        title: "photo".into(),
        nodes: vec![LayerNode::Group(Group { name: "order 0".into(), layers })],
        merged: Box::new(move || Ok(merged.clone())),
    }
}

fn writing(c: &mut Criterion) {
    let photo = Arc::new(Raster::new(WIDTH, HEIGHT, Samples::U8(photo_like(WIDTH, HEIGHT))));
    let raster = Arc::new(layer_raster(512, 1024));
    let mut group = c.benchmark_group("write");
    let layer_pixels = u64::from(LAYERS) * 512 * 1024;

    group.throughput(Throughput::Elements(layer_pixels + u64::from(WIDTH * HEIGHT)));
    let document = document(&photo, &raster);
    group.bench_function("psd", |b| {
        b.iter(|| {
            let fit = psd::write(Cursor::new(Vec::new()), Path::new("bench.psd"), &document, PsdVariant::Psd);
            assert_eq!(fit.expect("memory takes it"), FormatFit::Whole);
        });
    });

    group.throughput(Throughput::Elements(layer_pixels));
    group.bench_function("xcf", |b| {
        b.iter(|| xcf_bytes(&document));
    });
    group.bench_function("png layers, in parallel", |b| {
        b.iter(|| {
            (0..LAYERS).into_par_iter().for_each(|_| {
                png::write_rgba(&mut Vec::new(), &raster, None).expect("memory takes it");
            });
        });
    });
}

fn xcf_bytes(document: &LayeredDocument) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let fit = xcf::write(&mut out, Path::new("bench.xcf"), document, XcfVersion::Three);
    assert_eq!(fit.expect("memory takes it"), FormatFit::Whole);
    out.into_inner()
}

/// All layers, as an import reads them that finds every one changed; and what it needs to know beforehand.
fn reading(c: &mut Criterion) {
    let raster = Arc::new(layer_raster(512, 1024));
    let document = document(&Arc::new(Raster::blank(WIDTH, HEIGHT, Depth::Eight)), &raster);
    let folder = tempfile::tempdir().expect("there is a temporary folder");
    let [psd_file, xcf_file] = ["bench.psd", "bench.xcf"].map(|name| folder.path().join(name));
    let mut psd_bytes = Cursor::new(Vec::new());
    psd::write(&mut psd_bytes, &psd_file, &document, PsdVariant::Psd).expect("memory takes it");
    std::fs::write(&psd_file, psd_bytes.into_inner()).expect("the folder takes it");
    std::fs::write(&xcf_file, xcf_bytes(&document)).expect("the folder takes it");
    let mut group = c.benchmark_group("read");
    for (name, file) in [("psd", &psd_file), ("xcf", &xcf_file)] {
        group.throughput(Throughput::Elements(u64::from(LAYERS) * 512 * 1024));
        group.bench_function(name, |b| {
            b.iter(|| {
                let document = read_layered(file).expect("it was written");
                document
                    .layers
                    .par_iter()
                    .for_each(|layer| drop(layer.pixels.read().expect("it was written")));
            });
        });
        group.throughput(Throughput::Elements(u64::from(LAYERS)));
        group.bench_function(format!("{name}, layers without pixels"), |b| {
            b.iter(|| read_layered(file).expect("it was written"));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2));
    targets = writing, reading
}
criterion_main!(benches);
