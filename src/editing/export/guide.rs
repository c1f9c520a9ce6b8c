//! Guides: the one of a group shows where its layers are hidden in the photo and remain to be painted, and the one of trees where
//! these are ([`super::trees`]).
//!
//! Each layer with something to paint has one of six colours, in the editor's list of layers and in the guide,
//! where its hidden part is hatched and outlined in this colour. The hatching alternates between left and right,
//! for people who cannot distinguish the colours.

use std::borrow::Borrow;

use super::compose::HiddenPixels;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::Samples;
use quadratura_layered_files::{Depth, Raster, Tag};

/// The colours in turn, as the editors show them: red, green, blue in 8 bits.
const COLOURS: [(Tag, [u8; 3]); 6] = [
    (Tag::Red, [235, 60, 50]),
    (Tag::Blue, [45, 120, 240]),
    (Tag::Yellow, [250, 215, 40]),
    (Tag::Violet, [170, 85, 225]),
    (Tag::Green, [60, 185, 80]),
    (Tag::Orange, [245, 145, 35]),
];

/// The opacity of the outline, of 255.
const OUTLINE: u8 = 255;
/// The opacity of stripes, of 255.
const STRIPE: u8 = 190;
/// The opacity between stripes, of 255.
const BETWEEN: u8 = 60;

/// Returns the colour tag of the layer with this number among those that remain to be painted.
pub fn tag(number: usize) -> Tag {
    COLOURS[number % COLOURS.len()].0
}

/// Returns the number of the colour of a group of linked layers. They begin with the last colour, so that they rarely
/// have one that other layers have.
pub fn linked_colour(group: usize) -> usize {
    COLOURS.len() - 1 - group % COLOURS.len()
}

/// Iterates over the numbers of the colours that are not taken, again and again; over all if none is left.
pub fn free_colours(taken: &[usize]) -> impl Iterator<Item = usize> {
    let is_free = |number: usize| !taken.contains(&(number % COLOURS.len()));
    let any = (0..COLOURS.len()).any(is_free);
    (0..64 * COLOURS.len()).filter(move |number| !any || is_free(*number))
}

/// The dimensions of the hatching in pixels, so that it looks alike on small and large photos.
#[derive(Debug, Clone, Copy)]
pub struct HatchPattern {
    period: i32,
    stripe: i32,
    outline: i32,
}

impl HatchPattern {
    /// Chooses the dimensions for a photo of this size.
    pub fn for_photo(width: u32, height: u32) -> Self {
        let period = (width.max(height) / 160).max(6) as i32;
        Self { period, stripe: period / 3, outline: (period / 6).max(1) }
    }

    /// Returns the opacity at a hidden pixel of the photo.
    fn opacity(self, hidden: &HiddenPixels, x: i32, y: i32, index: usize) -> u8 {
        let t = self.outline;
        let inside = [(t, 0), (-t, 0), (0, t), (0, -t)].iter().all(|(dx, dy)| hidden.holds(x + dx, y + dy));
        let across = if index.is_multiple_of(2) { x + y } else { x - y };
        match across.rem_euclid(self.period) < self.stripe {
            _ if !inside => OUTLINE,
            true => STRIPE,
            false => BETWEEN,
        }
    }
}

/// Draws parts into a raster of `rect`, which contains them all, later ones over earlier ones. Each comes with the number of its
/// colour.
pub fn draw(
    parts: impl IntoIterator<Item = (usize, impl Borrow<HiddenPixels>)>,
    rect: PixelRect,
    pattern: HatchPattern,
    depth: Depth,
) -> Raster {
    let mut raster = Raster::blank(rect.w, rect.h, depth);
    for (index, hidden) in parts {
        let hidden = hidden.borrow();
        let colour = COLOURS[index % COLOURS.len()].1;
        let mut put = |x: i32, y: i32, [r, g, b]: [u8; 3], alpha: u8| {
            let at = 4 * rect.offset(x, y);
            match raster.samples_mut() {
                Samples::U8(s) => s[at..at + 4].copy_from_slice(&[r, g, b, alpha]),
                Samples::U16(s) => {
                    s[at..at + 4].copy_from_slice(&[r, g, b, alpha].map(|v| u16::from(v) * 257));
                }
            }
        };
        for (x, y) in hidden.held() {
            put(x, y, colour, pattern.opacity(hidden, x, y, index));
        }
    }
    raster
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> HiddenPixels {
        HiddenPixels::filled(PixelRect { x: 10, y: 20, w: 30, h: 30 }, true)
    }

    #[test]
    fn a_hidden_part_is_hatched_and_has_an_outline_and_nothing_else_is_touched() {
        let rect = PixelRect { x: 8, y: 18, w: 40, h: 40 };
        let raster = draw([(0, square())], rect, HatchPattern::for_photo(1536, 1024), Depth::Eight);
        assert_eq!(raster.coloured_rect(), PixelRect { x: 2, y: 2, w: 30, h: 30 });
        let Samples::U8(samples) = raster.samples() else { panic!("8 bits") };
        let alpha = |x: usize, y: usize| samples[4 * (y * 40 + x) + 3];
        assert_eq!((alpha(2, 2), alpha(31, 20), alpha(40, 2)), (OUTLINE, OUTLINE, 0));
        let inner: std::collections::BTreeSet<u8> = (5..28).map(|x| alpha(x, 15)).collect();
        assert_eq!(inner.into_iter().collect::<Vec<_>>(), [BETWEEN, STRIPE]);
    }

    #[test]
    fn layers_get_the_colours_that_linked_ones_leave() {
        let first = |taken: &[usize]| free_colours(taken).take(6).collect::<Vec<_>>();
        assert_eq!(first(&[]), [0, 1, 2, 3, 4, 5]);
        assert_eq!(first(&[linked_colour(0), 0]), [1, 2, 3, 4, 7, 8]);
        assert_eq!(first(&[0, 1, 2, 3, 4, 5]), [0, 1, 2, 3, 4, 5]);
        assert_eq!(tag(linked_colour(0)), tag(linked_colour(6)));
    }

    #[test]
    fn the_colour_in_the_guide_is_that_in_the_list_of_layers() {
        let rect = square().rect();
        let raster = draw([(7, square())], rect, HatchPattern::for_photo(100, 100), Depth::Sixteen);
        let Samples::U16(samples) = raster.samples() else { panic!("16 bits") };
        assert_eq!(tag(7), Tag::Blue);
        assert_eq!(samples[..4], [45 * 257, 120 * 257, 240 * 257, 65535]);
    }
}
