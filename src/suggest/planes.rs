//! Planes on which sparse points lie, by sequential RANSAC (Fischler and Bolles 1981): plumb ones first, then any, then level
//! ones, each seen from one side.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use quadratura_align::linear::eigen;
use quadratura_base::geometry::Plane;
use quadratura_base::geometry::polygon::PlaneFrame;
use quadratura_base::raster::robust::{of_rank, upper_median};
use quadratura_base::scene::synthetic::Rng;

use super::points::NormalisedPoint;

/// How a plane lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaneKind {
    /// The ground under the cameras.
    Ground,
    /// A wall.
    Plumb,
    /// A level surface above the ground.
    Level,
    /// A roof, a ramp.
    Sloped,
    /// An upright stand-in for a thing that has no planes.
    Thing,
}

/// A plane of points.
#[derive(Debug, Clone)]
pub struct PlaneOfPoints {
    /// The plane; the normal is towards the observers.
    pub plane: Plane,
    /// How it lies.
    pub kind: PlaneKind,
    /// The points on it.
    pub members: Vec<u32>,
    /// Other places at which photos agree about it.
    pub places: Vec<DVec3>,
}

/// Trials for each plane.
const TRIALS: usize = 2100;
/// Points by which trials are judged.
const JUDGES: usize = 1500;
/// The neighbours of a point among which the others of a trial are drawn.
const NEAR: usize = 30;
/// The fewest points of a plane.
const FEWEST: usize = 14;
/// Cells in which points of one island of a plane are neighbours.
const ISLAND_CELL: f64 = 0.04;
/// The sine of 4 degrees: a plane that is so near to plumb is plumb.
const PLUMB: f64 = 0.0698;
/// The cosine of 10 degrees: a plane that is so near to level is level.
const LEVEL: f64 = 0.9848;
/// Attempts without a plane after which the search ends.
const FAILURES: usize = 6;

/// The share of points on no plane from which on a search goes on beside planes that failed. Of castle, fountain and entry 4 % are
/// left then, of sites with few points a third.
const UNEXPLAINED: f64 = 0.1;

/// Returns the distance within which a point lies on a plane. Between 0.15 and 0.8 % of the distance, one facade became a dozen
/// planes.
pub fn tolerance(point: &NormalisedPoint) -> f64 {
    (2.0 * point.sigma).clamp(0.005 * point.away, 0.012 * point.away)
}

/// Returns whether a point lies on a plane and is seen from its front.
pub fn is_on(point: &NormalisedPoint, plane: &Plane) -> bool {
    plane.signed_distance(point.at).abs() < tolerance(point) && plane.signed_distance(point.eye) > 0.0
}

/// A search for planes.
pub struct PlaneSearch<'a> {
    points: &'a [NormalisedPoint],
    /// The direction upwards, where it is known.
    up: Option<DVec3>,
    rng: Rng,
    is_free: Vec<bool>,
    /// Planes that many points lie on by chance, in no island that is large enough, and that are not tried again.
    failed: Vec<Plane>,
    /// Whether the search goes on beside these.
    persists: bool,
    /// The side of the cells in which points are sought: larger where points are few.
    cell: f64,
    grid: FxHashMap<[i32; 3], Vec<u32>>,
}

impl<'a> PlaneSearch<'a> {
    /// Prepares a search; without a direction upwards, planes of any direction are alike.
    pub fn new(points: &'a [NormalisedPoint], up: Option<DVec3>, seed: u64) -> Self {
        let cell = ISLAND_CELL.max(0.5 * spacing(points));
        let mut grid: FxHashMap<[i32; 3], Vec<u32>> = FxHashMap::default();
        for (i, point) in (0..).zip(points) {
            grid.entry(grid_cell(point.at, cell)).or_default().push(i);
        }
        Self {
            points,
            up,
            rng: Rng::new(seed),
            is_free: vec![true; points.len()],
            failed: Vec::new(),
            persists: true,
            cell,
            grid,
        }
    }

    /// Ends the search at chance planes even while many points lie on none, where planes have to be clear.
    pub fn ending_at_chance(self) -> Self {
        Self { persists: false, ..self }
    }

    /// Points that lie on no plane so far.
    pub fn free(&self) -> Vec<u32> {
        (0..self.points.len() as u32).filter(|i| self.is_free[*i as usize]).collect()
    }

    /// Takes points out of the search.
    pub fn take(&mut self, points: &[u32]) {
        points.iter().for_each(|i| self.is_free[*i as usize] = false);
    }

    /// Finds planes, at most so many.
    pub fn planes(&mut self, most: usize) -> Vec<PlaneOfPoints> {
        let mut found = Vec::new();
        let mut failures = 0;
        while found.len() < most && failures < FAILURES {
            let free = self.free();
            if free.len() < FEWEST {
                break;
            }
            let Some(best) = self.best(&free) else { break };
            match self.grown(&free, best) {
                Some(plane) => {
                    self.take(&plane.members);
                    found.push(plane);
                }
                None => {
                    failures += 1;
                    // What is left of a site that is nearly explained is noise, and other planes in it are chance, too.
                    if self.persists && free.len() as f64 > UNEXPLAINED * self.points.len() as f64 {
                        self.failed.push(best);
                    }
                }
            }
        }
        found
    }

    /// Returns the trial with most points.
    fn best(&mut self, free: &[u32]) -> Option<Plane> {
        let mut trials: Vec<Plane> = (0..TRIALS).filter_map(|_| self.trial(free)).collect();
        // Of chance planes the same would be the best again.
        trials.retain(|trial| !self.failed.iter().any(|failed| is_twin(trial, failed)));
        let step = free.len().div_ceil(JUDGES).max(1);
        let judges: Vec<&NormalisedPoint> =
            free.iter().step_by(step).map(|i| &self.points[*i as usize]).collect();
        let count = |plane: &Plane| judges.iter().filter(|point| is_on(point, plane)).count();
        let counts: Vec<usize> = trials.par_iter().map(count).collect();
        // Of equal ones the first, whatever the number of threads.
        let (best, _) = counts.iter().enumerate().max_by_key(|(i, count)| (**count, usize::MAX - *i))?;
        Some(trials[best])
    }

    fn trial(&mut self, free: &[u32]) -> Option<Plane> {
        let first = free[self.rng.whole(0, free.len() as u32 - 1) as usize];
        let seed = &self.points[first as usize];
        let share = self.rng.unit();
        let near = self.near(first);
        let mut other = || {
            let any = near.len().checked_sub(1)?;
            Some(self.points[near[self.rng.whole(0, any as u32) as usize] as usize].at - seed.at)
        };
        let across = match self.up {
            Some(up) if share < 0.6 => other()?.cross(up),
            Some(up) if share >= 0.9 => up,
            _ => other()?.cross(other()?),
        };
        let plane = Plane { normal: across.try_normalize()?, point: seed.at };
        let plane = facing(plane, seed.eye);
        // Rows of window sills make false ceilings.
        let is_ceiling = self.up.is_some_and(|up| plane.normal.dot(up) < -LEVEL);
        (!is_ceiling).then_some(plane)
    }

    /// Returns the free points that are nearest to one.
    fn near(&self, of: u32) -> Vec<u32> {
        let at = self.points[of as usize].at;
        let [x, y, z] = grid_cell(at, self.cell);
        let mut found: Vec<u32> = Vec::new();
        for reach in 1..4 {
            let range = -reach..=reach;
            let cells = range.clone().flat_map(|i| {
                let range = range.clone();
                range.clone().flat_map(move |j| range.clone().map(move |k| [x + i, y + j, z + k]))
            });
            found = cells.filter_map(|cell| self.grid.get(&cell)).flatten().copied().collect();
            found.retain(|i| *i != of && self.is_free[*i as usize]);
            if found.len() >= NEAR {
                break;
            }
        }
        if found.len() > NEAR {
            let away = |i: &u32| self.points[*i as usize].at.distance_squared(at);
            found.select_nth_unstable_by(NEAR, |a, b| away(a).total_cmp(&away(b)).then(a.cmp(b)));
            found.truncate(NEAR);
            found.sort_unstable();
        }
        found
    }

    /// Fits a plane to its points, and keeps the islands that are large enough.
    fn grown(&self, free: &[u32], seed: Plane) -> Option<PlaneOfPoints> {
        let on = |plane: &Plane| -> Vec<u32> {
            free.iter().copied().filter(|i| is_on(&self.points[*i as usize], plane)).collect()
        };
        let mut plane = seed;
        for _ in 0..2 {
            plane = fitted(self.points, &on(&plane), self.up)?.0;
        }
        let members = large_islands(self.points, &plane, &on(&plane), self.cell);
        let (plane, kind) = fitted(self.points, &members, self.up)?;
        let is_ceiling = self.up.is_some_and(|up| plane.normal.dot(up) < -LEVEL);
        (members.len() >= FEWEST && !is_ceiling).then_some(PlaneOfPoints {
            plane,
            kind,
            members,
            places: Vec::new(),
        })
    }
}

/// Returns whether two trials are one plane within what a trial is off: 6 degrees, and 2 % of the median distance of points.
fn is_twin(trial: &Plane, failed: &Plane) -> bool {
    const SAME_DIRECTION: f64 = 0.9945;
    const SAME_PLACE: f64 = 0.02;
    let off = failed.signed_distance(trial.point).abs();
    trial.normal.dot(failed.normal) > SAME_DIRECTION && off < SAME_PLACE
}

/// Turns a plane's normal to a side.
pub fn facing(plane: Plane, eye: DVec3) -> Plane {
    if plane.signed_distance(eye) < 0.0 { Plane { normal: -plane.normal, ..plane } } else { plane }
}

fn grid_cell(at: DVec3, cell: f64) -> [i32; 3] {
    (at / cell).floor().to_array().map(|x| x as i32)
}

/// Returns the median distance from a point to its sixth neighbour, of some points.
fn spacing(points: &[NormalisedPoint]) -> f64 {
    let of = points.iter().step_by(points.len().div_ceil(300).max(1));
    let sixth = |point: &NormalisedPoint| {
        let mut away: Vec<f64> = points.iter().map(|other| other.at.distance(point.at)).collect();
        of_rank(&mut away, 6)
    };
    upper_median(&mut of.filter_map(sixth).collect::<Vec<_>>()).unwrap_or(0.0)
}

/// Fits a plane to points, each by the inverse of its tolerance; what is nearly plumb or level becomes so. `None` for fewer than
/// three points.
pub fn fitted(points: &[NormalisedPoint], members: &[u32], up: Option<DVec3>) -> Option<(Plane, PlaneKind)> {
    let of = || members.iter().map(|i| &points[*i as usize]);
    let weight = |point: &NormalisedPoint| tolerance(point).powi(-2);
    let total: f64 = of().map(weight).sum();
    if members.len() < 3 || total <= 0.0 {
        return None;
    }
    let middle = of().map(|point| point.at * weight(point)).sum::<DVec3>() / total;
    let eye = of().map(|point| point.eye).sum::<DVec3>() / members.len() as f64;
    let least = |across: Option<DVec3>| {
        let mut sums = [[0.0; 3]; 3];
        for point in of() {
            let mut off = point.at - middle;
            if let Some(up) = across {
                off -= up * off.dot(up);
            }
            let off = off.to_array();
            for i in 0..3 {
                for j in 0..3 {
                    sums[i][j] += weight(point) * off[i] * off[j];
                }
            }
        }
        let vectors = eigen(sums).map(|(_, vector)| DVec3::from_array(vector));
        // Where all is projected along up, up itself is the first.
        let is_up = |v: &DVec3| across.is_some_and(|up| v.dot(up).abs() > 0.9);
        vectors.into_iter().find(|v| !is_up(v)).unwrap_or(DVec3::X)
    };
    let normal = least(None);
    let Some(up) = up else {
        return Some((facing(Plane { normal, point: middle }, eye), PlaneKind::Sloped));
    };
    let (normal, kind) = match normal.dot(up).abs() {
        rise if rise < PLUMB => (least(Some(up)), PlaneKind::Plumb),
        rise if rise > LEVEL => (up, PlaneKind::Level),
        _ => (normal, PlaneKind::Sloped),
    };
    Some((facing(Plane { normal, point: middle }, eye), kind))
}

/// Returns the points of the islands of a plane that are large enough to be no chance.
fn large_islands(points: &[NormalisedPoint], plane: &Plane, members: &[u32], cell: f64) -> Vec<u32> {
    let frame = PlaneFrame::from_plane(plane);
    let mut cells: BTreeMap<(i32, i32), Vec<u32>> = BTreeMap::new();
    for i in members {
        let at = (frame.flat(points[*i as usize].at) / cell).floor();
        cells.entry((at.x as i32, at.y as i32)).or_default().push(*i);
    }
    let least = (0.03 * members.len() as f64).max(8.0) as usize;
    let mut kept = Vec::new();
    while let Some((first, own)) = cells.pop_first() {
        let (mut island, mut open) = (own, vec![first]);
        while let Some((x, y)) = open.pop() {
            for (i, j) in (-2..=2).flat_map(|i| (-2..=2).map(move |j| (i, j))) {
                if let Some(more) = cells.remove(&(x + i, y + j)) {
                    island.extend(more);
                    open.push((x + i, y + j));
                }
            }
        }
        if island.len() >= least {
            kept.extend(island);
        }
    }
    kept.sort_unstable();
    kept
}

/// Joins planes that are one within the noise, larger ones first.
pub fn merged(points: &[NormalisedPoint], mut planes: Vec<PlaneOfPoints>, up: DVec3) -> Vec<PlaneOfPoints> {
    planes.sort_by_key(|plane| std::cmp::Reverse(plane.members.len()));
    let mut kept: Vec<PlaneOfPoints> = Vec::new();
    for plane in planes {
        match kept.iter_mut().find(|large| is_same(points, large, &plane)) {
            Some(large) => {
                large.members.extend(&plane.members);
                large.members.sort_unstable();
                if let Some((plane, kind)) = fitted(points, &large.members, Some(up)) {
                    (large.plane, large.kind) = (plane, kind);
                }
            }
            None => kept.push(plane),
        }
    }
    kept
}

/// Fewer points than these give a direction that may be 12 degrees off.
const SMALL: usize = 60;

fn is_same(points: &[NormalisedPoint], large: &PlaneOfPoints, small: &PlaneOfPoints) -> bool {
    // The cosines of 12 and of 5 degrees.
    let least = if small.members.len() < SMALL { 0.978 } else { 0.9962 };
    let mut off: Vec<f64> = small
        .members
        .iter()
        .map(|i| &points[*i as usize])
        .map(|point| large.plane.signed_distance(point.at).abs() / point.away)
        .collect();
    large.plane.normal.dot(small.plane.normal) > least
        && upper_median(&mut off).is_some_and(|off| off < 0.013)
}
