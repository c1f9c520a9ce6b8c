//! Similarity transforms: scale, rotation and translation from the model to the cameras' world.

use std::fmt;

use glam::{DMat3, DQuat, DVec3};

use super::{Pose, axes};

/// The transform `p -> scale * rotation * p + translation`. In files it is the four rows of a 4 x 4 matrix that
/// applies to columns (x, y, z, 1).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "[[f64; 4]; 4]", into = "[[f64; 4]; 4]")]
pub struct Similarity {
    /// The scale factor, positive.
    pub scale: f64,
    /// The rotation, orthonormal with determinant 1.
    pub rotation: DMat3,
    /// The translation, in the target's unit.
    pub translation: DVec3,
}

impl Similarity {
    /// The identity transform.
    pub const IDENTITY: Self = Self { scale: 1.0, rotation: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// Transforms a point.
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.rotation * (point * self.scale) + self.translation
    }

    /// Returns the transform that applies `inner` first, then this one.
    pub fn compose(&self, inner: &Self) -> Self {
        Self {
            scale: self.scale * inner.scale,
            rotation: self.rotation * inner.rotation,
            translation: self.apply(inner.translation),
        }
    }

    /// Returns the inverse transform.
    pub fn inverse(&self) -> Self {
        let (scale, rotation) = (self.scale.recip(), self.rotation.transpose());
        Self { scale, rotation, translation: rotation * (self.translation * -scale) }
    }

    /// Returns the pose of a camera after the transform of its world: it sees what `pose` sees, in the target's unit.
    pub fn pose_after(&self, pose: &Pose) -> Pose {
        let rotation = pose.rotation * self.rotation.transpose();
        Pose { rotation, translation: pose.translation * self.scale - rotation * self.translation }
    }

    /// Returns the pose that [`Self::pose_after`] takes to this one.
    pub fn pose_before(&self, pose: &Pose) -> Pose {
        self.inverse().pose_after(pose)
    }

    /// Parses a name (see [`axes::named`]), or a matrix row by row as 16 or 12 numbers separated by spaces or
    /// commas.
    ///
    /// # Errors
    /// Returns a sentence that says what is wrong, without repeating the text itself.
    pub fn parse(text: &str) -> Result<Self, String> {
        if let Some(rotation) = axes::named(text) {
            return Ok(Self { rotation, ..Self::IDENTITY });
        }
        let words = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty());
        let number = |word: &str| word.parse::<f64>().map_err(|_| no_number(word));
        let numbers = words.map(number).collect::<Result<Vec<_>, _>>()?;
        if !matches!(numbers.len(), 12 | 16) {
            return Err(format!("{} numbers, expected the 16 of a 4 x 4 matrix", numbers.len()));
        }
        let mut rows = [[0.0, 0.0, 0.0, 1.0]; 4];
        rows.as_flattened_mut()[..numbers.len()].copy_from_slice(&numbers);
        Self::try_from(rows)
    }
}

fn no_number(word: &str) -> String {
    format!("`{word}` is not a number, nor a name such as identity, y-up, z-down or x,-z,y")
}

/// Writes what [`Similarity::parse`] reads back exactly: a name where there is one, else 12 numbers.
impl fmt::Display for Similarity {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if (self.scale, self.translation) == (1.0, DVec3::ZERO)
            && let Some((name, _)) = axes::conventions().into_iter().find(|(_, r)| *r == self.rotation)
        {
            return f.write_str(&name);
        }
        let rows: [[f64; 4]; 4] = (*self).into();
        let numbers: Vec<String> = rows[..3].as_flattened().iter().map(|x| (x + 0.0).to_string()).collect();
        f.write_str(&numbers.join(","))
    }
}

/// Converts to the rows of the 4 x 4 matrix.
impl From<Similarity> for [[f64; 4]; 4] {
    fn from(similarity: Similarity) -> Self {
        let columns = similarity.rotation * similarity.scale;
        let row = |i: usize| {
            let [x, y, z] = columns.row(i).to_array();
            [x, y, z, similarity.translation[i]]
        };
        [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
    }
}

impl TryFrom<[[f64; 4]; 4]> for Similarity {
    type Error = String;

    /// Splits a matrix into scale, rotation and translation; the error says why it is no similarity.
    fn try_from(rows: [[f64; 4]; 4]) -> Result<Self, String> {
        if rows.as_flattened().iter().any(|number| !number.is_finite()) {
            return Err("the transform has a number that is not finite".into());
        }
        if rows[3] != [0.0, 0.0, 0.0, 1.0] {
            return Err(format!("the transform's last row is {:?}, expected 0 0 0 1", rows[3]));
        }
        let row = |i: usize| DVec3::from_slice(&rows[i][..3]);
        let linear = DMat3::from_cols(row(0), row(1), row(2)).transpose();
        let determinant = linear.determinant();
        if determinant <= 0.0 {
            return Err(format!("the transform mirrors or flattens (determinant {determinant})"));
        }
        let scale = determinant.cbrt();
        let rotation = linear * scale.recip();
        if !(rotation * rotation.transpose()).abs_diff_eq(DMat3::IDENTITY, ROUNDING) {
            return Err("the transform shears, or scales one axis more than another".into());
        }
        let translation = DVec3::new(rows[0][3], rows[1][3], rows[2][3]);
        Ok(Self { scale, rotation: straightened(rotation), translation })
    }
}

/// Returns the rotation nearest to a matrix that was typed with few digits; exact rotations stay as they are.
fn straightened(rotation: DMat3) -> DMat3 {
    if (rotation * rotation.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-14) {
        return rotation;
    }
    DMat3::from_quat(DQuat::from_mat3(&rotation).normalize())
}

/// The largest deviation from a rotation that is accepted, for matrices typed with six digits.
const ROUNDING: f64 = 1e-5;

impl Default for Similarity {
    fn default() -> Self {
        Self::IDENTITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_sees_a_point_of_the_target_where_it_saw_it_before() {
        let by = Similarity {
            scale: 0.37,
            rotation: DMat3::from_rotation_x(0.8),
            translation: DVec3::new(4.0, -1.0, 2.5),
        };
        let pose = Pose { rotation: DMat3::from_rotation_y(0.4), translation: DVec3::new(1.0, 2.0, -3.0) };
        let (point, after) = (DVec3::new(0.3, -2.0, 7.0), by.pose_after(&pose));
        let off = after.camera_from_world(by.apply(point)) - pose.camera_from_world(point) * by.scale;
        assert!(off.length() < 1e-12, "{off}");
        let back = by.pose_before(&after);
        assert!(back.rotation.abs_diff_eq(pose.rotation, 1e-12));
        assert!(back.translation.abs_diff_eq(pose.translation, 1e-12));
    }

    #[test]
    fn a_similarity_comes_back_from_its_rows() {
        let similarity = Similarity {
            scale: 2.5,
            rotation: DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0),
            translation: DVec3::new(1.0, -2.0, 5e6),
        };
        let rows: [[f64; 4]; 4] = similarity.into();
        let back = Similarity::try_from(rows).unwrap();
        let point = DVec3::new(3.0, 1.0, -7.0);
        assert!((back.apply(point) - similarity.apply(point)).length() < 1e-8);
        assert_eq!(
            Similarity::try_from(<[[f64; 4]; 4]>::from(Similarity::IDENTITY)).unwrap(),
            Similarity::IDENTITY
        );
    }

    #[test]
    fn mirrored_sheared_flat_and_infinite_matrices_are_refused_by_what_they_do() {
        let refusal = |row: [f64; 4]| {
            let rows = [row, [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
            Similarity::try_from(rows).unwrap_err()
        };
        assert!(refusal([-1.0, 0.0, 0.0, 0.0]).contains("mirrors"));
        assert!(refusal([0.0, 0.0, 0.0, 0.0]).contains("flattens"));
        assert!(refusal([1.0, 0.5, 0.0, 0.0]).contains("shears"));
        assert!(refusal([2.0, 0.0, 0.0, 0.0]).contains("scales one axis"));
        assert!(refusal([1.0, 0.0, 0.0, f64::NAN]).contains("not finite"));
    }

    #[test]
    fn names_and_matrices_are_read_and_written() {
        let moved = Similarity { translation: DVec3::new(4.0, 8.0, -12.5), ..Similarity::IDENTITY };
        assert_eq!(Similarity::parse("1 0 0 4, 0 1 0 8, 0 0 1 -12.5").unwrap(), moved);
        assert_eq!(Similarity::parse("1,0,0,4,0,1,0,8,0,0,1,-12.5,0,0,0,1").unwrap(), moved);
        assert_eq!(moved.to_string(), "1,0,0,4,0,1,0,8,0,0,1,-12.5");
        assert_eq!(Similarity::parse("identity").unwrap(), Similarity::IDENTITY);
        assert_eq!(Similarity::parse("Y-up").unwrap().to_string(), "x,-z,y");
    }

    #[test]
    fn what_cannot_be_read_is_said() {
        let refusal = |text: &str| Similarity::parse(text).unwrap_err();
        assert!(refusal("1 2 3").contains("3 numbers, expected the 16"));
        assert!(refusal("y-upp").contains("`y-upp` is not a number, nor a name"));
        assert!(refusal("x,y,-z").contains("`x` is not a number"), "mirrored: no convention");
        assert!(refusal("1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1").contains("last row"));
    }

    #[test]
    fn forth_and_back_is_identity_and_composing_is_one_after_the_other() {
        let rotation = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0);
        let a = Similarity { scale: 2.5, rotation, translation: DVec3::new(1.0, -2.0, 3.0) };
        let b = Similarity::parse("0,-2,0,1, 2,0,0,5, 0,0,2,-7").unwrap();
        let point = DVec3::new(3.0, 1.0, -7.0);
        assert!((a.compose(&b).apply(point) - a.apply(b.apply(point))).length() < 1e-12);
        assert!((a.inverse().apply(a.apply(point)) - point).length() < 1e-12);
        let typed = Similarity::parse(&a.to_string()).unwrap();
        assert!((typed.apply(point) - a.apply(point)).length() < 1e-12);
        let rounded = Similarity::parse("0.70711,-0.70711,0,0, 0.70711,0.70711,0,0, 0,0,1,0").unwrap();
        assert!((rounded.rotation * rounded.rotation.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-15));
    }
}
