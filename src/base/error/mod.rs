//! Errors by cause, with remedies.

mod message;

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

pub use message::{Message, Remedy};

/// The result of all fallible functions of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// An error, classified by its cause.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The user's input cannot be used.
    #[error("{}{}: {found}; {remedy}", file.display(), at(place))]
    Input {
        /// The file that was read.
        file: PathBuf,
        /// The position in it: `line 12`, `face 7 of "roof"`, `byte 1024`; empty for the whole file.
        place: String,
        /// The finding: what was found, and what was expected.
        found: String,
        /// The remedy: what the user can do.
        remedy: Message,
    },
    /// The operating system reported an error.
    #[error("{}: could not {doing}: {}{}", path.display(), reason(source), remedy(source))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The attempted operation as a verb phrase: `read it`, `create the folder`.
        doing: &'static str,
        /// The system's error.
        source: std::io::Error,
    },
    /// The GPU, its driver or this program's use of it failed.
    #[error("GPU: {0}")]
    Gpu(String),
    /// The request contradicts itself or the project.
    #[error("{0}")]
    Request(String),
    /// The arguments of a command exclude or need each other, whatever the project: they are wrong as they were typed.
    #[error("{0}")]
    Usage(String),
    /// The request needs something that is missing or unknown; the message names the remedy.
    #[error("{0}")]
    Missing(Message),
    /// Several independent errors occurred; the message has one line for each.
    #[error("{}", lines(.0))]
    Several(Vec<Error>),
    /// The computation was cancelled.
    #[error("stopped on request")]
    Cancelled,
}

impl Error {
    /// Makes an [`Error::Input`] of file, place (may be empty), finding and remedy.
    pub fn input(
        file: impl Into<PathBuf>,
        place: impl Into<String>,
        found: impl Into<String>,
        remedy: impl Into<Message>,
    ) -> Self {
        Self::Input { file: file.into(), place: place.into(), found: found.into(), remedy: remedy.into() }
    }

    /// Makes an [`Error::Missing`].
    pub fn missing(message: impl Into<Message>) -> Self {
        Self::Missing(message.into())
    }

    /// Returns the error's message, in which each face words the remedies.
    pub fn message(&self) -> Message {
        match self {
            Self::Input { file, place, found, remedy } => {
                Message::from(format!("{}{}: {found}; ", file.display(), at(place))).and(remedy.clone())
            }
            Self::Missing(message) => message.clone(),
            Self::Several(errors) => Message::join(errors.iter().map(Self::message), "\n"),
            Self::Io { .. } | Self::Gpu(_) | Self::Request(_) | Self::Usage(_) | Self::Cancelled => {
                self.to_string().into()
            }
        }
    }

    /// Combines errors that occurred side by side into one; `None` when there are none. Cancellation takes
    /// precedence.
    pub fn of_all(errors: Vec<Self>) -> Option<Self> {
        if errors.iter().any(|error| matches!(error, Self::Cancelled)) {
            return Some(Self::Cancelled);
        }
        let mut errors = errors;
        if errors.len() > 1 { Some(Self::Several(errors)) } else { errors.pop() }
    }

    /// Returns the messages of errors in order of first occurrence. Errors that are the same for several files make
    /// one message, with the number of files and the first of their names.
    pub fn gathered(errors: &[&Self]) -> Vec<Message> {
        let mut groups: Vec<(&Self, Vec<&Path>)> = Vec::new();
        for error in errors {
            let file = error.file();
            match groups.iter_mut().find(|(first, _)| first.is_like(error)) {
                Some((_, files)) => files.extend(file),
                None => groups.push((error, file.into_iter().collect())),
            }
        }
        groups.into_iter().map(|(first, files)| first.message_for(&files)).collect()
    }

    /// Returns the file of an [`Error::Input`] that concerns a whole file.
    fn file(&self) -> Option<&Path> {
        match self {
            Self::Input { file, place, .. } if place.is_empty() => Some(file),
            _ => None,
        }
    }

    /// Returns true when both are the same problem with different files.
    fn is_like(&self, other: &Self) -> bool {
        let (Self::Input { found, remedy, .. }, Self::Input { found: theirs, remedy: other_remedy, .. }) =
            (self, other)
        else {
            return false;
        };
        self.file().is_some() && other.file().is_some() && (found, remedy) == (theirs, other_remedy)
    }

    /// Returns the message for all the files that have this problem.
    fn message_for(&self, files: &[&Path]) -> Message {
        let Self::Input { found, remedy, .. } = self else { return self.message() };
        if files.len() < 2 {
            return self.message();
        }
        let name = |file: &&Path| file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
        let named: Vec<String> = files.iter().take(NAMED).map(name).collect();
        let more = match files.len() - named.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let folder =
            files[0].parent().filter(|folder| files.iter().all(|file| file.parent() == Some(folder)));
        let folder = folder.filter(|folder| !folder.as_os_str().is_empty());
        let place = folder.map_or(String::new(), |folder| format!(" in {}", folder.display()));
        let files = format!("{} files{place}: {found}; ", files.len());
        Message::from(files).and(remedy.clone()).and(format!(" ({}{more})", named.join(", ")))
    }

    /// Makes a closure for `map_err` that wraps the system's error about `path` while `doing` something.
    pub fn io(path: impl AsRef<Path>, doing: &'static str) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.as_ref().to_path_buf();
        move |source| Self::Io { path, doing, source }
    }
}

/// Returns the reason in words for the most frequent errors; others in the system's words.
fn reason(source: &std::io::Error) -> String {
    match source.kind() {
        ErrorKind::NotFound => "it does not exist".into(),
        ErrorKind::AlreadyExists => "there is a file of this name".into(),
        ErrorKind::IsADirectory => "it is a folder, not a file".into(),
        ErrorKind::NotADirectory => "its path goes through a file as if it were a folder".into(),
        ErrorKind::PermissionDenied => "the system does not permit it".into(),
        ErrorKind::StorageFull => "the disk is full".into(),
        ErrorKind::QuotaExceeded => "your share of the disk is used up".into(),
        ErrorKind::ReadOnlyFilesystem => "the disk is read-only".into(),
        _ => source.to_string(),
    }
}

/// Returns the remedy against the system's most frequent errors, to be appended to the message.
fn remedy(source: &std::io::Error) -> &'static str {
    match source.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "; free some space on that disk, then try again",
        ErrorKind::ReadOnlyFilesystem => "; use a copy in another place",
        ErrorKind::NotFound | ErrorKind::NotADirectory => "; check the path",
        ErrorKind::IsADirectory => "; give a file",
        ErrorKind::AlreadyExists => "; choose another name, or move it away",
        ErrorKind::PermissionDenied => "; give yourself permission for that, or use a copy in another place",
        _ => "",
    }
}

/// The number of file names that a message lists; a longer list would not be read.
const NAMED: usize = 2;

/// Joins the errors' messages, one line each.
fn lines(errors: &[Error]) -> String {
    errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

/// Returns the place with a comma before it, or nothing for a whole file.
fn at(place: &str) -> String {
    if place.is_empty() { String::new() } else { format!(", {place}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disk_that_is_full_or_may_not_be_written_to_is_told_with_what_helps() {
        let message = |kind: ErrorKind| Error::io("a.png", "write it")(kind.into()).to_string();
        assert!(message(ErrorKind::StorageFull).ends_with("free some space on that disk, then try again"));
        assert!(message(ErrorKind::ReadOnlyFilesystem).ends_with("use a copy in another place"));
        assert!(message(ErrorKind::PermissionDenied).contains("give yourself permission"));
        assert_eq!(
            message(ErrorKind::NotFound),
            "a.png: could not write it: it does not exist; check the path"
        );
        assert_eq!(
            message(ErrorKind::IsADirectory),
            "a.png: could not write it: it is a folder, not a file; give a file"
        );
    }

    #[test]
    fn what_is_wrong_with_many_files_in_the_same_way_is_told_once_with_their_number() {
        let photo =
            |name: &str, found: &str| Error::input(format!("site/{name}"), "", found, "use its own size");
        let mut errors: Vec<Error> = (0..19).map(|i| photo(&format!("{i:02}.jpg"), "too small")).collect();
        errors.insert(1, photo("odd.jpg", "turned"));
        errors.push(Error::input("site/a.obj", "line 3", "no faces", "export them"));
        errors.push(Error::input("site/a.obj", "line 4", "no faces", "export them"));
        let messages = Error::gathered(&errors.iter().collect::<Vec<_>>());
        assert_eq!(
            messages[0].to_string(),
            "19 files in site: too small; use its own size (00.jpg, 01.jpg and 17 more)"
        );
        assert_eq!(
            messages[1..],
            errors[1..2].iter().chain(&errors[20..]).map(Error::message).collect::<Vec<_>>()
        );
    }
}
