//! The lens of a photo and of a view: it darkens the image towards the corners, and adds a little light everywhere.
//!
//! With the light L, a photo shows `e^(a r^2 + b r^4) L + offset`.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use quadratura_base::geometry::Pinhole;

/// The vignetting and offset of one photo.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Optics {
    /// The coefficients of the falloff, the logarithm of the light at a distance r from the principal point
    /// relative to that at it: `falloff[0] r^2 + falloff[1] r^4`, with r in half diagonals of the image.
    pub falloff: [f64; 2],
    /// The light added everywhere, equal in all channels; white is 1.
    pub offset: f64,
}

impl Optics {
    /// Returns the logarithm of the falloff at a squared distance from the principal point, in squared half
    /// diagonals of the image.
    pub fn log_light(&self, r2: f64) -> f64 {
        (self.falloff[0] + self.falloff[1] * r2) * r2
    }

    /// Removes offset and falloff from linear light. Light darker than the offset becomes almost black.
    pub fn undone(&self, light: [f64; 3], r2: f64) -> [f64; 3] {
        /// A value darker than half a step of 8 bits: 1 / 255 / 12.92 / 2.
        const ALMOST_BLACK: f64 = 1.5e-4;
        if *self == Self::default() {
            return light;
        }
        let brighter = (-self.log_light(r2)).exp();
        light.map(|light| (light - self.offset).max(light.min(ALMOST_BLACK)) * brighter)
    }

    /// Applies falloff and offset to linear light: the inverse of [`Self::undone`] for light that is not almost black.
    pub fn applied(&self, light: [f64; 3], r2: f64) -> [f64; 3] {
        if *self == Self::default() {
            return light;
        }
        let darker = self.log_light(r2).exp();
        light.map(|light| light * darker + self.offset)
    }
}

/// The darkening of a view towards its corners, as by a lens, in terms of the view's field rather than of its size.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ViewLens {
    /// The coefficients of the logarithm of the light: of the squared tangent of the angle to the axis, and of its square.
    pub falloff: [f64; 2],
    /// The largest squared tangent that the lenses show; beyond, the light stays as it is there.
    pub widest: f64,
}

impl ViewLens {
    /// Returns the lens of a photo.
    fn of_photo(optics: &Optics, camera: &Pinhole) -> Self {
        let [width, height] = [camera.width, camera.height].map(f64::from);
        let corners = [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]];
        let tangents = corners.map(|corner| squared_tangent(camera, corner.into()));
        let widest = tangents.into_iter().fold(0.0, f64::max);
        // Half diagonals per tangent, squared.
        let per_tangent =
            squared_radius(camera, DVec2::new(camera.cx + (camera.fx * camera.fy).sqrt(), camera.cy));
        let [a, b] = optics.falloff;
        Self { falloff: [a * per_tangent, b * per_tangent * per_tangent], widest }
    }

    /// Returns the mean of photos' lenses with these weights; neutral without weight.
    pub fn mean<'a>(photos: impl Iterator<Item = (&'a Optics, &'a Pinhole, f64)>) -> Self {
        let (mut sum, mut all) = (Self::default(), 0.0);
        for (optics, camera, weight) in photos {
            let lens = Self::of_photo(optics, camera);
            (0..2).for_each(|i| sum.falloff[i] += weight * lens.falloff[i]);
            sum.widest += weight * lens.widest;
            all += weight;
        }
        if all <= 0.0 {
            return Self::default();
        }
        Self { falloff: sum.falloff.map(|sum| sum / all), widest: sum.widest / all }
    }

    /// Returns the factor on light at a squared tangent of the angle to the view's axis.
    pub fn factor(&self, squared_tangent: f64) -> f64 {
        let t2 = squared_tangent.min(self.widest);
        ((self.falloff[0] + self.falloff[1] * t2) * t2).exp()
    }
}

/// Computes the squared tangent of the angle between a pixel's ray and the axis; both image axes count by the geometric mean
/// of their focal lengths, as in [`squared_radius`].
pub fn squared_tangent(camera: &Pinhole, px: DVec2) -> f64 {
    px.distance_squared(DVec2::new(camera.cx, camera.cy)) / (camera.fx * camera.fy)
}

/// Computes the squared distance of an image point from the principal point, in squared half diagonals.
pub fn squared_radius(camera: &Pinhole, px: DVec2) -> f64 {
    let half_diagonal2 = 0.25 * (f64::from(camera.width).powi(2) + f64::from(camera.height).powi(2));
    px.distance_squared(DVec2::new(camera.cx, camera.cy)) / half_diagonal2
}
