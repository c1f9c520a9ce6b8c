//! The model as seen by the photos.

use std::sync::Arc;

use quadratura_base::error::Result;
use quadratura_base::geometry::Pinhole;
use quadratura_base::scene::impostor::Facing;
use quadratura_base::scene::{FaceId, Model, Photo};
use quadratura_base::task::Task;
use quadratura_layers::rasteriser::{Band, Presence, VISIBLE};
use quadratura_layers::{Fragments, ProjectedModel, Rasteriser};

/// The longest side in pixels at which the model is rendered: the user should know of faces smaller than a pixel at
/// this size.
const LONGEST_SIDE: u32 = 2048;

/// The model as seen by one photo.
#[derive(Debug, Clone, PartialEq)]
pub struct VisibleModel {
    /// The share of the model's vertices in front of the camera.
    pub in_front: f64,
    /// The share of the model's vertices within the photo.
    pub inside: f64,
    /// The share of the photo's pixels that the model covers.
    pub covered: f64,
    /// The faces that are visible at one pixel or more, in model order.
    pub faces: Vec<VisibleFace>,
}

/// A visible face of a photo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VisibleFace {
    /// The face.
    pub face: FaceId,
    /// Whether it is seen from behind.
    pub back: bool,
    /// The number of pixels at which it is visible, at the reduced size.
    pub px: u32,
}

/// Renders the model with one photo's camera at reduced size.
///
/// # Errors
/// Returns [`quadratura_base::Error::Gpu`] or [`quadratura_base::Error::Cancelled`].
pub fn look(
    model: &Arc<Model>,
    photo: &Photo,
    rasteriser: &dyn Rasteriser,
    tolerance: f32,
    task: &Task,
) -> Result<VisibleModel> {
    let camera = reduced(&photo.camera);
    let view = ProjectedModel::new(&model.facing(&Facing::of_pose(&photo.pose)), &camera, &photo.pose);
    let fragments = rasteriser.fragments(&view, tolerance, task)?;
    let (in_front, inside) = vertex_shares(model, photo);
    let faces = visible_faces(&view, &fragments);
    Ok(VisibleModel { in_front, inside, covered: covered(&fragments, &camera), faces })
}

/// Returns the visible faces with their numbers of pixels.
fn visible_faces(view: &ProjectedModel, fragments: &Fragments) -> Vec<VisibleFace> {
    let mut px = vec![0; view.items.len()];
    let entries = fragments.lists.bands.iter().flat_map(|band| &band.entries);
    for entry in entries.filter(|&entry| entry & VISIBLE != 0) {
        px[(entry & !VISIBLE) as usize] += 1;
    }
    let items = view.items.iter().zip(&fragments.presence).zip(px);
    let working = items.filter(|((_, presence), _)| **presence == Presence::Working);
    let seen = working.map(|((item, _), px)| VisibleFace { face: item.face, back: item.back, px });
    let mut faces: Vec<VisibleFace> = seen.collect();
    // The triangles of a non-planar face are consecutive.
    faces.dedup_by(|next, first| {
        let same = next.face == first.face;
        first.px += if same { next.px } else { 0 };
        same
    });
    faces
}

/// Returns the same camera with fewer pixels.
fn reduced(camera: &Pinhole) -> Pinhole {
    let longest = camera.width.max(camera.height);
    if longest <= LONGEST_SIDE {
        return *camera;
    }
    let scale = f64::from(LONGEST_SIDE) / f64::from(longest);
    let side = |px: u32| ((f64::from(px) * scale).round() as u32).max(1);
    let (width, height) = (side(camera.width), side(camera.height));
    let (x, y) = (f64::from(width) / f64::from(camera.width), f64::from(height) / f64::from(camera.height));
    Pinhole { width, height, fx: camera.fx * x, cx: camera.cx * x, fy: camera.fy * y, cy: camera.cy * y }
}

/// Returns the shares of vertices in front of the camera and within the photo.
fn vertex_shares(model: &Model, photo: &Photo) -> (f64, f64) {
    let mut in_front = 0usize;
    let mut inside = 0usize;
    for &vertex in &model.vertices {
        if let Some(px) = photo.camera.image_from_camera(photo.pose.camera_from_world(vertex)) {
            in_front += 1;
            inside += usize::from(photo.camera.rect().contains_position(px));
        }
    }
    let share = |count: usize| count as f64 / model.vertices.len().max(1) as f64;
    (share(in_front), share(inside))
}

/// Returns the share of pixels that the model covers.
fn covered(fragments: &Fragments, camera: &Pinhole) -> f64 {
    let filled = |band: &Band| {
        let pixels = band.offsets.windows(2);
        pixels.filter(|w| band.entries[w[0] as usize..w[1] as usize].iter().any(|e| e & VISIBLE != 0)).count()
    };
    let count: usize = fragments.lists.bands.iter().map(filled).sum();
    count as f64 / (f64::from(camera.width) * f64::from(camera.height))
}
