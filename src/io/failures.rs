//! What failed, and why, in `cache/failed/` of a project: a photo has a file there from its failure until it is made again.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use quadratura_base::error::Error;
use quadratura_document::names::{file_name_of_photo, photo_of_file_name};
use quadratura_files::atomic::write_atomically;
use quadratura_files::json::{read_json, to_json};
use quadratura_files::lease::Holder;

const FOLDER: &str = "cache/failed";
const END: &str = ".json";
/// An error is some sentences.
const LARGEST: u64 = 1 << 20;

/// A photo that failed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// The program and its command.
    pub program: String,
    /// The name of the machine.
    pub host: String,
    /// The process id on that machine.
    pub process: u32,
    /// When the command failed, in seconds since 1970, UTC, by the clock of that machine.
    pub time: u64,
    /// The error.
    pub error: String,
}

/// Notes that a photo of the project in `folder` failed in this process, unless it was stopped. It is told in any case, so a failure
/// to write is not.
pub fn note_failure(folder: &Path, photo: &str, error: &Error) {
    if matches!(error, Error::Cancelled) {
        return;
    }
    let Holder { program, host, process, since, .. } = Holder::of_this_process();
    let failure = Failure { program, host, process, time: since, error: error.to_string() };
    let file = file(folder, photo);
    if fs::create_dir_all(folder.join(FOLDER)).is_ok() {
        let _ = write_atomically(file, &to_json(&failure));
    }
}

/// Removes the note of a photo that was made.
pub fn forget_failure(folder: &Path, photo: &str) {
    let _ = fs::remove_file(file(folder, photo));
}

/// Returns why a photo failed; `None` for one that did not.
fn failure(folder: &Path, photo: &str) -> Option<Failure> {
    read_json(&file(folder, photo), LARGEST, "").ok()
}

/// Returns the photos that failed, by name.
pub fn failures(folder: &Path) -> Vec<(String, Failure)> {
    let entries = fs::read_dir(folder.join(FOLDER)).into_iter().flatten().flatten();
    let mut failures: Vec<_> = entries
        .filter_map(|entry| {
            let name = entry.file_name().into_string().ok()?;
            let photo = photo_of_file_name(name.strip_suffix(END)?)?;
            Some((photo.clone(), failure(folder, &photo)?))
        })
        .collect();
    failures.sort_by(|a, b| a.0.cmp(&b.0));
    failures
}

fn file(folder: &Path, photo: &str) -> PathBuf {
    folder.join(FOLDER).join(format!("{}{END}", file_name_of_photo(photo)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_is_known_until_the_photo_is_made() {
        let folder = tempfile::tempdir().unwrap();
        forget_failure(folder.path(), "a/b.jpg");
        note_failure(folder.path(), "a/b.jpg", &Error::Cancelled);
        assert!(failures(folder.path()).is_empty());
        note_failure(folder.path(), "a/b.jpg", &Error::Request("it cannot be decoded".into()));
        let known = failures(folder.path());
        assert_eq!((&known[0].0[..], &known[0].1.error[..]), ("a/b.jpg", "it cannot be decoded"));
        assert_eq!(known[0].1.process, std::process::id());
        forget_failure(folder.path(), "a/b.jpg");
        assert!(failures(folder.path()).is_empty());
    }
}
