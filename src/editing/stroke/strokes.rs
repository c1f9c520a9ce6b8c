//! The paint of earlier strokes in the paint book, to which a stroke adds or from which it removes.

use std::collections::BTreeMap;

use glam::DVec2;

use super::dabs::Dabs;
use super::grid::{ViewGrid, centre};
use crate::import::session::PaintSession;
use crate::import::settle::SurfacePaint;
use quadratura_base::error::Result;
use quadratura_base::geometry::Plane;
use quadratura_base::geometry::polygon::fit_plane;
use quadratura_base::scene::impostor::Facing;
use quadratura_base::scene::{FaceId, PhotoId, Site};
use quadratura_document::paint::{PaintEntry, PaintPatch, PaintedView};
use quadratura_projection::LayerTextureId;
use quadratura_projection::twin::{ProbedPoint, ReferenceRenderer};
use quadratura_stacks::paint::parts::{camera_of, points};
use quadratura_view::Shot;

/// The effect of a brush that paints from which it replaces the paint of other photos. Paint of strokes has no opacity
/// of its own that could be reduced: it is mixed with what was below it. An eraser therefore removes all paint that it
/// touches: otherwise a soft stroke would leave a halo along the path of the same brush.
const REPLACES_FROM: f64 = 0.5;

/// The share of the distance from the viewer within which two planes are one: as in the visibility sort.
const SAME_PLANE: f64 = 1e-4;

/// The layer of a photo with its strokes.
pub struct StrokedPlace {
    pub view: PaintedView,
    pub layer: String,
    pub document: String,
}

/// Returns all paint of strokes on a layer of a document, by surface.
///
/// # Errors
/// Returns the error of a picture that is damaged: its paint would be lost for good.
pub fn own_surfaces(session: &PaintSession, document: &str, layer: &str) -> Result<Vec<SurfacePaint>> {
    let mut surfaces: BTreeMap<_, SurfacePaint> = BTreeMap::new();
    let own = |entry: &&PaintEntry| entry.document == document && entry.layer == layer;
    let mut entries: Vec<&PaintEntry> = session.book().entries.iter().filter(own).collect();
    entries.sort_by_key(|entry| entry.import);
    for entry in entries {
        let patch = session.whole_pixels(entry)?;
        let key = (entry.object.clone(), entry.face, entry.triangle, entry.beyond);
        let surface = surfaces.entry(key).or_insert_with(|| SurfacePaint {
            object: entry.object.clone(),
            face: entry.face,
            triangle: entry.triangle,
            beyond: entry.beyond,
            outline: entry.outline.clone(),
            patch: PaintPatch::of_pixels(&[]),
        });
        surface.patch = surface.patch.under(&patch);
    }
    Ok(surfaces.into_values().collect())
}

/// What erases the paint of strokes.
pub struct Eraser<'a> {
    pub site: &'a Site,
    pub renderer: &'a ReferenceRenderer,
    pub shot: &'a Shot,
    pub dabs: &'a Dabs,
    pub grid: &'a ViewGrid,
    /// Whether the photo with most weight keeps its paint, because the stroke paints there.
    pub only_others: bool,
}

impl Eraser<'_> {
    /// Returns the layers with paint of strokes under the brush, each with all that is left of this paint.
    ///
    /// # Errors
    /// Returns the errors of reading paint.
    pub fn left(&self, session: &PaintSession) -> Result<Vec<(StrokedPlace, Vec<SurfacePaint>)>> {
        let strokes = session.book().entries.iter().filter(|entry| entry.is_of_brush());
        let places: BTreeMap<(&str, &str), &PaintEntry> =
            strokes.map(|entry| ((entry.document.as_str(), entry.layer.as_str()), entry)).collect();
        let mut changed = Vec::new();
        for ((document, layer), entry) in places {
            let Some(view) = session.book().views.get(&entry.view) else { continue };
            let Some(photo) = self.photo_of(view) else { continue };
            let mut surfaces = own_surfaces(session, document, layer)?;
            let before: u64 = surfaces.iter().map(|surface| surface.patch.count()).sum();
            surfaces.iter_mut().for_each(|surface| self.erase(photo, surface));
            if surfaces.iter().map(|surface| surface.patch.count()).sum::<u64>() != before {
                surfaces.retain(|surface| !surface.patch.is_empty());
                let place = StrokedPlace {
                    view: view.clone(),
                    layer: layer.to_owned(),
                    document: document.to_owned(),
                };
                changed.push((place, surfaces));
            }
        }
        Ok(changed)
    }

    /// Returns the photo with this camera; `None` where the site has it no longer, or with another camera.
    fn photo_of(&self, view: &PaintedView) -> Option<PhotoId> {
        let id = self.site.photo_named(&view.photo.name)?;
        let photo = self.site.photo(id);
        (camera_of(&view.photo, &view.camera) == (photo.camera, photo.pose)).then_some(id)
    }

    /// Removes the paint of a surface that is under the brush.
    fn erase(&self, photo: PhotoId, surface: &mut SurfacePaint) {
        let model = self.renderer.model();
        let named = surface.face.and_then(|face| model.face_named(&surface.object, face));
        let Some(face) = named else { return };
        let plane = match model.impostor(face) {
            Some(impostor) => Some(impostor.plane(&Facing::of_pose(&self.shot.pose))),
            None => fit_plane(&points(&surface.outline)),
        };
        let Some(plane) = plane else { return };
        surface.patch = surface.patch.picked(|x, y, _| !self.is_under(photo, face, &plane, centre((x, y))));
    }

    fn is_under(&self, photo: PhotoId, face: FaceId, plane: &Plane, px: DVec2) -> bool {
        let under = || {
            let point = self.renderer.point_in_photo(self.shot, photo, px, face, plane)?;
            let in_camera = self.shot.pose.camera_from_world(point);
            let in_view = self.shot.camera.image_from_camera(in_camera)?;
            // A window drawn on a wall shares its paint with the wall.
            let same = |seen: &ProbedPoint| {
                seen.hit.face == face || seen.plane.signed_distance(point).abs() <= SAME_PLANE * in_camera.z
            };
            let is_kept = || {
                let texture = self.grid.texture_at(in_view, same);
                self.only_others && texture.is_none_or(|texture| self.of_texture(texture) == photo)
            };
            let effect = self.dabs.effect(point);
            let is_removed = if self.only_others { effect >= REPLACES_FROM } else { effect > 0.0 };
            Some(is_removed && self.grid.shows(in_view, same) && !is_kept())
        };
        under().unwrap_or(false)
    }

    fn of_texture(&self, texture: LayerTextureId) -> PhotoId {
        self.renderer.sources().layer_texture(texture).photo
    }
}
