//! Edges of outlines are laid onto lines where other planes cut theirs, and turned plumb, level or parallel to these where they nearly
//! are: neighbouring faces then meet without cracks, and are easy to drag.

use glam::DVec2;

use super::chart::PlaneChart;
use super::outline::{CellOutline, SLACK, area};
use super::planes::PlaneOfPoints;

/// Shorter edges stay as they are, in cells: their direction is chance.
const SHORTEST: f64 = 8.0;
/// The sine of the angle to a line within which an edge is laid onto it, 12 degrees, and of that to a direction, 9 degrees.
const SINE_OF_LINE: f64 = 0.208;
const SINE_OF_DIRECTION: f64 = 0.156;
/// How far the middle of an edge may be from the line, in cells: an outline is off by its slack on either side of a crack.
const REACH: f64 = 2.2 * SLACK;
/// The sine of the least angle at which two edges meet in a corner, 15 degrees.
const SINE_OF_CORNER: f64 = 0.26;
/// How far a corner may move, in cells.
const FARTHEST: f64 = 3.0 * SLACK;
/// A corner that is off the line of its neighbours by less is none, in cells.
const STRAIGHT: f64 = 0.7;

/// A line in cells, with a unit direction.
#[derive(Debug, Clone, Copy)]
pub struct CellLine {
    at: DVec2,
    along: DVec2,
}

impl CellLine {
    fn through(from: DVec2, to: DVec2) -> Self {
        Self { at: 0.5 * (from + to), along: (to - from).normalize_or_zero() }
    }

    fn nearest(&self, to: DVec2) -> DVec2 {
        self.at + self.along * self.along.dot(to - self.at)
    }

    fn crossing(&self, other: &Self) -> Option<DVec2> {
        let sine = self.along.perp_dot(other.along);
        (sine.abs() > SINE_OF_CORNER)
            .then(|| self.at + self.along * ((other.at - self.at).perp_dot(other.along) / sine))
    }
}

/// What the edges of a plane's faces are laid along.
#[derive(Debug, Default)]
pub struct Guides {
    lines: Vec<CellLine>,
    directions: Vec<DVec2>,
}

impl Guides {
    /// Collects the lines where other planes cut a plane, and its plumb and level directions; of a level plane those lines and what is
    /// at right angles to them.
    pub fn new(number: usize, planes: &[PlaneOfPoints], chart: &PlaneChart) -> Self {
        let own = planes[number].plane.normal;
        let line = |other: &PlaneOfPoints| {
            let along = own.cross(other.plane.normal).try_normalize()?;
            // Nearly parallel planes cut each other anywhere.
            let across = own.cross(along);
            let slope = across.dot(other.plane.normal);
            if slope.abs() < SINE_OF_CORNER {
                return None;
            }
            let origin = chart.middle(0);
            let point = origin - across * (other.plane.signed_distance(origin) / slope);
            let [from, to] = [point, point + along * chart.cell].map(|at| chart.place(at));
            Some(CellLine::through(from, to))
        };
        let others = planes.iter().enumerate().filter(|(other, _)| *other != number);
        let lines: Vec<CellLine> = others.filter_map(|(_, other)| line(other)).collect();
        let directions = match chart.rises {
            true => vec![DVec2::X, DVec2::Y],
            false => lines.iter().flat_map(|line| [line.along, line.along.perp()]).collect(),
        };
        Self { lines, directions }
    }

    /// Returns the line that an edge is laid on.
    fn line(&self, from: DVec2, to: DVec2) -> CellLine {
        let own = CellLine::through(from, to);
        if from.distance(to) < SHORTEST {
            return own;
        }
        let off = |line: &CellLine| line.nearest(own.at).distance(own.at);
        let is_near =
            |line: &&CellLine| own.along.perp_dot(line.along).abs() < SINE_OF_LINE && off(line) < REACH;
        let along = |line: &CellLine| line.along * own.along.dot(line.along).signum();
        if let Some(line) = self.lines.iter().filter(is_near).min_by(|a, b| off(a).total_cmp(&off(b))) {
            return CellLine { at: line.nearest(own.at), along: along(line) };
        }
        let sine = |direction: &DVec2| own.along.perp_dot(*direction).abs();
        let nearest = self.directions.iter().min_by(|a, b| sine(a).total_cmp(&sine(b)));
        match nearest.filter(|direction| sine(direction) < SINE_OF_DIRECTION) {
            Some(direction) => {
                CellLine { at: own.at, along: *direction * own.along.dot(*direction).signum() }
            }
            None => own,
        }
    }

    /// Returns an outline whose edges lie along the guides; a ring that would cross itself stays as it is.
    pub fn snapped(&self, outline: &CellOutline) -> CellOutline {
        let ring = |ring: &Vec<DVec2>| self.snapped_ring(ring).unwrap_or_else(|| ring.clone());
        let snapped =
            CellOutline { outer: ring(&outline.outer), holes: outline.holes.iter().map(ring).collect() };
        // A hole may not reach the edge.
        let apart = |hole: &Vec<DVec2>| !rings_cross(&snapped.outer, hole);
        if snapped.holes.iter().all(apart) { snapped } else { outline.clone() }
    }

    fn snapped_ring(&self, ring: &[DVec2]) -> Option<Vec<DVec2>> {
        let count = ring.len();
        let lines: Vec<CellLine> = (0..count).map(|i| self.line(ring[i], ring[(i + 1) % count])).collect();
        let mut corners = Vec::with_capacity(count);
        for (i, corner) in ring.iter().enumerate() {
            let (before, after) = (&lines[(i + count - 1) % count], &lines[i]);
            match before.crossing(after).filter(|at| at.distance(*corner) < FARTHEST) {
                Some(at) => corners.push(at),
                None => {
                    let ends = [before.nearest(*corner), after.nearest(*corner)];
                    if ends[0].distance(ends[1]) < STRAIGHT {
                        corners.push(0.5 * (ends[0] + ends[1]));
                    } else {
                        corners.extend(ends);
                    }
                }
            }
        }
        let corners = without_straight(corners);
        let keeps = corners.len() > 2 && area(&corners) * area(ring) > 0.0 && !crosses_itself(&corners);
        keeps.then_some(corners)
    }
}

/// Removes corners on the line of their neighbours.
fn without_straight(mut ring: Vec<DVec2>) -> Vec<DVec2> {
    let mut at = 0;
    while at < ring.len() && ring.len() > 3 {
        let (before, after) = (ring[(at + ring.len() - 1) % ring.len()], ring[(at + 1) % ring.len()]);
        let off = match (after - before).try_normalize() {
            Some(along) => along.perp_dot(ring[at] - before).abs(),
            None => 0.0,
        };
        if off < STRAIGHT {
            ring.remove(at);
        } else {
            at += 1;
        }
    }
    ring
}

fn edges(ring: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> + Clone + '_ {
    ring.iter().copied().zip(ring.iter().copied().cycle().skip(1))
}

fn cross((a, b): (DVec2, DVec2), (c, d): (DVec2, DVec2)) -> bool {
    let side = |from: DVec2, to: DVec2, at: DVec2| (to - from).perp_dot(at - from);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

fn crosses_itself(ring: &[DVec2]) -> bool {
    edges(ring).enumerate().any(|(i, one)| edges(ring).skip(i + 1).any(|other| cross(one, other)))
}

fn rings_cross(one: &[DVec2], other: &[DVec2]) -> bool {
    edges(one).any(|edge| edges(other).any(|own| cross(edge, own)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guides(lines: &[[(f64, f64); 2]]) -> Guides {
        let at = |(x, y): (f64, f64)| DVec2::new(x, y);
        let lines = lines.iter().map(|[from, to]| CellLine::through(at(*from), at(*to))).collect();
        Guides { lines, directions: vec![DVec2::X, DVec2::Y] }
    }

    fn outline(corners: &[(f64, f64)]) -> CellOutline {
        CellOutline { outer: corners.iter().map(|(x, y)| DVec2::new(*x, *y)).collect(), holes: Vec::new() }
    }

    #[test]
    fn edges_are_laid_on_crossings_and_turned_plumb_and_level() {
        let ragged = outline(&[(1.0, 0.0), (40.0, 2.0), (41.0, 30.0), (20.0, 31.0), (0.0, 29.0)]);
        let snapped = guides(&[[(44.0, 0.0), (44.0, 9.0)]]).snapped(&ragged).outer;
        assert_eq!(snapped.len(), 4, "{snapped:?}");
        assert!(
            snapped[1].x == 44.0 && snapped[2].x == 44.0,
            "the right edge is on the crossing: {snapped:?}"
        );
        let is_axis = |(a, b): (DVec2, DVec2)| (b - a).abs().min_element() < 1.1;
        assert!(edges(&snapped).all(is_axis), "{snapped:?}");
    }

    #[test]
    fn corners_on_one_line_are_joined_and_far_lines_are_left_alone() {
        let ragged = outline(&[(0.0, 0.0), (20.0, 1.0), (40.0, 0.0), (40.0, 30.0), (0.0, 30.0)]);
        let snapped = guides(&[[(0.0, 0.0), (9.0, 0.0)], [(60.0, 0.0), (60.0, 9.0)]]).snapped(&ragged).outer;
        let expected = [(0.0, 0.0), (40.0, 0.0), (40.0, 30.0), (0.0, 30.0)].map(|(x, y)| DVec2::new(x, y));
        assert!(
            snapped.len() == 4 && expected.iter().all(|it| snapped.iter().any(|at| at.distance(*it) < 1e-9)),
            "{snapped:?}"
        );
    }

    #[test]
    fn an_outline_never_crosses_itself() {
        let thin = outline(&[(0.0, 0.0), (40.0, 0.0), (40.0, 3.0), (0.0, 3.0)]);
        // Both long edges would be laid on one line.
        let snapped = guides(&[[(0.0, 1.5), (9.0, 1.5)]]).snapped(&thin).outer;
        assert_eq!(area(&snapped), 120.0, "{snapped:?}");
    }
}
