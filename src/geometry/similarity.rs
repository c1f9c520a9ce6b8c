//! Scale, rotation, translation: how the model reaches the cameras' world.

use glam::{DMat3, DVec3};

/// `p -> scale * rotation * p + translation`. In files: the four rows of a 4 x 4 matrix that takes
/// columns (x, y, z, 1).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "[[f64; 4]; 4]", into = "[[f64; 4]; 4]")]
pub struct Similarity {
    /// Positive.
    pub scale: f64,
    /// Orthonormal with determinant 1.
    pub rotation: DMat3,
    /// In the target's unit.
    pub translation: DVec3,
}

impl Similarity {
    /// Leaves every point where it is.
    pub const IDENTITY: Self = Self { scale: 1.0, rotation: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// Applies it to a point.
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.rotation * (point * self.scale) + self.translation
    }
}

impl Similarity {
    /// Reads the 16 numbers of a 4 x 4 matrix, or the 12 of its upper rows, row by row, separated by
    /// commas or spaces.
    ///
    /// # Errors
    /// What is wrong with them, and what was expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let words = text.split([',', ' ']).filter(|word| !word.is_empty());
        let number = |word: &str| word.parse::<f64>().map_err(|_| format!("`{word}` is not a number"));
        let numbers = words.map(number).collect::<Result<Vec<_>, _>>()?;
        if !matches!(numbers.len(), 12 | 16) {
            return Err(format!("{} numbers, expected the 16 of a 4 x 4 matrix", numbers.len()));
        }
        let mut rows = [[0.0, 0.0, 0.0, 1.0]; 4];
        rows.as_flattened_mut()[..numbers.len()].copy_from_slice(&numbers);
        Self::try_from(rows)
    }
}

/// The rows of the 4 x 4 matrix.
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

    /// Splits a matrix into scale, rotation and translation, or says why it is no similarity.
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
        Ok(Self { scale, rotation, translation })
    }
}

/// What a matrix typed with six digits may be off a rotation.
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
    fn a_matrix_may_be_typed_with_or_without_its_last_row() {
        let moved = Similarity { translation: DVec3::new(4.0, 5.0, 6.0), ..Similarity::IDENTITY };
        assert_eq!(Similarity::parse("1,0,0,4, 0,1,0,5, 0,0,1,6").unwrap(), moved);
        assert_eq!(Similarity::parse("1 0 0 4 0 1 0 5 0 0 1 6 0 0 0 1").unwrap(), moved);
        assert!(Similarity::parse("1 2 3").unwrap_err().contains("3 numbers"));
        assert!(Similarity::parse("up").unwrap_err().contains("`up`"));
    }
}
