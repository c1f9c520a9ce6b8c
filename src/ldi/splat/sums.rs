//! Sums of weights in two slots a pixel, near and far, in linear light: closes cracks without blurring what is not magnified,
//! keeps silhouettes soft, and hardly depends on the order of drawing.

mod slot;
#[cfg(test)]
mod tests;

use std::f32::consts::SQRT_2;

use glam::Vec4;

pub use self::slot::Slot;
use self::slot::{SlotAddition, add_apart, add_to_four};
use super::{BatchPositions, Canvas, Dot, floor_of_positive, index_of};
use crate::layout::DepthPixelOrigin;
use crate::stretch::{CLOSED, LONGEST, Parallelogram};
use crate::transfer::Positions;
use quadratura_view::srgb::Srgb;

/// The largest half side of a square splat in pixels: what is magnified more lets through what is behind it.
pub const LARGEST: f32 = 8.0;
/// Up to this spacing, splats have a half side of no more than 1: also on a grid turned by 45 degrees, the weights at a pixel sum
/// up to more than what is opaque.
pub const CLOSED_BY_ONE: f32 = 1.25;
/// The least half side of a splat in pixels. Splats are as large as the gaps between depth pixels, so that they blur no more than
/// they must; smaller ones would alias. docs/quality.md has the figures.
pub const LEAST: f32 = 0.75;
/// The tolerance within which inverse depths are of one surface, as a share, where it is not known that they are of two. Figures
/// at 0.02 and 0.05 are the same.
pub const LEVEL: f32 = 0.02;
/// The same where two surfaces are known, to which comes what they change within [`APART_PIXELS`]: such surfaces share a
/// slot where they meet, or one lies on the other, and not where one hides the other.
pub const APART: f32 = 0.002;
/// How many half sides of a splat two depth pixels may be apart at one pixel, along the steeper one of their planes.
pub const APART_PIXELS: f32 = 1.5;
/// A depth pixel is not drawn where the next nearer one of its ray is opaque, nearly as far away (see [`LEVEL`]), and no farther
/// from it in the picture than this, in pixels along either axis: it is behind it, and sums would mix them, as where a wall meets
/// the edge of one that hides it.
pub const COVERS: f32 = 0.5;
/// The sum of weights above which a slot holds more than one surface: planes whose pixels do not lie on a grid with the
/// picture's sum up to 1 within a quarter.
pub const OVERFULL: f32 = 1.25;
/// A near slot of less weight than this is replaced by a nearer surface, not moved to the far slot.
pub const SLIGHT: f32 = 0.05;
/// The weight of a slot from which on it is opaque: a quarter, which is what a plane of spacing 2 has between its dots.
pub const PER_OPAQUE: f32 = 4.0;

/// What is summed up for a picture, in fours: opacity times linear light R, G, B, and opacity.
pub const COLOUR: usize = 1;
/// What is summed up for a picture that is blended with others: the same, then the spacing, 1 where the colour is what the
/// reference camera saw or paint and 0 where it is filled in, 1 where it is paint, and the inverse depth.
pub const BLENDED: usize = 2;

/// A band with two slots a pixel. Around it is a border of one pixel, so that nothing needs to be clipped that is drawn on four
/// pixels.
#[derive(Debug)]
pub struct SumsCanvas<'a, const N: usize> {
    width: i32,
    height: i32,
    /// The near slots of each pixel, row by row, with the border.
    near: Vec<Slot<N>>,
    /// The far slots likewise.
    far: Vec<Slot<N>>,
    /// Whether any of [`FAR_BLOCK`] far slots is used: most are not, and need no look.
    far_used: Vec<bool>,
    /// Where the depth pixels of a batch are drawn.
    fours: Fours,
    /// Linear light by stored value, at the picture's exposure, R, G, B.
    light: &'a [[f32; 256]; 3],
    /// The number of depth pixels that are magnified too much.
    pub too_near: u64,
}

/// The four pixels around each depth pixel of a batch.
#[derive(Debug)]
struct Fours {
    /// The index of the left upper one; [`OTHERS`] for depth pixels that are outside, magnified or stretched.
    at: [u32; Positions::MOST],
    /// The weights: left and right upper one, left and right lower one.
    weights: [[f32; Positions::MOST]; 4],
}

const OTHERS: u32 = u32::MAX;
/// The number of far slots for which it is known together whether any is used.
const FAR_BLOCK: usize = 16;

impl Default for Fours {
    fn default() -> Self {
        Self { at: [OTHERS; Positions::MOST], weights: [[0.0; Positions::MOST]; 4] }
    }
}

impl Fours {
    /// Finds the pixels of a batch in a band.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    fn find(&mut self, batch: &BatchPositions, [width, height]: [f32; 2]) {
        let Self { at, weights: [a, b, c, d] } = self;
        let count = batch.u.len();
        let (us, vs, ss) = (batch.u, &batch.v[..count], &batch.s[..count]);
        let (at, a, b) = (&mut at[..count], &mut a[..count], &mut b[..count]);
        let (c, d) = (&mut c[..count], &mut d[..count]);
        for i in 0..count {
            let (u, v, s) = (us[i] - 0.5, vs[i] - batch.top - 0.5, ss[i]);
            let (x, y) = (floor_of_positive(u + 16.0) - 16.0, floor_of_positive(v + 16.0) - 16.0);
            let (right, lower) = (u - x, v - y);
            let within_one = s.min(1.0);
            let per_side = 1.0 / within_one.max(LEAST);
            let full = (within_one * per_side) * (within_one * per_side);
            let tent = |apart: f32| (1.0 - apart * per_side).max(0.0);
            let (upper_row, lower_row) = (full * tent(lower), full * tent(1.0 - lower));
            let (left_column, right_column) = (tent(right), tent(1.0 - right));
            (a[i], b[i]) = (upper_row * left_column, upper_row * right_column);
            (c[i], d[i]) = (lower_row * left_column, lower_row * right_column);
            // Positions that are no numbers fail all comparisons.
            let within =
                (s >= 0.0) & (u > -1.0) & (u < width) & (v > -1.0) & (v < height) & (s <= CLOSED_BY_ONE);
            let index = index_of((y + 1.0) * (width + 2.0) + (x + 1.0));
            at[i] = if within { index } else { OTHERS };
        }
    }
}

impl<'a, const N: usize> SumsCanvas<'a, N> {
    /// Makes an empty band.
    pub fn new(width: u32, height: u32, light: &'a [[f32; 256]; 3]) -> Self {
        let pixels = (width as usize + 2) * (height as usize + 2);
        let (near, far) = (vec![Slot::default(); pixels], vec![Slot::default(); pixels]);
        Self {
            width: width as i32,
            height: height as i32,
            near,
            far,
            far_used: vec![false; pixels.div_ceil(FAR_BLOCK)],
            fours: Fours::default(),
            light,
            too_near: 0,
        }
    }

    /// Returns an empty band as another one whose colours were written; `height` is at most its own.
    pub fn again(self, height: u32) -> Self {
        Self { height: height as i32, too_near: 0, ..self }
    }

    /// Returns the band with the linear light by stored value of the next image that is drawn on it.
    pub fn lit(self, light: &'a [[f32; 256]; 3]) -> Self {
        Self { light, ..self }
    }

    /// Returns the near and the far slot of a pixel.
    #[inline(always)]
    pub fn slots(&self, x: u32, y: u32) -> [&Slot<N>; 2] {
        let at = (y as usize + 1) * self.stride() + x as usize + 1;
        [&self.near[at], &self.far[at]]
    }

    #[inline(always)]
    fn stride(&self) -> usize {
        self.width as usize + 2
    }

    /// Writes the colours, near over far, row by row, and empties the band while its slots are at hand.
    // Iterators are calls in the profile `quick`.
    #[allow(clippy::needless_range_loop)]
    pub fn write_colours(&mut self, out: &mut [[u8; 4]]) {
        let (srgb, width, stride) = (Srgb::tables(), self.width as usize, self.stride());
        for (y, row) in out.chunks_exact_mut(width).enumerate() {
            let start = (y + 1) * stride + 1;
            for x in 0..width {
                let at = start + x;
                let far = if self.far_used[at / FAR_BLOCK] { self.far[at] } else { Slot::default() };
                row[x] = over(&self.near[at], &far, srgb);
                self.near[at] = Slot::default();
            }
        }
        self.empty_border();
        self.empty_far();
    }

    /// Empties the near slots around the band.
    fn empty_border(&mut self) {
        let (stride, rows) = (self.stride(), self.height as usize + 2);
        self.near[..stride].fill(Slot::default());
        self.near[(rows - 1) * stride..rows * stride].fill(Slot::default());
        for row in self.near.chunks_exact_mut(stride).take(rows) {
            (row[0], row[stride - 1]) = (Slot::default(), Slot::default());
        }
    }

    /// Empties the far slots that are used.
    fn empty_far(&mut self) {
        for (used, block) in self.far_used.iter_mut().zip(self.far.chunks_mut(FAR_BLOCK)) {
            if std::mem::take(used) {
                block.fill(Slot::default());
            }
        }
    }
}

/// Returns the colour of a pixel: near over far.
#[inline(always)]
fn over<const N: usize>(near: &Slot<N>, far: &Slot<N>, srgb: Srgb) -> [u8; 4] {
    let mut sum = near.covering(0.0)[0];
    if far.weight() > 0.0 {
        sum += far.covering(near.weight())[0] * (1.0 - sum.w);
    }
    let share = sum.w;
    if share <= 0.0 {
        return [0; 4];
    }
    let [r, g, b] = srgb.encoded_colour(sum / share);
    let whole = (share * 255.0) as u8;
    let part = share * 255.0 - f32::from(whole);
    [r, g, b, whole.saturating_add(u8::from(part >= 0.5))]
}

/// Returns the largest whole number that is not above a value of at least -16.
#[inline(always)]
fn floor(value: f32) -> i32 {
    // A cast drops the fraction; `f32::floor` is a call on processors without an instruction for it.
    (value + 16.0) as i32 - 16
}

impl<const N: usize> Canvas for SumsCanvas<'_, N> {
    const SPACED: bool = true;
    const COVERED: bool = true;
    const STRETCHED: bool = true;
    const ORIGINS: bool = N == BLENDED;
    const REACH: f32 = LONGEST;

    #[inline]
    fn reach(largest_spacing: f32, largest_stretch: f32) -> f32 {
        let of_square = largest_spacing.clamp(1.0, LARGEST);
        if largest_stretch <= CLOSED {
            return of_square;
        }
        // Half a diagonal; no number where both are unlimited.
        let of_stretched = SQRT_2 * largest_stretch + LEAST;
        of_square.max(if of_stretched < LONGEST { of_stretched } else { LONGEST })
    }

    #[inline(always)]
    fn begin(&mut self, batch: &BatchPositions) {
        self.fours.find(batch, [self.width as f32, self.height as f32]);
    }

    #[inline(always)]
    fn draw(&mut self, dot: &Dot) {
        let at = self.fours.at[dot.at];
        if at == OTHERS {
            // A copy, so that the usual case has no depth pixel in memory.
            let other = *dot;
            self.draw_other(&other);
            return;
        }
        let [a, b, c, d] = &self.fours.weights;
        let weights = Vec4::new(a[dot.at], b[dot.at], c[dot.at], d[dot.at]);
        let (at, stride, addition) = (at as usize, self.stride(), self.addition(dot, 1.0));
        let (upper, lower) = self.near[at..at + stride + 2].split_at_mut(stride);
        let ([a, b, ..], [c, d]) = (upper, lower) else { return };
        if !add_to_four([a, b, c, d], weights, &addition) {
            let copied = addition;
            self.add_one_by_one(at, weights.to_array(), &copied);
        }
    }
}

impl<const N: usize> SumsCanvas<'_, N> {
    /// Returns what a depth pixel adds whose splat has this half side.
    #[inline(always)]
    fn addition(&self, dot: &Dot, radius: f32) -> SlotAddition<N> {
        let [r, g, b, a] = dot.colour;
        let opacity = f32::from(a) * (1.0 / 255.0);
        let light = |c: usize, value: u8| self.light[c][usize::from(value)];
        let mut seen = [Vec4::ZERO; N];
        seen[0] = opacity * Vec4::new(light(0, r), light(1, g), light(2, b), 1.0);
        if N == BLENDED {
            let own = f32::from(u8::from(dot.origin <= DepthPixelOrigin::Paint));
            let paint = f32::from(u8::from(dot.origin == DepthPixelOrigin::Paint));
            seen[COLOUR] = Vec4::new(dot.s.abs(), own, paint, dot.q);
        }
        let along = APART_PIXELS * radius;
        SlotAddition { q: dot.q, surface: dot.surface as f32, slope: dot.slope, along, seen }
    }

    /// Draws a depth pixel that is magnified, stretched, or outside of the band.
    #[inline(never)]
    fn draw_other(&mut self, dot: &Dot) {
        if dot.s < 0.0 {
            self.draw_stretched(dot);
            return;
        }
        let radius = dot.s.min(LARGEST);
        let (u, v) = (dot.u - 0.5, dot.v - 0.5);
        let within = u > -radius && u < self.width as f32 - 1.0 + radius;
        // Positions that are no numbers fail both comparisons.
        if dot.s > CLOSED_BY_ONE && within && v > -radius && v < self.height as f32 - 1.0 + radius {
            self.too_near += u64::from(dot.s > LARGEST);
            self.add_around(u, v, radius, &self.addition(dot, radius));
        }
    }

    /// Draws a depth pixel that is a parallelogram. At each pixel its inverse depth is that of its plane there.
    fn draw_stretched(&mut self, dot: &Dot) {
        let (u, v) = (dot.u - 0.5, dot.v - 0.5);
        let (right, bottom) = (self.width as f32 - 1.0, self.height as f32 - 1.0);
        let meets = |along_u: f32, along_v: f32| {
            (u > -along_u) & (u < right + along_u) & (v > -along_v) & (v < bottom + along_v)
        };
        // Positions that are no numbers fail all comparisons.
        if !meets(LONGEST, LONGEST) {
            return;
        }
        let shape = Parallelogram::new(&dot.stretch.jacobian, LEAST);
        let [along_u, along_v] = shape.reach;
        if !meets(along_u, along_v) {
            return;
        }
        self.too_near += u64::from(shape.is_cut);
        let [of_u, of_v] = dot.stretch.gradient;
        let mut addition = self.addition(dot, 1.0);
        // Numbers below -16 may be rounded up: they are left of the band, or above it, either way.
        let rows = (floor(v - along_v) + 1).max(0)..(floor(v + along_v) + 1).min(self.height);
        for j in rows {
            let (start, dv) = ((j + 1) as usize * self.stride() + 1, j as f32 - v);
            let [low, high] = shape.extent(dv);
            for i in (floor(u + low) + 1).max(0)..(floor(u + high) + 1).min(self.width) {
                let du = i as f32 - u;
                addition.q = dot.q + of_u * du + of_v * dv;
                if N == BLENDED {
                    addition.seen[COLOUR].w = addition.q;
                }
                // Behind the plane's horizon it is not seen.
                if addition.q >= 0.0 {
                    self.add(start + i as usize, shape.weight(du, dv), &addition);
                }
            }
        }
    }

    /// Adds a depth pixel to the slots of four pixels, of which `at` is the left upper one.
    #[inline(never)]
    fn add_one_by_one(&mut self, at: usize, weights: [f32; 4], addition: &SlotAddition<N>) {
        let stride = self.stride();
        let [a, b, c, d] = weights;
        self.add(at, a, addition);
        self.add(at + 1, b, addition);
        self.add(at + stride, c, addition);
        self.add(at + stride + 1, d, addition);
    }

    /// Adds to the slots of a pixel. Empty slots hold zeros, to which their first depth pixel is added.
    #[inline]
    fn add(&mut self, at: usize, weight: f32, addition: &SlotAddition<N>) {
        if weight <= 0.0 {
            return;
        }
        let near = &mut self.near[at];
        if near.holds(addition) | (near.weight() == 0.0) {
            near.add(weight, addition);
        } else {
            self.far_used[at / FAR_BLOCK] = true;
            add_apart(near, &mut self.far[at], weight, addition);
        }
    }

    /// Adds a depth pixel to the pixels whose centres are nearer than `radius`, along either axis.
    fn add_around(&mut self, u: f32, v: f32, radius: f32, addition: &SlotAddition<N>) {
        let per_radius = 1.0 / radius;
        let columns = (floor(u - radius) + 1).max(0)..(floor(u + radius) + 1).min(self.width);
        let rows = (floor(v - radius) + 1).max(0)..(floor(v + radius) + 1).min(self.height);
        for j in rows {
            let of_row = 1.0 - (j as f32 - v).abs() * per_radius;
            let start = (j + 1) as usize * self.stride() + 1;
            for i in columns.clone() {
                let weight = of_row * (1.0 - (i as f32 - u).abs() * per_radius);
                self.add(start + i as usize, weight, addition);
            }
        }
    }
}
