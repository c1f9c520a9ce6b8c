//! The see-through surfaces of a site, piece by piece: the rectangles of impostors, and the planar faces of other objects.

use std::sync::Arc;

use glam::DVec2;

use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::raster::robust::median;
use quadratura_base::scene::impostor::Impostor;
use quadratura_base::scene::{FaceId, Model, ObjectId, Photo};
use quadratura_layers::fill::{FillSurfaceId, FillSurfaces};
use quadratura_layers::matte::{FaceGrid, SeenImpostor, SeenPiece};

/// A see-through surface: an impostor, a planar face of another object, or a triangle of a face that is not planar.
#[derive(Debug, Clone)]
pub struct SeeThroughPiece {
    /// The object that it belongs to.
    pub object: ObjectId,
    /// The surface.
    pub surface: FillSurfaceId,
    /// The surface's face.
    pub face: FaceId,
    /// The triangle of a face that is not planar.
    pub triangle: Option<u32>,
    /// The name by which its mattes are kept.
    pub name: String,
    shape: PieceShape,
}

#[derive(Debug, Clone)]
enum PieceShape {
    Turning(Impostor),
    Face(Arc<FaceGrid>),
}

impl SeeThroughPiece {
    /// Returns the pieces of a model in the order of its faces; `photos` are those that may show them.
    pub fn of_model(model: &Model, surfaces: &FillSurfaces, photos: &[Photo]) -> Vec<Self> {
        let faces = model.see_through_surfaces();
        faces.flat_map(|face| Self::of_face(model, surfaces, photos, face)).collect()
    }

    fn of_face(model: &Model, surfaces: &FillSurfaces, photos: &[Photo], face: FaceId) -> Vec<Self> {
        // A face without area has no surface that photos could show.
        let triangles = model.face_triangles(face).len() as u32;
        let parts: Vec<Option<u32>> = match surfaces.is_flat(face) {
            true => vec![None],
            false => (0..triangles).map(Some).collect(),
        };
        let object = model.face(face).object;
        let piece = |triangle: Option<u32>| {
            let surface = surfaces.id(face, triangle);
            let (shape, name) = match model.impostor(face) {
                Some(impostor) => (PieceShape::Turning(*impostor), model.object(object).name.clone()),
                None => {
                    let of_triangle = triangle.map_or(String::new(), |triangle| format!(".{triangle}"));
                    (PieceShape::Face(grid(surfaces, surface, photos)), model.face_name(face) + &of_triangle)
                }
            };
            Self { object, surface, face, triangle, name, shape }
        };
        parts.into_iter().map(piece).collect()
    }

    /// Returns the piece as a camera sees it.
    pub fn seen(&self, camera: &Pinhole, pose: &Pose) -> SeenPiece {
        match &self.shape {
            PieceShape::Turning(impostor) => SeenPiece::Turning(SeenImpostor::new(impostor, camera, pose)),
            PieceShape::Face(grid) => SeenPiece::Face { grid: grid.clone(), camera: *camera, pose: *pose },
        }
    }

    /// Returns whether both are likely to have the same colours: those of one object, and all impostors, which are plants as a
    /// rule.
    pub fn is_like(&self, other: &Self) -> bool {
        let turns = |piece: &Self| matches!(piece.shape, PieceShape::Turning(_));
        self.object == other.object || (turns(self) && turns(other))
    }
}

/// Lays a grid over a surface, as fine as half of the photos see it.
fn grid(surfaces: &FillSurfaces, surface: FillSurfaceId, photos: &[Photo]) -> Arc<FaceGrid> {
    let surface = surfaces.get(surface);
    let length = |photo: &Photo| {
        let image =
            |point: &glam::DVec3| photo.camera.image_from_camera(photo.pose.camera_from_world(*point));
        let corners: Vec<DVec2> = surface.outline.iter().map(image).collect::<Option<_>>()?;
        let low = corners.iter().copied().reduce(DVec2::min)?;
        let high = corners.iter().copied().reduce(DVec2::max)?;
        let frame = DVec2::new(f64::from(photo.camera.width), f64::from(photo.camera.height));
        let shows = low.cmplt(frame).all() && high.cmpgt(DVec2::ZERO).all();
        shows.then(|| (high - low).max_element())
    };
    let mut lengths: Vec<f64> = photos.iter().filter_map(length).collect();
    Arc::new(FaceGrid::new(&surface.plane, &surface.outline, median(&mut lengths).unwrap_or(1.0)))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use quadratura_base::scene::synthetic::Modeller;

    #[test]
    fn impostors_are_one_piece_and_other_objects_one_a_face() {
        let mut m = Modeller::new();
        m.object("tree").quad(DVec3::ZERO, DVec3::X, DVec3::Z).quad(DVec3::ZERO, DVec3::Y, DVec3::Z);
        m.object("fence").quad(DVec3::X, DVec3::Y, DVec3::Z).quad(DVec3::X + DVec3::Y, DVec3::X, DVec3::Z);
        m.object("wall").quad(DVec3::Y, DVec3::X, DVec3::Z);
        let (model, _) = (*m.finish()).clone().with_impostors(DVec3::Z, |object| object.name == "tree");
        let model = model.with_see_through(|object| object.name != "wall");
        let pieces = SeeThroughPiece::of_model(&model, &FillSurfaces::from_model(&model), &[]);
        let names: Vec<&str> = pieces.iter().map(|piece| &piece.name[..]).collect();
        assert_eq!(names, ["tree", "fence[0]", "fence[1]"]);
        assert!(pieces[1].is_like(&pieces[2]) && !pieces[0].is_like(&pieces[1]));
    }
}
