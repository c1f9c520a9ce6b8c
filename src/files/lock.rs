//! The lock file of a project: only one program writes to a project at a time.

use std::io::ErrorKind;
use std::path::Path;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use super::lease::{Holder, Lease};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;

/// The name of the lock file in the project folder.
pub const LOCK_FILE: &str = "project.lock";

/// How long another holder than a brief one is seen until it is believed: one that gives the lock back, or has just taken it, may
/// not be named.
const BELIEVED: Duration = Duration::from_millis(300);

/// The right to write what is authored in a project; dropping it releases the lock. Stacks and caches need none: each photo has a
/// lock of its own.
#[derive(Debug)]
pub struct ProjectLock {
    _lease: Lease,
}

impl ProjectLock {
    /// Takes the lock of the project in `folder`.
    ///
    /// # Errors
    /// [`Error::Request`] naming the holder when another program writes to the project;
    /// [`Error::Input`] when the folder is not writable; [`Error::Io`] when the lock file cannot be created.
    pub fn take(folder: &Path) -> Result<Self> {
        let tried = Instant::now();
        loop {
            match try_take(folder)? {
                Ok(lease) => return Ok(Self { _lease: lease }),
                // It was given back between two looks.
                Err(holder) if holder == Holder::default() && tried.elapsed() < BELIEVED => {
                    std::thread::sleep(Duration::from_millis(1));
                }
                Err(holder) => return Err(held(folder, &holder.to_string())),
            }
        }
    }

    /// Takes the lock of the project in `folder`. While another program holds it for which `is_brief` returns true,
    /// this tries again after each `pause`, and says once whom it waits for. Other holders are believed in after a moment, those on
    /// other machines once they have renewed the lock; where they do not, it is taken over.
    ///
    /// # Errors
    /// As [`ProjectLock::take`] for other holders; [`Error::Cancelled`].
    pub fn take_after(
        folder: &Path,
        is_brief: impl Fn(&str) -> bool,
        pause: Duration,
        task: &Task,
    ) -> Result<Self> {
        let (mut noted, mut other): (bool, Option<(Holder, Instant)>) = (false, None);
        loop {
            task.check_cancelled()?;
            match try_take(folder)? {
                Ok(lease) => {
                    if let Some(before) = &lease.taken_over_from {
                        task.note(format!(
                            "{before} left the lock of this project behind; it was taken over"
                        ));
                    }
                    return Ok(Self { _lease: lease });
                }
                Err(holder) if is_brief(&holder.to_string()) => {
                    other = None;
                    if !std::mem::replace(&mut noted, true) {
                        task.note(format!("{holder} is writing to this project; waiting for it"));
                    }
                }
                Err(holder) => {
                    let (first, since) = other.get_or_insert_with(|| (holder.clone(), Instant::now()));
                    let lives = holder.is_known_to_live() || !holder.is_same_moment(first);
                    if lives && since.elapsed() >= BELIEVED {
                        return Err(held(folder, &holder.to_string()));
                    }
                    let is_elsewhere = !holder.is_known_to_live() && since.elapsed() >= BELIEVED;
                    if is_elsewhere && !std::mem::replace(&mut noted, true) {
                        task.note(format!(
                            "{holder} has the lock of this project; looking whether it still runs"
                        ));
                    }
                }
            }
            std::thread::sleep(pause);
        }
    }

    /// Returns which program holds the lock of the project in `folder`; `None` when no program does.
    pub fn holder(folder: &Path) -> Option<String> {
        Self::holder_of(folder).map(|holder| holder.to_string())
    }

    /// [`Self::holder`], with where it runs and since when.
    pub fn holder_of(folder: &Path) -> Option<Holder> {
        Lease::holder(&folder.join(LOCK_FILE))
    }
}

/// Takes the lock, or returns who holds it.
fn try_take(folder: &Path) -> Result<std::result::Result<Lease, Holder>> {
    let path = folder.join(LOCK_FILE);
    Lease::try_take(&path).map_err(|error| refused(folder, &path, error))
}

fn refused(folder: &Path, lock: &Path, error: std::io::Error) -> Error {
    match error.kind() {
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            let remedy = "give yourself write permission for its folder, or copy the project elsewhere";
            Error::input(folder, "", format!("this project is not writable ({error})"), remedy)
        }
        _ => Error::io(lock, "create the lock file")(error),
    }
}

/// The command of this program that is running, once it is known.
static COMMAND: OnceLock<String> = OnceLock::new();

/// Says which command of this program is running, whatever the program's file is called.
pub fn introduce(command: &str) {
    // The first one counts: a process runs one command.
    let _ = COMMAND.set(command.to_owned());
}

/// Returns the name of this program and the command it was started with.
pub(super) fn program() -> String {
    if let Some(command) = COMMAND.get() {
        return format!("{PROGRAM} {command}");
    }
    let path = std::env::current_exe().unwrap_or_default();
    let program =
        path.file_stem().map_or_else(|| "a program".into(), |name| name.to_string_lossy().into_owned());
    let words = std::env::args_os().skip(1).filter_map(|word| word.into_string().ok());
    match command_of(&program, words) {
        Some(command) => format!("{program} {command}"),
        None => program,
    }
}

/// Returns the command among the program's arguments; without one this program opens the window. (Other
/// programs that use the library have no commands.)
fn command_of(program: &str, mut words: impl Iterator<Item = String>) -> Option<String> {
    let is_command = |word: &String| !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase());
    (program == PROGRAM).then(|| words.find(is_command).unwrap_or_else(|| WINDOW_COMMAND.into()))
}

const PROGRAM: &str = "quadratura";
/// The command that opens the window.
const WINDOW_COMMAND: &str = "edit";

fn held(folder: &Path, holder: &str) -> Error {
    Error::Request(format!("{}: {}", folder.display(), holder_message(holder)))
}

/// Checks that no window of another program has the project in `folder` open, which updates it itself.
///
/// # Errors
/// [`Error::Request`] naming the window.
pub fn refuse_open_in_window(folder: &Path) -> Result<()> {
    let holder = ProjectLock::holder_of(folder).filter(|holder| !holder.is_this_process());
    match holder.map(|holder| holder.to_string()).filter(|holder| is_window(holder)) {
        Some(holder) => Err(held(folder, &holder)),
        None => Ok(()),
    }
}

/// Returns whether a holder of the lock is the editor's window, which keeps it until the project is closed.
fn is_window(holder: &str) -> bool {
    is_command(holder, WINDOW_COMMAND)
}

/// Returns whether a holder of the lock is the command `export`, of which several may be asked for at the same time.
pub fn is_export(holder: &str) -> bool {
    is_command(holder, "export")
}

fn is_command(holder: &str, command: &str) -> bool {
    holder.starts_with(&format!("{PROGRAM} {command} "))
}

/// Returns a message that names the holder of the lock and says what to do.
pub fn holder_message(holder: &str) -> String {
    match is_window(holder) {
        true => format!("this project is already open in a window ({holder}); close it there"),
        false => format!("{holder} is writing to this project; wait until it has finished, or stop it"),
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::*;

    #[test]
    fn the_second_writer_is_told_who_the_first_is() {
        let folder = tempfile::tempdir().unwrap();
        let first = ProjectLock::take(folder.path()).unwrap();
        let message = ProjectLock::take(folder.path()).unwrap_err().to_string();
        assert!(message.contains(&format!("process {}", std::process::id())), "{message}");
        let holder = ProjectLock::holder(folder.path());
        assert!(holder.is_some_and(|holder| holder.contains("process")));
        drop(first);
        assert_eq!(ProjectLock::holder(folder.path()), None);
        ProjectLock::take(folder.path()).unwrap();
    }

    #[test]
    fn it_is_told_whether_a_window_or_a_command_has_the_project_and_what_to_do() {
        let report = |words: &[&str]| {
            let command = command_of(PROGRAM, words.iter().map(|word| (*word).to_owned())).unwrap();
            holder_message(&format!("{PROGRAM} {command} (process 7)"))
        };
        for window in [&[][..], &["edit", "castle"], &["--threads", "2", "edit"]] {
            let report = report(window);
            assert!(
                report.contains("open in a window (quadratura edit (process 7)); close it there"),
                "{report}"
            );
        }
        let command = report(&["--json", "build", "castle"]);
        assert!(command.contains("quadratura build (process 7) is writing") && command.contains("stop it"));
        assert_eq!(command_of("harness", ["edit".to_owned()].into_iter()), None);
    }

    #[test]
    fn a_brief_holder_is_waited_for_and_one_that_keeps_the_lock_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let (pause, task) = (Duration::from_millis(1), Task::silent());
        let holder = RefCell::new(Some(ProjectLock::take(folder.path()).unwrap()));
        let refused =
            ProjectLock::take_after(folder.path(), |_| false, pause, &task).unwrap_err().to_string();
        assert!(refused.contains("is writing to this project"), "{refused}");
        let seen = RefCell::new(0);
        let is_brief = |_: &str| {
            *seen.borrow_mut() += 1;
            if *seen.borrow() == 3 {
                *holder.borrow_mut() = None;
            }
            true
        };
        ProjectLock::take_after(folder.path(), is_brief, pause, &task).unwrap();
        assert_eq!(seen.into_inner(), 3);
    }

    #[test]
    fn a_lock_file_that_was_left_behind_is_no_obstacle() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(LOCK_FILE);
        std::fs::write(&file, "quadratura (process 1)\n and much more\n").unwrap();
        drop(ProjectLock::take(folder.path()).unwrap());
        assert!(!file.exists());
    }
}
