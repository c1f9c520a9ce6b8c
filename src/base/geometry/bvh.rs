//! A bounding volume hierarchy over triangles: nearest point, ray casts, overlapping pairs.

use std::ops::ControlFlow;

use glam::DVec3;

use super::triangle::{Triangle, nearest_point, ray_hit};

/// A bounding volume hierarchy: a binary tree of axis-aligned boxes over triangles.
#[derive(Debug)]
pub struct Bvh {
    triangles: Vec<Triangle>,
    /// The nodes in depth-first order: an inner node's first child follows it.
    nodes: Vec<BvhNode>,
    /// Triangle indices, grouped by leaf.
    order: Vec<u32>,
}

/// A box of the tree, either a leaf with triangles or an inner node with two children.
#[derive(Debug, Clone, Copy)]
struct BvhNode {
    low: DVec3,
    high: DVec3,
    /// A leaf: the index of its first entry in `order`. An inner node: the index of its second child.
    start: u32,
    /// The number of triangles of a leaf; 0 for an inner node.
    count: u32,
}

/// The most triangles that a leaf holds.
const LEAF: usize = 4;

impl Bvh {
    /// Builds the tree. All coordinates have to be finite.
    pub fn new(triangles: Vec<Triangle>) -> Self {
        let mut tree = Self { order: (0..triangles.len() as u32).collect(), nodes: Vec::new(), triangles };
        if !tree.triangles.is_empty() {
            tree.split(0, tree.order.len());
        }
        tree
    }

    /// Returns the triangles in the order in which they were given.
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// Appends the subtree over `order[start..end]`, halved at the median along the longest side of its box.
    fn split(&mut self, start: usize, end: usize) {
        let (low, high) = self.bounds(start, end);
        let node = self.nodes.len();
        self.nodes.push(BvhNode { low, high, start: start as u32, count: (end - start) as u32 });
        if end - start <= LEAF {
            return;
        }
        let axis = (high - low).max_position();
        let triangles = &self.triangles;
        let centre = |&t: &u32| triangles[t as usize].iter().map(|p| p[axis]).sum::<f64>();
        let middle = (end - start) / 2;
        self.order[start..end]
            .select_nth_unstable_by(middle, |a, b| centre(a).total_cmp(&centre(b)).then(a.cmp(b)));
        self.split(start, start + middle);
        self.nodes[node].start = self.nodes.len() as u32;
        self.nodes[node].count = 0;
        self.split(start + middle, end);
    }

    fn bounds(&self, start: usize, end: usize) -> (DVec3, DVec3) {
        let corners = self.order[start..end].iter().flat_map(|&t| self.triangles[t as usize]);
        corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
    }

    fn leaf(&self, node: &BvhNode) -> &[u32] {
        &self.order[node.start as usize..(node.start + node.count) as usize]
    }

    /// Returns the index of the triangle nearest to `point`, and the nearest point on it; `None` for an empty tree.
    pub fn nearest(&self, point: DVec3) -> Option<(u32, DVec3)> {
        let mut best = None;
        let mut best_squared = f64::INFINITY;
        let mut open = Vec::with_capacity(64);
        open.extend((!self.nodes.is_empty()).then_some((0u32, 0.0)));
        while let Some((at, squared)) = open.pop() {
            if squared >= best_squared {
                continue;
            }
            let node = &self.nodes[at as usize];
            for &triangle in if node.count > 0 { self.leaf(node) } else { &[] } {
                let candidate = nearest_point(point, &self.triangles[triangle as usize]);
                let squared = candidate.distance_squared(point);
                if squared < best_squared {
                    (best, best_squared) = (Some((triangle, candidate)), squared);
                }
            }
            if node.count == 0 {
                let mut children =
                    [at + 1, node.start].map(|c| (c, self.nodes[c as usize].distance_squared(point)));
                // The child pushed last, the nearer one, is visited first.
                children.sort_by(|a, b| b.1.total_cmp(&a.1));
                open.extend(children);
            }
        }
        best
    }

    /// Returns t and the index of the first triangle that the ray `origin + t direction` hits for 0 < t < `limit`.
    pub fn first_hit(&self, origin: DVec3, direction: DVec3, limit: f64) -> Option<(f64, u32)> {
        let inverse = direction.recip();
        let mut best: Option<(f64, u32)> = None;
        let mut open = NodeStack::new((!self.nodes.is_empty()).then_some((0u32, 0.0)));
        while let Some((at, enters)) = open.pop() {
            let reach = best.map_or(limit, |(t, _)| t);
            if enters >= reach {
                continue;
            }
            let node = &self.nodes[at as usize];
            for &triangle in if node.count > 0 { self.leaf(node) } else { &[] } {
                let hit = ray_hit(origin, direction, &self.triangles[triangle as usize]);
                if let Some(t) = hit.filter(|&t| t < best.map_or(limit, |(t, _)| t)) {
                    best = Some((t, triangle));
                }
            }
            if node.count == 0 {
                let enter = |child: u32| {
                    self.nodes[child as usize].entered(origin, inverse, reach).map(|t| (child, t))
                };
                match (enter(at + 1), enter(node.start)) {
                    // The nearer child is visited first; of two at equal distance, the second one.
                    (Some(first), Some(second)) if first.1 < second.1 => open.push_both(second, first),
                    (Some(first), Some(second)) => open.push_both(first, second),
                    (child, None) | (None, child) => child.into_iter().for_each(|child| open.push(child)),
                }
            }
        }
        best
    }

    /// Calls `visit` with t and the triangle's index for each hit of the ray `origin + t direction` with 0 < t <=
    /// `limit`, in no particular order.
    pub fn each_hit(&self, origin: DVec3, direction: DVec3, limit: f64, mut visit: impl FnMut(f64, u32)) {
        let inverse = direction.recip();
        let mut open = Vec::with_capacity(64);
        open.extend((!self.nodes.is_empty()).then_some(0u32));
        while let Some(at) = open.pop() {
            let node = &self.nodes[at as usize];
            if node.entered(origin, inverse, limit).is_none() {
                continue;
            }
            if node.count == 0 {
                open.extend([at + 1, node.start]);
            }
            for &triangle in if node.count > 0 { self.leaf(node) } else { &[] } {
                let hit = ray_hit(origin, direction, &self.triangles[triangle as usize]);
                if let Some(t) = hit.filter(|t| *t <= limit) {
                    visit(t, triangle);
                }
            }
        }
    }

    /// Calls `visit` for each pair of triangles whose leaves' boxes overlap, until it breaks.
    ///
    /// # Errors
    /// Returns the `Break` of `visit`, if any.
    pub fn overlapping_pairs(&self, mut visit: impl FnMut(u32, u32) -> ControlFlow<()>) -> ControlFlow<()> {
        let mut open = Vec::new();
        open.extend((!self.nodes.is_empty()).then_some((0u32, 0u32)));
        while let Some((a, b)) = open.pop() {
            let (node_a, node_b) = (&self.nodes[a as usize], &self.nodes[b as usize]);
            if a != b && !node_a.overlaps(node_b) {
                continue;
            }
            match (node_a.count > 0, node_b.count > 0) {
                (true, true) => self.leaf_pairs(node_a, node_b, a == b, &mut visit)?,
                (false, _) if a == b => {
                    let (left, right) = (a + 1, node_a.start);
                    open.extend([(left, left), (right, right), (left, right)]);
                }
                (false, _) => open.extend([(a + 1, b), (node_a.start, b)]),
                (true, false) => open.extend([(a, b + 1), (a, node_b.start)]),
            }
        }
        ControlFlow::Continue(())
    }

    /// Calls `visit` for each pair of triangles of two leaves, or of one leaf with itself.
    fn leaf_pairs(
        &self,
        a: &BvhNode,
        b: &BvhNode,
        same: bool,
        visit: &mut impl FnMut(u32, u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        for (i, &first) in self.leaf(a).iter().enumerate() {
            for &second in &self.leaf(b)[if same { i + 1 } else { 0 }..] {
                visit(first, second)?;
            }
        }
        ControlFlow::Continue(())
    }
}

/// A stack of nodes to visit, each with the t at which the ray enters it. It holds at most one node per level of
/// the tree and one more; a tree made by halving has no more levels than the number of triangles has bits.
struct NodeStack {
    nodes: [(u32, f64); 34],
    count: usize,
}

impl NodeStack {
    fn new(first: Option<(u32, f64)>) -> Self {
        Self { nodes: [first.unwrap_or_default(); 34], count: usize::from(first.is_some()) }
    }

    fn push(&mut self, node: (u32, f64)) {
        self.nodes[self.count] = node;
        self.count += 1;
    }

    fn push_both(&mut self, later: (u32, f64), sooner: (u32, f64)) {
        self.push(later);
        self.push(sooner);
    }

    fn pop(&mut self) -> Option<(u32, f64)> {
        self.count = self.count.checked_sub(1)?;
        Some(self.nodes[self.count])
    }
}

impl BvhNode {
    /// Returns the squared distance from `point` to the box, 0 inside.
    fn distance_squared(&self, point: DVec3) -> f64 {
        point.clamp(self.low, self.high).distance_squared(point)
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    /// Returns the t at which the ray enters the box, if that is before `limit`.
    fn entered(&self, origin: DVec3, inverse: DVec3, limit: f64) -> Option<f64> {
        let (mut enter, mut leave) = (0.0f64, limit);
        for axis in 0..3 {
            let near = (self.low[axis] - origin[axis]) * inverse[axis];
            let far = (self.high[axis] - origin[axis]) * inverse[axis];
            // A ray within a side's plane gives 0 x infinity = NaN, which f64's min and max ignore.
            enter = enter.max(near.min(far));
            leave = leave.min(near.max(far));
        }
        // Widened by a rounding error, so that flat boxes are not missed.
        (enter <= leave * (1.0 + 1e-12)).then_some(enter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::triangle::crossing_depth;

    /// Triangles scattered by a fixed rule.
    fn scattered(count: u32) -> Vec<Triangle> {
        let wave = |k: u32| f64::from(k).sin() * 50.0;
        let corner = |i: u32, k: u32| DVec3::new(wave(i * 7 + k), wave(i * 13 + k + 1), wave(i * 3 + 2 * k));
        let near = |i: u32, k: u32| corner(i, 0) + corner(i + 1000, k) * 0.1;
        (0..count).map(|i| [near(i, 1), near(i, 2), near(i, 3)]).collect()
    }

    #[test]
    fn the_tree_finds_what_looking_at_every_triangle_finds() {
        let triangles = scattered(300);
        let tree = Bvh::new(triangles.clone());
        for i in 0..200 {
            let p =
                DVec3::new(f64::from(i).cos() * 60.0, f64::from(i * 2).sin() * 60.0, f64::from(i % 7) * 9.0);
            let all = triangles.iter().map(|t| nearest_point(p, t).distance(p)).fold(f64::INFINITY, f64::min);
            assert!((tree.nearest(p).unwrap().1.distance(p) - all).abs() < 1e-12);
            let towards = DVec3::new(1.0, -2.0, f64::from(i % 5)) - p * 0.1;
            let all = triangles.iter().filter_map(|t| ray_hit(p, towards, t)).fold(f64::INFINITY, f64::min);
            assert_eq!(tree.first_hit(p, towards, f64::INFINITY).map_or(f64::INFINITY, |(t, _)| t), all);
            let within = |t: &f64| *t <= 2.0 * all;
            let mut all: Vec<f64> =
                triangles.iter().filter_map(|t| ray_hit(p, towards, t)).filter(within).collect();
            let limit = 2.0 * all.iter().copied().fold(f64::INFINITY, f64::min);
            let mut found = Vec::new();
            tree.each_hit(p, towards, limit, |t, _| found.push(t));
            all.sort_by(f64::total_cmp);
            found.sort_by(f64::total_cmp);
            assert_eq!(found, all);
        }
    }

    #[test]
    fn every_crossing_pair_is_visited_once() {
        let triangles = scattered(200);
        let crosses = |a: u32, b: u32| crossing_depth(&triangles[a as usize], &triangles[b as usize]) > 0.0;
        let mut found = Vec::new();
        let _ = Bvh::new(triangles.clone()).overlapping_pairs(|a, b| {
            found.extend(crosses(a, b).then_some((a.min(b), a.max(b))));
            ControlFlow::Continue(())
        });
        found.sort_unstable();
        let all: Vec<_> =
            (0..200).flat_map(|b| (0..b).map(move |a| (a, b))).filter(|&(a, b)| crosses(a, b)).collect();
        let mut all = all;
        all.sort_unstable();
        assert!(!all.is_empty());
        assert_eq!(found, all);
    }

    #[test]
    fn rays_along_the_axes_hit_flat_boxes() {
        let floor = Bvh::new(vec![[DVec3::ZERO, DVec3::X, DVec3::Y]]);
        assert_eq!(floor.first_hit(DVec3::new(0.0, 0.0, 3.0), DVec3::NEG_Z, 9.0).unwrap().0, 3.0);
        assert!(floor.first_hit(DVec3::new(0.0, 0.0, 3.0), DVec3::NEG_Z, 2.0).is_none());
        assert!(Bvh::new(Vec::new()).nearest(DVec3::ZERO).is_none());
    }
}
