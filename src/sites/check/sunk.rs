//! Intersections that no photo shows: a wall that is sunk into the ground ends below it, out of sight.

use rustc_hash::FxHashMap;

use super::faces::CheckedSurface;
use quadratura_base::error::Result;
use quadratura_base::geometry::polygon::extent;
use quadratura_base::scene::{FaceId, Model, Photo, Site};
use quadratura_base::task::Task;

/// A pair of intersecting faces, in model order, with its depth in world units.
pub type CrossingPair = ([FaceId; 2], f64);

/// Sorts pairs of intersecting faces into those of which one face ends behind the other where no photo shows it, and
/// the others. The order is kept.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`] on request.
pub fn parted(
    site: &Site,
    surface: &CheckedSurface,
    pairs: Vec<CrossingPair>,
    task: &Task,
) -> Result<(Vec<CrossingPair>, Vec<CrossingPair>)> {
    let mut corners = Corners { site, surface, shown: FxHashMap::default() };
    let (mut sunk, mut others) = (Vec::new(), Vec::new());
    for pair in pairs {
        task.check_cancelled()?;
        let [a, b] = pair.0;
        let is_sunk = corners.ends_behind(a, b) || corners.ends_behind(b, a);
        if is_sunk { &mut sunk } else { &mut others }.push(pair);
    }
    Ok((sunk, others))
}

/// The corners of a model, and which of them photos show.
struct Corners<'a> {
    site: &'a Site,
    surface: &'a CheckedSurface,
    /// By vertex, whether a photo shows it.
    shown: FxHashMap<u32, bool>,
}

/// A corner is behind a plane when it is farther from it than this share of the face's extent, as for intersections.
const BEHIND: f64 = 1e-3;

/// The ray to a corner ends before it by this share of its length, so that it does not meet the corner's own faces.
const BEFORE: f64 = 1e-4;

impl Corners<'_> {
    /// Returns whether `face` reaches through the front of `front`, and no photo shows any corner of it behind.
    fn ends_behind(&mut self, face: FaceId, front: FaceId) -> bool {
        let model: &Model = &self.site.model;
        let plane = &model.face(front).plane;
        let tolerance = BEHIND * extent(&model.ring_points(face).collect::<Vec<_>>());
        let distance = |vertex: &u32| plane.signed_distance(model.vertices[*vertex as usize]);
        let ring = model.ring(face);
        let behind: Vec<u32> = ring.iter().copied().filter(|vertex| distance(vertex) < -tolerance).collect();
        let reaches_through = !behind.is_empty() && ring.iter().any(|vertex| distance(vertex) > tolerance);
        reaches_through && !behind.into_iter().any(|vertex| self.is_shown(vertex))
    }

    fn is_shown(&mut self, vertex: u32) -> bool {
        let (site, surface) = (self.site, self.surface);
        *self
            .shown
            .entry(vertex)
            .or_insert_with(|| site.photos.iter().any(|photo| shows(site, surface, photo, vertex)))
    }
}

/// Returns whether nothing is in front of a vertex in the photo.
fn shows(site: &Site, surface: &CheckedSurface, photo: &Photo, vertex: u32) -> bool {
    let point = site.model.vertices[vertex as usize];
    let px = photo.camera.image_from_camera(photo.pose.camera_from_world(point));
    if !px.is_some_and(|px| photo.camera.rect().contains_position(px)) {
        return false;
    }
    let eye = photo.pose.center_in_world();
    surface.tree.first_hit(eye, point - eye, 1.0 - BEFORE).is_none()
}
