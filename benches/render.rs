//! Frames, by what they cost: photos, image layers, pixels, blending; and a layer that changes.
//!
//! `cargo bench --bench render`; one group alone: `cargo bench --bench render -- photos`.

use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec3, dvec3};
use quadratura::render::TextureOptions;
use quadratura::task::Task;
use quadratura::testing::geometry::{Pinhole, PixelRect};
use quadratura::testing::gpu::{Gpu, Renderer, TileStore};
use quadratura::testing::projection::relief::Relief;
use quadratura::testing::projection::{
    Domain, Gains, LayerTexture, LayerTextureId, LayerTexturePixels, Projector, Renders, Server, Sources,
    Texels,
};
use quadratura::testing::scene::synthetic::{Rng, centred, large, look_at};
use quadratura::testing::scene::{Model, PhotoId};
use quadratura::testing::view::{Mode, Quality, Shot};

/// Photos of the town are this large; their layer textures cover them.
const PHOTO: [u32; 2] = [1024, 512];

/// A square of the town, photographed from all around: every photo serves every face whose front it
/// sees, from one of `layers` layer textures.
struct Town {
    model: Arc<Model>,
    sources: Arc<Sources>,
}

impl Town {
    fn new(photos: u32, layers: u32) -> Self {
        let model = large::town(600).model;
        let mut sources = Sources::default();
        let mut rng = Rng::new(5);
        for photo in 0..photos {
            let turn = std::f64::consts::TAU * f64::from(photo) / f64::from(photos);
            let pose = look_at(eye(turn, rng.between(10.0, 14.0)), dvec3(0.0, 0.0, 4.0));
            let camera = centred(PHOTO[0], PHOTO[1], 700.0);
            sources.photos.push(Projector { name: format!("{photo}"), camera, pose });
            for layer in 0..layers {
                let rect = PixelRect { x: 0, y: 0, w: PHOTO[0], h: PHOTO[1] };
                sources.layer_textures.push(LayerTexture {
                    photo: PhotoId(photo),
                    id: format!("{photo} {layer}"),
                    rect,
                    see_through: false,
                });
            }
        }
        for face in model.face_ids() {
            let start = sources.servers.len() as u32;
            for photo in 0..photos {
                let eye = sources.photos[photo as usize].pose.center_in_world();
                if model.face(face).plane.signed_distance(eye) > 0.0 {
                    let layer_texture = LayerTextureId(photo * layers + face.0 % layers);
                    let photo = PhotoId(photo);
                    sources.servers.push(Server {
                        layer_texture,
                        photo,
                        back: false,
                        pinned: false,
                        domain: Domain::Whole,
                    });
                }
            }
            sources.of_face.push(Range { start, end: sources.servers.len() as u32 });
        }
        Self { model, sources: Arc::new(sources) }
    }

    fn renderer(&self, gpu: &Gpu) -> Renderer {
        let texels = Arc::new(Noise { layer_textures: self.sources.layer_textures.len() as u32 });
        let tiles = TileStore::new(gpu, &self.sources, texels, TextureOptions::default())
            .expect("page tables fit into any device");
        let gains = Gains::none(self.sources.photos.len());
        let (model, sources) = (self.model.clone(), self.sources.clone());
        Renderer::new(gpu, model, sources, gains, &Relief::default(), tiles).expect("shaders are valid")
    }
}

fn eye(turn: f64, height: f64) -> DVec3 {
    dvec3(40.0 * turn.cos(), 40.0 * turn.sin(), height)
}

/// Sheets full of colours. Those of one photo share its pixels among themselves by columns.
struct Noise {
    layer_textures: u32,
}

impl Texels for Noise {
    fn layer_texture(&self, layer_texture: LayerTextureId) -> quadratura::Result<LayerTexturePixels> {
        Ok(noise(layer_texture.0 % self.layer_textures))
    }
}

fn noise(seed: u32) -> LayerTexturePixels {
    let rect = PixelRect { x: 0, y: 0, w: PHOTO[0], h: PHOTO[1] };
    let mut rng = Rng::new(u64::from(seed));
    let pixels = rect.area() as usize;
    let mut rgba = Vec::with_capacity(4 * pixels);
    for _ in 0..pixels {
        let [r, g, b, ..] = rng.bits().to_le_bytes();
        rgba.extend([r, g, b, 255]);
    }
    LayerTexturePixels { rect, rgba, needed: vec![1; pixels], matte: None }
}

fn shot(width: u32, height: u32, mode: Mode) -> Shot {
    let camera: Pinhole = centred(width, height, 0.7 * f64::from(width));
    let mut shot = Shot::new(camera, look_at(eye(0.1, 12.0), dvec3(0.0, 0.0, 4.0)));
    shot.quality = Quality::Preview;
    shot.blend.mode = mode;
    shot
}

/// Frames of 960 x 540 where nothing else is said, tables and read-back included.
fn frame(c: &mut Criterion, name: &str, parameter: String, town: &Town, shot: &Shot) {
    let Ok(gpu) = Gpu::headless() else { return };
    let mut renderer = town.renderer(&gpu);
    let mut group = c.benchmark_group(name);
    let pixels = u64::from(shot.camera.width) * u64::from(shot.camera.height);
    group.throughput(Throughput::Elements(pixels));
    group.bench_function(BenchmarkId::from_parameter(parameter), |b| {
        b.iter(|| renderer.picture(shot, &Task::silent()).expect("the adapter works"));
    });
    group.finish();
}

fn by_photos(c: &mut Criterion) {
    for photos in [20, 100, 400] {
        let shot = shot(960, 540, Mode::default());
        frame(c, "frame by photos", photos.to_string(), &Town::new(photos, 1), &shot);
    }
}

fn by_layers(c: &mut Criterion) {
    for layers in [1, 8, 32] {
        let shot = shot(960, 540, Mode::default());
        frame(c, "frame by layers of a photo", layers.to_string(), &Town::new(10, layers), &shot);
    }
}

fn by_pixels(c: &mut Criterion) {
    let town = Town::new(20, 1);
    for (width, height) in [(480, 270), (960, 540), (1920, 1080)] {
        let shot = shot(width, height, Mode::default());
        frame(c, "frame by pixels", format!("{width}x{height}"), &town, &shot);
    }
}

fn by_mode(c: &mut Criterion) {
    let town = Town::new(20, 1);
    for mode in Mode::ALL {
        frame(c, "frame by mode", mode.to_string(), &town, &shot(960, 540, mode));
    }
    let mut finest = shot(960, 540, Mode::default());
    finest.quality = Quality::Final;
    frame(c, "frame by mode", "final".into(), &town, &finest);
}

/// From another picture for one layer texture to the frame that shows it.
fn change(c: &mut Criterion) {
    let Ok(gpu) = Gpu::headless() else { return };
    let mut renderer = Town::new(20, 1).renderer(&gpu);
    let shot = shot(480, 270, Mode::default());
    let task = Task::silent();
    renderer.picture(&shot, &task).expect("the adapter works");
    let pictures = [noise(1), noise(2)];
    let mut turn = 0;
    c.bench_function("a changed layer until it is on the device", |b| {
        b.iter(|| {
            turn = 1 - turn;
            renderer
                .tiles_mut()
                .replace_texture(LayerTextureId(0), &pictures[turn])
                .expect("the adapter works")
        });
    });
}

criterion_group! {
    name = render;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(3));
    targets = by_photos, by_layers, by_pixels, by_mode, change
}
criterion_main!(render);
