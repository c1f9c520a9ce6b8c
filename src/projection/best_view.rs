//! From where something is seen best: of the directions in which photos look at it, the one from which most of it is seen,
//! and from the side that the photos see. A view is never put behind what it is to show, nor into a house.

use glam::DVec3;

use super::model_surface::ModelSurface;
use quadratura_base::geometry::Pose;
use quadratura_base::geometry::triangle::area_vector;
use quadratura_base::scene::{FaceId, Model};
use quadratura_view::navigation::Viewpoint;

/// The largest number of points that are looked at, and of photos whose directions are tried.
const MOST_POINTS: usize = 96;
const MOST_PHOTOS: usize = 24;
/// A view from the present direction that sees this share of what the best one does is good enough: it turns nothing.
const GOOD_ENOUGH: f64 = 0.8;
/// A ray that ends this share of its length before its point is not stopped by anything but the point's own surface.
const SURFACE: f64 = 1e-3;
/// How far the photos' directions are lowered in a second try, so that a view looks over what is in front.
const DOWN: f64 = 0.45;

/// A point of what is to be seen.
struct SubjectPoint {
    at: DVec3,
    /// The normal of its face, turned to the side that photos see; zero where either side may be seen.
    normal: DVec3,
    /// The area that it stands for.
    weight: f64,
}

/// What is to be seen, and what may stand in front of it.
pub struct BestView<'a> {
    points: Vec<SubjectPoint>,
    solid: &'a ModelSurface,
    /// The positions of photos whose directions are tried, in world coordinates.
    eyes: Vec<DVec3>,
}

impl<'a> BestView<'a> {
    /// Looks for views of these faces, and of `center` where there are none, beside photos at these positions.
    pub fn new(
        model: &Model,
        faces: &[FaceId],
        center: DVec3,
        solid: &'a ModelSurface,
        photos: &[DVec3],
    ) -> Self {
        let eyes: Vec<DVec3> = some_of(photos, MOST_PHOTOS).copied().collect();
        let triangles: Vec<[DVec3; 3]> =
            faces.iter().flat_map(|face| model.face_triangles(*face)).map(|t| corners(model, t)).collect();
        let mut points: Vec<SubjectPoint> =
            some_of(&triangles, MOST_POINTS).map(|triangle| point_of(triangle, solid, &eyes)).collect();
        if points.is_empty() {
            points.push(SubjectPoint { at: center, normal: DVec3::ZERO, weight: 1.0 });
        }
        Self { points, solid, eyes }
    }

    /// Returns the share of what is to be seen that a view with an image of this `width` in image heights shows.
    pub fn seen(&self, view: &Viewpoint, width: f64) -> f64 {
        let eye = view.position();
        let is_seen = |point: &&SubjectPoint| {
            let is_in_front = point.normal.dot(eye - point.at) >= 0.0;
            let place = view.place(point.at);
            let is_in_image = place.is_some_and(|at| at.x.abs() <= width / 2.0 && at.y.abs() <= 0.5);
            is_in_front && is_in_image && is_free(self.solid, eye, point.at)
        };
        let seen: f64 = self.points.iter().filter(is_seen).map(|point| point.weight).sum();
        seen / self.points.iter().map(|point| point.weight).sum::<f64>().max(f64::MIN_POSITIVE)
    }

    /// Returns the view that shows most: `present`, where it is good enough, else one of those that `towards` makes of the
    /// photos' directions (unit vectors) to `center`.
    pub fn best(
        &self,
        present: Viewpoint,
        center: DVec3,
        up: DVec3,
        width: f64,
        towards: impl Fn(DVec3) -> Viewpoint,
    ) -> Viewpoint {
        let of_photo = |eye: &DVec3| {
            let ahead = (center - eye).normalize_or(-up);
            let there = towards(ahead);
            // Where something is in the way of the whole, a part is seen from the photo's own place.
            let here = Pose { translation: -(there.pose.rotation * *eye), ..there.pose };
            [there, towards((ahead - DOWN * up).normalize_or(-up)), Viewpoint { pose: here, ..there }]
        };
        let views = self.eyes.iter().flat_map(of_photo).map(|view| (self.seen(&view, width), view));
        let mine = self.seen(&present, width);
        let better =
            |best: (f64, Viewpoint), other: (f64, Viewpoint)| if other.0 > best.0 { other } else { best };
        match views.reduce(better) {
            Some((seen, view)) if mine < GOOD_ENOUGH * seen => view,
            _ => present,
        }
    }
}

/// Returns at most `most` items, evenly spread.
fn some_of<T>(items: &[T], most: usize) -> impl Iterator<Item = &T> {
    items.iter().step_by(items.len().div_ceil(most).max(1))
}

fn corners(model: &Model, triangle: &[u32; 3]) -> [DVec3; 3] {
    triangle.map(|vertex| model.vertices[vertex as usize])
}

/// Returns the middle of a triangle, with the side from which most photos see it.
fn point_of(triangle: &[DVec3; 3], solid: &ModelSurface, eyes: &[DVec3]) -> SubjectPoint {
    let area = area_vector(triangle);
    let (at, normal) = (triangle.iter().sum::<DVec3>() / 3.0, area.normalize_or_zero());
    let sees = |eye: &&DVec3| is_free(solid, **eye, at);
    let side = |eye: &DVec3| normal.dot(eye - at).signum();
    let sum: f64 = eyes.iter().filter(sees).map(side).sum();
    let side = if sum == 0.0 { 0.0 } else { sum.signum() };
    SubjectPoint { at, normal: side * normal, weight: area.length() }
}

/// Returns whether nothing is between an eye and a point of a surface.
fn is_free(solid: &ModelSurface, eye: DVec3, point: DVec3) -> bool {
    solid.nearest(eye, point - eye).is_none_or(|hit| hit.t >= 1.0 - SURFACE)
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use quadratura_base::scene::ObjectId;
    use quadratura_base::scene::synthetic::Modeller;
    use quadratura_view::flight::FrameLens;

    const UP: DVec3 = DVec3::Z;

    /// Two houses, one behind the other in y, 4 units wide and 4 apart.
    fn street() -> std::sync::Arc<Model> {
        let mut modeller = Modeller::new();
        for (name, y) in [("near", 0.0), ("far", 8.0)] {
            modeller.object(name).cuboid(DVec3::new(0.0, y, 2.0), DVec3::splat(2.0), DMat3::IDENTITY);
        }
        modeller.finish()
    }

    /// The face of an object that looks against y.
    fn front(model: &Model, object: u32) -> FaceId {
        let faces = model.object(ObjectId(object)).faces.iter();
        *faces.min_by(|a, b| mean_y(model, **a).total_cmp(&mean_y(model, **b))).unwrap()
    }

    fn mean_y(model: &Model, face: FaceId) -> f64 {
        model.ring_points(face).map(|point| point.y).sum::<f64>() / model.ring_points(face).len() as f64
    }

    /// The view that shows a face best, and how much of it, starting with one along `forward`.
    fn best(model: &Model, face: FaceId, photos: &[DVec3], forward: DVec3) -> (Viewpoint, f64) {
        let solid = ModelSurface::from_model(model);
        let center = model.ring_points(face).sum::<DVec3>() / 4.0;
        let towards =
            |forward| Viewpoint::towards(center, 2.9, forward, UP, FrameLens::with_field_of_view(0.9));
        let views = BestView::new(model, &[face], center, &solid, photos);
        let view = views.best(towards(forward), center, UP, 1.5, towards);
        (view, views.seen(&view, 1.5))
    }

    #[test]
    fn a_wall_is_not_framed_from_behind_or_from_inside_its_house() {
        let model = street();
        let photos = [DVec3::new(-3.0, -12.0, 1.6), DVec3::new(2.0, -14.0, 1.6)];
        for forward in [-DVec3::Y, DVec3::new(0.3, -1.0, 0.2).normalize()] {
            let (view, seen) = best(&model, front(&model, 0), &photos, forward);
            assert!(view.position().y < -2.0 && seen > 0.99, "{} sees {seen}", view.position());
        }
    }

    #[test]
    fn of_the_photos_directions_that_is_taken_from_which_nothing_is_in_front() {
        let model = street();
        // The first one looks through the near house, the second one into the gap between the houses.
        let photos = [DVec3::new(0.0, -12.0, 1.6), DVec3::new(9.0, 3.0, 1.6)];
        let (view, seen) = best(&model, front(&model, 1), &photos, DVec3::Y);
        assert!(seen > 0.99, "{} sees {seen}", view.position());
        let inside = |eye: DVec3, y: f64| (eye - DVec3::new(0.0, y, 2.0)).abs().max_element() < 2.0;
        assert!(!inside(view.position(), 0.0) && !inside(view.position(), 8.0));
    }

    #[test]
    fn a_view_that_shows_what_is_meant_is_not_turned() {
        let model = street();
        let photos = [DVec3::new(-3.0, -12.0, 1.6)];
        let forward = DVec3::new(-0.4, 1.0, -0.1).normalize();
        let (view, _) = best(&model, front(&model, 0), &photos, forward);
        assert!((view.pose.rotation.transpose() * DVec3::Z - forward).length() < 1e-9);
    }
}
