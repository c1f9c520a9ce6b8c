//! Resolution of cycles in the occlusion graph: contact noise is forgiven, real cycles are cut (after Newell,
//! Newell & Sancha 1972, but decided on pixels instead of extents).

use std::ops::Range;

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use super::component_pixels::{ComponentPixels, Meeting, Span, count_in, gather_components, split_span};
use super::nodes::{CutSide, GraphNode, Nodes, is_near};
use super::occlusion_graph::{AcyclicGraph, OcclusionGraph};
use super::options::Options;
use super::projected_model::ProjectedModel;
use super::rasteriser::{Occlusion, TIE, is_behind};
use super::runs::{Runs, item_of};

/// The nodes after cutting, and the occlusion relation between them.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Resolved {
    /// The items of the working set, cut into pieces where that was needed.
    pub nodes: Nodes,
    /// The complete occlusion relation between nodes.
    pub relation: OcclusionGraph,
    /// The acyclic part of the relation that was kept, and the edges that were refused.
    pub kept: AcyclicGraph,
    /// The number of cuts made.
    pub cuts: u32,
    /// The number of cuts of which one piece is visible nowhere and left the working set.
    pub free_cuts: u32,
}

/// Finds the cycles in the table of occlusions, forgives or cuts them, and so makes the working set sortable.
pub fn resolve_cycles(
    view: &ProjectedModel,
    runs: &Runs,
    working: &[bool],
    occlusions: &[Occlusion],
    options: &Options,
) -> Resolved {
    let table =
        OcclusionGraph::new(view.items.len() as u32, occlusions.iter().map(|o| (o.front, o.back, o.px)));
    let components = table.cyclic_components();
    let cycle_components = gather_components(runs, &components, view.items.len());
    let cut: Vec<_> = components
        .par_iter()
        .zip(cycle_components)
        .map(|(items, cycle_component)| {
            CycleComponent::cut(view, runs, options, &table.within(items), items, cycle_component)
        })
        .collect();
    let pieces: Vec<GraphNode> = cut.iter().flat_map(|c| c.pieces.iter().cloned()).collect();
    let nodes = Nodes::with_pieces(working, &pieces);
    let relation = relation_of_nodes(view, runs, &nodes, occlusions, options.tolerance);
    let kept = relation.keep_acyclic();
    Resolved {
        nodes,
        relation,
        kept,
        cuts: cut.iter().map(|c| c.cuts).sum(),
        free_cuts: cut.iter().map(|c| c.free_cuts).sum(),
    }
}

/// Builds the relation between nodes: pairs of whole items keep the rasteriser's counts, pairs with a cut
/// item are counted anew.
fn relation_of_nodes(
    view: &ProjectedModel,
    runs: &Runs,
    nodes: &Nodes,
    occlusions: &[Occlusion],
    tolerance: f32,
) -> OcclusionGraph {
    let whole = occlusions.iter().filter_map(|o| {
        let (front, back) = (nodes.of_whole(o.front)?, nodes.of_whole(o.back)?);
        Some((front.0, back.0, o.px))
    });
    let counted: EdgeSet = runs
        .rows
        .par_iter()
        .enumerate()
        .fold(EdgeSet::default, |mut counts, (y, row)| {
            for run in &row.runs {
                let entries = row.entries(run);
                if entries.len() > 1 && entries.iter().any(|&e| nodes.is_cut(item_of(e))) {
                    count_cut_pairs(view, nodes, entries, y as u32, run.x0..run.x1, tolerance, &mut counts);
                }
            }
            counts
        })
        .reduce(EdgeSet::default, |mut sum, counts| {
            counts.into_iter().for_each(|(pair, px)| *sum.entry(pair).or_default() += px);
            sum
        });
    let counted = counted.into_iter().map(|((front, back), px)| (front, back, px));
    OcclusionGraph::new(nodes.len(), whole.chain(counted))
}

/// Counts the pairs with a cut item over columns of a row that hold the same entries. Neighbouring pixels mostly have
/// the same front and the same back, so a stretch of such pixels is counted at once.
fn count_cut_pairs(
    view: &ProjectedModel,
    nodes: &Nodes,
    entries: &[u32],
    y: u32,
    columns: Range<u32>,
    tolerance: f32,
    counts: &mut EdgeSet,
) {
    for (i, a) in entries.iter().map(|&e| item_of(e)).enumerate() {
        for b in entries[i + 1..].iter().map(|&e| item_of(e)) {
            if !nodes.is_cut(a) && !nodes.is_cut(b) {
                continue;
            }
            let (mut last, mut px) = (None, 0);
            for x in columns.clone() {
                let pair = nearer(view, a, b, x, y, tolerance).and_then(|(front, back)| {
                    Some((nodes.at(view, front, x, y)?.0, nodes.at(view, back, x, y)?.0))
                });
                if pair != last {
                    add_pixels(counts, last, px);
                    (last, px) = (pair, 0);
                }
                px += 1;
            }
            add_pixels(counts, last, px);
        }
    }
}

fn add_pixels(counts: &mut EdgeSet, pair: Option<(u32, u32)>, px: u32) {
    if let Some(pair) = pair {
        *counts.entry(pair).or_default() += px;
    }
}

/// Returns (front, back) where one of two items is nearer by more than the tolerance; `None` where neither
/// is.
fn nearer(view: &ProjectedModel, a: u32, b: u32, x: u32, y: u32, tolerance: f32) -> Option<(u32, u32)> {
    let inverse = |i: u32| view.items[i as usize].inverse_depth.at(x, y);
    let (inverse_a, inverse_b) = (inverse(a), inverse(b));
    if is_behind(inverse_b, inverse_a, tolerance) {
        Some((a, b))
    } else if is_behind(inverse_a, inverse_b, tolerance) {
        Some((b, a))
    } else {
        None
    }
}

/// A node of a component while the component is being cut, with the pixels that it covers.
#[derive(Debug, Clone)]
struct ComponentPart {
    node: GraphNode,
    spans: Vec<Span>,
}

/// The result of [`CycleComponent::cut`].
#[derive(Debug, Default)]
struct CutComponent {
    pieces: Vec<GraphNode>,
    cuts: u32,
    free_cuts: u32,
}

/// The number of pixels of each edge (front, back).
type EdgeSet = FxHashMap<(u32, u32), u32>;

/// One strongly connected component while it is being cut. Parts are identified by their index in `parts`;
/// those that were cut or left the working set remain there as `None`.
struct CycleComponent<'a> {
    view: &'a ProjectedModel,
    runs: &'a Runs,
    options: &'a Options,
    meetings: Vec<Meeting>,
    meetings_of: FxHashMap<u32, Vec<u32>>,
    spans_of: FxHashMap<u32, Vec<Span>>,
    parts: Vec<Option<ComponentPart>>,
    edges: EdgeSet,
    tried: FxHashSet<(u32, u32)>,
    result: CutComponent,
}

/// A cut that could be made, with the graph that it would lead to.
struct CutCandidate {
    part: u32,
    plane: u32,
    near: ComponentPart,
    far: ComponentPart,
    edges: EdgeSet,
    drop_near: bool,
    drop_far: bool,
    refused_px: u64,
}

impl<'a> CycleComponent<'a> {
    fn cut(
        view: &'a ProjectedModel,
        runs: &'a Runs,
        options: &'a Options,
        table: &OcclusionGraph,
        items: &[u32],
        pixels: ComponentPixels,
    ) -> CutComponent {
        let mut meetings_of: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
        for (m, meeting) in pixels.meetings.iter().enumerate() {
            for &item in &meeting.items {
                meetings_of.entry(item).or_default().push(m as u32);
            }
        }
        let parts = items
            .iter()
            .map(|&item| ComponentPart {
                node: GraphNode { item, sides: Vec::new() },
                spans: pixels.spans[&item].clone(),
            })
            .map(Some)
            .collect();
        let mut cycle_component = Self {
            view,
            runs,
            options,
            meetings: pixels.meetings,
            meetings_of,
            spans_of: pixels.spans,
            parts,
            edges: table.edges.iter().map(|&(f, b, px)| ((f, b), px)).collect(),
            tried: FxHashSet::default(),
            result: CutComponent::default(),
        };
        cycle_component.run();
        let cut = cycle_component.parts.into_iter().flatten().map(|p| p.node);
        cycle_component.result.pieces = cut.filter(|n| !n.sides.is_empty()).collect();
        cycle_component.result
    }

    /// Cuts until no refused edge is stronger than contact noise, or until nothing can be cut.
    fn run(&mut self) {
        let mut hopeless: FxHashSet<(u32, u32)> = FxHashSet::default();
        loop {
            let kept = self.graph(&self.edges, None).keep_acyclic();
            let strong = kept.refused.iter().find(|&&(front, back, px)| {
                px > self.options.min_support && !hopeless.contains(&(front, back))
            });
            let Some(&(front, back, _)) = strong else { return };
            match self.best_candidate(&kept, front, back) {
                Some(best) => self.apply(best),
                None => {
                    hopeless.insert((front, back));
                }
            }
        }
    }

    /// Builds the component's graph over all parts. `grown` is the number of parts to assume, if it is not
    /// the present one.
    fn graph(&self, edges: &EdgeSet, grown: Option<u32>) -> OcclusionGraph {
        let len = grown.unwrap_or(self.parts.len() as u32);
        OcclusionGraph::new(len, edges.iter().map(|(&(f, b), &px)| (f, b, px)))
    }

    fn best_candidate(&mut self, kept: &AcyclicGraph, front: u32, back: u32) -> Option<CutCandidate> {
        let cycle = kept.graph.shortest_path(back, front)?;
        let mut best: Option<CutCandidate> = None;
        for &part in &cycle {
            for &other in &cycle {
                if let Some(candidate) = self.candidate(part, other)
                    && best.as_ref().is_none_or(|b| candidate.rank() < b.rank())
                {
                    best = Some(candidate);
                }
            }
        }
        best
    }

    /// Tries the cut of `part` by the plane of `other`; `None` unless the part has enough pixels clearly on
    /// both sides.
    fn candidate(&self, part: u32, other: u32) -> Option<CutCandidate> {
        let cut = self.parts[part as usize].as_ref()?;
        let plane = self.parts[other as usize].as_ref()?.node.item;
        if cut.node.item == plane || self.tried.contains(&(part, plane)) || !self.straddles(cut, plane) {
            return None;
        }
        let near = self.side_of(cut, plane, true);
        let far = self.side_of(cut, plane, false);
        let (drop_near, drop_far) = (!self.is_nearest_somewhere(&near), !self.is_nearest_somewhere(&far));
        let mut edges = self.edges.clone();
        edges.retain(|&(f, b), _| f != part && b != part);
        let grown = self.parts.len() as u32 + 2;
        let names = [grown - 2, grown - 1];
        for (pair, px) in self.recount(part, plane, names) {
            let dropped = |n: u32| (n == names[0] && drop_near) || (n == names[1] && drop_far);
            if !dropped(pair.0) && !dropped(pair.1) {
                edges.insert(pair, px);
            }
        }
        let refused_px = self.graph(&edges, Some(grown)).keep_acyclic().refused_px();
        Some(CutCandidate { part, plane, near, far, edges, drop_near, drop_far, refused_px })
    }

    /// Returns true when more than half of `min_support` pixels are clearly nearer than the plane, and as
    /// many clearly farther.
    fn straddles(&self, part: &ComponentPart, plane: u32) -> bool {
        let half = self.options.tolerance / 2.0;
        let (item, plane) = (self.inverse(part.node.item), self.inverse(plane));
        let enough = u64::from(self.options.min_support / 2);
        let nearer = |x: u32, y: u32| plane.at(x, y) < item.at(x, y) * (1.0 - half);
        let farther = |x: u32, y: u32| item.at(x, y) * (1.0 + half) < plane.at(x, y);
        count_in(&part.spans, nearer) > enough && count_in(&part.spans, farther) > enough
    }

    fn inverse(&self, item: u32) -> quadratura_base::geometry::InverseDepth {
        self.view.items[item as usize].inverse_depth
    }

    fn side_of(&self, part: &ComponentPart, plane: u32, near: bool) -> ComponentPart {
        let mut node = part.node.clone();
        node.sides.push(CutSide { plane, near });
        let on_side = |x: u32, y: u32| is_near(self.view, part.node.item, plane, x, y) == near;
        let spans = part.spans.iter().filter_map(|span| split_span(span, on_side)).collect();
        ComponentPart { node, spans }
    }

    /// Returns true when the part is nearest at some pixel. This alone decides whether a piece leaves the
    /// working set, so where the part's own spans show no such pixel, every visible pixel of the whole item
    /// is tested.
    fn is_nearest_somewhere(&self, part: &ComponentPart) -> bool {
        let nearest_in = |s: &Span| s.visible && (s.x0..s.x1).any(|x| self.is_nearest(part, s, x));
        part.spans.iter().any(nearest_in) || self.spans_of[&part.node.item].iter().any(nearest_in)
    }

    fn is_nearest(&self, part: &ComponentPart, span: &Span, x: u32) -> bool {
        let row = &self.runs.rows[span.y as usize];
        let inverse = |item: u32| self.inverse(item).at(x, span.y);
        let own = inverse(part.node.item);
        self.holds(&part.node, x, span.y)
            && row
                .entries(&row.runs[span.run as usize])
                .iter()
                .all(|&other| !is_behind(own, inverse(item_of(other)), TIE))
    }

    /// Counts the pairs of `part` anew at the pixels where other items of its component meet it. `names` are
    /// the numbers of its two sides (near, far).
    fn recount(&self, part: u32, plane: u32, names: [u32; 2]) -> EdgeSet {
        let Some(cut) = &self.parts[part as usize] else { return EdgeSet::default() };
        let item = cut.node.item;
        let parts_of = self.parts_by_item();
        let mut edges = EdgeSet::default();
        for &m in self.meetings_of.get(&item).map_or(&[][..], Vec::as_slice) {
            let meeting = &self.meetings[m as usize];
            for x in meeting.x0..meeting.x1 {
                if !self.holds(&cut.node, x, meeting.y) {
                    continue;
                }
                let name = names[usize::from(!is_near(self.view, item, plane, x, meeting.y))];
                for &other in meeting.items.iter().filter(|&&o| o != item) {
                    self.count_one(&parts_of, item, name, other, x, meeting.y, &mut edges);
                }
            }
        }
        edges
    }

    #[allow(clippy::too_many_arguments)]
    fn count_one(
        &self,
        parts_of: &FxHashMap<u32, Vec<u32>>,
        item: u32,
        name: u32,
        other: u32,
        x: u32,
        y: u32,
        edges: &mut EdgeSet,
    ) {
        let Some((front, _)) = nearer(self.view, item, other, x, y, self.options.tolerance) else { return };
        let Some(candidates) = parts_of.get(&other) else { return };
        let found = candidates
            .iter()
            .copied()
            .find(|&p| self.parts[p as usize].as_ref().is_some_and(|part| self.holds(&part.node, x, y)));
        if let Some(other_part) = found {
            let pair = if front == item { (name, other_part) } else { (other_part, name) };
            *edges.entry(pair).or_default() += 1;
        }
    }

    /// Returns true when the item's fragment at this pixel belongs to the node.
    fn holds(&self, node: &GraphNode, x: u32, y: u32) -> bool {
        node.sides.iter().all(|s| is_near(self.view, node.item, s.plane, x, y) == s.near)
    }

    fn parts_by_item(&self) -> FxHashMap<u32, Vec<u32>> {
        let mut parts_of: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
        for (i, part) in self.parts.iter().enumerate() {
            if let Some(part) = part {
                parts_of.entry(part.node.item).or_default().push(i as u32);
            }
        }
        parts_of
    }

    fn apply(&mut self, cut: CutCandidate) {
        self.parts[cut.part as usize] = None;
        let first = self.parts.len() as u32;
        // A face is cut by the same plane once only: neither piece, nor any piece of these, is offered that
        // plane again.
        let planes: Vec<u32> =
            self.tried.iter().filter(|t| t.0 == cut.part).map(|t| t.1).chain([cut.plane]).collect();
        for plane in planes {
            self.tried.insert((first, plane));
            self.tried.insert((first + 1, plane));
        }
        self.result.cuts += 1;
        self.result.free_cuts += u32::from(cut.drop_near || cut.drop_far);
        self.parts.push((!cut.drop_near).then_some(cut.near));
        self.parts.push((!cut.drop_far).then_some(cut.far));
        self.edges = cut.edges;
    }
}

impl CutCandidate {
    /// Returns the sort key of a candidate, the least being best: refused support, then free cuts first, then
    /// the order of part and plane.
    fn rank(&self) -> (u64, bool, u32, u32) {
        (self.refused_px, !(self.drop_near || self.drop_far), self.part, self.plane)
    }
}
