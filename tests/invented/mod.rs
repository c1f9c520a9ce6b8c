//! Invented stacks with their photos, for tests of what is made of stacks: no model, no camera that
//! means anything, but pixels whose every value is known.

use std::fs::File;
use std::path::Path;

use glam::{DMat3, DVec3};
use quadratura::testing::document::stack::{STACK_VERSION, StackCamera, StackPhoto};
use quadratura::testing::document::{Element, ImageLayer, Stack};
use quadratura::testing::geometry::{Pinhole, PixelRect, Pose};
use quadratura::testing::io::stack_store::StackStore;
use quadratura::testing::layered_files::png::write_rgba;
use quadratura::testing::layered_files::{Depth, Raster};
use quadratura::testing::layers::ElementIndex;
use quadratura::testing::scene::{FaceIndex, Photo, Samples};

/// What to invent.
pub struct Plan {
    pub photo: &'static str,
    pub width: u32,
    pub height: u32,
    pub depth: Depth,
    /// Image layers, spread over `orders` orders.
    pub layers: u32,
    pub orders: u32,
    /// Another number, other pixels and places.
    pub seed: u32,
    /// Pixels at the photo's left edge that are not valid.
    pub invalid: u32,
    /// Its colour profile.
    pub icc: Option<Vec<u8>>,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            photo: "nord/tür 1.png",
            width: 157,
            height: 101,
            depth: Depth::Eight,
            layers: 9,
            orders: 4,
            seed: 1,
            invalid: 0,
            icc: None,
        }
    }
}

/// An ellipse: what an image layer covers.
struct Shape {
    centre: (f64, f64),
    radius: (f64, f64),
}

/// Writes a photo and its stack into the folder `project`.
pub fn write(project: &Path, plan: &Plan) -> (Photo, Stack) {
    let file = project.join(format!("photo {}.png", plan.seed));
    let raster = photo(plan);
    write_rgba(File::create(&file).unwrap(), &raster, plan.icc.as_deref()).unwrap();
    (photo_of(plan.photo, plan.width, plan.height, &file), write_stack(project, plan, &raster))
}

/// A photo with a camera that means nothing.
fn photo_of(name: &str, width: u32, height: u32, file: &Path) -> Photo {
    let f = f64::from(width);
    let pose = Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };
    let camera = Pinhole { width, height, fx: f, fy: f, cx: f / 2.0, cy: f64::from(height) / 2.0 };
    Photo { name: name.into(), camera, pose, file: file.into(), masks: Vec::new(), exposure: None }
}

/// Smooth colours with noise, opaque where valid.
fn photo(plan: &Plan) -> Raster {
    let mut rng = plan.seed;
    let mut samples = Vec::new();
    for y in 0..plan.height {
        for x in 0..plan.width {
            let full = if x < plan.invalid { 0 } else { 65535 };
            for slope in [300 * x + 10 * y, 200 * y, 40 * (x + y) + 5000] {
                samples.push((slope % 60000 + roll(&mut rng, 5000)).min(full) as u16);
            }
            samples.push(full as u16);
        }
    }
    let samples = match plan.depth {
        Depth::Eight => Samples::U8(samples.iter().map(|s| (s >> 8) as u8).collect()),
        Depth::Sixteen => Samples::U16(samples),
    };
    Raster::new(plan.width, plan.height, samples)
}

fn roll(rng: &mut u32, sides: u32) -> u32 {
    *rng = rng.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    (*rng >> 8) % sides
}

/// Writes a stack over a photo.
fn write_stack(project: &Path, plan: &Plan, photo: &Raster) -> Stack {
    let shapes = shapes(plan);
    let writer = StackStore::new(project).begin(plan.photo).unwrap();
    let mut layers = Vec::new();
    for (index, shape) in shapes.iter().enumerate() {
        let needed: Vec<bool> = pixels(plan).map(|(x, y)| shape.covers(x, y)).collect();
        let visible: Vec<bool> = pixels(plan)
            .map(|(x, y)| {
                shape.covers(x, y)
                    && photo.has_colour(x, y)
                    && !shapes[..index].iter().any(|nearer| nearer.covers(x, y))
            })
            .collect();
        let layer = layer(plan, index as u32, &needed, &visible);
        write_files(writer.folder(), &layer, photo, &needed, &visible);
        layers.push(layer);
    }
    writer.commit(stack(plan, layers)).unwrap().stack
}

fn pixels(plan: &Plan) -> impl Iterator<Item = (u32, u32)> {
    let width = plan.width;
    (0..plan.height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

fn shapes(plan: &Plan) -> Vec<Shape> {
    let mut rng = plan.seed.wrapping_mul(77);
    let mut between = |low: f64, high: f64| low + (high - low) * f64::from(roll(&mut rng, 1000)) / 1000.0;
    let (w, h) = (f64::from(plan.width), f64::from(plan.height));
    let shape = |_| Shape {
        centre: (between(0.0, w), between(0.0, h)),
        radius: (between(0.03 * w, 0.3 * w), between(0.03 * h, 0.4 * h)),
    };
    (0..plan.layers).map(shape).collect()
}

impl Shape {
    fn covers(&self, x: u32, y: u32) -> bool {
        let dx = (f64::from(x) + 0.5 - self.centre.0) / self.radius.0;
        let dy = (f64::from(y) + 0.5 - self.centre.1) / self.radius.1;
        dx * dx + dy * dy <= 1.0
    }
}

fn layer(plan: &Plan, index: u32, needed: &[bool], visible: &[bool]) -> ImageLayer {
    let used: Vec<_> = pixels(plan).zip(needed).filter(|(_, needed)| **needed).map(|(p, _)| p).collect();
    let needed_rect = used
        .iter()
        .map(|&(x, y)| PixelRect::from_edges(x as i32, y as i32, x as i32 + 1, y as i32 + 1))
        .reduce(|a, b| a.union(&b))
        .expect("the shape covers something");
    let margin = 2 + index as i32;
    let names =
        ["Säule ö", "a wall [old] with a very long name that goes on and on and on", "tree", "門 портал"];
    ImageLayer {
        id: format!("t{:03}x{}", index, plan.seed),
        name: names[index as usize % names.len()].into(),
        own_name: None,
        order: index * plan.orders / plan.layers,
        rect: PixelRect {
            x: needed_rect.x - margin,
            y: needed_rect.y - margin,
            w: (needed_rect.w + 2 * margin as u32).next_power_of_two(),
            h: (needed_rect.h + 2 * margin as u32).next_power_of_two(),
        },
        elements: vec![ElementIndex(index)],
        file: format!("{index}.png"),
        needed_file: format!("{index}-needed.png"),
        needed_rect,
        texels_used: used.len() as u64,
        texels_visible: visible.iter().filter(|v| **v).count() as u64,
        fill: None,
        uv_from_world: [[0.0; 4]; 3],
    }
}

fn write_files(folder: &Path, layer: &ImageLayer, photo: &Raster, needed: &[bool], visible: &[bool]) {
    let rect = layer.rect;
    let index = |x: i32, y: i32| {
        let inside = x >= 0 && y >= 0 && x < photo.width() as i32 && y < photo.height() as i32;
        inside.then(|| y as usize * photo.width() as usize + x as usize)
    };
    let places: Vec<_> =
        (rect.y..rect.bottom()).flat_map(|y| (rect.x..rect.right()).map(move |x| index(x, y))).collect();
    let colour = |at: &Option<usize>| at.filter(|at| visible[*at]);
    let samples = match photo.samples() {
        Samples::U8(s) => Samples::U8(picked(s, places.iter().map(colour))),
        Samples::U16(s) => Samples::U16(picked(s, places.iter().map(colour))),
    };
    let file = File::create(folder.join(&layer.file)).unwrap();
    write_rgba(file, &Raster::new(rect.w, rect.h, samples), None).unwrap();
    let white: Vec<bool> = places.iter().map(|at| at.is_some_and(|at| needed[at])).collect();
    write_mask(&folder.join(&layer.needed_file), rect.w, rect.h, &white);
}

fn picked<T: Copy + Default>(samples: &[T], places: impl Iterator<Item = Option<usize>>) -> Vec<T> {
    let pixel = |at: usize| [samples[4 * at], samples[4 * at + 1], samples[4 * at + 2], samples[4 * at + 3]];
    places.flat_map(|at| at.map_or([T::default(); 4], pixel)).collect()
}

fn write_mask(file: &Path, width: u32, height: u32, white: &[bool]) {
    let mut encoder = png::Encoder::new(File::create(file).unwrap(), width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    let byte =
        |bits: &[bool]| bits.iter().enumerate().fold(0u8, |byte, (i, bit)| byte | u8::from(*bit) << (7 - i));
    let bytes: Vec<u8> = white.chunks(width as usize).flat_map(|row| row.chunks(8).map(byte)).collect();
    encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
}

fn stack(plan: &Plan, image_layers: Vec<ImageLayer>) -> Stack {
    let object = |i: u32| Element {
        object: format!("object {i}"),
        faces: vec![FaceIndex(i)],
        pieces: vec![],
        back: vec![],
        ..Element::default()
    };
    Stack {
        version: STACK_VERSION,
        method: Default::default(),
        inputs: format!("invented from {}", plan.seed),
        photo: StackPhoto { name: plan.photo.into(), width: plan.width, height: plan.height },
        camera: StackCamera { K: [[0.0; 3]; 3], R: [[0.0; 3]; 3], t: [0.0; 3] },
        visibility_layers: vec![(0..plan.layers).map(object).collect()],
        surfaces: vec![],
        pieces: vec![],
        occlusions: vec![],
        forgiven: vec![],
        unresolved: Vec::new(),
        texels: image_layers.iter().map(|layer| layer.rect.area()).sum(),
        texels_used: image_layers.iter().map(|layer| layer.texels_used).sum(),
        texels_unmerged: 0,
        bytes: 0,
        fill: None,
        untextured: Default::default(),
        notes: vec![],
        unsatisfied: vec![],
        leftovers: vec![],
        spared: vec![],
        surroundings_left_over: false,
        linked: vec![],
        tolerated: vec![],
        counts: Default::default(),
        in_use: Default::default(),
        image_layers,
    }
}
