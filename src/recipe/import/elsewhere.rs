//! Paint of other photos on the surfaces that an import paints: where it differs, each photo keeps its own.
//!
//! This is found from the paint book alone, without photos and stacks: paint is compared through the plane of the
//! surface, as if the photos had the same exposure and the surface no relief.

use std::collections::BTreeMap;

use glam::DVec2;
use serde::Serialize;

use crate::document::paint::{PaintBook, PaintColour, PaintEntry, PaintPatch};
use crate::error::Result;
use crate::geometry::polygon::{extent, fit_plane};
use crate::geometry::{Pinhole, Plane, Pose};
use crate::layers::fill::FillOptions;
use crate::layers::fill::ranked_donors::paints_differ;
use crate::raster::in_8_bits;
use crate::recipe::paint::parts::{camera_of, points};
use crate::scene::light::LINEAR_FROM_BYTE;

/// The number of new pixels per surface that are compared at most. They are spread evenly, and their counts scaled, so
/// that importing a wall that was painted as a whole takes no longer.
const MOST_COMPARED: usize = 20_000;

/// The distance from the plane, as a share of the surface's size, within which another surface is the same place: that
/// of windows drawn on a wall.
const SAME_PLACE: f64 = 1e-3;

/// Paint of another photo that differs from imported paint at the same places of a surface.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct PaintElsewhere {
    /// The other photo.
    pub photo: String,
    /// The face on which it is painted there, as `object[index]`.
    pub face: String,
    /// The photo that the import painted.
    pub imported_in: String,
    /// The number of imported pixels at whose places the other photo has clearly other paint, or has erased; an
    /// estimate where many pixels were imported.
    pub pixels: u64,
}

/// Returns the paint of other photos that differs from that of the import `number` in `book`, by photo and face. Paint
/// that the options do not project takes no part. `read` returns the pixels of an entry, or `None` where they are lost.
///
/// # Errors
/// Returns the errors of `read`.
pub fn paint_elsewhere(
    book: &PaintBook,
    number: u32,
    options: &FillOptions,
    read: &dyn Fn(&PaintEntry) -> Result<Option<PaintPatch>>,
) -> Result<Vec<PaintElsewhere>> {
    let is_seen = |entry: &&PaintEntry| {
        !entry.beyond && options.propagates(&entry.photo) && !options.stays(&entry.place())
    };
    let mut found: BTreeMap<(String, String, String), u64> = BTreeMap::new();
    for new in book.entries.iter().filter(|entry| entry.import == number).filter(is_seen) {
        let Some(here) = PaintedPlane::new(book, new) else { continue };
        // A stroke that crosses photos does not contradict itself where they meet.
        let is_same_stroke = |entry: &&PaintEntry| entry.import == number && entry.is_of_brush();
        let theirs = book.entries.iter().filter(|entry| entry.photo != new.photo && !entry.beyond);
        let theirs = theirs.filter(|entry| !is_same_stroke(entry));
        let theirs: Vec<_> = theirs.filter(|entry| here.is_level(entry)).collect();
        if theirs.is_empty() {
            continue;
        }
        let Some(patch) = read(new)? else { continue };
        for entry in theirs {
            let Some(other) = PaintedPlane::new(book, entry) else { continue };
            let Some(paint) = read(entry)? else { continue };
            let pixels = here.differing(&patch, &other, &paint);
            if pixels > 0 {
                let key = (entry.photo.clone(), entry.face_name(), new.photo.clone());
                *found.entry(key).or_default() += pixels;
            }
        }
    }
    let entry = |((photo, face, imported_in), pixels)| PaintElsewhere { photo, face, imported_in, pixels };
    Ok(found.into_iter().map(entry).collect())
}

/// The plane of a painted surface, and the camera under which it was painted.
struct PaintedPlane {
    plane: Plane,
    extent: f64,
    camera: Pinhole,
    pose: Pose,
}

impl PaintedPlane {
    /// Returns those of an entry; `None` where its surface or camera is unknown.
    fn new(book: &PaintBook, entry: &PaintEntry) -> Option<Self> {
        let view = book.views.get(&entry.view)?;
        let outline = points(&entry.outline);
        let plane = fit_plane(&outline)?;
        let (camera, pose) = camera_of(&view.photo, &view.camera);
        Some(Self { plane, extent: extent(&outline), camera, pose })
    }

    /// Returns true when the surface of an entry lies in this plane.
    fn is_level(&self, entry: &PaintEntry) -> bool {
        let outline = points(&entry.outline);
        let near = SAME_PLACE * self.extent.max(extent(&outline));
        !outline.is_empty() && outline.iter().all(|point| self.plane.signed_distance(*point).abs() <= near)
    }

    /// Returns the number of pixels of `patch` at whose places `paint` of the other view clearly differs.
    fn differing(&self, patch: &PaintPatch, other: &Self, paint: &PaintPatch) -> u64 {
        let step = (patch.count() as usize).div_ceil(MOST_COMPARED).max(1);
        let differs = |&(x, y, colour): &(i32, i32, PaintColour)| {
            let there = self.place_in(other, DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
            let theirs = there.and_then(|px| paint.at(px.x.floor() as i32, px.y.floor() as i32));
            theirs.is_some_and(|theirs| colours_differ(colour, theirs))
        };
        (step * patch.iter().step_by(step).filter(differs).count()) as u64
    }

    /// Returns the position in pixels at which the other view shows what this one shows at `px`; `None` behind it.
    fn place_in(&self, other: &Self, px: DVec2) -> Option<DVec2> {
        let eye = self.pose.center_in_world();
        let ray = self.pose.rotation.transpose() * self.camera.ray_in_camera(px);
        let along = -self.plane.signed_distance(eye) / self.plane.normal.dot(ray);
        let point = (along > 0.0).then_some(eye + ray * along)?;
        other.camera.image_from_camera(other.pose.camera_from_world(point))
    }
}

/// Returns true when imported paint shows clearly something else than other paint. An erased pixel is never projected;
/// where the other photo has erased, it keeps that.
fn colours_differ(new: PaintColour, other: PaintColour) -> bool {
    let light = |colour: PaintColour| {
        let [r, g, b, a] = colour.map(in_8_bits);
        (a >= 128).then(|| [r, g, b].map(|value| LINEAR_FROM_BYTE[usize::from(value)]))
    };
    match (light(new), light(other)) {
        (None, _) => false,
        (Some(_), None) => true,
        (Some(new), Some(other)) => paints_differ(new, other),
    }
}
