//! A picture at half the size: averages in linear light, of what is there and of nothing else.

use glam::Vec4;

use super::spans::Spans;
use crate::geometry::PixelRect;

/// How texels are averaged: weights of the 2, 4, ... texels around the middle between two, summing to 1,
/// the same in rows and columns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kernel(pub &'static [f32]);

impl Kernel {
    /// The mean of two: every texel of a level is the mean of an area of the photo, and no other's.
    pub const BOX: Self = Self(&[0.5, 0.5]);
    /// Lanczos-3 at half size, sampled: sharper, and what photos are usually made smaller with.
    pub const LANCZOS: Self = Self(&[
        0.00368914,
        0.01505614,
        -0.03399863,
        -0.06663732,
        0.13550528,
        0.44638539,
        0.44638539,
        0.13550528,
        -0.06663732,
        -0.03399863,
        0.01505614,
        0.00368914,
    ]);
    /// Nothing is halved.
    const ONE: Self = Self(&[1.0]);

    /// The first of the texels that make up texel `x`.
    fn first(self, x: i32) -> i32 {
        if self.0.len() == 1 { x } else { 2 * x + 1 - self.0.len() as i32 / 2 }
    }
}

impl Default for Kernel {
    fn default() -> Self {
        Self::BOX
    }
}

/// A level in linear light: a rectangle of texels, relative to the sheet's corner at this level.
#[derive(Debug, Clone)]
pub struct Light {
    /// Where anything is.
    pub content: Spans,
    /// Which texels there are values for: the bounds of `content`.
    pub rect: PixelRect,
    /// r, g, b times weight, and weight: how much of the texel is content. Only at `content`.
    pub colour: Vec<Vec4>,
    /// 0..1. Only at `content`.
    pub confidence: Vec<f32>,
}

/// What can be halved: colour (as in [`Light`]) and confidence of the texels of a row from column `x`.
pub trait Rows {
    /// Where anything is.
    fn content(&self) -> &Spans;

    /// Calls `put(index, colour, confidence)` for `count` texels of content.
    fn row(&self, y: i32, x: i32, count: usize, put: impl FnMut(usize, Vec4, f32));
}

impl Rows for Light {
    fn content(&self) -> &Spans {
        &self.content
    }

    fn row(&self, y: i32, x: i32, count: usize, mut put: impl FnMut(usize, Vec4, f32)) {
        let at = self.index(x, y);
        let values = self.colour[at..at + count].iter().zip(&self.confidence[at..at + count]);
        for (i, (&colour, &confidence)) in values.enumerate() {
            put(i, colour, confidence);
        }
    }
}

impl Light {
    /// The place of a texel within `rect`.
    pub fn index(&self, x: i32, y: i32) -> usize {
        (y - self.rect.y) as usize * self.rect.w as usize + (x - self.rect.x) as usize
    }

    /// Half of `source`: in columns, in rows, or both. A texel is content where one of the (at most) four
    /// that it stands for is; confidence is the plain mean, nothing counting as 0.
    pub fn half_of(source: &impl Rows, [in_x, in_y]: [bool; 2], kernel: Kernel) -> Self {
        let content = source.content().halved([in_x, in_y]);
        let rect = content.bounds();
        let texels = rect.area() as usize;
        let mut half = Self {
            content: Spans::default(),
            rect,
            colour: vec![Vec4::ZERO; texels],
            confidence: vec![0.0; texels],
        };
        let of = |halved| if halved { kernel } else { Kernel::ONE };
        let mut sums = Sums::new(source, of(in_x), of(in_y));
        for y in content.rows().filter(|&y| !content.row(y).is_empty()) {
            sums.gather(content.row(y), y);
            for x in content.row(y).iter().flat_map(Clone::clone) {
                let at = half.index(x, y);
                (half.colour[at], half.confidence[at]) = sums.texel(x);
            }
        }
        half.content = content;
        half
    }
}

/// One row of the half: columns of the source, summed over the rows that make it up.
struct Sums<'a, R> {
    source: &'a R,
    in_x: Kernel,
    in_y: Kernel,
    /// The column of the first sum.
    left: i32,
    /// With the kernel.
    colour: Vec<Vec4>,
    confidence: Vec<f32>,
    /// With the box, where the kernel is another one.
    plain: Vec<Vec4>,
}

impl<'a, R: Rows> Sums<'a, R> {
    fn new(source: &'a R, in_x: Kernel, in_y: Kernel) -> Self {
        let bounds = source.content().bounds().grown(in_x.0.len() as u32);
        let width = bounds.w as usize;
        let plain = if in_x.0.len().max(in_y.0.len()) > 2 { width } else { 0 };
        Self {
            source,
            in_x,
            in_y,
            left: bounds.x,
            colour: vec![Vec4::ZERO; width],
            confidence: vec![0.0; width],
            plain: vec![Vec4::ZERO; plain],
        }
    }

    /// Sums what the runs of row `y` of the half are made of.
    fn gather(&mut self, runs: &[std::ops::Range<i32>], y: i32) {
        for run in runs {
            let from = (self.in_x.first(run.start) - self.left).max(0) as usize;
            let to = self.in_x.first(run.end) + self.in_x.0.len() as i32 - self.left;
            let to = (to.max(0) as usize).min(self.colour.len());
            self.colour[from..to].fill(Vec4::ZERO);
            self.confidence[from..to].fill(0.0);
            self.plain.get_mut(from..to).into_iter().for_each(|plain| plain.fill(Vec4::ZERO));
        }
        let middle = self.in_y.0.len() / 2;
        for (i, &weight) in self.in_y.0.iter().enumerate() {
            let row = self.in_y.first(y) + i as i32;
            let plain = if i + 1 == middle || i == middle { 1.0 } else { 0.0 };
            self.add(row, weight, plain);
        }
    }

    fn add(&mut self, row: i32, weight: f32, plain: f32) {
        let content = self.source.content();
        for run in content.row(row) {
            let at = (run.start - self.left) as usize;
            let (colour, confidence) = (&mut self.colour[at..], &mut self.confidence[at..]);
            let plains = self.plain.get_mut(at..).unwrap_or_default();
            self.source.row(row, run.start, run.len(), |i, texel, trust| {
                colour[i] += weight * texel;
                confidence[i] += weight * trust;
                plains.get_mut(i).into_iter().for_each(|sum| *sum += plain * texel);
            });
        }
    }

    /// Colour times weight, weight, confidence.
    fn texel(&self, x: i32) -> (Vec4, f32) {
        let at = (self.in_x.first(x) - self.left) as usize;
        let (mut colour, mut confidence) = (Vec4::ZERO, 0.0);
        for (i, &weight) in self.in_x.0.iter().enumerate() {
            colour += weight * self.colour[at + i];
            confidence += weight * self.confidence[at + i];
        }
        if self.plain.is_empty() {
            return (colour, confidence);
        }
        (self.held(x, colour), confidence.clamp(0.0, 1.0))
    }

    /// Where little of a kernel with negative weights is content, it says little about the colour: the
    /// mean of the texels themselves does. The weight is theirs in any case.
    fn held(&self, x: i32, colour: Vec4) -> Vec4 {
        let at = if self.in_x.0.len() == 1 { x - self.left } else { 2 * x - self.left } as usize;
        let pair = if self.in_x.0.len() == 1 { &self.plain[at..=at] } else { &self.plain[at..at + 2] };
        let plain: Vec4 = pair.iter().sum::<Vec4>() / (pair.len() as f32 * self.rows_in_plain());
        if colour.w < 0.75 {
            return plain;
        }
        (colour / colour.w).max(Vec4::ZERO) * plain.w
    }

    fn rows_in_plain(&self) -> f32 {
        if self.in_y.0.len() == 1 { 1.0 } else { 2.0 }
    }
}
