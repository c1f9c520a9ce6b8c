//! Edges of the faces' outlines, collected once, because they are drawn in every frame.

use std::ops::Range;

use rustc_hash::FxHashSet;

use super::model::{FaceId, Model};

/// The edges of a model's outlines, as pairs of indices into its vertices.
#[derive(Debug, Clone, Default)]
pub struct Edges {
    /// The outlines' edges by face, in their direction, without the bridges to holes, which run along the same edge
    /// twice.
    edges: Vec<[u32; 2]>,
    of_face: Vec<Range<u32>>,
    /// Each edge once, no matter how many faces share it, with the smaller index first, sorted; without those of
    /// impostors, in whose place there is a rectangle that turns.
    all: Vec<[u32; 2]>,
}

impl Edges {
    /// Collects the edges of all faces of a model.
    pub fn from_model(model: &Model) -> Self {
        let (mut edges, mut of_face) = (Vec::new(), Vec::with_capacity(model.faces.len()));
        let mut all: Vec<[u32; 2]> = Vec::new();
        for face in model.face_ids() {
            let first = edges.len();
            edges.extend(of_outline(model.ring(face)));
            of_face.push(first as u32..edges.len() as u32);
            if model.impostor(face).is_none() {
                all.extend(edges[first..].iter().map(|&[a, b]| [a.min(b), a.max(b)]));
            }
        }
        all.sort_unstable();
        all.dedup();
        Self { edges, of_face, all }
    }

    /// Returns the edges of one face.
    pub fn of_face(&self, face: FaceId) -> &[[u32; 2]] {
        let range = self.of_face.get(face.0 as usize).cloned().unwrap_or_default();
        &self.edges[range.start as usize..range.end as usize]
    }

    /// Returns each edge of the model once, without those of impostors.
    pub fn all(&self) -> &[[u32; 2]] {
        &self.all
    }
}

/// Returns the edges of a ring without bridges.
fn of_outline(ring: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
    let edges = (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]]);
    let directed: FxHashSet<[u32; 2]> = edges.clone().collect();
    edges.filter(move |&[a, b]| a != b && !directed.contains(&[b, a]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::synthetic::closed_form;

    #[test]
    fn bridges_to_holes_are_no_edges() {
        // A square, a bridge to a triangle in it, and back.
        let ring = [0, 1, 2, 3, 0, 4, 5, 6, 4];
        let edges: Vec<_> = of_outline(&ring).collect();
        assert_eq!(edges, [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 4]]);
    }

    #[test]
    fn an_edge_that_faces_share_is_there_once() {
        let model = closed_form::two_quads().model;
        let edges = Edges::from_model(&model);
        assert_eq!(edges.all().len(), 8);
        assert!(model.face_ids().all(|face| edges.of_face(face).len() == 4));
        assert!(edges.all().is_sorted() && edges.of_face(FaceId(99)).is_empty());
    }
}
