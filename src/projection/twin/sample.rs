//! Lookups of a layer texture's texels at a position with the filter that a view needs (`shaders/texels.wgsl`, and
//! `texture_texel` of `shaders/project.wgsl`), in linear light in either quality.

use glam::DVec2;

use crate::LayerTexturePixels;
use crate::pyramid::{Pyramid, PyramidOptions, matte_pyramid, pyramid};
use crate::tiles::{Occupancy, TILE};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::light::LINEAR_FROM_BYTE;
use quadratura_view::shot::MOST_TAPS;

/// The distance from a texel's centre, as a share of its width, within which the texel is taken without
/// interpolation; the shares in between are stretched accordingly (`DEAD` of `shaders/texels.wgsl`).
const DEAD: f64 = 0.02;

/// The footprint in texels up to which level 0 alone is looked up.
const SHARP: f64 = 1.1;

/// The part of an octave over which *preview* mixes two levels (`MIXED` of `shaders/texels.wgsl`); elsewhere
/// it uses one level.
const MIXED: f64 = 0.3;

/// A filtered texel: linear colour, matte and confidence.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Texel {
    /// Linear light, times the matte.
    pub colour: [f64; 3],
    /// The matte, 0..1; 1 where the layer texture has none.
    pub matte: f64,
    /// The confidence, 0..1.
    pub confidence: f64,
}

impl Texel {
    fn add(&mut self, share: f64, other: &Self) {
        (0..3).for_each(|c| self.colour[c] += share * other.colour[c]);
        self.matte += share * other.matte;
        self.confidence += share * other.confidence;
    }
}

/// The footprint of a pixel of the view in a photo, in the photo's pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Footprint {
    /// A square with this side (*preview*).
    Square(f64),
    /// The parallelogram spanned by a step of one pixel to the right and one down (*final*).
    Sides(DVec2, DVec2),
}

/// A layer texture prepared for lookups.
#[derive(Debug)]
pub struct Lookup {
    rect: PixelRect,
    pyramid: Pyramid,
    /// The pyramid of the matte; `None` where the layer texture has none.
    matte: Option<Pyramid>,
    occupancy: Occupancy,
}

impl Lookup {
    /// Builds the pyramid of a layer texture. `rect` is the layer texture's, in photo pixels.
    pub fn new(rect: PixelRect, pixels: &LayerTexturePixels, options: &PyramidOptions) -> Self {
        let pyramid = pyramid(rect, pixels, options);
        let matte = pixels.matte.is_some().then(|| matte_pyramid(rect, pixels, options));
        Self { rect, occupancy: Occupancy::from_pyramid(&pyramid), pyramid, matte }
    }

    /// Looks up the texel at a photo position; `None` where there is no tile: far from all content, or beyond
    /// the rectangle by more than half a texel.
    pub fn texel(&self, px: DVec2, footprint: Footprint) -> Option<Texel> {
        let at = px - DVec2::new(self.rect.x.into(), self.rect.y.into());
        if at.min_element() <= -0.5 || (at - self.size()).max_element() >= 0.5 {
            return None;
        }
        match footprint {
            Footprint::Square(side) => {
                let level = level_of(side);
                let share = ((level.fract() - 0.5) / MIXED + 0.5).clamp(0.0, 1.0);
                self.between_levels(at, level.floor() + share)
            }
            Footprint::Sides(a, b) => self.along(at, a, b),
        }
    }

    /// Returns the memory that the texels use, in bytes.
    pub fn bytes(&self) -> u64 {
        self.pyramid.bytes() + self.matte.as_ref().map_or(0, Pyramid::bytes)
    }

    fn size(&self) -> DVec2 {
        DVec2::new(self.rect.w.into(), self.rect.h.into())
    }

    /// Averages taps along the longer axis of the ellipse that the sides make of the unit circle; each tap is
    /// as wide as the shorter axis.
    fn along(&self, at: DVec2, a: DVec2, b: DVec2) -> Option<Texel> {
        let sum = 0.5 * (a.length_squared() + b.length_squared());
        let difference = 0.5 * (a.length_squared() - b.length_squared());
        let root = difference.hypot(a.dot(b));
        let longer = (sum + root).sqrt();
        let shorter = (sum - root).max(0.0).sqrt().max(longer / MOST_TAPS);
        let angle = 0.5 * a.dot(b).atan2(difference);
        let axis = a * angle.cos() + b * angle.sin();
        // One more tap is taken from a tenth of a width on.
        let taps = (longer / shorter.max(1.0) - 0.1).ceil().clamp(1.0, MOST_TAPS);
        let taps = if longer < SHARP { 1 } else { taps as u32 };
        let position = |tap: u32| at + axis * ((f64::from(tap) + 0.5) / f64::from(taps) - 0.5);
        let found: Vec<Texel> =
            (0..taps).filter_map(|tap| self.between_levels(position(tap), level_of(shorter))).collect();
        // Outside of what the photo shows there is no valid colour, so taps are weighted by their confidence.
        let trusted: f64 = found.iter().map(|texel| texel.confidence).sum();
        let mut mean = Texel::default();
        found.iter().for_each(|texel| mean.add(texel.confidence / trusted.max(1e-6), texel));
        mean.confidence = trusted / f64::from(taps);
        (!found.is_empty()).then_some(mean)
    }

    /// Interpolates between two levels; where one has no tile, the other's colour is taken.
    fn between_levels(&self, at: DVec2, level: f64) -> Option<Texel> {
        let level = level.min((self.pyramid.levels.len() - 1) as f64);
        let (fine, share) = (level.floor() as u32, level.fract());
        if share == 0.0 {
            return self.in_level(at, fine);
        }
        match (self.in_level(at, fine), self.in_level(at, fine + 1)) {
            (Some(fine), Some(coarse)) => {
                let mut mixed = Texel::default();
                mixed.add(1.0 - share, &fine);
                mixed.add(share, &coarse);
                Some(mixed)
            }
            (Some(fine), None) => Some(Texel { confidence: (1.0 - share) * fine.confidence, ..fine }),
            (None, Some(coarse)) => Some(Texel { confidence: share * coarse.confidence, ..coarse }),
            (None, None) => None,
        }
    }

    /// Interpolates between four texels of a level; `at` in texels of level 0 from the layer texture's corner.
    /// Returns `None` where the level has no tile. It is written out, without `raster::bilinear`, so that it reads like
    /// the shader, with the shader's dead zones.
    fn in_level(&self, at: DVec2, level: u32) -> Option<Texel> {
        let [width, height] = self.pyramid.shape.size(level).map(f64::from);
        let at = at.clamp(DVec2::ZERO, self.size()) * DVec2::new(width, height) / self.size();
        let tile = |at: f64, size: f64| (at.min(size - 1.0) / f64::from(TILE)) as u32;
        if !self.occupancy.holds(level, tile(at.x, width), tile(at.y, height)) {
            return None;
        }
        let base = (at - 0.5).floor();
        let share = ((at - 0.5 - base - DEAD) / (1.0 - 2.0 * DEAD)).clamp(DVec2::ZERO, DVec2::ONE);
        let mut between = Texel::default();
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let along = |step: i32, share: f64| if step == 1 { share } else { 1.0 - share };
            let weight = along(dx, share.x) * along(dy, share.y);
            between.add(weight, &self.decoded(level as usize, base.x as i32 + dx, base.y as i32 + dy));
        }
        Some(between)
    }

    /// Decodes a texel of a level; it is empty outside of the part that is kept.
    fn decoded(&self, level: usize, x: i32, y: i32) -> Texel {
        let of_colour = &self.pyramid.levels[level];
        let matte = self.matte.as_ref().map(|matte| &matte.levels[level]);
        if !of_colour.rect.contains(x, y) {
            return Texel { matte: if matte.is_some() { 0.0 } else { 1.0 }, ..Texel::default() };
        }
        let at = of_colour.index(x, y);
        let [r, g, b, confidence] = [0, 1, 2, 3].map(|channel| of_colour.rgba[at + channel]);
        let colour = [r, g, b].map(|byte| f64::from(LINEAR_FROM_BYTE[usize::from(byte)]));
        let share = |byte: u8| f64::from(byte) / 255.0;
        let matte = matte.map_or(1.0, |matte| share(matte.rgba[at + 3]));
        Texel { colour, matte, confidence: share(confidence) }
    }
}

/// Returns the level, fractional, whose texels are as wide as the footprint.
fn level_of(footprint: f64) -> f64 {
    (footprint / SHARP).log2().max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_footprint_that_reaches_past_what_the_photo_shows_is_not_darkened_by_it() {
        // White in the left half; in the same tiles, nothing.
        let rect = PixelRect::of_size(64, 64);
        let kept = PixelRect { w: 32, ..rect };
        let pixels = LayerTexturePixels {
            rect: kept,
            rgba: vec![255; 4 * 32 * 64],
            needed: vec![1; 32 * 64],
            matte: None,
        };
        let lookup = Lookup::new(rect, &pixels, &PyramidOptions::default());
        let long = Footprint::Sides(DVec2::new(16.0, 0.0), DVec2::new(0.0, 2.0));
        let texel = lookup.texel(DVec2::new(30.0, 32.0), long).unwrap();
        // The tolerance allows for 8 bits at the border of the content, where colour is extended.
        assert!(texel.colour.iter().all(|c| (c - 1.0).abs() < 0.01), "{texel:?}");
        assert!(texel.confidence > 0.0 && texel.confidence < 0.6, "{texel:?}");
    }
}
