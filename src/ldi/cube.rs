//! A cube: six layered depth images of 90 degrees and one centre, for views that turn further than one frame reaches.
//!
//! The faces have an order of their own (McMillan 1995 on a cube instead of a plane): each plane through the centre that
//! parts two faces is crossed once by the lines of sight of the picture's camera, from behind to ahead, so the faces are drawn
//! by rising E . n, with E the direction from the centre to the picture's camera and n the faces' axes. Within each, the order
//! of [`super::order`] holds.

use glam::{DMat3, DVec3};

use super::layout::Ldi;
use super::set::{Arrangement, LdiSet};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Pinhole, Pose};

/// The names of the faces in their order, as seen by somebody upright who looks ahead.
pub const FACE_NAMES: [&str; 6] = ["right", "left", "down", "up", "front", "back"];

/// The name of the option under which the report of a face has the face's name.
pub const FACE: &str = "cube";

/// The cosine of the steepest angle at which a camera that looks up or down still has a direction ahead.
const STEEPEST: f64 = 1e-3;
/// How far lengths and entries of rotations may be from those of a cube, as a share: text with seven digits is within.
const TOLERANCE: f64 = 1e-6;
/// How far centres may be apart, as a share of their distance from the world's origin or, near it, in world units: they follow
/// from R and t with rounding errors.
const CENTRE_TOLERANCE: f64 = 1e-9;

/// Returns the axes of a cube in the world, right, down and ahead in its columns: upright, and ahead where a camera looks. `up`
/// is a unit vector; where the camera looks straight up or down, ahead is what is up in its picture.
pub fn upright(pose: &Pose, up: DVec3) -> DMat3 {
    let level = |direction: DVec3| direction.reject_from_normalized(up);
    let in_world = pose.rotation.transpose();
    let [ahead, above] = [in_world * DVec3::Z, in_world * -DVec3::Y].map(level);
    let ahead = if ahead.length() > STEEPEST { ahead } else { above };
    let (ahead, down) = (ahead.normalize_or(up.any_orthonormal_vector()), -up);
    DMat3::from_cols(down.cross(ahead), down, ahead)
}

/// Returns the cameras of a cube around `centre`, in world coordinates, whose faces have `side_px` x `side_px` pixels, in the
/// order of [`FACE_NAMES`]. The faces are along `axes`, see [`upright`]; they share no pixel and leave none out.
pub fn cube_cameras(centre: DVec3, axes: &DMat3, side_px: u32) -> [(Pinhole, Pose); 6] {
    let half = f64::from(side_px) / 2.0;
    let camera = Pinhole { width: side_px, height: side_px, fx: half, fy: half, cx: half, cy: half };
    let (x, y, z) = (axes.x_axis, axes.y_axis, axes.z_axis);
    // Right, down and ahead of each face, in the world.
    let faces = [[-z, y, x], [z, y, -x], [x, -z, y], [x, z, -y], [x, y, z], [-x, y, -z]];
    faces.map(|[right, down, ahead]| {
        let rotation = DMat3::from_cols(right, down, ahead).transpose();
        (camera, Pose { rotation, translation: -(rotation * centre) })
    })
}

/// Returns the direction in which a camera looks, in the world.
pub fn axis(pose: &Pose) -> DVec3 {
    pose.rotation.transpose() * DVec3::Z
}

/// Returns the indices of faces with these axes in the order in which they are drawn for a picture from `viewpoint`: by rising
/// E . n, those that are equal in their own order. At the centre, where every order will do, that is their own.
pub fn faces_in_order(axes: &[DVec3], centre: DVec3, viewpoint: DVec3) -> Vec<usize> {
    let forward = viewpoint - centre;
    let mut order: Vec<usize> = (0..axes.len()).collect();
    order.sort_by(|&a, &b| forward.dot(axes[a]).total_cmp(&forward.dot(axes[b])));
    order
}

/// Makes a cube of its faces.
///
/// # Errors
/// [`Error::Request`] that says why they are none.
pub fn cube(faces: [Ldi; 6]) -> Result<LdiSet> {
    let images: Vec<Ldi> = faces.into();
    let of_faces: Vec<CubeFace> = images.iter().map(CubeFace::of).collect();
    match flaw(&of_faces) {
        None => Ok(LdiSet { arrangement: Arrangement::Cube, images }),
        Some(found) => Err(Error::Request(format!("the images make no cube: {found}"))),
    }
}

/// What must fit together in a cube.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CubeFace {
    /// See [`Ldi::camera`].
    pub camera: Pinhole,
    /// See [`Ldi::pose`].
    pub pose: Pose,
    /// See [`Ldi::gain`].
    pub gain: [f64; 3],
}

impl CubeFace {
    /// Returns what must fit of an image.
    pub fn of(ldi: &Ldi) -> Self {
        Self { camera: ldi.camera, pose: ldi.pose, gain: ldi.gain }
    }
}

/// Returns what is wrong with the faces of a cube, all six or those that are left: each has a square frame of just 90 degrees
/// in the first one's resolution, centre and exposure, and no two look in the same direction, all of them along one trihedral;
/// `None` where nothing is wrong.
pub fn flaw(faces: &[CubeFace]) -> Option<String> {
    let first = faces.first()?;
    let centre = first.pose.center_in_world();
    let near = |a: f64, b: f64| (a - b).abs() <= TOLERANCE * b.abs().max(1.0);
    for (index, face) in faces.iter().enumerate() {
        let Pinhole { width, height, fx, fy, cx, cy } = face.camera;
        let half = f64::from(width) / 2.0;
        if width != height || ![fx, fy, cx, cy].iter().all(|value| near(*value, half)) {
            return Some(format!(
                "face {index} has {width} x {height} pixels, focal lengths {fx} and {fy} and principal point {cx}, {cy}; \
                 expected a square with half its side for each"
            ));
        }
        if width != first.camera.width {
            return Some(format!("face {index} has {width} pixels a side; expected {}", first.camera.width));
        }
        let apart = face.pose.center_in_world().distance(centre);
        // Not a number fails, too.
        let is_centre = apart <= CENTRE_TOLERANCE * (1.0 + centre.length());
        if !is_centre {
            return Some(format!(
                "the centre of face {index} is {apart} from that of face 0; expected one centre"
            ));
        }
        if face.gain != first.gain {
            return Some(format!("face {index} has the gain {:?}; expected {:?}", face.gain, first.gain));
        }
        let turned = face.pose.rotation * first.pose.rotation.transpose();
        if !turned.to_cols_array().iter().all(|entry| near(entry.abs(), 0.0) || near(entry.abs(), 1.0)) {
            return Some(format!("face {index} is not turned against face 0 by right angles"));
        }
        if let Some(other) =
            faces[..index].iter().position(|other| axis(&other.pose).dot(axis(&face.pose)) > 0.5)
        {
            return Some(format!("faces {other} and {index} look in the same direction"));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    fn faces() -> Vec<CubeFace> {
        let centre = DVec3::new(3.0, -5e6, 0.25);
        cube_cameras(centre, &DMat3::IDENTITY, 64)
            .map(|(camera, pose)| CubeFace { camera, pose, gain: [0.1; 3] })
            .into()
    }

    #[test]
    fn every_direction_is_in_exactly_one_face_of_a_cube() {
        let (centre, mut rng) = (DVec3::new(7.0, 2.0, -1.0), Rng::new(1));
        let cameras = cube_cameras(centre, &DMat3::IDENTITY, 128);
        for _ in 0..2000 {
            let direction = DVec3::from_array(std::array::from_fn(|_| rng.between(-1.0, 1.0)));
            let within = cameras.iter().filter(|(camera, pose)| {
                let position = camera.image_from_camera(pose.camera_from_world(centre + 5.0 * direction));
                position.is_some_and(|p| p.min_element() >= 0.0 && p.max_element() < 128.0)
            });
            assert_eq!(within.count(), 1, "{direction}");
        }
        for ((_, pose), ahead) in cameras.iter().zip([1.0, -1.0].repeat(3)) {
            assert!((pose.rotation.determinant() - 1.0).abs() < 1e-12);
            assert_eq!(axis(pose).element_sum(), ahead);
        }
    }

    #[test]
    fn faces_are_named_as_somebody_upright_sees_them_whatever_axis_of_the_world_is_up() {
        // A world whose z axis points up, and a camera in it that looks along y and a little down.
        let ahead = DVec3::new(0.0, 0.9, -0.3).normalize();
        let rotation = DMat3::from_cols(DVec3::X, ahead.cross(DVec3::X), ahead).transpose();
        let pose = Pose { rotation, translation: DVec3::ZERO };
        let axes_of = |axes: DMat3| cube_cameras(DVec3::ZERO, &axes, 2).map(|(_, pose)| axis(&pose));
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        for (found, expected) in axes_of(upright(&pose, z)).into_iter().zip([x, -x, -z, z, y, -y]) {
            assert!(found.distance(expected) < 1e-12, "{found}, not {expected}");
        }
        let down = Pose { rotation: DMat3::from_cols(x, -y, -z).transpose(), translation: DVec3::ZERO };
        assert!(axes_of(upright(&down, z))[4].distance(y) < 1e-12, "what is up in its picture is ahead");
    }

    /// Returns the face that a point around the origin is in.
    fn face_of(point: DVec3) -> usize {
        let axes = cube_cameras(DVec3::ZERO, &DMat3::IDENTITY, 2).map(|(_, pose)| axis(&pose));
        (0..6).max_by(|&a, &b| point.dot(axes[a]).total_cmp(&point.dot(axes[b]))).unwrap()
    }

    #[test]
    fn of_two_points_on_one_line_of_sight_the_face_of_the_farther_one_is_drawn_first() {
        let mut rng = Rng::new(2);
        let axes = cube_cameras(DVec3::ZERO, &DMat3::IDENTITY, 2).map(|(_, pose)| axis(&pose));
        let (mut pairs, mut reversed_right) = (0, 0);
        for _ in 0..3000 {
            let mut vector = || DVec3::from_array(std::array::from_fn(|_| rng.between(-1.0, 1.0)));
            let (viewpoint, direction) = (vector(), vector());
            let order = faces_in_order(&axes, DVec3::ZERO, viewpoint);
            let place = |face: usize| order.iter().position(|other| *other == face).unwrap();
            let faces: Vec<usize> =
                (1..60).map(|step| face_of(viewpoint + 0.1 * f64::from(step) * direction)).collect();
            for (far, face) in faces.iter().enumerate() {
                for nearer in faces[..far].iter().filter(|nearer| *nearer != face) {
                    assert!(place(*face) < place(*nearer), "{viewpoint} along {direction}");
                    pairs += 1;
                    reversed_right += u32::from(place(*face) > place(*nearer));
                }
            }
        }
        assert!(pairs > 100_000 && reversed_right == 0, "{pairs} pairs");
    }

    #[test]
    fn what_is_no_cube_is_told() {
        assert_eq!(flaw(&faces()), None);
        assert_eq!(flaw(&faces()[2..4]), None);
        let says = |change: &dyn Fn(&mut Vec<CubeFace>), what: &str| {
            let mut faces = faces();
            change(&mut faces);
            let found = flaw(&faces).unwrap();
            assert!(found.contains(what), "{found}");
        };
        says(&|faces| faces[3].camera.height = 65, "face 3 has 64 x 65 pixels");
        says(&|faces| faces[1].camera.fx = 40.0, "focal lengths 40");
        says(
            &|faces| faces[5].camera = cube_cameras(DVec3::ZERO, &DMat3::IDENTITY, 32)[0].0,
            "32 pixels a side; expected 64",
        );
        says(&|faces| faces[2].pose.translation.x += 0.1, "one centre");
        says(&|faces| faces[2].pose.translation.x = f64::NAN, "one centre");
        says(&|faces| faces[4].gain = [0.0; 3], "gain");
        says(&|faces| faces[4] = faces[0], "faces 0 and 4 look in the same direction");
        let turned = DMat3::from_rotation_y(0.2);
        says(
            &|faces| {
                let centre = faces[1].pose.center_in_world();
                let rotation = turned * faces[1].pose.rotation;
                faces[1].pose = Pose { rotation, translation: -(rotation * centre) };
            },
            "right angles",
        );
    }
}
