//! Layered pixels: several surfaces behind each other, each a sum of what was found at nearly one depth, with the sub-pixels that
//! it covers (Max 1996, *multi-layer z-buffers*).

use glam::Vec3;

use super::facet::Facet;

/// What is added to a layered pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayerSample {
    /// The sub-pixels that it covers, bit `4 b_y + b_x`.
    pub mask: u16,
    /// Its depth: smaller is nearer, in the unit of the view's frame.
    pub depth: f32,
    /// How much it counts in means; above 0.
    pub weight: f32,
    /// The share of light that it reflects, linear.
    pub reflected: Vec3,
    /// The share of light that it lets through, linear; 0 for bark.
    pub through: Vec3,
    /// The normal, of length 1; shorter as the mean of several leaves.
    pub normal: Vec3,
    /// True for leaves.
    pub is_leaf: bool,
}

impl LayerSample {
    /// Makes the sample of a polygon's fragment: it counts by the sub-pixels that it covers.
    pub(super) fn of_facet(mask: u16, depth: f32, facet: &Facet) -> Self {
        Self {
            mask,
            depth,
            weight: mask.count_ones() as f32 / 16.0,
            reflected: facet.reflected,
            through: facet.through.unwrap_or(Vec3::ZERO),
            normal: facet.normal.as_vec3(),
            is_leaf: facet.through.is_some(),
        }
    }
}

/// A surface in a pixel: sums by weight of what was added to it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Layer {
    /// The mean depth.
    pub depth: f32,
    /// The sum of weights.
    pub weight: f32,
    reflected: Vec3,
    through: Vec3,
    normal: Vec3,
    /// The part of `reflected` that is no leaf's.
    bark: Vec3,
    leaf: f32,
    /// The sub-pixels that are covered.
    pub mask: u16,
}

impl Layer {
    fn of(sample: &LayerSample) -> Self {
        let mut layer = Self::default();
        layer.add(sample);
        layer
    }

    #[inline]
    fn add(&mut self, sample: &LayerSample) {
        let weight = sample.weight;
        self.weight += weight;
        self.depth += (sample.depth - self.depth) * (weight / self.weight);
        self.reflected += weight * sample.reflected;
        self.through += weight * sample.through;
        self.normal += weight * sample.normal;
        if sample.is_leaf {
            self.leaf += weight;
        } else {
            self.bark += weight * sample.reflected;
        }
        self.mask |= sample.mask;
    }

    #[inline]
    fn join(&mut self, other: &Self) {
        self.weight += other.weight;
        self.depth += (other.depth - self.depth) * (other.weight / self.weight);
        self.reflected += other.reflected;
        self.through += other.through;
        self.normal += other.normal;
        self.bark += other.bark;
        self.leaf += other.leaf;
        self.mask |= other.mask;
    }

    /// Returns the mean share of light that is reflected.
    pub fn reflected(&self) -> Vec3 {
        self.reflected / self.weight
    }

    /// Returns the part of [`Self::reflected`] that is no leaf's.
    pub fn reflected_by_bark(&self) -> Vec3 {
        self.bark / self.weight
    }

    /// Returns the mean share of light that is let through.
    pub fn through(&self) -> Vec3 {
        self.through / self.weight
    }

    /// Returns the direction of the mean normal, of length 1; the viewer's where the normals cancel out.
    pub fn normal(&self) -> Vec3 {
        self.normal.try_normalize().unwrap_or(Vec3::NEG_Z)
    }

    /// Returns the length of the mean normal: 1 where all that was added looks in one direction.
    pub fn length(&self) -> f32 {
        self.normal.length() / self.weight
    }

    /// Returns true where most of it is leaves.
    pub fn is_leaf(&self) -> bool {
        2.0 * self.leaf >= self.weight
    }
}

/// The slabs of equal depth into which layered pixels are cut: the pixels of each slab follow those of the one before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slabs {
    count: usize,
    /// Slabs for a unit of depth.
    per_depth: f32,
}

impl Slabs {
    /// One slab: pixels are not cut.
    pub const ONE: Self = Self { count: 1, per_depth: 0.0 };

    /// Makes a number of slabs, at least 1, of depths up to `half` about 0.
    pub fn new(count: usize, half: f32) -> Self {
        Self { count, per_depth: count as f32 / (2.0 * half).max(f32::MIN_POSITIVE) }
    }

    /// Returns the index of the slab of a depth.
    #[inline]
    pub fn of(&self, depth: f32) -> usize {
        let slab = 0.5 * self.count as f32 + depth * self.per_depth;
        (slab.max(0.0) as usize).min(self.count - 1)
    }
}

/// Layered pixels: up to `most` surfaces each, nearest first.
#[derive(Debug, Clone, PartialEq)]
pub struct LayeredPixels {
    most: usize,
    counts: Vec<u8>,
    /// `most` places a pixel; those past its count hold nothing.
    layers: Vec<Layer>,
}

impl LayeredPixels {
    /// Makes empty pixels of up to `most` layers, at least 1.
    pub fn new(pixels: usize, most: u8) -> Self {
        let most = usize::from(most.max(1));
        Self { most, counts: vec![0; pixels], layers: vec![Layer::default(); pixels * most] }
    }

    /// Returns the layers of a pixel, nearest first.
    #[inline]
    pub fn layers(&self, pixel: usize) -> &[Layer] {
        &self.layers[pixel * self.most..][..usize::from(self.counts[pixel])]
    }

    /// Adds a sample to a pixel: to the layer whose mean depth is within `epsilon` of it, the nearer one of two; else it becomes a
    /// layer in its place by depth. What is then behind the last place joins the last layer, so that no sub-pixel is lost.
    #[inline]
    pub fn insert(&mut self, pixel: usize, sample: &LayerSample, epsilon: f32) {
        let count = usize::from(self.counts[pixel]);
        let layers = &mut self.layers[pixel * self.most..][..self.most];
        // The layers are in order: the place, and beside it the two that are nearest in depth.
        let mut place = 0;
        while place < count && layers[place].depth < sample.depth {
            place += 1;
        }
        let before = if place > 0 { sample.depth - layers[place - 1].depth } else { f32::INFINITY };
        let after = if place < count { layers[place].depth - sample.depth } else { f32::INFINITY };
        let joined = match before <= after {
            true if before <= epsilon => Some(place - 1),
            false if after <= epsilon => Some(place),
            _ => None,
        };
        match joined {
            Some(index) => {
                layers[index].add(sample);
                settle(&mut layers[..count], index);
            }
            None if count < self.most => {
                layers[place..=count].rotate_right(1);
                layers[place] = Layer::of(sample);
                self.counts[pixel] += 1;
            }
            // Full: the last place takes what is behind the others.
            None if place < self.most => {
                let pushed = layers[self.most - 1];
                layers[place..].rotate_right(1);
                layers[place] = Layer::of(sample);
                layers[self.most - 1].join(&pushed);
            }
            None => layers[self.most - 1].add(sample),
        }
    }
}

impl LayeredPixels {
    /// Returns the sums, by weight, of the light that leaves reflect and let through.
    pub fn light_of_leaves(&self) -> [Vec3; 2] {
        let layers = (0..self.counts.len()).flat_map(|pixel| self.layers(pixel));
        layers.fold([Vec3::ZERO; 2], |[reflected, through], layer| {
            [reflected + (layer.reflected - layer.bark), through + layer.through]
        })
    }

    /// Returns the mean length of the mean normals of leaves, by what they cover; 1 where there are none.
    pub fn mean_length_of_leaves(&self) -> f32 {
        let pixels = (0..self.counts.len()).flat_map(|pixel| self.layers(pixel));
        let (sum, covered) = pixels.filter(|layer| layer.is_leaf()).fold((0.0, 0.0), |(sum, all), layer| {
            let covered = f64::from(layer.mask.count_ones());
            (sum + covered * f64::from(layer.length()), all + covered)
        });
        if covered > 0.0 { (sum / covered) as f32 } else { 1.0 }
    }
}

/// Moves a layer whose mean depth has changed to its place among its neighbours.
#[inline]
fn settle(layers: &mut [Layer], mut index: usize) {
    while index > 0 && layers[index].depth < layers[index - 1].depth {
        layers.swap(index, index - 1);
        index -= 1;
    }
    while index + 1 < layers.len() && layers[index].depth > layers[index + 1].depth {
        layers.swap(index, index + 1);
        index += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    fn sample(depth: f32, mask: u16) -> LayerSample {
        let (reflected, through) = (Vec3::splat(depth), Vec3::ZERO);
        LayerSample { mask, depth, weight: 1.0, reflected, through, normal: Vec3::NEG_Z, is_leaf: false }
    }

    fn depths(pixels: &LayeredPixels) -> Vec<f32> {
        pixels.layers(0).iter().map(|layer| layer.depth).collect()
    }

    #[test]
    fn two_surfaces_are_one_layer_within_epsilon_and_two_beyond() {
        for (gap, layers) in [(0.99, 1), (1.01, 2)] {
            let mut pixels = LayeredPixels::new(1, 4);
            pixels.insert(0, &sample(5.0, 0x00FF), 1.0);
            pixels.insert(0, &sample(5.0 + gap, 0xFF00), 1.0);
            assert_eq!(pixels.layers(0).len(), layers, "{gap}");
        }
    }

    #[test]
    fn two_half_masks_of_one_surface_are_a_full_pixel_with_the_mean_of_both() {
        let mut pixels = LayeredPixels::new(1, 4);
        pixels.insert(0, &sample(5.0, 0x00FF), 1.0);
        pixels.insert(0, &LayerSample { weight: 3.0, ..sample(6.0, 0xFF00) }, 1.0);
        let layer = pixels.layers(0)[0];
        assert_eq!((layer.mask, layer.depth, layer.reflected()), (0xFFFF, 5.75, Vec3::splat(5.75)));
    }

    #[test]
    fn the_nearer_layer_of_two_takes_a_sample_that_both_could() {
        let mut pixels = LayeredPixels::new(1, 4);
        for depth in [1.0, 2.5, 1.6] {
            pixels.insert(0, &sample(depth, 1), 1.0);
        }
        assert_eq!(depths(&pixels), [1.3, 2.5]);
    }

    #[test]
    fn layers_are_nearest_first_and_the_last_one_takes_what_has_no_place() {
        let mut pixels = LayeredPixels::new(1, 3);
        for (bit, depth) in [4.0, 2.0, 6.0, 1.0, 7.0, 3.0].into_iter().enumerate() {
            pixels.insert(0, &sample(depth, 1 << bit), 0.1);
        }
        // 4, 6, 7 and 3 share the last place.
        assert_eq!(depths(&pixels), [1.0, 2.0, 5.0]);
        assert_eq!((pixels.layers(0)[2].mask, pixels.layers(0)[2].weight), (0b110101, 4.0));
    }

    #[test]
    fn random_samples_stay_in_order_and_no_weight_is_lost_while_there_is_room() {
        let mut rng = Rng::new(9);
        for _ in 0..200 {
            let mut pixels = LayeredPixels::new(1, 64);
            let mut mask = 0;
            for _ in 0..60 {
                let bit = 1 << (rng.between(0.0, 16.0) as u32).min(15);
                mask |= bit;
                pixels.insert(0, &sample(rng.between(0.0, 20.0) as f32, bit), 0.5);
            }
            let layers = pixels.layers(0);
            assert!(layers.is_sorted_by(|a, b| a.depth <= b.depth));
            assert_eq!(layers.iter().map(|layer| layer.weight).sum::<f32>(), 60.0);
            assert_eq!(layers.iter().fold(0, |all, layer| all | layer.mask), mask);
        }
    }

    #[test]
    fn the_mean_normal_of_two_leaves_at_right_angles_is_as_long_as_half_a_diagonal() {
        let mut pixels = LayeredPixels::new(2, 2);
        let leaf = LayerSample { is_leaf: true, ..sample(1.0, 0x00FF) };
        pixels.insert(0, &leaf, 1.0);
        pixels.insert(0, &LayerSample { normal: Vec3::X, mask: 0xFF00, ..leaf }, 1.0);
        assert!((pixels.layers(0)[0].length() - 0.5f32.sqrt()).abs() < 1e-6);
        // A leaf of a quarter of a pixel counts a quarter, and bark does not.
        pixels.insert(1, &LayerSample { mask: 0x000F, ..leaf }, 0.1);
        pixels.insert(1, &sample(5.0, 0x0FF0), 0.1);
        let expected = (0.5f32.sqrt() + 0.25) / 1.25;
        assert!((pixels.mean_length_of_leaves() - expected).abs() < 1e-6);
        assert_eq!(LayeredPixels::new(3, 1).mean_length_of_leaves(), 1.0);
    }

    #[test]
    fn a_layer_is_a_leaf_where_most_of_it_is() {
        let leaf = LayerSample { is_leaf: true, ..sample(1.0, 1) };
        let mut pixels = LayeredPixels::new(1, 1);
        pixels.insert(0, &LayerSample { weight: 2.0, ..sample(1.0, 1) }, 1.0);
        pixels.insert(0, &leaf, 1.0);
        assert!(!pixels.layers(0)[0].is_leaf());
        pixels.insert(0, &leaf, 1.0);
        assert!(pixels.layers(0)[0].is_leaf());
    }
}
