//! Names, numbers and strings of the text format.

use std::collections::BTreeSet;
use std::fmt::Display;

use glam::DVec3;

/// Names of primitives below one parent: letters, digits and underscores, not beginning with a digit, each once.
#[derive(Default)]
pub(super) struct PrimitiveNames {
    used: BTreeSet<String>,
}

impl PrimitiveNames {
    /// Returns the name for something, unlike all before.
    pub fn name(&mut self, wanted: &str) -> String {
        let allowed = |letter: char| if letter.is_ascii_alphanumeric() { letter } else { '_' };
        let mut name: String = wanted.chars().map(allowed).collect();
        if name.starts_with(|first: char| first.is_ascii_digit()) || name.is_empty() {
            name.insert(0, '_');
        }
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        let mut free = std::iter::once(name.clone()).chain(numbered);
        let found = free.find(|name| !self.used.contains(name)).expect("there are more numbers than names");
        self.used.insert(found.clone());
        found
    }
}

/// Returns a string literal.
pub(super) fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => quoted.extend(['\\', letter]),
            '\n' => quoted.push_str("\\n"),
            '\r' => quoted.push_str("\\r"),
            letter if letter.is_control() => quoted.push(' '),
            letter => quoted.push(letter),
        }
    }
    quoted.push('"');
    quoted
}

/// Returns an array of values.
pub(super) fn array<T: Display>(values: impl IntoIterator<Item = T>) -> String {
    let values: Vec<String> = values.into_iter().map(|value| value.to_string()).collect();
    format!("[{}]", values.join(", "))
}

/// Returns a tuple of numbers in single precision.
pub(super) fn tuple<const N: usize>(values: [f64; N]) -> String {
    // Adding zero turns -0 into 0.
    format!("({})", values.map(|value| (value as f32 + 0.0).to_string()).join(", "))
}

/// Returns a matrix for rows of points, by where it takes the axes and the origin.
pub(super) fn matrix(rows: &[DVec3; 4]) -> String {
    let row = |(row, last): (&DVec3, u8)| {
        let [x, y, z] = row.to_array().map(|value| value + 0.0);
        format!("({x}, {y}, {z}, {last})")
    };
    let rows: Vec<String> = rows.iter().zip([0, 0, 0, 1]).map(row).collect();
    format!("( {} )", rows.join(", "))
}
