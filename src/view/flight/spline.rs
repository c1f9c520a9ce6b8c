//! A cubic Hermite spline through points at uneven knots.

/// A spline through `N`-dimensional points; once continuously differentiable.
#[derive(Debug, Clone)]
pub(super) struct Spline<const N: usize> {
    knots: Vec<f64>,
    points: Vec<[f64; N]>,
    /// Change per knot unit at each point.
    velocities: Vec<[f64; N]>,
}

impl<const N: usize> Spline<N> {
    /// Builds the spline through `points`, as many as `knots`, which rise; at least one.
    pub fn new(knots: &[f64], points: Vec<[f64; N]>) -> Self {
        let slopes: Vec<[f64; N]> = (1..points.len())
            .map(|i| {
                let step = knots[i] - knots[i - 1];
                std::array::from_fn(|axis| (points[i][axis] - points[i - 1][axis]) / step)
            })
            .collect();
        let velocities = (0..points.len())
            .map(|i| std::array::from_fn(|axis| velocity(knots, i, |segment| slopes[segment][axis])))
            .collect();
        Self { knots: knots.to_vec(), points, velocities }
    }

    /// Returns the spline's point at `knot`; before the first knot and after the last one, it is the end point.
    pub fn at(&self, knot: f64) -> [f64; N] {
        let Some((i, step, t)) = segment(&self.knots, knot) else { return self.points[0] };
        let (t2, t3) = (t * t, t * t * t);
        std::array::from_fn(|axis| {
            (2.0 * t3 - 3.0 * t2 + 1.0) * self.points[i][axis]
                + (3.0 * t2 - 2.0 * t3) * self.points[i + 1][axis]
                + step * (t3 - 2.0 * t2 + t) * self.velocities[i][axis]
                + step * (t3 - t2) * self.velocities[i + 1][axis]
        })
    }
}

/// Returns the segment that `knot` lies in, its length in knot units, and the position in it, 0..1; `None`
/// where there is one knot only.
pub(super) fn segment(knots: &[f64], knot: f64) -> Option<(usize, f64, f64)> {
    let last = knots.len().checked_sub(2)?;
    let i = knots.partition_point(|k| *k <= knot).saturating_sub(1).min(last);
    let step = knots[i + 1] - knots[i];
    Some((i, step, ((knot - knots[i]) / step).clamp(0.0, 1.0)))
}

/// Computes the velocity at point `i` from the slopes of the adjacent segments, of which the shorter one
/// weighs more, so that a parabola is reproduced exactly. At the ends it is the slope of the end segment.
pub(super) fn velocity<T>(knots: &[f64], i: usize, slope: impl Fn(usize) -> T) -> T
where
    T: std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T> + Default,
{
    let last = knots.len() - 1;
    match i {
        _ if last == 0 => T::default(),
        0 => slope(0),
        _ if i == last => slope(last - 1),
        _ => {
            let (before, after) = (knots[i] - knots[i - 1], knots[i + 1] - knots[i]);
            slope(i - 1) * (after / (before + after)) + slope(i) * (before / (before + after))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_at_uneven_knots_is_met_between_inner_knots() {
        let knots = [0.0, 0.5, 2.0, 2.25, 4.0];
        let parabola = |x: f64| 3.0 * x * x - x + 2.0;
        let spline = Spline::new(&knots, knots.iter().map(|&x| [parabola(x)]).collect());
        for x in [0.5, 0.7, 1.3, 2.0, 2.1, 2.25] {
            assert!((spline.at(x)[0] - parabola(x)).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn before_the_first_knot_and_after_the_last_it_stands() {
        let spline = Spline::new(&[1.0, 2.0], vec![[5.0, 0.0], [7.0, 1.0]]);
        assert_eq!((spline.at(0.0), spline.at(9.0)), ([5.0, 0.0], [7.0, 1.0]));
        assert_eq!(Spline::new(&[1.0], vec![[5.0]]).at(3.0), [5.0]);
    }
}
