//! Directions within a plane of the points along which things on it are likely to run.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use quadratura_base::raster::robust::upper_median;

use super::points::Points;

/// Half a degree each, over a right angle.
const STEPS: usize = 180;

/// Points lie in rows where their histogram along an axis is so much more peaked than at most angles.
const PEAKED: f64 = 1.12;

/// Returns one or two unit directions in the plane with this index: where it falls, and along which its points lie in
/// rows, or else where most other planes cross it.
pub fn directions(points: &Points, index: usize) -> Vec<DVec3> {
    let normal = points.planes[index].normal;
    let falls = points.vertical.map(|vertical| vertical.reject_from(normal));
    let mut found: Vec<DVec3> =
        falls.filter(|along| along.length() > 0.3).map(DVec3::normalize).into_iter().collect();
    found.extend(rows(points, index).or_else(|| crossings(points, index)));
    found
}

/// Finds the angle at which the points' projections on two axes are most peaked.
fn rows(points: &Points, index: usize) -> Option<DVec3> {
    const BINS: usize = 128;
    let plane = &points.planes[index];
    let (u, v) = plane.normal.any_orthonormal_pair();
    let reach = 2.0 * plane.radius;
    let step = plane.members.len().div_ceil(3000).max(1);
    let flat: Vec<(f64, f64)> = plane
        .members
        .iter()
        .step_by(step)
        .map(|i| points.sights[*i as usize].point - plane.point)
        .map(|off| (off.dot(u), off.dot(v)))
        .collect();
    let peaked = |step: usize| {
        let (sin, cos) = (step as f64 / STEPS as f64 * FRAC_PI_2).sin_cos();
        let mut counts = [[0u32; BINS]; 2];
        for (x, y) in &flat {
            for (counts, along) in counts.iter_mut().zip([x * cos + y * sin, y * cos - x * sin]) {
                let bin = (along / reach + 1.0) * 0.5 * BINS as f64;
                if (0.0..BINS as f64).contains(&bin) {
                    counts[bin as usize] += 1;
                }
            }
        }
        counts.as_flattened().iter().map(|count| f64::from(*count).powi(2)).sum::<f64>()
    };
    let peaks: Vec<f64> = (0..STEPS).map(peaked).collect();
    let best = (0..STEPS).max_by(|a, b| peaks[*a].total_cmp(&peaks[*b]))?;
    let usual = upper_median(&mut peaks.clone())?;
    let (sin, cos) = (best as f64 / STEPS as f64 * FRAC_PI_2).sin_cos();
    (peaks[best] > PEAKED * usual).then_some(u * cos + v * sin)
}

/// Finds the direction along which most points' planes cross this one.
fn crossings(points: &Points, index: usize) -> Option<DVec3> {
    let plane = &points.planes[index];
    let (u, v) = plane.normal.any_orthonormal_pair();
    let mut weights = [0.0; STEPS];
    for other in &points.planes {
        let Some(along) = plane.normal.cross(other.normal).try_normalize() else { continue };
        if plane.normal.dot(other.normal).abs() > 0.9 {
            continue;
        }
        let at = along.dot(v).atan2(along.dot(u)).rem_euclid(FRAC_PI_2) / FRAC_PI_2 * STEPS as f64;
        for off in -3i32..=3 {
            let step = (at as i32 + off).rem_euclid(STEPS as i32) as usize;
            weights[step] += (other.members.len() as f64).sqrt() * f64::from(4 - off.abs());
        }
    }
    let best = (0..STEPS).max_by(|a, b| weights[*a].total_cmp(&weights[*b]))?;
    let (sin, cos) = ((best as f64 + 0.5) / STEPS as f64 * FRAC_PI_2).sin_cos();
    (weights[best] > 0.0).then_some(u * cos + v * sin)
}
