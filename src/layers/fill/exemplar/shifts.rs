//! The dominant shifts, by which the known part is most similar to itself (He and Sun 2012), such as the
//! distances of windows and of courses of stone.

use super::level::ExemplarLevel;
use super::random::{number, within};
use super::{REACH, TURNS};
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Image;
use rayon::prelude::*;

/// The number of shifts kept; the peaks of the histogram fall off quickly.
const KEPT: usize = 12;

/// The number of patches sampled: enough to fill a histogram.
const ASKED: usize = 4096;

/// The largest number of cells of the grid that is analysed.
const MOST_CELLS: usize = 160 * 160;

/// The length of the shortest shift considered, as a share of the longer side: every image is similar to
/// itself under shorter ones.
const LEAST_SHARE: f32 = 1.0 / 15.0;

/// A shift, with the grid in whose cells it is expressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shift {
    cells: [i32; 2],
    level: usize,
}

impl Shift {
    /// Converts the shift to cells of grid number `level`, 0 being the finest of the given ones.
    pub fn at(&self, level: usize) -> [i32; 2] {
        self.cells.map(|side| match self.level.checked_sub(level) {
            Some(finer) => side << finer,
            None => side >> (level - self.level),
        })
    }
}

/// Finds the dominant shifts of the known part and their opposites. `levels` are the grids that are searched.
pub fn dominant(levels: &[ExemplarLevel], seed: u64) -> Vec<Shift> {
    let index = levels.iter().position(|l| l.colours.len() <= MOST_CELLS).unwrap_or(levels.len() - 1);
    let level = &levels[index];
    let least = ((level.size[0].max(level.size[1]) as f32 * LEAST_SHARE) as i32).max(2 * REACH as i32);
    let step = level.sources.len().div_ceil(ASKED).max(1);
    let sampled: Vec<u32> = level.sources.iter().copied().step_by(step).collect();
    let found: Vec<[i32; 2]> =
        sampled.par_iter().filter_map(|&patch| most_similar(level, patch, least, seed)).collect();
    peaks(&found, level.size).into_iter().map(|cells| Shift { cells, level: index }).collect()
}

/// Finds the shift of at least `least` cells to the most similar patch, at random and around the best found
/// so far; `None` when there is none.
fn most_similar(level: &ExemplarLevel, patch: u32, least: i32, seed: u64) -> Option<[i32; 2]> {
    let (whole, [width, height]) = (level.rect(), level.size.map(|side| side as i32));
    let (x, y) = (patch as i32 % width, patch as i32 / width);
    let mut best: Option<([i32; 2], f32)> = None;
    let offer = |[dx, dy]: [i32; 2], best: &mut Option<([i32; 2], f32)>| {
        let source = whole.index(x + dx, y + dy).filter(|source| level.is_source[*source]);
        let Some(source) = source.filter(|_| dx.abs().max(dy.abs()) >= least) else { return };
        let limit = best.map_or(f32::INFINITY, |best| best.1);
        let cost = difference(level, patch as usize, source, limit);
        if cost < limit {
            *best = Some(([dx, dy], cost));
        }
    };
    // Along the axes every shift is tried, because facades repeat in these directions.
    for shift in (-width..width).map(|dx| [dx, 0]).chain((-height..height).map(|dy| [0, dy])) {
        offer(shift, &mut best);
    }
    for step in 0..64 {
        let source =
            level.sources[number(seed, patch.into(), step + 100) as usize % level.sources.len()] as i32;
        offer([source % width - x, source / width - y], &mut best);
    }
    for turn in 0..TURNS[0] as u64 {
        let reach = (16 >> turn).max(1);
        let random = number(seed, patch.into(), turn + 200);
        let from = best?.0;
        offer([from[0] + within(random & 0xffff, reach), from[1] + within(random >> 32, reach)], &mut best);
    }
    best.map(|(shift, _)| shift)
}

fn difference(level: &ExemplarLevel, a: usize, b: usize, limit: f32) -> f32 {
    let width = level.size[0];
    let mut sum = 0.0;
    for row in 0..=2 * REACH {
        let first = |middle: usize| middle + row * width - REACH * width - REACH;
        let (a, b) = (first(a), first(b));
        let cells = level.colours[a..=a + 2 * REACH].iter().zip(&level.colours[b..=b + 2 * REACH]);
        let mut row_sum = 0.0;
        for (a, b) in cells {
            let [r, g, b] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
            row_sum += r * r + g * g + b * b;
        }
        sum += row_sum;
        if sum > limit {
            return f32::INFINITY;
        }
    }
    sum
}

/// Finds the highest bins of the histogram of shifts. A shift and its opposite count as one, and both are
/// returned.
fn peaks(found: &[[i32; 2]], size: [usize; 2]) -> Vec<[i32; 2]> {
    let [width, height] = size.map(|side| side as i32);
    let all = PixelRect::from_edges(-width, -height, width + 1, height + 1);
    let mut histogram = Image::filled(all, 0u32);
    for &[dx, dy] in found {
        for [dx, dy] in [[dx, dy], [-dx, -dy]] {
            for (nx, ny) in (-1..=1).flat_map(|ny| (-1..=1).map(move |nx| (nx, ny))) {
                if let Some(count) = histogram.get_mut(dx + nx, dy + ny) {
                    *count += 2 - nx.abs().max(ny.abs()) as u32;
                }
            }
        }
    }
    let mut order: Vec<_> = histogram.iter().filter(|(_, count)| **count > 0).collect();
    order.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
    let mut kept: Vec<[i32; 2]> = Vec::new();
    for ((dx, dy), _) in order {
        let shift = [dx, dy];
        if kept.iter().all(|other| (shift[0] - other[0]).abs().max((shift[1] - other[1]).abs()) > 2) {
            kept.push(shift);
        }
        if kept.len() == KEPT {
            break;
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fullest_places_come_first_and_both_ways() {
        let found: Vec<[i32; 2]> = [[12, 0]; 9].into_iter().chain([[0, 7]; 4]).chain([[30, 3]]).collect();
        let kept = peaks(&found, [40, 40]);
        assert_eq!(kept[..4], [[-12, 0], [12, 0], [0, -7], [0, 7]]);
    }

    #[test]
    fn a_shift_is_the_same_way_on_every_grid() {
        let shift = Shift { cells: [6, -4], level: 1 };
        assert_eq!([shift.at(0), shift.at(1), shift.at(2)], [[12, -8], [6, -4], [3, -2]]);
    }
}
