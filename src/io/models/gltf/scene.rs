//! Reads the node hierarchy: the position and name of each mesh.

use glam::{DMat3, DMat4, DQuat, DVec3};
use gltf::json::Root;
use serde::Deserialize;

use super::accessor::Source;
use crate::error::Result;

/// The nodes' transforms in 64 bits: the gltf crate reads them in 32, which shifts a site in map coordinates
/// by half a metre.
#[derive(Deserialize)]
pub(super) struct NodeTransforms {
    #[serde(default)]
    nodes: Vec<Frame>,
}

#[derive(Deserialize)]
struct Frame {
    #[serde(default)]
    matrix: Option<[f64; 16]>,
    #[serde(default = "zeros")]
    translation: [f64; 3],
    #[serde(default = "unturned")]
    rotation: [f64; 4],
    #[serde(default = "ones")]
    scale: [f64; 3],
}

fn zeros() -> [f64; 3] {
    [0.0; 3]
}

fn ones() -> [f64; 3] {
    [1.0; 3]
}

fn unturned() -> [f64; 4] {
    DQuat::IDENTITY.to_array()
}

impl Frame {
    fn matrix(&self) -> DMat4 {
        let from_parts = || {
            let rotation = DQuat::from_array(self.rotation).normalize();
            DMat4::from_scale_rotation_translation(self.scale.into(), rotation, self.translation.into())
        };
        self.matrix.as_ref().map_or_else(from_parts, DMat4::from_cols_array)
    }
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

/// Returns all meshes of the scene, parents before children, children in file order.
///
/// # Errors
/// [`crate::Error::Input`] with the JSON path when nodes are missing, shared or their own ancestors, or when
/// a transform is not affine.
pub(super) fn placed_meshes(source: &Source, frames: &NodeTransforms) -> Result<Vec<PlacedMesh>> {
    let root = source.root;
    let mut visited = vec![false; root.nodes.len()];
    let mut meshes = Vec::new();
    let mut open: Vec<(usize, DMat4)> =
        roots(source)?.into_iter().map(|n| (n, DMat4::IDENTITY)).rev().collect();
    while let Some((node, parent)) = open.pop() {
        let place = format!("nodes[{node}]");
        let (Some(described), Some(frame)) = (root.nodes.get(node), frames.nodes.get(node)) else {
            return Err(source.error(&place, "this node does not exist"));
        };
        if std::mem::replace(&mut visited[node], true) {
            return Err(source.error(&place, "this node has two parents or is its own ancestor"));
        }
        let world = parent * frame.matrix();
        if !world.is_finite() || world.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
            return Err(source.error(&place, "a transform that is not finite or not affine"));
        }
        if let Some(mesh) = described.mesh {
            let (linear, translation) = (DMat3::from_mat4(world), world.w_axis.truncate());
            meshes.push(PlacedMesh { node, mesh: mesh.value(), linear, translation });
        }
        open.extend(described.children.iter().flatten().rev().map(|child| (child.value(), world)));
    }
    Ok(meshes)
}

/// Returns the nodes of the default scene; of the first scene, if none is the default; if there are no
/// scenes, the nodes without parents.
fn roots(source: &Source) -> Result<Vec<usize>> {
    let root = source.root;
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
