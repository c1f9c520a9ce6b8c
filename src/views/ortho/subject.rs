//! What an orthophoto is of, and the plane of its picture.

use glam::{DVec2, DVec3};

use crate::frame::{area_vector, faces_named, point_named, up_of};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{FaceId, Model};
use quadratura_sites::open::Opened;
use quadratura_view::PicturePlane;

/// What an orthophoto is of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Subject {
    /// Faces and objects by name, seen from straight in front.
    On(Vec<String>),
    /// The site from above, or these faces and objects.
    Plan(Vec<String>),
    /// What is behind the upright plane through two points, seen with the first one on the left.
    Section([String; 2]),
}

/// The plane of a picture, and what is in it.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedSubject {
    /// The plane; its middle is the middle of the picture.
    pub plane: PicturePlane,
    /// Width and height of the picture, in world units.
    pub size: DVec2,
    /// The faces that the picture is of; all that is in sight where it is of no particular ones.
    pub faces: Vec<FaceId>,
    /// The least depth of these behind the plane, in world units; 0 for sections, which cut there.
    pub foremost: f64,
}

/// The cosine of the angle within which normals belong to one facade, 15 degrees, and the cosine of the angle up to which faces are part
/// of its picture, 60 degrees.
const ALIKE: f64 = 0.965_925_826_289_068_3;
const IN_SIGHT: f64 = 0.5;

/// The largest upward part of the normals of upright faces: 30 degrees from level.
const UPRIGHT: f64 = 0.5;

/// Finds the plane of a picture.
///
/// # Errors
/// Returns [`Error::Request`] for faces, objects and points that do not exist, for faces without area, and for a section whose points are
/// the same or above each other.
pub fn placed(opened: &Opened, subject: &Subject) -> Result<PlacedSubject> {
    let model = &opened.site.model;
    let up = up_of(opened);
    match subject {
        Subject::On(names) => on_faces(opened, &named(model, names)?, up, &names.join(", ")),
        Subject::Plan(names) => {
            let faces = if names.is_empty() { with_area(model) } else { named(model, names)? };
            let axes = opened.project.frame.axes();
            let (east, north) = match opened.project.frame.up {
                Some(_) => (axes.row(0), axes.row(1)),
                None => {
                    let east = DVec3::X.reject_from(up).try_normalize();
                    let east = east.unwrap_or_else(|| up.any_orthonormal_vector());
                    (east, up.cross(east))
                }
            };
            Ok(around(model, faces, east, -north))
        }
        Subject::Section(points) => section(opened, points, up),
    }
}

fn named(model: &Model, names: &[String]) -> Result<Vec<FaceId>> {
    let mut faces = Vec::new();
    for name in names {
        faces.extend(faces_named(model, name)?);
    }
    faces.sort_unstable();
    faces.dedup();
    Ok(faces)
}

fn with_area(model: &Model) -> Vec<FaceId> {
    model.face_ids().filter(|face| area_vector(model, *face).length() > 0.0).collect()
}

/// Returns the picture of faces from straight in front: of the largest facade among them on the side where cameras are.
fn on_faces(opened: &Opened, faces: &[FaceId], up: DVec3, names: &str) -> Result<PlacedSubject> {
    let model = &opened.site.model;
    let eyes: Vec<DVec3> = opened.site.photos.iter().map(|photo| photo.pose.center_in_world()).collect();
    // Each normal with the area, towards the side on which more cameras are.
    let towards_cameras = |&face: &FaceId| {
        let (normal, point) = (area_vector(model, face), model.face(face).plane.point);
        let in_front = eyes.iter().filter(|eye| normal.dot(**eye - point) > 0.0).count();
        let side = if 2 * in_front < eyes.len() { -1.0 } else { 1.0 };
        (normal.length() > 0.0).then_some((face, normal * side))
    };
    let normals: Vec<(FaceId, DVec3)> = faces.iter().filter_map(towards_cameras).collect();
    let is_upright = |normal: DVec3| normal.dot(up).abs() < UPRIGHT * normal.length();
    let has_walls = normals.iter().any(|(_, normal)| is_upright(*normal));
    let of_facades: Vec<DVec3> = normals
        .iter()
        .map(|(_, normal)| *normal)
        .filter(|normal| !has_walls || is_upright(*normal))
        .collect();
    let alike = |a: DVec3, b: DVec3| a.dot(b) >= ALIKE * a.length() * b.length();
    let sums = of_facades
        .iter()
        .map(|normal| -> DVec3 { of_facades.iter().filter(|other| alike(*normal, **other)).sum() });
    let largest = sums.max_by(|a, b| a.length().total_cmp(&b.length())).and_then(DVec3::try_normalize);
    let Some(normal) = largest else {
        return Err(Error::Request(format!("{names}: these faces have no area to be shown; name others")));
    };
    let in_sight =
        |(face, own): &(FaceId, DVec3)| (own.dot(normal) >= IN_SIGHT * own.length()).then_some(*face);
    let shown: Vec<FaceId> = normals.iter().filter_map(in_sight).collect();
    // Level faces have no up of their own: the frame's north, else any direction.
    let axes = opened.project.frame.axes();
    let upwards = [up, axes.row(1), axes.row(0)].map(|up| up.reject_from(normal));
    let upwards = upwards.into_iter().find(|up| up.length() > 0.1).unwrap_or(DVec3::ZERO);
    let upwards = upwards.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
    Ok(around(model, shown, upwards.cross(normal), -upwards))
}

/// Returns the smallest picture of faces along these directions.
fn around(model: &Model, faces: Vec<FaceId>, right: DVec3, down: DVec3) -> PlacedSubject {
    let corners: Vec<DVec3> = faces.iter().flat_map(|face| model.ring_points(*face)).collect();
    let forward = right.cross(down);
    let place = |corner: &DVec3| DVec3::new(corner.dot(right), corner.dot(down), corner.dot(forward));
    let (low, high) = corners
        .iter()
        .map(place)
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), place| (low.min(place), high.max(place)));
    let middle = 0.5 * (low + high);
    let in_world = right * middle.x + down * middle.y + forward * middle.z;
    PlacedSubject {
        plane: PicturePlane { middle: in_world, right, down },
        size: (high - low).truncate(),
        faces,
        foremost: low.z - middle.z,
    }
}

fn section(opened: &Opened, points: &[String; 2], up: DVec3) -> Result<PlacedSubject> {
    let [a, b] = points;
    let (from, to) = (point_named(opened, a)?, point_named(opened, b)?);
    let along = (to - from).reject_from(up);
    let Some(right) = along.try_normalize().filter(|_| along.length() > 1e-3 * (to - from).length()) else {
        return Err(Error::Request(format!(
            "a section runs between two points beside each other, and {a} and {b} are the same point or above each other"
        )));
    };
    let model = &opened.site.model;
    let heights = model.vertices.iter().map(|vertex| vertex.dot(up));
    let (low, high) =
        heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
    let middle = 0.5 * (from + to).reject_from(up) + up * (0.5 * (low + high));
    Ok(PlacedSubject {
        plane: PicturePlane { middle, right, down: -up },
        size: DVec2::new(along.length(), high - low),
        faces: Vec::new(),
        foremost: 0.0,
    })
}
