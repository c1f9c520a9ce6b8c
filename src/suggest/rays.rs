//! Rays of points that faces would block: every observation is a line of sight that nothing stands in.

use quadratura_base::geometry::Plane;

use super::chart::PlaneChart;
use super::planes::tolerance;
use super::points::NormalisedPoint;
use super::support::passes;
use super::view::WorkingPhoto;

/// The share of a ray behind a face from which on it is blocked.
const BEHIND: f64 = 0.03;
/// The share of the rays that meet a face which it may block: wild points are not fewer.
const MOST_BLOCKED: f64 = 0.01;
/// The side of the squares that are cut out, in cells: smaller holes are no part of an outline.
const SQUARE: usize = 8;

/// The rays that meet a plane, as cells of its raster.
pub struct Rays {
    /// Those that go on behind it.
    pub blocked: Vec<usize>,
    /// Those that end on it.
    pub ending: Vec<usize>,
}

impl Rays {
    /// Collects the rays of points whose observers are known.
    pub fn new(
        plane: &Plane,
        chart: &PlaneChart,
        points: &[NormalisedPoint],
        views: &[WorkingPhoto],
    ) -> Self {
        let mut rays = Self { blocked: Vec::new(), ending: Vec::new() };
        for point in points.iter().filter(|point| point.is_tracked) {
            let is_on = plane.signed_distance(point.at).abs() < tolerance(point);
            for observer in &point.observers {
                let eye = views[*observer as usize].eye;
                if is_on && plane.signed_distance(eye) > 0.0 {
                    rays.ending.extend(chart.index(point.at));
                } else if let Some(at) = passes(eye, point, plane, BEHIND) {
                    rays.blocked.extend(chart.index(at));
                }
            }
        }
        rays
    }

    /// Returns how many rays a mask blocks, and how many meet it.
    pub fn count(&self, mask: &[bool]) -> (usize, usize) {
        let on = |cells: &[usize]| cells.iter().filter(|cell| mask[**cell]).count();
        let blocked = on(&self.blocked);
        (blocked, blocked + on(&self.ending))
    }

    /// Returns whether a mask blocks more than 1 % of the rays that meet it; one ray alone may be wrong.
    pub fn is_wrong(&self, mask: &[bool]) -> bool {
        let (blocked, met) = self.count(mask);
        blocked > 1 && blocked as f64 > MOST_BLOCKED * met as f64
    }

    /// Cuts squares out of a mask, those that block most first, until it blocks no more than a share of the rays that meet it.
    pub fn cut(&self, mask: &mut [bool], chart: &PlaneChart, most: f64) {
        let columns = chart.size[0].div_ceil(SQUARE);
        let square = |cell: usize| (cell / chart.size[0] / SQUARE) * columns + cell % chart.size[0] / SQUARE;
        let count = columns * chart.size[1].div_ceil(SQUARE);
        let tally = |cells: &[usize], mask: &[bool]| {
            let mut counts = vec![0usize; count];
            cells.iter().filter(|cell| mask[**cell]).for_each(|cell| counts[square(*cell)] += 1);
            counts
        };
        let (blocked, ending) = (tally(&self.blocked, mask), tally(&self.ending, mask));
        let (mut all_blocked, mut all) = self.count(mask);
        let mut order: Vec<usize> = (0..count).filter(|i| blocked[*i] > 0).collect();
        let share = |i: usize| blocked[i] as f64 / (blocked[i] + ending[i]) as f64;
        order.sort_by(|a, b| {
            share(*b).total_cmp(&share(*a)).then(blocked[*b].cmp(&blocked[*a])).then(a.cmp(b))
        });
        let mut is_cut = vec![false; count];
        for i in order {
            if all_blocked as f64 <= most * all as f64 {
                break;
            }
            is_cut[i] = true;
            all_blocked -= blocked[i];
            all -= blocked[i] + ending[i];
        }
        mask.iter_mut().enumerate().for_each(|(cell, own)| *own &= !is_cut[square(cell)]);
    }
}
