//! One grid of the pyramid: its cells, its patches, and what a cell takes from the patches over it.

use rayon::prelude::*;

use super::search::Field;
use super::{Canvas, Cell, REACH};
use crate::geometry::PixelRect;
use crate::raster::halving::{self, OddSide};

/// A grid.
pub struct Level {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Roots of linear light; those of unknown cells change from turn to turn.
    pub colours: Vec<[f32; 3]>,
    /// How far a cell's colour counts where patches are compared: 0 outside, 1 known, less the deeper in the
    /// unknown, so that the picture grows inwards.
    pub weights: Vec<f32>,
    /// The cell is unknown, and asked for.
    pub unknown: Vec<bool>,
    /// Whether the patch around a cell is known as a whole.
    pub is_source: Vec<bool>,
    /// Middles of such patches, rising.
    pub sources: Vec<u32>,
    /// Middles of patches that hold something unknown, rising.
    pub targets: Vec<u32>,
}

/// How much less a colour counts a cell deeper in the unknown (Wexler et al., section 3.2).
const DEEPER: f32 = 1.3;

/// Grids are halved while their shorter side has so many cells.
const LEAST_SIDE: usize = 4 * (2 * REACH + 1);

/// The canvas with its unknown cells as `filled`, and halved again and again.
pub fn levels(canvas: &Canvas, filled: Vec<[f32; 3]>) -> Vec<Level> {
    let mut canvases = vec![Canvas { colours: filled, ..canvas.clone() }];
    while canvases[canvases.len() - 1].size.iter().all(|side| *side >= LEAST_SIDE) {
        canvases.push(halved(&canvases[canvases.len() - 1]));
    }
    canvases.into_par_iter().map(Level::of).collect()
}

/// Known where all four cells are, asked for where one is.
fn halved(canvas: &Canvas) -> Canvas {
    let cell = |four: &[usize]| {
        let asked = four.iter().filter(|at| canvas.cells[**at] != Cell::Outside);
        let count = asked.clone().count();
        if count == 0 {
            return (canvas.colours[four[0]], Cell::Outside);
        }
        let known = four.iter().all(|at| canvas.cells[*at] == Cell::Known);
        let mean = |c: usize| asked.clone().map(|at| canvas.colours[*at][c]).sum::<f32>() / count as f32;
        ([0, 1, 2].map(mean), if known { Cell::Known } else { Cell::Unknown })
    };
    let (colours, cells) = halving::halved(canvas.size, OddSide::Twice, cell).into_iter().unzip();
    Canvas { size: OddSide::Twice.half_size(canvas.size), colours, cells }
}

impl Level {
    fn of(canvas: Canvas) -> Self {
        let Canvas { size, colours, cells } = canvas;
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

    /// All cells.
    pub fn rect(&self) -> PixelRect {
        PixelRect::of_size(self.size[0] as u32, self.size[1] as u32)
    }

    /// Gives each unknown cell the mean of what the patches over it say, those that are like their example
    /// counting more (Wexler et al., equation 3).
    pub fn vote(&mut self, field: &Field) {
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

    fn voted(&self, field: &Field, at: usize, width: usize, scale: f32) -> [f32; 3] {
        let (x, y) = (at % width, at / width);
        let (mut sum, mut weight) = ([0.0; 3], 0.0);
        for py in y.saturating_sub(REACH)..(y + REACH + 1).min(self.size[1]) {
            for px in x.saturating_sub(REACH)..(x + REACH + 1).min(width) {
                let Some((source, cost)) = field.best(py * width + px) else { continue };
                // A source's patch is within the grid, so what lies at the same place of it is, too.
                let from = source as usize + at - (py * width + px);
                let share = self.weights[py * width + px] * (-cost / scale).exp();
                (0..3).for_each(|c| sum[c] += share * self.colours[from][c]);
                weight += share;
            }
        }
        if weight > 0.0 { sum.map(|sum| sum / weight) } else { self.colours[at] }
    }
}

/// For each cell how many of the patch around it are set.
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

/// By the number of steps to the nearest known cell.
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
        // Deep in the unknown all count alike, and not nothing.
        _ => DEEPER.powi(-i32::from((*steps).min(20))),
    };
    cells.iter().zip(&steps).map(weight).collect()
}
