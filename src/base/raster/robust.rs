//! Robust statistics: medians and quantiles, which a few wild values do not move. Each says what it does between two
//! values, because results are compared byte by byte.

use std::cmp::Ordering;

/// The standard deviation of normal errors over their median absolute deviation: 1 over the normal distribution's third
/// quartile.
pub const SIGMA_PER_MAD: f64 = 1.4826;

/// A floating-point number: `f32` or `f64`.
pub trait Real: Copy {
    /// Compares by value, as `total_cmp` does.
    fn order(&self, other: &Self) -> Ordering;

    /// Returns half of the sum.
    fn mean(self, other: Self) -> Self;
}

impl Real for f32 {
    #[inline]
    fn order(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }

    #[inline]
    fn mean(self, other: Self) -> Self {
        (self + other) / 2.0
    }
}

impl Real for f64 {
    #[inline]
    fn order(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }

    #[inline]
    fn mean(self, other: Self) -> Self {
        (self + other) / 2.0
    }
}

/// Returns the value with `rank` others before it in rising order; `None` when there are not as many. The order of
/// `values` changes.
#[inline]
pub fn of_rank<T: Real>(values: &mut [T], rank: usize) -> Option<T> {
    (rank < values.len()).then(|| *values.select_nth_unstable_by(rank, T::order).1)
}

/// Returns the median; for an even number of values, the larger of the two in the middle. `None` without values. The
/// order of `values` changes.
#[inline]
pub fn upper_median<T: Real>(values: &mut [T]) -> Option<T> {
    of_rank(values, values.len() / 2)
}

/// Returns the median; for an even number of values, the mean of the two in the middle. `None` without values. Sorts
/// `values`.
#[inline]
pub fn median<T: Real>(values: &mut [T]) -> Option<T> {
    values.sort_unstable_by(T::order);
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        count if count % 2 == 1 => Some(values[middle]),
        _ => Some(values[middle - 1].mean(values[middle])),
    }
}

/// Returns the quantile at `share`, 0 to 1: the value of the nearest rank, half-way the larger one. `None` without
/// values. The order of `values` changes.
pub fn quantile<T: Real>(values: &mut [T], share: f64) -> Option<T> {
    let last = values.len().saturating_sub(1);
    of_rank(values, (last as f64 * share).round() as usize)
}

/// Estimates the standard deviation of errors around 0 by their median absolute deviation (an upper median), which is
/// right for normal errors and hardly moved by others. `None` without errors. Their order changes, and they lose their
/// sign.
#[inline]
pub fn sigma(errors: &mut [f64]) -> Option<f64> {
    errors.iter_mut().for_each(|error| *error = error.abs());
    Some(SIGMA_PER_MAD * upper_median(errors)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_medians_differ_where_the_number_is_even() {
        assert_eq!(
            (median(&mut [9.0, 1.0, 4.0, 2.0]), upper_median(&mut [9.0, 1.0, 4.0, 2.0])),
            (Some(3.0), Some(4.0))
        );
        let odd = [7.0_f32, -1.0, 5.0];
        assert_eq!((median(&mut odd.clone()), upper_median(&mut odd.clone())), (Some(5.0), Some(5.0)));
        assert_eq!((median::<f64>(&mut []), upper_median::<f32>(&mut [])), (None, None));
    }

    #[test]
    fn a_quantile_is_one_of_the_values() {
        let values: Vec<f64> = (0..=10).rev().map(f64::from).collect();
        let at = |share| quantile(&mut values.clone(), share);
        assert_eq!([at(0.0), at(0.25), at(0.75), at(1.0)], [Some(0.0), Some(3.0), Some(8.0), Some(10.0)]);
        assert_eq!((quantile(&mut [4.0_f32], 0.9), quantile::<f64>(&mut [], 0.5)), (Some(4.0), None));
        assert_eq!((of_rank(&mut [3.0, 1.0, 2.0], 1), of_rank(&mut [3.0], 1)), (Some(2.0), None));
    }

    #[test]
    fn one_wild_error_in_nine_does_not_move_sigma() {
        let mut errors: Vec<f64> = (1..=8).map(|i| if i % 2 == 0 { 0.1 } else { -0.1 }).collect();
        errors.push(1e9);
        assert_eq!(sigma(&mut errors), Some(0.14826));
    }
}
