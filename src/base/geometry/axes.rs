//! Axis conventions: the 24 rotations that map axes to axes, and their names.

use glam::{DMat3, DVec3};

/// Returns all 24 rotations that map axes to axes, with their names. The name `x,-z,y` lists, for the world's x, y
/// and z, the signed model axis that each is taken from. The identity, `x,y,z`, comes first.
pub fn conventions() -> Vec<(String, DMat3)> {
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let mut conventions = Vec::with_capacity(24);
    for order in ORDERS {
        for signs in 0..8u8 {
            let sign = |row: usize| if signs >> row & 1 == 1 { -1.0 } else { 1.0 };
            let row = |row: usize| DVec3::AXES[order[row]] * sign(row);
            let rotation = DMat3::from_cols(row(0), row(1), row(2)).transpose();
            // A negative determinant would be a reflection.
            if rotation.determinant() > 0.0 {
                conventions.push((name(&order, sign), rotation + DMat3::ZERO));
            }
        }
    }
    conventions
}

/// Writes the name of a signed permutation: `order[row]` is the model axis of world axis `row`.
fn name(order: &[usize; 3], sign: impl Fn(usize) -> f64) -> String {
    let axis =
        |row: usize| format!("{}{}", if sign(row) < 0.0 { "-" } else { "" }, ["x", "y", "z"][order[row]]);
    [axis(0), axis(1), axis(2)].join(",")
}

/// Returns the rotation that a name stands for, or `None` for an unknown name. Upper and lower case are equal.
/// Names are those of [`conventions`] and these:
///
/// | name | meaning | same as |
/// |---|---|---|
/// | `identity`, `z-up` | the model has the world's axes | `x,y,z` |
/// | `y-up` | y is up in the model (glTF's rule), z in the world | `x,-z,y` |
///  `z-down` | z is up in one of the two frames and down in the other | `x,-y,-z` |
pub fn named(name: &str) -> Option<DMat3> {
    let name = name.trim().to_lowercase().replace(' ', "");
    let systematic = match name.as_str() {
        "identity" | "z-up" => "x,y,z",
        "y-up" => "x,-z,y",
        "z-down" => "x,-y,-z",
        other => other,
    };
    conventions().into_iter().find(|(name, _)| name == systematic).map(|(_, rotation)| rotation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_24_different_rotations_and_each_is_found_by_its_name() {
        let all = conventions();
        assert_eq!(all.len(), 24);
        assert_eq!(all[0], ("x,y,z".to_owned(), DMat3::IDENTITY));
        for (i, (name, rotation)) in all.iter().enumerate() {
            assert_eq!((rotation.determinant(), named(name)), (1.0, Some(*rotation)));
            assert!(all[..i].iter().all(|(_, other)| other != rotation));
        }
    }

    #[test]
    fn a_name_says_where_the_worlds_axes_come_from() {
        let model_point = DVec3::new(1.0, 2.0, 3.0);
        assert_eq!(named("x, -Z, y").unwrap() * model_point, DVec3::new(1.0, -3.0, 2.0));
        assert_eq!(named("y-up").unwrap() * DVec3::Y, DVec3::Z);
        assert_eq!(named("z-down").unwrap() * DVec3::Z, DVec3::NEG_Z);
        assert_eq!(named("w-up"), None);
    }
}
