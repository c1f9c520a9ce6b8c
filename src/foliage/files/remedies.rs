//! What is wrong in a plant's file, with what to do about it.

use crate::PlantFlaw;

/// The remedy where nothing more can be said than where it is.
pub const CORRECT: &str = "correct it; docs/formats.md describes plants";
/// The remedy for a text that ends too early.
pub const COMPLETE: &str = "complete the file, or copy it again: it may be cut short";
/// The remedy for a word that is no number, or none that is possible.
pub const NUMBER: &str = "write such a number there";
/// The remedy for a file that is named and not there.
pub const FILE: &str = "put the file into the plant's folder, or correct its name";
/// The remedy for a plant that is too large.
pub const COARSER: &str = "make the plant coarser, or give it fewer parts";
/// The remedy for coordinates that are too large.
pub const SMALLER: &str = "make the numbers of its points and transforms smaller";

/// A finding with its remedy.
#[derive(Debug)]
pub struct Wrong {
    pub found: String,
    pub remedy: &'static str,
}

impl From<String> for Wrong {
    fn from(found: String) -> Self {
        Self { found, remedy: CORRECT }
    }
}

impl From<&str> for Wrong {
    fn from(found: &str) -> Self {
        found.to_owned().into()
    }
}

impl<Found: Into<String>> From<(Found, &'static str)> for Wrong {
    fn from((found, remedy): (Found, &'static str)) -> Self {
        Self { found: found.into(), remedy }
    }
}

impl From<&PlantFlaw> for Wrong {
    fn from(flaw: &PlantFlaw) -> Self {
        let remedy = match flaw {
            PlantFlaw::Cycle(_) => "remove one of these uses: no part may be a part of itself",
            PlantFlaw::Levels(_) => "put parts of parts together, so that there are fewer levels",
            PlantFlaw::Uses(_) | PlantFlaw::Corners(_) => COARSER,
            PlantFlaw::Endless(_) => SMALLER,
        };
        Self { found: flaw.to_string(), remedy }
    }
}
