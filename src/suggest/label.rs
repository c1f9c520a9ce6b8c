//! What each pixel of a photo shows: one of the planes, the model that is given, or what is far away. This is piecewise planar
//! stereo (Sinha, Steedly and Szeliski, *Piecewise Planar Stereo for Image-based Rendering*, 2009).

use glam::{DVec2, DVec3};

use quadratura_base::geometry::Plane;

use super::compare::{Comparer, NEIGHBOURS, NEUTRAL, PixelBounds};
use super::planes::{PlaneKind, PlaneOfPoints};
use super::points::NormalisedPoint;
use super::sgm::best_labels;
use super::support::{PlaneSupport, middle};
use super::view::{PlaneDepth, WorkingPhoto};

/// What is far away.
pub const FAR: u16 = u16::MAX;
/// The model that is given.
pub const GIVEN: u16 = u16::MAX - 1;
/// What the photo does not show.
pub const UNKNOWN: u16 = u16::MAX - 2;

/// The cost of what is impossible.
const IMPOSSIBLE: f32 = 12.0;

/// The cost of a depth that differs from that of a point by twice its tolerance or more.
const OFF_POINT: f32 = 2.0;

/// Points count within this distance of where a photo shows them, in pixels.
const NEAR_PX: i32 = 5;

/// What photos are labelled with.
#[derive(Debug, Clone)]
pub struct LabelCandidates {
    /// The planes; labels are their indices.
    pub planes: Vec<PlaneOfPoints>,
    /// What points say about each.
    pub supports: Vec<PlaneSupport>,
    /// The direction upwards.
    pub up: DVec3,
    /// The weight of rays that pass through planes.
    pub violation: f32,
}

impl LabelCandidates {
    /// Returns the ground.
    pub fn ground(&self) -> Option<&Plane> {
        self.planes.iter().find(|plane| plane.kind == PlaneKind::Ground).map(|plane| &plane.plane)
    }
}

/// A photo, and what is known about it besides the planes.
pub struct LabelledPhoto<'a> {
    /// All photos.
    pub views: &'a [WorkingPhoto],
    /// The one that is labelled.
    pub of: usize,
    /// The photos with which it is compared, best first.
    pub neighbours: &'a [u32],
    /// The points.
    pub points: &'a [NormalisedPoint],
    /// How likely each pixel shows the sky.
    pub sky: &'a [f32],
    /// The inverse depth of the given model; 0 where it is not.
    pub given: Option<&'a [f32]>,
}

impl LabelledPhoto<'_> {
    fn view(&self) -> &WorkingPhoto {
        &self.views[self.of]
    }
}

/// The labels of a photo, with how much the photos disagree about each.
#[derive(Debug, Clone)]
pub struct PhotoLabels {
    /// The label of each pixel.
    pub of: Vec<u16>,
    /// The cost of the label by the photos' agreement alone.
    pub cost: Vec<f32>,
}

/// Labels a photo.
pub fn labelled(subject: &LabelledPhoto<'_>, candidates: &LabelCandidates) -> PhotoLabels {
    let view = subject.view();
    let comparer = Comparer::new(subject.views, subject.of, subject.neighbours, NEIGHBOURS);
    let pinned = Pinned::new(subject);
    let ground =
        candidates.ground().filter(|plane| is_front(view, plane)).map(|plane| view.inverse_depth(plane));
    let mut columns: Vec<(u16, Costs)> = Vec::new();
    for (i, (plane, support)) in (0..).zip(candidates.planes.iter().zip(&candidates.supports)) {
        if is_front(view, &plane.plane) {
            let place =
                PlanePlace { plane, support, ground: ground.as_ref(), violation: candidates.violation };
            columns.extend(plane_costs(subject, &comparer, &pinned, &place).map(|costs| (i, costs)));
        }
    }
    let far = far_costs(subject, &comparer, &pinned, candidates.up);
    columns.push((FAR, far));
    if let Some(given) = subject.given {
        columns.push((GIVEN, given_costs(subject, &comparer, &pinned, given)));
    }
    chosen(view, &columns)
}

/// The costs of one label at each pixel.
struct Costs {
    all: Vec<f32>,
    /// By the agreement of photos alone.
    agreement: Vec<f32>,
}

/// Chooses the best labels.
fn chosen(view: &WorkingPhoto, columns: &[(u16, Costs)]) -> PhotoLabels {
    let [w, h] = view.size();
    let count = columns.len();
    let mut costs = vec![0.0; w * h * count];
    for (k, (_, column)) in columns.iter().enumerate() {
        for (at, cost) in column.all.iter().enumerate().filter(|(at, _)| view.known[*at]) {
            costs[at * count + k] = *cost;
        }
    }
    let best = best_labels(&costs, count, &view.greys.values, [w, h]);
    let label = |(at, k): (usize, &u16)| match columns[usize::from(*k)] {
        _ if !view.known[at] => UNKNOWN,
        // SGM may go on over a place where the label cannot be.
        (label, ref column) if column.all[at] < IMPOSSIBLE || label == FAR => label,
        _ => FAR,
    };
    let of = best.iter().enumerate().map(label).collect();
    let cost = best.iter().enumerate().map(|(at, k)| columns[usize::from(*k)].1.agreement[at]).collect();
    PhotoLabels { of, cost }
}

/// Returns whether a photo sees the front of a plane.
pub fn is_front(view: &WorkingPhoto, plane: &Plane) -> bool {
    plane.signed_distance(view.eye) > 1e-3
}

/// The sparse points that a photo shows, and the pixels near each.
struct Pinned {
    /// For each pixel the index of the nearest point in `points`.
    nearest: Vec<Option<u32>>,
    /// The column, row and depth of each point, and the tolerance of the depth.
    points: Vec<[f64; 4]>,
}

impl Pinned {
    fn new(subject: &LabelledPhoto<'_>) -> Self {
        let view = subject.view();
        let [w, h] = view.size();
        let mut nearest = vec![None; w * h];
        let mut away = vec![i32::MAX; w * h];
        let mut points = Vec::new();
        for point in
            subject.points.iter().filter(|p| p.is_tracked && p.observers.contains(&(subject.of as u32)))
        {
            let Some((px, z)) = view.project(point.at) else { continue };
            let own = points.len() as u32;
            points.push([px.x, px.y, z, (2.0 * point.sigma).max(0.004 * z)]);
            for (dx, dy) in (-NEAR_PX..=NEAR_PX).flat_map(|dx| (-NEAR_PX..=NEAR_PX).map(move |dy| (dx, dy))) {
                let (x, y) = (px.x as i32 + dx, px.y as i32 + dy);
                let square = dx * dx + dy * dy;
                if square <= NEAR_PX * NEAR_PX && x >= 0 && y >= 0 && (x as usize) < w && (y as usize) < h {
                    let at = y as usize * w + x as usize;
                    if square < away[at] {
                        (nearest[at], away[at]) = (Some(own), square);
                    }
                }
            }
        }
        Self { nearest, points }
    }

    /// Returns what a plane costs at each point.
    fn costs(&self, depth: &PlaneDepth) -> Vec<f32> {
        self.costs_by(|px| depth.between(px.x - 0.5, px.y - 0.5))
    }

    /// Returns what inverse depths cost at each point: at the position itself, because depth changes from pixel to pixel.
    fn costs_by(&self, depth: impl Fn(DVec2) -> f64) -> Vec<f32> {
        let cost = |(point, at): (u32, &[f64; 4])| self.cost(point, depth(DVec2::new(at[0], at[1])));
        (0..).zip(&self.points).map(cost).collect()
    }

    /// Returns what an inverse depth costs at a point.
    fn cost(&self, point: u32, inverse: f64) -> f32 {
        let [_, _, z, tolerance] = self.points[point as usize];
        if inverse <= 0.0 {
            return OFF_POINT;
        }
        OFF_POINT * ((1.0 / inverse - z).abs() / (2.0 * tolerance)).min(1.0) as f32
    }
}

/// A plane, and what it is judged by.
struct PlanePlace<'a> {
    plane: &'a PlaneOfPoints,
    support: &'a PlaneSupport,
    ground: Option<&'a PlaneDepth>,
    violation: f32,
}

/// Returns the costs of a plane; `None` where the photo does not show it.
fn plane_costs(
    subject: &LabelledPhoto<'_>,
    comparer: &Comparer<'_>,
    pinned: &Pinned,
    place: &PlanePlace<'_>,
) -> Option<Costs> {
    let view = subject.view();
    let [w, h] = view.size();
    let depth = view.inverse_depth(&place.plane.plane);
    let mut all = vec![IMPOSSIBLE; w * h];
    let (mut low, mut high) = ([w, h], [0, 0]);
    for (y, x) in (0..h).flat_map(|y| (0..w).map(move |x| (y, x))) {
        let inverse = depth.at(x, y);
        if inverse <= 1e-4 {
            continue;
        }
        let point = view.eye + view.ray(middle(x, y)) / inverse;
        let Some((distance, violation)) = place.support.at(point) else { continue };
        let below = place.ground.filter(|_| place.plane.kind != PlaneKind::Ground).map_or(0.0, |ground| {
            let deeper = ground.at(x, y) / inverse - 1.0;
            1.5 * (deeper / 0.05).clamp(0.0, 1.0) as f32
        });
        let far = 0.3 * ((distance - 0.05).max(0.0) / 0.3).min(2.0);
        let at = y * w + x;
        all[at] = far + place.violation * violation + 0.4 * subject.sky[at] + below;
        (low, high) = ([low[0].min(x), low[1].min(y)], [high[0].max(x + 1), high[1].max(y + 1)]);
    }
    if low[0] >= high[0] {
        return None;
    }
    let at_points = pinned.costs(&depth);
    let bounds = PixelBounds { low, high };
    let disagreement = comparer.disagreement(|x, y| depth.at(x, y), bounds);
    let mut agreement = vec![NEUTRAL; w * h];
    let pixels = (low[1]..high[1]).flat_map(|y| (low[0]..high[0]).map(move |x| y * w + x));
    for (at, disagreement) in
        pixels.zip(disagreement).filter(|(at, _)| all[*at] < IMPOSSIBLE).collect::<Vec<_>>()
    {
        agreement[at] = comparer.cost(at, disagreement);
        all[at] += agreement[at] + pinned.nearest[at].map_or(0.0, |point| at_points[point as usize]);
    }
    Some(Costs { all, agreement })
}

/// Returns the costs of what is far away: little in the sky, much below the horizon.
fn far_costs(subject: &LabelledPhoto<'_>, comparer: &Comparer<'_>, pinned: &Pinned, up: DVec3) -> Costs {
    let view = subject.view();
    let w = view.size()[0];
    let agreement = comparer.cost_far();
    let cost = |(at, own): (usize, &f32)| {
        let sky = 0.25 + 1.5 * (1.0 - subject.sky[at]);
        let is_below = view.ray(middle(at % w, at / w)).dot(up) < 0.0;
        let at_point = pinned.nearest[at].map_or(0.0, |_| OFF_POINT);
        sky.min(0.7 + own) + if is_below { 1.5 } else { 0.0 } + at_point
    };
    let all = agreement.iter().enumerate().map(cost).collect();
    Costs { all, agreement }
}

/// Returns the costs of the given model, which is preferred a little.
fn given_costs(
    subject: &LabelledPhoto<'_>,
    comparer: &Comparer<'_>,
    pinned: &Pinned,
    given: &[f32],
) -> Costs {
    let w = subject.view().size()[0];
    let depth = |x: usize, y: usize| match given[y * w + x] {
        inverse if inverse > 0.0 => f64::from(inverse),
        _ => -1.0,
    };
    let disagreement = comparer.disagreement(depth, comparer.whole());
    let agreement: Vec<f32> = disagreement.iter().enumerate().map(|(at, c)| comparer.cost(at, *c)).collect();
    let at_points = pinned.costs_by(|px| f64::from(given[subject.view().index(px)]));
    let cost = |(at, own): (usize, &f32)| {
        if given[at] <= 0.0 {
            return IMPOSSIBLE;
        }
        let at_point = pinned.nearest[at].map_or(0.0, |point| at_points[point as usize]);
        own + 0.4 * subject.sky[at] - 0.3 + at_point
    };
    let all = agreement.iter().enumerate().map(cost).collect();
    Costs { all, agreement }
}
