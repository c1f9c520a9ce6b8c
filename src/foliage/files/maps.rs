//! What is asked of every affine map of a plant's file.

use glam::DAffine3;

use super::tokens::LARGEST_NUMBER;

/// Returns true for maps that flatten what they move.
pub fn is_singular(map: &DAffine3) -> bool {
    map.matrix3.determinant() == 0.0 || !map.matrix3.inverse().is_finite()
}

/// Returns true where all numbers are finite and at most [`LARGEST_NUMBER`].
pub fn is_within_numbers(map: &DAffine3) -> bool {
    map.to_cols_array().iter().all(|number| number.abs() <= LARGEST_NUMBER)
}
