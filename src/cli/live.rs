//! Folders for other programs that follow the project.

use std::path::{Path, PathBuf};

use super::lock::lock_and_read;
use super::table::counted;
use super::words::error_text;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_exports::handover::live::refresh;
use quadratura_sites::open::Opened;

/// Brings folders up to date, with the project's lock, and says so.
///
/// # Errors
/// Those of taking the lock and of [`refresh`].
pub fn follow(project: &Path, opened: &Opened, except: &[PathBuf], memory: u64, task: &Task) -> Result<()> {
    if !project.join("exports/handover/folders.json").is_file() {
        return Ok(());
    }
    let (_lock, _) = lock_and_read(project, task)?;
    follow_locked(project, opened, except, memory, task)
}

/// The same for a command that has the lock.
///
/// # Errors
/// Those of [`refresh`].
pub fn follow_locked(
    project: &Path,
    opened: &Opened,
    except: &[PathBuf],
    memory: u64,
    task: &Task,
) -> Result<()> {
    for refreshed in refresh(project, opened, except, memory, task)? {
        let folder = refreshed.folder.display();
        match refreshed.done {
            Ok(done) => {
                task.note(format!("{folder} is up to date: {}", counted(done.files.len(), "file")));
                done.failed.into_iter().for_each(|what| task.note(what));
            }
            Err(error) => task.note(format!("{folder} was not brought up to date: {}", error_text(&error))),
        }
    }
    Ok(())
}
