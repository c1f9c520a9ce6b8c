//! Places all over photos: what a whole photo that is left out is predicted from.
//!
//! Common points ([`super::points`]) are those at which colours can be compared well: on plain surfaces, away from outlines. A picture
//! is more than that. Its places lie on a grid over the whole photo, next to outlines, too, and where no face is, in the surroundings,
//! which are as far away as nothing else, so that a direction decides.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::options::ExposureOptions;
use super::points::{PointPatch, Visibility, grid, patch_in};
use crate::Projector;
use quadratura_base::scene::{FaceId, PhotoId};

/// A place of a photo, with the photos that show the same there.
#[derive(Debug, Clone, PartialEq)]
pub struct PhotoPlace {
    /// The photo on whose grid the place lies.
    pub own: PhotoId,
    /// The face that it shows there; `None` for the surroundings.
    pub face: Option<FaceId>,
    /// The patches in its own photo and in others, in the photos' order; at least two.
    pub patches: Vec<PointPatch>,
}

/// The distance of surroundings in typical distances of surfaces, as far as angles between photos go.
const SURROUNDINGS: f64 = 8.0;

/// Finds places on a grid over each photo that other photos show, too, in the order of photos, rows and columns. `reach` is the typical
/// distance of surfaces from their cameras.
pub fn places_of_photos(
    photos: &[Projector],
    visibility: &impl Visibility,
    reach: f64,
    options: &ExposureOptions,
) -> Vec<PhotoPlace> {
    let of_photo = |own: PhotoId| {
        let place = move |px: DVec2| place_at(photos, visibility, own, px, SURROUNDINGS * reach);
        grid(&photos[own.index()], options).into_par_iter().filter_map(place).collect::<Vec<_>>()
    };
    PhotoId::all(photos.len()).flat_map(of_photo).collect()
}

/// Returns the place at a position of a photo; `None` where no other photo shows the same.
fn place_at(
    photos: &[Projector],
    visibility: &impl Visibility,
    own: PhotoId,
    px: DVec2,
    far: f64,
) -> Option<PhotoPlace> {
    let others = || PhotoId::all(photos.len());
    let Some((face, position)) = visibility.surface_at(own, px) else {
        if !visibility.is_open(own, px) {
            return None;
        }
        let Projector { camera, pose, .. } = &photos[own.index()];
        let direction = pose.rotation.transpose() * camera.ray_in_camera(px).normalize();
        let (eye, away) = (pose.center_in_world(), direction * far);
        let open = |photo: PhotoId| {
            let patch = open_patch(photo, &photos[photo.index()], eye, away)?;
            (photo == own || visibility.is_open(photo, patch.center_px)).then_some(patch)
        };
        let patches: Vec<PointPatch> = others().filter_map(open).collect();
        return (patches.len() >= 2).then_some(PhotoPlace { own, face: None, patches });
    };
    let normal = visibility.normal(face);
    let side = normal.dot(photos[own.index()].pose.center_in_world() - position).signum();
    let shown = |photo: PhotoId| {
        let patch = patch_in(photo, &photos[photo.index()], position, normal * side)?;
        (photo == own || visibility.shows_around(photo, face, patch.center_px, 0.0)).then_some(patch)
    };
    let patches: Vec<PointPatch> = others().filter_map(shown).collect();
    let is_shown = patches.len() >= 2 && patches.iter().any(|patch| patch.photo == own);
    is_shown.then_some(PhotoPlace { own, face: Some(face), patches })
}

/// Returns the patch of surroundings in a photo: at infinity as to its position, and so far away from the viewpoint as to angles.
fn open_patch(photo: PhotoId, projector: &Projector, eye: DVec3, away: DVec3) -> Option<PointPatch> {
    let Projector { camera, pose, .. } = projector;
    let center_px = camera.image_from_camera(pose.rotation * away)?;
    let to_camera = pose.center_in_world() - (eye + away);
    let distance = to_camera.length();
    let px_per_unit = (camera.fx * camera.fy).sqrt() / distance;
    let is_inside = camera.rect().contains_position(center_px);
    is_inside.then(|| PointPatch {
        photo,
        center_px,
        towards_camera: to_camera / distance,
        distance,
        px_per_unit,
    })
}
