//! Reads the node hierarchy: the nodes of the scene, and the position of each mesh.

use std::collections::BTreeSet;

use glam::{DAffine3, DMat3, DMat4, DVec3};
use gltf::json::Root;
use rustc_hash::FxHashSet;

use super::accessor::Source;
use super::frames::{MOST_INSTANCES, instances};
use quadratura_base::error::Result;

/// A node of the scene.
pub struct SceneNode {
    /// Its index in the file.
    pub node: usize,
    /// The place of its parent in the list of [`scene_nodes`].
    pub parent: Option<usize>,
    /// The map from its frame to its parent's; finite.
    pub parent_from_node: DAffine3,
}

/// A mesh in the scene.
pub(super) struct PlacedMesh {
    pub node: usize,
    pub mesh: usize,
    /// The transform from the mesh's coordinates to the scene's.
    linear: DMat3,
    translation: DVec3,
}

impl PlacedMesh {
    pub fn apply(&self, position: DVec3) -> DVec3 {
        self.linear * position + self.translation
    }

    /// Returns whether the transform mirrors the mesh, which reverses its winding.
    pub fn is_mirrored(&self) -> bool {
        self.linear.determinant() < 0.0
    }
}

/// Returns all nodes of the scene, parents before children, children in file order. Hidden nodes are left out with all below
/// them, and the coarser copies of nodes in levels of detail; `notes` name them.
///
/// # Errors
/// [`quadratura_base::Error::Input`] with the JSON path when nodes are missing, shared or their own ancestors, or when
/// a transform is not affine.
pub fn scene_nodes(source: &Source, notes: &mut BTreeSet<String>) -> Result<Vec<SceneNode>> {
    let coarser: FxHashSet<usize> =
        source.frames.nodes.iter().flat_map(|frame| frame.coarser_levels()).copied().collect();
    let mut hidden: Vec<String> = Vec::new();
    let mut visited = vec![false; source.root.nodes.len()];
    let mut nodes: Vec<SceneNode> = Vec::new();
    let mut open: Vec<(usize, Option<usize>)> = roots(source)?.into_iter().map(|n| (n, None)).rev().collect();
    while let Some((node, parent)) = open.pop() {
        let place = format!("nodes[{node}]");
        let (Some(described), Some(frame)) = (source.root.nodes.get(node), source.frames.nodes.get(node))
        else {
            return Err(source.error(&place, "this node does not exist"));
        };
        if std::mem::replace(&mut visited[node], true) {
            return Err(source.error(&place, reached_twice(node, parent, &nodes)));
        }
        if coarser.contains(&node) {
            continue;
        }
        if frame.is_hidden() {
            let name = described.name.as_ref().filter(|name| !name.is_empty());
            hidden.push(name.cloned().unwrap_or_else(|| place.clone()));
            continue;
        }
        let map = frame.parent_from_node();
        if !map.is_finite() || map.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
            return Err(source.error(&place, "a transform that is not finite or not affine"));
        }
        let children = described.children.iter().flatten().rev();
        open.extend(children.map(|child| (child.value(), Some(nodes.len()))));
        nodes.push(SceneNode { node, parent, parent_from_node: DAffine3::from_mat4(map) });
    }
    if !hidden.is_empty() {
        let named = hidden.iter().take(NAMED).cloned().collect::<Vec<_>>().join(", ");
        let more = hidden.len().saturating_sub(NAMED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        notes.insert(format!(
            "hidden nodes (KHR_node_visibility) are left out, with everything below them: {named}{more}"
        ));
    }
    Ok(nodes)
}

/// The hidden nodes that a note names.
const NAMED: usize = 5;

/// The most nodes of a cycle that a message names.
const LONGEST_CYCLE: usize = 20;

/// Describes a node that is reached again, from `parent`: spells out the cycle, if it is its own ancestor.
fn reached_twice(node: usize, parent: Option<usize>, nodes: &[SceneNode]) -> String {
    let ancestors = || std::iter::successors(parent, |at| nodes[*at].parent).map(|at| nodes[at].node);
    let mut cycle: Vec<usize> = ancestors().take_while(|ancestor| *ancestor != node).collect();
    if !ancestors().any(|ancestor| ancestor == node) {
        return "this node has two parents".to_owned();
    }
    cycle.reverse();
    let more = if cycle.len() > LONGEST_CYCLE { ", ..." } else { "" };
    let way: String = cycle.iter().take(LONGEST_CYCLE).map(|node| format!(", {node}")).collect();
    format!("this node is its own ancestor: nodes {node}{way}{more}, {node}")
}

/// Returns all meshes of the scene, in the order of [`scene_nodes`], each once for every instance.
///
/// # Errors
/// Those of [`scene_nodes`] and [`instances`]; too many instances; a transform that is not finite.
pub(super) fn placed_meshes(source: &Source, notes: &mut BTreeSet<String>) -> Result<Vec<PlacedMesh>> {
    let nodes = scene_nodes(source, notes)?;
    let mut worlds: Vec<DMat4> = Vec::with_capacity(nodes.len());
    let mut meshes = Vec::new();
    for SceneNode { node, parent, parent_from_node } in nodes {
        let place = format!("nodes[{node}]");
        let world = parent.map_or(DMat4::IDENTITY, |parent| worlds[parent]) * DMat4::from(parent_from_node);
        worlds.push(world);
        let Some(mesh) = source.root.nodes[node].mesh else { continue };
        let maps = instances(source, node)?.unwrap_or_else(|| vec![DAffine3::IDENTITY]);
        if meshes.len() + maps.len() > MOST_INSTANCES {
            return Err(
                source.error(&place, format!("more than {MOST_INSTANCES} meshes and instances up to here"))
            );
        }
        for map in maps {
            let world = world * DMat4::from(map);
            if !world.is_finite() {
                return Err(source.error(&place, "a transform that is not finite or not affine"));
            }
            let (linear, translation) = (DMat3::from_mat4(world), world.w_axis.truncate());
            meshes.push(PlacedMesh { node, mesh: mesh.value(), linear, translation });
        }
    }
    Ok(meshes)
}

/// Returns the nodes of the default scene; of the first scene, if none is the default; if there are no
/// scenes, the nodes without parents.
fn roots(source: &Source) -> Result<Vec<usize>> {
    let root = &source.root;
    let index = root.scene.map_or(0, |scene| scene.value());
    match root.scenes.get(index) {
        Some(scene) => Ok(scene.nodes.iter().map(|node| node.value()).collect()),
        None if root.scenes.is_empty() => Ok(orphans(root)),
        None => Err(source.error("scene", format!("scene {index} of {}", root.scenes.len()))),
    }
}

fn orphans(root: &Root) -> Vec<usize> {
    let mut has_parent = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        if let Some(slot) = has_parent.get_mut(child.value()) {
            *slot = true;
        }
    }
    (0..root.nodes.len()).filter(|&node| !has_parent[node]).collect()
}
