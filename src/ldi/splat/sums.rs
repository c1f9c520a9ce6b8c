//! Sums of weights in two slots a pixel, near and far, in linear light: closes cracks without blurring what is not magnified,
//! keeps silhouettes soft, and hardly depends on the order of drawing.

use super::{Canvas, Dot, Placed, floor_of_positive, index_of};
use crate::ldi::layout::DepthPixelOrigin;
use crate::ldi::transfer::Positions;
use crate::projection::srgb::Srgb;

/// The largest half side of a splat in pixels: what is magnified more lets through what is behind it.
pub const LARGEST: f32 = 8.0;
/// Up to this spacing, splats have a half side of 1: also on a grid turned by 45 degrees, the weights at a pixel sum up to more
/// than what is opaque.
pub const CLOSED_BY_ONE: f32 = 1.25;
/// The tolerance within which inverse depths are of one surface, as a share, where it is not known that they are of two. Figures
/// at 0.02 and 0.05 are the same.
pub const LEVEL: f32 = 0.02;
/// The same where two surfaces are known, to which comes what they change within [`APART_PIXELS`]: such surfaces share a
/// slot where they meet, or one lies on the other, and not where one hides the other.
pub const APART: f32 = 0.002;
/// How many half sides of a splat two depth pixels may be apart at one pixel, along the steeper one of their planes.
pub const APART_PIXELS: f32 = 1.5;
/// The sum of weights above which a slot holds more than one surface: planes whose pixels do not lie on a grid with the
/// picture's sum up to 1 within a quarter.
pub const OVERFULL: f32 = 1.25;
/// A near slot of less weight than this is replaced by a nearer surface, not moved to the far slot.
pub const SLIGHT: f32 = 0.05;
/// The weight of a slot from which on it is opaque: a quarter, which is what a plane of spacing 2 has between its dots.
pub const PER_OPAQUE: f32 = 4.0;

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
    /// The surface of the depth pixel that was drawn last, 0 where it is unknown.
    surface: u32,
    /// Its slope, see [`Dot::slope`].
    slope: f32,
    /// The sums of weights times values: see [`COLOUR`] and [`BLENDED`].
    pub seen: [f32; N],
}

/// What a depth pixel adds to the slots of its pixels.
#[derive(Debug, Clone, Copy)]
struct Sample<const N: usize> {
    q: f32,
    surface: u32,
    slope: f32,
    /// Along how many pixels its slope counts.
    along: f32,
    /// What it adds for a weight of 1.
    seen: [f32; N],
}

impl<const N: usize> Default for Slot<N> {
    fn default() -> Self {
        Self { q: 0.0, weight: 0.0, surface: 0, slope: 0.0, seen: [0.0; N] }
    }
}

impl<const N: usize> Slot<N> {
    #[inline(always)]
    fn new(weight: f32, sample: &Sample<N>) -> Self {
        let Sample { q, surface, slope, seen, .. } = *sample;
        let mut slot = Self { q, weight, surface, slope, seen: [0.0; N] };
        slot.add_share(weight, &seen);
        slot
    }

    /// Adds a depth pixel. A surface's weights make 1 where it covers a pixel, so what is far beyond 1 belongs to another
    /// surface at nearly the same depth, such as a window before its wall: the later one, which is nearer, replaces that
    /// share of what is there.
    #[inline(always)]
    fn add(&mut self, weight: f32, sample: &Sample<N>) {
        let Sample { q, surface, slope, seen, .. } = sample;
        self.q = self.q.max(*q);
        (self.surface, self.slope) = (*surface, *slope);
        let sum = self.weight + weight;
        if sum > OVERFULL {
            self.keep_beside(weight * seen[3]);
        } else {
            self.weight = sum;
        }
        self.add_share(weight, seen);
    }

    /// Leaves room for what covers this share: what is translucent replaces only as much as it covers. The weight becomes 1.
    #[inline(never)]
    fn keep_beside(&mut self, covered: f32) {
        let left = (1.0 - covered) / self.weight;
        self.weight = 1.0;
        for sum in &mut self.seen {
            *sum *= left;
        }
    }

    #[inline(always)]
    // Iterators are calls in the profile `quick`, which does not optimise across all functions.
    #[allow(clippy::needless_range_loop)]
    fn add_share(&mut self, weight: f32, seen: &[f32; N]) {
        for i in 0..N {
            self.seen[i] += weight * seen[i];
        }
    }

    /// Returns whether a depth pixel is of the slot's surface, lies on it or meets it.
    #[inline(always)]
    fn holds(&self, Sample { q, surface, slope, along, .. }: &Sample<N>) -> bool {
        let of_two = (*surface != self.surface) & (*surface != 0) & (self.surface != 0);
        let (one, two) = (LEVEL * self.q, APART * self.q + along * slope.max(self.slope));
        (q - self.q).abs() <= if of_two { one.min(two) } else { one }
    }

    /// Returns linear light R, G, B times the share of the pixel that the surface covers, that share, and further values
    /// times the share that it would cover if it were opaque.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub fn covering(&self) -> [f32; N] {
        let mut covering = [0.0; N];
        if self.weight > 0.0 {
            let share = (PER_OPAQUE * self.weight).min(1.0) / self.weight;
            for i in 0..N {
                covering[i] = self.seen[i] * share;
            }
        }
        covering
    }
}

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
    /// The index of the left upper one; [`OTHERS`] for depth pixels that are outside or magnified.
    at: [u32; Positions::MOST],
    /// The weights: left and right upper one, left and right lower one.
    weights: [[f32; Positions::MOST]; 4],
}

const OTHERS: u32 = u32::MAX;

impl Default for Fours {
    fn default() -> Self {
        Self { at: [OTHERS; Positions::MOST], weights: [[0.0; Positions::MOST]; 4] }
    }
}

impl Fours {
    /// Finds the pixels of a batch in a band.
    #[inline(always)]
    fn find(&mut self, batch: &Placed, [width, height]: [f32; 2]) {
        let Self { at, weights: [a, b, c, d] } = self;
        let places = batch.u.iter().zip(batch.v).zip(batch.s);
        let found = at.iter_mut().zip(a).zip(b).zip(c).zip(d);
        for (((u, v), s), ((((at, a), b), c), d)) in places.zip(found) {
            let (u, v) = (u - 0.5, v - batch.top - 0.5);
            let (x, y) = (floor_of_positive(u + 16.0) - 16.0, floor_of_positive(v + 16.0) - 16.0);
            let (right, lower) = (u - x, v - y);
            let shrink = s.min(1.0);
            let full = shrink * shrink;
            let (upper_row, lower_row) = (full * (1.0 - lower), full * lower);
            (*a, *b) = (upper_row * (1.0 - right), upper_row * right);
            (*c, *d) = (lower_row * (1.0 - right), lower_row * right);
            // Positions that are no numbers fail all comparisons.
            let within = (u > -1.0) & (u < width) & (v > -1.0) & (v < height) & (*s <= CLOSED_BY_ONE);
            let index = index_of((y + 1.0) * (width + 2.0) + (x + 1.0));
            *at = if within { index } else { OTHERS };
        }
    }
}

impl<'a, const N: usize> SumsCanvas<'a, N> {
    /// Makes an empty band.
    pub fn new(width: u32, height: u32, light: &'a [[f32; 256]; 3]) -> Self {
        let empty = || vec![Slot::default(); (width as usize + 2) * (height as usize + 2)];
        let (near, far) = (empty(), empty());
        Self {
            width: width as i32,
            height: height as i32,
            near,
            far,
            fours: Fours::default(),
            light,
            too_near: 0,
        }
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

    /// Writes the colours, near over far, row by row.
    pub fn write_colours(&self, out: &mut [[u8; 4]]) {
        let srgb = Srgb::tables();
        let width = self.width as usize;
        for (y, row) in out.chunks_exact_mut(width).enumerate() {
            let start = (y + 1) * self.stride() + 1;
            let slots = self.near[start..start + width].iter().zip(&self.far[start..start + width]);
            for (pixel, (near, far)) in row.iter_mut().zip(slots) {
                *pixel = over(near, far, srgb);
            }
        }
    }
}

/// Returns the colour of a pixel: near over far.
#[inline(always)]
#[allow(clippy::needless_range_loop)]
fn over<const N: usize>(near: &Slot<N>, far: &Slot<N>, srgb: Srgb) -> [u8; 4] {
    let mut sum = near.covering();
    if far.weight > 0.0 {
        let (back, left) = (far.covering(), 1.0 - sum[3]);
        for i in 0..COLOUR {
            sum[i] += back[i] * left;
        }
    }
    let share = sum[3];
    if share <= 0.0 {
        return [0; 4];
    }
    let [r, g, b] = [sum[0] / share, sum[1] / share, sum[2] / share];
    let whole = (share * 255.0) as u8;
    let part = share * 255.0 - f32::from(whole);
    [srgb.encoded(r), srgb.encoded(g), srgb.encoded(b), whole.saturating_add(u8::from(part >= 0.5))]
}

/// Adds what is not level with the near slot.
#[inline(never)]
fn add_apart<const N: usize>(near: &mut Slot<N>, far: &mut Slot<N>, weight: f32, sample: &Sample<N>) {
    if sample.q > near.q {
        if near.weight > SLIGHT || near.weight > far.weight {
            *far = *near;
        }
        *near = Slot::new(weight, sample);
    } else if far.weight == 0.0 || far.holds(sample) {
        far.add(weight, sample);
    } else if sample.q > far.q {
        *far = Slot::new(weight, sample);
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

    #[inline]
    fn reach(largest_spacing: f32) -> f32 {
        largest_spacing.clamp(1.0, LARGEST)
    }

    #[inline(always)]
    fn begin(&mut self, batch: &Placed) {
        self.fours.find(batch, [self.width as f32, self.height as f32]);
    }

    #[inline(always)]
    fn draw(&mut self, dot: &Dot) {
        let at = self.fours.at[dot.at];
        if at == OTHERS {
            self.draw_other(dot);
            return;
        }
        let (at, sample) = (at as usize, self.sample(dot, 1.0));
        let [a, b, c, d] = &self.fours.weights;
        let [a, b, c, d] = [a[dot.at], b[dot.at], c[dot.at], d[dot.at]];
        self.add_to_two(at, [a, b], &sample);
        self.add_to_two(at + self.stride(), [c, d], &sample);
    }
}

impl<const N: usize> SumsCanvas<'_, N> {
    /// Returns what a depth pixel adds whose splat has this half side.
    #[inline(always)]
    fn sample(&self, dot: &Dot, radius: f32) -> Sample<N> {
        let [r, g, b, a] = dot.colour;
        let opacity = f32::from(a) * (1.0 / 255.0);
        let mut seen = [0.0; N];
        seen[0] = opacity * self.light[0][usize::from(r)];
        seen[1] = opacity * self.light[1][usize::from(g)];
        seen[2] = opacity * self.light[2][usize::from(b)];
        seen[3] = opacity;
        if N == BLENDED {
            seen[COLOUR] = dot.s;
            seen[COLOUR + 1] = f32::from(u8::from(dot.origin <= DepthPixelOrigin::Paint));
            seen[COLOUR + 2] = f32::from(u8::from(dot.origin == DepthPixelOrigin::Paint));
            seen[COLOUR + 3] = dot.q;
        }
        Sample { q: dot.q, surface: dot.surface, slope: dot.slope, along: APART_PIXELS * radius, seen }
    }

    /// Draws a depth pixel that is magnified, or outside of the band.
    #[inline(never)]
    fn draw_other(&mut self, dot: &Dot) {
        let radius = dot.s.min(LARGEST);
        let (u, v) = (dot.u - 0.5, dot.v - 0.5);
        let within = u > -radius && u < self.width as f32 - 1.0 + radius;
        // Positions that are no numbers fail both comparisons.
        if dot.s > CLOSED_BY_ONE && within && v > -radius && v < self.height as f32 - 1.0 + radius {
            self.too_near += u64::from(dot.s > LARGEST);
            self.add_around(u, v, radius, &self.sample(dot, radius));
        }
    }

    /// Adds to the slots of a pixel. Empty slots hold zeros, to which their first depth pixel is added.
    #[inline(always)]
    fn add(&mut self, at: usize, weight: f32, sample: &Sample<N>) {
        if weight <= 0.0 {
            return;
        }
        let near = &mut self.near[at];
        if near.holds(sample) | (near.weight == 0.0) {
            near.add(weight, sample);
        } else {
            add_apart(near, &mut self.far[at], weight, sample);
        }
    }

    /// Adds a depth pixel to two neighbours in a row.
    #[inline(always)]
    fn add_to_two(&mut self, at: usize, [left, right]: [f32; 2], sample: &Sample<N>) {
        self.add(at, left, sample);
        self.add(at + 1, right, sample);
    }

    /// Adds a depth pixel to the pixels whose centres are nearer than `radius`, along either axis.
    fn add_around(&mut self, u: f32, v: f32, radius: f32, sample: &Sample<N>) {
        let per_radius = 1.0 / radius;
        let columns = (floor(u - radius) + 1).max(0)..(floor(u + radius) + 1).min(self.width);
        let rows = (floor(v - radius) + 1).max(0)..(floor(v + radius) + 1).min(self.height);
        for j in rows {
            let of_row = 1.0 - (j as f32 - v).abs() * per_radius;
            let start = (j + 1) as usize * self.stride() + 1;
            for i in columns.clone() {
                let weight = of_row * (1.0 - (i as f32 - u).abs() * per_radius);
                self.add(start + i as usize, weight, sample);
            }
        }
    }
}
