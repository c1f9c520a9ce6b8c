//! The timing of a flight: at its keyframes' times, or at a constant speed.

use glam::{DQuat, DVec3};

use super::Flight;
use super::spline::Spline;

/// The speed of a flight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Speed {
    /// The flight passes each keyframe at its time.
    #[default]
    Timed,
    /// The flight moves and turns at a constant speed from the first keyframe's time to the last one's.
    Constant,
    /// Constant speed, with a gentle start and end.
    Eased,
}

/// The number of steps in which a segment's length is measured; the length is interpolated smoothly between
/// them.
const STEPS: usize = 64;

/// Returns the knots of the splines: the times, or numbers that rise with the path length between keyframes.
pub(super) fn knots(times: &[f64], positions: &[DVec3], rotations: &[DQuat], speed: Speed) -> Vec<f64> {
    if speed == Speed::Timed {
        return times.to_vec();
    }
    let way = PathLength::new(positions, rotations);
    let mut knots = vec![0.0];
    for (i, positions) in positions.windows(2).enumerate() {
        let length = way.between((positions[0], rotations[i]), (positions[1], rotations[i + 1]));
        // Centripetal parametrisation: the square root avoids loops and cusps (Yuksel, Schaefer & Keyser, *On
        // the Parameterization of Catmull-Rom Curves*, 2009). The minimum separates keyframes that are equal.
        knots.push(knots[i] + length.max(1e-6).sqrt());
    }
    knots
}

/// A measure of path length that combines movement and rotation, which have equal weight over the whole
/// flight.
#[derive(Debug, Clone, Copy)]
struct PathLength {
    /// The total length in world units, or 1 where there is no movement; below, the total angle in radians,
    /// or 1.
    distance: f64,
    angle_rad: f64,
}

impl PathLength {
    fn new(positions: &[DVec3], rotations: &[DQuat]) -> Self {
        let distance: f64 = positions.windows(2).map(|p| p[0].distance(p[1])).sum();
        let angle_rad: f64 = rotations.windows(2).map(|r| angle(r[0], r[1])).sum();
        let or_one = |length: f64, least: f64| if length > least { length } else { 1.0 };
        // Smaller values are rounding errors, which must not count as movement.
        let reach = positions.iter().map(|p| p.length()).fold(0.0, f64::max);
        Self { distance: or_one(distance, 1e-9 * reach), angle_rad: or_one(angle_rad, 1e-6) }
    }

    fn between(&self, (p, q): (DVec3, DQuat), (r, s): (DVec3, DQuat)) -> f64 {
        p.distance(r) / self.distance + angle(q, s) / self.angle_rad
    }
}

fn angle(a: DQuat, b: DQuat) -> f64 {
    let turn = a.conjugate() * b;
    2.0 * turn.xyz().length().atan2(turn.w.abs())
}

/// The mapping from time to knots.
#[derive(Debug, Clone)]
pub(super) struct Pace {
    span_s: [f64; 2],
    eased: bool,
    /// The knots as a function of the share of the path length, 0..1.
    knots: Spline<1>,
}

impl Pace {
    /// Maps times linearly to knots, which are the times, or proportional to them.
    pub fn even(knots: &[f64], times: &[f64]) -> Self {
        let ends = vec![[knots[0]], [knots[knots.len() - 1]]];
        Self {
            span_s: [times[0], times[times.len() - 1]],
            eased: false,
            knots: Spline::new(&[0.0, 1.0], ends),
        }
    }

    /// Maps equal times to equal path lengths of `flight`.
    pub fn measured(flight: &Flight, knots: &[f64], times: &[f64], eased: bool) -> Self {
        let even = Self::even(knots, times);
        let steps = (knots.len() - 1) * STEPS;
        if steps == 0 {
            return even;
        }
        let knot = |step: usize| {
            let (i, part) = (step / STEPS, (step % STEPS) as f64 / STEPS as f64);
            if part == 0.0 { knots[i] } else { knots[i] + part * (knots[i + 1] - knots[i]) }
        };
        let poses: Vec<(DVec3, DQuat)> = (0..=steps).map(|step| pose_at(flight, knot(step))).collect();
        let (positions, rotations): (Vec<_>, Vec<_>) = poses.iter().copied().unzip();
        let way = PathLength::new(&positions, &rotations);
        let (mut done, mut marks) = (vec![0.0], vec![[knots[0]]]);
        for (step, pair) in poses.windows(2).enumerate() {
            let length = way.between(pair[0], pair[1]);
            // Steps without movement take no time; the later knot counts.
            if length > 0.0 {
                done.push(done[done.len() - 1] + length);
                marks.push([knot(step + 1)]);
            }
        }
        let whole = done[done.len() - 1];
        if whole <= 0.0 {
            return even;
        }
        done.iter_mut().for_each(|way| *way /= whole);
        Self { eased, knots: Spline::new(&done, marks), ..even }
    }

    /// Returns the first and the last time, in seconds.
    pub fn span_s(&self) -> [f64; 2] {
        self.span_s
    }

    /// Returns the knot at a time in seconds, clamped to the ends.
    pub fn knot_at(&self, time_s: f64) -> f64 {
        let [start, end] = self.span_s;
        let share = if end > start { ((time_s - start) / (end - start)).clamp(0.0, 1.0) } else { 0.0 };
        // Smoothstep, which starts and ends at rest.
        let way = if self.eased { share * share * (3.0 - 2.0 * share) } else { share };
        self.knots.at(way)[0]
    }
}

fn pose_at(flight: &Flight, knot: f64) -> (DVec3, DQuat) {
    let pose = flight.pose(knot);
    (pose.center_in_world(), DQuat::from_mat3(&pose.rotation.transpose()))
}
