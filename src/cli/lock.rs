//! Taking the lock of a project for a command.

use std::path::Path;
use std::time::Duration;

use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_files::lock::{ProjectLock, is_export, refuse_open_in_window};
use quadratura_io::project::read_project;

/// The time between attempts while another command exports.
const AGAIN: Duration = Duration::from_millis(50);

/// Takes the lock of the project in `folder` and reads the project. Exports of several jobs follow each other, so this waits for
/// those.
///
/// # Errors
/// The errors of [`read_project`]; [`quadratura_base::Error::Request`] naming the holder of the lock.
pub fn lock_and_read(folder: &Path, task: &Task) -> Result<(ProjectLock, Project)> {
    // A folder without a project gets no lock file, but an error that says so.
    read_project(folder)?;
    let lock = ProjectLock::take_after(folder, is_export, AGAIN, task)?;
    // The project is read again, because another program may have changed it before the lock was taken.
    Ok((lock, read_project(folder)?))
}

/// Reads the project in `folder`, with its lock where the command changes something.
///
/// # Errors
/// As [`lock_and_read`].
pub fn read_with_lock_if(
    changes: bool,
    folder: &Path,
    task: &Task,
) -> Result<(Option<ProjectLock>, Project)> {
    if !changes {
        return Ok((None, read_project(folder)?));
    }
    lock_and_read(folder, task).map(|(lock, project)| (Some(lock), project))
}

/// Reads the project in `folder` for a command that makes stacks or fillings, which needs no lock but those of the photos.
///
/// # Errors
/// The errors of [`read_project`]; [`quadratura_base::Error::Request`] where a window has the project open.
pub fn read_to_make(folder: &Path) -> Result<Project> {
    let project = read_project(folder)?;
    refuse_open_in_window(folder)?;
    Ok(project)
}
