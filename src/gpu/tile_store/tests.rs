//! Tests of texture memory on a device: lookups are compared with the pyramids that the tiles were cut from.

use std::sync::{Arc, Mutex};

use wgpu::{BufferUsages, ShaderStages};

use super::{Loaded, TileStore};
use crate::bindings::BindingKind;
use crate::device::Gpu;
use crate::renderer::texels::{self, TexelGroup};
use crate::{bindings, readback};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::scene::PhotoId;
use quadratura_base::scene::synthetic::Rng;
use quadratura_base::task::{Event, Task};
use quadratura_projection::pyramid::{Pyramid, PyramidOptions, pyramid};
use quadratura_projection::residency::{NOTHING, SLOT_BITS, TextureRecord, TileRequest};
use quadratura_projection::tiles;
use quadratura_projection::{LayerTexture, LayerTextureId, LayerTexturePixels, Projector, Sources, Texels};
use quadratura_projection::{Storage, TextureOptions};
use quadratura_view::srgb::Srgb;

/// A compute shader that does one lookup per thread.
const LOOK: &str = "
const STORED = false;
@group(0) @binding(0) var<storage, read> asked: array<Asked>;
@group(0) @binding(1) var<storage, read_write> found: array<vec4f>;
struct Asked { at: vec2f, layer_texture: u32, level: u32, log_size: vec2u }
@compute @workgroup_size(64)
fn look(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&asked) { return; }
    let ask = asked[id.x];
    found[id.x] = texel_at_level(TexturePlacement(ask.layer_texture, vec2f(), ask.log_size), ask.at, ask.level);
}";

/// A lookup; `at` is in texels of level 0 from the layer texture's corner.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Asked {
    at: [f32; 2],
    layer_texture: u32,
    level: u32,
    log_size: [u32; 2],
}

/// Sheets made by a test, with counts of how often each was read.
struct Made {
    layer_textures: Mutex<Vec<LayerTexturePixels>>,
    reads: Mutex<Vec<u32>>,
}

impl Texels for Made {
    fn layer_texture(&self, layer_texture: LayerTextureId) -> Result<LayerTexturePixels> {
        self.reads.lock().unwrap()[layer_texture.0 as usize] += 1;
        Ok(self.layer_textures.lock().unwrap()[layer_texture.0 as usize].clone())
    }
}

/// Makes content in blots, so that most layer textures have empty tiles.
fn painted(rect: PixelRect, rng: &mut Rng) -> LayerTexturePixels {
    let blots: Vec<[f64; 3]> = (0..3)
        .map(|_| [rng.unit() * f64::from(rect.w), rng.unit() * f64::from(rect.h), rng.between(2.0, 50.0)])
        .collect();
    let waves = [rng.between(0.02, 0.2), rng.between(0.02, 0.2), rng.between(0.0, 6.0)];
    let mut pixels = LayerTexturePixels { rect, rgba: Vec::new(), needed: Vec::new(), matte: None };
    for (y, x) in (0..rect.h).flat_map(|y| (0..rect.w).map(move |x| (f64::from(y), f64::from(x)))) {
        let inside = blots.iter().any(|[bx, by, r]| (x - bx).abs() < *r && (y - by).abs() < 0.7 * r);
        let value =
            |phase: f64| (127.0 + 120.0 * (waves[0] * x + waves[1] * y + waves[2] + phase).sin()) as u8;
        let texel = if inside { [value(0.0), value(1.0), value(2.0), 255] } else { [0; 4] };
        pixels.rgba.extend(texel);
        pixels.needed.push(u8::from(inside));
    }
    pixels
}

struct Scene {
    sources: Sources,
    made: Arc<Made>,
    pyramids: Vec<Pyramid>,
}

fn scene(seed: u64, sizes: &[[u32; 2]]) -> Scene {
    let mut rng = Rng::new(seed);
    let rects = sizes.iter().map(|&[w, h]| PixelRect { x: rng.whole(0, 90) as i32 - 50, y: -7, w, h });
    let rects: Vec<_> = rects.collect();
    let layer_textures: Vec<_> = rects.iter().map(|rect| painted(*rect, &mut rng)).collect();
    let make = |(rect, pixels): (&PixelRect, &LayerTexturePixels)| {
        pyramid(*rect, pixels, &PyramidOptions::default())
    };
    let pyramids = rects.iter().zip(&layer_textures).map(make).collect();
    let photo = Projector {
        name: "a".into(),
        camera: Pinhole { width: 64, height: 64, fx: 64.0, fy: 64.0, cx: 32.0, cy: 32.0 },
        pose: Pose { rotation: glam::DMat3::IDENTITY, translation: glam::DVec3::ZERO },
    };
    let layer_texture = |(i, rect): (usize, &PixelRect)| LayerTexture {
        photo: PhotoId(0),
        id: i.to_string(),
        rect: *rect,
        see_through: false,
    };
    let sources = Sources {
        photos: vec![photo],
        layer_textures: rects.iter().enumerate().map(layer_texture).collect(),
        ..Sources::default()
    };
    let made =
        Made { reads: Mutex::new(vec![0; layer_textures.len()]), layer_textures: Mutex::new(layer_textures) };
    Scene { sources, made: Arc::new(made), pyramids }
}

/// The constant of the shader: the distance from a texel's centre within which the texel is taken as it is.
const DEAD: f32 = 0.02;

const SIZES: [[u32; 2]; 8] =
    [[256, 256], [512, 64], [64, 128], [32, 32], [8, 2], [1, 1], [16, 256], [1024, 512]];

/// Opens a device; `None` on a machine without an adapter.
fn gpu() -> Option<Gpu> {
    crate::left_out::on_adapter(Gpu::headless())
}

fn store(gpu: &Gpu, scene: &Scene, slots: u64) -> TileStore {
    let options = TextureOptions {
        budget_bytes: slots * Storage::Plain.slot_bytes(),
        cache_bytes: 1 << 18,
        ..TextureOptions::default()
    };
    TileStore::new(gpu, &scene.sources, scene.made.clone(), options).unwrap()
}

/// Does lookups with the renderer's own code.
fn look(gpu: &Gpu, store: &TileStore, asked: &[Asked]) -> Vec<[f32; 4]> {
    let texels = TexelGroup::new(gpu, ShaderStages::COMPUTE);
    let own = bindings::layout(gpu, "look", ShaderStages::COMPUTE, &[BindingKind::Read, BindingKind::Write]);
    let module = bindings::shader(gpu, "look", &[LOOK, texels::SOURCE].concat());
    let pipeline = bindings::compute(gpu, "look", &module, &[&own, &texels.layout]);
    let asked_buffer = bindings::filled(gpu, "asked", asked, BufferUsages::STORAGE);
    let words = 4 * asked.len() as u64;
    let found = bindings::storage(gpu, "found", words, true);
    let resources = [asked_buffer.as_entire_binding(), found.as_entire_binding()];
    let group = bindings::bind(gpu, "look", &own, &resources);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.set_bind_group(1, &texels.bind(gpu, store, false), &[]);
    pass.dispatch_workgroups((asked.len() as u32).div_ceil(64), 1, 1);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    let [words] = readback::read(gpu, [(&found, 0..words)]).unwrap();
    bytemuck::cast_slice(&words).to_vec()
}

/// Returns the level of the tile that a lookup reads, according to the page tables.
fn level_found(store: &TileStore, ask: &Asked) -> Option<u32> {
    let record = store.residency.records()[ask.layer_texture as usize];
    let shape = store.residency.shape(LayerTextureId(ask.layer_texture));
    let [columns, rows] = shape.tiles(ask.level);
    let [x, y] = [0, 1].map(|i| (ask.at[i] / (64 << ask.level.min(shape.log[i])) as f32) as u32);
    let tile = y.min(rows - 1) * columns + x.min(columns - 1);
    let entry = store.residency.entries()[(record.offsets[ask.level as usize] + tile) as usize];
    (entry != NOTHING).then(|| ask.level + (entry >> SLOT_BITS))
}

/// Computes what `texel_at_level` should return.
fn expected(pyramid: &Pyramid, level: u32, at: [f32; 2]) -> [f32; 4] {
    let held = &pyramid.levels[level as usize];
    let size = [0, 1].map(|i| pyramid.shape.size(level)[i] as f32 / pyramid.shape.size(0)[i] as f32);
    let at = [0, 1].map(|i| at[i] * size[i] - 0.5);
    // Near a texel's centre the texel is taken as it is.
    let share = |i: usize| ((at[i] - at[i].floor() - DEAD) / (1.0 - 2.0 * DEAD)).clamp(0.0, 1.0);
    let mut sum = [0.0; 4];
    for corner in 0..4 {
        let step = [corner % 2, corner / 2];
        let texel = [0, 1].map(|i| at[i].floor() as i32 + step[i]);
        let weight = |i: usize| if step[i] == 1 { share(i) } else { 1.0 - share(i) };
        let rect = held.rect;
        let inside =
            (rect.x..rect.right()).contains(&texel[0]) && (rect.y..rect.bottom()).contains(&texel[1]);
        if inside {
            let from = held.index(texel[0], texel[1]);
            let [r, g, b, a]: [u8; 4] = held.rgba[from..from + 4].try_into().unwrap();
            let values = [r, g, b].map(|value| Srgb::tables().linear(value));
            let values = [values[0], values[1], values[2], f32::from(a) / 255.0];
            (0..4).for_each(|c| sum[c] += weight(0) * weight(1) * values[c]);
        }
    }
    sum
}

/// Makes lookups around content, within half a texel, as renderers do.
fn ask(scene: &Scene, rng: &mut Rng, level: impl Fn(&Pyramid, &mut Rng) -> u32) -> Vec<Asked> {
    let mut asked = Vec::new();
    for (layer_texture, pyramid) in (0..).zip(&scene.pyramids) {
        let texels: Vec<(i32, i32)> =
            pyramid.levels[0].content.iter().flat_map(|(y, run)| run.clone().map(move |x| (x, y))).collect();
        for _ in 0..texels.len().min(400) {
            let (x, y) = texels[rng.whole(0, texels.len() as u32 - 1) as usize];
            let at = [x, y].map(|at| (f64::from(at) + rng.unit()) as f32);
            let level = level(pyramid, rng);
            asked.push(Asked { at, layer_texture, level, log_size: pyramid.shape.log });
        }
    }
    asked
}

/// A sampler's fractions have 8 bits, and colours here range from 0 to 1.
const TOLERANCE: f32 = 2.5 / 256.0;

fn check(scene: &Scene, store: &TileStore, asked: &[Asked], found: &[[f32; 4]]) {
    for (ask, found) in asked.iter().zip(found) {
        let level = level_found(store, ask).unwrap_or_else(|| panic!("{ask:?} is served by nothing"));
        let expected = expected(&scene.pyramids[ask.layer_texture as usize], level, ask.at);
        let error = (0..4).map(|c| (expected[c] - found[c]).abs()).fold(0.0, f32::max);
        assert!(error <= TOLERANCE, "{error} at {ask:?}, level {level}: {found:?}, {expected:?}");
    }
}

fn any_level(pyramid: &Pyramid, rng: &mut Rng) -> u32 {
    rng.whole(0, pyramid.shape.levels() - 1)
}

#[test]
fn lookups_find_every_sheets_own_texels_at_every_level() {
    let Some(gpu) = gpu() else { return };
    for seed in 0..3 {
        let scene = scene(seed, &SIZES);
        let mut store = store(&gpu, &scene, 4000);
        let loaded = store.load_all(&Task::silent()).unwrap();
        assert_eq!((loaded.layer_textures, loaded.left_out), (SIZES.len(), 0));
        let asked = ask(&scene, &mut Rng::new(seed + 50), any_level);
        let found = look(&gpu, &store, &asked);
        check(&scene, &store, &asked, &found);
        assert!(asked.iter().all(|ask| level_found(&store, ask) == Some(ask.level)));
    }
}

#[test]
fn compressed_tiles_are_nearly_the_same() {
    let Some(gpu) = gpu().filter(Gpu::has_compression) else { return };
    let scene = scene(2, &SIZES);
    let options = TextureOptions { storage: Storage::Compressed, ..TextureOptions::default() };
    let mut store = TileStore::new(&gpu, &scene.sources, scene.made.clone(), options).unwrap();
    store.load_all(&Task::silent()).unwrap();
    let asked = ask(&scene, &mut Rng::new(8), any_level);
    let found = look(&gpu, &store, &asked);
    let error = |(ask, found): (&Asked, &[f32; 4])| {
        let expected = expected(&scene.pyramids[ask.layer_texture as usize], ask.level, ask.at);
        (0..4).map(|c| (expected[c] - found[c]).powi(2)).sum::<f32>() / 4.0
    };
    let mean = asked.iter().zip(&found).map(error).sum::<f32>() / asked.len() as f32;
    // Colours on a closed curve, hard edges and ramps of confidence are the worst case for a block, which
    // holds one line. Photos have a hundredth of this error; misplaced tiles would cause a tenth.
    assert!(mean < 1e-2, "mean square {mean}");
}

#[test]
fn under_a_tiny_budget_every_lookup_is_served_by_some_level() {
    let Some(gpu) = gpu() else { return };
    let scene = scene(7, &SIZES);
    for slots in [9, 20, 45] {
        let mut store = store(&gpu, &scene, slots);
        let loaded = store.load_all(&Task::silent()).unwrap();
        assert!(loaded.left_out > 0 && store.statistics().resident_tiles <= slots);
        let asked = ask(&scene, &mut Rng::new(slots), |_, _| 0);
        check(&scene, &store, &asked, &look(&gpu, &store, &asked));
        // The view now needs a single layer texture, which gets finer.
        let own: Vec<Asked> = asked.iter().filter(|ask| ask.layer_texture == 0).copied().collect();
        let levels = |store: &TileStore| own.iter().filter_map(|ask| level_found(store, ask)).sum::<u32>();
        let before = levels(&store);
        store.load(&[TileRequest::all(LayerTextureId(0))], &Task::silent()).unwrap();
        assert!(levels(&store) <= before, "{slots} slots");
        check(&scene, &store, &own, &look(&gpu, &store, &own));
    }
}

#[test]
fn a_changed_sheet_writes_only_its_changed_tiles() {
    let Some(gpu) = gpu() else { return };
    let mut scene = scene(3, &[[512, 512], [64, 64]]);
    let mut store = store(&gpu, &scene, 4000);
    // The small layer texture is loaded first, because the cache keeps the last one.
    store.load(&[TileRequest::all(LayerTextureId(1))], &Task::silent()).unwrap();
    store.load(&[TileRequest::all(LayerTextureId(0))], &Task::silent()).unwrap();
    let mut pixels = scene.made.layer_texture(LayerTextureId(0)).unwrap();
    let unchanged = store.replace_texture(LayerTextureId(0), &pixels).unwrap();
    assert_eq!(unchanged.tiles, 0);
    let painted = pixels.rgba.chunks(4).position(|texel| texel[3] > 0).expect("there is content");
    pixels.rgba[4 * painted] ^= 0x80;
    let changed = store.replace_texture(LayerTextureId(0), &pixels).unwrap();
    // One texel changes: at each of the levels 0 to 3 its tile and at most three that have it in their
    // gutter, and the tail.
    assert!((5..=17).contains(&changed.tiles), "{changed:?}");
    scene.pyramids[0] = pyramid(scene.sources.layer_textures[0].rect, &pixels, &PyramidOptions::default());
    let asked = ask(&scene, &mut Rng::new(9), any_level);
    check(&scene, &store, &asked, &look(&gpu, &store, &asked));
}

#[test]
fn what_lies_on_the_device_is_not_read_again() {
    let scene = scene(5, &SIZES);
    let mut store = store(&Gpu::noop(), &scene, 4000);
    let task = Task::silent();
    let coarse = store.load(&[TileRequest::from_level(LayerTextureId(7), 2)], &task).unwrap();
    assert!(
        coarse.layer_textures == 1 && coarse.tiles > 4,
        "there is room for the finer ones, too: {coarse:?}"
    );
    store.load_all(&task).unwrap();
    for wants in [
        vec![TileRequest::all(LayerTextureId(3))],
        vec![TileRequest::from_level(LayerTextureId(7), 1), TileRequest::all(LayerTextureId(0))],
    ] {
        let again = store.load(&wants, &task).unwrap();
        assert_eq!((again.tiles, again.layer_textures), (0, 0));
    }
    assert!(scene.made.reads.lock().unwrap().iter().all(|reads| *reads == 1));
}

#[test]
fn requests_that_do_not_fit_are_refused_without_being_read_again_and_coarser_only_when_that_is_asked_for() {
    let scene = scene(5, &SIZES);
    let mut store = store(&Gpu::noop(), &scene, 40);
    let task = Task::silent();
    let all: Vec<TileRequest> =
        (0..SIZES.len() as u32).map(|i| TileRequest::all(LayerTextureId(i))).collect();
    let refused = store.load_if_it_fits(&all, &task).unwrap();
    assert!(refused.left_out > 0 && refused.layer_textures == SIZES.len(), "{refused:?}");
    let again = store.load_if_it_fits(&all, &task).unwrap();
    assert_eq!(again, Loaded { left_out: refused.left_out, ..Loaded::default() });
    let coarse = store.load(&all, &task).unwrap();
    assert_eq!(coarse.left_out, refused.left_out);
    let one = [TileRequest::from_level(LayerTextureId(7), 2)];
    assert_eq!(store.load_if_it_fits(&one, &task).unwrap().left_out, 0);
    assert!(store.holds(&one));
}

/// The layer textures of a test, one of which cannot be read.
struct Torn(Arc<Made>, LayerTextureId);

impl Texels for Torn {
    fn layer_texture(&self, layer_texture: LayerTextureId) -> Result<LayerTexturePixels> {
        if layer_texture == self.1 {
            Err(Error::Request("torn".into()))
        } else {
            self.0.layer_texture(layer_texture)
        }
    }
}

#[test]
fn a_sheet_that_cannot_be_read_is_told_once_and_serves_nothing_while_the_others_go_on() {
    let scene = scene(6, &SIZES);
    let torn = LayerTextureId(2);
    let texels = Arc::new(Torn(scene.made.clone(), torn));
    let mut store = TileStore::new(&Gpu::noop(), &scene.sources, texels, TextureOptions::default()).unwrap();
    let notes: Arc<Mutex<Vec<String>>> = Arc::default();
    let recorded = notes.clone();
    let task = Task::new(move |event| {
        if let Event::Note { text, .. } = event {
            recorded.lock().unwrap().push(text.to_string());
        }
    });
    let wants: Vec<TileRequest> = (0..SIZES.len() as u32)
        .map(|layer_texture| TileRequest::all(LayerTextureId(layer_texture)))
        .collect();
    let loaded = store.load(&wants, &task).unwrap();
    assert_eq!((loaded.layer_textures, loaded.left_out), (SIZES.len() - 1, 0));
    store.load(&[TileRequest::all(torn)], &task).unwrap();
    let notes = notes.lock().unwrap().clone();
    assert!(notes.len() == 1 && notes[0].contains("torn"), "{notes:?}");
    assert_eq!(store.unreadable().iter().collect::<Vec<_>>(), [&torn]);
    let served = |layer_texture: LayerTextureId| {
        let record = store.residency.records()[layer_texture.0 as usize];
        store.residency.entries()[record.offsets[record.levels as usize - 1] as usize] != NOTHING
    };
    assert!(
        (0..SIZES.len() as u32)
            .map(LayerTextureId)
            .all(|layer_texture| served(layer_texture) == (layer_texture != torn))
    );
    // The layer texture is readable again and textures its faces.
    store.replace_texture(torn, &scene.made.layer_texture(torn).unwrap()).unwrap();
    store.load(&[TileRequest::all(torn)], &task).unwrap();
    assert!(store.unreadable().is_empty() && store.residency.resident_of(torn).len() > 1);
}

#[test]
fn tables_and_slots_are_alike_in_rust_and_in_wgsl() {
    let says = |line: String| assert!(texels::SOURCE.contains(&line), "the shader does not say {line:?}");
    says(format!("const TILE: f32 = {}.0;", tiles::TILE));
    says(format!("const GUTTER: f32 = {}.0;", tiles::GUTTER));
    says(format!("const SLOT: f32 = {}.0;", tiles::SLOT));
    says(format!("const TAIL_LOG: u32 = {}u;", tiles::TAIL.ilog2()));
    says(format!("const SLOT_BITS: u32 = {SLOT_BITS}u;"));
    says(format!("const NOTHING: u32 = {NOTHING:#x}u;"));
    says(format!("const TEXTURE_WORDS: u32 = {}u;", size_of::<TextureRecord>() / 4));
    says(format!("const MATTE_WORD: u32 = {}u;", std::mem::offset_of!(TextureRecord, matte) / 4));
    says(format!("const FIRST_OFFSET: u32 = {}u;", std::mem::offset_of!(TextureRecord, offsets) / 4));
    says(format!("const DEAD: f32 = {DEAD};"));
    for ([x, y], log) in tiles::TAIL_SPOTS.into_iter().zip(0..) {
        let case = if log == 5 { "default".to_string() } else { format!("case {log}u") };
        says(format!("{case}: {{ return vec2f({x}.0, {y}.0); }}"));
    }
}
