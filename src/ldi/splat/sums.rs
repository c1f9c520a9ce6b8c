//! Sums of weights in two slots a pixel, near and far, in linear light: closes cracks without blurring what is not magnified,
//! keeps silhouettes soft, and hardly depends on the order of drawing.

use super::{Canvas, Dot};
use crate::ldi::layout::DepthPixelOrigin;
use crate::projection::srgb::Srgb;

/// The largest half side of a splat in pixels: what is magnified more lets through what is behind it.
pub const LARGEST: f32 = 8.0;
/// Up to this spacing, splats have a half side of 1: also on a grid turned by 45 degrees, the weights at a pixel sum up to more
/// than what is opaque.
const CLOSED_BY_ONE: f32 = 1.25;
/// The tolerance within which inverse depths are of one surface, as a share. Figures at 0.02 and 0.05 are the same.
pub const LEVEL: f32 = 0.02;
/// The sum of weights above which a slot holds more than one surface: planes whose pixels do not lie on a grid with the
/// picture's sum up to 1 within a quarter.
const OVERFULL: f32 = 1.25;
/// A near slot of less weight than this is replaced by a nearer surface, not moved to the far slot.
const SLIGHT: f32 = 0.05;
/// The weight of a slot from which on it is opaque: a quarter, which is what a plane of spacing 2 has between its dots.
const PER_OPAQUE: f32 = 4.0;

/// What is summed up for a picture: opacity times linear light R, G, B, and opacity.
pub const COLOUR: usize = 4;
/// What is summed up for a picture that is blended with others: the same, then the spacing, 1 where the colour is what the
/// reference camera saw or paint and 0 where it is filled in, 1 where it is paint, and the inverse depth.
pub const BLENDED: usize = 8;

/// The sums of one surface at a pixel; the weight is 0 where there is none.
#[derive(Debug, Clone, Copy)]
pub struct Slot<const N: usize> {
    /// Inverse depth in the picture's camera, in 1/world unit.
    pub q: f32,
    /// The sum of weights.
    pub weight: f32,
    /// The sums of weights times values: see [`COLOUR`] and [`BLENDED`].
    pub seen: [f32; N],
}

impl<const N: usize> Default for Slot<N> {
    fn default() -> Self {
        Self { q: 0.0, weight: 0.0, seen: [0.0; N] }
    }
}

impl<const N: usize> Slot<N> {
    fn new(q: f32, weight: f32, seen: [f32; N]) -> Self {
        Self { q, weight, seen: seen.map(|value| value * weight) }
    }

    /// Adds a depth pixel. A surface's weights make 1 where it covers a pixel, so what is far beyond 1 belongs to another
    /// surface at nearly the same depth, such as a window before its wall: the later one, which is nearer, replaces that
    /// share of what is there.
    #[inline(always)]
    fn add(&mut self, q: f32, weight: f32, seen: [f32; N]) {
        self.q = self.q.max(q);
        if self.weight + weight > OVERFULL {
            // What is translucent replaces only as much as it covers.
            let covered = weight * seen[3];
            let left = (1.0 - covered) / self.weight;
            self.weight = 1.0;
            self.seen = std::array::from_fn(|i| self.seen[i] * left + weight * seen[i]);
            return;
        }
        self.weight += weight;
        self.seen = std::array::from_fn(|i| self.seen[i] + weight * seen[i]);
    }

    #[inline(always)]
    fn holds(&self, q: f32) -> bool {
        (q - self.q).abs() <= LEVEL * self.q
    }

    /// Returns linear light R, G, B times the share of the pixel that the surface covers, that share, and further values
    /// times the share that it would cover if it were opaque.
    pub fn covering(&self) -> [f32; N] {
        if self.weight <= 0.0 {
            return [0.0; N];
        }
        let share = (PER_OPAQUE * self.weight).min(1.0) / self.weight;
        self.seen.map(|sum| sum * share)
    }
}

/// A band with two slots a pixel.
#[derive(Debug)]
pub struct SumsCanvas<'a, const N: usize> {
    width: i32,
    height: i32,
    /// Near and far, of each pixel, row by row.
    pub slots: Vec<[Slot<N>; 2]>,
    /// Linear light by stored value, at the picture's exposure, R, G, B.
    light: &'a [[f32; 256]; 3],
    /// The number of depth pixels that are magnified too much.
    pub too_near: u64,
}

impl<'a, const N: usize> SumsCanvas<'a, N> {
    /// Makes an empty band.
    pub fn new(width: u32, height: u32, light: &'a [[f32; 256]; 3]) -> Self {
        let slots = vec![[Slot::default(); 2]; width as usize * height as usize];
        Self { width: width as i32, height: height as i32, slots, light, too_near: 0 }
    }

    /// Returns the colours: near over far.
    pub fn colours(&self) -> impl Iterator<Item = [u8; 4]> + '_ {
        let srgb = Srgb::tables();
        self.slots.iter().map(move |[near, far]| {
            let (front, back) = (near.covering(), far.covering());
            let over = |i: usize| front[i] + back[i] * (1.0 - front[3]);
            let share = over(3);
            if share <= 0.0 {
                return [0; 4];
            }
            let colour = |c: usize| srgb.encoded(over(c) / share);
            [colour(0), colour(1), colour(2), (share * 255.0).round() as u8]
        })
    }
}

/// Adds to the slots of a pixel.
#[inline(always)]
fn add<const N: usize>(slots: &mut [Slot<N>; 2], q: f32, weight: f32, seen: [f32; N]) {
    let [near, far] = slots;
    if near.weight == 0.0 {
        *near = Slot::new(q, weight, seen);
    } else if near.holds(q) {
        near.add(q, weight, seen);
    } else if q > near.q {
        if near.weight > SLIGHT || near.weight > far.weight {
            *far = *near;
        }
        *near = Slot::new(q, weight, seen);
    } else if far.weight > 0.0 && far.holds(q) {
        far.add(q, weight, seen);
    } else if far.weight == 0.0 || q > far.q {
        *far = Slot::new(q, weight, seen);
    }
}

/// Returns the largest whole number that is not above a value of at least -16.
#[inline(always)]
fn floor(value: f32) -> i32 {
    // A cast drops the fraction; `f32::floor` is a call on processors without an instruction for it.
    (value + 16.0) as i32 - 16
}

impl<const N: usize> Canvas for SumsCanvas<'_, N> {
    const SPACED: bool = true;
    const ORIGINS: bool = N == BLENDED;
    const REACH: f32 = LARGEST;

    #[inline(always)]
    fn draw(&mut self, dot: &Dot) {
        let radius = if dot.s <= CLOSED_BY_ONE { 1.0 } else { dot.s.min(LARGEST) };
        let (u, v) = (dot.u - 0.5, dot.v - 0.5);
        let within = u > -radius && u < self.width as f32 - 1.0 + radius;
        // Positions that are no numbers fail both comparisons.
        if !(within && v > -radius && v < self.height as f32 - 1.0 + radius) {
            return;
        }
        self.too_near += u64::from(dot.s > LARGEST);
        let shrink = dot.s.min(1.0);
        let full = shrink * shrink;
        let [r, g, b, a] = dot.colour;
        let opacity = f32::from(a) * (1.0 / 255.0);
        let light = |c: usize, byte: u8| opacity * self.light[c][usize::from(byte)];
        let mut seen = [0.0; N];
        seen[..COLOUR].copy_from_slice(&[light(0, r), light(1, g), light(2, b), opacity]);
        if N == BLENDED {
            seen[COLOUR] = dot.s;
            seen[COLOUR + 1] = f32::from(u8::from(dot.origin <= DepthPixelOrigin::Paint));
            seen[COLOUR + 2] = f32::from(u8::from(dot.origin == DepthPixelOrigin::Paint));
            seen[COLOUR + 3] = dot.q;
        }
        if dot.s <= CLOSED_BY_ONE {
            self.add_to_four(u, v, full, dot.q, seen);
        } else {
            self.add_around(u, v, radius, dot.q, seen);
        }
    }
}

impl<const N: usize> SumsCanvas<'_, N> {
    /// Adds a depth pixel to the four pixels whose centres are around its position.
    #[inline(always)]
    fn add_to_four(&mut self, u: f32, v: f32, full: f32, q: f32, seen: [f32; N]) {
        let (x, y) = (floor(u), floor(v));
        let (right, lower) = (u - x as f32, v - y as f32);
        for (j, of_row) in [(y, full * (1.0 - lower)), (y + 1, full * lower)] {
            if j < 0 || j >= self.height {
                continue;
            }
            let start = (j * self.width) as usize;
            let row = &mut self.slots[start..start + self.width as usize];
            for (i, weight) in [(x, of_row * (1.0 - right)), (x + 1, of_row * right)] {
                if weight > 0.0
                    && let Some(slots) = row.get_mut(i as usize)
                {
                    add(slots, q, weight, seen);
                }
            }
        }
    }

    /// Adds a depth pixel to the pixels whose centres are nearer than `radius`, along either axis.
    #[inline(never)]
    fn add_around(&mut self, u: f32, v: f32, radius: f32, q: f32, seen: [f32; N]) {
        let per_radius = 1.0 / radius;
        let columns = (floor(u - radius) + 1).max(0)..(floor(u + radius) + 1).min(self.width);
        let rows = (floor(v - radius) + 1).max(0)..(floor(v + radius) + 1).min(self.height);
        for j in rows {
            let of_row = 1.0 - (j as f32 - v).abs() * per_radius;
            let start = (j * self.width) as usize;
            let row = &mut self.slots[start + columns.start as usize..start + columns.end as usize];
            for (i, slots) in columns.clone().zip(row) {
                let weight = of_row * (1.0 - (i as f32 - u).abs() * per_radius);
                if weight > 0.0 {
                    add(slots, q, weight, seen);
                }
            }
        }
    }
}
