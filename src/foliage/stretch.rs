//! How much a linear map stretches what is mapped.

use glam::{DMat3, DVec3};

/// Returns the factor by which a linear map stretches at most: its largest singular value, the root of the largest
/// eigenvalue of `map^T map`, in closed form (Smith, *Eigenvalues of a symmetric 3 x 3 matrix*, 1961).
pub fn largest_stretch(map: &DMat3) -> f64 {
    // A common factor keeps squares of large and small numbers within range.
    let scale = map.to_cols_array().iter().fold(0.0f64, |most, value| most.max(value.abs()));
    if scale == 0.0 {
        return 0.0;
    }
    let map = *map * scale.recip();
    let square = map.transpose() * map;
    let mean = (square.x_axis.x + square.y_axis.y + square.z_axis.z) / 3.0;
    let rest = square - DMat3::from_diagonal(DVec3::splat(mean));
    let spread = (rest.to_cols_array().iter().map(|value| value * value).sum::<f64>() / 6.0).sqrt();
    if spread <= f64::EPSILON * mean {
        return scale * mean.sqrt();
    }
    let half = (0.5 * (rest * spread.recip()).determinant()).clamp(-1.0, 1.0);
    scale * (mean + 2.0 * spread * (half.acos() / 3.0).cos()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    #[test]
    fn no_direction_is_stretched_more_than_the_largest_stretch_and_one_nearly_as_much() {
        let mut rng = Rng::new(4);
        for case in 0..200 {
            let scale = 10f64.powi(case % 13 - 6);
            let map = DMat3::from_cols_array(&std::array::from_fn(|_| scale * rng.between(-1.0, 1.0)));
            let most = largest_stretch(&map);
            let mut seen = 0.0f64;
            let mut direction = DVec3::new(rng.unit() + 0.1, rng.unit(), rng.unit()).normalize();
            for _ in 0..2000 {
                seen = seen.max((map * direction).length());
                // Power iteration towards the direction that is stretched most.
                direction = (map.transpose() * (map * direction)).normalize();
            }
            // The closed form loses half of the digits where two singular values are nearly equal.
            assert!(
                seen <= most * (1.0 + 1e-7) && seen >= most * (1.0 - 1e-4),
                "case {case}: {seen}, {most}"
            );
        }
    }

    #[test]
    fn a_rotation_stretches_nothing_and_zero_everything_to_nothing() {
        let turn = DMat3::from_rotation_x(0.3) * DMat3::from_rotation_z(1.2);
        assert!((largest_stretch(&turn) - 1.0).abs() < 1e-7);
        assert_eq!(largest_stretch(&DMat3::ZERO), 0.0);
        assert_eq!(largest_stretch(&DMat3::from_diagonal(DVec3::new(-3.0, 1.0, 0.5))), 3.0);
    }
}
