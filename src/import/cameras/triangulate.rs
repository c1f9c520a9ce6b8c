//! Positions of points that photos observe.

use glam::{DMat3, DVec2, DVec3};

use super::kept::CameraPhoto;
use quadratura_base::geometry::RangedLens;

/// The steps of refinement; each doubles the number of right digits.
const STEPS: usize = 8;
/// The least sine of the angle between two rays; along nearly parallel ones a point has no position.
const NARROWEST: f64 = 1e-3;

/// Returns the position in the world at which photos show a point at places in pixels: the one nearest to all rays, then that with
/// the least squares in the photos. `None` for fewer than two photos, and where the rays are parallel.
pub(super) fn triangulated(seen: &[(&CameraPhoto, DVec2)]) -> Option<DVec3> {
    let rays: Option<Vec<(DVec3, DVec3)>> = seen.iter().map(|(photo, at)| ray(photo, *at)).collect();
    let rays = rays.filter(|rays| rays.len() >= 2)?;
    let widest = rays.iter().map(|(_, along)| along.cross(rays[0].1).length()).fold(0.0, f64::max);
    if widest < NARROWEST {
        return None;
    }
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    // Far from the origin, squares of positions would lose the digits of the rest.
    let origin = rays[0].0;
    for (centre, along) in rays {
        let across = DMat3::IDENTITY - DMat3::from_cols(along * along.x, along * along.y, along * along.z);
        matrix += across;
        right += across * (centre - origin);
    }
    let nearest = origin + matrix.inverse() * right;
    let mut position = nearest;
    for _ in 0..STEPS {
        match stepped(seen, position) {
            Some(next) => position = next,
            // Places that do not belong together have no better one, which their errors of reprojection tell.
            None => return nearest.is_finite().then_some(nearest),
        }
    }
    Some(position)
}

/// Returns the centre of a photo, and the direction in which it shows what is at a place in pixels.
fn ray(photo: &CameraPhoto, at: DVec2) -> Option<(DVec3, DVec3)> {
    let ray = photo.camera.ray_in_camera(at);
    let ray = RangedLens::new(photo.lens).undistort(ray.truncate())?.extend(1.0);
    let ray = match &photo.shutter {
        Some(shutter) => shutter.ray_at_rest(ray, at.y, photo.camera.height.into())?,
        None => ray,
    };
    let centre = photo.pose.center_in_world();
    let along = (photo.pose.rotation.transpose() * ray).try_normalize()?;
    centre.is_finite().then_some((centre, along))
}

/// One step of Gauss and Newton.
fn stepped(seen: &[(&CameraPhoto, DVec2)], position: DVec3) -> Option<DVec3> {
    let (mut normal, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for (photo, at) in seen {
        let depth = photo.pose.camera_from_world(position).z;
        let step = 1e-6 * depth.abs().max(1e-6);
        let shown = |offset: DVec3| photo.image_from_world(position + offset);
        let miss = *at - shown(DVec3::ZERO)?;
        let mut slopes = [DVec2::ZERO; 3];
        for (slope, axis) in slopes.iter_mut().zip(DVec3::AXES) {
            *slope = (shown(axis * step)? - shown(axis * -step)?) / (2.0 * step);
        }
        for row in [slopes.map(|slope| slope.x), slopes.map(|slope| slope.y)]
            .map(DVec3::from)
            .into_iter()
            .zip(miss.to_array())
        {
            let (gradient, miss) = row;
            normal += DMat3::from_cols(gradient * gradient.x, gradient * gradient.y, gradient * gradient.z);
            right += gradient * miss;
        }
    }
    let next = position + normal.inverse() * right;
    next.is_finite().then_some(next)
}
