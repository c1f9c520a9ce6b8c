//! The images of plants on the device (`shaders/flake.wgsl`): the samples of a species, and the images that a view shows.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, Vec2, Vec3, Vec4, Vec4Swizzles};
use wgpu::{Buffer, BufferUsages};

use super::extent::extent;
use crate::bindings;
use crate::device::Gpu;
use quadratura_base::geometry::PixelRect;
use quadratura_foliage::{ImageInView, MBuffer, MSample, Plant, PlantImages, depth_from_stored};

/// The WGSL source that is put before the passes over images.
const SOURCE: &str = include_str!("../../../../shaders/flake.wgsl");

/// The words of a sample.
const WORDS: usize = 3;
/// The most columns and rows of an image whose samples fit into them.
const MOST_SIDE: u32 = 1 << 12;
/// The samples of a block: of an image, except for those of its last one.
pub const BLOCK: u32 = 256;
/// The side of the parts of an image whose samples come together, in pixels: of one layer of samples they would be a block.
const PART_SIDE: u32 = 16;

/// An image in a view in the layout of the shader (`FlakeImage`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct FlakeImageWords {
    pub right: [f32; 4],
    pub down: [f32; 4],
    pub forward: [f32; 4],
    pub normal_right: [f32; 3],
    pub delta: f32,
    pub normal_down: [f32; 3],
    pub depth_step: f32,
    pub normal_forward: [f32; 3],
    pub first_depth: f32,
    pub through: [f32; 3],
    pub half: f32,
    pub gain: [f32; 3],
    pub length: f32,
    pub first: u32,
    pub count: u32,
    pub before: u32,
    pub of_direction: u32,
    pub of_part: u32,
    pub tree: u32,
    pub species: u32,
    pub first_block: u32,
}

impl FlakeImageWords {
    /// Returns the pixels in which the points of its samples may be, in a view with these focal lengths and this centre, in pixels: those around
    /// the box of the image with all depths that a sample can have. It is wider than any picture where the box reaches behind the viewer.
    pub fn rect(&self, lens: [Vec2; 2]) -> PixelRect {
        let side = self.half * self.delta;
        let low = Vec3::new(-side, -side, self.first_depth);
        let high = Vec3::new(side, side, self.first_depth + self.depth_step * f32::from(u16::MAX));
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let rows = [self.right, self.down, self.forward].map(Vec4::from_array);
        let along = |of: &dyn Fn(&Vec4) -> f32| Vec3::from_array(rows.each_ref().map(of));
        let middle = along(&|row| row.xyz().dot(middle) + row.w);
        let half = along(&|row| row.xyz().abs().dot(half));
        let far = Vec2::splat(1e6);
        let [low, high] = match extent([middle - half, middle + half], lens) {
            Some(extent) => extent.map(|at| at.floor().clamp(-far, far)),
            None => [-far, far],
        };
        PixelRect::from_edges(low.x as i32, low.y as i32, high.x as i32 + 1, high.y as i32 + 1)
    }
}

/// The rows that are drawn together in the layout of the shader (`FlakeRows`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct FlakeRowsWords {
    pub first: u32,
    pub count: u32,
    pub width: u32,
    pub reach: u32,
}

impl FlakeRowsWords {
    /// Uploads them.
    pub fn on_device(&self, gpu: &Gpu) -> Buffer {
        bindings::filled(gpu, "rows", std::slice::from_ref(self), BufferUsages::UNIFORM)
    }
}

/// The box around neighbouring samples of an image: the lowest and the highest column, row and stored depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Block {
    low: [u16; 3],
    high: [u16; 3],
}

impl Block {
    /// Encloses samples.
    fn around(samples: &[FlakeSample]) -> Self {
        let all = samples.iter().map(|(column, row, sample)| [*column, *row, sample.depth]);
        let nothing = Self { low: [u16::MAX; 3], high: [0; 3] };
        all.fold(nothing, |Self { low, high }, at| Self {
            low: [0, 1, 2].map(|axis| low[axis].min(at[axis])),
            high: [0, 1, 2].map(|axis| high[axis].max(at[axis])),
        })
    }

    fn words(&self) -> [u32; 3] {
        [0, 1, 2].map(|axis| u32::from(self.low[axis]) | u32::from(self.high[axis]) << 16)
    }

    /// Returns the depth in the view of its nearest point, of an image in the view.
    pub fn nearest(&self, image: &FlakeImageWords) -> f32 {
        let end = |axis: usize, stored: u16, side: f32| match axis {
            2 => image.first_depth + image.depth_step * f32::from(stored),
            _ => (f32::from(stored) + side - image.half) * image.delta,
        };
        let along = |axis: usize| {
            let (low, high) = (end(axis, self.low[axis], 0.0), end(axis, self.high[axis], 1.0));
            (image.forward[axis] * low).min(image.forward[axis] * high)
        };
        image.forward[3] + along(0) + along(1) + along(2)
    }
}

/// Column, row, and the sample.
type FlakeSample = (u16, u16, MSample);

/// Returns the text before the passes, with so many sub-pixels a pixel.
pub fn source(samples: u32) -> String {
    format!("const SAMPLES = {samples}u;\nconst BLOCK = {BLOCK}u;\n{SOURCE}")
}

/// The samples of an image, and the first of its blocks.
type PlaceOfImage = (Range<u32>, u32);

/// The images of a species on the device.
#[derive(Debug)]
pub struct SpeciesImages {
    /// Three words a sample.
    pub samples: Buffer,
    /// The blocks of all images, in the order of the samples.
    pub blocks: Vec<Block>,
    /// Three words a block.
    pub blocks_on_device: Buffer,
    /// The number of the species, as a uniform.
    pub number: Buffer,
    /// Without the copies that the device has no room for.
    pub images: PlantImages,
    /// Where each image is: by sub-object, copy and direction.
    places: Vec<Vec<Vec<PlaceOfImage>>>,
}

impl SpeciesImages {
    /// Uploads the images of the plant of a species; the finest copies are left out where they do not fit.
    pub fn new(gpu: &Gpu, images: &PlantImages, species: u32) -> Self {
        let mut images = images.clone();
        let room = gpu.largest_binding() / (4 * WORDS as u64);
        leave_out_finest(&mut images, room.min(u64::from(u32::MAX)));
        let (mut words, mut blocks): (Vec<[u32; WORDS]>, Vec<Block>) = Default::default();
        let mut add = |view: &MBuffer, side: u32| {
            let (first, first_block) = (words.len() as u32, blocks.len() as u32);
            add_samples(&mut words, &mut blocks, view, side);
            (first..words.len() as u32, first_block)
        };
        let places = images.objects.iter().map(|object| {
            let copies = object.iter().flat_map(|object| &object.copies);
            copies.map(|copy| copy.views.iter().map(|view| add(view, copy.side)).collect()).collect()
        });
        let places = places.collect();
        let samples = bindings::filled(gpu, "samples of plants", words.as_flattened(), BufferUsages::STORAGE);
        let of_blocks: Vec<[u32; 3]> = blocks.iter().map(Block::words).collect();
        let blocks_on_device =
            bindings::filled(gpu, "blocks of samples", of_blocks.as_flattened(), BufferUsages::STORAGE);
        // Their places are all that is needed from now on.
        for view in
            images.objects.iter_mut().flatten().flat_map(|of| &mut of.copies).flat_map(|copy| &mut copy.views)
        {
            *view = MBuffer::default();
        }
        let number = bindings::filled(gpu, "species", &[[species; 4]], BufferUsages::UNIFORM);
        Self { samples, blocks, blocks_on_device, number, images, places }
    }

    /// Returns an image of a plant in a view; its place among the images in view is set by the caller.
    pub fn words(&self, plant: &Plant, image: &ImageInView) -> FlakeImageWords {
        let ImageInView { object, copy, direction, linear, origin, view_from_normal, .. } = image;
        let of = self.images.objects[*object].as_ref().expect("it has images");
        let copy_of = &of.copies[*copy];
        let (Range { start, end }, first_block) = self.places[*object][*copy][*direction].clone();
        let [depth_step, first_depth] = depth_from_stored(plant.objects[*object].bounds.ball.radius);
        let row = |axis: usize| linear.row(axis).extend(origin[axis]).to_array();
        let normal = |axis: usize| view_from_normal.row(axis).to_array();
        FlakeImageWords {
            right: row(0),
            down: row(1),
            forward: row(2),
            normal_right: normal(0),
            delta: copy_of.delta as f32,
            normal_down: normal(1),
            depth_step: depth_step as f32,
            normal_forward: normal(2),
            first_depth: first_depth as f32,
            through: image.through.to_array(),
            half: 0.5 * copy_of.side as f32,
            gain: image.gain.to_array(),
            length: image.length,
            first: start,
            count: end - start,
            of_direction: image.of_direction.word(),
            of_part: image.of_part.word(),
            first_block,
            ..FlakeImageWords::zeroed()
        }
    }
}

/// Returns the rows of a map, each followed by its offset.
pub fn rows_of(map: &DAffine3) -> [[f32; 4]; 3] {
    let (rows, offset) = (map.matrix3.transpose(), map.translation);
    [0, 1, 2].map(|axis| rows.col(axis).extend(offset[axis]).as_vec4().to_array())
}

/// Removes the finest copy of the sub-object that has most samples, again and again until all samples fit; a sub-object without
/// copies has no images.
fn leave_out_finest(images: &mut PlantImages, room: u64) {
    let samples = |views: &[MBuffer]| views.iter().map(|view| view.samples.len() as u64).sum::<u64>();
    for object in &mut images.objects {
        if let Some(of) = object {
            of.copies.retain(|copy| copy.side <= MOST_SIDE);
        }
        *object = object.take().filter(|of| !of.copies.is_empty());
    }
    let all = |images: &PlantImages| {
        images
            .objects
            .iter()
            .flatten()
            .flat_map(|of| &of.copies)
            .map(|copy| samples(&copy.views))
            .sum::<u64>()
    };
    while all(images) > room {
        let finest = |of: &Option<_>| {
            of.as_ref().map_or(0, |of: &quadratura_foliage::ObjectImages| samples(&of.copies[0].views))
        };
        let Some(largest) = images.objects.iter_mut().max_by_key(|of| finest(of)) else { return };
        if let Some(of) = largest {
            of.copies.remove(0);
        }
        *largest = largest.take().filter(|of| !of.copies.is_empty());
    }
}

/// Adds the samples of an image block by block, part by part.
fn add_samples(words: &mut Vec<[u32; WORDS]>, blocks: &mut Vec<Block>, view: &MBuffer, side: u32) {
    let mut samples = view.samples.iter();
    let mut all: Vec<FlakeSample> = Vec::with_capacity(view.samples.len());
    for (pixel, count) in (0u32..).zip(&view.counts) {
        let at = |sample: &MSample| ((pixel % side) as u16, (pixel / side) as u16, *sample);
        all.extend(samples.by_ref().take(usize::from(*count)).map(at));
    }
    // Rows of parts are visited to and fro, and parts from near to far and from far to near in turn, so that a block that has samples
    // of two parts has neighbours, too.
    let across = side.div_ceil(PART_SIDE);
    all.sort_by_key(|(column, row, sample)| {
        let [row, column] = [*row, *column].map(|at| u32::from(at) / PART_SIDE);
        let part = row * across + if row.is_multiple_of(2) { column } else { across - 1 - column };
        (part, if part.is_multiple_of(2) { sample.depth } else { u16::MAX - sample.depth })
    });
    blocks.extend(all.chunks(BLOCK as usize).map(Block::around));
    words.extend(all.iter().map(|(column, row, MSample { depth, colour: [r, g, b], normal, mask })| {
        let [r, g, b] = [r, g, b].map(|byte| u32::from(*byte));
        [
            u32::from(*column) | u32::from(*row) << 12 | r << 24,
            u32::from(*depth) | u32::from(normal.0) << 16,
            u32::from(*mask) | g << 16 | b << 24,
        ]
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::renderer::plants::tests::oak;
    use quadratura_base::scene::synthetic::Rng;
    use quadratura_base::task::Task;
    use quadratura_foliage::{BakeOptions, bake};

    #[test]
    fn the_finest_copies_are_left_out_until_samples_fit_and_then_whole_sub_objects() {
        let options = BakeOptions { side: 24, least_side: 48, most_side: 48, ..BakeOptions::SLABS };
        let all = bake(&oak(), &options, &Task::silent()).unwrap();
        let count = |images: &PlantImages| {
            let copies = images.objects.iter().flatten().flat_map(|of| &of.copies);
            copies.flat_map(|copy| &copy.views).map(|view| view.samples.len() as u64).sum::<u64>()
        };
        for room in [u64::MAX, count(&all) - 1, count(&all) / 4, 1] {
            let mut images = all.clone();
            leave_out_finest(&mut images, room);
            assert!(count(&images) <= room);
            assert_eq!(images == all, room >= count(&all));
            assert!(images.objects.iter().flatten().all(|of| !of.copies.is_empty()));
            assert_eq!(images.objects.len(), all.objects.len());
        }
    }

    #[test]
    fn the_rectangle_of_an_image_holds_the_points_of_all_samples_and_little_more() {
        let lens = [Vec2::new(300.0, 280.0), Vec2::new(160.0, 120.0)];
        let image = |right, down, forward| FlakeImageWords {
            right,
            down,
            forward,
            delta: 0.1,
            half: 8.0,
            first_depth: -1.0,
            depth_step: 2.0 / f32::from(u16::MAX),
            ..FlakeImageWords::zeroed()
        };
        let mut rng = Rng::new(5);
        let (mut inside, mut around) = (0, 0);
        for _ in 0..300 {
            let mut number = |low: f64, high: f64| rng.between(low, high) as f32;
            let mut row = |offset: f32| [number(-1.0, 1.0), number(-1.0, 1.0), number(-1.0, 1.0), offset];
            let image = image(row(1.0), row(-2.0), row(0.5));
            let rect = image.rect(lens);
            for _ in 0..100 {
                let mut at = |steps: f64| number(0.0, steps).floor();
                let local = Vec4::new(
                    (at(16.0) + 0.5 - image.half) * image.delta,
                    (at(16.0) + 0.5 - image.half) * image.delta,
                    image.first_depth + image.depth_step * at(65536.0),
                    1.0,
                );
                let point =
                    [image.right, image.down, image.forward].map(|row| local.dot(Vec4::from_array(row)));
                let [x, y, z] = point;
                if z <= 0.0 {
                    assert!(rect.w > 1_000_000 && rect.h > 1_000_000, "{rect:?}");
                    around += 1;
                    continue;
                }
                let px = lens[0] * Vec2::new(x, y) / z + lens[1];
                if px.abs().max_element() < 1e6 {
                    assert!(rect.contains(px.x.floor() as i32, px.y.floor() as i32), "{px} and {rect:?}");
                    inside += 1;
                }
            }
        }
        assert!(inside > 10_000 && around > 100, "{inside} and {around}");
        // From 9 to 11 away and 0.8 to each side: 26.7 and 24.9 pixels.
        let upright = image([1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 10.0]);
        assert_eq!(upright.rect(lens), PixelRect { x: 133, y: 95, w: 54, h: 50 });
    }

    #[test]
    fn samples_keep_all_their_bits() {
        let sample = MSample {
            depth: 0xABCD,
            colour: [1, 2, 255],
            normal: quadratura_foliage::NormalCode(0x8123),
            mask: 0xF00F,
        };
        let mut counts = vec![0; 12];
        counts[7] = 1;
        let (mut words, mut blocks) = Default::default();
        add_samples(&mut words, &mut blocks, &MBuffer { counts, samples: vec![sample] }, 4);
        assert_eq!(words, [[3 | 1 << 12 | 1 << 24, 0x8123_ABCD, 0xF00F | 2 << 16 | 255 << 24]]);
        assert_eq!(
            blocks.iter().map(Block::words).collect::<Vec<_>>(),
            [[3 | 3 << 16, 1 | 1 << 16, 0xABCD_ABCD]]
        );
    }
}
