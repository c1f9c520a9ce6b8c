//! The local origin: programs that compute in f32 lose pixels where coordinates are large.

use glam::DVec3;

use quadratura_base::scene::Site;

/// The largest coordinate, in world units, that is left as it is.
const LARGEST: f64 = 1e4;
/// The same in extents of the site: f32 has 24 bits, so that a thousandth of them is left for the site, a millionth of its size each.
const LARGEST_IN_EXTENTS: f64 = 1e3;

/// Returns the point that every export subtracts from coordinates of the world, the same whatever the format and the photos that are
/// exported: zero where coordinates are small, else the middle of the site, rounded to a power of ten near a tenth of its extent.
pub fn local_origin(site: &Site) -> DVec3 {
    let cameras = site.photos.iter().map(|photo| photo.pose.center_in_world());
    let points = cameras.chain(site.model.vertices.iter().copied());
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
        local_origin(&Site { photos: Vec::new(), model })
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
}
