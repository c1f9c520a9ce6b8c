//! The neighbours of a depth pixel on its surface, between which colours are interpolated.

use std::ops::Range;

use glam::{DVec2, Vec4};

use crate::layout::ResolutionLevel;
use quadratura_view::srgb::Srgb;

/// The share by which the inverse depth of a neighbour may differ from that of the plane to be on it.
const SAME_SURFACE: f64 = 0.03;

/// A depth pixel of a level with its neighbours on its surface, and the rows in which they are. It moves from one depth pixel to the
/// next, mostly along a row, so that neighbours are found beside those before.
#[derive(Debug)]
pub struct Neighbourhood {
    /// The row, and the indices of its depth pixels.
    y: u32,
    indices: Range<usize>,
    /// The rows above, at and below the depth pixel: their depth pixels, and where the last search ended.
    rows: [(Range<usize>, usize); 3],
    /// The depth pixel, and its column.
    index: usize,
    x: u16,
    /// Its inverse depth, in 1/world unit.
    pub inverse_depth: f64,
    /// The change of inverse depth a pixel.
    pub gradient: DVec2,
    /// Its linear light times opacity, and its opacity of 0 to 255.
    own: Vec4,
    /// The linear light of the 3 x 3 pixels around it, times opacity, and their opacities of 0 to 255, row by row; those of other
    /// surfaces have its own.
    light: [[Vec4; 3]; 3],
    /// Whether the light of a row is known in its column and the one to the left, and in its column and the one to the right.
    known: [[bool; 2]; 3],
    srgb: Srgb,
}

impl Neighbourhood {
    /// Makes a neighbourhood that is nowhere yet.
    pub fn new() -> Self {
        Self {
            y: 0,
            indices: 0..0,
            rows: [const { (0..0, 0) }; 3],
            index: 0,
            x: 0,
            inverse_depth: 0.0,
            gradient: DVec2::ZERO,
            own: Vec4::ZERO,
            light: [[Vec4::ZERO; 3]; 3],
            known: [[false; 2]; 3],
            srgb: Srgb::tables(),
        }
    }

    /// Moves to a depth pixel. `slope` is the change of its inverse depth from pixel to pixel; where it is `None`, it is estimated from
    /// neighbours.
    pub fn move_to(&mut self, level: &ResolutionLevel, index: usize, slope: Option<DVec2>) {
        if !self.indices.contains(&index) {
            let y = level.rows.partition_point(|first| *first as usize <= index) as u32 - 1;
            let row = |y: Option<u32>| match y.filter(|y| *y < level.camera.height) {
                Some(y) => level.row(y),
                None => 0..0,
            };
            let rows = [row(y.checked_sub(1)), row(Some(y)), row(y.checked_add(1))];
            (self.y, self.indices) = (y, rows[1].clone());
            // Parts of rows are drawn one below the other.
            let x = level.columns[index];
            let begin = |row: &Range<usize>| {
                row.start + level.columns[row.clone()].partition_point(|column| *column < x)
            };
            self.rows = rows.map(|row| (row.clone(), begin(&row)));
        } else if index == self.index {
            return;
        }
        (self.index, self.x) = (index, level.columns[index]);
        self.inverse_depth = f64::from(level.inverse_depths[index]);
        self.gradient = slope.unwrap_or_default();
        (self.own, self.known) = (light_of(&self.srgb, level.colours[index]), [[false; 2]; 3]);
        if slope.is_none() {
            let [above, beside, below] = [0, 1, 2].map(|row| self.find(level, row, [true; 2]));
            let here = self.inverse_depth;
            self.gradient = DVec2::new(
                slope_between(beside[0], here, beside[2]),
                slope_between(above[1], here, below[1]),
            );
        }
    }

    /// Returns its centre, in pixels of the level.
    pub fn centre(&self) -> DVec2 {
        DVec2::new(f64::from(self.x) + 0.5, f64::from(self.y) + 0.5)
    }

    /// Returns the depth pixels of a row in its column and the ones beside it.
    fn columns(&mut self, level: &ResolutionLevel, row: usize) -> Range<usize> {
        let (from, to) = (self.x.saturating_sub(1), self.x.saturating_add(1));
        let (Range { start, end }, at) = &mut self.rows[row];
        while *at > *start && level.columns[*at - 1] >= from {
            *at -= 1;
        }
        while *at < *end && level.columns[*at] < from {
            *at += 1;
        }
        let count = level.columns[*at..*end].iter().take_while(|column| **column <= to).count();
        *at..*at + count
    }

    /// Finds the light of a row, 0 above, 1 beside and 2 below the pixel, in its column and in those to the left and to the right if
    /// these are asked for. Returns the inverse depths of the neighbours there.
    #[inline]
    fn find(&mut self, level: &ResolutionLevel, row: usize, [left, right]: [bool; 2]) -> [Option<f64>; 3] {
        let (here, x) = (self.inverse_depth, self.x);
        let surface = level.surfaces[self.index];
        let in_middle = here + (row as f64 - 1.0) * self.gradient.y;
        let (asked, mut depths) = ([left, true, right], [None; 3]);
        let others = self.columns(level, row);
        for (light, asked) in self.light[row].iter_mut().zip(asked) {
            if asked {
                *light = self.own;
            }
        }
        for other in others {
            let cell = usize::from(level.columns[other] + 1 - x);
            // The nearest one of its surface counts.
            if !asked[cell] || (row, cell) == (1, 1) || depths[cell].is_some() {
                continue;
            }
            let expected = in_middle + (cell as f64 - 1.0) * self.gradient.x;
            let depth = f64::from(level.inverse_depths[other]);
            if level.surfaces[other] == surface && (depth - expected).abs() <= SAME_SURFACE * here {
                self.light[row][cell] = light_of(&self.srgb, level.colours[other]);
                depths[cell] = Some(depth);
            }
        }
        let [left_is_known, right_is_known] = self.known[row];
        self.known[row] = [left_is_known | left, right_is_known | right];
        depths
    }

    /// Interpolates the colour at an offset of about half a pixel at most, in linear light.
    pub fn colour(&mut self, level: &ResolutionLevel, by: DVec2) -> [u8; 4] {
        let right = by.x >= 0.0;
        let (column, row) = (if right { 2 } else { 0 }, if by.y < 0.0 { 0 } else { 2 });
        let (x, y) = (by.x.abs() as f32, by.y.abs() as f32);
        for row in [1, row] {
            if !self.known[row][usize::from(right)] {
                self.find(level, row, [!right, right]);
            }
        }
        let along = |row: &[Vec4; 3]| row[1] * (1.0 - x) + row[column] * x;
        let light = along(&self.light[1]) * (1.0 - y) + along(&self.light[row]) * y;
        let [r, g, b] = self.srgb.encoded_colour(light / light.w.max(f32::MIN_POSITIVE));
        [r, g, b, (light.w + 0.5) as u8]
    }
}

/// Returns the linear light of a stored colour times its opacity, and its opacity of 0 to 255.
#[inline]
fn light_of(srgb: &Srgb, [r, g, b, a]: [u8; 4]) -> Vec4 {
    Vec4::new(srgb.linear(r), srgb.linear(g), srgb.linear(b), 1.0) * f32::from(a)
}

/// Returns the change of a value from pixel to pixel where both neighbours, one or none are known: the smaller change, since
/// the larger one may be an edge.
fn slope_between(before: Option<f64>, here: f64, after: Option<f64>) -> f64 {
    match (before.map(|before| here - before), after.map(|after| after - here)) {
        (Some(a), Some(b)) => {
            if a.abs() < b.abs() {
                a
            } else {
                b
            }
        }
        (one, other) => one.or(other).unwrap_or(0.0),
    }
}
