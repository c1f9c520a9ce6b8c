//! Pixel and texel sets as runs per row, with set operations, growing and halving. Their cost is proportional to
//! outlines, not to areas.

use std::ops::Range;

use super::PixelRect;

/// A run of columns `start..end` in a row.
pub type ColumnRun = Range<i32>;

/// A set of texels as disjoint, ascending runs that never touch, row by row from `top`.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct Spans {
    top: i32,
    /// The index in `runs` where each row begins, and where the last one ends; empty for the empty set.
    starts: Vec<u32>,
    runs: Vec<ColumnRun>,
}

impl Spans {
    /// Builds a set from `rows`; `fill(y, out)` appends each row's runs, ascending and disjoint.
    pub fn from_rows(rows: Range<i32>, mut fill: impl FnMut(i32, &mut Vec<ColumnRun>)) -> Self {
        let mut spans = Self { top: rows.start, starts: vec![0], runs: Vec::new() };
        let mut row = Vec::new();
        for y in rows {
            row.clear();
            fill(y, &mut row);
            join_touching(&row, &mut spans.runs);
            spans.starts.push(spans.runs.len() as u32);
        }
        spans
    }

    /// Builds the set of pixels of a rectangle for which a predicate is true.
    pub fn of_pixels(within: PixelRect, holds: impl Fn(i32, i32) -> bool) -> Self {
        Self::from_rows(within.y..within.bottom(), |y, out| {
            let mut x = within.x;
            while x < within.right() {
                let held = holds(x, y);
                let end = (x + 1..within.right()).find(|&x| holds(x, y) != held).unwrap_or(within.right());
                if held {
                    out.push(x..end);
                }
                x = end;
            }
        })
    }

    /// Returns the rows that may hold texels; all others are empty.
    #[inline]
    pub fn rows(&self) -> Range<i32> {
        self.top..self.top + self.starts.len().saturating_sub(1) as i32
    }

    /// Returns the runs of a row; empty outside of [`Self::rows`].
    #[inline]
    pub fn row(&self, y: i32) -> &[ColumnRun] {
        if !self.rows().contains(&y) {
            return &[];
        }
        let at = (y - self.top) as usize;
        &self.runs[self.starts[at] as usize..self.starts[at + 1] as usize]
    }

    /// Iterates over all runs with their rows, top to bottom and left to right.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = (i32, &ColumnRun)> {
        self.rows().flat_map(|y| self.row(y).iter().map(move |run| (y, run)))
    }

    /// Returns the number of texels.
    #[inline]
    pub fn count(&self) -> u64 {
        self.runs.iter().map(|run| run.len() as u64).sum()
    }

    /// Returns true for the empty set.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// Returns the smallest rectangle that contains the set.
    #[inline]
    pub fn bounds(&self) -> PixelRect {
        let filled = || self.rows().filter(|&y| !self.row(y).is_empty());
        let left = self.runs.iter().map(|run| run.start).min().unwrap_or(0);
        let right = self.runs.iter().map(|run| run.end).max().unwrap_or(0);
        let (top, last) = (filled().next().unwrap_or(0), filled().next_back().unwrap_or(-1));
        PixelRect::from_edges(left, top, right, last + 1)
    }

    /// Returns the set grown by `by` rows and columns (a square, not a disc).
    pub fn grown(&self, by: i32) -> Self {
        let wide = |run: &ColumnRun| run.start - by..run.end + by;
        let mut grown = Self::from_rows(self.rows(), |y, out| out.extend(self.row(y).iter().map(wide)));
        let mut reach = 0;
        // First rows -1, 0, 1 are united, then rows -3, 0, 3 of the result: the reach triples, so few unions are
        // needed.
        while reach < by && !grown.is_empty() {
            let step = (2 * reach + 1).min(by - reach);
            grown = grown.stacked(step);
            reach += step;
        }
        grown
    }

    /// Returns the union of the set with itself moved `step` rows up and down.
    fn stacked(&self, step: i32) -> Self {
        let rows = self.rows().start - step..self.rows().end + step;
        let mut pair = Vec::new();
        Self::from_rows(rows, |y, out| {
            pair.clear();
            unite(self.row(y - step), self.row(y), &mut pair);
            unite(&pair, self.row(y + step), out);
        })
    }

    /// Returns true when the set contains a pixel.
    #[inline]
    pub fn holds(&self, x: i32, y: i32) -> bool {
        let row = self.row(y);
        let behind = row.partition_point(|run| run.start <= x);
        behind > 0 && x < row[behind - 1].end
    }

    /// Returns the texels that are in either set.
    #[inline]
    pub fn union(&self, other: &Self) -> Self {
        let rows = match (self.is_empty(), other.is_empty()) {
            (true, _) => other.rows(),
            (_, true) => self.rows(),
            _ => self.rows().start.min(other.rows().start)..self.rows().end.max(other.rows().end),
        };
        Self::from_rows(rows, |y, out| unite(self.row(y), other.row(y), out))
    }

    /// Returns the texels that are in this set and not in `other`.
    #[inline]
    pub fn minus(&self, other: &Self) -> Self {
        Self::from_rows(self.rows(), |y, out| subtract(self.row(y), other.row(y), out))
    }

    /// Returns the texels that are in both sets.
    #[inline]
    pub fn intersection(&self, other: &Self) -> Self {
        let mut rest = Vec::new();
        Self::from_rows(self.rows(), |y, out| {
            rest.clear();
            subtract(self.row(y), other.row(y), &mut rest);
            subtract(self.row(y), &rest, out);
        })
    }

    /// Returns the texels of a rectangle that are not in this set.
    #[inline]
    pub fn complement(&self, within: PixelRect) -> Self {
        let whole = within.x..within.right();
        let rows = within.y..within.bottom();
        Self::from_rows(rows, |y, out| subtract(std::slice::from_ref(&whole), self.row(y), out))
    }

    /// Returns the texels of half the resolution that contain any texel of this set: columns are halved where `x`,
    /// rows where `y`.
    pub fn halved(&self, [x, y]: [bool; 2]) -> Self {
        let narrow = |run: &ColumnRun| if x { run.start >> 1..(run.end + 1) >> 1 } else { run.clone() };
        let rows = if y { self.top >> 1..(self.rows().end + 1) >> 1 } else { self.rows() };
        let (mut pair, mut halves) = (Vec::new(), Vec::new());
        Self::from_rows(rows, |row, out| {
            pair.clear();
            halves.clear();
            let below = if y { self.row(2 * row + 1) } else { &[] };
            unite(self.row(if y { 2 * row } else { row }), below, &mut pair);
            halves.extend(pair.iter().map(narrow));
            out.extend(halves.iter().cloned());
        })
    }
}

/// Appends ascending runs, those that touch or overlap joined into one.
fn join_touching(rising: &[ColumnRun], out: &mut Vec<ColumnRun>) {
    let first = out.len();
    for run in rising.iter().filter(|run| !run.is_empty()) {
        match out[first..].last_mut() {
            Some(last) if run.start <= last.end => last.end = last.end.max(run.end),
            _ => out.push(run.clone()),
        }
    }
}

/// Appends the union of two rows, ascending.
fn unite(a: &[ColumnRun], b: &[ColumnRun], out: &mut Vec<ColumnRun>) {
    let (mut a, mut b) = (a.iter().peekable(), b.iter().peekable());
    let first = out.len();
    while let Some(run) = match (a.peek(), b.peek()) {
        (Some(x), Some(y)) if x.start <= y.start => a.next(),
        (Some(_), None) => a.next(),
        _ => b.next(),
    } {
        match out[first..].last_mut() {
            Some(last) if run.start <= last.end => last.end = last.end.max(run.end),
            _ => out.push(run.clone()),
        }
    }
}

/// Appends the runs of `a` without those of `b`, ascending.
fn subtract(a: &[ColumnRun], b: &[ColumnRun], out: &mut Vec<ColumnRun>) {
    let mut holes = b.iter().peekable();
    for run in a {
        let mut from = run.start;
        while holes.next_if(|hole| hole.end <= from).is_some() {}
        while let Some(hole) = holes.peek().filter(|hole| hole.start < run.end) {
            if from < hole.start {
                out.push(from..hole.start);
            }
            from = hole.end;
            if hole.end > run.end {
                break;
            }
            holes.next();
        }
        if from < run.end {
            out.push(from..run.end);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::synthetic::Rng;

    const SIDE: i32 = 24;

    /// Returns the set as a bitmap, which is slow and simple.
    fn picture(spans: &Spans) -> Vec<bool> {
        let mut picture = vec![false; (3 * SIDE * 3 * SIDE) as usize];
        for (y, run) in spans.iter() {
            for x in run.clone() {
                picture[((y + SIDE) * 3 * SIDE + x + SIDE) as usize] = true;
            }
        }
        picture
    }

    fn at(picture: &[bool], x: i32, y: i32) -> bool {
        let inside = (-SIDE..2 * SIDE).contains(&x) && (-SIDE..2 * SIDE).contains(&y);
        inside && picture[((y + SIDE) * 3 * SIDE + x + SIDE) as usize]
    }

    fn random(rng: &mut Rng) -> Spans {
        Spans::from_rows(0..SIDE, |_, out| {
            let mut x = rng.between(0.0, 9.0) as i32;
            while x < SIDE - 5 && rng.between(0.0, 1.0) < 0.8 {
                let end = x + rng.between(1.0, 5.0) as i32;
                out.push(x..end);
                x = end + rng.between(0.0, 6.0) as i32;
            }
        })
    }

    fn check(name: &str, found: &Spans, expected: impl Fn(i32, i32) -> bool) {
        let found = picture(found);
        for y in -SIDE..2 * SIDE {
            for x in -SIDE..2 * SIDE {
                assert_eq!(at(&found, x, y), expected(x, y), "{name} at {x}, {y}");
            }
        }
    }

    #[test]
    fn sets_of_runs_are_sets_of_texels() {
        let mut rng = Rng::new(11);
        for _ in 0..50 {
            let (a, b) = (random(&mut rng), random(&mut rng));
            let (p, q) = (picture(&a), picture(&b));
            check("minus", &a.minus(&b), |x, y| at(&p, x, y) && !at(&q, x, y));
            check("union", &a.union(&b), |x, y| at(&p, x, y) || at(&q, x, y));
            check("union with nothing", &Spans::default().union(&b), |x, y| at(&q, x, y));
            let everywhere = PixelRect { x: -SIDE, y: -SIDE, w: 3 * SIDE as u32, h: 3 * SIDE as u32 };
            check("of pixels", &Spans::of_pixels(everywhere, |x, y| at(&p, x, y)), |x, y| a.holds(x, y));
            check("intersection", &a.intersection(&b), |x, y| at(&p, x, y) && at(&q, x, y));
            for by in [1, 2, 5, 8] {
                let near = |x, y| (-by..=by).any(|dy| (-by..=by).any(|dx| at(&p, x + dx, y + dy)));
                check("grown", &a.grown(by), near);
            }
            let within = PixelRect { x: -3, y: -2, w: 30, h: 29 };
            let inside = |x, y| (-3..27).contains(&x) && (-2..27).contains(&y);
            check("complement", &a.complement(within), |x, y| inside(x, y) && !at(&p, x, y));
            let any = |x, y| (0..4).any(|i| at(&p, 2 * x + i % 2, 2 * y + i / 2));
            check("halved", &a.halved([true, true]), any);
            check("halved in columns", &a.halved([true, false]), |x, y| {
                at(&p, 2 * x, y) || at(&p, 2 * x + 1, y)
            });
            let texels = p.iter().filter(|&&set| set).count() as u64;
            assert_eq!(a.count(), texels);
        }
    }

    #[test]
    fn bounds_hold_every_run_and_nothing_has_none() {
        let spans = Spans::from_rows(2..9, |y, out| {
            if (4..6).contains(&y) {
                out.push(y..y + 3);
            }
        });
        assert_eq!(spans.bounds(), PixelRect { x: 4, y: 4, w: 4, h: 2 });
        assert!(Spans::default().bounds().is_empty() && Spans::default().grown(3).is_empty());
    }
}
