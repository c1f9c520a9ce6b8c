//! Faults of the program: a report is written and the window stays open. The project's files are complete, because
//! every file is written completely or not at all.

use std::backtrace::Backtrace;
use std::cell::RefCell;
use std::fmt::Write as _;
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use eframe::egui::{CentralPanel, RichText, Ui};

use crate::app::APP_ID;
use crate::app::action::build::close_project;
use crate::app::action::saving::keep_now;
use crate::app::editor::Editor;
use crate::app::opening::open_now;
use crate::io::atomic::write_atomically;

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

/// Installs the hook that writes a report of every panic into the folder of the settings.
pub fn watch() {
    let before = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        before(panic);
        let folder = eframe::storage_dir(APP_ID).map(|folder| folder.join("reports"));
        let report = folder.and_then(|folder| written(&folder, &text(panic)));
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
    let payload = panic.payload_as_str().unwrap_or("something that is no text");
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

/// Draws the crash page, which replaces the editor after a fault.
pub fn crash_ui(editor: &mut Editor, ui: &mut Ui) {
    let Some(crash) = editor.crash.clone() else { return };
    CentralPanel::default_margins().show(ui, |ui| {
        ui.vertical_centered(|ui| {
            ui.add_space(ui.available_height() * 0.2);
            ui.label(RichText::new("The program made a mistake").size(26.0).strong());
            ui.add_space(8.0);
            ui.label("Your project is whole: every file of it is written at once or not at all.");
            ui.label("Jobs that run go on. Decisions that are not saved are kept, and offered when it is opened again.");
            ui.label("What was being drawn is gone, and nothing else.");
            ui.add_space(12.0);
            ui.monospace(&crash.said);
            if let Some(report) = &crash.report {
                ui.label(format!("A report is in {}. Please send it to the makers.", report.display()));
            }
            ui.add_space(16.0);
            if ui.button("Open the project again").clicked() {
                editor.go_on_after_crash();
            }
            if ui.button("Quit").clicked() {
                editor.state.quit();
            }
        });
    });
}

impl Editor {
    /// Shows the crash page; unsaved changes are on disk before it appears.
    pub(super) fn crashed(&mut self, crash: Crash) {
        self.crash = Some(crash);
        keep_now(&mut self.state, &mut self.work);
    }

    /// Restarts from the files on disk, as the state in memory may be inconsistent.
    fn go_on_after_crash(&mut self) {
        self.crash = None;
        // Decisions are complete snapshots: the last ones are autosaved, and offered for recovery.
        keep_now(&mut self.state, &mut self.work);
        let folder = self.state.session.as_ref().map(|session| session.folder.clone());
        match folder {
            Some(folder) => open_now(&mut self.state, &mut self.work, folder),
            None => close_project(&mut self.state, &mut self.work),
        }
    }
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
