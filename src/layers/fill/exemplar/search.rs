//! The search for the most similar known patch of each patch: PatchMatch, in rounds over all patches at once,
//! so that the result does not depend on the number of threads.

use std::ops::Range;

use rayon::prelude::*;

use super::REACH;
use super::level::ExemplarLevel;
use super::random::{number, within};
use quadratura_base::raster::halving::OddSide;
use quadratura_base::raster::robust::of_rank;

/// The centre of the most similar known patch found so far, for each patch that holds an unknown cell.
pub struct MatchField {
    /// The source per cell; [`NONE`] where the cell is not the centre of such a patch.
    source: Vec<u32>,
    cost: Vec<f32>,
}

const NONE: u32 = u32::MAX;

/// The distances, in cells, of the neighbours from which a patch learns: far ones first, so that good shifts
/// spread quickly.
const JUMPS: [i32; 2] = [5, 1];

/// The factor on the cost of a shift that neither repeats nor runs along an axis.
const IRREGULAR: f32 = 1.15;

impl MatchField {
    /// Builds a field with a random known patch for each patch.
    pub fn random(level: &ExemplarLevel, seed: u64) -> Self {
        Self::from_sources(level, |target| {
            level.sources[number(seed, target.into(), 0) as usize % level.sources.len()]
        })
    }

    /// Refines the field of a grid of half the size for `level`.
    pub fn refined(&self, level: &ExemplarLevel, seed: u64) -> Self {
        let [width, height] = level.size;
        let coarse = OddSide::Twice.half_size(level.size);
        Self::from_sources(level, |target| {
            let (x, y) = (target as usize % width, target as usize / width);
            let source = self.source[y / 2 * coarse[0] + x / 2];
            let (sx, sy) = (source as usize % coarse[0] * 2 + x % 2, source as usize / coarse[0] * 2 + y % 2);
            let found = (source != NONE && sx < width && sy < height).then(|| sy * width + sx);
            match found.filter(|source| level.is_source[*source]) {
                Some(source) => source as u32,
                None => level.sources[number(seed, target.into(), 1) as usize % level.sources.len()],
            }
        })
    }

    fn from_sources(level: &ExemplarLevel, source_of: impl Fn(u32) -> u32 + Sync) -> Self {
        let mut field =
            Self { source: vec![NONE; level.colours.len()], cost: vec![0.0; level.colours.len()] };
        for &target in &level.targets {
            field.source[target as usize] = source_of(target);
        }
        field
    }

    /// Returns the centre of the best known patch for the patch around a cell, and its cost; `None` where no
    /// patch is searched.
    pub fn best(&self, cell: usize) -> Option<(u32, f32)> {
        (self.source[cell] != NONE).then(|| (self.source[cell], self.cost[cell]))
    }

    /// Returns the shift from a cell to its best patch, in columns and rows.
    pub fn shift(&self, level: &ExemplarLevel, cell: usize) -> Option<[i32; 2]> {
        let (source, _) = self.best(cell)?;
        let width = level.size[0] as i32;
        let (source, cell) = (source as i32, cell as i32);
        Some([source % width - cell % width, source / width - cell / width])
    }

    /// Returns the upper quartile of the costs: three of four patches stay below it.
    pub fn usual_cost(&self) -> f32 {
        let costs = self.source.iter().zip(&self.cost).filter(|(source, _)| **source != NONE);
        let mut costs: Vec<f32> = costs.map(|(_, cost)| *cost).collect();
        let rank = costs.len() * 3 / 4;
        of_rank(&mut costs, rank).unwrap_or(0.0)
    }

    /// Does one turn: every patch is compared anew, then tries its neighbours' shifts, the dominant shifts,
    /// and random shifts around its best one with ever smaller radius.
    pub fn search(&mut self, level: &ExemplarLevel, shifts: &[[i32; 2]], seed: u64) {
        let measure = Measure { level, shifts };
        for (round, jump) in (0..).zip(JUMPS) {
            let before = &*self;
            let found: Vec<(u32, u32, f32)> = level
                .targets
                .par_iter()
                .map(|&target| {
                    let mut best = Best::new(&measure, target, before.source[target as usize]);
                    before.learn(&mut best, jump);
                    if round == 0 {
                        shifts.iter().for_each(|shift| best.offer(*shift));
                    } else {
                        best.look_around(seed);
                    }
                    (target, best.source, best.cost)
                })
                .collect();
            for (target, source, cost) in found {
                (self.source[target as usize], self.cost[target as usize]) = (source, cost);
            }
        }
    }

    /// Offers the shifts of the four neighbours `jump` cells away.
    fn learn(&self, best: &mut Best, jump: i32) {
        let level = best.measure.level;
        let (whole, width) = (level.rect(), level.size[0] as i32);
        let (x, y) = (best.target as i32 % width, best.target as i32 / width);
        for (dx, dy) in [(-jump, 0), (jump, 0), (0, -jump), (0, jump)] {
            let shift = whole.index(x + dx, y + dy).and_then(|cell| self.shift(level, cell));
            shift.into_iter().for_each(|shift| best.offer(shift));
        }
    }
}

/// The best known patch for a patch so far.
struct Best<'a> {
    measure: &'a Measure<'a>,
    target: u32,
    patch: ClippedPatch,
    source: u32,
    cost: f32,
}

impl<'a> Best<'a> {
    fn new(measure: &'a Measure<'a>, target: u32, source: u32) -> Self {
        let patch = ClippedPatch::new(measure.level, target);
        Self { measure, target, source, cost: measure.cost(target, &patch, source, f32::INFINITY), patch }
    }

    fn offer(&mut self, [dx, dy]: [i32; 2]) {
        let level = self.measure.level;
        let width = level.size[0] as i32;
        let (x, y) = (self.target as i32 % width + dx, self.target as i32 / width + dy);
        let source = level.rect().index(x, y).filter(|source| level.is_source[*source]);
        let Some(source) = source.map(|source| source as u32).filter(|source| *source != self.source) else {
            return;
        };
        let cost = self.measure.cost(self.target, &self.patch, source, self.cost);
        if cost < self.cost {
            (self.source, self.cost) = (source, cost);
        }
    }

    fn look_around(&mut self, seed: u64) {
        let [width, height] = self.measure.level.size.map(|side| side as i32);
        let mut reach = width.max(height);
        let mut step = 2;
        while reach >= 1 {
            let random = number(seed, self.target.into(), step);
            let (dx, dy) = (within(random & 0xffff_ffff, reach), within(random >> 32, reach));
            let (source, target) = (self.source as i32, self.target as i32);
            let shift = [source % width - target % width, source / width - target / width];
            self.offer([shift[0] + dx, shift[1] + dy]);
            reach /= 2;
            step += 1;
        }
    }
}

/// The part of the patch around a cell that lies within the grid. It is the same for all comparisons of the cell.
struct ClippedPatch {
    rows: Range<usize>,
    columns: Range<usize>,
    /// The sum of the weights of its cells.
    weight: f32,
}

impl ClippedPatch {
    fn new(level: &ExemplarLevel, target: u32) -> Self {
        let [width, height] = level.size;
        let (x, y) = (target as usize % width, target as usize / width);
        let rows = y.saturating_sub(REACH)..(y + REACH + 1).min(height);
        let columns = x.saturating_sub(REACH)..(x + REACH + 1).min(width);
        let mut weight = 0.0;
        for row in rows.clone() {
            weight +=
                level.weights[row * width + columns.start..row * width + columns.end].iter().sum::<f32>();
        }
        Self { rows, columns, weight }
    }
}

/// The measure of dissimilarity between patches.
struct Measure<'a> {
    level: &'a ExemplarLevel,
    shifts: &'a [[i32; 2]],
}

impl Measure<'_> {
    /// Computes the mean squared difference, weighted over the target's `patch`. It may return infinity once
    /// the cost exceeds `limit`.
    fn cost(&self, target: u32, patch: &ClippedPatch, source: u32, limit: f32) -> f32 {
        let level = self.level;
        let width = level.size[0];
        let factor = self.factor(target, source);
        let bound = limit * patch.weight / factor;
        let count = patch.columns.len();
        let mut sum = 0.0;
        for row in patch.rows.clone() {
            let at = row * width + patch.columns.start;
            let from = (at as i64 + i64::from(source) - i64::from(target)) as usize;
            let pairs = level.colours[at..at + count].iter().zip(&level.colours[from..from + count]);
            for ((a, b), weight) in pairs.zip(&level.weights[at..at + count]) {
                let [r, g, b] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
                sum += weight * (r * r + g * g + b * b);
            }
            if sum > bound {
                return f32::INFINITY;
            }
        }
        if patch.weight > 0.0 { sum / patch.weight * factor } else { 0.0 }
    }

    fn factor(&self, target: u32, source: u32) -> f32 {
        let width = self.level.size[0] as i32;
        let (source, target) = (source as i32, target as i32);
        let [dx, dy] = [source % width - target % width, source / width - target / width];
        let repeats = || self.shifts.iter().any(|[x, y]| (dx - x).abs() <= 1 && (dy - y).abs() <= 1);
        if dx.abs() <= 1 || dy.abs() <= 1 || repeats() { 1.0 } else { IRREGULAR }
    }
}
