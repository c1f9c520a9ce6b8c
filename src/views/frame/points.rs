//! Points of the site by the names that are typed for them: corners of faces, pixels of photos, sparse points, and coordinates.

use glam::{DVec2, DVec3};

use quadratura_base::error::{Error, Result};
use quadratura_projection::model_surface::ModelSurface;
use quadratura_sites::named::index_of_photo;
use quadratura_sites::open::Opened;
use quadratura_stacks::survey::face_named;

/// How points are written, for help and messages.
pub const FORMS: &str = "OBJECT[FACE]:CORNER for a corner of a face, both counted from 0; PHOTO:X,Y for what a pixel of a photo shows of \
                         the model; point:PHOTO:X,Y for the sparse point that the photo observes nearest to the pixel; or X,Y,Z in the \
                         cameras' world";

/// The largest distance of a sparse point's observation from the pixel that names it, in pixels.
const NEAR_PX: f64 = 8.0;

/// The beginning of names of sparse points.
const SPARSE: &str = "point:";

/// Returns the position in the cameras' world of the point that is named ([`FORMS`]).
///
/// # Errors
/// Returns [`Error::Request`] for a name of none of these forms, for objects, faces, corners and photos that do not exist, for a pixel
/// outside of its photo or where it shows no surface, and where no sparse point is near.
pub fn point_named(opened: &Opened, typed: &str) -> Result<DVec3> {
    if let Some(position) = numbers::<3>(typed) {
        return Ok(DVec3::from_array(position));
    }
    if let Some((photo, px)) = typed.strip_prefix(SPARSE).and_then(pixel) {
        return sparse_point(opened, photo, px);
    }
    if let Some((face, corner)) = corner(typed) {
        return corner_of(opened, face, corner);
    }
    match pixel(typed) {
        Some((photo, px)) => on_surface(opened, photo, px),
        None => Err(Error::Request(format!("{typed:?} is not a point; write {FORMS}"))),
    }
}

/// Parses finite numbers separated by commas.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let parts: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    parts.ok()?.try_into().ok().filter(|numbers: &[f64; N]| numbers.iter().all(|x| x.is_finite()))
}

/// Splits `PHOTO:X,Y`.
fn pixel(text: &str) -> Option<(&str, DVec2)> {
    let (photo, px) = text.rsplit_once(':')?;
    numbers::<2>(px).map(|px| (photo, DVec2::from_array(px)))
}

/// Splits `OBJECT[FACE]:CORNER`.
fn corner(text: &str) -> Option<(&str, usize)> {
    let (face, corner) = text.rsplit_once(':')?;
    Some((face, corner.trim().parse().ok()?)).filter(|_| face.ends_with(']'))
}

fn corner_of(opened: &Opened, face: &str, corner: usize) -> Result<DVec3> {
    let model = &opened.site.model;
    let id = face_named(model, face)?;
    let corners = model.ring_points(id).len();
    model.ring_points(id).nth(corner).ok_or_else(|| {
        Error::Request(format!("{face} has {corners} corners, numbered from 0; there is no corner {corner}"))
    })
}

fn on_surface(opened: &Opened, photo: &str, px: DVec2) -> Result<DVec3> {
    let photo = opened.site.photo(index_of_photo(&opened.site, photo)?);
    let (name, camera) = (&photo.name, &photo.camera);
    if !camera.rect().contains_position(px) {
        let (width, height) = (camera.width, camera.height);
        return Err(Error::Request(format!(
            "pixel {},{} is not in {name}, which is {width} x {height}",
            px.x, px.y
        )));
    }
    let (eye, ray) =
        (photo.pose.center_in_world(), photo.pose.rotation.transpose() * camera.ray_in_camera(px));
    let hit = ModelSurface::from_model(&opened.site.model).nearest(eye, ray);
    let hit = hit.ok_or_else(|| {
        Error::Request(format!(
            "{name} shows no surface of the model at pixel {},{}; choose a pixel on a face",
            px.x, px.y
        ))
    })?;
    Ok(eye + ray * hit.t)
}

fn sparse_point(opened: &Opened, photo: &str, px: DVec2) -> Result<DVec3> {
    let id = index_of_photo(&opened.site, photo)?;
    let seen = opened.points.iter().flat_map(|point| {
        let of_photo = point.observations.iter().filter(|(photo, _)| *photo as usize == id.index());
        of_photo.map(|(_, at)| (at.distance(px), point.position))
    });
    let nearest = seen.min_by(|a, b| a.0.total_cmp(&b.0));
    let name = &opened.site.photo(id).name;
    match nearest {
        Some((distance, position)) if distance <= NEAR_PX => Ok(position),
        Some((distance, _)) => Err(Error::Request(format!(
            "the sparse point nearest to pixel {},{} of {name} is {distance:.0} pixels away, more than {NEAR_PX}; give its pixel in the \
             photo as it was taken",
            px.x, px.y
        ))),
        None => Err(Error::Request(format!(
            "{name} observes no sparse point: the project's cameras have none of it; name a corner of a face or a pixel"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_points_are_taken_apart_from_the_right() {
        assert_eq!(numbers::<3>("1, -2.5,3e2"), Some([1.0, -2.5, 300.0]));
        assert_eq!((numbers::<3>("1,2"), numbers::<2>("1,nan")), (None, None));
        assert_eq!(pixel("a:b.jpg:10.5,20"), Some(("a:b.jpg", DVec2::new(10.5, 20.0))));
        assert_eq!(corner("wall: left[3]:2"), Some(("wall: left[3]", 2)));
        assert_eq!((corner("photo.jpg:2"), corner("wall[3]")), (None, None));
    }
}
