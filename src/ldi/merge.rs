//! Samples that fall into one pixel of the reference camera become its layers.
//!
//! Published (section 2.2): a sample joins the first layer whose depth differs by no more than epsilon, else it opens one.
//! Here samples are sorted by depth and covered greedily from the front, so that their order does not count; an epsilon that
//! grows with the slope of the surface keeps a plane seen along it in one layer. Without slopes no rule gives fewer layers
//! of that tolerance: it is the cover of points on a line by intervals.

use glam::DVec3;

use super::layout::{DepthPixel, LdiSurface};
use crate::projection::srgb::Srgb;

/// A sample of a surface in a pixel of the reference camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Inverse depth, colour, surface and origin, all in the reference camera.
    pub pixel: DepthPixel,
    /// The number of its source; 0 is the reference camera's own photo.
    pub source: u16,
    /// Its pixel in the source, in reading order.
    pub place: u32,
    /// How much it counts in means, > 0.
    pub weight: f32,
}

/// How the samples of one pixel become layers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Merging {
    /// The difference of inverse depths within a layer, as a share of the nearest one.
    pub epsilon: f64,
    /// True when the tolerance grows by how much the depth of the nearest sample's surface changes within a pixel.
    pub slopes: bool,
    /// True when a layer with a sample of source 0 has that sample's colour and depth.
    pub keep: bool,
    /// The largest number of layers.
    pub layers: usize,
}

impl Default for Merging {
    fn default() -> Self {
        Self { epsilon: 0.01, slopes: true, keep: true, layers: 10 }
    }
}

/// Returns how much the inverse depth of a surface changes over a pixel, as a share of `inverse_depth`. `nu` has the pixels of
/// the camera in which samples are merged.
pub fn slope(nu: DVec3, inverse_depth: f64) -> f64 {
    if inverse_depth > 0.0 { (nu.x.abs() + nu.y.abs()) / inverse_depth } else { 0.0 }
}

/// The layers of one pixel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Merged {
    /// The depth pixels, nearest first.
    pub layers: Vec<DepthPixel>,
    /// The number of samples that were left out because of the largest number of layers.
    pub dropped: u64,
}

/// Merges the samples of one pixel, which it sorts. `pixel_size` is the size of the pixel in those of the frame, in which the
/// surfaces' planes are.
pub fn merge(samples: &mut [Sample], surfaces: &[LdiSurface], pixel_size: f64, merging: &Merging) -> Merged {
    samples.sort_unstable_by(|a, b| {
        let by_depth = b.pixel.inverse_depth.total_cmp(&a.pixel.inverse_depth);
        by_depth.then_with(|| (a.source, a.place, a.pixel.surface).cmp(&(b.source, b.place, b.pixel.surface)))
    });
    let mut layers: Vec<&[Sample]> = Vec::new();
    let mut rest: &[Sample] = samples;
    while let Some(first) = rest.first() {
        let nearest = f64::from(first.pixel.inverse_depth);
        let nu = usize::from(first.pixel.surface).checked_sub(1).map(|index| surfaces[index].nu);
        let of_surface = nu.filter(|_| merging.slopes).map_or(0.0, |nu| slope(nu, nearest) * pixel_size);
        let reach = (merging.epsilon + of_surface) * nearest;
        let within = |sample: &Sample| nearest - f64::from(sample.pixel.inverse_depth) <= reach;
        let (layer, farther) = rest.split_at(rest.partition_point(within));
        layers.push(layer);
        rest = farther;
    }
    let dropped = limit(&mut layers, merging.layers);
    Merged { layers: layers.into_iter().map(|layer| of_layer(layer, merging.keep)).collect(), dropped }
}

/// Keeps the nearest layers and the farthest one; returns the number of samples left out.
fn limit(layers: &mut Vec<&[Sample]>, most: usize) -> u64 {
    if layers.len() <= most {
        return 0;
    }
    let last = layers.len() - 1;
    let left_out: usize = layers[most - 1..last].iter().map(|layer| layer.len()).sum();
    layers.drain(most - 1..last);
    left_out as u64
}

/// Returns the depth pixel of a layer's samples.
fn of_layer(samples: &[Sample], keep: bool) -> DepthPixel {
    let own = samples.iter().filter(|sample| sample.source == 0).max_by(|a, b| a.weight.total_cmp(&b.weight));
    if let (true, Some(own)) = (keep, own) {
        return own.pixel;
    }
    if let [only] = samples {
        return only.pixel;
    }
    let srgb = Srgb::tables();
    let (mut depth, mut light, mut opacity, mut weights, mut opaque) = (0.0, [0.0f64; 3], 0.0, 0.0, 0.0);
    let mut heaviest = &samples[0];
    for sample in samples {
        let DepthPixel { inverse_depth, colour: [colour @ .., a], .. } = sample.pixel;
        let weight = f64::from(sample.weight);
        let seen = weight * f64::from(a);
        depth += weight * f64::from(inverse_depth);
        light.iter_mut().zip(colour).for_each(|(sum, byte)| *sum += seen * f64::from(srgb.linear(byte)));
        (opacity, weights, opaque) = (opacity + weight * f64::from(a), weights + weight, opaque + seen);
        if sample.weight > heaviest.weight {
            heaviest = sample;
        }
    }
    let [r, g, b] = light.map(|sum| srgb.encoded((sum / opaque.max(f64::MIN_POSITIVE)) as f32));
    DepthPixel {
        inverse_depth: (depth / weights) as f32,
        colour: [r, g, b, (opacity / weights).round() as u8],
        ..heaviest.pixel
    }
}
