//! Notes about what is left out of a plant.

use std::collections::BTreeMap;

/// What is left out, each kind with the first place and the number of places.
#[derive(Debug, Default)]
pub struct Notes(BTreeMap<&'static str, (String, usize)>);

impl Notes {
    /// Notes something at a place of the file.
    pub fn add(&mut self, what: &'static str, place: impl FnOnce() -> String) {
        self.0.entry(what).or_insert_with(|| (place(), 0)).1 += 1;
    }

    /// Returns one text for each kind.
    pub fn texts(&self) -> Vec<String> {
        let text = |(what, (place, count)): (&&str, &(String, usize))| match count - 1 {
            0 => format!("{place}: {what}"),
            others => format!("{place}: {what} (and {others} more)"),
        };
        self.0.iter().map(text).collect()
    }
}
