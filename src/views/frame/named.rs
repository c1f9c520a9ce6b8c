//! Faces by the names that are typed for them.

use glam::DVec3;

use quadratura_base::error::Result;
use quadratura_base::geometry::triangle;
use quadratura_base::scene::{FaceId, Model};
use quadratura_sites::named::objects_named;
use quadratura_stacks::decide::faces_named as parts_named;

/// Returns the faces that a name refers to: an object, or objects by a pattern in which `*` stands for any characters; or faces of one as
/// `OBJECT[3, 5-8]`.
///
/// # Errors
/// Returns [`quadratura_base::error::Error::Request`] when there are none.
pub fn faces_named(model: &Model, typed: &str) -> Result<Vec<FaceId>> {
    if model.object_like(typed).is_none() && typed.ends_with(']') {
        let parts = parts_named(model, None, typed)?;
        let index = |part: &quadratura_layers::Faces| {
            let object = part.object.clone();
            part.faces.iter().map(move |index| (object.clone(), *index)).collect::<Vec<_>>()
        };
        let ids = parts.iter().flat_map(index).map(|(object, index)| {
            model.face_named(&object, index).ok_or_else(|| {
                // Says how many faces the object has.
                let missing = quadratura_stacks::survey::face_named(model, &format!("{object}[{index}]"));
                missing.expect_err("the model lacks the face")
            })
        });
        return ids.collect();
    }
    let objects = objects_named(model, typed)?;
    Ok(objects.into_iter().flat_map(|object| model.object(object).faces.iter().copied()).collect())
}

/// Returns the normal of a face, as its outline says, with the area as its length.
pub fn area_vector(model: &Model, face: FaceId) -> DVec3 {
    let corners = |triangle: &[u32; 3]| triangle.map(|vertex| model.vertices[vertex as usize]);
    let twice = model.face_triangles(face).iter().map(|it| triangle::area_vector(&corners(it)));
    0.5 * twice.sum::<DVec3>()
}
