//! Paint of other photos on the surfaces that an import paints: where it differs, each photo keeps its own.
//!
//! This is found from the paint book alone, without photos and stacks: paint is compared through the plane of the
//! surface, as if the photos had the same exposure and the surface no relief. Of impostors each photo has a rectangle of
//! its own; there, paint is compared at the same distance from the axis and the same height, of photos on one side.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use serde::Serialize;

use quadratura_base::error::Result;
use quadratura_base::geometry::polygon::{extent, fit_plane};
use quadratura_base::geometry::{Pinhole, Plane, Pose};
use quadratura_base::raster::in_8_bits;
use quadratura_base::scene::FaceIndex;
use quadratura_base::scene::light::LINEAR_FROM_BYTE;
use quadratura_document::paint::{PaintBook, PaintColour, PaintEntry, PaintPatch};
use quadratura_layers::fill::FillOptions;
use quadratura_layers::fill::ranked_donors::paints_differ;
use quadratura_stacks::paint::parts::{camera_of, points};

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
        let theirs: Vec<_> = theirs.filter(|entry| here.is_level(entry) || here.turns_to(entry)).collect();
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
    face: (String, Option<FaceIndex>),
    /// The rectangle, if it is one about an axis, as those of impostors are.
    upright: Option<Upright>,
}

/// A rectangle about an axis that goes up in its middle.
#[derive(Debug, Clone, Copy)]
struct Upright {
    foot: DVec3,
    /// The way along the axis, and half the way across, to the right.
    along: DVec3,
    across: DVec3,
}

/// The deviation, as a share of a rectangle's sides, within which two rectangles have one axis, width and height.
const SAME_AXIS: f64 = 1e-6;

impl Upright {
    /// Returns the rectangle with this outline, which begins at the lower left.
    fn of_outline(outline: &[DVec3]) -> Option<Self> {
        let [a, b, c, d] = *outline else { return None };
        let (foot, across) = ((a + b) / 2.0, (b - a) / 2.0);
        let along = (c + d) / 2.0 - foot;
        let near = SAME_AXIS * (along.length() + across.length());
        let is_rectangle =
            (c - d).distance(2.0 * across) <= near && across.dot(along).abs() <= near * along.length();
        is_rectangle.then_some(Self { foot, along, across })
    }

    /// Returns whether the other one is this one turned about the axis, by less than a right angle.
    fn is_turned(&self, other: &Self) -> bool {
        let near = SAME_AXIS * (self.along.length() + self.across.length());
        self.foot.distance(other.foot) <= near
            && self.along.distance(other.along) <= near
            && (self.across.length() - other.across.length()).abs() <= near
            && self.across.dot(other.across) > 0.0
    }

    /// Returns the point of the other one at the position of a point of this one.
    fn turned(&self, other: &Self, point: DVec3) -> DVec3 {
        let from_foot = point - self.foot;
        let share = |way: DVec3| from_foot.dot(way) / way.length_squared();
        other.foot + other.across * share(self.across) + other.along * share(self.along)
    }
}

impl PaintedPlane {
    /// Returns those of an entry; `None` where its surface or camera is unknown.
    fn new(book: &PaintBook, entry: &PaintEntry) -> Option<Self> {
        let view = book.views.get(&entry.view)?;
        let outline = points(&entry.outline);
        let plane = fit_plane(&outline)?;
        let (camera, pose) = camera_of(&view.photo, &view.camera);
        let (face, upright) = ((entry.object.clone(), entry.face), Upright::of_outline(&outline));
        Some(Self { plane, extent: extent(&outline), camera, pose, face, upright })
    }

    /// Returns true when an entry's surface is that of the same impostor, as another photo sees it.
    fn turns_to(&self, entry: &PaintEntry) -> bool {
        let is_same = self.face.0 == entry.object && self.face.1 == entry.face;
        let pair = self.upright.zip(Upright::of_outline(&points(&entry.outline)));
        is_same && pair.is_some_and(|(one, other)| one.is_turned(&other))
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
        let pair = self
            .upright
            .zip(other.upright)
            .filter(|(one, two)| self.face == other.face && one.is_turned(two));
        let point = pair.map_or(point, |(one, two)| one.turned(&two, point));
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

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use quadratura_base::scene::impostor::{Facing, Impostor};
    use quadratura_base::scene::synthetic::{centred, look_at};
    use quadratura_document::paint::PaintedView;
    use quadratura_document::stack::{StackCamera, StackPhoto};
    use quadratura_layers::fill::Propagation;

    const TREE: Impostor = Impostor { foot: DVec3::ZERO, axis: DVec3::Z, height: 4.0, half_width: 2.0 };

    /// A book with paint of a colour at one place of a tree, (u, v) from its foot, in a photo from each of these places.
    fn book(painted: &[(DVec3, DVec2, PaintColour)]) -> (PaintBook, BTreeMap<String, PaintPatch>) {
        let (mut book, mut patches) = (PaintBook::default(), BTreeMap::new());
        for (number, (eye, place, colour)) in (1..).zip(painted) {
            let (camera, pose) = (centred(200, 200, 150.0), look_at(*eye, DVec3::new(0.0, 0.0, 2.0)));
            let name = format!("{number}.png");
            let photo = StackPhoto { name: name.clone(), width: 200, height: 200 };
            let camera_of_stack = StackCamera {
                K: camera.matrix_rows(),
                R: pose.rotation_rows(),
                t: pose.translation.to_array(),
            };
            let view = PaintedView { photo, camera: camera_of_stack };
            book.views.insert(name.clone(), view);
            let facing = Facing::of_pose(&pose);
            let px = camera.image_from_camera(pose.camera_from_world(TREE.point(&facing, *place))).unwrap();
            let (x, y) = (px.x as i32, px.y as i32);
            let pixels: Vec<_> =
                (-3..=3).flat_map(|dy| (-3..=3).map(move |dx| (x + dx, y + dy, *colour))).collect();
            let patch = PaintPatch::of_pixels(&pixels);
            book.entries.push(PaintEntry {
                photo: name.clone(),
                object: "tree".into(),
                face: Some(FaceIndex(0)),
                triangle: None,
                beyond: false,
                layer: "t".into(),
                document: name.clone(),
                import: number,
                view: name.clone(),
                outline: TREE.corners(&facing).map(|corner| corner.to_array()).to_vec(),
                rect: patch.rect(),
                pixels: patch.count(),
                file: name.clone(),
            });
            patches.insert(name, patch);
        }
        (book, patches)
    }

    #[test]
    fn paint_of_two_photos_at_one_place_of_an_impostor_that_differs_is_told() {
        let (red, blue) = ([65535, 0, 0, 65535], [0, 0, 65535, 65535]);
        let (place, other_place) = (DVec2::new(0.8, 3.0), DVec2::new(-0.8, 3.0));
        let (front, aside) = (DVec3::new(0.0, -9.0, 2.0), DVec3::new(6.0, -6.0, 2.0));
        let behind = DVec3::new(0.0, 9.0, 2.0);
        let options = FillOptions { propagate: Propagation::all(), ..FillOptions::default() };
        let differing = |painted: &[(DVec3, DVec2, PaintColour)]| -> u64 {
            let (book, patches) = book(painted);
            let read = |entry: &PaintEntry| Ok(patches.get(&entry.file).cloned());
            let found = paint_elsewhere(&book, 2, &options, &read).unwrap();
            assert!(found.iter().all(|it| it.face == "tree[0]" && it.photo == "1.png"), "{found:?}");
            found.iter().map(|it| it.pixels).sum()
        };
        assert!(differing(&[(front, place, red), (aside, place, blue)]) > 25);
        assert_eq!(differing(&[(front, place, red), (aside, place, red)]), 0, "the same paint");
        assert_eq!(differing(&[(front, place, red), (aside, other_place, blue)]), 0, "another place");
        assert_eq!(differing(&[(front, place, red), (behind, place, blue)]), 0, "another side of the tree");
    }
}
