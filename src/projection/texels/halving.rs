//! A picture at half the size: averages in linear light, of what is there and of nothing else.

use std::ops::Range;

use glam::Vec4;

use crate::geometry::{PixelRect, Spans};

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
        let at = self.rect.offset(x, y);
        let values = self.colour[at..at + count].iter().zip(&self.confidence[at..at + count]);
        for (i, (&colour, &confidence)) in values.enumerate() {
            put(i, colour, confidence);
        }
    }
}

impl Light {
    /// Half of `source`: in columns, in rows, or both. A texel is the mean of the (at most) four that it
    /// stands for, and no other's: content where one of them is, its colour theirs by weight; of confidence
    /// it is the plain mean, nothing counting as 0.
    pub fn half_of(source: &impl Rows, [in_x, in_y]: [bool; 2]) -> Self {
        let content = source.content().halved([in_x, in_y]);
        let rect = content.bounds();
        let texels = rect.area() as usize;
        let mut half = Self {
            content: Spans::default(),
            rect,
            colour: vec![Vec4::ZERO; texels],
            confidence: vec![0.0; texels],
        };
        let mut sums = Sums::new(source, [in_x, in_y]);
        for y in content.rows().filter(|&y| !content.row(y).is_empty()) {
            sums.gather(content.row(y), y);
            for x in content.row(y).iter().flat_map(Clone::clone) {
                let at = half.rect.offset(x, y);
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
    /// Texels of the source to one of the half, across and down.
    of: [i32; 2],
    /// The column of the first sum.
    left: i32,
    colour: Vec<Vec4>,
    confidence: Vec<f32>,
}

impl<'a, R: Rows> Sums<'a, R> {
    fn new(source: &'a R, halved: [bool; 2]) -> Self {
        // The neighbour of an outermost texel makes up the same texel of the half.
        let bounds = source.content().bounds().grown(1);
        let width = bounds.w as usize;
        let of = halved.map(|halved| if halved { 2 } else { 1 });
        Self { source, of, left: bounds.x, colour: vec![Vec4::ZERO; width], confidence: vec![0.0; width] }
    }

    /// Sums what the runs of row `y` of the half are made of.
    fn gather(&mut self, runs: &[Range<i32>], y: i32) {
        let [across, down] = self.of;
        for run in runs {
            let place = |x: i32| ((across * x - self.left).max(0) as usize).min(self.colour.len());
            let columns = place(run.start)..place(run.end);
            self.colour[columns.clone()].fill(Vec4::ZERO);
            self.confidence[columns].fill(0.0);
        }
        (down * y..down * (y + 1)).for_each(|row| self.add(row));
    }

    fn add(&mut self, row: i32) {
        let share = 1.0 / self.of[1] as f32;
        for run in self.source.content().row(row) {
            let at = (run.start - self.left) as usize;
            let (colour, confidence) = (&mut self.colour[at..], &mut self.confidence[at..]);
            self.source.row(row, run.start, run.len(), |i, texel, trust| {
                colour[i] += share * texel;
                confidence[i] += share * trust;
            });
        }
    }

    /// Colour times weight, weight, confidence.
    fn texel(&self, x: i32) -> (Vec4, f32) {
        let across = self.of[0] as usize;
        let at = (self.of[0] * x - self.left) as usize;
        let share = 1.0 / across as f32;
        let colour = self.colour[at..at + across].iter().sum::<Vec4>();
        (share * colour, share * self.confidence[at..at + across].iter().sum::<f32>())
    }
}
