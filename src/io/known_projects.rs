//! What all windows of a user know about projects: the recent ones, and those whose updates are paused. It is in one small
//! file, which each window reads again when another one has changed it.

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions, create_dir_all};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use quadratura_base::error::{Error, Result};
use quadratura_files::atomic::write_atomically;
use quadratura_files::json::to_json;

/// The number of recent projects that are kept.
const MOST_RECENT: usize = 12;

/// The content of the file.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct KnownProjects {
    /// The folders of recent projects, the last opened first.
    pub recent: Vec<PathBuf>,
    /// The folders of projects whose updates in the background are paused.
    pub paused: BTreeSet<PathBuf>,
}

impl KnownProjects {
    /// Moves a project to the top of the recent ones.
    pub fn remember(&mut self, project: &Path) {
        let Some(project) = named(project) else { return };
        self.recent.retain(|other| *other != project);
        self.recent.insert(0, project);
        self.recent.truncate(MOST_RECENT);
    }

    /// Removes a project from the recent ones.
    pub fn forget(&mut self, project: &Path) {
        self.recent.retain(|other| other != project);
    }

    /// Returns whether the updates of a project are paused.
    pub fn is_paused(&self, project: &Path) -> bool {
        named(project).is_some_and(|project| self.paused.contains(&project))
    }

    /// Pauses the updates of a project, or resumes them.
    pub fn pause(&mut self, project: &Path, paused: bool) {
        let Some(project) = named(project) else { return };
        if paused {
            self.paused.insert(project)
        } else {
            self.paused.remove(&project)
        };
    }
}

/// Returns the name under which a project is known, whatever leads to it; none where JSON cannot hold it.
fn named(project: &Path) -> Option<PathBuf> {
    let project = project.canonicalize().unwrap_or_else(|_| project.to_path_buf());
    project.to_str().is_some().then_some(project)
}

/// Reads the file. One that is missing or damaged tells nothing: it has only what a window remembers for convenience.
pub fn read_known(file: &Path) -> KnownProjects {
    let text = std::fs::read(file).unwrap_or_default();
    serde_json::from_slice(&text).unwrap_or_default()
}

/// Changes what the file says now, also where other windows do so at the same time; returns what it says then.
///
/// # Errors
/// [`Error::Io`] when the file cannot be written.
pub fn change_known(file: &Path, change: impl FnOnce(&mut KnownProjects)) -> Result<KnownProjects> {
    let folder = file.parent().unwrap_or(file);
    create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    let _turn = turn(&file.with_extension("lock"))?;
    let before = read_known(file);
    let mut known = before.clone();
    change(&mut known);
    if known != before {
        write_atomically(file, &to_json(&known))?;
    }
    Ok(known)
}

/// Waits until no other window changes the file.
fn turn(lock: &Path) -> Result<File> {
    let open = OpenOptions::new().create(true).truncate(false).write(true).open(lock);
    let file = open.map_err(Error::io(lock, "open it"))?;
    file.lock().map_err(Error::io(lock, "lock it"))?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_project_opened_again_comes_first_and_is_listed_once() {
        let mut known = KnownProjects::default();
        (0..20).for_each(|i| known.remember(Path::new(&format!("no-such-project-{i}"))));
        known.remember(Path::new("no-such-project-15"));
        assert_eq!(known.recent.len(), MOST_RECENT);
        assert_eq!(known.recent[0], Path::new("no-such-project-15"));
        assert_eq!(known.recent.iter().filter(|path| path.ends_with("no-such-project-15")).count(), 1);
    }

    #[test]
    fn windows_that_write_at_the_same_time_lose_nothing_of_each_other() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("new/projects.json");
        std::thread::scope(|scope| {
            for window in 0..4 {
                let file = &file;
                scope.spawn(move || {
                    for turn in 0..8 {
                        let project = PathBuf::from(format!("site-{window}-{turn}"));
                        change_known(file, |known| known.pause(&project, true)).unwrap();
                    }
                });
            }
        });
        assert_eq!(read_known(&file).paused.len(), 32);
        let known = change_known(&file, |known| known.pause(Path::new("site-0-0"), false)).unwrap();
        assert!(!known.is_paused(Path::new("site-0-0")) && known.is_paused(Path::new("site-0-1")));
    }

    #[test]
    fn a_damaged_file_is_written_anew() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("projects.json");
        std::fs::write(&file, "{\"recent\": [").unwrap();
        assert_eq!(read_known(&file), KnownProjects::default());
        change_known(&file, |known| known.remember(Path::new("no-such-project"))).unwrap();
        assert_eq!(read_known(&file).recent, [PathBuf::from("no-such-project")]);
    }
}
