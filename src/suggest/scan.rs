//! A dense mesh in the place of sparse points: what photos see of it.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use quadratura_base::error::Result;
use quadratura_base::geometry::bvh::Bvh;
use quadratura_base::task::Task;

use super::points::SourcePoint;
use super::view::SourcePhoto;

/// The points that all photos together take of a mesh.
const POINTS: usize = 30_000;
/// The error of an observation in pixels of the photos at the fine size.
const ERROR_PX: f64 = 0.5;
/// A place is seen where nothing is nearer by more than this share of its distance: triangles of scans are rough.
const SAME: f64 = 0.01;
/// The cosine of the steepest angle at which a place is seen, 80 degrees.
const STEEPEST: f64 = 0.17;
/// The stage that is reported.
const STAGE: &str = "see the mesh";

/// Returns points on a mesh as photos see it, about as many in each, with all photos that see them. Triangles may be wound
/// either way.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`] on request.
pub fn points_of_mesh(mesh: &Bvh, photos: &[SourcePhoto], task: &Task) -> Result<Vec<SourcePoint>> {
    let share = POINTS.div_ceil(photos.len().max(1));
    let mut points = Vec::new();
    for (done, photo) in (0u64..).zip(photos) {
        task.step(STAGE, done, photos.len() as u64)?;
        let (w, h) = (f64::from(photo.camera.width), f64::from(photo.camera.height));
        let step = (w * h / share as f64).sqrt().max(1.0);
        let (columns, rows) = ((w / step) as usize, (h / step) as usize);
        let seen = |at: usize| {
            let px = DVec2::new((at % columns) as f64 + 0.5, (at / columns) as f64 + 0.5) * step;
            let eye = photo.pose.center_in_world();
            let ray = photo.pose.rotation.transpose() * photo.camera.ray_in_camera(px);
            let (t, triangle) = mesh.first_hit(eye, ray, f64::INFINITY)?;
            seen_by_all(mesh, eye + ray * t, triangle, photos)
        };
        points.extend((0..columns * rows).into_par_iter().filter_map(seen).collect::<Vec<_>>());
    }
    task.step(STAGE, photos.len() as u64, photos.len() as u64)?;
    Ok(points)
}

/// Returns a place of a triangle with the photos that see it; `None` for fewer than two.
fn seen_by_all(mesh: &Bvh, at: DVec3, triangle: u32, photos: &[SourcePhoto]) -> Option<SourcePoint> {
    let [a, b, c] = mesh.triangles()[triangle as usize];
    let normal = (b - a).cross(c - a).try_normalize()?;
    let sees = |photo: &SourcePhoto| {
        let in_camera = photo.pose.camera_from_world(at);
        let is_inside = photo
            .camera
            .image_from_camera(in_camera)
            .is_some_and(|px| photo.camera.rect().contains_position(px));
        let eye = photo.pose.center_in_world();
        is_inside
            && (eye - at).normalize_or_zero().dot(normal).abs() > STEEPEST
            && mesh.first_hit(eye, at - eye, 1.0 - SAME).is_none()
    };
    let observers: Vec<u32> = (0..).zip(photos).filter(|(_, photo)| sees(photo)).map(|(i, _)| i).collect();
    let error_rad = ERROR_PX / photos[*observers.first()? as usize].camera.fx;
    (observers.len() > 1).then_some(SourcePoint { position: at, observers, error_rad })
}
