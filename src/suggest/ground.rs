//! The ground under the cameras. Few points lie on it, so it is searched by comparing photos for level planes at all heights.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use quadratura_base::geometry::{Plane, Pose};
use quadratura_base::raster::robust::quantile;

use super::planes::{PlaneKind, PlaneOfPoints, fitted};
use super::points::NormalisedPoint;
use super::support::middle;
use super::view::{Warp, WorkingPhoto};

/// A level plane of so many points is the ground if it is the lowest.
const ENOUGH_POINTS: usize = 150;
/// Heights that are tried, from -0.3 to 0.4 of the cameras' height about the lowest points.
const HEIGHTS: usize = 25;
/// Photos in which the ground is searched.
const PHOTOS: usize = 7;
/// Every so many columns and rows of the finer photos.
const STEP: usize = 8;
/// Columns and rows on each side of a window of 13 x 13.
const WINDOW: i32 = 6;
/// A height is clear when photos agree there so much, and so much better than anywhere else.
const CLEAR: [f32; 2] = [0.6, 0.15];
/// The fewest pixels with a clear height.
const FEWEST: usize = 40;
/// The cosine of the largest tilt, 3 degrees: steps become a tilted plane otherwise.
const MOST_TILT: f64 = 0.9986;

/// Adds the ground to planes, or marks the one that it is. Nothing changes where it is not found.
pub fn with_ground(
    mut planes: Vec<PlaneOfPoints>,
    points: &[NormalisedPoint],
    views: &[WorkingPhoto],
    up: DVec3,
    near: &[Vec<u32>],
) -> Vec<PlaneOfPoints> {
    let height = |plane: &PlaneOfPoints| plane.plane.point.dot(up);
    let mut heights: Vec<f64> = points.iter().map(|point| point.at.dot(up)).collect();
    let Some(low) = quantile(&mut heights, 0.004) else { return planes };
    let eyes = views.iter().map(|view| view.eye.dot(up)).sum::<f64>() / views.len() as f64;
    let above = eyes - low;
    let lowest = planes
        .iter_mut()
        .filter(|plane| plane.kind == PlaneKind::Level && plane.members.len() >= ENOUGH_POINTS)
        .min_by(|a, b| height(a).total_cmp(&height(b)));
    if let Some(lowest) = lowest.filter(|lowest| height(lowest) < low + 0.2 * above.abs()) {
        lowest.kind = PlaneKind::Ground;
        return planes;
    }
    if above <= 0.0 {
        return planes;
    }
    let heights: Vec<f64> =
        (0..HEIGHTS).map(|i| low + above * (-0.3 + 0.7 * i as f64 / (HEIGHTS - 1) as f64)).collect();
    let Some(plane) = searched(views, up, near, &heights, above) else { return planes };
    let is_on = |point: &NormalisedPoint| plane.signed_distance(point.at).abs() < 0.012 * point.away;
    let members: Vec<u32> = (0..).zip(points).filter(|(_, point)| is_on(point)).map(|(i, _)| i).collect();
    // Level planes of few points that are the ground itself.
    planes.retain(|other| {
        other.kind != PlaneKind::Level || (height(other) - plane.point.dot(up)).abs() > 0.06 * above
    });
    planes.push(PlaneOfPoints { plane, kind: PlaneKind::Ground, members, places: Vec::new() });
    planes
}

/// Searches the ground at heights; `above` is the cameras' height above the lowest points.
fn searched(
    views: &[WorkingPhoto],
    up: DVec3,
    near: &[Vec<u32>],
    heights: &[f64],
    above: f64,
) -> Option<Plane> {
    let step = views.len().div_ceil(PHOTOS).max(1);
    let of: Vec<usize> = (0..views.len()).step_by(step).collect();
    let found: Vec<(DVec3, f64)> =
        of.par_iter().flat_map_iter(|of| clear_places(views, *of, &near[*of], up, heights)).collect();
    let spacing = heights[1] - heights[0];
    let count = |height: f64| found.iter().filter(|(_, h)| (h - height).abs() < 1.5 * spacing).count();
    let mode = heights.iter().copied().max_by_key(|height| count(*height))?;
    if count(mode) < FEWEST {
        return None;
    }
    let mut plane = Plane { normal: up, point: up * mode };
    for reach in [0.12, 0.06] {
        let on: Vec<NormalisedPoint> = found
            .iter()
            .filter(|(at, _)| plane.signed_distance(*at).abs() < reach * above)
            .map(|(at, _)| as_point(*at, up))
            .collect();
        let all: Vec<u32> = (0..on.len() as u32).collect();
        let (fit, _) = fitted(&on, &all, None)?;
        let normal = if fit.normal.dot(up) < MOST_TILT { up } else { fit.normal };
        plane = Plane { normal, point: fit.point };
    }
    Some(plane)
}

/// A place on the ground as a point, seen from above.
fn as_point(at: DVec3, up: DVec3) -> NormalisedPoint {
    NormalisedPoint { at, observers: Vec::new(), is_tracked: false, eye: at + up, away: 1.0, sigma: 0.0 }
}

/// Returns the places on level planes where the photos clearly agree, with their heights.
fn clear_places(
    views: &[WorkingPhoto],
    of: usize,
    near: &[u32],
    up: DVec3,
    heights: &[f64],
) -> Vec<(DVec3, f64)> {
    let view = &views[of];
    let camera = view.fine.camera;
    let others: Vec<(&WorkingPhoto, Warp)> = near
        .iter()
        .take(4)
        .map(|i| &views[*i as usize])
        .map(|other| (other, Warp::new((&camera, &view.pose), (&other.fine.camera, &other.pose))))
        .collect();
    let [w, h] = view.fine.size();
    let mut found = Vec::new();
    for (y, x) in (h / 2..h).step_by(STEP).flat_map(|y| (0..w).step_by(STEP).map(move |x| (y, x))) {
        let Some(own) = PixelWindow::new(view, x, y) else { continue };
        let ray = view.pose.rotation.transpose() * camera.ray_in_camera(middle(x, y));
        let fall = ray.dot(up);
        if fall >= -1e-3 {
            continue;
        }
        let scores: Vec<f32> = heights
            .iter()
            .map(|height| {
                let plane = Plane { normal: up, point: up * *height };
                own.agreement(&others, &camera_depth(&view.pose, &plane, view.eye, &camera))
            })
            .collect();
        let Some(best) = (0..scores.len()).max_by(|a, b| scores[*a].total_cmp(&scores[*b])) else { continue };
        let rest = (0..scores.len()).filter(|i| i.abs_diff(best) > 2).map(|i| scores[i]).fold(0.0, f32::max);
        let is_inside = best > 0 && best + 1 < scores.len();
        if is_inside && scores[best] > CLEAR[0] && scores[best] > rest + CLEAR[1] {
            let height = heights[best];
            let t = (height - view.eye.dot(up)) / fall;
            found.push((view.eye + ray * t, height));
        }
    }
    found
}

/// The inverse depth of a plane over the finer photo: its value at a position in pixels.
fn camera_depth<'a>(
    pose: &'a Pose,
    plane: &Plane,
    eye: DVec3,
    camera: &'a quadratura_base::geometry::Pinhole,
) -> impl Fn(DVec2) -> f64 + 'a {
    let normal = pose.rotation * plane.normal / -plane.signed_distance(eye);
    move |px: DVec2| normal.dot(camera.ray_in_camera(px))
}

/// The window around a pixel of the finer photo.
struct PixelWindow {
    places: Vec<DVec2>,
    values: Vec<f32>,
}

impl PixelWindow {
    /// Takes every other pixel of the window; `None` at the border and for plain ones.
    fn new(view: &WorkingPhoto, x: usize, y: usize) -> Option<Self> {
        let [w, h] = view.fine.size();
        let range = || (-WINDOW..=WINDOW).step_by(2);
        let (mut places, mut values) = (Vec::new(), Vec::new());
        for (dy, dx) in range().flat_map(|dy| range().map(move |dx| (dy, dx))) {
            let (x, y) = (x.checked_add_signed(dx as isize)?, y.checked_add_signed(dy as isize)?);
            if x >= w || y >= h {
                return None;
            }
            places.push(middle(x, y));
            values.push(view.fine.values[y * w + x]);
        }
        let values = normalised(values)?;
        Some(Self { places, values })
    }

    /// Returns the mean correlation with the better half of other photos, for an inverse depth.
    fn agreement(&self, others: &[(&WorkingPhoto, Warp)], depth: &impl Fn(DVec2) -> f64) -> f32 {
        let correlation = |(other, warp): &(&WorkingPhoto, Warp)| {
            let seen = |px: &DVec2| {
                let inverse = depth(*px);
                if inverse <= 0.0 { None } else { other.fine.at(warp.at(*px, inverse)?) }
            };
            let values = self.places.iter().map(seen).collect::<Option<Vec<f32>>>().and_then(normalised)?;
            Some(values.iter().zip(&self.values).map(|(a, b)| a * b).sum::<f32>())
        };
        let mut each: Vec<f32> = others.iter().filter_map(correlation).collect();
        each.sort_unstable_by(|a, b| b.total_cmp(a));
        let better = &each[..each.len().div_ceil(2)];
        if better.is_empty() { 0.0 } else { better.iter().sum::<f32>() / better.len() as f32 }
    }
}

/// Returns values with mean 0 and squares that add up to 1; `None` for plain ones.
fn normalised(mut values: Vec<f32>) -> Option<Vec<f32>> {
    let count = values.len() as f32;
    let mean = values.iter().sum::<f32>() / count;
    values.iter_mut().for_each(|value| *value -= mean);
    let length = values.iter().map(|value| value * value).sum::<f32>();
    // A standard deviation of two greys.
    if length < 4.0 * count {
        return None;
    }
    let scale = length.sqrt().recip();
    values.iter_mut().for_each(|value| *value *= scale);
    Some(values)
}
