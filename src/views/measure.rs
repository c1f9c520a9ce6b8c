//! Lengths and areas on the surfaces of a site, with what they are worth: the size of a photo's pixel there.

use glam::DVec3;

use crate::frame::{area_vector, up_of};
use quadratura_base::scene::{FaceId, Model, Photo};
use quadratura_document::SiteFrame;
use quadratura_projection::model_surface::ModelSurface;
use quadratura_sites::open::Opened;
use quadratura_view::weights::pixels_per_unit;

/// A point on a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointOnFace {
    /// The position in the cameras' world.
    pub position: DVec3,
    /// The face.
    pub face: FaceId,
}

/// A value with its uncertainty, in the frame's unit or its square; `None` where no photo shows the place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// The value.
    pub value: f64,
    /// About how far it may be off.
    pub uncertainty: Option<f64>,
}

/// What there is between two points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    /// The straight distance.
    pub straight: Measured,
    /// The difference of heights, from the first point up to the second.
    pub height: f64,
    /// The level part of the distance.
    pub level: f64,
}

/// The share of the way to a point from which on a surface that a ray meets is that of the point.
const THERE: f64 = 1.0 - 1e-6;

/// Returns the side of a pixel of the photo that shows a point of a face best, on the face; in world units. `None` where no photo shows it.
pub fn pixel_at(opened: &Opened, surface: &ModelSurface, point: PointOnFace) -> Option<f64> {
    let plane = &opened.site.model.face(point.face).plane;
    let of_photo = |photo: &Photo| {
        let in_photo = photo.pose.camera_from_world(point.position);
        let px = photo.camera.image_from_camera(in_photo)?;
        let eye = photo.pose.center_in_world();
        let density = pixels_per_unit(&photo.camera, plane, eye, in_photo.z);
        let is_seen = || {
            let hit = surface.nearest(eye, point.position - eye);
            hit.is_none_or(|hit| hit.t >= THERE)
        };
        (photo.camera.rect().contains_position(px) && density > 0.0 && is_seen()).then(|| 1.0 / density)
    };
    opened.site.photos.iter().filter_map(of_photo).min_by(f64::total_cmp)
}

/// Measures from one point to another. Each is known to about a pixel of the best photo there.
pub fn distance(opened: &Opened, surface: &ModelSurface, points: [PointOnFace; 2]) -> Distance {
    let scale = opened.project.frame.metres_per_unit().unwrap_or(1.0);
    let [from, to] = points.map(|point| point.position);
    let between = (to - from) * scale;
    let height = between.dot(up_of(opened));
    let pixels = points.map(|point| pixel_at(opened, surface, point));
    let uncertainty = match pixels {
        [Some(a), Some(b)] => Some(a.hypot(b) * scale),
        _ => None,
    };
    let straight = Measured { value: between.length(), uncertainty };
    Distance { straight, height, level: (between.length_squared() - height * height).max(0.0).sqrt() }
}

/// Measures the area of a face. It is off by as much as its outline is, by about half a pixel along all of it.
pub fn area(opened: &Opened, surface: &ModelSurface, face: FaceId) -> Measured {
    let model = &opened.site.model;
    let scale = opened.project.frame.metres_per_unit().unwrap_or(1.0);
    let value = area_vector(model, face).length() * scale * scale;
    let corners: Vec<DVec3> = model.ring_points(face).collect();
    let around: f64 =
        (0..corners.len()).map(|at| corners[at].distance(corners[(at + 1) % corners.len()])).sum();
    let pixels = places_on(model, face)
        .into_iter()
        .filter_map(|position| pixel_at(opened, surface, PointOnFace { position, face }));
    let pixel = pixels.min_by(f64::total_cmp);
    Measured { value, uncertainty: pixel.map(|pixel| 0.5 * pixel * around * scale * scale) }
}

/// The triangles of a face on which places are looked at.
const MOST_TRIANGLES: usize = 16;

/// Returns places all over a face.
fn places_on(model: &Model, face: FaceId) -> Vec<DVec3> {
    /// Parts along each side of a triangle.
    const PARTS: u32 = 5;
    let share = |part: u32| (f64::from(part) + 1.0 / 3.0) / f64::from(PARTS);
    let of_triangle = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|vertex| model.vertices[vertex as usize]);
        let at = move |u: u32, v: u32| a + (b - a) * share(u) + (c - a) * share(v);
        (0..PARTS).flat_map(move |u| (0..PARTS - u).map(move |v| at(u, v))).collect::<Vec<_>>()
    };
    model.face_triangles(face).iter().take(MOST_TRIANGLES).flat_map(of_triangle).collect()
}

/// Returns a length or an area in words, with as many digits as its uncertainty allows, such as `12.34 ± 0.01 m`.
pub fn worded(measured: Measured, frame: &SiteFrame, power: u32) -> String {
    let unit = match (frame.unit(), power) {
        (unit, 1) => unit.to_owned(),
        ("m", _) => "m²".to_owned(),
        (unit, _) => format!("square {unit}"),
    };
    let Measured { value, uncertainty } = measured;
    let digits_of = |size: f64| (-size.log10().floor()).clamp(0.0, 6.0) as usize;
    match uncertainty.filter(|uncertainty| *uncertainty > 0.0) {
        Some(uncertainty) => {
            let digits = digits_of(uncertainty);
            format!("{value:.digits$} ± {uncertainty:.digits$} {unit}")
        }
        None => {
            let digits = digits_of(value.abs().max(1e-6) * 1e-3);
            format!("{value:.digits$} {unit}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_document::frame::Stated;
    use quadratura_stacks::tiny_site::tiny_project;

    #[test]
    fn lengths_have_as_many_digits_as_they_are_known_to() {
        let mut frame = SiteFrame::default();
        let of = |value, uncertainty| Measured { value, uncertainty };
        assert_eq!(worded(of(2.0, None), &frame, 1), "2.000 units");
        frame.scale = Some(Stated { value: 1.0, from: "a test".into() });
        assert_eq!(worded(of(12.3456, Some(0.012)), &frame, 1), "12.35 ± 0.01 m");
        assert_eq!(worded(of(123.4, Some(2.6)), &frame, 2), "123 ± 3 m²");
    }

    #[test]
    fn a_point_is_known_to_a_pixel_of_the_photo_that_sees_it_and_an_area_to_half_of_one_around_it() {
        let folder = tempfile::tempdir().unwrap();
        let (_, mut opened) = tiny_project(folder.path()).unwrap();
        opened.project.frame.scale = Some(Stated { value: 0.5, from: "a test".into() });
        let surface = ModelSurface::from_model(&opened.site.model);
        let photo = &opened.site.photos[0];
        let eye = photo.pose.center_in_world();
        let middle = glam::DVec2::new(f64::from(photo.camera.width), f64::from(photo.camera.height)) * 0.5;
        let ray = photo.pose.rotation.transpose() * photo.camera.ray_in_camera(middle);
        let hit = surface.nearest(eye, ray).unwrap();
        let point = PointOnFace { position: eye + ray * hit.t, face: hit.face };
        let pixel = pixel_at(&opened, &surface, point).unwrap();
        // Seen from straight in front a pixel is depth / focal length; it is larger at an angle, and no photo is much nearer.
        let plain = hit.t / photo.camera.fx;
        assert!(pixel > 0.5 * plain && pixel < 3.0 * plain, "{pixel} and {plain}");
        let other = PointOnFace { position: point.position + DVec3::Z * 0.25, ..point };
        let found = distance(&opened, &surface, [point, other]);
        assert!((found.straight.value - 0.125).abs() < 1e-12);
        let model = opened.site.model.clone();
        let of_hit = area(&opened, &surface, hit.face);
        let units = area_vector(&model, hit.face).length();
        assert!((of_hit.value - 0.25 * units).abs() < 1e-9 * units, "{of_hit:?}");
        let known: Vec<f64> =
            model.face_ids().filter_map(|face| area(&opened, &surface, face).uncertainty).collect();
        assert!(!known.is_empty() && known.iter().all(|off| *off > 0.0), "{known:?}");
    }
}
