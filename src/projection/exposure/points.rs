//! Surface points that several photos show, spread evenly over what the photos see.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::ExposureOptions;
use crate::error::Result;
use crate::geometry::Plane;
use crate::projection::surface::Surface;
use crate::projection::weights::pixels_per_unit;
use crate::projection::{PhotoId, Projector};
use crate::scene::{FaceId, Model};
use crate::task::Task;

/// A surface point with the photos that show it, in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct SharedPoint {
    /// In the world.
    pub position: DVec3,
    /// Of the surface, on the side that the photos see; length 1.
    pub normal: DVec3,
    /// Two or more.
    pub patches: Vec<Patch>,
}

/// The surroundings of a point in one photo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    /// The photo.
    pub photo: PhotoId,
    /// Where the point is, in the photo's pixels.
    pub center_px: DVec2,
    /// From the point to the camera, length 1.
    pub towards_camera: DVec3,
    /// From the point to the camera, in world units.
    pub distance: f64,
    /// Square root of the pixels that a unit of the surface's area has in the photo: pixels per world
    /// unit, foreshortening included.
    pub px_per_unit: f64,
}

/// What the photos see of the model.
pub trait Visibility: Sync {
    /// The face that the photo shows at an image point, and where on it; `None` for none and for
    /// things whose looks change with the direction (billboards).
    fn surface_at(&self, photo: PhotoId, image_px: DVec2) -> Option<(FaceId, DVec3)>;

    /// The face's unit normal.
    fn normal(&self, face: FaceId) -> DVec3;

    /// Whether the photo shows the plane of `face` all over the square of `half_px` around an image
    /// point, all of it within the photo.
    fn shows_around(&self, photo: PhotoId, face: FaceId, image_px: DVec2, half_px: f64) -> bool;
}

/// Visibility by rays onto the model: that is what stacks' visible parts are cut from, pixel by pixel.
#[derive(Debug)]
pub struct RayVisibility<'a> {
    model: &'a Model,
    surface: Surface,
    photos: &'a [Projector],
}

impl<'a> RayVisibility<'a> {
    /// Of a model in the photos' world.
    pub fn new(model: &'a Model, photos: &'a [Projector]) -> Self {
        Self { model, surface: Surface::of(model), photos }
    }

    /// Origin and direction (depth 1 at t = 1) of the ray through an image point.
    fn ray(&self, photo: PhotoId, image_px: DVec2) -> (DVec3, DVec3) {
        let Projector { camera, pose, .. } = &self.photos[photo.0 as usize];
        (pose.center_in_world(), pose.rotation.transpose() * camera.ray_in_camera(image_px))
    }
}

impl Visibility for RayVisibility<'_> {
    fn surface_at(&self, photo: PhotoId, image_px: DVec2) -> Option<(FaceId, DVec3)> {
        let (origin, direction) = self.ray(photo, image_px);
        let hit = self.surface.nearest(origin, direction)?;
        let billboard = self.model.object(self.model.face(hit.face).object).billboard;
        (!billboard).then(|| (hit.face, origin + direction * hit.t))
    }

    fn normal(&self, face: FaceId) -> DVec3 {
        self.model.face(face).plane.normal
    }

    fn shows_around(&self, photo: PhotoId, face: FaceId, image_px: DVec2, half_px: f64) -> bool {
        let camera = &self.photos[photo.0 as usize].camera;
        let size = DVec2::new(camera.width.into(), camera.height.into());
        if (image_px - half_px).min_element() < 0.0 || (image_px + half_px - size).max_element() > 0.0 {
            return false;
        }
        let plane = self.model.face(face).plane;
        // The middle first: it says no most often.
        let places = [0, 1, 2, 3, 5, 6, 7, 8].map(|k| (k % 3, k / 3));
        [(1, 1)].into_iter().chain(places).all(|(i, j)| {
            let offset = DVec2::new(f64::from(i - 1), f64::from(j - 1)) * half_px;
            let (origin, direction) = self.ray(photo, image_px + offset);
            let on_plane = -plane.signed_distance(origin) / plane.normal.dot(direction);
            let hit = self.surface.nearest(origin, direction);
            // Coarser than the visibility tolerance, for faces that are not quite planar: what lies
            // this near to the plane has the same pixels in any photo.
            hit.is_some_and(|hit| (hit.t - on_plane).abs() <= 1e-3 * hit.t)
        })
    }
}

/// Surfaces seen more obliquely are left out: their patches are long stripes elsewhere.
const LEAST_COSINE: f64 = 0.2;

/// Points on the surface, from a regular grid over each photo, with all photos that show them well.
/// So each photo has about the same say, and near things as much as far ones. In the order of photos,
/// rows and columns, whatever the number of threads.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn spread_points(
    photos: &[Projector],
    visibility: &impl Visibility,
    options: &ExposureOptions,
    task: &Task,
) -> Result<Vec<SharedPoint>> {
    let mut points = Vec::new();
    for (i, projector) in photos.iter().enumerate() {
        task.step("shared points", i as u64, photos.len() as u64)?;
        let photo = PhotoId(i as u32);
        let found = grid(projector, options).into_par_iter().filter_map(|image_px| {
            let (face, position) = visibility.surface_at(photo, image_px)?;
            shared_point(photos, visibility, photo, face, position, options)
        });
        points.extend(found.collect::<Vec<_>>());
    }
    task.step("shared points", photos.len() as u64, photos.len() as u64)?;
    Ok(points)
}

/// Image points of one photo.
fn grid(projector: &Projector, options: &ExposureOptions) -> Vec<DVec2> {
    let (w, h) = (f64::from(projector.camera.width), f64::from(projector.camera.height));
    let step = (w * h / f64::from(options.points_per_photo.max(1))).sqrt();
    let (columns, rows) = ((w / step).round().max(1.0) as u32, (h / step).round().max(1.0) as u32);
    let place = |k: u32, of: u32, length: f64| (f64::from(k) + 0.5) / f64::from(of) * length;
    let row = |y: u32| (0..columns).map(move |x| DVec2::new(place(x, columns, w), place(y, rows, h)));
    (0..rows).flat_map(row).collect()
}

/// The point with the photos that show it, if its own is one of them and not the only one.
fn shared_point(
    photos: &[Projector],
    visibility: &impl Visibility,
    own: PhotoId,
    face: FaceId,
    position: DVec3,
    options: &ExposureOptions,
) -> Option<SharedPoint> {
    let normal = visibility.normal(face);
    let half_px = options.half_patch_px + options.border_px;
    let shown = |photo: PhotoId, side: f64| {
        let patch = patch_in(photo, &photos[photo.0 as usize], position, normal * side)?;
        visibility.shows_around(photo, face, patch.center_px, half_px).then_some(patch)
    };
    // A face has two sides, and they have nothing in common.
    let eye = photos[own.0 as usize].pose.center_in_world();
    let side = normal.dot(eye - position).signum();
    shown(own, side)?;
    let patches: Vec<Patch> =
        (0..photos.len() as u32).filter_map(|photo| shown(PhotoId(photo), side)).collect();
    (patches.len() >= 2).then_some(SharedPoint { position, normal: normal * side, patches })
}

/// How a photo sees a point of a surface; `None` behind it, behind the camera, or too obliquely.
fn patch_in(photo: PhotoId, projector: &Projector, position: DVec3, normal: DVec3) -> Option<Patch> {
    let eye = projector.pose.center_in_world();
    let in_camera = projector.pose.camera_from_world(position);
    let center_px = projector.camera.image_from_camera(in_camera)?;
    let to_camera = eye - position;
    let distance = to_camera.length();
    let towards_camera = to_camera / distance;
    let cosine = normal.dot(towards_camera);
    let plane = Plane { normal, point: position };
    let px_per_unit = pixels_per_unit(&projector.camera, &plane, eye, in_camera.z);
    (cosine >= LEAST_COSINE).then_some(Patch { photo, center_px, towards_camera, distance, px_per_unit })
}
