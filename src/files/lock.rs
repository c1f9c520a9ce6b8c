//! The lock file of a project: only one program writes to a project at a time.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Seek, Write};
use std::path::Path;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;

/// The name of the lock file in the project folder.
pub const LOCK_FILE: &str = "project.lock";

/// How long the lock file has to name a holder that keeps the lock until that is believed. Between the taking of the lock and the
/// signing, it names nobody, or the holder before.
const BELIEVED: Duration = Duration::from_millis(300);

/// The right to write to a project; dropping it releases the lock.
///
/// The operating system holds the lock and releases it when the program ends, for whatever reason, so a stale
/// lock file blocks no other program. The file is never removed, because another program might be waiting for it.
#[derive(Debug)]
pub struct ProjectLock {
    _file: File,
}

impl ProjectLock {
    /// Takes the lock of the project in `folder`.
    ///
    /// # Errors
    /// [`Error::Request`] naming the holder when another program writes to the project;
    /// [`Error::Input`] when the folder is not writable; [`Error::Io`] when the lock file cannot be created.
    pub fn take(folder: &Path) -> Result<Self> {
        Self::try_take(folder)?.map_err(|holder| held(folder, &holder))
    }

    /// Takes the lock of the project in `folder`. While another program holds it for which `is_brief` returns true,
    /// this tries again after each `pause`, and says once whom it waits for. Other holders are believed in after a moment: one that
    /// has just taken the lock has not signed yet.
    ///
    /// # Errors
    /// As [`ProjectLock::take`] for other holders; [`Error::Cancelled`].
    pub fn take_after(
        folder: &Path,
        is_brief: impl Fn(&str) -> bool,
        pause: Duration,
        task: &Task,
    ) -> Result<Self> {
        let (mut noted, mut other_since) = (false, None);
        loop {
            task.check_cancelled()?;
            match Self::try_take(folder)? {
                Ok(lock) => return Ok(lock),
                Err(holder) if !is_brief(&holder) => {
                    if other_since.get_or_insert_with(Instant::now).elapsed() >= BELIEVED {
                        return Err(held(folder, &holder));
                    }
                }
                Err(holder) => {
                    other_since = None;
                    if !std::mem::replace(&mut noted, true) {
                        task.note(format!("{holder} is writing to this project; waiting for it"));
                    }
                }
            }
            std::thread::sleep(pause);
        }
    }

    /// Takes the lock, or returns who holds it.
    fn try_take(folder: &Path) -> Result<Result<Self, String>> {
        let path = folder.join(LOCK_FILE);
        let mut file = OpenOptions::new()
            .create(true)
            .truncate(false)
            .read(true)
            .write(true)
            .open(&path)
            .map_err(|error| refused(folder, &path, error))?;
        match file.try_lock() {
            Ok(()) => (),
            // A file system without locks, such as some network drives: work without protection rather than
            // not at all.
            Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => (),
            Err(TryLockError::Error(error)) => return Err(Error::io(&path, "lock it")(error)),
            Err(TryLockError::WouldBlock) => return Ok(Err(signature(&mut file))),
        }
        sign(&mut file).map_err(Error::io(&path, "write it"))?;
        Ok(Ok(Self { _file: file }))
    }
}

fn refused(folder: &Path, lock: &Path, error: std::io::Error) -> Error {
    match error.kind() {
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            let remedy = "give yourself write permission for its folder, or copy the project elsewhere";
            Error::input(folder, "", format!("this project is not writable ({error})"), remedy)
        }
        _ => Error::io(lock, "open the lock file")(error),
    }
}

impl ProjectLock {
    /// Returns which program holds the lock of the project in `folder`; `None` when no program does, or where
    /// that cannot be determined.
    pub fn holder(folder: &Path) -> Option<String> {
        let mut file = OpenOptions::new().read(true).write(true).open(folder.join(LOCK_FILE)).ok()?;
        matches!(file.try_lock(), Err(TryLockError::WouldBlock)).then(|| signature(&mut file))
    }
}

/// Writes this program's name and process id into the lock file, for the message to the next program that
/// wants the lock.
fn sign(file: &mut File) -> std::io::Result<()> {
    file.set_len(0)?;
    file.rewind()?;
    writeln!(file, "{} (process {})", program(), std::process::id())
}

/// The command of this program that is running, once it is known.
static COMMAND: OnceLock<String> = OnceLock::new();

/// Says which command of this program is running, whatever the program's file is called.
pub fn introduce(command: &str) {
    // The first one counts: a process runs one command.
    let _ = COMMAND.set(command.to_owned());
}

/// Returns the name of this program and the command it was started with.
fn program() -> String {
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

/// The command that holds the lock for one photo at a time.
const UPDATE_COMMAND: &str = "update";

fn held(folder: &Path, holder: &str) -> Error {
    Error::Request(format!("{}: {}", folder.display(), holder_message(holder)))
}

/// Returns whether a holder of the lock is the editor's window, which keeps it until the project is closed.
pub fn is_window(holder: &str) -> bool {
    is_command(holder, WINDOW_COMMAND)
}

/// Returns whether a holder of the lock is the command `update`, which releases it after each photo.
pub fn is_update(holder: &str) -> bool {
    is_command(holder, UPDATE_COMMAND)
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

/// Reads the holder's name from the lock file.
fn signature(file: &mut File) -> String {
    let mut holder = String::new();
    // The content is unreadable where the system locks it, too (Windows).
    let known = file.take(200).read_to_string(&mut holder).is_ok() && !holder.trim().is_empty();
    if known { holder.trim().to_owned() } else { "another program".to_owned() }
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
    fn a_holder_that_has_not_signed_yet_is_waited_for_and_one_that_keeps_the_lock_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(LOCK_FILE);
        std::fs::write(&path, "quadratura build (process 1)\n").unwrap();
        let open = || OpenOptions::new().read(true).write(true).open(&path).unwrap();
        let (pause, task) = (Duration::from_millis(1), Task::silent());
        let holder = RefCell::new(Some(open()));
        holder.borrow().as_ref().unwrap().lock().unwrap();
        let refused =
            ProjectLock::take_after(folder.path(), |_| false, pause, &task).unwrap_err().to_string();
        assert!(refused.contains("quadratura build (process 1) is writing"), "{refused}");
        // What the file names at each try: the holder before, nobody, and the holder, who goes after a while.
        let seen = RefCell::new(Vec::new());
        let is_brief = |name: &str| {
            seen.borrow_mut().push(name.to_owned());
            match seen.borrow().len() {
                1 => holder.borrow().as_ref().unwrap().set_len(0).unwrap(),
                2 => std::fs::write(&path, "quadratura update (process 2)\n").unwrap(),
                5 => *holder.borrow_mut() = None,
                _ => (),
            }
            name.contains("update")
        };
        ProjectLock::take_after(folder.path(), is_brief, pause, &task).unwrap();
        let seen = seen.into_inner();
        assert!(seen[0].contains("build") && seen[1] == "another program", "{seen:?}");
        assert!(seen.len() == 5 && seen[2..].iter().all(|name| name.contains("update")), "{seen:?}");
    }

    #[test]
    fn a_lock_file_that_was_left_behind_is_no_obstacle() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(LOCK_FILE), "quadratura (process 1)\n and much more\n").unwrap();
        let _lock = ProjectLock::take(folder.path()).unwrap();
        let signed = std::fs::read_to_string(folder.path().join(LOCK_FILE)).unwrap();
        assert_eq!(signed.lines().count(), 1);
    }
}
