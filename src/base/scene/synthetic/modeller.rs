//! A builder for synthetic models, face by face.

use std::ops::Range;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::geometry::Plane;
use crate::scene::{Face, FaceId, FaceIndex, Model, Object, ObjectId};

/// A model under construction. Faces are added to the object named last.
#[derive(Debug, Clone, Default)]
pub struct Modeller {
    model: Model,
    current: Option<ObjectId>,
}

impl Modeller {
    /// Starts an empty model.
    pub fn new() -> Self {
        Self::default()
    }

    /// Makes the object of this name current, adding it if it is new. All following faces belong to it.
    pub fn object(&mut self, name: impl Into<String>) -> &mut Self {
        let name = name.into();
        let objects = &mut self.model.objects;
        let known = objects.iter().rposition(|object| object.name == name);
        self.current = Some(ObjectId(known.unwrap_or(objects.len()) as u32));
        if known.is_none() {
            objects.push(Object {
                name,
                faces: Vec::new(),
                billboard: false,
                impostor: None,
                see_through: false,
                turned: false,
            });
        }
        self
    }

    /// Adds a convex planar polygon, counter-clockwise seen from its visible side.
    pub fn polygon(&mut self, corners: &[DVec3]) -> &mut Self {
        let fan: Vec<[usize; 3]> = (2..corners.len()).map(|i| [0, i - 1, i]).collect();
        self.face(corners, &fan, true)
    }

    /// Adds a planar polygon of any shape with its triangles, as indices into the outline.
    pub fn shape(&mut self, outline: &[DVec3], triangles: &[[usize; 3]]) -> &mut Self {
        self.face(outline, triangles, true)
    }

    /// Adds a quadrilateral whose corners do not lie in one plane, bent along corners 0 and 2.
    pub fn bent_quad(&mut self, corners: [DVec3; 4]) -> &mut Self {
        self.face(&corners, &[[0, 1, 2], [0, 2, 3]], false)
    }

    /// Adds the parallelogram `origin`, `origin + u`, `origin + u + v`, `origin + v`, visible from the side of `u x
    /// v`.
    pub fn quad(&mut self, origin: DVec3, u: DVec3, v: DVec3) -> &mut Self {
        self.polygon(&[origin, origin + u, origin + u + v, origin + v])
    }

    /// Adds the same parallelogram, wound so that it is visible from the side to which `towards` points.
    pub fn quad_facing(&mut self, towards: DVec3, origin: DVec3, u: DVec3, v: DVec3) -> &mut Self {
        if u.cross(v).dot(towards) > 0.0 { self.quad(origin, u, v) } else { self.quad(origin, v, u) }
    }

    /// Adds a rectangle parallel to the image of a camera whose frame is the world, at depth `z`, `[x0, x1] x [y0,
    /// y1]` with y down. The camera sees its front.
    pub fn screen(&mut self, z: f64, [x0, y0, x1, y1]: [f64; 4]) -> &mut Self {
        let (down, right) = (DVec3::Y * (y1 - y0), DVec3::X * (x1 - x0));
        self.quad(DVec3::new(x0, y0, z), down, right)
    }

    /// Adds the six faces of a box, visible from outside. `axes` rotates the box's frame into the world, `half` is
    /// half its size along its own axes.
    pub fn cuboid(&mut self, centre: DVec3, half: DVec3, axes: DMat3) -> &mut Self {
        let half_axes = [axes.x_axis * half.x, axes.y_axis * half.y, axes.z_axis * half.z];
        for axis in 0..3 {
            let [out, u, v] = [0, 1, 2].map(|step| half_axes[(axis + step) % 3]);
            self.quad(centre + out - u - v, 2.0 * u, 2.0 * v);
            self.quad(centre - out - u - v, 2.0 * v, 2.0 * u);
        }
        self
    }

    /// Returns the finished model and starts an empty one.
    pub fn finish(&mut self) -> Arc<Model> {
        self.current = None;
        Arc::new(std::mem::take(&mut self.model))
    }

    /// Adds a face with its own vertices to the current object.
    fn face(&mut self, outline: &[DVec3], triangles: &[[usize; 3]], planar: bool) -> &mut Self {
        let object = self.current.expect("an object was named before its first face");
        let model = &mut self.model;
        let (id, base) = (FaceId(model.faces.len() as u32), model.vertices.len());
        let index = |corner: usize| (base + corner) as u32;
        model.vertices.extend_from_slice(outline);
        let ring = appended(&mut model.ring_vertices, (0..outline.len()).map(index));
        let triangles = appended(&mut model.triangles, triangles.iter().map(|t| t.map(index)));
        let faces = &mut model.objects[object.0 as usize].faces;
        let index = FaceIndex::new(faces.len());
        faces.push(id);
        model.faces.push(Face { object, index, ring, triangles, plane: plane_of(outline), planar });
        self
    }
}

/// Appends values to a flat array and returns their range.
fn appended<T>(array: &mut Vec<T>, values: impl Iterator<Item = T>) -> Range<u32> {
    let start = array.len() as u32;
    array.extend(values);
    start..array.len() as u32
}

/// Returns Newell's plane of an outline, computed relative to its first corner.
fn plane_of(outline: &[DVec3]) -> Plane {
    let origin = outline[0];
    let next = outline.iter().cycle().skip(1);
    let doubled: DVec3 = outline.iter().zip(next).map(|(a, b)| (a - origin).cross(b - origin)).sum();
    let middle: DVec3 = outline.iter().map(|p| p - origin).sum::<DVec3>() / outline.len() as f64;
    Plane { normal: doubled.normalize(), point: origin + middle }
}
