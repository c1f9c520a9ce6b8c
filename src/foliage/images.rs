//! Images of sub-objects: parallel views with depth, from 22 or six directions, at one or several resolutions.

use glam::{Vec2, Vec3};

use super::directions::Directions;
use super::mbuffer::{Layer, LayeredPixels};
use super::normal::NormalCode;
use quadratura_base::scene::light::{LINEAR_FROM_BYTE, srgb_from_linear};

/// A view of a sub-object: the surfaces of each pixel, nearest first (Max 1996, an *M-buffer*; of *slabs*: those that are the nearest in
/// one of the slabs into which the sub-object is cut across the direction, Max, Deussen & Keating 1999).
///
/// Pixel (i, j) has its centre at ((i + 1/2 - side/2) delta, (j + 1/2 - side/2) delta) of the view's frame, whose origin is the
/// middle of the sub-object's ball.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MBuffer {
    /// How many samples each pixel has, row by row from the top.
    pub counts: Vec<u8>,
    /// The samples in the order of the pixels, in a pixel nearest first.
    pub samples: Vec<MSample>,
}

/// A surface in a pixel of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MSample {
    /// The depth: 1 is the ball's nearest point, 65,535 its farthest.
    pub depth: u16,
    /// The share of light that is reflected, as sRGB.
    pub colour: [u8; 3],
    /// The normal in the view's frame, and whether it is a leaf; that of a leaf looks to the viewer.
    pub normal: NormalCode,
    /// The sub-pixels that are covered, bit `4 b_y + b_x`; not 0.
    pub mask: u16,
}

/// The views of a sub-object at one resolution.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageCopy {
    /// The side of a pixel in the sub-object's unit.
    pub delta: f64,
    /// Columns and rows of each view.
    pub side: u32,
    /// The views, by direction ([`Directions`]).
    pub views: Vec<MBuffer>,
    /// How the light of its samples becomes that of the polygons.
    pub correction: LightCorrection,
}

/// How the light of samples, each of which stands for several surfaces, becomes the light of these.
#[derive(Debug, Clone, PartialEq)]
pub struct LightCorrection {
    /// The factor on the light, R, G, B: the mean of views all around in several suns.
    pub gain: Vec3,
    /// For each direction the mean length of the mean normals of leaves: 1 where the leaves of each sample are parallel.
    pub lengths: Vec<f32>,
}

impl LightCorrection {
    /// Returns the one that changes nothing, of so many directions.
    pub fn none(directions: usize) -> Self {
        Self { gain: Vec3::ONE, lengths: vec![1.0; directions] }
    }
}

/// The images of a sub-object.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectImages {
    /// The copies, finest first; at least one.
    pub copies: Vec<ImageCopy>,
    /// The share of light that leaves let through over the share that they reflect, R, G, B; the mean of all leaves.
    pub through: Vec3,
}

/// The images of a plant's sub-objects, in their order; `None` where images save nothing ([`super::bake()`]).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlantImages {
    /// The directions of all views.
    pub directions: Directions,
    /// Whether any of them was made from images of parts, see [`super::BakeOptions::from_parts`].
    pub from_parts: bool,
    /// The images of each sub-object.
    pub objects: Vec<Option<ObjectImages>>,
}

impl MBuffer {
    /// Makes the view of layered pixels whose depths are within `radius` of 0.
    /// `through` is what leaves let through over what they reflect.
    pub(super) fn of(pixels: &LayeredPixels, count: usize, radius: f64, through: Vec3) -> Self {
        let mut view = Self { counts: Vec::with_capacity(count), samples: Vec::new() };
        for pixel in 0..count {
            let layers = pixels.layers(pixel);
            view.counts.push(layers.len() as u8);
            let sample = |layer: &Layer| MSample::of(layer, layer.mask, radius, through);
            view.samples.extend(layers.iter().map(sample));
        }
        view
    }

    /// Makes the view of `slabs` slabs, whose layered pixels follow each other. Of each slab, what is the nearest is kept in each
    /// sub-pixel.
    pub(super) fn of_slabs(
        pixels: &LayeredPixels,
        count: usize,
        slabs: usize,
        radius: f64,
        through: Vec3,
    ) -> Self {
        let mut view = Self { counts: Vec::with_capacity(count), samples: Vec::new() };
        for pixel in 0..count {
            let before = view.samples.len();
            for slab in 0..slabs {
                let mut left = u16::MAX;
                for layer in pixels.layers(slab * count + pixel) {
                    let mask = layer.mask & left;
                    left &= !mask;
                    if mask != 0 {
                        view.samples.push(MSample::of(layer, mask, radius, through));
                    }
                }
            }
            view.counts.push((view.samples.len() - before) as u8);
        }
        view
    }
}

impl MSample {
    fn of(layer: &Layer, mask: u16, radius: f64, through: Vec3) -> Self {
        Self {
            depth: stored_depth(f64::from(layer.depth), radius),
            colour: stored_reflected(layer, through).to_array().map(srgb_byte),
            normal: NormalCode::new(layer.normal(), layer.is_leaf()),
            mask,
        }
    }

    /// Returns the middle of the covered sub-pixels from the pixel's centre, in sides of a pixel.
    #[inline]
    pub(super) fn middle(&self) -> Vec2 {
        let count = |of: u16| (self.mask & of).count_ones() as f32;
        let x = 3.0 * (count(0x8888) - count(0x1111)) + count(0x4444) - count(0x2222);
        let y = 3.0 * (count(0xF000) - count(0x000F)) + count(0x0F00) - count(0x00F0);
        Vec2::new(x, y) / (8.0 * self.mask.count_ones() as f32)
    }

    /// Returns the share of light that is reflected, linear.
    #[inline]
    pub fn reflected(&self) -> Vec3 {
        let [r, g, b] = self.colour;
        let linear = |byte: u8| LINEAR_FROM_BYTE[usize::from(byte)];
        Vec3::new(linear(r), linear(g), linear(b))
    }
}

/// Returns the share of light that is stored as reflected. A sample is leaf or bark, but its surfaces may be both: what it reflects and lets
/// through, as its light is computed, is together what they do.
fn stored_reflected(layer: &Layer, through: Vec3) -> Vec3 {
    let bark = layer.reflected_by_bark();
    match layer.is_leaf() {
        // Bark in a sample of leaves lets nothing through.
        true => layer.reflected() - bark + bark / (1.0 + through),
        false => layer.reflected() + layer.through(),
    }
}

fn srgb_byte(linear: f32) -> u8 {
    (255.0 * srgb_from_linear(f64::from(linear).clamp(0.0, 1.0))).round() as u8
}

/// Steps of stored depths from one end of the ball to the other.
const DEPTH_STEPS: f64 = 65_534.0;

/// Returns a depth about the middle of a ball as it is stored.
fn stored_depth(depth: f64, radius: f64) -> u16 {
    let share = if radius > 0.0 { 0.5 * (depth / radius + 1.0) } else { 0.5 };
    1 + (DEPTH_STEPS * share.clamp(0.0, 1.0)).round() as u16
}

/// Returns the factor and the offset that make a depth about the middle of a ball of a stored one.
pub fn depth_from_stored(radius: f64) -> [f64; 2] {
    let step = 2.0 * radius / DEPTH_STEPS;
    [step, -radius - step]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mbuffer::LayerSample;

    #[test]
    fn what_a_sample_of_leaves_and_bark_reflects_and_lets_through_is_together_what_they_do() {
        let through = Vec3::new(0.5, 1.5, 2.0);
        let bark = LayerSample {
            mask: 0x00FF,
            depth: 0.0,
            weight: 1.0,
            reflected: Vec3::splat(0.2),
            through: Vec3::ZERO,
            normal: Vec3::NEG_Z,
            is_leaf: false,
        };
        let reflected = Vec3::new(0.1, 0.2, 0.04);
        let leaf = LayerSample { reflected, through: reflected * through, is_leaf: true, ..bark };
        for (weight, is_leaf) in [(3.0, true), (0.25, false)] {
            let mut pixels = LayeredPixels::new(1, 1);
            pixels.insert(0, &bark, 1.0);
            pixels.insert(0, &LayerSample { weight, ..leaf }, 1.0);
            let view = MBuffer::of(&pixels, 1, 1.0, through);
            let sample = view.samples[0];
            assert_eq!(sample.normal.is_leaf(), is_leaf);
            let together = sample.reflected() * if is_leaf { 1.0 + through } else { Vec3::ONE };
            let expected = (bark.reflected + weight * (leaf.reflected + leaf.through)) / (1.0 + weight);
            // A byte of sRGB.
            assert!((together / expected - 1.0).abs().max_element() < 0.02, "{together} {expected}");
        }
    }

    #[test]
    fn a_stored_depth_is_off_by_half_a_step() {
        let radius = 3.5;
        let [factor, offset] = depth_from_stored(radius);
        for i in 0..=1000 {
            let depth = radius * (f64::from(i) / 500.0 - 1.0);
            let again = factor * f64::from(stored_depth(depth, radius)) + offset;
            assert!((again - depth).abs() <= 0.5 * factor * 1.0001, "{depth} {again}");
        }
        assert_eq!([-9.0, -3.5, 3.5, 9.0].map(|depth| stored_depth(depth, radius)), [1, 1, 65535, 65535]);
        assert_eq!(stored_depth(0.0, 0.0), 32768);
    }
}
