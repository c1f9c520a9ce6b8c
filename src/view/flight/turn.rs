//! Smooth interpolation of rotations through keyframes, without flips.
//!
//! Each segment is a cubic Bezier curve on the unit quaternions, evaluated by De Casteljau's steps as
//! spherical interpolations (Shoemake, *Animating Rotation with Quaternion Curves*, SIGGRAPH 1985). Its inner
//! points follow from the angular velocities at the keyframes.

use glam::{DQuat, DVec3};

use super::spline::{segment, velocity};

/// A spline through rotations at uneven knots; once continuously differentiable.
#[derive(Debug, Clone)]
pub(super) struct TurnSpline {
    knots: Vec<f64>,
    /// The rotations, each on the same hemisphere as the one before, so that the shorter way is taken.
    rotations: Vec<DQuat>,
    /// Rotation vectors per knot unit at each keyframe, in its own frame.
    velocities: Vec<DVec3>,
}

impl TurnSpline {
    /// Builds the spline through `rotations`, as many as `knots`, which rise; at least one.
    pub fn new(knots: &[f64], rotations: &[DQuat]) -> Self {
        let mut near: Vec<DQuat> = Vec::with_capacity(rotations.len());
        for &rotation in rotations {
            let flipped = near.last().is_some_and(|before| before.dot(rotation) < 0.0);
            near.push(if flipped { -rotation } else { rotation });
        }
        let turn = |i: usize| (near[i].conjugate() * near[i + 1]).to_scaled_axis();
        // A rotation vector has the same coordinates in the frames at both ends of its segment.
        let slope = |i: usize| turn(i) / (knots[i + 1] - knots[i]);
        let velocities = (0..near.len()).map(|i| velocity(knots, i, slope)).collect();
        Self { knots: knots.to_vec(), rotations: near, velocities }
    }

    /// Returns the rotation at `knot`, clamped to the ends.
    pub fn at(&self, knot: f64) -> DQuat {
        let Some((i, step, t)) = segment(&self.knots, knot) else { return self.rotations[0] };
        let third = |i: usize, sign: f64| DQuat::from_scaled_axis(self.velocities[i] * (sign * step / 3.0));
        let (start, end) = (self.rotations[i], self.rotations[i + 1]);
        let (after, before) = (start * third(i, 1.0), end * third(i + 1, -1.0));
        let (a, b, c) = (start.slerp(after, t), after.slerp(before, t), before.slerp(end, t));
        a.slerp(b, t).slerp(b.slerp(c, t), t).normalize()
    }
}
