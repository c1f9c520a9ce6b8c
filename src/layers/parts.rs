//! Elements: each object's faces and pieces, gathered into as few parts as possible, and the
//! visibility layers that follow.

use std::cmp::Reverse;

use rustc_hash::FxHashMap;

use super::cycles::Resolved;
use super::graph::Graph;
use super::nodes::NodeId;
use super::quotient::Quotient;
use super::view::View;
use super::wishes::Wanted;
use crate::scene::{Model, ObjectId};

/// Faces and pieces of one object that do not occlude each other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    /// The object.
    pub object: ObjectId,
    /// Rising.
    pub nodes: Vec<NodeId>,
    /// Its visibility layer, 0 nearest.
    pub layer: u32,
}

/// The visibility layers of a photo. Elements are in reading order: by layer, then by first node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layers {
    /// By layer, then by first node.
    pub elements: Vec<Element>,
    /// The element of each node.
    pub element_of: Vec<u32>,
    /// Who occludes whom, in the order of the layers: acyclic.
    pub occlusions: Graph,
    /// Occlusions against the order, forgiven or left: `(front, back, px)`, sorted.
    pub against: Vec<(u32, u32, u32)>,
}

/// Gathers the nodes of every object into elements and orders these.
///
/// Objects come by falling number of nodes, then name; nodes by layer, then model order. A node
/// joins the first part of its object that it overlaps in at most `min_support` pixels, to which no
/// path of occlusions leads through others (the quotient stays acyclic), with which it has at
/// most `min_support` forgiven pixels towards any other, and from no face of which it was asked to be
/// apart.
pub fn gather_parts(
    model: &Model,
    view: &View,
    resolved: &Resolved,
    min_support: u32,
    wanted: &Wanted,
) -> Layers {
    let kept = &resolved.kept.graph;
    let layer = kept.longest_paths();
    let face_of = |node: u32| view.items[resolved.nodes.list[node as usize].item as usize].face;
    let object_of = |node: u32| model.face(face_of(node)).object;
    let mut nodes_of: FxHashMap<ObjectId, Vec<u32>> = FxHashMap::default();
    (0..kept.len).for_each(|node| nodes_of.entry(object_of(node)).or_default().push(node));
    let mut objects: Vec<_> = nodes_of.into_iter().collect();
    objects.sort_by_key(|(object, nodes)| (Reverse(nodes.len()), &model.object(*object).name));

    let mut gathering = Gathering::new(resolved, min_support);
    for (_, nodes) in &mut objects {
        nodes.sort_unstable_by_key(|&n| (layer[n as usize], n));
        gathering.gather(nodes, |a, b| wanted.apart(face_of(a), face_of(b)));
    }
    let groups: Vec<u32> = (0..kept.len).map(|n| gathering.quotient.group(n)).collect();
    layers_of_groups(&groups, &resolved.relation, kept, object_of)
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

    fn gather(&mut self, nodes: &[u32], apart: impl Fn(u32, u32) -> bool) {
        // Each begins with the node that names it.
        let mut parts: Vec<Vec<u32>> = Vec::new();
        for &node in nodes {
            let fits = |part: &Vec<u32>| {
                self.may_join(node, part[0]) && !part.iter().any(|&member| apart(member, node))
            };
            match parts.iter().position(fits) {
                Some(place) => {
                    let part = parts[place][0];
                    self.merge_forgiven(part, node);
                    self.quotient.merge(part, node);
                    parts[place].push(node);
                }
                None => parts.push(vec![node]),
            }
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

    /// Forgiven supports add up when nodes merge, but must stay noise.
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

/// The layers of given groups of nodes. `order` is an acyclic part of `relation` whose quotient by
/// the groups is acyclic too; the rest of the relation either agrees with it or is `against` it.
fn layers_of_groups(
    groups: &[u32],
    relation: &Graph,
    order: &Graph,
    object_of: impl Fn(u32) -> ObjectId,
) -> Layers {
    let (compact, count) = compact_groups(groups);
    let between = |g: &Graph| {
        let edges = g.edges.iter();
        Graph::new(count, edges.map(|&(f, b, px)| (compact[f as usize], compact[b as usize], px)))
    };
    let layer = between(order).longest_paths();
    from_layers(&compact, &layer, &between(relation), object_of)
}

/// Elements in reading order from groups of nodes with their layers.
pub(super) fn from_layers(
    group_of: &[u32],
    layer_of_group: &[u32],
    relation: &Graph,
    object_of: impl Fn(u32) -> ObjectId,
) -> Layers {
    let mut nodes: Vec<Vec<NodeId>> = vec![Vec::new(); layer_of_group.len()];
    for (node, &group) in group_of.iter().enumerate() {
        nodes[group as usize].push(NodeId(node as u32));
    }
    let mut reading: Vec<u32> = (0..layer_of_group.len() as u32).collect();
    reading.sort_by_key(|&g| (layer_of_group[g as usize], nodes[g as usize][0]));
    let mut place = vec![0u32; reading.len()];
    reading.iter().enumerate().for_each(|(i, &g)| place[g as usize] = i as u32);

    let elements: Vec<Element> = reading
        .iter()
        .map(|&g| Element {
            object: object_of(nodes[g as usize][0].0),
            nodes: std::mem::take(&mut nodes[g as usize]),
            layer: layer_of_group[g as usize],
        })
        .collect();
    let renamed = relation.edges.iter().map(|&(f, b, px)| (place[f as usize], place[b as usize], px));
    let (along, mut against): (Vec<_>, Vec<_>) =
        renamed.partition(|&(f, b, _)| elements[f as usize].layer < elements[b as usize].layer);
    against.sort_unstable();
    Layers {
        element_of: group_of.iter().map(|&g| place[g as usize]).collect(),
        occlusions: Graph::new(elements.len() as u32, along),
        elements,
        against,
    }
}

/// Renumbers groups `0..count` in order of first appearance.
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
    /// Number of visibility layers.
    pub fn count(&self) -> u32 {
        self.elements.iter().map(|e| e.layer + 1).max().unwrap_or(0)
    }
}
