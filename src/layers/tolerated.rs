//! Tolerated overlaps: parts of one object that are kept apart only because they occlude each other a little may be
//! one element. In the overlap the farther surface gets no texture from this photo.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::nodes::Nodes;
use super::occlusion_graph::OcclusionGraph;
use super::projected_model::ProjectedModel;
use super::runs::{RowRuns, Runs, is_visible, item_of};

/// An overlap within an element: node `front` is nearer than node `back` at `px` pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Overlap {
    /// The nearer node.
    pub front: u32,
    /// The farther node.
    pub back: u32,
    /// The number of pixels.
    pub px: u32,
}

/// A part of an object while parts are united.
#[derive(Debug, Clone)]
pub(super) struct ObjectPart {
    /// The node that identifies the part.
    pub root: u32,
    /// The nodes, with those of the parts that were united with it.
    pub nodes: Vec<u32>,
}

/// The overlaps between parts of objects.
pub(super) struct Overlaps<'a> {
    relation: &'a OcclusionGraph,
    /// The number of visible pixels of each node.
    visible_px: Vec<u64>,
}

impl<'a> Overlaps<'a> {
    /// Counts the visible pixels of all nodes.
    pub fn new(view: &ProjectedModel, runs: &Runs, nodes: &Nodes, relation: &'a OcclusionGraph) -> Self {
        Self { relation, visible_px: visible_px(view, runs, nodes) }
    }

    /// Returns the pairs of parts whose overlap is at most `share` of the visible pixels of the smaller part: those
    /// with the smallest share first (ties: the parts' order).
    pub fn pairs(
        &self,
        parts: &[ObjectPart],
        share: impl Fn(&ObjectPart, &ObjectPart) -> f64,
    ) -> Vec<(usize, usize)> {
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (b, second) in parts.iter().enumerate() {
            for (a, first) in parts[..b].iter().enumerate() {
                let overlap = self.share_of_smaller(first, second);
                if overlap <= share(first, second) {
                    pairs.push((overlap, a, b));
                }
            }
        }
        pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
        pairs.into_iter().map(|(_, a, b)| (a, b)).collect()
    }

    /// Returns the pixels at which two parts occlude each other, as a share of the visible pixels of the smaller one.
    fn share_of_smaller(&self, a: &ObjectPart, b: &ObjectPart) -> f64 {
        let visible =
            |part: &ObjectPart| part.nodes.iter().map(|n| self.visible_px[*n as usize]).sum::<u64>();
        let px = |fronts: &ObjectPart, backs: &ObjectPart| {
            let backs: BTreeSet<u32> = backs.nodes.iter().copied().collect();
            let edges = fronts.nodes.iter().flat_map(|front| self.relation.edges_of(*front));
            edges.filter(|(_, back, _)| backs.contains(back)).map(|edge| u64::from(edge.2)).sum::<u64>()
        };
        (px(a, b) + px(b, a)) as f64 / visible(a).min(visible(b)).max(1) as f64
    }
}

/// Counts the visible pixels of every node.
fn visible_px(view: &ProjectedModel, runs: &Runs, nodes: &Nodes) -> Vec<u64> {
    let none = || vec![0u64; nodes.list.len()];
    let count = |mut px: Vec<u64>, (y, row): (usize, &RowRuns)| {
        for run in &row.runs {
            for item in row.entries(run).iter().filter(|e| is_visible(**e)).map(|e| item_of(*e)) {
                if nodes.is_cut(item) {
                    let pixels = (run.x0..run.x1).filter_map(|x| nodes.at(view, item, x, y as u32));
                    pixels.for_each(|node| px[node.0 as usize] += 1);
                } else if let Some(node) = nodes.of_whole(item) {
                    px[node.0 as usize] += u64::from(run.len());
                }
            }
        }
        px
    };
    let unite = |mut a: Vec<u64>, b: Vec<u64>| {
        a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        a
    };
    runs.rows.par_iter().enumerate().fold(none, count).reduce(none, unite)
}
