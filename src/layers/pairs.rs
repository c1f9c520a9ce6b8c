//! The table of occlusions, counted from fragment lists.

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::rasteriser::{Band, FragmentLists, Occlusion, VISIBLE, is_behind};
use super::view::View;

/// Rows that one job counts: a band may be the whole photo.
const JOB_ROWS: u32 = 64;

/// Pass *pairs*: every ordered pair of items of which the first is nearer by more than the
/// tolerance at one pixel or more, with the number of those pixels; sorted by (front, back).
///
/// A function of the lists alone: a rasteriser's own table of the same lists is equal to it.
pub fn count_pairs(view: &View, lists: &FragmentLists, tolerance: f32) -> Vec<Occlusion> {
    let jobs: Vec<(&Band, u32)> = lists
        .bands
        .iter()
        .flat_map(|band| (band.y0..band.y1).step_by(JOB_ROWS as usize).map(move |y| (band, y)))
        .collect();
    let table = jobs
        .into_par_iter()
        .map(|(band, y)| pairs_of_rows(view, lists, band, y, tolerance))
        .reduce(FxHashMap::default, sum);
    let pair = |((front, back), px)| Occlusion { front, back, px };
    let mut occlusions: Vec<Occlusion> = table.into_iter().map(pair).collect();
    occlusions.par_sort_unstable();
    occlusions
}

/// Every pixel of a band in row order: column, row, entries.
pub fn pixels<'a>(
    lists: &'a FragmentLists,
    band: &'a Band,
) -> impl Iterator<Item = (u32, u32, &'a [u32])> + 'a {
    (band.y0..band.y1).flat_map(move |y| (0..lists.width).map(move |x| (x, y, lists.pixel(band, x, y))))
}

/// Pixels per (front, back).
type Table = FxHashMap<(u32, u32), u32>;

fn pairs_of_rows(view: &View, lists: &FragmentLists, band: &Band, y0: u32, tolerance: f32) -> Table {
    let mut table = Table::default();
    let mut depths = Vec::new();
    for y in y0..(y0 + JOB_ROWS).min(band.y1) {
        for x in 0..lists.width {
            depths.clear();
            depths.extend(lists.pixel(band, x, y).iter().map(|entry| {
                let item = entry & !VISIBLE;
                (item, view.items[item as usize].inverse_depth.at(x, y))
            }));
            count_pixel(&depths, tolerance, &mut table);
        }
    }
    table
}

fn count_pixel(depths: &[(u32, f32)], tolerance: f32, table: &mut Table) {
    for &(front, nearer) in depths {
        for &(back, farther) in depths {
            if is_behind(farther, nearer, tolerance) {
                *table.entry((front, back)).or_default() += 1;
            }
        }
    }
}

fn sum(mut larger: Table, mut smaller: Table) -> Table {
    if larger.len() < smaller.len() {
        std::mem::swap(&mut larger, &mut smaller);
    }
    for (pair, px) in smaller {
        *larger.entry(pair).or_default() += px;
    }
    larger
}
