//! Synthesis by example: the unknown part of a planar image is composed of patches of the known part.
//!
//! Wexler, Shechtman and Irani (*Space-Time Completion of Video*, 2007) define the goal: every patch that
//! holds an unknown cell should resemble some known patch. The solution is found from coarse to fine by
//! turns: each patch searches for the most similar known patch (`search`, after Barnes, Shechtman,
//! Finkelstein and Goldman, *PatchMatch*, 2009), then every unknown cell takes the mean of what the patches
//! over it propose (`level`). Facades repeat: the shifts by which the known part is most similar to itself
//! (`shifts`, He and Sun, *Statistics of Patch Offsets for Image Completion*, 2012) are tried everywhere, and
//! both these and shifts along the axes are preferred, since the plane is upright and both are the facade's
//! own (Huang, Kang, Ahuja and Kopf, *Image Completion using Planar Structure Guidance*, 2014). The finest
//! grid only copies, by the shifts found on the coarser one.

mod level;
mod random;
mod search;
mod shifts;

use glam::DVec2;

use self::level::{ExemplarLevel, levels};
use self::search::MatchField;
use super::push_pull::WeightedGrid;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::bilinear::Clamped;

/// The state of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cell {
    /// The cell is not part of the surface.
    Outside,
    /// The cell is part of the surface and has no colour yet.
    Unknown,
    /// The cell has a colour.
    Known,
}

/// A planar image with unknown cells.
#[derive(Debug, Clone, PartialEq)]
pub struct ExemplarImage {
    /// The number of columns and rows.
    pub size: [usize; 2],
    /// The colours as square roots of linear light, so that differences are roughly perceptual; row by row.
    pub colours: Vec<[f32; 3]>,
    /// The state of each cell.
    pub cells: Vec<Cell>,
}

impl ExemplarImage {
    /// Builds a canvas in which all cells are outside.
    pub fn new(size: [usize; 2]) -> Self {
        let count = size[0] * size[1];
        Self { size, colours: vec![[0.0; 3]; count], cells: vec![Cell::Outside; count] }
    }

    /// Returns true when too little is known for taking examples from it.
    pub fn is_too_little(&self) -> bool {
        let count = |state: Cell| self.cells.iter().filter(|cell| **cell == state).count();
        let known = count(Cell::Known);
        known < LEAST_SOURCES || count(Cell::Unknown) > MOST_INVENTED * known
    }

    /// Returns the colours of all cells, unknown ones interpolated by diffusion; `None` when none is known.
    pub fn diffused(&self) -> Option<Vec<[f32; 3]>> {
        let weights = self.cells.iter().map(|cell| if *cell == Cell::Known { 1.0 } else { 0.0 }).collect();
        WeightedGrid { size: self.size, values: self.colours.clone(), weights }.filled()
    }
}

/// The number of cells on either side of a patch's centre: seven by seven cells hold a corner of a window.
const REACH: usize = 3;

/// The least number of known patches: fewer lead to nothing but repetitions.
const LEAST_SOURCES: usize = 256;

/// The largest ratio of unknown to known cells: beyond it, repetition dominates.
const MOST_INVENTED: usize = 12;

/// The largest number of patches to search for on the finest grid searched; larger grids copy by the shifts
/// found at half their size, which are as good.
const MOST_SEARCHED: usize = 40_000;

/// The number of turns on the coarsest grid, where everything is decided, and on each finer one.
const TURNS: [usize; 2] = [10, 3];

/// Synthesises the unknown cells by example. Returns false, without any change, when the known part is too
/// small to take examples from. The same canvas and seed give the same image on any number of threads.
pub fn invent(canvas: &mut ExemplarImage, seed: u64) -> bool {
    if canvas.cells.iter().all(|cell| *cell != Cell::Unknown) || canvas.is_too_little() {
        return false;
    }
    let Some(diffused) = canvas.diffused() else { return false };
    let mut levels = levels(canvas, diffused);
    // The finest grid that is searched; coarser ones have fewer targets still.
    let finest = levels.iter().position(|l| l.targets.len() <= MOST_SEARCHED).unwrap_or(levels.len() - 1);
    let coarsest = match levels.iter().rposition(|l| l.sources.len() >= LEAST_SOURCES) {
        Some(coarsest) if coarsest >= finest => coarsest,
        _ => return false,
    };
    let shifts = shifts::dominant(&levels[finest..=coarsest], seed);
    let mut field: Option<MatchField> = None;
    for at in (finest..=coarsest).rev() {
        let shifts: Vec<[i32; 2]> = shifts.iter().map(|shift| shift.at(at - finest)).collect();
        let turns = TURNS[usize::from(at < coarsest)];
        let level = &mut levels[at];
        let mut next = match field.take() {
            None => MatchField::random(level, seed),
            Some(coarser) => coarser.refined(level, seed),
        };
        if at < coarsest {
            level.vote(&next);
        }
        for turn in 0..turns {
            next.search(level, &shifts, seed ^ (at * 64 + turn) as u64);
            level.vote(&next);
        }
        field = Some(next);
    }
    let field = field.expect("one grid at least was searched");
    copy(canvas, &levels[finest], &field, finest);
    true
}

/// Copies into every unknown cell of the canvas the colour at its shift, where shifts were found on a grid
/// 2^`coarser` times as coarse: the mean over the four nearest cells of that grid, weighted by nearness, so
/// that no blocks appear.
fn copy(canvas: &mut ExemplarImage, level: &ExemplarLevel, field: &MatchField, coarser: usize) {
    let scale = 1 << coarser;
    let [width, height] = canvas.size;
    let whole = PixelRect::of_size(width as u32, height as u32);
    let before = canvas.clone();
    for (i, cell) in before.cells.iter().enumerate().filter(|(_, cell)| **cell == Cell::Unknown) {
        let (x, y) = (i % width, i / width);
        let (mut sum, mut weight) = ([0.0; 3], 0.0);
        let middle = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) / scale as f64;
        for (near_x, near_y, share) in Clamped::new(middle, level.size).taps() {
            let Some([sx, sy]) = field.shift(level, near_y * level.size[0] + near_x) else { continue };
            let (sx, sy) = (x as i32 + sx * scale as i32, y as i32 + sy * scale as i32);
            let Some(from) = whole.index(sx, sy) else { continue };
            if before.cells[from] == Cell::Known {
                (0..3).for_each(|c| sum[c] += share * before.colours[from][c]);
                weight += share;
            }
        }
        debug_assert!(*cell == Cell::Unknown);
        canvas.colours[i] = if weight > 0.0 {
            sum.map(|sum| sum / weight)
        } else {
            level.colours
                [(y / scale).min(level.size[1] - 1) * level.size[0] + (x / scale).min(level.size[0] - 1)]
        };
        canvas.cells[i] = Cell::Known;
    }
}

#[cfg(test)]
mod tests;
