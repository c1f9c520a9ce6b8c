//! Where paint belongs now: its surface in the stack of today, whatever was renamed, moved or remodelled since.

use glam::{DVec2, DVec3};

use super::parts::{Part, camera_of, points};
use crate::document::paint::{Colour, PaintEntry, PaintedView, Patch};
use crate::geometry::polygon::{extent, fit_plane};
use crate::geometry::{Pinhole, PixelRect, Plane, Pose};
use crate::raster::bilinear::Corner;

/// Two outlines are the same when their corners are nearer than this share of their size: models are written
/// with six digits and more.
const SAME_OUTLINE: f64 = 1e-5;

/// A remodelled face is still the same surface when its plane turned by less than some 8 degrees ...
const SAME_DIRECTION: f64 = 0.99;
/// ... and moved by less than this share of the surface's size.
const SAME_PLACE: f64 = 0.05;

/// Where an entry belongs among the parts of a stack.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Home {
    /// On these: the same surface, whole or in pieces.
    Same(Vec<usize>),
    /// On those of these that cover a pixel: the surface was remodelled.
    Spread(Vec<usize>),
    /// The stack has nothing like it.
    Lost,
}

/// Looks for the surface of an entry among `parts`: by name and outline; by outline alone, where it was renamed;
/// by object and plane, where it was remodelled.
pub fn home(entry: &PaintEntry, parts: &[&Part]) -> Home {
    let named = |part: &Part| {
        part.object == entry.object && part.face == entry.face && part.triangle == entry.triangle
    };
    let unknown = |part: &Part| part.outline.is_empty() || entry.outline.is_empty();
    let same = |part: &Part| unknown(part) || same_outline(&entry.outline, part.outline);
    let found = places(parts, |part| named(part) && same(part));
    if !found.is_empty() {
        return Home::Same(found);
    }
    let renamed = places(parts, |part| !unknown(part) && same(part));
    if !renamed.is_empty() {
        return Home::Same(renamed);
    }
    let like = places(parts, |part| {
        named(part) || (part.object == entry.object && same_plane(&entry.outline, part.outline))
    });
    if like.is_empty() { Home::Lost } else { Home::Spread(like) }
}

fn places(parts: &[&Part], wanted: impl Fn(&Part) -> bool) -> Vec<usize> {
    parts.iter().enumerate().filter(|(_, part)| wanted(part)).map(|(place, _)| place).collect()
}

/// The same corners in the same order, wherever the list begins.
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

fn same_plane(a: &[[f64; 3]], b: &[[f64; 3]]) -> bool {
    let (a, b) = (points(a), points(b));
    let (Some(old), Some(new)) = (fit_plane(&a), fit_plane(&b)) else { return false };
    let near = SAME_PLACE * extent(&a).max(extent(&b));
    old.normal.dot(new.normal) >= SAME_DIRECTION && a.iter().all(|p| new.signed_distance(*p).abs() <= near)
}

/// A camera and its pose.
type View = (Pinhole, Pose);

/// How paint gets from the photo as it was to the photo as it is: through its surface's plane.
pub struct Reprojection {
    plane: Plane,
    old: View,
    new: View,
}

/// Cameras that take a surface's corners to places nearer than this, in pixels, are the same one.
const SAME_CAMERA_PX: f64 = 1e-3;

impl Reprojection {
    /// None where the camera is the same, or the surface has no plane: paint stays at its pixels.
    pub fn between(entry: &PaintEntry, old: &PaintedView, new: View) -> Option<Self> {
        let old = camera_of(&old.photo, &old.camera);
        let outline = points(&entry.outline);
        let same = old == new || corners(entry.rect).all(|px| at_same_place(px, &outline, old, new));
        if same {
            return None;
        }
        let plane = fit_plane(&outline)?;
        Some(Self { plane, old, new })
    }

    /// The paint at its new pixels: each shows what lay at its centre's foot on the surface, the nearest old
    /// pixel where that is clear, mixed from its neighbours where it lies between.
    pub fn applied(&self, patch: &Patch, photo: PixelRect) -> Patch {
        let Some(rect) = self.bounds(patch.rect(), photo) else { return Patch::of_pixels(&[]) };
        let mut moved = Patch::new(rect);
        for (x, y) in rect.pixels() {
            let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            if let Some(colour) = self.old_px(centre).and_then(|px| sample(patch, px)) {
                moved.put(x, y, colour);
            }
        }
        moved
    }

    fn old_px(&self, new_px: DVec2) -> Option<DVec2> {
        carried(new_px, &self.plane, self.new, self.old)
    }

    fn bounds(&self, rect: PixelRect, photo: PixelRect) -> Option<PixelRect> {
        let carried: Vec<DVec2> =
            corners(rect).filter_map(|px| carried(px, &self.plane, self.old, self.new)).collect();
        // Some corner's ray misses the plane: it may be anywhere in the photo.
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

fn corners(rect: PixelRect) -> impl Iterator<Item = DVec2> {
    let edge = |x: i32, y: i32| DVec2::new(f64::from(x), f64::from(y));
    let (right, bottom) = (rect.right(), rect.bottom());
    [edge(rect.x, rect.y), edge(right, rect.y), edge(right, bottom), edge(rect.x, bottom)].into_iter()
}

fn at_same_place(px: DVec2, outline: &[DVec3], old: View, new: View) -> bool {
    let plane = fit_plane(outline);
    let there = plane.and_then(|plane| carried(px, &plane, old, new));
    there.is_some_and(|there| there.distance(px) <= SAME_CAMERA_PX)
}

/// From one photo through a plane into another one.
fn carried(px: DVec2, plane: &Plane, (from, from_pose): View, (to, to_pose): View) -> Option<DVec2> {
    let eye = from_pose.center_in_world();
    let ray = from_pose.rotation.transpose() * from.ray_in_camera(px);
    let along = -plane.signed_distance(eye) / plane.normal.dot(ray);
    let hit = (along > 0.0 && along.is_finite()).then(|| eye + ray * along)?;
    to.image_from_camera(to_pose.camera_from_world(hit))
}

/// The paint at an image position: bilinear over painted pixels; nothing where the nearest one is not painted.
fn sample(patch: &Patch, px: DVec2) -> Option<Colour> {
    let nearest = patch.at(px.x.floor() as i32, px.y.floor() as i32)?;
    if nearest[3] == 0 {
        return Some(nearest);
    }
    let mut sum = [0.0; 4];
    let mut weights = 0.0;
    for (x, y, weight) in Corner::of(px).taps() {
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
