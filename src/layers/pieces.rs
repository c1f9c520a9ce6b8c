//! The polygons in space of the pieces into which the sort cut faces.

use glam::DVec3;

use super::nodes::{CutSide, Node, Nodes};
use super::view::View;
use crate::geometry::polygon::{fit_plane, split_by_plane};
use crate::geometry::{Plane, Pose};
use crate::scene::{FaceId, Model};

/// The polygons of one node that is not a whole face: several where a cut takes the face apart.
#[derive(Debug, Clone, PartialEq)]
pub struct NodePieces {
    /// The face that the pieces belong to.
    pub face: FaceId,
    /// The index of the first ring among all pieces of the face.
    pub first: u32,
    /// Simple rings in world coordinates, wound like the face; holes are bridged.
    pub rings: Vec<Vec<DVec3>>,
}

/// Computes the pieces of every node that is not a whole face, numbered consecutively through each face in
/// node order; `None` for whole faces.
pub fn pieces_of_nodes(model: &Model, view: &View, nodes: &Nodes, pose: &Pose) -> Vec<Option<NodePieces>> {
    let eye = pose.center_in_world();
    let mut last: Option<(FaceId, u32)> = None;
    nodes
        .list
        .iter()
        .map(|node| {
            let item = &view.items[node.item as usize];
            if node.sides.is_empty() && item.triangle.is_none() {
                return None;
            }
            let first = last.filter(|l| l.0 == item.face).map_or(0, |l| l.1);
            let rings = rings_of(model, view, node, eye);
            last = Some((item.face, first + rings.len() as u32));
            Some(NodePieces { face: item.face, first, rings })
        })
        .collect()
}

fn rings_of(model: &Model, view: &View, node: &Node, eye: DVec3) -> Vec<Vec<DVec3>> {
    let whole = vec![outline(model, view, node.item)];
    node.sides.iter().fold(whole, |rings, side| {
        let plane = plane_of(model, view, side.plane);
        rings.iter().flat_map(|ring| side_of(ring, &plane, side, eye)).collect()
    })
}

fn side_of(ring: &[DVec3], plane: &Plane, side: &CutSide, eye: DVec3) -> Vec<Vec<DVec3>> {
    let (positive, negative) = split_by_plane(ring, plane);
    if (plane.signed_distance(eye) > 0.0) == side.near { positive } else { negative }
}

/// Returns the outline of an item, in world coordinates.
pub fn outline(model: &Model, view: &View, item: u32) -> Vec<DVec3> {
    let item = &view.items[item as usize];
    match item.triangle {
        None => model.ring_points(item.face).collect(),
        Some(t) => model.face_triangles(item.face)[t as usize].map(|v| model.vertices[v as usize]).to_vec(),
    }
}

fn plane_of(model: &Model, view: &View, item: u32) -> Plane {
    let face = view.items[item as usize].face;
    match view.items[item as usize].triangle {
        None => model.face(face).plane,
        Some(_) => fit_plane(&outline(model, view, item)).unwrap_or(model.face(face).plane),
    }
}
