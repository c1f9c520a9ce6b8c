//! The polygons in space of the pieces into which the sort cut faces.

use glam::DVec3;

use super::nodes::{CutSide, GraphNode, Nodes};
use super::projected_model::ProjectedModel;
use super::tolerated::Overlap;
use quadratura_base::geometry::polygon::{fit_plane, split_by_plane, triangulate};
use quadratura_base::geometry::{Plane, Pose};
use quadratura_base::scene::{FaceId, Model};

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
/// node order; `None` for whole faces. Where a node is behind another one of its own element (`tolerated`), it has no
/// piece.
pub fn pieces_of_nodes(
    model: &Model,
    view: &ProjectedModel,
    nodes: &Nodes,
    tolerated: &[Overlap],
    pose: &Pose,
) -> Vec<Option<NodePieces>> {
    let eye = pose.center_in_world();
    let mut last: Option<(FaceId, u32)> = None;
    nodes
        .list
        .iter()
        .zip(0u32..)
        .map(|(node, index)| {
            let item = &view.items[node.item as usize];
            let fronts: Vec<&GraphNode> = tolerated
                .iter()
                .filter(|overlap| overlap.back == index)
                .map(|overlap| &nodes.list[overlap.front as usize])
                .collect();
            if node.sides.is_empty() && item.triangle.is_none() && fronts.is_empty() {
                return None;
            }
            let first = last.filter(|l| l.0 == item.face).map_or(0, |l| l.1);
            let whole = rings_of(model, view, node, eye);
            let in_sight = fronts.iter().fold(whole.clone(), |rings, front| {
                not_behind(rings, &rings_of(model, view, front, eye), eye)
            });
            // Rounding may leave nothing of a sliver.
            let rings = if in_sight.is_empty() { whole } else { in_sight };
            last = Some((item.face, first + rings.len() as u32));
            Some(NodePieces { face: item.face, first, rings })
        })
        .collect()
}

fn rings_of(model: &Model, view: &ProjectedModel, node: &GraphNode, eye: DVec3) -> Vec<Vec<DVec3>> {
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

/// Returns the parts of planar rings that are not behind the rings of a nearer surface, as seen from `eye`.
fn not_behind(rings: Vec<Vec<DVec3>>, nearer: &[Vec<DVec3>], eye: DVec3) -> Vec<Vec<DVec3>> {
    nearer.iter().filter_map(|ring| Some((ring, fit_plane(ring)?))).fold(rings, |rings, (ring, plane)| {
        let found = triangulate(ring, &plane);
        let points = [&ring[..], &found.crossings[..]].concat();
        let triangles = found.triangles.iter().map(|triangle| triangle.map(|corner| points[corner as usize]));
        triangles.fold(rings, |rings, triangle| outside_shadow(rings, triangle, &plane, eye))
    })
}

/// Returns the parts of planar rings that are outside the shadow of a triangle, of this plane, for a light at `eye`.
fn outside_shadow(
    rings: Vec<Vec<DVec3>>,
    triangle: [DVec3; 3],
    plane: &Plane,
    eye: DVec3,
) -> Vec<Vec<DVec3>> {
    let middle = triangle.iter().sum::<DVec3>() / 3.0;
    let edge = |[a, b]: [DVec3; 2]| {
        let normal = (a - eye).cross(b - eye).try_normalize()?;
        let normal = if normal.dot(middle - eye) < 0.0 { -normal } else { normal };
        Some(Plane { normal, point: eye })
    };
    let [a, b, c] = triangle;
    let Some(edges) = [[a, b], [b, c], [c, a]].into_iter().map(edge).collect::<Option<Vec<_>>>() else {
        // Seen edge-on, it casts no shadow.
        return rings;
    };
    let beyond = if plane.signed_distance(eye) > 0.0 { -plane.normal } else { plane.normal };
    let sides = edges.into_iter().chain([Plane { normal: beyond, ..*plane }]);
    let mut outside = Vec::new();
    let mut inside = rings.clone();
    for side in sides {
        let (kept, left): (Vec<_>, Vec<_>) = inside.iter().map(|ring| split_by_plane(ring, &side)).unzip();
        (inside, outside) = (kept.concat(), [outside, left.concat()].concat());
    }
    // What no shadow falls on stays in one piece.
    if inside.is_empty() { rings } else { outside }
}

/// Returns the outline of an item, in world coordinates.
pub fn outline(model: &Model, view: &ProjectedModel, item: u32) -> Vec<DVec3> {
    let item = &view.items[item as usize];
    match item.triangle {
        None => model.ring_points(item.face).collect(),
        Some(t) => model.face_triangles(item.face)[t as usize].map(|v| model.vertices[v as usize]).to_vec(),
    }
}

fn plane_of(model: &Model, view: &ProjectedModel, item: u32) -> Plane {
    let face = view.items[item as usize].face;
    match view.items[item as usize].triangle {
        None => model.face(face).plane,
        Some(_) => fit_plane(&outline(model, view, item)).unwrap_or(model.face(face).plane),
    }
}
