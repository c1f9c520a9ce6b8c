//! What is wrong in a layered depth image, before it is known which file it is in.

use std::path::Path;

use quadratura_base::error::Error;

/// The result of a check.
pub(super) type CheckResult<T = ()> = Result<T, FileDefect>;

/// What is wrong, and where.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FileDefect {
    /// The place in the file; empty for the whole file.
    pub place: String,
    /// What was found, and what was expected.
    pub found: String,
}

impl FileDefect {
    /// Makes a defect at a place.
    pub fn at(place: impl Into<String>, found: impl Into<String>) -> Self {
        Self { place: place.into(), found: found.into() }
    }

    /// Makes a defect of the first line.
    pub fn of_line(found: impl Into<String>) -> Self {
        Self::at("first line", found)
    }

    /// Returns the error for a file that was read.
    pub fn into_input(self, file: &Path, remedy: &str) -> Error {
        Error::input(file, self.place, self.found, remedy)
    }

    /// Returns the error for a layered depth image that cannot be written.
    pub fn into_request(self, file: &Path) -> Error {
        let place = if self.place.is_empty() { self.place } else { format!(", {}", self.place) };
        Error::Request(format!("{}{place}: it was not written: {}", file.display(), self.found))
    }
}

/// Returns a defect unless a condition holds.
pub(super) fn ensure(holds: bool, defect: impl FnOnce() -> FileDefect) -> CheckResult {
    if holds { Ok(()) } else { Err(defect()) }
}
