//! Triangles become fragments: for each pixel a mask of its 4 x 4 sub-pixels that are covered (Carpenter, *The A-buffer*,
//! 1984), with depths and with what is needed to find colour and normal in their middle.
//!
//! Sub-pixel `4 b_y + b_x` of pixel (i, j) lies at (i + (b_x + 1/2)/4, j + (b_y + 1/2)/4). Corners are rounded to 1/1024
//! of a pixel, and edges are then tested in integers: of two triangles with a common edge exactly one covers each
//! sub-pixel on it.

#[cfg(test)]
mod tests;

use glam::{DVec2, DVec3};

use quadratura_base::geometry::PixelRect;

/// Steps of corners in a pixel.
const STEPS: i64 = 1024;
/// Steps from a sub-pixel to the next one.
const STRIDE: i64 = STEPS / 4;
/// Corners farther than this from the image's corner, in pixels, have to be clipped first: their edges would not fit
/// into integers. The largest picture has 16,384.
pub const REACH_PX: f64 = 65_536.0;

/// A triangle's corner in the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageCorner {
    /// The image point in steps of 1/1024 pixel.
    at: [i64; 2],
    /// How near it is: linear across the image, larger is nearer.
    nearness: f64,
}

impl ImageCorner {
    /// Makes a corner at an image point in pixels that is within [`REACH_PX`]; `None` beyond it.
    #[inline]
    pub fn new(point_px: DVec2, nearness: f64) -> Option<Self> {
        let is_within = point_px.x.abs() <= REACH_PX && point_px.y.abs() <= REACH_PX;
        let step = |value: f64| (value * STEPS as f64).round() as i64;
        is_within.then(|| Self { at: [step(point_px.x), step(point_px.y)], nearness })
    }
}

/// Returns the share of a triangle that a pixel covers, measured on the triangle itself, where its nearness is `middle`:
/// by perspective it goes with the cube of the distance.
pub fn share_in_pixel(perspective: bool, corners: &[ImageCorner; 3], middle: f64) -> f64 {
    let [a, b, c] = corners;
    let [ab, ac] = [b, c].map(|other| [other.at[0] - a.at[0], other.at[1] - a.at[1]]);
    let area_px = 0.5 * (ab[0] * ac[1] - ab[1] * ac[0]).abs() as f64 / (STEPS * STEPS) as f64;
    let stretch =
        if perspective { (a.nearness / middle) * (b.nearness / middle) * (c.nearness / middle) } else { 1.0 };
    stretch / area_px
}

/// What a triangle covers of a pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Fragment {
    /// The pixel's column.
    pub x: i32,
    /// The pixel's row.
    pub y: i32,
    /// The covered sub-pixels, bit `4 b_y + b_x`; not 0.
    pub mask: u16,
    /// How near each covered sub-pixel is, 0 for the others.
    pub nearness: [f32; 16],
    /// How near the middle of the covered sub-pixels is.
    pub middle: f64,
    /// The weights of the three corners in the middle of the covered sub-pixels, with perspective; they sum to 1.
    pub weights: DVec3,
}

impl Fragment {
    /// Returns what of it is in some sub-pixels; `None` for nothing.
    pub fn within(&self, mask: u16) -> Option<Self> {
        let mask = self.mask & mask;
        let nearness = std::array::from_fn(|bit| if mask >> bit & 1 == 1 { self.nearness[bit] } else { 0.0 });
        (mask != 0).then(|| Self { mask, nearness, ..self.clone() })
    }

    /// Returns the middle of some of the covered sub-pixels, at least one: in the image, in pixels, and how near the surface is
    /// there.
    pub fn middle_of(&self, mask: u16) -> (DVec2, f64) {
        let (mut px, mut nearness, mut left) = (DVec2::ZERO, 0.0, mask);
        while left != 0 {
            let bit = left.trailing_zeros();
            left &= left - 1;
            px += DVec2::new(f64::from(bit % 4), f64::from(bit / 4));
            nearness += f64::from(self.nearness[bit as usize]);
        }
        let count = f64::from(mask.count_ones());
        // Nearness is linear across the image.
        (DVec2::new(f64::from(self.x), f64::from(self.y)) + (px / count + 0.5) / 4.0, nearness / count)
    }
}

/// How triangles are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// The pixels that are drawn.
    pub bounds: PixelRect,
    /// True where nearness is 1/z, so that weights within a triangle go with it.
    pub perspective: bool,
}

/// An edge of a triangle: at least 0 on the inside, in integers.
#[derive(Clone, Copy)]
struct EdgeFunction {
    /// The change by a step to the right and down.
    change: [i64; 2],
    /// The value at the origin of steps, made less by 1 where sub-pixels on the edge are not the triangle's.
    origin: i64,
    /// What was taken away.
    bias: i64,
}

impl EdgeFunction {
    #[inline]
    fn new([ax, ay]: [i64; 2], [bx, by]: [i64; 2]) -> Self {
        let (dx, dy) = (bx - ax, by - ay);
        // Of the two triangles at an edge one has it as a left or top edge, which keeps what lies on it.
        let keeps = dy < 0 || (dy == 0 && dx > 0);
        let bias = i64::from(!keeps);
        Self { change: [-dy, dx], origin: dy * ax - dx * ay - bias, bias }
    }

    #[inline]
    fn at(&self, [x, y]: [i64; 2]) -> i64 {
        self.change[0] * x + self.change[1] * y + self.origin
    }
}

/// Draws a triangle, from whichever side it is seen: calls `each` with its fragments in the target, by rows. Sub-pixels
/// where `keeps` (of the weights of the corners) is false are holes.
#[inline]
pub fn rasterise(
    target: &Target,
    corners: [ImageCorner; 3],
    keeps: Option<&dyn Fn(DVec3) -> bool>,
    mut each: impl FnMut(&Fragment),
) {
    let Some(samples) = covered_samples(&target.bounds, &corners) else { return };
    let Some(triangle) = PreparedTriangle::new(target.perspective, corners) else { return };
    let [x0, x1, y0, y1] = samples;
    for y in y0.div_euclid(4)..=y1.div_euclid(4) {
        for x in x0.div_euclid(4)..=x1.div_euclid(4) {
            let (right, below) = (lower(x1, 4 * x + 3), lower(y1, 4 * y + 3));
            let samples = [higher(x0, 4 * x), right, higher(y0, 4 * y), below];
            if let Some(fragment) = triangle.fragment([x, y], samples, keeps) {
                each(&fragment);
            }
        }
    }
}

/// Returns the first and last column and row of sub-pixels that the triangle may cover; most small triangles cover none.
#[inline]
fn covered_samples(bounds: &PixelRect, corners: &[ImageCorner; 3]) -> Option<[i64; 4]> {
    let range = |axis: usize, low_px: i32, high_px: i32| {
        let [a, b, c] = corners;
        let (a, b, c) = (a.at[axis], b.at[axis], c.at[axis]);
        let (low, high) = (lower(a, lower(b, c)), higher(a, higher(b, c)));
        // Sub-pixel s lies at step s * STRIDE + STRIDE / 2.
        let first = higher((low - STRIDE / 2 + STRIDE - 1).div_euclid(STRIDE), 4 * i64::from(low_px));
        let last = lower((high - STRIDE / 2).div_euclid(STRIDE), 4 * i64::from(high_px) - 1);
        (first <= last).then_some([first, last])
    };
    let [x0, x1] = range(0, bounds.x, bounds.right())?;
    let [y0, y1] = range(1, bounds.y, bounds.bottom())?;
    Some([x0, x1, y0, y1])
}

// Written out: those of the standard library stay calls in builds that do not optimise across packages, and took a fifth
// of the time.
#[inline]
fn lower(a: i64, b: i64) -> i64 {
    if b < a { b } else { a }
}

#[inline]
fn higher(a: i64, b: i64) -> i64 {
    if b > a { b } else { a }
}

/// A triangle that is ready to be tested. Edge `i` is the one opposite of corner `i`.
struct PreparedTriangle {
    edges: [EdgeFunction; 3],
    nearness: [f64; 3],
    /// 1 over twice the area in steps.
    per_area: f64,
    perspective: bool,
    /// True where corners 1 and 2 were exchanged.
    turned: bool,
}

impl PreparedTriangle {
    /// Prepares a triangle; `None` where it has no area.
    #[inline]
    fn new(perspective: bool, [a, b, c]: [ImageCorner; 3]) -> Option<Self> {
        let (ab, ac) = ([b.at[0] - a.at[0], b.at[1] - a.at[1]], [c.at[0] - a.at[0], c.at[1] - a.at[1]]);
        let twice = ab[0] * ac[1] - ab[1] * ac[0];
        let turned = twice < 0;
        let (b, c, twice) = if turned { (c, b, -twice) } else { (b, c, twice) };
        let edges =
            [EdgeFunction::new(b.at, c.at), EdgeFunction::new(c.at, a.at), EdgeFunction::new(a.at, b.at)];
        let nearness = [a.nearness, b.nearness, c.nearness];
        (twice > 0).then(|| Self { edges, nearness, per_area: (twice as f64).recip(), perspective, turned })
    }

    /// Returns what the triangle covers of some sub-pixels of a pixel: first and last column, first and last row.
    #[inline]
    fn fragment(
        &self,
        [x, y]: [i64; 2],
        [x0, x1, y0, y1]: [i64; 4],
        keeps: Option<&dyn Fn(DVec3) -> bool>,
    ) -> Option<Fragment> {
        let (mut mask, mut nearness, mut sum) = (0u16, [0.0f32; 16], DVec3::ZERO);
        for row in y0..y1 + 1 {
            for column in x0..x1 + 1 {
                let Some(share) = self.shares([column, row]) else { continue };
                if keeps.is_some_and(|keeps| !keeps(self.weights(share))) {
                    continue;
                }
                let bit = (4 * (row - 4 * y) + column - 4 * x) as usize;
                mask |= 1 << bit;
                nearness[bit] = self.nearness(share) as f32;
                sum += share;
            }
        }
        (mask != 0).then(|| {
            // What is linear across the image has its value in the middle as its mean.
            let share = sum / f64::from(mask.count_ones());
            let (weights, middle) = (self.weights(share), self.nearness(share));
            Fragment { x: x as i32, y: y as i32, mask, nearness, middle, weights }
        })
    }

    /// Returns the shares of the triangle's area that belong to its corners at a sub-pixel; `None` outside.
    #[inline]
    fn shares(&self, [column, row]: [i64; 2]) -> Option<DVec3> {
        // Written out: closures over arrays stay calls in builds that do not optimise across functions.
        let at = [column * STRIDE + STRIDE / 2, row * STRIDE + STRIDE / 2];
        let [first, second, third] = &self.edges;
        let (a, b, c) = (first.at(at), second.at(at), third.at(at));
        if (a | b | c) < 0 {
            return None;
        }
        let whole = DVec3::new((a + first.bias) as f64, (b + second.bias) as f64, (c + third.bias) as f64);
        Some(whole * self.per_area)
    }

    #[inline]
    fn nearness(&self, share: DVec3) -> f64 {
        share.dot(DVec3::from_array(self.nearness))
    }

    /// Returns the weights of the corners, in the order in which they were given.
    #[inline]
    fn weights(&self, share: DVec3) -> DVec3 {
        let weights = match self.perspective {
            true => share * DVec3::from_array(self.nearness) / self.nearness(share),
            false => share,
        };
        if self.turned { DVec3::new(weights.x, weights.z, weights.y) } else { weights }
    }
}
