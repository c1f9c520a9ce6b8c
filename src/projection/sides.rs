//! The back sides of faces. Models of sites are open: a wall is modelled and photographed from one side only,
//! and seen from the other side it would only hide what is behind it.

use super::Sources;
use quadratura_base::scene::{FaceId, Model};

/// A side of a face relative to its plane's normal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The side that the normal points towards.
    Front,
    /// The side that the normal points away from.
    Back,
}

/// The back sides of faces: those that no photo textures. Where no photo textures a face at all, the side
/// that the normal points away from is its back, so that missing coverage of the other side remains visible.
/// Billboards have no backs, because photos texture both of their sides.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct BackSides {
    /// Per face, whether its front and its back are back sides.
    backs: Vec<[bool; 2]>,
    /// Per face, whether no photo textures it.
    uncovered: Vec<bool>,
}

impl BackSides {
    /// Finds the back sides of a model's faces from the photos that texture them.
    pub fn new(model: &Model, sources: &Sources) -> Self {
        let backs = |face: FaceId| {
            if model.object(model.face(face).object).billboard {
                return [false; 2];
            }
            let serves = |back: bool| sources.servers_of(face).iter().any(|server| server.back == back);
            match [serves(false), serves(true)] {
                [false, false] => [false, true],
                [front, back] => [!front, !back],
            }
        };
        let uncovered = {
            let is_bare = |face| sources.servers_of(face).is_empty() && !model.is_replaced(face);
            model.face_ids().map(is_bare).collect()
        };
        Self { backs: model.face_ids().map(backs).collect(), uncovered }
    }

    /// Returns true when a side of a face is a back side.
    pub fn is_back(&self, face: FaceId, side: Side) -> bool {
        let of_face = self.backs.get(face.0 as usize).copied().unwrap_or_default();
        of_face[usize::from(side == Side::Back)]
    }
}

impl BackSides {
    /// Returns the faces that no photo textures; none where it is not known which photos do.
    pub fn uncovered(&self) -> impl Iterator<Item = FaceId> {
        self.uncovered.iter().zip(0..).filter(|(uncovered, _)| **uncovered).map(|(_, face)| FaceId(face))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Domain, LayerTextureId, Server};
    use quadratura_base::scene::PhotoId;
    use quadratura_base::scene::synthetic::Modeller;

    #[test]
    fn a_side_that_no_photo_serves_is_a_back_and_of_a_face_without_photos_the_one_behind_its_normal() {
        let mut m = Modeller::new();
        for name in ["from the front", "from behind", "from both", "never"] {
            m.object(name).screen(5.0, [-1.0, -1.0, 1.0, 1.0]);
        }
        let model = m.finish();
        let server = |back| Server {
            layer_texture: LayerTextureId(0),
            photo: PhotoId(0),
            back,
            pinned: false,
            domain: Domain::Whole,
        };
        let servers = vec![server(false), server(true), server(false), server(true)];
        let sources = Sources { servers, of_face: vec![0..1, 1..2, 2..4, 4..4], ..Sources::default() };
        let sides = BackSides::new(&model, &sources);
        let backs = |face| [Side::Front, Side::Back].map(|side| sides.is_back(FaceId(face), side));
        assert_eq!([0, 1, 2, 3].map(backs), [[false, true], [true, false], [false, false], [false, true]]);
        assert_eq!(sides.uncovered().collect::<Vec<_>>(), [FaceId(3)]);
    }
}
