//! Assignment of paint to surfaces of the present stack, after surfaces were renamed, moved or remodelled.

use glam::DVec2;

use super::parts::{SurfacePart, camera_of, points};
use quadratura_base::geometry::polygon::{extent, fit_plane};
use quadratura_base::geometry::{Pinhole, PixelRect, Plane, Pose};
use quadratura_base::raster::bilinear::BilinearCorner;
use quadratura_document::paint::{PaintColour, PaintEntry, PaintPatch, PaintedView};

/// Outlines are equal when their corners differ by less than this share of their size: models are written with six
/// digits or more.
const SAME_OUTLINE: f64 = 1e-5;

/// A remodelled face is still the same surface when its plane was rotated by less than about 8 degrees ...
const SAME_DIRECTION: f64 = 0.99;
/// ... and moved by less than this share of the surface's size.
const SAME_PLACE: f64 = 0.05;

/// The parts of a stack to which an entry belongs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Home {
    /// The surface is unchanged; the parts contain it as a whole or in pieces.
    Same(Vec<usize>),
    /// The surface was remodelled; each pixel belongs to those of these parts that cover it.
    Spread(Vec<usize>),
    /// The stack has no such surface.
    Lost,
}

/// Finds the surface of an entry among `parts`: by name and outline; by outline alone, if it was renamed; by object
/// and plane, if it was remodelled. An impostor has the paint of all faces of its object.
pub fn home(entry: &PaintEntry, parts: &[&SurfacePart]) -> Home {
    let named = |part: &SurfacePart| {
        part.object == entry.object && part.face == entry.face && part.triangle == entry.triangle
    };
    let unknown = |part: &SurfacePart| part.outline.is_empty() || entry.outline.is_empty();
    let same = |part: &SurfacePart| unknown(part) || same_outline(&entry.outline, part.outline);
    let found = matching(parts, |part| named(part) && same(part));
    if !found.is_empty() {
        return Home::Same(found);
    }
    let renamed = matching(parts, |part| !unknown(part) && same(part));
    if !renamed.is_empty() {
        return Home::Same(renamed);
    }
    let like = matching(parts, |part| {
        let same_object = part.object == entry.object;
        named(part) || (same_object && (part.impostor || same_plane(&entry.outline, part.outline)))
    });
    if like.is_empty() { Home::Lost } else { Home::Spread(like) }
}

/// Returns the indices of the parts for which a predicate is true.
fn matching(parts: &[&SurfacePart], wanted: impl Fn(&SurfacePart) -> bool) -> Vec<usize> {
    parts.iter().enumerate().filter(|(_, part)| wanted(part)).map(|(index, _)| index).collect()
}

/// Returns true when two outlines have the same corners in the same order, wherever the list begins.
fn same_outline(a: &[[f64; 3]], b: &[[f64; 3]]) -> bool {
    if a == b {
        return true;
    }
    let (a, b) = (points(a), points(b));
    if a.len() != b.len() {
        return false;
    }
    let near = SAME_OUTLINE * extent(&a);
    let agrees = |shift: usize| (0..a.len()).all(|i| a[i].distance(b[(i + shift) % b.len()]) <= near);
    (0..a.len()).any(agrees)
}

/// Returns true when two outlines lie in almost the same plane.
fn same_plane(a: &[[f64; 3]], b: &[[f64; 3]]) -> bool {
    let (a, b) = (points(a), points(b));
    let (Some(old), Some(new)) = (fit_plane(&a), fit_plane(&b)) else { return false };
    let near = SAME_PLACE * extent(&a).max(extent(&b));
    old.normal.dot(new.normal) >= SAME_DIRECTION && a.iter().all(|p| new.signed_distance(*p).abs() <= near)
}

/// What paint lies on: the plane of a surface, or the surroundings, which are infinitely far away.
enum PaintedGround {
    Plane(Plane),
    Infinity,
}

/// A camera and its pose.
#[derive(Clone, Copy, PartialEq)]
struct PosedCamera {
    camera: Pinhole,
    pose: Pose,
}

/// The mapping of paint from the photo at the time of painting to the present photo, through what was painted on.
pub struct PaintMapping {
    through: PaintedGround,
    old: PosedCamera,
    new: PosedCamera,
}

/// The distance in pixels below which two cameras show a surface's corners at the same position.
const SAME_CAMERA_PX: f64 = 1e-3;

impl PaintMapping {
    /// Compares the camera at the time of painting with the present one; `None` where they agree, or the surface has no plane, so
    /// that paint stays at its pixels.
    pub fn between(entry: &PaintEntry, old: &PaintedView, camera: Pinhole, pose: Pose) -> Option<Self> {
        let new = PosedCamera { camera, pose };
        let (camera, pose) = camera_of(&old.photo, &old.camera);
        let old = PosedCamera { camera, pose };
        let through = match entry.face {
            Some(_) => PaintedGround::Plane(fit_plane(&points(&entry.outline))?),
            None => PaintedGround::Infinity,
        };
        let at_same_place = |px: DVec2| {
            carried(px, &through, old, new).is_some_and(|there| there.distance(px) <= SAME_CAMERA_PX)
        };
        let same = old == new || corners(entry.rect).all(at_same_place);
        (!same).then_some(Self { through, old, new })
    }

    /// Returns the paint at its new pixels. Each new pixel shows what is at its centre on the surface, interpolated
    /// from the old pixels.
    pub fn applied(&self, patch: &PaintPatch, photo: PixelRect) -> PaintPatch {
        let Some(rect) = self.bounds(patch.rect(), photo) else { return PaintPatch::of_pixels(&[]) };
        let mut moved = PaintPatch::new(rect);
        for (x, y) in rect.pixels() {
            let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            if let Some(colour) = self.old_px(centre).and_then(|px| sample(patch, px)) {
                moved.put(x, y, colour);
            }
        }
        moved
    }

    /// Maps a position in the present photo to the old one.
    fn old_px(&self, new_px: DVec2) -> Option<DVec2> {
        carried(new_px, &self.through, self.new, self.old)
    }

    /// Returns the pixels that paint may reach in the present photo.
    fn bounds(&self, rect: PixelRect, photo: PixelRect) -> Option<PixelRect> {
        let carried: Vec<DVec2> =
            corners(rect).filter_map(|px| carried(px, &self.through, self.old, self.new)).collect();
        // The ray through some corner misses the plane, so the paint may be anywhere in the photo.
        if carried.len() < 4 {
            return Some(photo);
        }
        let low = carried.iter().copied().reduce(DVec2::min)?.floor();
        let high = carried.iter().copied().reduce(DVec2::max)?.ceil();
        let around = photo.grown(photo.w.max(photo.h));
        let rect =
            PixelRect::from_edges(low.x as i32 - 1, low.y as i32 - 1, high.x as i32 + 1, high.y as i32 + 1);
        Some(rect.intersection(&around)).filter(|rect| !rect.is_empty())
    }
}

/// Returns the corners of a rectangle.
fn corners(rect: PixelRect) -> impl Iterator<Item = DVec2> {
    let edge = |x: i32, y: i32| DVec2::new(f64::from(x), f64::from(y));
    let (right, bottom) = (rect.right(), rect.bottom());
    [edge(rect.x, rect.y), edge(right, rect.y), edge(right, bottom), edge(rect.x, bottom)].into_iter()
}

/// Maps a position from one photo to another through what was painted on; `None` where that is not possible.
fn carried(px: DVec2, through: &PaintedGround, from: PosedCamera, to: PosedCamera) -> Option<DVec2> {
    let ray = from.pose.rotation.transpose() * from.camera.ray_in_camera(px);
    let plane = match through {
        PaintedGround::Plane(plane) => plane,
        PaintedGround::Infinity => return to.camera.image_from_camera(to.pose.rotation * ray),
    };
    let eye = from.pose.center_in_world();
    let along = -plane.signed_distance(eye) / plane.normal.dot(ray);
    let hit = (along > 0.0 && along.is_finite()).then(|| eye + ray * along)?;
    to.camera.image_from_camera(to.pose.camera_from_world(hit))
}

/// Samples the paint at an image position: bilinear over painted pixels, `None` where the nearest pixel is not
/// painted.
fn sample(patch: &PaintPatch, px: DVec2) -> Option<PaintColour> {
    let nearest = patch.at(px.x.floor() as i32, px.y.floor() as i32)?;
    if nearest[3] == 0 {
        return Some(nearest);
    }
    let mut sum = [0.0; 4];
    let mut weights = 0.0;
    for (x, y, weight) in BilinearCorner::from_px(px).taps() {
        let Some(colour) = patch.at(x, y) else { continue };
        let alpha = f64::from(colour[3]);
        (0..3).for_each(|i| sum[i] += weight * alpha * f64::from(colour[i]));
        sum[3] += weight * alpha;
        weights += weight;
    }
    let colour = |i: usize| (sum[i] / sum[3]).round() as u16;
    Some(if sum[3] > 0.0 {
        [colour(0), colour(1), colour(2), (sum[3] / weights).round() as u16]
    } else {
        nearest
    })
}
