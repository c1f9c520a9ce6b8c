//! Errors say whose fault it was, and what to do about it.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The result of everything in this crate that can fail.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What can go wrong, by whose fault.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// What the user gave cannot be used.
    #[error("{}{}: {found}; {remedy}", file.display(), at(place))]
    Input {
        /// The file that was read.
        file: PathBuf,
        /// Where in it: `line 12`, `face 7 of "roof"`, `byte 1024`; empty for the whole file.
        place: String,
        /// What was found, against what was expected.
        found: String,
        /// What to do.
        remedy: String,
    },
    /// The operating system refused.
    #[error("{}: could not {doing}: {source}{}", path.display(), remedy(source))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// A verb phrase: `read it`, `create the folder`.
        doing: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// The GPU, its driver, or our use of it.
    #[error("GPU: {0}")]
    Gpu(String),
    /// The request contradicts itself or the project.
    #[error("{0}")]
    Request(String),
    /// Several things are wrong that do not depend on each other; one line each.
    #[error("{}", lines(.0))]
    Several(Vec<Error>),
    /// Somebody asked to stop.
    #[error("stopped on request")]
    Cancelled,
}

impl Error {
    /// An [`Error::Input`]: file, place (may be empty), finding, remedy.
    pub fn input(
        file: impl Into<PathBuf>,
        place: impl Into<String>,
        found: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::Input { file: file.into(), place: place.into(), found: found.into(), remedy: remedy.into() }
    }

    /// One error of those that happened side by side; `None` when none did. Being stopped outweighs
    /// the rest.
    pub fn of_all(errors: Vec<Self>) -> Option<Self> {
        if errors.iter().any(|error| matches!(error, Self::Cancelled)) {
            return Some(Self::Cancelled);
        }
        let mut errors = errors;
        if errors.len() > 1 { Some(Self::Several(errors)) } else { errors.pop() }
    }

    /// For `map_err`: wraps what the system said about `path` while `doing` something.
    pub fn io(path: impl AsRef<Path>, doing: &'static str) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.as_ref().to_path_buf();
        move |source| Self::Io { path, doing, source }
    }
}

/// What helps against what the system says most often.
fn remedy(source: &std::io::Error) -> &'static str {
    match source.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "; free some space on that disk, then do it again"
        }
        ErrorKind::ReadOnlyFilesystem => "; nothing can be written on that disk: use a copy in another place",
        ErrorKind::PermissionDenied => "; give yourself the right to do that, or use a copy in another place",
        _ => "",
    }
}

fn lines(errors: &[Error]) -> String {
    errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

fn at(place: &str) -> String {
    if place.is_empty() { String::new() } else { format!(", {place}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disk_that_is_full_or_may_not_be_written_to_is_told_with_what_helps() {
        let told = |kind: ErrorKind| Error::io("a.png", "write it")(kind.into()).to_string();
        assert!(told(ErrorKind::StorageFull).ends_with("free some space on that disk, then do it again"));
        assert!(told(ErrorKind::ReadOnlyFilesystem).ends_with("use a copy in another place"));
        assert!(told(ErrorKind::PermissionDenied).contains("give yourself the right"));
        assert_eq!(told(ErrorKind::NotFound), "a.png: could not write it: entity not found");
    }
}
