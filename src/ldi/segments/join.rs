//! Depth pixels are joined to segments.
//!
//! A depth pixel is joined to a 4-neighbour of its surface, or to one whose inverse depth differs by no more than an epsilon
//! and the slope of the surface ([`crate::merge::slope`]; of an unknown one, the change to its other neighbours).
//! Infinitely far ones are joined to each other. A segment takes one depth pixel of each ray at most: it grows from its first
//! depth pixel on, along its surface first, and leaves out what would be a second one.

use std::collections::VecDeque;

use crate::layout::{LdiSurface, ResolutionLevel};
use crate::merge::slope;
use glam::DVec3;
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// The segment of every depth pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SegmentLabels {
    /// By depth pixel, the number of its segment, from 0.
    pub segments: Vec<u32>,
    /// The number of segments.
    pub count: u32,
}

/// What has no segment yet.
const NONE: u32 = u32::MAX;
/// An unknown surface's own slope is taken from neighbours whose inverse depths differ by less than this share: beyond it is
/// another surface.
const STEEPEST: f64 = 0.1;

/// How many rows are joined between two reports of progress.
const ROWS_A_STEP: usize = 32;

/// Joins the depth pixels of a level.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn label(
    level: &ResolutionLevel,
    surfaces: &[LdiSurface],
    epsilon: f64,
    task: &Task,
) -> Result<SegmentLabels> {
    let positions = PositionIndex::new(level, surfaces, epsilon);
    let mut labels = vec![NONE; level.len()];
    let mut taken = vec![NONE; positions.width * positions.height];
    let mut count = 0;
    for y in 0..positions.height {
        if y.is_multiple_of(ROWS_A_STEP) {
            task.step("join", y as u64, positions.height as u64)?;
        }
        for seed in level.row(y as u32) {
            if labels[seed] == NONE {
                positions.grow(seed as u32, y, count, &mut labels, &mut taken);
                count += 1;
            }
        }
    }
    Ok(SegmentLabels { segments: labels, count })
}

/// A level whose depth pixels are found by position.
struct PositionIndex<'a> {
    level: &'a ResolutionLevel,
    surfaces: &'a [LdiSurface],
    epsilon: f64,
    width: usize,
    height: usize,
    /// The first depth pixel of each position, row by row, and the end.
    starts: Vec<u32>,
}

/// A depth pixel with its position, column and row.
#[derive(Debug, Clone, Copy)]
struct PositionedPixel {
    index: u32,
    x: usize,
    y: usize,
}

impl<'a> PositionIndex<'a> {
    fn new(level: &'a ResolutionLevel, surfaces: &'a [LdiSurface], epsilon: f64) -> Self {
        let (width, height) = (level.camera.width as usize, level.camera.height as usize);
        let mut starts = Vec::with_capacity(width * height + 1);
        for y in 0..height {
            let row = level.row(y as u32);
            let mut at = row.start;
            for x in 0..width {
                starts.push(at as u32);
                while at < row.end && usize::from(level.columns[at]) == x {
                    at += 1;
                }
            }
        }
        starts.push(level.len() as u32);
        Self { level, surfaces, epsilon, width, height, starts }
    }

    /// Gives a number to everything that belongs together with a depth pixel that has none.
    fn grow(&self, seed: u32, y: usize, segment: u32, labels: &mut [u32], taken: &mut [u32]) {
        let (mut of_surface, mut others) = (VecDeque::new(), VecDeque::new());
        others.push_back(PositionedPixel {
            index: seed,
            x: usize::from(self.level.columns[seed as usize]),
            y,
        });
        while let Some(at) = of_surface.pop_front().or_else(|| others.pop_front()) {
            let position = at.y * self.width + at.x;
            if labels[at.index as usize] != NONE || taken[position] == segment {
                continue;
            }
            labels[at.index as usize] = segment;
            taken[position] = segment;
            for (x, y) in self.neighbours(at) {
                if taken[y * self.width + x] == segment {
                    continue;
                }
                for index in self.pixels(x, y).filter(|&index| labels[index as usize] == NONE) {
                    let there = PositionedPixel { index, x, y };
                    match self.joins(at, there) {
                        Joined::BySurface => of_surface.push_back(there),
                        Joined::ByDepth => others.push_back(there),
                        Joined::No => {}
                    }
                }
            }
        }
    }

    fn neighbours(&self, at: PositionedPixel) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (width, height) = (self.width, self.height);
        let beside =
            [(at.x.wrapping_sub(1), at.y), (at.x + 1, at.y), (at.x, at.y.wrapping_sub(1)), (at.x, at.y + 1)];
        beside.into_iter().filter(move |&(x, y)| x < width && y < height)
    }

    fn pixels(&self, x: usize, y: usize) -> std::ops::Range<u32> {
        let position = y * self.width + x;
        self.starts[position]..self.starts[position + 1]
    }

    fn joins(&self, a: PositionedPixel, b: PositionedPixel) -> Joined {
        let surface = |placed: PositionedPixel| self.level.surfaces[placed.index as usize];
        if surface(a) != 0 && surface(a) == surface(b) {
            return Joined::BySurface;
        }
        let depth = |placed: PositionedPixel| f64::from(self.level.inverse_depths[placed.index as usize]);
        let (d, other) = (depth(a), depth(b));
        let joined = if d == 0.0 || other == 0.0 {
            d == other
        } else {
            // Nearly all are joined or parted by epsilon alone.
            let apart = (d.ln() - other.ln()).abs();
            apart <= self.epsilon
                || (apart <= self.epsilon + STEEPEST && apart <= self.epsilon + self.slope(a, b))
        };
        if joined { Joined::ByDepth } else { Joined::No }
    }

    /// Returns the larger slope of two neighbours' surfaces, at most [`STEEPEST`].
    fn slope(&self, a: PositionedPixel, b: PositionedPixel) -> f64 {
        let of = |at: PositionedPixel, from: PositionedPixel| {
            let d = f64::from(self.level.inverse_depths[at.index as usize]);
            match self.level.surfaces[at.index as usize] {
                0 => self.slope_from_neighbour(at, from, d),
                surface => {
                    let nu = self.surfaces[usize::from(surface) - 1].nu;
                    // The change towards this neighbour, not over the whole pixel.
                    let along = if at.y == from.y {
                        DVec3::new(nu.x, 0.0, nu.z)
                    } else {
                        DVec3::new(0.0, nu.y, nu.z)
                    };
                    slope(along, d)
                }
            }
        };
        of(a, b).max(of(b, a)).min(STEEPEST)
    }

    /// Returns the change of an unknown surface to the neighbour that is opposite to `from`; 0 where there is none of it.
    fn slope_from_neighbour(&self, at: PositionedPixel, from: PositionedPixel, d: f64) -> f64 {
        let (x, y) = ((2 * at.x).wrapping_sub(from.x), (2 * at.y).wrapping_sub(from.y));
        if x >= self.width || y >= self.height {
            return 0.0;
        }
        let unknown = self.pixels(x, y).filter(|&index| self.level.surfaces[index as usize] == 0);
        let change =
            unknown.map(|index| (f64::from(self.level.inverse_depths[index as usize]).ln() - d.ln()).abs());
        change.filter(|change| *change < STEEPEST).min_by(f64::total_cmp).unwrap_or(0.0)
    }
}

/// Whether two depth pixels are joined, and by what.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Joined {
    BySurface,
    ByDepth,
    No,
}
