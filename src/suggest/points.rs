//! The sparse points that say something: how far each is from its observers, and how certain that is.

use glam::DVec3;

use quadratura_base::raster::robust::upper_median;

use super::view::WorkingPhoto;

/// A sparse point as a model is suggested from it.
#[derive(Debug, Clone)]
pub struct SourcePoint {
    /// The position in the cameras' world.
    pub position: DVec3,
    /// The photos that show it, as indices of the photos. Empty where nothing is known about it.
    pub observers: Vec<u32>,
    /// The mean angle in radians between the rays of its observations and the point.
    pub error_rad: f64,
}

/// A point in normalised coordinates.
#[derive(Debug, Clone)]
pub struct NormalisedPoint {
    /// The position.
    pub at: DVec3,
    /// The photos that show it, or that should where the files do not say.
    pub observers: Vec<u32>,
    /// Whether the files say which photos show it.
    pub is_tracked: bool,
    /// The mean position of its observers.
    pub eye: DVec3,
    /// Its distance from there.
    pub away: f64,
    /// The standard error of that distance.
    pub sigma: f64,
}

/// The most points that are used: of more, every n-th.
const MOST: usize = 30_000;

/// The least angle between two observers, one degree: less says too little about the distance.
const LEAST_ANGLE_RAD: f64 = 0.0175;

/// The largest error of a distance as a share of it.
const MOST_ERROR: f64 = 0.05;

/// The frame of all computations: `world = origin + unit * normalised`. The unit is the median distance of points from
/// their observers.
#[derive(Debug, Clone, Copy)]
pub struct PointFrame {
    /// The points' middle in the cameras' world.
    pub origin: DVec3,
    /// The unit in units of the cameras' world.
    pub unit: f64,
}

impl PointFrame {
    /// Finds the frame; `None` without points.
    pub fn new(eyes: &[DVec3], points: &[SourcePoint]) -> Option<Self> {
        let finite = || points.iter().filter(|point| point.position.is_finite());
        let mut away: Vec<f64> = finite()
            .flat_map(|point| {
                let near = nearest(eyes, point.position);
                let seen = point.observers.iter().map(|i| eyes[*i as usize]);
                let all: Vec<DVec3> =
                    if point.observers.is_empty() { near.collect() } else { seen.collect() };
                all.into_iter().map(|eye| eye.distance(point.position))
            })
            .collect();
        let middle = |axis: usize| upper_median(&mut finite().map(|p| p.position[axis]).collect::<Vec<_>>());
        let origin = DVec3::new(middle(0)?, middle(1)?, middle(2)?);
        let unit = upper_median(&mut away).filter(|unit| unit.is_finite() && *unit > 0.0)?;
        Some(Self { origin, unit })
    }
}

/// The nearest camera, which stands for the observers of a point without any.
fn nearest(eyes: &[DVec3], point: DVec3) -> impl Iterator<Item = DVec3> {
    eyes.iter()
        .copied()
        .min_by(|a, b| a.distance_squared(point).total_cmp(&b.distance_squared(point)))
        .into_iter()
}

/// Returns the points that are certain enough, in normalised coordinates.
pub fn certain(views: &[WorkingPhoto], points: &[SourcePoint], frame: &PointFrame) -> Vec<NormalisedPoint> {
    let step = points.len().div_ceil(MOST).max(1);
    let kept = points.iter().step_by(step).filter(|point| point.position.is_finite());
    kept.filter_map(|point| normalised(views, point, frame)).collect()
}

fn normalised(views: &[WorkingPhoto], point: &SourcePoint, frame: &PointFrame) -> Option<NormalisedPoint> {
    let at = (point.position - frame.origin) / frame.unit;
    let is_tracked = !point.observers.is_empty();
    let observers = if is_tracked { point.observers.clone() } else { likely_observers(views, at) };
    let rays: Vec<DVec3> = observers.iter().map(|i| views[*i as usize].eye - at).collect();
    let pairs = (1..rays.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
    let angle = pairs.map(|(a, b)| rays[a].angle_between(rays[b])).fold(0.0, f64::max);
    if angle < LEAST_ANGLE_RAD {
        return None;
    }
    let eye = at + rays.iter().sum::<DVec3>() / rays.len() as f64;
    let away = eye.distance(at);
    let sigma = point.error_rad * away / angle.sin().max(LEAST_ANGLE_RAD);
    (away > 0.0 && sigma < MOST_ERROR * away).then_some(NormalisedPoint {
        at,
        observers,
        is_tracked,
        eye,
        away,
        sigma,
    })
}

/// Returns the three nearest cameras that have a point in their picture.
fn likely_observers(views: &[WorkingPhoto], at: DVec3) -> Vec<u32> {
    let mut seen: Vec<(f64, u32)> = (0..)
        .zip(views)
        .filter(|(_, view)| view.project(at).is_some())
        .map(|(i, view)| (view.eye.distance(at), i))
        .collect();
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    seen.into_iter().take(3).map(|(_, i)| i).collect()
}

/// Returns the weight of each pair of photos for comparing them: points that both show, less where the cameras are too near to
/// each other or too far apart. Rows are sorted, best first.
pub fn neighbours(views: &[WorkingPhoto], points: &[NormalisedPoint]) -> Vec<Vec<u32>> {
    let count = views.len();
    let mut common = vec![0u32; count * count];
    for point in points {
        for a in &point.observers {
            for b in &point.observers {
                common[*a as usize * count + *b as usize] += 1;
            }
        }
    }
    let weight = |a: usize, b: usize| {
        let apart = views[a].eye.distance(views[b].eye);
        f64::from(common[a * count + b]) * (apart / 0.08).min(1.0) * (0.5 / apart.max(1e-9)).min(1.0)
    };
    let row = |a: usize| {
        let mut others: Vec<(f64, u32)> = (0..count)
            .filter(|b| *b != a)
            .map(|b| (weight(a, b), b as u32))
            .filter(|(w, _)| *w > 0.0)
            .collect();
        others.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
        others.into_iter().map(|(_, b)| b).collect()
    };
    (0..count).map(row).collect()
}
