//! Outlines of masks: the edges of cells, simplified (Douglas and Peucker 1973), with bridged holes.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use quadratura_base::geometry::polygon::bridge_holes;

use super::chart::{PlaneChart, regions};

/// How far an outline may leave the cells' edges, in cells.
pub const SLACK: f64 = 2.5;

/// The same as a share of the side of a square of the region's area, where that is more: nobody drags a thousand corners of a
/// court's ground.
pub const SLACK_OF_SIDE: f64 = 0.01;

/// The smallest area of an outline or of a hole, in cells.
const LEAST_AREA: f64 = 60.0;

/// An outline with its holes, in cells: counter-clockwise, the holes clockwise.
#[derive(Debug, Clone)]
pub struct CellOutline {
    /// The outer ring.
    pub outer: Vec<DVec2>,
    /// The holes.
    pub holes: Vec<Vec<DVec2>>,
}

/// Returns the outlines of a mask's regions, simplified by `slack_of_side` of a region's size at most.
pub fn outlines(mask: &[bool], size: [usize; 2], slack_of_side: f64) -> Vec<CellOutline> {
    let (number, sizes) = regions(mask, size);
    let mut found = Vec::new();
    for region in 0..sizes.len() as u32 {
        let first = number.iter().position(|own| *own == region);
        if !first.is_some_and(|at| mask[at]) || (sizes[region as usize] as f64) < LEAST_AREA {
            continue;
        }
        let slack = SLACK.max(slack_of_side * (sizes[region as usize] as f64).sqrt());
        let mut rings: Vec<Vec<DVec2>> = walked(&number, region, size)
            .iter()
            .map(|ring| simplified(ring, slack))
            .filter(|ring| ring.len() > 2)
            .collect();
        rings.sort_by(|a, b| area(b).total_cmp(&area(a)));
        let mut rings = rings.into_iter().filter(|ring| area(ring).abs() >= LEAST_AREA);
        if let Some(outer) = rings.next().filter(|outer| area(outer) > 0.0) {
            found.push(CellOutline { outer, holes: rings.filter(|ring| area(ring) < 0.0).collect() });
        }
    }
    found
}

impl CellOutline {
    /// Returns the rings of the outline on its plane, with bridged holes, wound counter-clockwise seen from the front.
    pub fn rings(&self, chart: &PlaneChart) -> Vec<Vec<DVec3>> {
        let raised = |ring: &Vec<DVec2>| ring.iter().map(|at| chart.point(*at)).collect::<Vec<DVec3>>();
        bridge_holes(&raised(&self.outer), &self.holes.iter().map(raised).collect::<Vec<_>>())
    }
}

/// Returns the signed area of a ring, positive when it runs counter-clockwise.
pub fn area(ring: &[DVec2]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>() / 2.0
}

/// Walks around a region along the edges of its cells, which are on the left.
fn walked(number: &[u32], region: u32, [columns, rows]: [usize; 2]) -> Vec<Vec<DVec2>> {
    let is_in = |x: i64, y: i64| {
        x >= 0
            && y >= 0
            && (x as usize) < columns
            && (y as usize) < rows
            && number[y as usize * columns + x as usize] == region
    };
    // Each edge by where it begins.
    let mut edges: BTreeMap<(i64, i64), Vec<(i64, i64)>> = BTreeMap::new();
    for at in (0..number.len()).filter(|at| number[*at] == region) {
        let (x, y) = ((at % columns) as i64, (at / columns) as i64);
        let sides = [
            ((x, y - 1), (x, y), (x + 1, y)),
            ((x + 1, y), (x + 1, y), (x + 1, y + 1)),
            ((x, y + 1), (x + 1, y + 1), (x, y + 1)),
            ((x - 1, y), (x, y + 1), (x, y)),
        ];
        for ((i, j), from, to) in sides {
            if !is_in(i, j) {
                edges.entry(from).or_default().push(to);
            }
        }
    }
    let mut rings = Vec::new();
    while let Some((&start, _)) = edges.first_key_value() {
        let (mut ring, mut at, mut heading) = (Vec::new(), start, None);
        while let Some(ways) = edges.get_mut(&at) {
            // Where two corners of the region touch, the walk turns left, so that they stay apart.
            let turn = |to: &(i64, i64)| {
                let ahead = DVec2::new((to.0 - at.0) as f64, (to.1 - at.1) as f64);
                heading.map_or(0.0, |heading: DVec2| heading.perp_dot(ahead))
            };
            let best =
                (0..ways.len()).max_by(|a, b| turn(&ways[*a]).total_cmp(&turn(&ways[*b]))).unwrap_or(0);
            let to = ways.swap_remove(best);
            if ways.is_empty() {
                edges.remove(&at);
            }
            ring.push(DVec2::new(at.0 as f64, at.1 as f64));
            heading = Some(DVec2::new((to.0 - at.0) as f64, (to.1 - at.1) as f64));
            at = to;
        }
        rings.push(ring);
    }
    rings
}

/// Simplifies a closed ring within `slack` cells, from the two points that are farthest apart.
fn simplified(ring: &[DVec2], slack: f64) -> Vec<DVec2> {
    if ring.len() < 4 {
        return ring.to_vec();
    }
    let farthest = |from: DVec2| {
        let away = |i: &usize| ring[*i].distance_squared(from);
        (0..ring.len()).max_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(0)
    };
    let a = farthest(ring[0]);
    let b = farthest(ring[a]);
    let (a, b) = (a.min(b), a.max(b));
    let second: Vec<DVec2> = ring[b..].iter().chain(&ring[..=a]).copied().collect();
    let mut kept = Vec::new();
    keep(&ring[a..=b], slack, &mut kept);
    keep(&second, slack, &mut kept);
    kept
}

/// Keeps the corners of a chain, but for its last.
fn keep(chain: &[DVec2], slack: f64, kept: &mut Vec<DVec2>) {
    let (Some(&first), Some(&last)) = (chain.first(), chain.last()) else { return };
    let along = (last - first).normalize_or_zero();
    let off = |point: &DVec2| match along {
        DVec2::ZERO => point.distance(first),
        along => along.perp_dot(*point - first).abs(),
    };
    let inner = 1..chain.len().max(2) - 1;
    match inner.max_by(|a, b| off(&chain[*a]).total_cmp(&off(&chain[*b]))) {
        Some(corner) if off(&chain[corner]) > slack => {
            keep(&chain[..=corner], slack, kept);
            keep(&chain[corner..], slack, kept);
        }
        _ => kept.push(first),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(rows: &[&str], scale: usize) -> (Vec<bool>, [usize; 2]) {
        let size = [rows[0].len() * scale, rows.len() * scale];
        let cell = |at: usize| rows[at / size[0] / scale].as_bytes()[at % size[0] / scale] == b'#';
        ((0..size[0] * size[1]).map(cell).collect(), size)
    }

    #[test]
    fn a_rectangle_with_a_window_has_four_corners_and_a_hole_of_four() {
        let (mask, size) = mask(&["......", ".####.", ".#..#.", ".####.", "......"], 10);
        let found = outlines(&mask, size, SLACK_OF_SIDE);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].outer.len(), found[0].holes.len(), found[0].holes[0].len()), (4, 1, 4));
        assert_eq!((area(&found[0].outer), area(&found[0].holes[0])), (1200.0, -200.0));
    }

    #[test]
    fn regions_that_touch_at_a_corner_stay_apart() {
        let (mask, size) = mask(&["#.", ".#"], 10);
        let found = outlines(&mask, size, SLACK_OF_SIDE);
        assert_eq!(found.iter().map(|found| area(&found.outer)).collect::<Vec<_>>(), [100.0, 100.0]);
    }
}
