//! Conversion of quaternions and matrices to poses.

use glam::{DMat3, DQuat, DVec3};

use quadratura_base::geometry::Pose;
use quadratura_files::text::Objection;

/// The largest difference of the entries of `M^T M` of a rotation from those of the identity: a rotation written with
/// three decimals is within it, a visible shear or stretch is not.
const ROUNDED: f64 = 4e-3;

/// Converts camera axes with y up that look along -z (OpenGL's) to those with y down that look along z, and back.
pub(super) const CV_FROM_GL: DMat3 = DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));

/// Returns the pose, world to camera, of a quaternion (w, x, y, z) and a translation.
pub(super) fn pose_of_quaternion(quaternion: [f64; 4], translation: [f64; 3]) -> Result<Pose, Objection> {
    let [w, x, y, z] = quaternion;
    let length = (w * w + x * x + y * y + z * z).sqrt();
    // Also false for a length that is not a number.
    if !(length > 1e-6 && length < 1e6) {
        let found = format!("the rotation {quaternion:?} is not a valid quaternion");
        return Err((found, "write QW QX QY QZ of length 1"));
    }
    if !is_on_a_map(translation) {
        let found = format!("the position {translation:?} is not within 1e15 of the origin");
        return Err((found, "write TX TY TZ as numbers in the model's unit"));
    }
    let rotation = DMat3::from_quat(DQuat::from_xyzw(x, y, z, w).normalize());
    Ok(Pose { rotation, translation: translation.into() })
}

/// Splits a matrix into a rotation and a uniform scale.
///
/// # Errors
/// Returns an error when the matrix mirrors, shears, stretches or is singular; `what` names it in the message.
pub(super) fn rotation_and_scale(matrix: DMat3, what: &str) -> Result<(DMat3, f64), Objection> {
    let scale = matrix.determinant().abs().cbrt();
    // Also false for what is not a number.
    if !(scale > 1e-9 && scale < 1e9) {
        let found = format!("{what} is no rotation: its determinant is {}", matrix.determinant());
        return Err((found, "export the cameras again"));
    }
    if matrix.determinant() < 0.0 {
        let found = format!("{what} mirrors: its determinant is {}", matrix.determinant());
        return Err((found, "export the cameras again, in right-handed axes"));
    }
    let even = matrix * (1.0 / scale);
    let differences = (even.transpose() * even - DMat3::IDENTITY).to_cols_array();
    let largest = differences.iter().fold(0.0f64, |largest, difference| largest.max(difference.abs()));
    if largest.is_nan() || largest > ROUNDED {
        let found = format!("{what} shears or stretches by {largest:.3}, where a rotation is expected");
        return Err((found, "export the cameras again"));
    }
    Ok((DMat3::from_quat(DQuat::from_mat3(&even).normalize()), scale))
}

/// Returns the pose of a rotation, world to camera, and the camera's centre in the world.
///
/// # Errors
/// Returns an error when `rotation` is none, or `centre` is beyond any map.
pub(super) fn pose_at(rotation: DMat3, centre: DVec3) -> Result<Pose, Objection> {
    let (rotation, _) = rotation_and_scale(rotation, "the rotation")?;
    if !is_on_a_map(centre.into()) {
        let found = format!("the position {:?} is not within 1e15 of the origin", centre.to_array());
        return Err((found, "export the cameras again, in the model's unit"));
    }
    Ok(Pose { rotation, translation: -(rotation * centre) })
}

/// Returns the matrix with these rows.
pub(super) fn of_rows(rows: &[f64; 9]) -> DMat3 {
    DMat3::from_cols_array(rows).transpose()
}

/// Returns true for a position within 1e15 of the origin. Beyond that, positions lose whole units, and their products
/// the range of numbers. The same limit applies to models.
pub(super) fn is_on_a_map(position: [f64; 3]) -> bool {
    position.iter().all(|v| v.abs() <= 1e15)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_is_kept_and_its_scale_told() {
        let turn = DMat3::from_quat(DQuat::from_xyzw(0.5, -0.1, 0.3, 0.8).normalize());
        let (rotation, scale) = rotation_and_scale(turn * 2.5, "it").unwrap();
        assert!((scale - 2.5).abs() < 1e-14);
        // Products of a few numbers of size 1.
        assert!((rotation - turn).to_cols_array().iter().all(|v| v.abs() < 1e-15));
        let rounded = DMat3::from_cols_array(&turn.to_cols_array().map(|v| (v * 1e3).round() / 1e3));
        let (rotation, _) = rotation_and_scale(rounded, "it").unwrap();
        assert!((rotation.determinant() - 1.0).abs() < 1e-14);
    }

    #[test]
    fn what_is_no_rotation_is_refused_with_what_it_is() {
        let refused =
            |columns: [f64; 9]| rotation_and_scale(DMat3::from_cols_array(&columns), "it").unwrap_err().0;
        assert!(refused([1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0]).contains("mirrors"));
        assert!(refused([1.0, 0.0, 0.0, 0.0, 1.01, 0.0, 0.0, 0.0, 1.0]).contains("stretches by 0.013"));
        assert!(refused([1.0, 0.0, 0.0, 0.02, 1.0, 0.0, 0.0, 0.0, 1.0]).contains("shears"));
        for number in [0.0, f64::NAN, f64::INFINITY, 1e300] {
            assert!(refused([number; 9]).contains("is no rotation"), "{number}");
        }
    }
}
