//! What the page needs of the model of exposure metering, so that its views are exposed as those of `render`.

use glam::DVec3;
use serde::Serialize;

use quadratura_base::scene::PhotoId;
use quadratura_projection::exposure::Meter;

/// The most points at which the page knows the light: an eighth of the program's, which a visitor would load before the first picture.
const MOST_POINTS: usize = 1024;

/// The model of metering, without its points. Logarithms are natural ones, of light in the common exposure.
#[derive(Debug, Serialize)]
pub struct DescribedMeter {
    /// Standard deviations of the meter's weight across and down, as tangents.
    support: [f64; 2],
    /// The weight of the usual reading.
    least: f64,
    /// The decrease of a view's exposure per unit of its reading, R, G, B.
    follows: [f64; 3],
    /// The logarithm of the light that each photo's meter reads.
    readings: Vec<f64>,
    /// The usual reading of the photos like each.
    usual: Vec<f64>,
}

/// Returns the model for the photos of a page; `None` where exposures followed no meter.
pub fn described(meter: &Meter, ids: &[PhotoId]) -> Option<DescribedMeter> {
    let of_photos = |values: &[f64]| ids.iter().map(|id| values[id.index()]).collect();
    (meter.follows != [0.0; 3]).then(|| DescribedMeter {
        support: meter.support,
        least: meter.least / stride(meter) as f64,
        follows: meter.follows,
        readings: of_photos(&meter.readings),
        usual: of_photos(&meter.usual),
    })
}

/// Returns the points as numbers: for each its position less the origin, its area times its normal, and the number of photos of the
/// page that see it, then each of these with the light there. Empty where exposures followed no meter.
pub fn numbers(meter: &Meter, ids: &[PhotoId], origin: DVec3) -> Vec<f32> {
    let mut numbers = Vec::new();
    if meter.follows == [0.0; 3] {
        return numbers;
    }
    for point in meter.points().iter().step_by(stride(meter)) {
        let number = |photo: u32| ids.iter().position(|id| id.0 == photo);
        let seen: Vec<_> = point
            .seen
            .iter()
            .filter_map(|(photo, light)| Some([number(*photo)? as f32, *light as f32]))
            .collect();
        if !seen.is_empty() {
            numbers.extend((point.position - origin).as_vec3().to_array());
            numbers.extend(point.area.as_vec3().to_array());
            numbers.push(seen.len() as f32);
            numbers.extend(seen.into_flattened());
        }
    }
    numbers
}

/// The page has one of so many points.
fn stride(meter: &Meter) -> usize {
    meter.points().len().div_ceil(MOST_POINTS).max(1)
}
