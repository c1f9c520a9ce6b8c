//! Which image layers show each pixel of a photo. Most pixels are shown by one; by several where faces lie on each other, such as windows
//! on a wall. A label is a set of layers.

use std::collections::BTreeMap;

use quadratura_projection::LayerTextureId;

/// The most labels of a photo beside that for nothing, as many as a byte tells apart.
const MOST: usize = 255;

/// The labels of a photo's pixels.
pub struct TexelLabels {
    /// The label of each pixel; 0 for nothing.
    of_pixel: Vec<u16>,
    /// The layers of each label, ascending.
    sets: Vec<Vec<LayerTextureId>>,
    /// The label of a label with one more layer.
    with: BTreeMap<(u16, LayerTextureId), u16>,
}

/// Labels of which each is a byte.
pub struct ByteLabels {
    /// The label of each pixel; 0 for nothing.
    pub of_pixel: Vec<u8>,
    /// The labels of each layer.
    pub of_layer: BTreeMap<LayerTextureId, Vec<u8>>,
    /// The number of pixels that lost their label, because there are too many.
    pub lost: usize,
}

impl TexelLabels {
    /// Labels so many pixels with nothing.
    pub fn new(count: usize) -> Self {
        Self { of_pixel: vec![0; count], sets: vec![Vec::new()], with: BTreeMap::new() }
    }

    /// Returns whether some layer shows a pixel.
    pub fn is_claimed(&self, at: usize) -> bool {
        self.of_pixel[at] > 0
    }

    /// Adds a layer to those that show a pixel. Where a photo has more labels than 16 bits tell apart, the pixel keeps its former one.
    pub fn claim(&mut self, at: usize, layer: LayerTextureId) {
        let before = self.of_pixel[at];
        let next = self.sets.len();
        let label = *self.with.entry((before, layer)).or_insert(next.min(usize::from(u16::MAX)) as u16);
        if usize::from(label) == next {
            let mut set = self.sets[usize::from(before)].clone();
            set.push(layer);
            self.sets.push(set);
        }
        if usize::from(label) < self.sets.len() {
            self.of_pixel[at] = label;
        }
    }

    /// Returns the same with the labels of fewest pixels taken for nothing where there are more than a byte tells apart.
    pub fn in_bytes(&self) -> ByteLabels {
        let mut counts = vec![0usize; self.sets.len()];
        self.of_pixel.iter().for_each(|label| counts[usize::from(*label)] += 1);
        let mut order: Vec<usize> = (1..self.sets.len()).filter(|label| counts[*label] > 0).collect();
        order.sort_by_key(|label| (std::cmp::Reverse(counts[*label]), *label));
        let lost = order.iter().skip(MOST).map(|label| counts[*label]).sum();
        order.truncate(MOST);
        order.sort_unstable();
        let mut byte = vec![0u8; self.sets.len()];
        let mut of_layer: BTreeMap<LayerTextureId, Vec<u8>> = BTreeMap::new();
        for (label, number) in order.into_iter().zip(1u8..) {
            byte[label] = number;
            self.sets[label].iter().for_each(|layer| of_layer.entry(*layer).or_default().push(number));
        }
        let of_pixel = self.of_pixel.iter().map(|label| byte[usize::from(*label)]).collect();
        ByteLabels { of_pixel, of_layer, lost }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_of_two_layers_has_a_label_of_both() {
        let [wall, window] = [LayerTextureId(4), LayerTextureId(7)];
        let mut labels = TexelLabels::new(3);
        labels.claim(0, wall);
        labels.claim(1, wall);
        labels.claim(1, window);
        let ByteLabels { of_pixel, of_layer, lost } = labels.in_bytes();
        assert_eq!(of_pixel, [1, 2, 0]);
        assert_eq!(
            (of_layer[&wall].as_slice(), of_layer[&window].as_slice(), lost),
            (&[1, 2][..], &[2][..], 0)
        );
    }

    #[test]
    fn of_too_many_labels_the_smallest_become_nothing() {
        let mut labels = TexelLabels::new(600);
        for at in 0..600 {
            labels.claim(at, LayerTextureId(if at < 300 { at as u32 } else { 7 }));
        }
        let found = labels.in_bytes();
        assert_eq!((found.lost, found.of_layer.len()), (300 - MOST, MOST));
        assert!(found.of_pixel[599] > 0 && found.of_pixel[599] == found.of_pixel[7]);
    }
}
