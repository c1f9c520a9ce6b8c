//! Where the site is in the files: in its frame, where it has one, less a local origin, because programs that compute in f32 lose pixels
//! where coordinates are large.

use glam::DVec3;

use quadratura_base::geometry::{Pose, Similarity};
use quadratura_base::scene::Site;
use quadratura_document::SiteFrame;
use quadratura_handover::camera::less_origin;

/// How the cameras' world is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// The transform to the site's frame; `None` where the world is written as it is.
    pub frame_from_world: Option<Similarity>,
    /// The point of the frame, or of the world, that is zero in the files.
    pub origin: DVec3,
}

impl Placement {
    /// Places a site in its frame, or in the cameras' world where that is empty or not wanted.
    pub fn new(site: &Site, frame: &SiteFrame, is_in_frame: bool) -> Self {
        let frame_from_world = (is_in_frame && !frame.is_empty()).then(|| frame.frame_from_world());
        let at = |point: DVec3| frame_from_world.map_or(point, |frame| frame.apply(point));
        let cameras = site.photos.iter().map(|photo| at(photo.pose.center_in_world()));
        let points = cameras.chain(site.model.vertices.iter().map(|vertex| at(*vertex)));
        Self { frame_from_world, origin: local_origin(points) }
    }

    /// Returns where a point of the world is in the files.
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.frame_from_world.map_or(point, |frame| frame.apply(point)) - self.origin
    }

    /// Returns a direction of the world in the files.
    pub fn direction(&self, direction: DVec3) -> DVec3 {
        self.frame_from_world.map_or(direction, |frame| frame.rotation * direction)
    }

    /// Returns a length of the world in the files.
    pub fn length(&self, length: f64) -> f64 {
        self.frame_from_world.map_or(length, |frame| length * frame.scale)
    }

    /// Returns the pose of a camera in the files.
    pub fn pose(&self, pose: &Pose) -> Pose {
        let pose = self.frame_from_world.map_or(*pose, |frame| frame.pose_after(pose));
        less_origin(&pose, self.origin)
    }
}

/// The largest coordinate, in world units, that is left as it is.
const LARGEST: f64 = 1e4;
/// The same in extents of the site: f32 has 24 bits, so that a thousandth of them is left for the site, a millionth of its size each.
const LARGEST_IN_EXTENTS: f64 = 1e3;

/// Returns the point that every export subtracts from coordinates, the same whatever the format and the photos that are exported: zero
/// where coordinates are small, else the middle of the site's points, rounded to a power of ten near a tenth of its extent.
fn local_origin(points: impl Iterator<Item = DVec3>) -> DVec3 {
    let (low, high) = points
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)));
    let extent = (high - low).max_element();
    let largest = low.abs().max(high.abs()).max_element();
    if !largest.is_finite() || extent <= 0.0 || largest <= LARGEST.min(LARGEST_IN_EXTENTS * extent) {
        return DVec3::ZERO;
    }
    // A whole exponent, so that the numbers in the files are short.
    let unit = 10f64.powi((extent / 10.0).log10().ceil() as i32);
    // Adding zero makes the zero of the files a positive one.
    ((low + high) / 2.0 / unit).round() * unit + 0.0
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use quadratura_base::scene::Model;

    fn origin_of(vertices: &[[f64; 3]]) -> DVec3 {
        let vertices = vertices.iter().copied().map(DVec3::from_array).collect();
        let model = Arc::new(Model { vertices, ..Model::default() });
        let site = Site { photos: Vec::new(), model };
        Placement::new(&site, &SiteFrame::default(), true).origin
    }

    #[test]
    fn coordinates_of_a_usual_site_stay_as_they_are() {
        assert_eq!(origin_of(&[[-120.0, 3.0, 0.0], [80.0, 40.0, 12.0]]), DVec3::ZERO);
        assert_eq!(origin_of(&[]), DVec3::ZERO);
    }

    #[test]
    fn a_georeferenced_site_gets_a_round_origin_in_its_middle() {
        let origin = origin_of(&[[412_345.6, 5_654_321.0, 101.0], [412_425.6, 5_654_399.0, 139.0]]);
        assert_eq!(origin, DVec3::new(412_390.0, 5_654_360.0, 120.0));
    }

    #[test]
    fn a_small_site_far_from_zero_in_its_own_size_gets_an_origin_too() {
        let origin = origin_of(&[[50.0, 0.0, 0.0], [50.01, 0.01, 0.0]]);
        assert!((origin - DVec3::new(50.005, 0.005, 0.0)).abs().max_element() < 1e-3, "{origin}");
    }

    #[test]
    fn a_camera_in_the_frame_sees_points_of_the_frame_where_it_saw_them_in_the_world() {
        use glam::DMat3;
        use quadratura_document::frame::Stated;
        let stated = |value| Some(Stated { value, from: "a test".to_owned() });
        let frame = SiteFrame {
            up: stated([0.0, -0.6, 0.8]),
            origin: stated([3.0, -2.0, 7.0]),
            scale: Some(Stated { value: 0.37, from: "a test".into() }),
            ..SiteFrame::default()
        };
        let model = Arc::new(Model { vertices: vec![DVec3::ONE], ..Model::default() });
        let placement = Placement::new(&Site { photos: Vec::new(), model }, &frame, true);
        let rotation = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.1);
        let pose = Pose { rotation, translation: DVec3::new(0.4, -3.0, 12.0) };
        let point = DVec3::new(2.0, 5.0, -1.0);
        let (before, after) =
            (pose.camera_from_world(point), placement.pose(&pose).camera_from_world(placement.point(point)));
        assert!((before * 0.37 - after).length() < 1e-12, "{before} and {after}");
        assert!((placement.direction(DVec3::new(0.0, -0.6, 0.8)) - DVec3::Z).length() < 1e-12);
        assert_eq!(placement.length(2.0), 0.74);
    }
}
