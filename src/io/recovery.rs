//! Keeps unsaved changes for the case of a crash, in `project.unsaved.json` beside `project.json`, which
//! stays as it is. The file is authored data: it cannot be derived again.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

pub use super::project::UNSAVED_FILE;
use super::project::{PROJECT_FILE, judged};
use quadratura_base::error::{Error, Result};
use quadratura_document::Project;
use quadratura_files::atomic::{sync_folder, write_atomically};
use quadratura_files::hash::hash_file;
use quadratura_files::json::{read_json, to_json};

const LARGEST: u64 = 16 << 20;
const REMEDY: &str = "remove the file if you do not need the unsaved changes";

/// The content of the file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Unsaved {
    /// BLAKE3 of the `project.json` that the changes were made to.
    of: String,
    /// The project with the changes.
    project: Project,
}

/// Unsaved changes that a program left behind when it ended.
#[derive(Debug, Clone, PartialEq)]
pub struct UnsavedChanges {
    /// The project with the changes that were not saved.
    pub project: Project,
    /// The time at which they were kept.
    pub time: SystemTime,
    /// Whether `project.json` was changed by another program since; accepting the changes would undo that.
    pub saved_since: bool,
}

/// Stores a project with unsaved changes. The caller must hold the project's lock.
///
/// # Errors
/// [`Error::Io`]; the changes that were stored before stay, and so does `project.json`.
pub fn write_unsaved(folder: &Path, project: &Project) -> Result<()> {
    let unsaved = Unsaved { of: hash_file(folder.join(PROJECT_FILE))?, project: project.clone() };
    write_atomically(path(folder), &to_json(&unsaved))
}

/// Reads the unsaved changes; `None` where there are none, or where they are equal to `saved`, the current
/// content of `project.json`.
///
/// # Errors
/// [`Error::Input`] for a file that is damaged or from a newer program; [`Error::Io`]. The file stays in
/// place.
pub fn read_unsaved(folder: &Path, saved: &Project) -> Result<Option<UnsavedChanges>> {
    let file = path(folder);
    let time = match fs::metadata(&file).and_then(|data| data.modified()) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        time => time.map_err(Error::io(&file, "read it"))?,
    };
    let Unsaved { of, project } = read_json(&file, LARGEST, REMEDY)?;
    let project = judged(&file, project)?;
    if project == *saved {
        return Ok(None);
    }
    let saved_since = of != hash_file(folder.join(PROJECT_FILE))?;
    Ok(Some(UnsavedChanges { project, time, saved_since }))
}

/// Removes the stored changes, after a save or when they are not wanted.
///
/// # Errors
/// [`Error::Io`] when the file exists and cannot be removed.
pub fn forget_unsaved(folder: &Path) -> Result<()> {
    let file = path(folder);
    match fs::remove_file(&file) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        removed => removed.map_err(Error::io(&file, "remove it")).and_then(|()| sync_folder(folder)),
    }
}

fn path(folder: &Path) -> PathBuf {
    folder.join(UNSAVED_FILE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::project::{read_project, write_project};
    use quadratura_layers::Options;

    fn project(margin: u32) -> Project {
        let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m.obj"}"#;
        let project: Project = serde_json::from_str(text).unwrap();
        Project { options: Options { margin, ..Options::default() }, ..project }
    }

    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        write_project(folder.path(), &project(1)).unwrap();
        folder
    }

    #[test]
    fn unsaved_changes_are_found_and_project_json_is_unchanged() {
        let folder = folder();
        let before = fs::read(folder.path().join(PROJECT_FILE)).unwrap();
        assert_eq!(read_unsaved(folder.path(), &project(1)).unwrap(), None);
        write_unsaved(folder.path(), &project(2)).unwrap();
        write_unsaved(folder.path(), &project(3)).unwrap();
        let found = read_unsaved(folder.path(), &project(1)).unwrap().unwrap();
        assert_eq!((found.project, found.saved_since), (project(3), false));
        assert_eq!(fs::read(folder.path().join(PROJECT_FILE)).unwrap(), before);
    }

    #[test]
    fn after_a_save_there_is_nothing_to_recover_even_if_the_program_ended_before_it_could_forget() {
        let folder = folder();
        write_unsaved(folder.path(), &project(2)).unwrap();
        write_project(folder.path(), &project(2)).unwrap();
        assert_eq!(read_unsaved(folder.path(), &read_project(folder.path()).unwrap()).unwrap(), None);
        forget_unsaved(folder.path()).unwrap();
        forget_unsaved(folder.path()).unwrap();
        assert!(!folder.path().join(UNSAVED_FILE).exists());
    }

    #[test]
    fn a_project_that_was_changed_elsewhere_since_is_told() {
        let folder = folder();
        write_unsaved(folder.path(), &project(2)).unwrap();
        write_project(folder.path(), &project(5)).unwrap();
        let found = read_unsaved(folder.path(), &project(5)).unwrap().unwrap();
        assert!(found.saved_since && found.project == project(2));
    }

    #[test]
    fn a_damaged_file_is_reported_and_stays() {
        let folder = folder();
        let file = folder.path().join(UNSAVED_FILE);
        for text in [
            r#"{"of": "x""#,
            r#"{"of": "x", "project": {"version": 99, "photos": "p", "cameras": "c", "model": "m"}}"#,
        ] {
            fs::write(&file, text).unwrap();
            let message = read_unsaved(folder.path(), &project(1)).unwrap_err().to_string();
            assert!(message.contains(UNSAVED_FILE), "{message}");
            assert_eq!(fs::read_to_string(&file).unwrap(), text);
        }
    }
}
