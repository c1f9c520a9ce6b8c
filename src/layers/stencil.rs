//! Visibility layers from stencil peeling: the method of 2003 as it was published, with its contradictions
//! counted.

use rustc_hash::FxHashMap;

use super::constraints::ResolvedConstraints;
use super::occlusion_graph::OcclusionGraph;
use super::parts::{Layers, compact_groups, from_layers};
use super::projected_model::ProjectedModel;
use super::rasteriser::{Occlusion, StencilLayers};
use quadratura_base::scene::Model;

/// Builds the layers that stencil peeling leads to. Faces of an object that share a layer and overlap in at
/// most `min_support` pixels make one element, unless a split keeps them apart; nothing is cut and nothing
/// forgiven. Occlusions that contradict the layers are in [`Layers::against`]. Nodes are the items of the
/// working set, in model order.
pub fn layers_of_stencil(
    model: &Model,
    view: &ProjectedModel,
    items: &[u32],
    peeled: &StencilLayers,
    occlusions: &[Occlusion],
    min_support: u32,
    wanted: &ResolvedConstraints,
) -> Layers {
    let node_of = |item: u32| items.binary_search(&item).ok().map(|n| n as u32);
    let relation = OcclusionGraph::new(
        items.len() as u32,
        occlusions.iter().filter_map(|o| Some((node_of(o.front)?, node_of(o.back)?, o.px))),
    );
    let mut overlaps: FxHashMap<(u32, u32), u32> = FxHashMap::default();
    for &(front, back, px) in &relation.edges {
        *overlaps.entry((front.min(back), front.max(back))).or_default() += px;
    }
    let face_of = |node: u32| view.items[items[node as usize] as usize].face;
    let object_of = |node: u32| model.face(face_of(node)).object;
    let layer_of = |node: u32| peeled.layer[items[node as usize] as usize].unwrap_or(0);

    let mut groups: Vec<Vec<u32>> = Vec::new();
    let mut groups_of: FxHashMap<(u32, u32), Vec<u32>> = FxHashMap::default();
    let mut group_of = vec![0u32; items.len()];
    for node in 0..items.len() as u32 {
        let candidates = groups_of.entry((object_of(node).0, layer_of(node))).or_default();
        let fits = |g: &&u32| {
            let group = &groups[**g as usize];
            let pairs = group.iter().filter_map(|&n| overlaps.get(&(n, node)));
            let apart = group.iter().any(|&n| wanted.apart(face_of(n), face_of(node)));
            pairs.sum::<u32>() <= min_support && !apart
        };
        let group = match candidates.iter().find(fits) {
            Some(&group) => group,
            None => {
                candidates.push(groups.len() as u32);
                groups.push(Vec::new());
                groups.len() as u32 - 1
            }
        };
        groups[group as usize].push(node);
        group_of[node as usize] = group;
    }
    let (compact, count) = compact_groups(&group_of);
    let mut layer_of_group = vec![0; count as usize];
    for (node, &group) in compact.iter().enumerate() {
        layer_of_group[group as usize] = layer_of(node as u32);
    }
    let edges = relation.edges.iter();
    let between =
        OcclusionGraph::new(count, edges.map(|&(f, b, px)| (compact[f as usize], compact[b as usize], px)));
    from_layers(&compact, &layer_of_group, &between, object_of)
}
