//! The quotient of an acyclic graph: its nodes are merged into groups step by step while it stays acyclic.

use rustc_hash::{FxHashMap, FxHashSet};

use super::occlusion_graph::OcclusionGraph;

/// A graph of groups of nodes; an edge between groups has the summed support of the edges between their
/// nodes. Each group is identified by one of its nodes, see [`Quotient::group`].
pub struct Quotient {
    group_of: Vec<u32>,
    successors: Vec<FxHashMap<u32, u32>>,
    predecessors: Vec<FxHashMap<u32, u32>>,
    /// A number per group that rises along every edge; it prunes searches.
    level: Vec<u32>,
}

impl Quotient {
    /// Builds the quotient in which every node is its own group. The graph must be acyclic.
    pub fn new(graph: &OcclusionGraph) -> Self {
        let n = graph.len as usize;
        let mut quotient = Self {
            group_of: (0..graph.len).collect(),
            successors: vec![FxHashMap::default(); n],
            predecessors: vec![FxHashMap::default(); n],
            level: graph.longest_paths(),
        };
        for &(front, back, px) in &graph.edges {
            quotient.successors[front as usize].insert(back, px);
            quotient.predecessors[back as usize].insert(front, px);
        }
        quotient
    }

    /// Returns the group that holds a node.
    pub fn group(&self, node: u32) -> u32 {
        let mut group = node;
        while self.group_of[group as usize] != group {
            group = self.group_of[group as usize];
        }
        group
    }

    /// Returns true when some path leads from one of two groups to the other through a third one.
    pub fn path_through_others(&self, a: u32, b: u32) -> bool {
        self.leads_through_others(a, b) || self.leads_through_others(b, a)
    }

    /// Returns true when some path leads from one of two groups to the other, directly or through others.
    pub fn connected(&self, a: u32, b: u32) -> bool {
        self.successors[a as usize].contains_key(&b)
            || self.successors[b as usize].contains_key(&a)
            || self.path_through_others(a, b)
    }

    /// Returns true when a path of two edges or more leads from `a` to `b`.
    fn leads_through_others(&self, a: u32, b: u32) -> bool {
        let goal = self.level[b as usize];
        if self.level[a as usize] + 1 >= goal {
            return false;
        }
        let below = |g: &u32| self.level[*g as usize] < goal;
        let mut open: Vec<u32> = self.successors[a as usize].keys().copied().filter(below).collect();
        let mut seen: FxHashSet<u32> = open.iter().copied().collect();
        while let Some(group) = open.pop() {
            for &next in self.successors[group as usize].keys() {
                if next == b {
                    return true;
                }
                if below(&next) && seen.insert(next) {
                    open.push(next);
                }
            }
        }
        false
    }

    /// Merges group `b` into group `a`; edges between the two vanish. The caller makes sure that no path
    /// between them leads through other groups, otherwise the quotient would become cyclic.
    pub fn merge(&mut self, a: u32, b: u32) {
        self.group_of[b as usize] = a;
        for (next, px) in std::mem::take(&mut self.successors[b as usize]) {
            self.predecessors[next as usize].remove(&b);
            if next != a {
                *self.successors[a as usize].entry(next).or_default() += px;
                *self.predecessors[next as usize].entry(a).or_default() += px;
            }
        }
        for (previous, px) in std::mem::take(&mut self.predecessors[b as usize]) {
            self.successors[previous as usize].remove(&b);
            if previous != a {
                *self.predecessors[a as usize].entry(previous).or_default() += px;
                *self.successors[previous as usize].entry(a).or_default() += px;
            }
        }
        self.level[a as usize] = self.level[a as usize].max(self.level[b as usize]);
        self.raise_from(a);
    }

    fn raise_from(&mut self, group: u32) {
        let mut open = vec![group];
        while let Some(front) = open.pop() {
            let least = self.level[front as usize] + 1;
            for &back in self.successors[front as usize].keys() {
                if self.level[back as usize] < least {
                    self.level[back as usize] = least;
                    open.push(back);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merging_carries_paths_along() {
        // 0 -> 1 -> 2, 3 -> 4
        let mut quotient = Quotient::new(&OcclusionGraph::new(5, [(0, 1, 5), (1, 2, 5), (3, 4, 5)]));
        assert!(quotient.path_through_others(0, 2));
        assert!(!quotient.path_through_others(0, 1));
        assert!(quotient.connected(0, 1));
        assert!(!quotient.connected(2, 3));
        quotient.merge(2, 3);
        assert!(quotient.connected(0, 4) && quotient.path_through_others(0, 4));
        assert_eq!(quotient.group(3), 2);
        assert!(!quotient.connected(3, 3), "merged edges vanish");
    }
}
