//! Elements: each object's faces and pieces, gathered into as few parts as possible, and the visibility
//! layers that follow from them.

use std::cmp::Reverse;
use std::fmt;

use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

use super::constraints::ResolvedConstraints;
use super::cycles::Resolved;
use super::nodes::NodeId;
use super::occlusion_graph::OcclusionGraph;
use super::options::Options;
use super::projected_model::ProjectedModel;
use super::quotient::Quotient;
use super::runs::Runs;
use super::tolerated::{ObjectPart, Overlap, Overlaps};
use quadratura_base::scene::{Model, ObjectId};

/// The index of an element in reading order of the visibility layers, which stacks number them by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ElementIndex(pub u32);

impl ElementIndex {
    /// Returns the index of the element at a position in reading order.
    pub fn new(position: usize) -> Self {
        Self(position as u32)
    }

    /// Returns the position in reading order.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl fmt::Display for ElementIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A part of an object: faces and pieces that hardly occlude each other and are sorted as one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SortedElement {
    /// The object that the element belongs to.
    pub object: ObjectId,
    /// The nodes, in rising order.
    pub nodes: Vec<NodeId>,
    /// The visibility layer, 0 nearest.
    pub visibility_layer: u32,
}

/// The visibility layers of a photo.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layers {
    /// The elements in reading order: by layer, then by first node.
    pub elements: Vec<SortedElement>,
    /// The element of each node.
    pub element_of: Vec<ElementIndex>,
    /// The occlusions between elements that agree with the order of the layers: an acyclic graph.
    pub occlusions: OcclusionGraph,
    /// The occlusions that contradict the order of the layers, forgiven or left over: `(front, back, px)`,
    /// sorted.
    pub against: Vec<(u32, u32, u32)>,
    /// The overlaps within elements that were tolerated, between nodes; sorted.
    pub tolerated: Vec<Overlap>,
}

/// Gathers the nodes of every object into elements and sorts these into visibility layers.
///
/// Objects are processed by falling number of nodes, then by name; nodes by layer, then in model order. A
/// node joins the first part of its object that meets four conditions: the two overlap in at most
/// `min_support` pixels; no path of occlusions leads from one to the other through other groups (so the
/// quotient stays acyclic); the two together have at most `min_support` forgiven pixels towards any other
/// group; and no constraint splits the node from a face of the part.
///
/// Then parts of one object are united that only a tolerated overlap keeps apart, under the same conditions but for the
/// first one.
pub fn gather_parts(
    model: &Model,
    view: &ProjectedModel,
    runs: &Runs,
    resolved: &Resolved,
    options: &Options,
    wanted: &ResolvedConstraints,
) -> Layers {
    let kept = &resolved.kept.graph;
    let layer = kept.longest_paths();
    let face_of = |node: u32| view.items[resolved.nodes.list[node as usize].item as usize].face;
    let object_of = |node: u32| model.face(face_of(node)).object;
    let mut nodes_of: FxHashMap<ObjectId, Vec<u32>> = FxHashMap::default();
    (0..kept.len).for_each(|node| nodes_of.entry(object_of(node)).or_default().push(node));
    let mut objects: Vec<_> = nodes_of.into_iter().collect();
    objects.sort_by_key(|(object, nodes)| (Reverse(nodes.len()), &model.object(*object).name));

    let mut gathering = Gathering::new(resolved, options.min_support);
    let apart = |a: u32, b: u32| wanted.apart(face_of(a), face_of(b));
    let mut parts_of = Vec::with_capacity(objects.len());
    for (object, nodes) in &mut objects {
        nodes.sort_unstable_by_key(|&n| (layer[n as usize], n));
        parts_of.push((*object, gathering.gather(nodes, apart)));
    }
    let before = gathering.groups();
    if options.tolerates() || wanted.tolerates_any() {
        let overlaps = Overlaps::new(view, runs, &resolved.nodes, &resolved.relation);
        for (object, parts) in parts_of.iter_mut().filter(|(_, parts)| parts.len() > 1) {
            let of_object = f64::from(options.tolerated_share(&model.object(*object).name));
            let asked = |part: &ObjectPart| part.nodes.iter().all(|node| wanted.tolerates(face_of(*node)));
            let share =
                |a: &ObjectPart, b: &ObjectPart| if asked(a) && asked(b) { f64::INFINITY } else { of_object };
            if of_object > 0.0 || parts.iter().any(asked) {
                gathering.unite(parts, &overlaps, share, apart);
            }
        }
    }
    let groups = gathering.groups();
    let mut layers = layers_of_groups(&groups, &resolved.relation, kept, object_of);
    layers.tolerated = overlaps_within(&groups, &before, &resolved.relation);
    layers
}

/// Returns the overlaps between nodes that are in one group now and were in two before.
fn overlaps_within(groups: &[u32], before: &[u32], relation: &OcclusionGraph) -> Vec<Overlap> {
    let united =
        |f: u32, b: u32| groups[f as usize] == groups[b as usize] && before[f as usize] != before[b as usize];
    let overlaps = relation.edges.iter().filter(|&&(front, back, _)| united(front, back));
    overlaps.map(|&(front, back, px)| Overlap { front, back, px }).collect()
}

struct Gathering {
    quotient: Quotient,
    overlaps: Vec<FxHashMap<u32, u32>>,
    forgiven: FxHashMap<u32, FxHashMap<(u32, bool), u32>>,
    min_support: u32,
}

impl Gathering {
    fn new(resolved: &Resolved, min_support: u32) -> Self {
        let mut overlaps = vec![FxHashMap::default(); resolved.relation.len as usize];
        for &(front, back, px) in &resolved.relation.edges {
            *overlaps[front as usize].entry(back).or_default() += px;
            *overlaps[back as usize].entry(front).or_default() += px;
        }
        let mut forgiven: FxHashMap<u32, FxHashMap<(u32, bool), u32>> = FxHashMap::default();
        for &(front, back, px) in &resolved.kept.refused {
            forgiven.entry(front).or_default().insert((back, true), px);
            forgiven.entry(back).or_default().insert((front, false), px);
        }
        Self { quotient: Quotient::new(&resolved.kept.graph), overlaps, forgiven, min_support }
    }

    /// Returns the group of each node.
    fn groups(&self) -> Vec<u32> {
        (0..self.overlaps.len() as u32).map(|node| self.quotient.group(node)).collect()
    }

    fn gather(&mut self, nodes: &[u32], apart: impl Fn(u32, u32) -> bool) -> Vec<ObjectPart> {
        // Each part is identified by its first node.
        let mut parts: Vec<Vec<u32>> = Vec::new();
        for &node in nodes {
            let fits = |part: &Vec<u32>| {
                self.may_join(node, part[0]) && !part.iter().any(|&member| apart(member, node))
            };
            match parts.iter().position(fits) {
                Some(index) => {
                    let part = parts[index][0];
                    self.merge_forgiven(part, node);
                    self.quotient.merge(part, node);
                    parts[index].push(node);
                }
                None => parts.push(vec![node]),
            }
        }
        parts.into_iter().map(|nodes| ObjectPart { root: nodes[0], nodes }).collect()
    }

    /// Unites parts of one object whose overlap is tolerated, until no such pair is left that the order and the splits
    /// allow.
    fn unite(
        &mut self,
        parts: &mut Vec<ObjectPart>,
        overlaps: &Overlaps,
        share: impl Fn(&ObjectPart, &ObjectPart) -> f64,
        apart: impl Fn(u32, u32) -> bool,
    ) {
        let is_split =
            |a: &ObjectPart, b: &ObjectPart| a.nodes.iter().any(|&a| b.nodes.iter().any(|&b| apart(a, b)));
        loop {
            let may_unite = |(a, b): &(usize, usize)| {
                let (a, b) = (&parts[*a], &parts[*b]);
                self.forgives_little(b.root, a.root)
                    && !self.quotient.path_through_others(a.root, b.root)
                    && !is_split(a, b)
            };
            let Some((a, b)) = overlaps.pairs(parts, &share).into_iter().find(may_unite) else { return };
            let joining = parts.remove(b);
            self.merge_forgiven(parts[a].root, joining.root);
            self.quotient.merge(parts[a].root, joining.root);
            parts[a].nodes.extend(joining.nodes);
        }
    }

    fn may_join(&self, node: u32, part: u32) -> bool {
        let overlap: u32 = self.overlaps[node as usize]
            .iter()
            .filter(|(other, _)| self.quotient.group(**other) == part)
            .map(|(_, px)| px)
            .sum();
        overlap <= self.min_support
            && self.forgives_little(node, part)
            && !self.quotient.path_through_others(node, part)
    }

    /// Returns true when the forgiven supports that the merge would add up remain contact noise.
    fn forgives_little(&self, node: u32, part: u32) -> bool {
        let (Some(a), Some(b)) = (self.forgiven.get(&node), self.forgiven.get(&part)) else { return true };
        let (small, large) = if a.len() < b.len() { (a, b) } else { (b, a) };
        small.iter().all(|(key, px)| large.get(key).is_none_or(|other| px + other <= self.min_support))
    }

    fn merge_forgiven(&mut self, part: u32, node: u32) {
        let Some(mut moved) = self.forgiven.remove(&node) else { return };
        moved.remove(&(part, true));
        moved.remove(&(part, false));
        if let Some(own) = self.forgiven.get_mut(&part) {
            own.remove(&(node, true));
            own.remove(&(node, false));
        }
        for ((other, front), px) in moved {
            *self.forgiven.entry(part).or_default().entry((other, front)).or_default() += px;
            if let Some(back) = self.forgiven.get_mut(&other) {
                back.remove(&(node, !front));
                *back.entry((part, !front)).or_default() += px;
            }
        }
    }
}

/// Computes the layers of given groups of nodes. `order` is an acyclic part of `relation` whose quotient by
/// the groups is acyclic too; the other edges of the relation either agree with the order or contradict it
/// ([`Layers::against`]).
fn layers_of_groups(
    groups: &[u32],
    relation: &OcclusionGraph,
    order: &OcclusionGraph,
    object_of: impl Fn(u32) -> ObjectId,
) -> Layers {
    let (compact, count) = compact_groups(groups);
    let between = |g: &OcclusionGraph| {
        let edges = g.edges.iter();
        OcclusionGraph::new(count, edges.map(|&(f, b, px)| (compact[f as usize], compact[b as usize], px)))
    };
    let layer = between(order).longest_paths();
    from_layers(&compact, &layer, &between(relation), object_of)
}

/// Builds the elements, in reading order, from groups of nodes with their layers.
pub(super) fn from_layers(
    group_of: &[u32],
    layer_of_group: &[u32],
    relation: &OcclusionGraph,
    object_of: impl Fn(u32) -> ObjectId,
) -> Layers {
    let mut nodes: Vec<Vec<NodeId>> = vec![Vec::new(); layer_of_group.len()];
    for (node, &group) in group_of.iter().enumerate() {
        nodes[group as usize].push(NodeId(node as u32));
    }
    let mut reading: Vec<u32> = (0..layer_of_group.len() as u32).collect();
    reading.sort_by_key(|&g| (layer_of_group[g as usize], nodes[g as usize][0]));
    let mut index = vec![0u32; reading.len()];
    reading.iter().enumerate().for_each(|(i, &g)| index[g as usize] = i as u32);

    let elements: Vec<SortedElement> = reading
        .iter()
        .map(|&g| SortedElement {
            object: object_of(nodes[g as usize][0].0),
            nodes: std::mem::take(&mut nodes[g as usize]),
            visibility_layer: layer_of_group[g as usize],
        })
        .collect();
    let renamed = relation.edges.iter().map(|&(f, b, px)| (index[f as usize], index[b as usize], px));
    let (along, mut against): (Vec<_>, Vec<_>) = renamed.partition(|&(f, b, _)| {
        elements[f as usize].visibility_layer < elements[b as usize].visibility_layer
    });
    against.sort_unstable();
    Layers {
        element_of: group_of.iter().map(|&g| ElementIndex(index[g as usize])).collect(),
        occlusions: OcclusionGraph::new(elements.len() as u32, along),
        elements,
        against,
        tolerated: Vec::new(),
    }
}

/// Renumbers groups to `0..count` in order of first appearance; returns the new numbers and `count`.
pub(super) fn compact_groups(groups: &[u32]) -> (Vec<u32>, u32) {
    let mut names: FxHashMap<u32, u32> = FxHashMap::default();
    let compact = groups
        .iter()
        .map(|g| {
            let next = names.len() as u32;
            *names.entry(*g).or_insert(next)
        })
        .collect();
    (compact, names.len() as u32)
}

impl Layers {
    /// Returns the number of visibility layers.
    pub fn count(&self) -> u32 {
        self.elements.iter().map(|e| e.visibility_layer + 1).max().unwrap_or(0)
    }
}
