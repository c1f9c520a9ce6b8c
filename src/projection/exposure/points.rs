//! Surface points that several photos show, evenly distributed over the photos.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::options::ExposureOptions;
use super::surface_gains::JoinedFaces;
use crate::Projector;
use crate::model_surface::ModelSurface;
use quadratura_base::error::Result;
use quadratura_base::geometry::Plane;
use quadratura_base::raster::robust::upper_median;
use quadratura_base::scene::{FaceId, Model, PhotoId};
use quadratura_base::task::Task;
use quadratura_view::Blend;
use quadratura_view::weights::pixels_per_unit;
use quadratura_view::weights::{Claim, border, octaves_missing};

/// A surface point with the photos that show it, in the photos' order.
#[derive(Debug, Clone, PartialEq)]
pub struct SharedPoint {
    /// The photo on whose grid the point lies.
    pub own: PhotoId,
    /// The face on which the point lies.
    pub face: FaceId,
    /// The position in world coordinates.
    pub position: DVec3,
    /// The unit normal of the surface, on the side that the photos see.
    pub normal: DVec3,
    /// The point's patches in the photos; at least two.
    pub patches: Vec<PointPatch>,
}

/// The surroundings of a point in one photo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointPatch {
    /// The photo.
    pub photo: PhotoId,
    /// The position of the point, in the photo's pixels.
    pub center_px: DVec2,
    /// The unit direction from the point to the camera.
    pub towards_camera: DVec3,
    /// The distance from the point to the camera, in world units.
    pub distance: f64,
    /// Square root of the number of pixels per unit of the surface's area in the photo: pixels per world
    /// unit, including foreshortening.
    pub px_per_unit: f64,
}

/// A source of answers about which surfaces the photos show.
pub trait Visibility: Sync {
    /// Returns the face that the photo shows at an image point, and the point on it in world coordinates;
    /// `None` where there is none, and for billboards, whose appearance changes with the direction.
    fn surface_at(&self, photo: PhotoId, image_px: DVec2) -> Option<(FaceId, DVec3)>;

    /// Returns true when the photo shows nothing of the model at an image point.
    fn is_open(&self, photo: PhotoId, image_px: DVec2) -> bool;

    /// Returns the face's unit normal.
    fn normal(&self, face: FaceId) -> DVec3;

    /// Returns true when the photo shows the plane of `face` in the whole square of `half_px` around an image
    /// point, and the square lies within the photo.
    fn shows_around(&self, photo: PhotoId, face: FaceId, image_px: DVec2, half_px: f64) -> bool;

    /// Returns the pairs of faces that share an edge, each once.
    fn joined(&self) -> Vec<JoinedFaces>;
}

/// The visibility by ray casting against the model, which agrees with the visible parts in stacks pixel by pixel.
#[derive(Debug)]
pub struct RayVisibility<'a> {
    model: &'a Model,
    surface: ModelSurface,
    photos: &'a [Projector],
}

impl<'a> RayVisibility<'a> {
    /// Builds the visibility of a model in the photos' world.
    pub fn new(model: &'a Model, photos: &'a [Projector]) -> Self {
        Self { model, surface: ModelSurface::from_model(model), photos }
    }

    /// Returns the origin and direction (depth 1 at t = 1) of the ray through an image point.
    fn ray(&self, photo: PhotoId, image_px: DVec2) -> (DVec3, DVec3) {
        let Projector { camera, pose, .. } = &self.photos[photo.index()];
        (pose.center_in_world(), pose.rotation.transpose() * camera.ray_in_camera(image_px))
    }
}

impl Visibility for RayVisibility<'_> {
    fn surface_at(&self, photo: PhotoId, image_px: DVec2) -> Option<(FaceId, DVec3)> {
        let (origin, direction) = self.ray(photo, image_px);
        let hit = self.surface.nearest(origin, direction)?;
        let billboard = self.model.object(self.model.face(hit.face).object).shows_what_is_behind();
        (!billboard).then(|| (hit.face, origin + direction * hit.t))
    }

    fn is_open(&self, photo: PhotoId, image_px: DVec2) -> bool {
        let (origin, direction) = self.ray(photo, image_px);
        self.surface.nearest(origin, direction).is_none()
    }

    fn normal(&self, face: FaceId) -> DVec3 {
        self.model.face(face).plane.normal
    }

    fn shows_around(&self, photo: PhotoId, face: FaceId, image_px: DVec2, half_px: f64) -> bool {
        let camera = &self.photos[photo.index()].camera;
        let size = DVec2::new(camera.width.into(), camera.height.into());
        if (image_px - half_px).min_element() < 0.0 || (image_px + half_px - size).max_element() > 0.0 {
            return false;
        }
        let plane = self.model.face(face).plane;
        // The centre is tested first, because it fails most often.
        let offsets = [0, 1, 2, 3, 5, 6, 7, 8].map(|k| (k % 3, k / 3));
        let around = offsets.into_iter().filter(|_| half_px > 0.0);
        [(1, 1)].into_iter().chain(around).all(|(i, j)| {
            let offset = DVec2::new(f64::from(i - 1), f64::from(j - 1)) * half_px;
            let (origin, direction) = self.ray(photo, image_px + offset);
            let on_plane = -plane.signed_distance(origin) / plane.normal.dot(direction);
            let hit = self.surface.nearest(origin, direction);
            // The limit is coarser than the visibility tolerance, for faces that are not quite planar: what
            // lies this close to the plane has the same pixels in any photo.
            hit.is_some_and(|hit| (hit.t - on_plane).abs() <= 1e-3 * hit.t)
        })
    }

    fn joined(&self) -> Vec<JoinedFaces> {
        // By position: files may repeat vertices.
        let mut of_edge: BTreeMap<[[u64; 3]; 2], Vec<FaceId>> = BTreeMap::new();
        for face in self.model.face_ids() {
            let corners: Vec<[u64; 3]> =
                self.model.ring_points(face).map(|corner| corner.to_array().map(f64::to_bits)).collect();
            for (at, corner) in corners.iter().enumerate() {
                let next = &corners[(at + 1) % corners.len()];
                of_edge.entry([*corner.min(next), *corner.max(next)]).or_default().push(face);
            }
        }
        let pairs = of_edge.into_values().flat_map(|faces| {
            let pairs = faces.windows(2).filter(|pair| pair[0] != pair[1]);
            pairs.map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>()
        });
        let joined: BTreeSet<[FaceId; 2]> = pairs.collect();
        let cosine = |[a, b]: [FaceId; 2]| self.normal(a).dot(self.normal(b)).abs();
        joined.into_iter().map(|faces| JoinedFaces { faces, cosine: cosine(faces) }).collect()
    }
}

/// The least cosine of the angle to the normal; patches of surfaces seen more obliquely are long stripes in
/// other photos.
const LEAST_COSINE: f64 = 0.2;

/// Finds points on the surface from a regular grid over each photo, with all photos that show them well, so
/// that each photo has about the same weight, and near surfaces as much as far ones. The points are in the
/// order of photos, rows and columns, whatever the number of threads.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn shared_points(
    photos: &[Projector],
    visibility: &impl Visibility,
    options: &ExposureOptions,
    task: &Task,
) -> Result<Vec<SharedPoint>> {
    let mut points = Vec::new();
    for (i, projector) in photos.iter().enumerate() {
        task.step("shared points", i as u64, photos.len() as u64)?;
        let photo = PhotoId::new(i);
        let found = grid(projector, options).into_par_iter().filter_map(|image_px| {
            let (face, position) = visibility.surface_at(photo, image_px)?;
            shared_point(photos, visibility, photo, face, position, options)
        });
        points.extend(found.collect::<Vec<_>>());
    }
    task.step("shared points", photos.len() as u64, photos.len() as u64)?;
    Ok(points)
}

/// A surface point that a photo shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpreadPoint {
    /// The photo on whose grid the point lies.
    pub own: PhotoId,
    /// The face on which the point lies.
    pub face: FaceId,
    /// The position in world coordinates.
    pub position: DVec3,
}

/// Finds points on the surface from a regular grid over each of some photos, `points_per_photo` of each, in the order of photos,
/// rows and columns, whatever the number of threads.
pub fn spread_points(
    photos: &[Projector],
    chosen: &[PhotoId],
    visibility: &impl Visibility,
    options: &ExposureOptions,
) -> Vec<SpreadPoint> {
    let of_photo = |own: &PhotoId| {
        let own = *own;
        let point = move |image_px: DVec2| {
            let (face, position) = visibility.surface_at(own, image_px)?;
            Some(SpreadPoint { own, face, position })
        };
        grid(&photos[own.index()], options).into_par_iter().filter_map(point).collect::<Vec<_>>()
    };
    chosen.iter().flat_map(of_photo).collect()
}

/// Returns the grid of image points of one photo.
pub(super) fn grid(projector: &Projector, options: &ExposureOptions) -> Vec<DVec2> {
    let (w, h) = (f64::from(projector.camera.width), f64::from(projector.camera.height));
    let step = (w * h / f64::from(options.points_per_photo.max(1))).sqrt();
    let (columns, rows) = ((w / step).round().max(1.0) as u32, (h / step).round().max(1.0) as u32);
    let spot = |k: u32, of: u32, length: f64| (f64::from(k) + 0.5) / f64::from(of) * length;
    let row = |y: u32| (0..columns).map(move |x| DVec2::new(spot(x, columns, w), spot(y, rows, h)));
    (0..rows).flat_map(row).collect()
}

/// Finds the photos that show a point; `None` unless its own photo and at least one other do.
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
    let patch_if_visible = |photo: PhotoId, side: f64| {
        let patch = patch_in(photo, &photos[photo.index()], position, normal * side)?;
        visibility.shows_around(photo, face, patch.center_px, half_px).then_some(patch)
    };
    // A face has two sides, whose appearance is unrelated.
    let eye = photos[own.index()].pose.center_in_world();
    let side = normal.dot(eye - position).signum();
    patch_if_visible(own, side)?;
    let patches: Vec<PointPatch> =
        PhotoId::all(photos.len()).filter_map(|photo| patch_if_visible(photo, side)).collect();
    (patches.len() >= 2).then_some(SharedPoint { own, face, position, normal: normal * side, patches })
}

/// Computes the patch of a surface point in a photo; `None` from behind the surface, behind the camera, or
/// too obliquely.
pub(super) fn patch_in(
    photo: PhotoId,
    projector: &Projector,
    position: DVec3,
    normal: DVec3,
) -> Option<PointPatch> {
    let eye = projector.pose.center_in_world();
    let in_camera = projector.pose.camera_from_world(position);
    let center_px = projector.camera.image_from_camera(in_camera)?;
    let to_camera = eye - position;
    let distance = to_camera.length();
    let towards_camera = to_camera / distance;
    let cosine = normal.dot(towards_camera);
    let plane = Plane { normal, point: position };
    let px_per_unit = pixels_per_unit(&projector.camera, &plane, eye, in_camera.z);
    (cosine >= LEAST_COSINE).then_some(PointPatch { photo, center_px, towards_camera, distance, px_per_unit })
}

/// Returns the median distance between points and the cameras that see them; 1 without any.
pub(super) fn typical_distance(points: &[SharedPoint]) -> f64 {
    let mut distances: Vec<f64> = points.iter().flat_map(|p| &p.patches).map(|p| p.distance).collect();
    upper_median(&mut distances).unwrap_or(1.0)
}

/// Returns the penalties of photos that show a point, by their patches, for a view like a photo's own patch.
pub(super) fn penalties_of<'a>(
    photos: &[Projector],
    own: &PointPatch,
    others: impl Iterator<Item = &'a PointPatch>,
    blend: &Blend,
) -> Vec<f64> {
    let penalty = |patch: &PointPatch| {
        let chord = (patch.towards_camera - own.towards_camera).length();
        let claim = Claim {
            angle: 2.0 * (0.5 * chord).min(1.0).asin(),
            octaves: octaves_missing(own.px_per_unit, patch.px_per_unit),
            border: border(&photos[patch.photo.index()].camera, patch.center_px),
            confidence: 1.0,
            agreement: 1.0,
        };
        claim.penalty(blend)
    };
    others.map(penalty).collect()
}
