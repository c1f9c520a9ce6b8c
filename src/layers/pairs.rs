//! The table of occlusions, counted from the fragment lists.

use std::ops::Range;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::projected_model::ProjectedModel;
use super::rasteriser::{Band, FragmentLists, Occlusion, VISIBLE, is_behind};
use quadratura_base::geometry::InverseDepth;

/// Rows that one parallel job counts; a band may be the whole photo.
const JOB_ROWS: u32 = 64;

/// Counts the table of occlusions (pass *pairs*): every ordered pair of items of which the first is nearer by
/// more than the tolerance at one pixel or more, with the number of those pixels, sorted by (front, back).
///
/// The result depends on the lists alone: a rasteriser that counts its own table from the same lists has to
/// produce an equal one.
pub fn count_pairs(view: &ProjectedModel, lists: &FragmentLists, tolerance: f32) -> Vec<Occlusion> {
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

/// Iterates over the pixels of a band in row order: column, row, entries.
pub fn pixels<'a>(
    lists: &'a FragmentLists,
    band: &'a Band,
) -> impl Iterator<Item = (u32, u32, &'a [u32])> + 'a {
    (band.y0..band.y1).flat_map(move |y| (0..lists.width).map(move |x| (x, y, lists.pixel(band, x, y))))
}

/// The number of pixels per pair (front, back).
type PairCounts = FxHashMap<(u32, u32), u32>;

/// Counts the pairs of [`JOB_ROWS`] rows from `y0` on. Neighbouring pixels mostly hold the same entries, so a
/// run of such pixels is counted at once.
fn pairs_of_rows(
    view: &ProjectedModel,
    lists: &FragmentLists,
    band: &Band,
    y0: u32,
    tolerance: f32,
) -> PairCounts {
    let mut table = PairCounts::default();
    for y in y0..(y0 + JOB_ROWS).min(band.y1) {
        let mut x = 0;
        while x < lists.width {
            let (begin, entries) = (x, lists.pixel(band, x, y));
            x += 1;
            while x < lists.width && lists.pixel(band, x, y) == entries {
                x += 1;
            }
            count_run(view, entries, begin..x, y, tolerance, &mut table);
        }
    }
    table
}

/// Counts every pair of the `entries` that all pixels of a run hold.
fn count_run(
    view: &ProjectedModel,
    entries: &[u32],
    run: Range<u32>,
    y: u32,
    tolerance: f32,
    table: &mut PairCounts,
) {
    for (i, one) in entries.iter().map(|entry| entry & !VISIBLE).enumerate() {
        for other in entries[i + 1..].iter().map(|entry| entry & !VISIBLE) {
            let [p, q] = [one, other].map(|item| &view.items[item as usize].inverse_depth);
            let [one_in_front, other_in_front] = nearer_px(p, q, run.clone(), y, tolerance);
            if one_in_front > 0 {
                *table.entry((one, other)).or_default() += one_in_front;
            }
            if other_in_front > 0 {
                *table.entry((other, one)).or_default() += other_in_front;
            }
        }
    }
}

/// Counts the pixels of a run at which `p` is nearer than `q` by more than the tolerance, and those at which
/// `q` is nearer than `p`.
fn nearer_px(p: &InverseDepth, q: &InverseDepth, run: Range<u32>, y: u32, tolerance: f32) -> [u32; 2] {
    // The margin by which each is not behind the other; negative where it is behind.
    let margin = |x: u32| {
        let (p, q) = (p.at(x, y), q.at(x, y));
        [p * (1.0 + tolerance) - q, q * (1.0 + tolerance) - p]
    };
    let (left, right) = (margin(run.start), margin(run.end - 1));
    let rounding = uncertainty(p, &run, y) + uncertainty(q, &run, y);
    // The margin is linear along the row. A sign that holds at both ends, by more than rounding could change,
    // holds between them.
    let certain = |i: usize| left[i].min(right[i]) > rounding || left[i].max(right[i]) < -rounding;
    if certain(0) && certain(1) {
        let px = run.len() as u32;
        return [if left[1] < 0.0 { px } else { 0 }, if left[0] < 0.0 { px } else { 0 }];
    }
    run.fold([0, 0], |[p_px, q_px], x| {
        let (p, q) = (p.at(x, y), q.at(x, y));
        [p_px + u32::from(is_behind(q, p, tolerance)), q_px + u32::from(is_behind(p, q, tolerance))]
    })
}

/// Bounds the rounding errors of inverse depths along a run from above: four times the sum of half a unit in
/// the last place of every term.
fn uncertainty(plane: &InverseDepth, run: &Range<u32>, y: u32) -> f32 {
    let dx = (run.start as f32 - plane.u0).abs().max((run.end as f32 - plane.u0).abs());
    let dy = (y as f32 - plane.v0).abs() + 1.0;
    (plane.a.abs() * dx + plane.b.abs() * dy + plane.c.abs()) * 2.0_f32.powi(-20)
}

fn sum(mut larger: PairCounts, mut smaller: PairCounts) -> PairCounts {
    if larger.len() < smaller.len() {
        std::mem::swap(&mut larger, &mut smaller);
    }
    for (pair, px) in smaller {
        *larger.entry(pair).or_default() += px;
    }
    larger
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns coefficients of two planes that nearly touch somewhere on a row, from a seed.
    fn planes(seed: u64) -> [InverseDepth; 2] {
        let mut rng = quadratura_base::scene::synthetic::Rng::new(seed);
        let c = rng.between(0.01, 1.0) as f32;
        let mut plane = |near: f32| InverseDepth {
            a: rng.between(-1e-5, 1e-5) as f32,
            b: rng.between(-1e-3, 1e-3) as f32,
            c: near * (1.0 + rng.between(-2e-4, 2e-4) as f32),
            u0: rng.whole(0, 6000) as f32 * 0.5,
            v0: 50.0,
        };
        [plane(c), plane(c)]
    }

    #[test]
    fn a_run_counts_what_its_pixels_count_one_by_one() {
        for seed in 0..2000 {
            let [p, q] = planes(seed);
            for tolerance in [0.0, 1e-4] {
                let whole = nearer_px(&p, &q, 1000..2000, 50, tolerance);
                let pixels = (1000..2000).map(|x| nearer_px(&p, &q, x..x + 1, 50, tolerance));
                let apart = pixels.fold([0, 0], |sum, px| [sum[0] + px[0], sum[1] + px[1]]);
                let plain = |front: &InverseDepth, back: &InverseDepth| {
                    (1000..2000).filter(|&x| is_behind(back.at(x, 50), front.at(x, 50), tolerance)).count()
                        as u32
                };
                assert_eq!(whole, [plain(&p, &q), plain(&q, &p)], "seed {seed}");
                assert_eq!(whole, apart, "seed {seed}");
            }
        }
    }
}
