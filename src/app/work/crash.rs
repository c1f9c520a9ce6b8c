//! Faults of the program: a panic is caught, and a report is written. The project's files are complete, because
//! every file is written completely or not at all.

use std::backtrace::Backtrace;
use std::cell::RefCell;
use std::fmt::Write as _;
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use quadratura_files::atomic::write_atomically;
use quadratura_files::guarded::is_decoding;

thread_local! {
    /// The last panic of this thread, and the path of its report.
    static LAST: RefCell<Option<Crash>> = const { RefCell::new(None) };
}

/// A panic that was caught.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Crash {
    /// The panic message.
    pub said: String,
    /// The path of the report; none where it could not be written.
    pub report: Option<PathBuf>,
}

impl Crash {
    /// Returns whether the panic came from the display connection, which panics when it is lost.
    pub fn is_of_display(&self) -> bool {
        is_of_display(&self.said)
    }
}

/// Returns whether a text names a source file of the display connection.
pub fn is_of_display(text: &str) -> bool {
    ["winit-", "x11rb-", "wayland-"].iter().any(|package| text.contains(package))
}

/// Installs the hook that writes a report of every panic into `folder`, where there is one.
pub fn watch(folder: Option<PathBuf>) {
    let before = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        before(panic);
        // A decoder's panic becomes an error about its file.
        if is_decoding() {
            return;
        }
        let report = folder.as_ref().and_then(|folder| written(folder, &text(panic)));
        let crash = Crash { said: said(panic), report };
        // Thread-local storage may be gone in a thread that ends.
        let _ = LAST.try_with(|last| last.replace(Some(crash)));
    }));
}

/// Runs `work`; a panic becomes a [`Crash`].
pub fn guarded(work: impl FnOnce()) -> Result<(), Crash> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| last())
}

/// Returns the last panic of this thread.
pub fn last() -> Crash {
    LAST.with(|last| last.take()).unwrap_or_default()
}

fn said(panic: &PanicHookInfo<'_>) -> String {
    let payload = panic.payload_as_str().unwrap_or("an error without a text");
    let place =
        panic.location().map_or(String::new(), |place| format!(" ({}:{})", place.file(), place.line()));
    format!("{payload}{place}")
}

fn text(panic: &PanicHookInfo<'_>) -> String {
    let thread = std::thread::current();
    let mut text = format!("Quadratura {}\n", env!("CARGO_PKG_VERSION"));
    let _ = writeln!(text, "{} {}", std::env::consts::OS, std::env::consts::ARCH);
    let _ = writeln!(text, "thread: {}", thread.name().unwrap_or("without a name"));
    let _ = writeln!(text, "{}\n", said(panic));
    let _ = writeln!(text, "{}", Backtrace::force_capture());
    text
}

/// Writes a report under a unique name.
fn written(folder: &Path, text: &str) -> Option<PathBuf> {
    std::fs::create_dir_all(folder).ok()?;
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let path = folder.join(format!("fault-{}.txt", since.as_millis()));
    write_atomically(&path, text.as_bytes()).ok().map(|()| path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_leaves_a_report_that_says_what_and_where() {
        let folder = tempfile::tempdir().unwrap();
        let path = written(&folder.path().join("reports"), "the wall fell").unwrap();
        assert_eq!(std::fs::read_to_string(path).unwrap(), "the wall fell");
        assert!(guarded(|| ()).is_ok());
        assert!(guarded(|| panic!("the wall fell")).is_err());
    }
}
