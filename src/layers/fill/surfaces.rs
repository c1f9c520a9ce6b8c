//! The planar surfaces of a model, the units of filling.

use glam::DVec3;

use quadratura_base::geometry::Plane;
use quadratura_base::geometry::polygon::fit_plane;
use quadratura_base::scene::builder::says_backdrop;
use quadratura_base::scene::{FaceId, Model};

/// The index of a surface in [`FillSurfaces`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FillSurfaceId(pub u32);

impl FillSurfaceId {
    /// Stands for the surroundings in regions. [`FillSurfaces`] does not have it.
    pub const SURROUNDINGS: Self = Self(u32::MAX);
}

/// A planar face, or one triangle of a face that is not planar.
#[derive(Debug, Clone, PartialEq)]
pub struct FillSurface {
    /// The face that the surface belongs to.
    pub face: FaceId,
    /// The index of the triangle within the face when the face is not planar; `None` for a planar face.
    pub triangle: Option<u32>,
    /// The plane, in world coordinates.
    pub plane: Plane,
    /// The outline as one ring in world coordinates; holes are bridged.
    pub outline: Vec<DVec3>,
    /// True for a flat stand-in for foliage and the like, and for what was declared see-through; the background seen
    /// through it depends on the viewpoint.
    pub billboard: bool,
    /// True for a backdrop, which is behind everything else.
    pub backdrop: bool,
}

/// The surfaces of a model, in the order of its faces.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FillSurfaces {
    list: Vec<FillSurface>,
    /// The index of each face's first surface.
    first: Vec<u32>,
}

impl FillSurfaces {
    /// Lists the surfaces of a model (in world coordinates). Those of impostors have the rectangle that faces a camera of no
    /// photo; each donor sees it turned towards itself ([`super::Donor::pose_on`]).
    pub fn from_model(model: &Model) -> Self {
        let mut surfaces = Self::default();
        for face in model.face_ids() {
            surfaces.first.push(surfaces.list.len() as u32);
            let plane = model.face(face).plane;
            let object = model.object(model.face(face).object);
            let (billboard, backdrop) = (object.shows_what_is_behind(), says_backdrop(&object.name));
            if let Some(impostor) = model.impostor(face) {
                let rest = impostor.at_rest();
                let (plane, outline) = (impostor.plane(&rest), impostor.corners(&rest).to_vec());
                surfaces.list.push(FillSurface { face, triangle: None, plane, outline, billboard, backdrop });
                continue;
            }
            if model.face(face).planar {
                let outline = model.ring_points(face).collect();
                surfaces.list.push(FillSurface { face, triangle: None, plane, outline, billboard, backdrop });
                continue;
            }
            for (t, corners) in (0..).zip(model.face_triangles(face)) {
                let outline = corners.map(|v| model.vertices[v as usize]).to_vec();
                let plane = fit_plane(&outline).unwrap_or(plane);
                surfaces.list.push(FillSurface {
                    face,
                    triangle: Some(t),
                    plane,
                    outline,
                    billboard,
                    backdrop,
                });
            }
        }
        surfaces
    }

    /// Returns the number of surfaces.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Returns true when there is no surface.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Returns the surface with this id.
    pub fn get(&self, id: FillSurfaceId) -> &FillSurface {
        &self.list[id.0 as usize]
    }

    /// Returns the surface of a planar face, or of one triangle of a face; the face must have it (see
    /// [`Self::find`]).
    pub fn id(&self, face: FaceId, triangle: Option<u32>) -> FillSurfaceId {
        FillSurfaceId(self.first[face.0 as usize] + triangle.unwrap_or(0))
    }

    /// Returns true when a face is one surface, not one per triangle.
    pub fn is_flat(&self, face: FaceId) -> bool {
        self.list
            .get(self.first[face.0 as usize] as usize)
            .is_some_and(|first| first.face == face && first.triangle.is_none())
    }

    /// Returns all surfaces of the face that a surface belongs to.
    pub fn of_same_face(&self, id: FillSurfaceId) -> impl Iterator<Item = FillSurfaceId> + '_ {
        let face = self.get(id).face;
        let first = self.first[face.0 as usize];
        (first..)
            .map(FillSurfaceId)
            .take_while(move |id| self.list.get(id.0 as usize).is_some_and(|s| s.face == face))
    }

    /// Returns the surface of a face or of one of its triangles; `None` when the face has no such triangle,
    /// or is planar when it should not be (or the reverse).
    pub fn find(&self, face: FaceId, triangle: Option<u32>) -> Option<FillSurfaceId> {
        let id = self.id(face, triangle);
        let surface = self.list.get(id.0 as usize)?;
        (surface.face == face && surface.triangle == triangle).then_some(id)
    }

    /// Returns the surface of a face that a polygon (world coordinates) lies on: the one whose plane and
    /// centroid are nearest to it.
    pub fn nearest_to_polygon(&self, face: FaceId, polygon: &[DVec3]) -> FillSurfaceId {
        let mean = |ring: &[DVec3]| ring.iter().sum::<DVec3>() / ring.len() as f64;
        let middle = mean(polygon);
        let far = |surface: &FillSurface| {
            let off = polygon.iter().map(|p| surface.plane.signed_distance(*p).abs()).fold(0.0, f64::max);
            // The plane decides; the centroid distinguishes triangles of one plane.
            1e3 * off + mean(&surface.outline).distance(middle)
        };
        let first = self.first[face.0 as usize];
        let of_face = self.list[first as usize..].iter().take_while(|surface| surface.face == face);
        let nearest = (first..).zip(of_face).min_by(|a, b| far(a.1).total_cmp(&far(b.1)));
        FillSurfaceId(nearest.map_or(first, |(id, _)| id))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::closed_form;

    #[test]
    fn a_bent_face_has_a_surface_a_triangle_and_its_pieces_find_theirs() {
        let scene = closed_form::bent_quad();
        let surfaces = FillSurfaces::from_model(&scene.model);
        let bent = scene.model.face_ids().find(|face| !scene.model.face(*face).planar).unwrap();
        for (t, _) in (0..).zip(scene.model.face_triangles(bent)) {
            let id = surfaces.id(bent, Some(t));
            let corners = surfaces.get(id).outline.clone();
            let middle = corners.iter().sum::<DVec3>() / 3.0;
            let inner: Vec<DVec3> = corners.iter().map(|p| middle + (*p - middle) * 0.3).collect();
            assert_eq!(surfaces.nearest_to_polygon(bent, &inner), id);
            assert_eq!(surfaces.find(bent, Some(t)), Some(id));
        }
        assert_eq!((surfaces.find(bent, None), surfaces.find(bent, Some(99))), (None, None));
    }
}
