//! The spacing: the root of the area that one pixel of the reference camera takes in the picture, in pixels, by which
//! splats are as large as the gaps between them.
//!
//! Of a plane the area is (f2/f1)^2 (h2/h1) omega^-3, with h_i the distances of the camera centres from the plane, and
//! h2/h1 = 1 - nu . E. So `s = g omega^(-3/2)` with one factor g a surface and picture. The paper (section 4) approximates it
//! by the distance and angle of each depth pixel and a table of 64 entries, which serves its baseline alone.

use glam::{DMat3, DVec2, DVec3};

use super::layout::{Ldi, LdiSurface};
use super::transfer::Transfer;
use quadratura_base::geometry::{Pinhole, Pose};

/// How the spacing is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Spacing {
    /// By the depth pixel's plane.
    #[default]
    Exact,
    /// By the published table of 64 entries.
    Table,
}

/// The factors of the spacing for one picture, by the index that a depth pixel gives.
#[derive(Debug, Clone)]
pub enum Factors {
    /// g by surface; entry 0 is the unknown surface, whose spacing is g / omega.
    Exact(Vec<f32>),
    /// The published lookup divided by the reference depth, see [`Factors::table`]: 64 entries.
    Table(Box<[f32; 64]>),
}

/// Returns h2/h1 of a surface: the distance of the picture's camera from the plane over that of the reference camera, negative
/// on its other side.
fn distance_ratio(surface: &LdiSurface, transfer: &Transfer) -> f64 {
    1.0 - surface.nu.dot(transfer.epipole)
}

/// Returns g of a surface: (f2/f1) sqrt(|h2/h1|).
pub fn factor(surface: &LdiSurface, transfer: &Transfer) -> f64 {
    transfer.focal_ratio * distance_ratio(surface, transfer).abs().sqrt()
}

/// Returns whether the picture shows the side of a surface that the reference camera does not see.
pub fn is_from_behind(surface: &LdiSurface, transfer: &Transfer) -> bool {
    distance_ratio(surface, transfer) <= 0.0
}

/// Returns the spacing at a depth pixel of a surface with factor `g` where the transfer has 1 / omega.
#[inline]
pub fn exact(g: f32, per_omega: f32) -> f32 {
    g * (per_omega * per_omega.sqrt())
}

/// Returns a spacing that is not exceeded where no factor is larger and no omega is smaller than these; infinite where none is
/// known.
pub fn largest(factor: f32, omega: f32) -> f32 {
    /// Spacings in single precision are a little larger.
    const MARGIN: f32 = 1.001;
    let per_omega = 1.0 / omega;
    let spacing = MARGIN * factor * (per_omega * per_omega.sqrt().max(1.0));
    if spacing.is_nan() { f32::INFINITY } else { spacing }
}

/// Returns by number of surface how much its inverse depth changes from pixel to pixel of the picture along u and v, in 1/world
/// unit; 0 for the unknown surface, and infinite where the picture's camera is in the plane. `transfer` is that of the first level.
pub fn gradients(ldi: &Ldi, transfer: &Transfer) -> Vec<[f32; 2]> {
    let known = ldi.surfaces.iter().map(|surface| gradient(surface, transfer));
    std::iter::once([0.0; 2]).chain(known).collect()
}

/// Returns how much the inverse depth of a surface with this gradient changes from pixel to pixel, along both axes together.
pub fn slope([u, v]: [f32; 2]) -> f32 {
    u.abs() + v.abs()
}

/// A plane d = nu . p1 of the reference camera is q = (H^-T nu) . p2 in the picture, where H = A + b nu^T moves its points.
fn gradient(surface: &LdiSurface, transfer: &Transfer) -> [f32; 2] {
    let DVec3 { x, y, z } = surface.nu;
    let b = transfer.b;
    let to_picture = transfer.a + DMat3::from_cols(b * x, b * y, b * z);
    let nu = to_picture.inverse().transpose() * surface.nu;
    if nu.is_nan() { [f32::INFINITY; 2] } else { [nu.x as f32, nu.y as f32] }
}

impl Factors {
    /// Makes the factors by planes. `transfer` is that of the first level: nu and E have its pixels as unit.
    pub fn exact(ldi: &Ldi, transfer: &Transfer, focal_ratio: f64) -> Self {
        let of_level = focal_ratio / transfer.focal_ratio;
        let unknown = focal_ratio as f32;
        let known = ldi.surfaces.iter().map(|surface| (factor(surface, transfer) * of_level) as f32);
        Self::Exact(std::iter::once(unknown).chain(known).collect())
    }

    /// Returns the largest factor of some surfaces, by number; infinite for the table.
    pub fn largest(&self, surfaces: &[u16]) -> f32 {
        match self {
            Self::Exact(factors) => {
                let factors = surfaces.iter().filter_map(|surface| factors.get(usize::from(*surface)));
                factors.copied().fold(0.0, f32::max)
            }
            Self::Table(_) => f32::INFINITY,
        }
    }

    /// Makes the published table: the root of the size is approximated by z2 lookup[n_x, n_y, d1], where z2 is the inverse
    /// depth in the picture's camera and lookup = d1 sqrt(cos(phi2) f2^2 / (cos(phi1) f1^2)); phi_i are the angles between
    /// normal and camera i's axis. The paper prints f2/f1 once where an area needs its square, which does not show while
    /// both are equal.
    pub fn table(ldi: &Ldi, picture: &Pose, focal_ratio: f64) -> Self {
        let picture_axis = ldi.pose.rotation * (picture.rotation.transpose() * DVec3::Z);
        let mut table = Box::new([0.0f32; 64]);
        for (entry, value) in (0u8..).zip(table.iter_mut()) {
            let normal = normal_of_entry(entry);
            let (cos1, cos2) = (normal.z.abs(), normal.dot(picture_axis).abs().max(0.05));
            let distance = distance_of_entry(entry, &ldi.report.quartiles);
            *value = (distance * focal_ratio * (cos2 / cos1).sqrt()) as f32;
        }
        Self::Table(table)
    }
}

/// The number of bins of each component of the normal.
const BINS: usize = 4;
/// The least |n_z| of the normals that a bin stands for.
const LEAST_NZ: f64 = 0.2;

/// Returns the unit normal, in the reference camera, for which a table entry is: the centroid of its bins' part of the unit
/// disc.
pub fn normal_of_entry(entry: u8) -> DVec3 {
    let (bin_x, bin_y) = (usize::from(entry & 3), usize::from(entry >> 2 & 3));
    let (mut sum, mut count) = (DVec2::ZERO, 0.0);
    const STEPS: usize = 32;
    for iy in 0..STEPS {
        for ix in 0..STEPS {
            let within = |bin: usize, i: usize| {
                -1.0 + (bin as f64 + (i as f64 + 0.5) / STEPS as f64) * 2.0 / BINS as f64
            };
            let p = DVec2::new(within(bin_x, ix), within(bin_y, iy));
            if p.length_squared() <= 1.0 {
                sum += p;
                count += 1.0;
            }
        }
    }
    let p = sum / f64::max(count, 1.0);
    let z = (1.0 - p.length_squared()).max(0.0).sqrt().max(LEAST_NZ);
    DVec3::new(p.x, p.y, -z).normalize()
}

/// Returns the distance for which a table entry is: the middle of its quarter of the depth pixels.
fn distance_of_entry(entry: u8, quartiles: &[f64; 3]) -> f64 {
    let [low, middle, high] = *quartiles;
    match entry >> 4 & 3 {
        0 => low,
        1 => (low + middle) / 2.0,
        2 => (middle + high) / 2.0,
        _ => high,
    }
}

/// Returns the distance of a depth pixel from the reference camera, in world units; infinite for inverse depth 0.
pub fn distance(camera: &Pinhole, column: u16, row: u32, inverse_depth: f32) -> f64 {
    let ray = camera.ray_in_camera(DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5));
    ray.length() / f64::from(inverse_depth)
}

/// Returns the quartiles of distances, without those that are infinite; 0 where there are none.
pub fn quartiles(mut distances: Vec<f32>) -> [f64; 3] {
    distances.retain(|distance| distance.is_finite());
    let Some(last) = distances.len().checked_sub(1) else { return [0.0; 3] };
    let [first, second, third] = [1, 2, 3].map(|quarter| quarter * last / 4);
    let (low, median, high) = distances.select_nth_unstable_by(second, f32::total_cmp);
    // Of a few distances, two quartiles may be the same one.
    let of = |part: &mut [f32], at: Option<usize>| match at.filter(|at| *at < part.len()) {
        Some(at) => *part.select_nth_unstable_by(at, f32::total_cmp).1,
        None => *median,
    };
    [of(low, Some(first)), *median, of(high, third.checked_sub(second + 1))].map(f64::from)
}

/// Returns the table entry of a depth pixel with this unit normal (n_z < 0) and distance from the reference camera.
pub fn entry_of(normal: DVec3, distance: f64, quartiles: &[f64; 3]) -> u8 {
    let bin = |value: f64| ((value + 1.0) / 2.0 * BINS as f64).clamp(0.0, BINS as f64 - 1.0) as u8;
    let quarter = quartiles.iter().filter(|quartile| distance > **quartile).count() as u8;
    bin(normal.x) | bin(normal.y) << 2 | quarter << 4
}

/// Returns the unit normal of a surface in the reference camera's frame, towards the camera (n_z < 0 where the camera looks
/// at it within 90 degrees of its axis).
pub fn normal_of(surface: &LdiSurface, camera: &Pinhole) -> DVec3 {
    normal_of_plane(surface.nu, camera)
}

/// Returns the unit normal of the plane with this nu, see [`LdiSurface::nu`], as [`normal_of`].
pub fn normal_of_plane(nu: DVec3, camera: &Pinhole) -> DVec3 {
    let Pinhole { fx, fy, cx, cy, .. } = *camera;
    let matrix =
        DMat3::from_cols(DVec3::new(fx, 0.0, 0.0), DVec3::new(0.0, fy, 0.0), DVec3::new(cx, cy, 1.0));
    // d = nu . K (P / z) and d z = 1 make (K^T nu) . P = 1, so K^T nu points away from the camera.
    let away = matrix.transpose() * nu;
    -away.normalize_or(DVec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    #[test]
    fn quartiles_are_those_of_the_sorted_distances() {
        let mut rng = Rng::new(7);
        for count in (0..12).chain([100, 1001]) {
            // Some are the same.
            let mut distances: Vec<f32> =
                (0..count).map(|_| rng.between(0.0, 256.0).floor() as f32).collect();
            let found = quartiles(distances.iter().copied().chain([f32::INFINITY]).collect());
            distances.sort_by(f32::total_cmp);
            let expected = [1, 2, 3].map(|quarter| match count {
                0 => 0.0,
                _ => f64::from(distances[quarter * (count - 1) / 4]),
            });
            assert_eq!(found, expected, "{count}");
        }
    }
}
