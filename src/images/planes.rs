//! The planes of a stack's surfaces as inverse depth over the photo, with the bits that the sort computes.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use quadratura_base::geometry::clip::clipped_to_box;
use quadratura_base::geometry::polygon::newell_normal;
use quadratura_base::geometry::{InverseDepth, Pinhole, Pose};
use quadratura_base::scene::builder::SURROUNDINGS;
use quadratura_base::scene::impostor::Facing;
use quadratura_base::scene::{FaceId, FaceIndex, Model};
use quadratura_layers::projected_model::ProjectedModel;
use quadratura_ldi::LdiSurface;

/// The plane of a surface.
#[derive(Debug, Clone)]
pub struct SurfacePlane {
    /// The unique name of the object.
    pub object: String,
    /// The face's index within the object; `None` for the surroundings.
    pub face: Option<FaceIndex>,
    /// The face in the model; `None` where the model does not have it.
    pub id: Option<FaceId>,
    /// The inverse depth over the photo; `None` for the surroundings, which are infinitely far away.
    inverse_depth: Option<InverseDepth>,
}

impl SurfacePlane {
    /// Returns the plane of the surroundings, which are infinitely far away.
    pub fn of_surroundings() -> Self {
        Self { object: SURROUNDINGS.to_owned(), face: None, id: None, inverse_depth: None }
    }

    /// Returns the plane of a face of a model, or of one of its triangles.
    pub fn of_face(model: &Model, id: FaceId, inverse_depth: InverseDepth) -> Self {
        let face = model.face(id);
        let object = model.object(face.object).name.clone();
        Self { object, face: Some(face.index), id: Some(id), inverse_depth: Some(inverse_depth) }
    }

    /// Returns the inverse depth at the centre of a pixel; `None` where the plane is behind the camera, or the camera in it.
    pub fn at(&self, x: u32, y: u32) -> Option<f32> {
        let Some(plane) = &self.inverse_depth else { return Some(0.0) };
        let inverse_depth = plane.at(x, y);
        (inverse_depth > 0.0 && inverse_depth <= quadratura_ldi::layout::LARGEST_INVERSE_DEPTH)
            .then_some(inverse_depth)
    }

    /// Returns the surface for the file.
    pub fn surface(&self) -> LdiSurface {
        let nu = self.inverse_depth.map_or(DVec3::ZERO, |InverseDepth { a, b, c, u0, v0 }| {
            let [a, b, c, u0, v0] = [a, b, c, u0, v0].map(f64::from);
            DVec3::new(a, b, c - a * u0 - b * v0)
        });
        LdiSurface { nu, object: self.object.clone(), face: self.face }
    }
}

/// Object, face and triangle.
type PlaneKey = (String, Option<FaceIndex>, Option<u32>);

/// The planes of a stack's surfaces, numbered as they are asked for.
pub struct SurfacePlanes {
    camera: Pinhole,
    pose: Pose,
    model: Arc<Model>,
    /// The planes that the sort has computed of the present model.
    of_items: BTreeMap<(FaceId, Option<u32>), InverseDepth>,
    numbers: BTreeMap<PlaneKey, u32>,
    list: Vec<SurfacePlane>,
}

impl SurfacePlanes {
    /// Prepares the planes as seen by a photo. `current` tells whether the stack was made of this model; where it was not,
    /// the outlines in the stack have the planes.
    pub fn new(model: &Arc<Model>, camera: Pinhole, pose: Pose, current: bool) -> Self {
        let model = model.facing(&Facing::of_pose(&pose));
        let of_items = match current {
            true => {
                let view = ProjectedModel::new(&model, &camera, &pose);
                view.items.iter().map(|item| ((item.face, item.triangle), item.inverse_depth)).collect()
            }
            false => BTreeMap::new(),
        };
        Self { camera, pose, model, of_items, numbers: BTreeMap::new(), list: Vec::new() }
    }

    /// Returns the number of the plane of a surface with this outline, in world coordinates.
    pub fn number(
        &mut self,
        object: &str,
        face: Option<FaceIndex>,
        triangle: Option<u32>,
        outline: &[[f64; 3]],
    ) -> u32 {
        let key = (object.to_owned(), face, triangle);
        if let Some(number) = self.numbers.get(&key) {
            return *number;
        }
        let plane = match face {
            None => SurfacePlane::of_surroundings(),
            Some(index) => {
                let id = self.model.face_named(object, index);
                let of_item = id.and_then(|id| self.of_items.get(&(id, triangle)).copied());
                let inverse_depth = Some(of_item.unwrap_or_else(|| self.of_outline(outline)));
                SurfacePlane { object: object.to_owned(), face, id, inverse_depth }
            }
        };
        let number = self.list.len() as u32;
        self.list.push(plane);
        self.numbers.insert(key, number);
        number
    }

    /// Returns the number of the surroundings' plane.
    pub fn surroundings(&mut self) -> u32 {
        self.number(SURROUNDINGS, None, None, &[])
    }

    /// Returns the model as the photo sees it, and the planes.
    pub fn finish(self) -> (Arc<Model>, Vec<SurfacePlane>) {
        (self.model, self.list)
    }

    /// Returns the inverse depth of an outline's own plane. It is not a number where the camera is in the plane.
    fn of_outline(&self, outline: &[[f64; 3]]) -> InverseDepth {
        let point = |p: &[f64; 3]| self.pose.camera_from_world(DVec3::from_array(*p));
        let ring: Vec<DVec3> = outline.iter().map(point).collect();
        let normal = newell_normal(&ring).normalize_or_zero();
        let middle = ring.iter().sum::<DVec3>() / ring.len().max(1) as f64;
        let size = DVec2::new(f64::from(self.camera.width), f64::from(self.camera.height));
        let clipped = clipped_to_box(&ring, &self.camera, DVec2::ZERO, size);
        let farthest = clipped.into_iter().max_by(|a, b| a.z.total_cmp(&b.z));
        let around = farthest.and_then(|point| self.camera.image_from_camera(point));
        let around = around.unwrap_or(DVec2::new(self.camera.cx, self.camera.cy));
        InverseDepth::of_plane(normal, normal.dot(middle), around, &self.camera)
    }
}
