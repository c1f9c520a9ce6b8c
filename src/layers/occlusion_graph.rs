//! The occlusion graph: nodes, weighted edges "front is nearer than back at px pixels", and the order that
//! decides which edges are kept.

use petgraph::algo::tarjan_scc;
use petgraph::graph::{DiGraph, NodeIndex};
use rustc_hash::FxHashMap;

/// A directed graph over nodes `0..len`, its edges sorted by (front, back).
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct OcclusionGraph {
    /// The number of nodes.
    pub len: u32,
    /// Edges `(front, back, px)`, sorted, without duplicates.
    pub edges: Vec<(u32, u32, u32)>,
}

impl OcclusionGraph {
    /// Builds a graph from edges. The supports of equal pairs are added up; edges from a node to itself are
    /// dropped.
    pub fn new(len: u32, edges: impl IntoIterator<Item = (u32, u32, u32)>) -> Self {
        let mut sums: FxHashMap<(u32, u32), u32> = FxHashMap::default();
        for (front, back, px) in edges {
            if front != back {
                *sums.entry((front, back)).or_default() += px;
            }
        }
        let mut edges: Vec<_> = sums.into_iter().map(|((f, b), px)| (f, b, px)).collect();
        edges.sort_unstable();
        Self { len, edges }
    }

    /// Returns the strongly connected components of more than one node, each sorted, ordered by their first
    /// node.
    pub fn cyclic_components(&self) -> Vec<Vec<u32>> {
        let mut graph = DiGraph::<(), (), u32>::with_capacity(self.len as usize, self.edges.len());
        for _ in 0..self.len {
            graph.add_node(());
        }
        for &(front, back, _) in &self.edges {
            graph.add_edge(NodeIndex::new(front as usize), NodeIndex::new(back as usize), ());
        }
        let mut components: Vec<Vec<u32>> = tarjan_scc(&graph)
            .into_iter()
            .filter(|c| c.len() > 1)
            .map(|c| c.into_iter().map(|n| n.index() as u32).collect())
            .collect();
        components.iter_mut().for_each(|c| c.sort_unstable());
        components.sort_unstable();
        components
    }

    /// Returns the subgraph of the edges inside `nodes` (sorted), its nodes renumbered by their index in
    /// `nodes`.
    #[inline]
    pub fn within(&self, nodes: &[u32]) -> Self {
        let index = |n: u32| nodes.binary_search(&n).ok().map(|i| i as u32);
        let edges = nodes
            .iter()
            .flat_map(|&front| self.edges_of(front))
            .filter_map(|&(f, b, px)| Some((index(f)?, index(b)?, px)))
            .collect();
        Self { len: nodes.len() as u32, edges }
    }

    /// Returns the edges that leave `front`.
    #[inline]
    pub fn edges_of(&self, front: u32) -> &[(u32, u32, u32)] {
        let begin = self.edges.partition_point(|e| e.0 < front);
        let end = self.edges.partition_point(|e| e.0 <= front);
        &self.edges[begin..end]
    }

    /// Keeps an acyclic subset of the edges: by falling support (ties: front, back), each edge is kept that
    /// closes no cycle with those already kept. The refused edges are returned strongest first.
    #[inline]
    pub fn keep_acyclic(&self) -> AcyclicGraph {
        let mut by_support = self.edges.clone();
        by_support.sort_by_key(|&(front, back, px)| (std::cmp::Reverse(px), front, back));
        let mut order = IncrementalOrder::new(self.len);
        let (mut kept, refused) =
            by_support.into_iter().partition::<Vec<_>, _>(|&(f, b, _)| order.insert(f, b));
        kept.sort_unstable();
        AcyclicGraph { graph: Self { len: self.len, edges: kept }, refused }
    }

    /// Computes the length of the longest path to each node, in edges. The graph must be acyclic.
    pub fn longest_paths(&self) -> Vec<u32> {
        let mut incoming = vec![0u32; self.len as usize];
        for &(_, back, _) in &self.edges {
            incoming[back as usize] += 1;
        }
        let mut level = vec![0u32; self.len as usize];
        let mut ready: Vec<u32> = (0..self.len).filter(|&n| incoming[n as usize] == 0).collect();
        while let Some(front) = ready.pop() {
            for &(_, back, _) in self.edges_of(front) {
                let back = back as usize;
                level[back] = level[back].max(level[front as usize] + 1);
                incoming[back] -= 1;
                if incoming[back] == 0 {
                    ready.push(back as u32);
                }
            }
        }
        debug_assert!(incoming.iter().all(|&n| n == 0), "the graph has a cycle");
        level
    }

    /// Finds the shortest path from `from` to `to` (both included), preferring smaller node numbers; `None`
    /// where there is no path.
    pub fn shortest_path(&self, from: u32, to: u32) -> Option<Vec<u32>> {
        let mut before: FxHashMap<u32, u32> = FxHashMap::default();
        let mut queue = std::collections::VecDeque::from([from]);
        while let Some(node) = queue.pop_front() {
            if node == to {
                let mut path = vec![to];
                while let Some(&previous) = before.get(&path[path.len() - 1]) {
                    path.push(previous);
                }
                path.reverse();
                return Some(path);
            }
            for &(_, back, _) in self.edges_of(node) {
                if back != from && !before.contains_key(&back) {
                    before.insert(back, node);
                    queue.push_back(back);
                }
            }
        }
        None
    }
}

/// The result of [`OcclusionGraph::keep_acyclic`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct AcyclicGraph {
    /// The acyclic graph of the edges that were kept.
    pub graph: OcclusionGraph,
    /// The edges that would have closed a cycle, strongest first.
    pub refused: Vec<(u32, u32, u32)>,
}

impl AcyclicGraph {
    /// Returns the total support of all refused edges, in pixels.
    #[inline]
    pub fn refused_px(&self) -> u64 {
        self.refused.iter().map(|e| u64::from(e.2)).sum()
    }
}

/// An incremental topological order (Pearce & Kelly, *A Dynamic Topological Sort Algorithm for Directed
/// Acyclic Graphs*, 2006): an insertion visits only the nodes between the two ends of the new edge.
struct IncrementalOrder {
    position: Vec<u32>,
    successors: Vec<Vec<u32>>,
    predecessors: Vec<Vec<u32>>,
    seen: Vec<bool>,
}

impl IncrementalOrder {
    fn new(len: u32) -> Self {
        let n = len as usize;
        Self {
            position: (0..len).collect(),
            successors: vec![Vec::new(); n],
            predecessors: vec![Vec::new(); n],
            seen: vec![false; n],
        }
    }

    /// Adds `front -> back` unless it closes a cycle; returns whether it was added.
    fn insert(&mut self, front: u32, back: u32) -> bool {
        let (low, high) = (self.position[back as usize], self.position[front as usize]);
        if low < high {
            let Some(after) = self.reach_forward(back, front, high) else { return false };
            let before = self.reach_backward(front, low);
            self.reorder(before, after);
        }
        self.successors[front as usize].push(back);
        self.predecessors[back as usize].push(front);
        true
    }

    /// Returns the nodes reachable from `start` at positions below `high`; `None` when `forbidden` is one of
    /// them.
    fn reach_forward(&mut self, start: u32, forbidden: u32, high: u32) -> Option<Vec<u32>> {
        let mut found = vec![start];
        self.seen[start as usize] = true;
        let mut next = 0;
        let mut closes = false;
        while next < found.len() && !closes {
            for &s in &self.successors[found[next] as usize] {
                closes |= s == forbidden;
                if self.position[s as usize] < high && !self.seen[s as usize] {
                    self.seen[s as usize] = true;
                    found.push(s);
                }
            }
            next += 1;
        }
        found.iter().for_each(|&n| self.seen[n as usize] = false);
        (!closes).then_some(found)
    }

    fn reach_backward(&mut self, start: u32, low: u32) -> Vec<u32> {
        let mut found = vec![start];
        self.seen[start as usize] = true;
        let mut next = 0;
        while next < found.len() {
            for &p in &self.predecessors[found[next] as usize] {
                if self.position[p as usize] > low && !self.seen[p as usize] {
                    self.seen[p as usize] = true;
                    found.push(p);
                }
            }
            next += 1;
        }
        found.iter().for_each(|&n| self.seen[n as usize] = false);
        found
    }

    /// Assigns the positions that both sets occupy to `before` first, then to `after`.
    fn reorder(&mut self, mut before: Vec<u32>, mut after: Vec<u32>) {
        before.sort_unstable_by_key(|&n| self.position[n as usize]);
        after.sort_unstable_by_key(|&n| self.position[n as usize]);
        let nodes: Vec<u32> = before.into_iter().chain(after).collect();
        let mut positions: Vec<u32> = nodes.iter().map(|&n| self.position[n as usize]).collect();
        positions.sort_unstable();
        for (node, position) in nodes.into_iter().zip(positions) {
            self.position[node as usize] = position;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weakest_edge_of_a_cycle_is_refused() {
        let graph = OcclusionGraph::new(3, [(0, 1, 50), (1, 2, 40), (2, 0, 7)]);
        let kept = graph.keep_acyclic();
        assert_eq!(kept.refused, [(2, 0, 7)]);
        assert_eq!(kept.graph.longest_paths(), [0, 1, 2]);
        assert_eq!(kept.graph.shortest_path(0, 2), Some(vec![0, 1, 2]));
        assert_eq!(graph.cyclic_components(), [[0, 1, 2]]);
    }

    #[test]
    fn random_graphs_keep_a_maximal_acyclic_set() {
        let mut state = 7u64;
        let mut random = |n: u64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) % n
        };
        for _ in 0..200 {
            let n = 2 + random(12) as u32;
            let edges: Vec<_> = (0..random(40))
                .map(|_| (random(n.into()) as u32, random(n.into()) as u32, 1 + random(9) as u32))
                .collect();
            let graph = OcclusionGraph::new(n, edges);
            let kept = graph.keep_acyclic();
            assert!(kept.graph.cyclic_components().is_empty());
            for &(front, back, _) in &kept.refused {
                assert!(kept.graph.shortest_path(back, front).is_some(), "refused without a cycle");
            }
            assert_eq!(kept.graph.edges.len() + kept.refused.len(), graph.edges.len());
        }
    }
}
