//! Halving of levels: means in linear light over the content alone, never over empty texels.

use std::ops::Range;

use glam::Vec4;

use quadratura_base::geometry::{PixelRect, Spans};

/// A level in linear light: a rectangle of texels, relative to the layer texture's corner at this level.
#[derive(Debug, Clone)]
pub struct Light {
    /// The texels with content.
    pub content: Spans,
    /// The texels that have values: the bounds of `content`.
    pub rect: PixelRect,
    /// r, g, b times weight, and weight, the share of the texel that is content. Valid at `content` only.
    pub colour: Vec<Vec4>,
    /// Confidence, 0..1. Valid at `content` only.
    pub confidence: Vec<f32>,
}

/// A source of rows of texels that can be halved: colour (as in [`Light`]) and confidence.
pub trait Rows {
    /// Returns the texels with content.
    fn content(&self) -> &Spans;

    /// Calls `put(index, colour, confidence)` for `count` texels of content from column `x` of row `y`.
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
    /// Halves `source` in columns, in rows, or both. A texel is the mean of exactly those (at most) four
    /// texels that it stands for. It has content where one of them has, its colour is their mean by weight,
    /// and its confidence is the plain mean, where empty texels count as 0. This is not `raster::halving`: levels are
    /// sparse, and only runs of content are visited.
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
        let mut sums = RowSums::new(source, [in_x, in_y]);
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

/// One row of the half: columns of the source, summed over the rows that form it.
struct RowSums<'a, R> {
    source: &'a R,
    /// The number of texels of the source per texel of the half, across and down.
    of: [i32; 2],
    /// The column of the first sum.
    left: i32,
    colour: Vec<Vec4>,
    confidence: Vec<f32>,
}

impl<'a, R: Rows> RowSums<'a, R> {
    fn new(source: &'a R, halved: [bool; 2]) -> Self {
        // The neighbour of an outermost texel belongs to the same texel of the half.
        let bounds = source.content().bounds().grown(1);
        let width = bounds.w as usize;
        let of = halved.map(|halved| if halved { 2 } else { 1 });
        Self { source, of, left: bounds.x, colour: vec![Vec4::ZERO; width], confidence: vec![0.0; width] }
    }

    /// Sums the source's texels that form the runs of row `y` of the half.
    fn gather(&mut self, runs: &[Range<i32>], y: i32) {
        let [across, down] = self.of;
        for run in runs {
            let index = |x: i32| ((across * x - self.left).max(0) as usize).min(self.colour.len());
            let columns = index(run.start)..index(run.end);
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

    /// Returns the texel of the half in column `x`: colour times weight with the weight, and confidence.
    fn texel(&self, x: i32) -> (Vec4, f32) {
        let across = self.of[0] as usize;
        let at = (self.of[0] * x - self.left) as usize;
        let share = 1.0 / across as f32;
        let colour = self.colour[at..at + across].iter().sum::<Vec4>();
        (share * colour, share * self.confidence[at..at + across].iter().sum::<f32>())
    }
}
