//! The planes that many sparse points lie on, by sequential RANSAC (Fischler and Bolles 1981; Schnabel, Wahl and Klein
//! 2007 for seeds of near points).

use glam::DVec3;

use quadratura_base::raster::robust::quantile;
use quadratura_base::scene::synthetic::Rng;

use super::linear::eigen;
use super::points::ObservedPoint;

/// A plane of the points.
#[derive(Debug, Clone, PartialEq)]
pub struct PointPlane {
    /// The unit normal, towards the observers.
    pub normal: DVec3,
    /// The points' middle.
    pub point: DVec3,
    /// The points.
    pub members: Vec<u32>,
    /// The distance from the middle within which four fifths of the points lie.
    pub radius: f64,
}

/// A point lies on a plane within this share of its distance from the observer: 8 cm at 20 m.
pub const ON_PLANE: f64 = 0.004;

const MOST_PLANES: usize = 40;
const SEEDS: usize = 1500;
const JUDGES: usize = 1500;

/// Finds the planes, that with most points first, and tells each point which one it lies on.
pub fn planes(sights: &mut [ObservedPoint]) -> Vec<PointPlane> {
    let least = (0.002 * sights.len() as f64).max(12.0) as usize;
    let mut rest = along_a_curve(sights);
    let mut rng = Rng::new(41);
    let mut planes = Vec::new();
    while planes.len() < MOST_PLANES && rest.len() >= least {
        let Some((normal, point)) = best_seed(sights, &rest, &mut rng) else { break };
        let Some((normal, point)) = fitted(sights, &rest, fitted(sights, &rest, Some((normal, point))))
        else {
            break;
        };
        let (members, others): (Vec<u32>, Vec<u32>) =
            rest.iter().partition(|i| is_on(&sights[**i as usize], normal, point));
        if members.len() < least {
            break;
        }
        rest = others;
        planes.push(plane(sights, normal, members));
    }
    planes.sort_by_key(|plane| std::cmp::Reverse(plane.members.len()));
    for (number, plane) in (0..).zip(&planes) {
        plane.members.iter().for_each(|i| sights[*i as usize].plane = Some(number));
    }
    planes
}

fn is_on(sight: &ObservedPoint, normal: DVec3, point: DVec3) -> bool {
    (sight.point - point).dot(normal).abs() < ON_PLANE * sight.depth
}

/// Describes a plane by its members.
fn plane(sights: &[ObservedPoint], normal: DVec3, members: Vec<u32>) -> PointPlane {
    let count = members.len() as f64;
    let of = |i: &u32| &sights[*i as usize];
    let point = members.iter().map(|i| of(i).point).sum::<DVec3>() / count;
    let towards: f64 = members.iter().map(|i| (of(i).eye - of(i).point).normalize().dot(normal)).sum();
    let mut far: Vec<f64> = members.iter().map(|i| of(i).point.distance(point)).collect();
    let radius = quantile(&mut far, 0.8).unwrap_or(0.0);
    PointPlane { normal: if towards < 0.0 { -normal } else { normal }, point, members, radius }
}

/// Returns the plane through three points on which most of the judges lie.
fn best_seed(sights: &[ObservedPoint], rest: &[u32], rng: &mut Rng) -> Option<(DVec3, DVec3)> {
    let step = rest.len().div_ceil(JUDGES).max(1);
    let judges: Vec<&ObservedPoint> = rest.iter().step_by(step).map(|i| &sights[*i as usize]).collect();
    let last = rest.len() as u32 - 1;
    let mut best = (0, None);
    for seed in 0..SEEDS {
        let first = rng.whole(0, last);
        // Neighbours on the curve are near in space, so that most seeds lie on one wall.
        let mut other = || {
            if seed % 5 == 0 {
                return rng.whole(0, last);
            }
            let away = rng.whole(1, 24);
            if rng.chance(0.5) { first.saturating_sub(away) } else { (first + away).min(last) }
        };
        let corners = [first, other(), other()].map(|i| sights[rest[i as usize] as usize].point);
        let across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let Some(normal) = across.try_normalize() else { continue };
        let count = judges.iter().filter(|sight| is_on(sight, normal, corners[0])).count();
        if count > best.0 {
            best = (count, Some((normal, corners[0])));
        }
    }
    best.1
}

/// Fits a plane to the points that lie on it, each by the inverse of its tolerance.
fn fitted(sights: &[ObservedPoint], rest: &[u32], plane: Option<(DVec3, DVec3)>) -> Option<(DVec3, DVec3)> {
    let (normal, point) = plane?;
    let on = || rest.iter().map(|i| &sights[*i as usize]).filter(|sight| is_on(sight, normal, point));
    let weight = |sight: &ObservedPoint| sight.depth.powi(-2);
    let total: f64 = on().map(weight).sum();
    let middle = on().map(|sight| sight.point * weight(sight)).sum::<DVec3>() / total;
    let mut sums = [[0.0; 3]; 3];
    for sight in on() {
        let off = (sight.point - middle).to_array();
        for i in 0..3 {
            for j in 0..3 {
                sums[i][j] += weight(sight) * off[i] * off[j];
            }
        }
    }
    middle.is_finite().then(|| (DVec3::from_array(eigen(sums)[0].1), middle))
}

/// Orders the points along a Z-order curve (Morton 1966) through the box that holds most of them.
fn along_a_curve(sights: &[ObservedPoint]) -> Vec<u32> {
    let bounds = |axis: usize| {
        let mut all: Vec<f64> = sights.iter().map(|sight| sight.point[axis]).collect();
        let low = quantile(&mut all, 0.02).unwrap_or(0.0);
        (low, (quantile(&mut all, 0.98).unwrap_or(1.0) - low).max(1e-9))
    };
    let bounds = [bounds(0), bounds(1), bounds(2)];
    // Cells are cubes, so that the curve does not prefer a thin box's axis.
    let size = bounds.iter().fold(0.0, |size: f64, (_, extent)| size.max(*extent));
    let code = |point: DVec3| {
        let cell: [u64; 3] = std::array::from_fn(|axis| {
            (((point[axis] - bounds[axis].0) / size).clamp(0.0, 1.0) * 1023.0) as u64
        });
        (0..10).fold(0u64, |code, bit| {
            (0..3).fold(code, |code, axis| code | (cell[axis] >> bit & 1) << (3 * bit + axis))
        })
    };
    let mut order: Vec<u32> = (0..sights.len() as u32).collect();
    order.sort_by_cached_key(|i| code(sights[*i as usize].point));
    order
}
