//! `build` on small invented sites, from photos on disk to stacks on disk: what the files hold.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use quadratura::task::Task;
use quadratura::testing::document::{Decisions, Stack};
use quadratura::testing::io::stack_store::StackStore;
use quadratura::testing::layers::{BoxShape, Method, Options, SoftwareRasteriser};
use quadratura::testing::scene::synthetic::{
    Modeller, Rng, Scene, Truth, camera_is_world, centred, closed_form, random,
};
use quadratura::testing::scene::{Photo, Site};
use quadratura::testing::stacks::build::{BuildOptions, Built, build};

/// A photo of one colour a pixel, RGBA: noise, so that any pixel from elsewhere is noticed. With
/// `holes`, some pixels are not valid.
struct Noise {
    width: u32,
    height: u32,
    rgba: Vec<u16>,
}

impl Noise {
    fn new(seed: u64, width: u32, height: u32, holes: bool) -> Self {
        let mut rng = Rng::new(seed);
        let mut rgba = Vec::new();
        for _ in 0..width * height {
            rgba.extend([0; 3].map(|_| rng.whole(0, 65535) as u16));
            rgba.push(if holes && rng.chance(0.2) { rng.whole(0, 60000) as u16 } else { 65535 });
        }
        Self { width, height, rgba }
    }

    fn save(&self, path: &Path, bits: u8, alpha: bool) {
        let pixels = self.rgba.chunks_exact(4).map(|p| if alpha { p } else { &p[..3] });
        let bytes: Vec<u8> = match bits {
            8 => pixels.flatten().map(|v| (v >> 8) as u8).collect(),
            _ => pixels.flatten().flat_map(|v| v.to_be_bytes()).collect(),
        };
        let file = fs::File::create(path).unwrap();
        let mut encoder = png::Encoder::new(file, self.width, self.height);
        encoder.set_color(if alpha { png::ColorType::Rgba } else { png::ColorType::Rgb });
        encoder.set_depth(if bits == 8 { png::BitDepth::Eight } else { png::BitDepth::Sixteen });
        encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
    }

    fn pixel(&self, x: u32, y: u32, bits: u8) -> [u16; 4] {
        let at = ((y * self.width + x) * 4) as usize;
        let full = if bits == 8 { 255 } else { 65535 };
        let [r, g, b, a]: [u16; 4] = self.rgba[at..at + 4].try_into().unwrap();
        let shift = if bits == 8 { 8 } else { 0 };
        [r >> shift, g >> shift, b >> shift, if a == 65535 { full } else { 0 }]
    }
}

/// A decoded PNG with 4 or 1 channels, samples widened to 16 bits.
fn decode(path: &Path) -> (u32, u32, Vec<u16>) {
    let mut decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap()));
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let samples = match info.bit_depth {
        png::BitDepth::Sixteen => bytes.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect(),
        _ => bytes.iter().map(|&b| b.into()).collect(),
    };
    (info.width, info.height, samples)
}

/// A project folder with one photo of a scene.
struct Bench {
    folder: tempfile::TempDir,
    site: Site,
    noise: Noise,
    bits: u8,
}

impl Bench {
    fn new(scene: &Scene, bits: u8, alpha: bool) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let noise = Noise::new(7, scene.camera.width, scene.camera.height, alpha);
        let file = folder.path().join("photo.png");
        noise.save(&file, bits, alpha);
        let photo = Photo { name: "photo.png".into(), file, ..scene.photo() };
        Self { folder, site: Site { photos: vec![photo], model: scene.model.clone() }, noise, bits }
    }

    fn build(&self, layers: Options, threads: usize) -> Built {
        self.decided(layers, &Decisions::default(), threads)
    }

    fn decided(&self, layers: Options, decisions: &Decisions, threads: usize) -> Built {
        let (decisions, photos) = (decisions.clone(), Vec::new());
        let options = BuildOptions { layers, decisions, photos, memory: 1 << 30, threads, force: false };
        let store = StackStore::new(self.folder.path());
        let built = build(&self.site, &store, &SoftwareRasteriser, &options, &Task::silent());
        built.unwrap().pop().unwrap()
    }

    fn stack_folder(&self) -> PathBuf {
        StackStore::new(self.folder.path()).folder("photo.png")
    }

    /// Every file of the stack with its bytes.
    fn bytes(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        fn walk(folder: &Path, found: &mut BTreeMap<PathBuf, Vec<u8>>, root: &Path) {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    walk(&path, found, root);
                } else {
                    found.insert(path.strip_prefix(root).unwrap().into(), fs::read(&path).unwrap());
                }
            }
        }
        let mut found = BTreeMap::new();
        walk(&self.stack_folder(), &mut found, &self.stack_folder());
        found
    }

    /// A transparent pixel is black, or has the colour of the photo there, which is valid.
    fn check_transparent(&self, pixel: &[u16], x: i32, y: i32) {
        if pixel[3] > 0 || pixel.iter().all(|&s| s == 0) {
            return;
        }
        let truth = self.noise.pixel(x as u32, y as u32, self.bits);
        assert!(truth[3] > 0, "colour where the photo is not valid");
        assert!(pixel[..3] == truth[..3] || pixel[..3] == darkest_blue(self.bits), "{pixel:?} for {truth:?}");
    }

    /// Stacks all layers back to front over nothing, and checks every layer's own promises.
    fn check_content(&self, stack: &Stack) {
        let (width, height) = (self.noise.width, self.noise.height);
        let mut picture = vec![[0u16; 4]; (width * height) as usize];
        for layer in stack.image_layers.iter().rev() {
            let (w, h, rgba) = decode(&self.stack_folder().join(&layer.file));
            let (_, _, needed) = decode(&self.stack_folder().join(&layer.needed_file));
            assert_eq!((w, h), (layer.rect.w, layer.rect.h));
            assert_eq!(needed.iter().filter(|&&n| n > 0).count() as u64, layer.texels_used);
            let opaque = rgba.chunks_exact(4).filter(|p| p[3] > 0).count();
            assert_eq!(opaque as u64, layer.texels_visible);
            for (i, (pixel, needed)) in rgba.chunks_exact(4).zip(needed).enumerate() {
                let x = layer.rect.x + (i as u32 % w) as i32;
                let y = layer.rect.y + (i as u32 / w) as i32;
                let inside = (0..width as i32).contains(&x) && (0..height as i32).contains(&y);
                assert!(inside || (pixel[3] == 0 && needed == 0), "texels outside the photo");
                assert!(needed > 0 || pixel[3] == 0, "opaque where no element is");
                self.check_transparent(pixel, x, y);
                if needed > 0 {
                    let at = (y as u32 * width + x as u32) as usize;
                    if pixel[3] > 0 {
                        picture[at] = pixel.try_into().unwrap();
                    }
                }
            }
        }
        for [y, x0, x1] in &stack.leftovers {
            for x in *x0..*x1 {
                let at = (y * width + x) as usize;
                assert_eq!(picture[at], [0; 4], "leftovers are where nothing else is shown");
                picture[at] = self.noise.pixel(x, *y, self.bits);
            }
        }
        for (i, &pixel) in picture.iter().enumerate() {
            let truth = self.noise.pixel(i as u32 % width, i as u32 / width, self.bits);
            let expected = if truth[3] > 0 { truth } else { [0; 4] };
            assert_eq!(pixel, expected, "pixel {i}");
        }
    }
}

/// What black becomes beside an outline.
fn darkest_blue(bits: u8) -> [u16; 3] {
    [0, 0, if bits == 8 { 1 } else { 257 }]
}

fn rich_scene() -> Scene {
    random::boxes(11, 12)
}

#[test]
fn stacked_layers_give_the_photo_back_bit_for_bit_wherever_it_is_valid() {
    for scene in closed_form::all().into_iter().chain([rich_scene()]) {
        for (bits, alpha) in [(8, false), (16, true)] {
            let bench = Bench::new(&scene, bits, alpha);
            let stack = bench.build(Options::default(), 1).stack.unwrap();
            assert!(!stack.image_layers.is_empty(), "{}", scene.name);
            bench.check_content(&stack);
        }
    }
}

#[test]
fn so_they_do_with_every_option() {
    let bench = Bench::new(&rich_scene(), 8, true);
    let options = [
        Options { published: true, ..Options::default() },
        Options { boxes: BoxShape::Exact, margin: 3, ..Options::default() },
        Options { largest_side: 64, ..Options::default() },
        Options { largest_side: 64, boxes: BoxShape::Exact, margin: 0, ..Options::default() },
        Options { method: Method::Stencil, ..Options::default() },
        Options { reach: 0.0, ..Options::default() },
        Options { reach: 1.0, min_visible: 0, ..Options::default() },
    ];
    for options in options {
        let built = bench.build(options.clone(), 1);
        assert!(!built.up_to_date, "other options, another stack");
        let stack = built.stack.unwrap();
        // The published order may be wrong, but every texel that is opaque shows the photo's pixel.
        bench.check_content(&stack);
        if options.largest_side == 64 {
            assert!(stack.image_layers.iter().all(|l| l.rect.w <= 64 && l.rect.h <= 64));
        }
    }
}

/// A wall that leaves this many pixels of a photo of 160 x 120 px free at the right edge.
fn wall_beside(free: f64) -> Scene {
    let mut modeller = Modeller::new();
    let right = (80.0 - free) / 12.0 - 1e-3;
    modeller.object("wall").screen(10.0, [-20.0, -20.0, right, 20.0]);
    let (camera, pose) = (centred(160, 120, 120.0), camera_is_world());
    Scene { name: "beside".into(), model: modeller.finish(), camera, pose, truth: Truth::Unknown }
}

#[test]
fn the_surroundings_are_the_last_layer_behind_all_others_and_hide_nothing() {
    let bench = Bench::new(&wall_beside(40.0), 8, false);
    let stack = bench.build(Options::default(), 1).stack.unwrap();
    let [wall, surroundings] = &stack.image_layers[..] else { panic!("{:?}", stack.image_layers) };
    assert_eq!((wall.name.as_str(), surroundings.name.as_str()), ("wall", "surroundings"));
    assert_eq!((wall.order, surroundings.order), (0, 1));
    let [_, behind] = &stack.visibility_layers[..] else { panic!("{:?}", stack.visibility_layers) };
    assert_eq!((behind.len(), behind[0].object.as_str(), behind[0].faces.len()), (1, "[surroundings]", 0));
    assert!(stack.occlusions.is_empty(), "they are behind everything, so no occlusion names them");
    // 40 columns are free, and 4 % of 160 pixels lie behind the wall.
    assert_eq!((surroundings.texels_visible, surroundings.texels_used), (40 * 120, (40 + 6) * 120));
    let all = bench.build(Options { reach: 1.0, ..Options::default() }, 1).stack.unwrap();
    assert_eq!((all.image_layers[1].texels_visible, all.image_layers[1].texels_used), (40 * 120, 160 * 120));
    assert_ne!(all.inputs, stack.inputs);
    let pixels = |stack: &Stack| stack.image_layers[0].texels_visible + stack.image_layers[1].texels_visible;
    assert_eq!([pixels(&stack), pixels(&all)], [160 * 120; 2]);
}

#[test]
fn a_model_that_covers_everything_leaves_no_surroundings_and_a_crack_is_a_leftover() {
    let bench = Bench::new(&wall_beside(-1.0), 8, false);
    let stack = bench.build(Options::default(), 1).stack.unwrap();
    assert_eq!((stack.image_layers.len(), stack.visibility_layers.len()), (1, 1));
    assert!(stack.leftovers.is_empty() && !stack.surroundings_left_over);
    // The surroundings of a large photo are a layer from 64 pixels on; here they have a fifth of what they need.
    let crack = Options { min_visible: 200, min_share: 0.2, ..Options::default() };
    let bench = Bench::new(&wall_beside(1.0), 8, false);
    let stack = bench.build(crack.clone(), 1).stack.unwrap();
    assert_eq!((stack.image_layers.len(), stack.leftovers.len()), (1, 120));
    assert!(stack.surroundings_left_over);
    bench.check_content(&stack);
    let whole = bench.build(Options { min_visible: 0, ..crack }, 1).stack.unwrap();
    assert_eq!((whole.image_layers.len(), whole.leftovers.len()), (2, 0));
}

#[test]
fn where_the_photo_is_not_valid_there_are_no_surroundings_and_a_cave_has_none() {
    let scene = wall_beside(40.0);
    let bench = Bench::new(&scene, 8, true);
    let stack = bench.build(Options::default(), 1).stack.unwrap();
    let valid = (0..160 * 120).filter(|i| i % 160 >= 120 && bench.noise.pixel(i % 160, i / 160, 8)[3] > 0);
    assert_eq!(stack.image_layers[1].texels_visible, valid.count() as u64);
    bench.check_content(&stack);
    // Masked where no surface is: nothing of the surroundings is left.
    let mask = bench.folder.path().join("mask.png");
    let mut encoder = png::Encoder::new(fs::File::create(&mask).unwrap(), 160, 120);
    encoder.set_color(png::ColorType::Grayscale);
    let grey: Vec<u8> = (0..160 * 120).map(|i| if i % 160 >= 120 { 0 } else { 255 }).collect();
    encoder.write_header().unwrap().write_image_data(&grey).unwrap();
    let mut masked = bench;
    masked.site.photos[0].masks = vec![mask];
    let stack = masked.build(Options::default(), 1).stack.unwrap();
    assert_eq!((stack.image_layers.len(), stack.surroundings_left_over), (1, false));
}

#[test]
fn a_photo_without_any_surface_is_nothing_but_surroundings() {
    let mut scene = wall_beside(40.0);
    let away = glam::DMat3::from_rotation_y(std::f64::consts::PI);
    scene.pose.rotation = away * scene.pose.rotation;
    let bench = Bench::new(&scene, 8, false);
    let stack = bench.build(Options::default(), 1).stack.unwrap();
    let [only] = &stack.image_layers[..] else { panic!("{:?}", stack.image_layers) };
    assert_eq!((only.order, only.texels_visible, only.texels_used), (0, 160 * 120, 160 * 120));
    bench.check_content(&stack);
}

#[test]
fn the_layer_of_the_surroundings_can_be_renamed() {
    let bench = Bench::new(&wall_beside(40.0), 8, false);
    let decisions = decided(r#"{"names":[{"name":"Sky","of":[{"object":"[surroundings]"}]}]}"#);
    let stack = bench.decided(Options::default(), &decisions, 1).stack.unwrap();
    let names: Vec<_> = stack.image_layers.iter().map(|layer| layer.name.as_str()).collect();
    assert_eq!(names, ["wall", "Sky"]);
}

#[test]
fn the_same_input_gives_the_same_bytes_for_any_number_of_threads() {
    let scene = rich_scene();
    let bytes = [1, 2, 5].map(|threads| {
        let bench = Bench::new(&scene, 8, false);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bench.build(Options::default(), threads)).stack.unwrap();
        bench.bytes()
    });
    assert!(bytes[0].len() > 4);
    assert_eq!(bytes[0], bytes[1]);
    assert_eq!(bytes[0], bytes[2]);
}

#[test]
fn nothing_is_rebuilt_until_something_changes() {
    let mut bench = Bench::new(&rich_scene(), 8, false);
    assert!(!bench.build(Options::default(), 1).up_to_date);
    assert!(bench.build(Options::default(), 1).up_to_date);
    assert!(!bench.build(Options { tolerance: 2e-4, ..Options::default() }, 1).up_to_date);
    let mut model = (*bench.site.model).clone();
    model.vertices.iter_mut().for_each(|v| *v += DVec3::new(0.01, 0.0, 0.0));
    bench.site.model = Arc::new(model);
    assert!(!bench.build(Options { tolerance: 2e-4, ..Options::default() }, 1).up_to_date);
    Noise::new(8, bench.noise.width, bench.noise.height, false).save(&bench.site.photos[0].file, 8, false);
    assert!(!bench.build(Options { tolerance: 2e-4, ..Options::default() }, 1).up_to_date);
}

#[test]
fn a_fault_in_one_photo_does_not_stop_the_others() {
    let mut bench = Bench::new(&rich_scene(), 8, false);
    let missing = bench.folder.path().join("missing.png");
    let lost = Photo { name: "lost.png".into(), file: missing, ..bench.site.photos[0].clone() };
    bench.site.photos.insert(0, lost);
    let (layers, decisions, photos) = (Options::default(), Decisions::default(), Vec::new());
    let options = BuildOptions { layers, decisions, photos, memory: 1, threads: 4, force: false };
    let store = StackStore::new(bench.folder.path());
    let built = build(&bench.site, &store, &SoftwareRasteriser, &options, &Task::silent()).unwrap();
    assert!(built[0].stack.as_ref().is_err_and(|e| e.to_string().contains("missing.png")));
    assert!(built[1].stack.is_ok());
    assert!(store.current("photo.png").unwrap().is_some());
}

#[test]
fn uv_from_world_takes_a_surface_to_its_texel() {
    // A photo with an off-centre principal point, and rectangles inside and outside of it.
    let scene = closed_form::portrait();
    let bench = Bench::new(&scene, 8, false);
    let stack = bench.build(Options::default(), 1).stack.unwrap();
    let photo = &bench.site.photos[0];
    for layer in &stack.image_layers {
        for p in scene.model.vertices.iter().filter(|p| photo.pose.camera_from_world(**p).z > 0.0) {
            let image = photo.camera.image_from_camera(photo.pose.camera_from_world(*p)).unwrap();
            let dot = |row: [f64; 4]| row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3];
            let [u, v, q] = layer.uv_from_world.map(dot);
            let x = u / q * f64::from(layer.rect.w) + f64::from(layer.rect.x);
            let y = v / q * f64::from(layer.rect.h) + f64::from(layer.rect.y);
            // The formula of design section 3 promises 1e-6 px.
            assert!((x - image.x).abs() < 1e-6 && (y - image.y).abs() < 1e-6, "{x} {y} {image}");
        }
    }
}

fn decided(text: &str) -> Decisions {
    let mut decisions = Decisions::default();
    decisions.set("photo.png", serde_json::from_str(text).unwrap());
    decisions
}

#[test]
fn a_new_name_is_given_without_making_a_layer_again_and_taken_back_without_a_trace() {
    let bench = Bench::new(&rich_scene(), 8, false);
    let plain = bench.build(Options::default(), 1).stack.unwrap();
    let bytes = bench.bytes();
    let element = plain.image_layers[1].elements[0].index();
    let known_by = plain.visibility_layers.iter().flatten().nth(element).unwrap().known_by();
    let of = serde_json::to_string(&known_by).unwrap();
    let decisions = decided(&format!(r#"{{"names":[{{"name":"Bell tower","of":[{of}]}}]}}"#));

    let named = bench.decided(Options::default(), &decisions, 1);
    assert!(named.up_to_date, "only its name is new");
    let (was, now) = (&plain.image_layers[1], &named.stack.unwrap().image_layers[1]);
    assert_eq!((now.name.as_str(), now.own_name.as_ref()), ("Bell tower", Some(&was.name)));
    assert_eq!(now.id, was.id, "files that were exported before still come home");
    assert!(bench.decided(Options::default(), &decisions, 1).up_to_date);
    bench.build(Options::default(), 1);
    assert_eq!(bench.bytes(), bytes);

    fs::remove_dir_all(bench.stack_folder()).unwrap();
    let fresh = bench.decided(Options::default(), &decisions, 1);
    assert!(!fresh.up_to_date && fresh.stack.unwrap().image_layers[1].name == "Bell tower");
}

#[test]
fn decisions_about_a_photos_layers_build_it_again_and_what_does_not_hold_is_told() {
    let bench = Bench::new(&rich_scene(), 8, false);
    let plain = bench.build(Options::default(), 1).stack.unwrap();
    let all: Vec<String> = plain
        .visibility_layers
        .iter()
        .flatten()
        .map(|element| serde_json::to_string(&element.known_by()).unwrap())
        .collect();
    let merge = decided(&format!(r#"{{"merge":[[{}]]}}"#, all.join(",")));
    let built = bench.decided(Options::default(), &merge, 1);
    assert!(!built.up_to_date);
    let merged = built.stack.unwrap();
    assert_eq!(merged.inputs(), plain.inputs);
    assert!(
        merged.unsatisfied.iter().any(|note| note.contains("lies in front of a part of")),
        "{:?}",
        merged.unsatisfied
    );
    assert!(bench.decided(Options::default(), &merge, 1).up_to_date);

    let gone = decided(r#"{"split":[[[{"object":"nowhere"}]]],"options":{"margin":3}}"#);
    let stack = bench.decided(Options::default(), &gone, 1).stack.unwrap();
    assert!(
        stack.unsatisfied[0].contains("nowhere is not textured by this photo"),
        "{:?}",
        stack.unsatisfied
    );
    let other = bench.build(Options { margin: 3, ..Options::default() }, 1).stack.unwrap();
    let ids = |stack: &Stack| stack.image_layers.iter().map(|l| l.id.clone()).collect::<Vec<_>>();
    assert_eq!(ids(&stack), ids(&other), "an option of the photo's own");
}
