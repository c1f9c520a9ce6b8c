//! Outlines of groups of adjacent polygons, by walking along a half-edge mesh.

use rustc_hash::{FxHashMap, FxHashSet};

/// Returns the outlines of polygons that lie side by side in one plane, given as cycles of point indices, all wound
/// alike. Polygons that share an edge (in opposite directions) form a group. Each group becomes one weakly simple
/// ring, wound like the polygons, whose holes are bridged along existing edges, those of least `bridge_cost(from,
/// to)` first (usually the length). Groups are in the order of their first polygon.
///
/// An edge that more than two polygons use, or two in the same direction, connects nothing.
pub fn outlines(polygons: &[Vec<u32>], bridge_cost: impl Fn(u32, u32) -> f64) -> Vec<Vec<u32>> {
    let mut mesh = HalfEdges::new(polygons);
    mesh.bridge_holes(bridge_cost);
    mesh.rings()
}

/// The directed edges of all polygons. Edge h runs `from[h] -> from[next[h]]`; `twin[h]` is the opposite edge in
/// the neighbouring polygon.
struct HalfEdges {
    from: Vec<u32>,
    next: Vec<u32>,
    /// The twin of each directed edge; [`NONE`] on the outline.
    twin: Vec<u32>,
    /// The group of each directed edge, numbered by first polygon.
    group: Vec<u32>,
    /// Whether the edge is a bridge, which is walked along on both sides.
    bridge: Vec<bool>,
}

/// Marks a directed edge without a twin or group.
const NONE: u32 = u32::MAX;

impl HalfEdges {
    fn new(polygons: &[Vec<u32>]) -> Self {
        let (mut from, mut next) = (Vec::new(), Vec::new());
        for polygon in polygons {
            let start = from.len() as u32;
            from.extend_from_slice(polygon);
            next.extend((0..polygon.len() as u32).map(|i| start + (i + 1) % polygon.len() as u32));
        }
        let edges = from.len();
        let mut mesh = Self {
            from,
            next,
            twin: vec![NONE; edges],
            group: vec![NONE; edges],
            bridge: vec![false; edges],
        };
        mesh.find_twins();
        mesh.find_groups();
        mesh
    }

    /// Returns the point at which a directed edge ends.
    fn to(&self, h: u32) -> u32 {
        self.from[self.next[h as usize] as usize]
    }

    fn edges(&self) -> std::ops::Range<u32> {
        0..self.from.len() as u32
    }

    /// Pairs each directed edge with the only opposite one.
    fn find_twins(&mut self) {
        let mut by_ends: FxHashMap<(u32, u32), u32> = FxHashMap::default();
        for h in self.edges() {
            let ends = (self.from[h as usize], self.to(h));
            by_ends.entry(ends).and_modify(|seen| *seen = NONE).or_insert(h);
        }
        let sole = |ends| by_ends.get(&ends).copied().filter(|&h| h != NONE);
        for h in self.edges() {
            let (a, b) = (self.from[h as usize], self.to(h));
            if let (Some(_), Some(other)) = (sole((a, b)), sole((b, a))) {
                self.twin[h as usize] = other;
            }
        }
    }

    /// Numbers the groups by flooding across polygons and twins.
    fn find_groups(&mut self) {
        let mut groups = 0;
        let mut open = Vec::new();
        for first in self.edges() {
            if self.group[first as usize] != NONE {
                continue;
            }
            open.push(first);
            while let Some(h) = open.pop() {
                if h == NONE || self.group[h as usize] != NONE {
                    continue;
                }
                self.group[h as usize] = groups;
                open.push(self.next[h as usize]);
                open.push(self.twin[h as usize]);
            }
            groups += 1;
        }
    }

    /// Returns true when an outline runs along this edge.
    fn is_walked(&self, h: u32) -> bool {
        self.twin[h as usize] == NONE || self.bridge[h as usize]
    }

    /// Returns the walked edge that follows `h`: the first one met when turning through the polygons at its end.
    fn following(&self, h: u32) -> u32 {
        let mut h = self.next[h as usize];
        while !self.is_walked(h) {
            h = self.next[self.twin[h as usize] as usize];
        }
        h
    }

    /// Returns the closed walks along the outline, each as directed edges.
    fn loops(&self) -> Vec<Vec<u32>> {
        let mut seen = vec![false; self.from.len()];
        let mut loops = Vec::new();
        for first in self.edges().filter(|&h| self.is_walked(h)) {
            let mut walk = Vec::new();
            let mut h = first;
            while !seen[h as usize] {
                seen[h as usize] = true;
                walk.push(h);
                h = self.following(h);
            }
            if !walk.is_empty() {
                loops.push(walk);
            }
        }
        loops
    }

    /// Connects the loops of each group by the cheapest inner edges that do (a minimum spanning tree by Kruskal's
    /// algorithm). Branches that end at an inner point connect nothing and are removed.
    fn bridge_holes(&mut self, cost: impl Fn(u32, u32) -> f64) {
        let loops = self.loops();
        let groups = self.group.iter().max().map_or(0, |&g| g as usize + 1);
        if loops.len() <= groups {
            return;
        }
        let mut sets = Sets::default();
        let mut on_outline = FxHashSet::default();
        for walk in &loops {
            for &h in walk {
                sets.join(self.corner(walk[0]), self.corner(h));
                on_outline.insert(self.corner(h));
            }
        }
        let mut tree = Vec::new();
        for h in self.inner_edges_by_cost(cost) {
            if sets.join(self.corner(h), self.corner(self.next[h as usize])) {
                tree.push(h);
            }
        }
        for h in self.pruned(tree, &on_outline) {
            self.bridge[h as usize] = true;
            self.bridge[self.twin[h as usize] as usize] = true;
        }
    }

    /// Returns the start point of an edge together with its group: groups that only touch at a point stay separate.
    fn corner(&self, h: u32) -> (u32, u32) {
        (self.group[h as usize], self.from[h as usize])
    }

    /// Returns one directed edge per pair of twins, cheapest first.
    fn inner_edges_by_cost(&self, cost: impl Fn(u32, u32) -> f64) -> Vec<u32> {
        let cost_of = |h: u32| cost(self.from[h as usize], self.to(h));
        let inner = |h: &u32| self.twin[*h as usize] != NONE && *h < self.twin[*h as usize];
        let mut edges: Vec<(f64, u32)> = self.edges().filter(inner).map(|h| (cost_of(h), h)).collect();
        edges.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        edges.into_iter().map(|(_, h)| h).collect()
    }

    /// Removes branches of the tree that end at a corner inside the outline.
    fn pruned(&self, tree: Vec<u32>, on_outline: &FxHashSet<(u32, u32)>) -> Vec<u32> {
        let ends = |h: u32| [self.corner(h), self.corner(self.next[h as usize])];
        let mut edges_at: FxHashMap<(u32, u32), Vec<u32>> = FxHashMap::default();
        for &h in &tree {
            ends(h).into_iter().for_each(|corner| edges_at.entry(corner).or_default().push(h));
        }
        let inner = |corner: &(u32, u32)| !on_outline.contains(corner);
        let mut tips: Vec<(u32, u32)> = edges_at.keys().copied().filter(inner).collect();
        let mut cut = FxHashSet::default();
        while let Some(tip) = tips.pop() {
            let mut left = edges_at[&tip].iter().filter(|&h| !cut.contains(h));
            if let (Some(&last), None) = (left.next(), left.next()) {
                cut.insert(last);
                tips.extend(ends(last).into_iter().filter(|end| *end != tip && inner(end)));
            }
        }
        tree.into_iter().filter(|h| !cut.contains(h)).collect()
    }

    /// Returns the loops as rings of points, by group.
    fn rings(&self) -> Vec<Vec<u32>> {
        let mut loops = self.loops();
        loops.sort_by_key(|walk| self.group[walk[0] as usize]);
        loops.into_iter().map(|walk| walk.into_iter().map(|h| self.from[h as usize]).collect()).collect()
    }
}

/// A union-find structure over corners.
#[derive(Default)]
struct Sets(FxHashMap<(u32, u32), (u32, u32)>);

impl Sets {
    /// Returns the representative of a corner's set and shortens the path to it.
    fn root(&mut self, mut at: (u32, u32)) -> (u32, u32) {
        while let Some(&up) = self.0.get(&at)
            && up != at
        {
            let above = self.0.get(&up).copied().unwrap_or(up);
            self.0.insert(at, above);
            at = up;
        }
        at
    }

    /// Unites two sets; returns false when they were one already.
    fn join(&mut self, a: (u32, u32), b: (u32, u32)) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        if a != b {
            self.0.insert(b, a);
        }
        a != b
    }
}
