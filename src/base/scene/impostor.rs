//! Impostors: billboards that turn about an upright axis towards whoever looks at them (`docs/method.md`, section 7).
//!
//! A tree modelled as one flat polygon, or as two that cross, shows in every photo the picture that was made from that
//! photo's direction. So each camera gets a rectangle of its own through the axis, which faces it, and a position on it is
//! named by its distance from the axis and its height: positions of the same name on the rectangles of two cameras belong
//! together. The idea of nearest views on turning rectangles is that of Max (1996), with photos in place of made pictures.

use std::fmt;
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use super::{FaceId, FaceIndex, Model, Object, ObjectId};
use crate::geometry::{Plane, Pose, polygon::extent};

/// The cosine of the largest angle, 20 degrees, between the axis and the up direction.
const MOST_TILT: f64 = 0.939_692_620_785_908_4;

/// The least side of an impostor, as a share of the extent of its object: less is no area.
const LEAST_SIDE: f64 = 1e-6;

/// The largest distance of the axis from the plane of a face that it is said to lie in, as a share of the extent.
const OFF_PLANE: f64 = 0.02;

/// The distance of a camera from the axis, in half widths, below which it has no side of its own.
pub const ON_AXIS: f64 = 1e-3;

/// A billboard that turns. All positions are in world coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impostor {
    /// The lowest point of the axis.
    pub foot: DVec3,
    /// The unit direction of the axis, upwards.
    pub axis: DVec3,
    /// The length along the axis, in world units.
    pub height: f64,
    /// The largest distance of the object from the axis, in world units.
    pub half_width: f64,
}

/// The reason why an object cannot be an impostor; it stays polygons.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoImpostor {
    /// It has no faces.
    Empty,
    /// It does not extend along the axis: it lies on the ground.
    Flat,
    /// It does not extend beside the axis.
    Thin,
}

impl fmt::Display for NoImpostor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Empty => "it has no faces",
            Self::Flat => "it has no height: it lies on the ground",
            Self::Thin => "it has no width",
        })
    }
}

/// A camera for which an impostor turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facing {
    /// The camera's centre.
    pub eye: DVec3,
    /// The camera's unit direction to the right, used where the eye lies on the axis.
    pub right: DVec3,
}

impl Impostor {
    /// Makes the impostor of an object. `up` is the unit up direction.
    ///
    /// # Errors
    /// The reason why the object cannot be one.
    pub fn of_object(model: &Model, object: ObjectId, up: DVec3) -> Result<Self, NoImpostor> {
        let faces = &model.object(object).faces;
        let corners: Vec<DVec3> = faces.iter().flat_map(|face| model.ring_points(*face)).collect();
        let size = extent(&corners);
        if corners.is_empty() || size <= 0.0 {
            return Err(NoImpostor::Empty);
        }
        let (on_axis, axis) = common_line(model, faces, up, OFF_PLANE * size)
            .unwrap_or_else(|| (lowest_edge_middle(model, faces, up), up));
        let along = |corner: &DVec3| (*corner - on_axis).dot(axis);
        let low = corners.iter().map(along).fold(f64::INFINITY, f64::min);
        let high = corners.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
        let aside = |corner: &DVec3| (*corner - on_axis).reject_from(axis).length();
        let half_width = corners.iter().map(aside).fold(0.0, f64::max);
        if high - low <= LEAST_SIDE * size {
            return Err(NoImpostor::Flat);
        }
        if half_width <= LEAST_SIDE * size {
            return Err(NoImpostor::Thin);
        }
        Ok(Self { foot: on_axis + axis * low, axis, height: high - low, half_width })
    }

    /// Returns the unit direction across the axis, to the right as the camera sees it.
    pub fn across(&self, camera: &Facing) -> DVec3 {
        let across = self.axis.cross(camera.eye - self.foot);
        if across.length() >= ON_AXIS * self.half_width {
            return across.normalize();
        }
        let right = camera.right.reject_from(self.axis).try_normalize();
        right.unwrap_or_else(|| self.axis.any_orthonormal_vector())
    }

    /// Returns the corners of the rectangle that faces a camera: counter-clockwise as the camera sees it, from the lower
    /// left.
    pub fn corners(&self, camera: &Facing) -> [DVec3; 4] {
        let across = self.across(camera) * self.half_width;
        let top = self.foot + self.axis * self.height;
        [self.foot - across, self.foot + across, top + across, top - across]
    }

    /// Returns the position of a point in the rectangle of a camera: its signed distance from the axis, to the right, and
    /// its height above the foot; world units.
    pub fn place(&self, camera: &Facing, point: DVec3) -> DVec2 {
        let from_foot = point - self.foot;
        DVec2::new(from_foot.dot(self.across(camera)), from_foot.dot(self.axis))
    }

    /// Returns the point at a position in the rectangle of a camera; the inverse of [`Self::place`].
    pub fn point(&self, camera: &Facing, place: DVec2) -> DVec3 {
        self.foot + self.across(camera) * place.x + self.axis * place.y
    }

    /// Returns the camera on the other side of the axis, which sees the mirrored picture.
    pub fn mirrored(&self, camera: &Facing) -> Facing {
        let turned = |direction: DVec3| 2.0 * direction.project_onto(self.axis) - direction;
        Facing { eye: self.foot + turned(camera.eye - self.foot), right: turned(camera.right) }
    }
}

impl Facing {
    /// Returns the camera with this pose.
    pub fn of_pose(pose: &Pose) -> Self {
        Self { eye: pose.center_in_world(), right: pose.rotation.transpose().x_axis }
    }
}

impl Impostor {
    /// Returns the plane of the rectangle that faces a camera; the normal points towards the camera.
    pub fn plane(&self, camera: &Facing) -> Plane {
        Plane { normal: self.across(camera).cross(self.axis), point: self.foot }
    }

    /// Returns a camera that every part of the program takes for positions that belong to no camera in particular.
    pub fn at_rest(&self) -> Facing {
        let eye = self.foot + self.axis.any_orthonormal_vector() * self.half_width;
        Facing { eye, right: DVec3::X }
    }

    /// Returns the rotation about the axis that takes the rectangle that faces `from` to the one that faces `to`, so that
    /// positions of the same name meet.
    pub fn turn(&self, from: &Facing, to: &Facing) -> Turn {
        let basis = |camera: &Facing| {
            let across = self.across(camera);
            DMat3::from_cols(across, self.axis, across.cross(self.axis))
        };
        Turn { about: self.foot, rotation: basis(to) * basis(from).transpose() }
    }

    /// Returns where a ray, from the eye of a camera, meets the rectangle that faces the camera: the ray parameter.
    pub fn met(&self, camera: &Facing, direction: DVec3) -> Option<f64> {
        let plane = self.plane(camera);
        let t = -plane.signed_distance(camera.eye) / plane.normal.dot(direction);
        let place = self.place(camera, camera.eye + direction * t);
        let within = place.x.abs() <= self.half_width && (0.0..=self.height).contains(&place.y);
        (t > 0.0 && t.is_finite() && within).then_some(t)
    }
}

/// A rotation about an upright axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// A point of the axis.
    pub about: DVec3,
    /// The rotation.
    pub rotation: DMat3,
}

impl Turn {
    /// Returns the point that a point is taken to.
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.about + self.rotation * (point - self.about)
    }

    /// Returns this rotation followed by half a turn about its axis.
    pub fn and_half(&self, axis: DVec3) -> Self {
        let half = DMat3::from_axis_angle(axis, std::f64::consts::PI);
        Self { rotation: half * self.rotation, ..*self }
    }

    /// Returns the pose that sees points where `pose` sees what they are taken to.
    pub fn before(&self, pose: &Pose) -> Pose {
        let rotation = pose.rotation * self.rotation;
        let translation = pose.camera_from_world(self.about) - rotation * self.about;
        Pose { rotation, translation }
    }
}

impl Model {
    /// Returns the same model in which some objects are impostors, and the objects that cannot be, with the reasons.
    /// `up` is the unit up direction.
    pub fn with_impostors(
        mut self,
        up: DVec3,
        turns: impl Fn(&Object) -> bool,
    ) -> (Self, Vec<(String, NoImpostor)>) {
        let mut refused = Vec::new();
        for id in (0..self.objects.len()).map(ObjectId::new) {
            let found = turns(self.object(id)).then(|| Impostor::of_object(&self, id, up));
            let object = &mut self.objects[id.index()];
            match found {
                None => (),
                Some(Ok(impostor)) => {
                    object.impostor = Some(impostor);
                    (object.billboard, object.see_through) = (true, true);
                }
                Some(Err(reason)) => refused.push((object.name.clone(), reason)),
            }
        }
        (self, refused)
    }

    /// Returns true when some object is an impostor.
    pub fn has_impostors(&self) -> bool {
        self.objects.iter().any(|object| object.impostor.is_some())
    }

    /// Returns the impostor that a face belongs to.
    pub fn impostor(&self, face: FaceId) -> Option<&Impostor> {
        self.object(self.face(face).object).impostor.as_ref()
    }

    /// Returns true when a face is the one that stands for all faces of its object, which is an impostor.
    pub fn stands_for_impostor(&self, face: FaceId) -> bool {
        self.face(face).index == FaceIndex(0) && self.impostor(face).is_some()
    }

    /// Returns true when the rectangle of an impostor, another face of the object, takes the place of a face.
    pub fn is_replaced(&self, face: FaceId) -> bool {
        self.face(face).index != FaceIndex(0) && self.impostor(face).is_some()
    }

    /// Returns the index of the face that stacks have in place of a face: of an impostor the first one, else its own.
    pub fn index_in_stacks(&self, face: FaceId) -> FaceIndex {
        if self.is_replaced(face) { FaceIndex(0) } else { self.face(face).index }
    }

    /// Returns the plane of a face as a camera sees it.
    pub fn plane_facing(&self, face: FaceId, camera: &Facing) -> Plane {
        self.impostor(face).map_or(self.face(face).plane, |impostor| impostor.plane(camera))
    }

    /// Returns the model as a camera sees it: the first face of each impostor's object is the rectangle that faces the
    /// camera, and its other faces have no area. Faces keep their ids.
    pub fn facing(self: &Arc<Self>, camera: &Facing) -> Arc<Self> {
        let mut model = self.clone();
        if self.has_impostors() {
            Arc::make_mut(&mut model).turn_towards(camera);
        }
        model
    }

    /// Turns all impostors towards a camera, in place; see [`Self::facing`].
    pub fn turn_towards(&mut self, camera: &Facing) {
        for id in (0..self.objects.len()).map(ObjectId::new) {
            let Some(impostor) = self.object(id).impostor else { continue };
            let Some(&face) = self.object(id).faces.first() else { continue };
            if !self.objects[id.index()].turned {
                self.add_rectangle(id);
            }
            let first = self.ring(face)[0] as usize;
            self.vertices[first..first + 4].copy_from_slice(&impostor.corners(camera));
            self.faces[face.0 as usize].plane = impostor.plane(camera);
        }
    }

    /// Gives the first face of an object a rectangle with vertices of its own, and takes the area of the others.
    fn add_rectangle(&mut self, id: ObjectId) {
        let vertex = self.vertices.len() as u32;
        let (ring, triangle) = (self.ring_vertices.len() as u32, self.triangles.len() as u32);
        self.vertices.extend([DVec3::ZERO; 4]);
        self.ring_vertices.extend(vertex..vertex + 4);
        self.triangles.extend([[vertex, vertex + 1, vertex + 2], [vertex, vertex + 2, vertex + 3]]);
        self.objects[id.index()].turned = true;
        let faces = self.object(id).faces.clone();
        for face in &faces[1..] {
            let face = &mut self.faces[face.0 as usize];
            face.triangles = face.triangles.start..face.triangles.start;
        }
        let face = &mut self.faces[faces[0].0 as usize];
        face.ring = ring..ring + 4;
        face.triangles = triangle..triangle + 2;
        face.planar = true;
    }
}

/// Returns a point and the upward unit direction of the line that all faces' planes have in common, if there is one
/// within 20 degrees of up from which no plane is farther than `off`.
fn common_line(model: &Model, faces: &[FaceId], up: DVec3, off: f64) -> Option<(DVec3, DVec3)> {
    let planes: Vec<Plane> = faces
        .iter()
        .filter(|face| !model.face_triangles(**face).is_empty())
        .map(|face| model.face(*face).plane)
        .collect();
    let first = planes.first()?;
    // The two planes that differ most define the line.
    let crossing = |plane: &&Plane| first.normal.cross(plane.normal).length();
    let second = planes.iter().max_by(|a, b| crossing(a).total_cmp(&crossing(b)))?;
    let direction =
        first.normal.cross(second.normal).try_normalize().filter(|_| crossing(&second) > OFF_PLANE)?;
    let axis = if direction.dot(up) < 0.0 { -direction } else { direction };
    if axis.dot(up) < MOST_TILT {
        return None;
    }
    // The point of both planes that lies at the height of the first one's own point.
    let rows = DMat3::from_cols(first.normal, second.normal, axis).transpose();
    let offsets =
        DVec3::new(first.normal.dot(first.point), second.normal.dot(second.point), axis.dot(first.point));
    let point = rows.inverse() * offsets;
    let holds = |plane: &Plane| {
        plane.signed_distance(point).abs() <= off && plane.normal.dot(axis).abs() <= OFF_PLANE
    };
    planes.iter().all(holds).then_some((point, axis))
}

/// Returns the middle of the edge whose middle is lowest.
fn lowest_edge_middle(model: &Model, faces: &[FaceId], up: DVec3) -> DVec3 {
    let edges = faces.iter().flat_map(|face| {
        let ring: Vec<DVec3> = model.ring_points(*face).collect();
        (0..ring.len()).map(|i| 0.5 * (ring[i] + ring[(i + 1) % ring.len()])).collect::<Vec<_>>()
    });
    edges.min_by(|a, b| a.dot(up).total_cmp(&b.dot(up))).expect("the caller has corners")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::synthetic::{Modeller, Rng};

    const UP: DVec3 = DVec3::Z;

    /// Two quads that cross at `foot`, tilted towards x by this many degrees, six wide and eight high.
    fn crossed(foot: DVec3, degrees: f64) -> Arc<Model> {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let axis = DVec3::new(sin, 0.0, cos);
        let mut m = Modeller::new();
        m.object("tree.billboard");
        for across in [DVec3::Y, DVec3::new(cos, 0.0, -sin)] {
            m.quad(foot - 3.0 * across, 6.0 * across, 8.0 * axis);
        }
        m.finish()
    }

    fn near(a: DVec3, b: DVec3) -> bool {
        a.distance(b) < 1e-9
    }

    #[test]
    fn crossing_quads_turn_about_their_common_line_up_to_20_degrees_from_up() {
        let foot = DVec3::new(5.0, -7.0, 1.0);
        for degrees in [0.0, 10.0, 19.0] {
            let found = Impostor::of_object(&crossed(foot, degrees), ObjectId(0), UP).unwrap();
            let tilt = degrees.to_radians();
            assert!(near(found.foot, foot), "{found:?}");
            assert!(near(found.axis, DVec3::new(tilt.sin(), 0.0, tilt.cos())), "{found:?}");
            assert!((found.height - 8.0).abs() < 1e-9 && (found.half_width - 3.0).abs() < 1e-9, "{found:?}");
        }
        let leaning = Impostor::of_object(&crossed(foot, 21.0), ObjectId(0), UP).unwrap();
        assert_eq!(leaning.axis, UP);
    }

    #[test]
    fn one_quad_turns_about_the_middle_of_its_lower_edge_in_worlds_with_up_anywhere() {
        for up in [DVec3::Z, DVec3::NEG_Z, DVec3::Y] {
            let right = up.any_orthonormal_vector();
            let mut m = Modeller::new();
            m.object("hedge.billboard").quad(DVec3::ONE, 4.0 * right, 3.0 * up);
            let found = Impostor::of_object(&m.finish(), ObjectId(0), up).unwrap();
            assert!(near(found.foot, DVec3::ONE + 2.0 * right) && found.axis == up, "{found:?}");
            assert!((found.height - 3.0).abs() < 1e-9 && (found.half_width - 2.0).abs() < 1e-9);
        }
    }

    #[test]
    fn what_lies_on_the_ground_or_is_a_line_stays_as_it_is() {
        let mut m = Modeller::new();
        m.object("carpet").quad(DVec3::ZERO, DVec3::X, DVec3::Y);
        assert_eq!(Impostor::of_object(&m.finish(), ObjectId(0), UP), Err(NoImpostor::Flat));
        let mut m = Modeller::new();
        m.object("pole").polygon(&[DVec3::ZERO, DVec3::Z, 2.0 * DVec3::Z]);
        assert_eq!(Impostor::of_object(&m.finish(), ObjectId(0), UP), Err(NoImpostor::Thin));
    }

    #[test]
    fn the_rectangle_faces_its_camera_and_places_in_it_come_back() {
        let mut rng = Rng::new(11);
        let tree = Impostor::of_object(&crossed(DVec3::new(1.0, 2.0, 3.0), 5.0), ObjectId(0), UP).unwrap();
        for _ in 0..200 {
            let coordinate = |rng: &mut Rng| rng.between(-30.0, 30.0);
            let eye = DVec3::new(coordinate(&mut rng), coordinate(&mut rng), coordinate(&mut rng));
            let camera = Facing { eye, right: DVec3::X };
            let corners = tree.corners(&camera);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            let towards = (eye - tree.foot).reject_from(tree.axis).normalize();
            assert!(near(normal, towards), "{normal} {towards}");
            let place = DVec2::new(rng.between(-3.0, 3.0), rng.between(0.0, 8.0));
            let point = tree.point(&camera, place);
            assert!(tree.place(&camera, point).distance(place) < 1e-9);
            let mirror = tree.mirrored(&camera);
            let from_behind = DVec2::new(-place.x, place.y);
            assert!(near(tree.point(&mirror, from_behind), point), "the mirror sees it from behind");
        }
        // On the axis the camera's own right decides.
        let above = Facing { eye: tree.foot + 50.0 * tree.axis, right: DVec3::Y };
        assert!(near(tree.across(&above), DVec3::Y));
    }

    #[test]
    fn a_model_that_faces_a_camera_keeps_its_face_ids_and_has_one_rectangle_per_impostor() {
        let mut m = Modeller::new();
        m.object("ground").quad(DVec3::new(-9.0, -9.0, 0.0), DVec3::X * 18.0, DVec3::Y * 18.0);
        m.object("tree.billboard").quad(DVec3::NEG_X, 2.0 * DVec3::X, 4.0 * DVec3::Z);
        m.quad(DVec3::NEG_Y, 2.0 * DVec3::Y, 4.0 * DVec3::Z);
        m.object("wall").quad(DVec3::new(-9.0, 9.0, 0.0), DVec3::X * 18.0, DVec3::Z * 8.0);
        let (model, refused) =
            (*m.finish()).clone().with_impostors(UP, |object| object.name.contains("billboard"));
        assert!(refused.is_empty());
        let tree = model.objects[1].impostor.unwrap();
        let camera = Facing { eye: DVec3::new(7.0, -20.0, 2.0), right: DVec3::X };
        let model = Arc::new(model);
        let elsewhere = Facing { eye: DVec3::new(-30.0, 4.0, 2.0), right: DVec3::X };
        let mut turned = model.facing(&elsewhere);
        assert_eq!(turned.faces.len(), model.faces.len());
        Arc::make_mut(&mut turned).turn_towards(&camera);
        assert_eq!(turned, model.facing(&camera), "a model turns again in place");
        for other in [FaceId(0), FaceId(3)] {
            assert_eq!(turned.face(other), model.face(other));
        }
        let corners: Vec<DVec3> = turned.ring_points(FaceId(1)).collect();
        assert_eq!(corners, tree.corners(&camera));
        assert_eq!((turned.face_triangles(FaceId(1)).len(), turned.face_triangles(FaceId(2)).len()), (2, 0));
        let plane = turned.face(FaceId(1)).plane;
        assert!(corners.iter().all(|corner| plane.signed_distance(*corner).abs() < 1e-9));
        assert!(plane.signed_distance(camera.eye) > 0.0, "it is seen from the front");
    }
}
