//! One grid of the pyramid: its cells, its patches, and the vote of the patches over each cell.

use rayon::prelude::*;

use super::search::MatchField;
use super::{Cell, ExemplarImage, REACH};
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::halving::{self, OddSide};

/// One grid of the pyramid.
pub struct ExemplarLevel {
    /// The number of columns and rows.
    pub size: [usize; 2],
    /// The colours as square roots of linear light; those of unknown cells change from turn to turn.
    pub colours: Vec<[f32; 3]>,
    /// The weight of each cell's colour when patches are compared: 0 outside, 1 known, and the smaller the
    /// deeper in the unknown part, so that the synthesis proceeds inwards.
    pub weights: Vec<f32>,
    /// True for the unknown cells.
    pub unknown: Vec<bool>,
    /// True for the cells around which the whole patch is known.
    pub is_source: Vec<bool>,
    /// The centres of the known patches, rising.
    pub sources: Vec<u32>,
    /// The centres of the patches that hold an unknown cell, rising.
    pub targets: Vec<u32>,
}

/// The factor by which the weight decreases with each cell deeper in the unknown part (Wexler et al., section
/// 3.2).
const DEEPER: f32 = 1.3;

/// The least side of a grid, in cells, that is halved once more.
const LEAST_SIDE: usize = 4 * (2 * REACH + 1);

/// Builds the pyramid of a canvas whose unknown cells have the colours `filled`.
pub fn levels(canvas: &ExemplarImage, filled: Vec<[f32; 3]>) -> Vec<ExemplarLevel> {
    let mut canvases = vec![ExemplarImage { colours: filled, ..canvas.clone() }];
    while canvases[canvases.len() - 1].size.iter().all(|side| *side >= LEAST_SIDE) {
        canvases.push(halved(&canvases[canvases.len() - 1]));
    }
    canvases.into_par_iter().map(ExemplarLevel::new).collect()
}

/// Halves a canvas: a cell is known where all four cells are, and outside where all four are.
fn halved(canvas: &ExemplarImage) -> ExemplarImage {
    let cell = |four: &[usize]| {
        let not_outside = four.iter().filter(|at| canvas.cells[**at] != Cell::Outside);
        let count = not_outside.clone().count();
        if count == 0 {
            return (canvas.colours[four[0]], Cell::Outside);
        }
        let known = four.iter().all(|at| canvas.cells[*at] == Cell::Known);
        let mean =
            |c: usize| not_outside.clone().map(|at| canvas.colours[*at][c]).sum::<f32>() / count as f32;
        ([0, 1, 2].map(mean), if known { Cell::Known } else { Cell::Unknown })
    };
    let (colours, cells) = halving::halved(canvas.size, OddSide::Twice, cell).into_iter().unzip();
    ExemplarImage { size: OddSide::Twice.half_size(canvas.size), colours, cells }
}

impl ExemplarLevel {
    fn new(canvas: ExemplarImage) -> Self {
        let ExemplarImage { size, colours, cells } = canvas;
        let unknown: Vec<bool> = cells.iter().map(|cell| *cell == Cell::Unknown).collect();
        let known: Vec<bool> = cells.iter().map(|cell| *cell == Cell::Known).collect();
        let inside = |i: usize| {
            let (x, y) = (i % size[0], i / size[0]);
            x >= REACH && y >= REACH && x + REACH < size[0] && y + REACH < size[1]
        };
        let full = box_sums(&known, size);
        let any = box_sums(&unknown, size);
        let patch = ((2 * REACH + 1) * (2 * REACH + 1)) as u32;
        let is_source: Vec<bool> = (0..cells.len()).map(|i| inside(i) && full[i] == patch).collect();
        let listed = |holds: &dyn Fn(usize) -> bool| {
            (0..cells.len()).filter(|i| holds(*i)).map(|i| i as u32).collect()
        };
        let sources = listed(&|i| is_source[i]);
        let targets = listed(&|i| cells[i] != Cell::Outside && any[i] > 0);
        let weights = weights(&cells, size);
        Self { size, colours, weights, unknown, is_source, sources, targets }
    }

    /// Returns the rectangle of all cells.
    pub fn rect(&self) -> PixelRect {
        PixelRect::of_size(self.size[0] as u32, self.size[1] as u32)
    }

    /// Sets each unknown cell to the mean of the colours that the patches over it propose, weighted by the
    /// similarity of these patches to their sources (Wexler et al., equation 3).
    pub fn vote(&mut self, field: &MatchField) {
        let scale = field.usual_cost().max(1e-6);
        let before = &*self;
        let width = before.size[0];
        let voted: Vec<(u32, [f32; 3])> = before
            .targets
            .par_iter()
            .filter(|target| before.unknown[**target as usize])
            .map(|&target| (target, before.voted(field, target as usize, width, scale)))
            .collect();
        for (target, colour) in voted {
            self.colours[target as usize] = colour;
        }
    }

    fn voted(&self, field: &MatchField, at: usize, width: usize, scale: f32) -> [f32; 3] {
        let (x, y) = (at % width, at / width);
        let (mut sum, mut weight) = ([0.0; 3], 0.0);
        for py in y.saturating_sub(REACH)..(y + REACH + 1).min(self.size[1]) {
            for px in x.saturating_sub(REACH)..(x + REACH + 1).min(width) {
                let Some((source, cost)) = field.best(py * width + px) else { continue };
                // The source's patch lies within the grid, so its corresponding cell does, too.
                let from = source as usize + at - (py * width + px);
                let share = self.weights[py * width + px] * (-cost / scale).exp();
                (0..3).for_each(|c| sum[c] += share * self.colours[from][c]);
                weight += share;
            }
        }
        if weight > 0.0 { sum.map(|sum| sum / weight) } else { self.colours[at] }
    }
}

/// Counts, for each cell, the set cells of the patch around it.
fn box_sums(set: &[bool], [width, height]: [usize; 2]) -> Vec<u32> {
    let mut table = vec![0u32; (width + 1) * (height + 1)];
    for y in 0..height {
        let mut row = 0;
        for x in 0..width {
            row += u32::from(set[y * width + x]);
            table[(y + 1) * (width + 1) + x + 1] = table[y * (width + 1) + x + 1] + row;
        }
    }
    let sum = |i: usize| {
        let (x, y) = (i % width, i / width);
        let [x0, y0] = [x.saturating_sub(REACH), y.saturating_sub(REACH)];
        let [x1, y1] = [(x + REACH + 1).min(width), (y + REACH + 1).min(height)];
        let at = |x: usize, y: usize| table[y * (width + 1) + x];
        at(x1, y1) + at(x0, y0) - at(x1, y0) - at(x0, y1)
    };
    (0..width * height).map(sum).collect()
}

/// Computes the weights from the number of steps to the nearest known cell.
fn weights(cells: &[Cell], [width, height]: [usize; 2]) -> Vec<f32> {
    let mut steps = vec![u16::MAX; cells.len()];
    let mut open: Vec<usize> = (0..cells.len()).filter(|i| cells[*i] == Cell::Known).collect();
    open.iter().for_each(|i| steps[*i] = 0);
    while !open.is_empty() {
        let mut next = Vec::new();
        for i in open {
            let (x, y) = (i % width, i / width);
            let mut reach = |j: usize| {
                if steps[j] == u16::MAX {
                    steps[j] = steps[i].saturating_add(1);
                    next.push(j);
                }
            };
            [
                (x > 0, i.wrapping_sub(1)),
                (x + 1 < width, i + 1),
                (y > 0, i.wrapping_sub(width)),
                (y + 1 < height, i + width),
            ]
            .into_iter()
            .filter(|(inside, _)| *inside)
            .for_each(|(_, j)| reach(j));
        }
        open = next;
    }
    let weight = |(cell, steps): (&Cell, &u16)| match cell {
        Cell::Outside => 0.0,
        // Deep in the unknown part all cells have the same small weight.
        _ => DEEPER.powi(-i32::from((*steps).min(20))),
    };
    cells.iter().zip(&steps).map(weight).collect()
}
