//! Samples that fall into one pixel of the reference camera become its layers.
//!
//! Published (section 2.2): a sample joins the first layer whose depth differs by no more than epsilon, else it opens one.
//! Here samples are sorted by depth and covered greedily from the front, so that their order does not count; an epsilon that
//! grows with the slope of the surface keeps a plane seen along it in one layer. Without slopes no rule gives fewer layers
//! of that tolerance: it is the cover of points on a line by intervals.

use glam::DVec3;

use super::layout::{DepthPixel, LdiSurface};
use quadratura_view::srgb::Srgb;

/// A sample of a surface in a pixel of the reference camera.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SurfaceSample {
    /// Inverse depth, colour, surface and origin, all in the reference camera.
    pub pixel: DepthPixel,
    /// The number of its source; 0 is the reference camera's own photo.
    pub source: u16,
    /// Its pixel in the source, in reading order.
    pub place: u32,
    /// How much it counts in means, > 0.
    pub weight: f32,
    /// Whether its own camera does not see it: it counts only where no camera sees the layer. What is right behind a surface
    /// must not shine through it.
    pub hidden: bool,
}

/// How the samples of one pixel become layers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Merging {
    /// The difference of inverse depths within a layer, as a share of the nearest one.
    pub epsilon: f64,
    /// True when the tolerance grows by how much the depth of the nearest sample's surface changes within a pixel.
    pub slopes: bool,
    /// The largest number of layers.
    pub layers: usize,
}

impl Default for Merging {
    fn default() -> Self {
        Self { epsilon: 0.01, slopes: true, layers: 10 }
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
pub fn merge(
    samples: &mut [SurfaceSample],
    surfaces: &[LdiSurface],
    pixel_size: f64,
    merging: &Merging,
) -> Merged {
    if let [sample] = samples {
        return Merged { layers: vec![sample.pixel], dropped: 0 };
    }
    let mut found = Vec::new();
    let dropped = merge_into(samples, surfaces, pixel_size, merging, |pixel| found.push(pixel));
    Merged { layers: found, dropped }
}

/// The same without a list: `add` gets the layers, the nearest first. Returns [`Merged::dropped`].
pub fn merge_into(
    samples: &mut [SurfaceSample],
    surfaces: &[LdiSurface],
    pixel_size: f64,
    merging: &Merging,
    mut add: impl FnMut(DepthPixel),
) -> u64 {
    if let [sample] = samples {
        add(sample.pixel);
        return 0;
    }
    sort(samples);
    let (mut count, mut dropped) = (0, 0);
    let mut rest: &[SurfaceSample] = samples;
    // The last of too many layers, which may turn out to be the farthest one.
    let mut beyond: Option<&[SurfaceSample]> = None;
    while let Some(first) = rest.first() {
        let nearest = f64::from(first.pixel.inverse_depth);
        let nu = usize::from(first.pixel.surface).checked_sub(1).map(|index| surfaces[index].nu);
        let of_surface = nu.filter(|_| merging.slopes).map_or(0.0, |nu| slope(nu, nearest) * pixel_size);
        let reach = (merging.epsilon + of_surface) * nearest;
        let within = |sample: &&SurfaceSample| nearest - f64::from(sample.pixel.inverse_depth) <= reach;
        let (layer, farther) = rest.split_at(rest.iter().take_while(within).count());
        rest = farther;
        // What is infinitely far away is the photo's own: what others show there is not, as what stands beyond the model.
        let keep = nearest == 0.0;
        if count + 1 < merging.layers {
            add(of_layer(layer, keep));
            count += 1;
        } else if let Some(other) = beyond.replace(layer) {
            dropped += other.len() as u64;
        }
    }
    if let Some(farthest) = beyond {
        let keep = farthest.iter().all(|sample| sample.pixel.inverse_depth == 0.0);
        add(of_layer(farthest, keep));
    }
    dropped
}

/// The number of samples up to which they are sorted by insertion.
const FEW: usize = 16;

/// Sorts by falling inverse depth. Most pixels have few samples, mostly in order already.
fn sort(samples: &mut [SurfaceSample]) {
    let key = |s: &SurfaceSample| (s.source, s.place, s.pixel.surface);
    let compare = |a: &SurfaceSample, b: &SurfaceSample| {
        let by_depth = b.pixel.inverse_depth.total_cmp(&a.pixel.inverse_depth);
        by_depth.then_with(|| key(a).cmp(&key(b)))
    };
    if samples.len() > FEW {
        samples.sort_by(compare);
        return;
    }
    for end in 1..samples.len() {
        let mut at = end;
        while at > 0 && compare(&samples[at], &samples[at - 1]).is_lt() {
            samples.swap(at, at - 1);
            at -= 1;
        }
    }
}

/// Merges the samples of one pixel by the published rule, in the order in which they come: a sample joins the first layer
/// whose depth z differs by no more than epsilon z, and depth and stored colour become the mean of all its samples; else it
/// opens a layer, as long as there are fewer than the largest number.
///
/// In what z and epsilon are measured, the paper (section 2.2) does not say.
pub fn merge_as_published(samples: &[SurfaceSample], merging: &Merging) -> Merged {
    let mut found = Vec::new();
    let dropped = merge_as_published_into(samples, merging, &mut Vec::new(), |pixel| found.push(pixel));
    Merged { layers: found, dropped }
}

/// The same without lists of its own: `layers` is overwritten, and `add` gets the layers, the nearest first. Returns
/// [`Merged::dropped`].
pub fn merge_as_published_into(
    samples: &[SurfaceSample],
    merging: &Merging,
    layers: &mut Vec<PublishedLayer>,
    add: impl FnMut(DepthPixel),
) -> u64 {
    layers.clear();
    let mut dropped = 0;
    for sample in samples {
        let z = 1.0 / f64::from(sample.pixel.inverse_depth);
        let level = |layer: &PublishedLayer| (z - layer.z).abs() <= merging.epsilon * layer.z || z == layer.z;
        match layers.iter().position(level) {
            Some(layer) => layers[layer].add(&sample.pixel),
            None if layers.len() < merging.layers => layers.push(PublishedLayer::new(sample.pixel)),
            None => dropped += 1,
        }
    }
    layers.sort_by(|a, b| a.z.total_cmp(&b.z));
    layers.iter().map(PublishedLayer::mean).for_each(add);
    dropped
}

/// A layer of the published rule.
#[derive(Debug)]
pub struct PublishedLayer {
    first: DepthPixel,
    /// The mean depth, in world units; infinite for the sky.
    z: f64,
    /// Sums of stored colours and opacity.
    sums: [f64; 4],
    count: f64,
}

impl PublishedLayer {
    fn new(first: DepthPixel) -> Self {
        let z = 1.0 / f64::from(first.inverse_depth);
        Self { first, z, sums: first.colour.map(f64::from), count: 1.0 }
    }

    fn add(&mut self, pixel: &DepthPixel) {
        self.count += 1.0;
        let z = 1.0 / f64::from(pixel.inverse_depth);
        if self.z.is_finite() {
            self.z += (z - self.z) / self.count;
        }
        self.sums.iter_mut().zip(pixel.colour).for_each(|(sum, value)| *sum += f64::from(value));
    }

    fn mean(&self) -> DepthPixel {
        let colour = self.sums.map(|sum| (sum / self.count).round() as u8);
        DepthPixel { inverse_depth: (1.0 / self.z) as f32, colour, ..self.first }
    }
}

/// Returns the depth pixel of a layer's samples, which are sorted by depth; with `keep` of those of source 0 alone, where there
/// are some.
fn of_layer(samples: &[SurfaceSample], keep: bool) -> DepthPixel {
    if let [sample] = samples {
        return sample.pixel;
    }
    let any_is_seen = samples.iter().any(|sample| !sample.hidden);
    let counting = || samples.iter().filter(move |sample| !(any_is_seen && sample.hidden));
    let own = || counting().filter(|sample| sample.source == 0);
    if keep && own().next().is_some() { mean(own()) } else { mean(counting()) }
}

/// Returns the weighted mean of samples, in linear light, with the surface of the heaviest; one sample is its own mean.
fn mean<'a>(samples: impl Iterator<Item = &'a SurfaceSample>) -> DepthPixel {
    let srgb = Srgb::tables();
    let (mut depth, mut light, mut opacity, mut weights, mut opaque) = (0.0, [0.0f64; 3], 0.0, 0.0, 0.0);
    let (mut heaviest, mut count): (Option<&SurfaceSample>, usize) = (None, 0);
    for sample in samples {
        let DepthPixel { inverse_depth, colour: [r, g, b, a], .. } = sample.pixel;
        let weight = f64::from(sample.weight);
        let seen = weight * f64::from(a);
        depth += weight * f64::from(inverse_depth);
        light[0] += seen * f64::from(srgb.linear(r));
        light[1] += seen * f64::from(srgb.linear(g));
        light[2] += seen * f64::from(srgb.linear(b));
        (opacity, weights, opaque) = (opacity + weight * f64::from(a), weights + weight, opaque + seen);
        count += 1;
        if heaviest.is_none_or(|heaviest| sample.weight > heaviest.weight) {
            heaviest = Some(sample);
        }
    }
    let heaviest = heaviest.expect("a layer has a sample").pixel;
    if count == 1 {
        return heaviest;
    }
    let opaque = opaque.max(f64::MIN_POSITIVE);
    let [r, g, b] = [light[0] / opaque, light[1] / opaque, light[2] / opaque];
    let [r, g, b] = [srgb.encoded(r as f32), srgb.encoded(g as f32), srgb.encoded(b as f32)];
    DepthPixel {
        inverse_depth: (depth / weights) as f32,
        colour: [r, g, b, (opacity / weights).round() as u8],
        ..heaviest
    }
}
