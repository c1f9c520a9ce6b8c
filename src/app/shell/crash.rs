//! Faults of the program itself: a report is written, the window stays, and the project's files are whole, because
//! every file is written whole or not at all.

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
    /// What this thread's last panic said, and where its report is.
    static LAST: RefCell<Option<Crash>> = const { RefCell::new(None) };
}

/// A panic that was caught.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Crash {
    /// What it said.
    pub said: String,
    /// The file that tells more; none where it could not be written.
    pub report: Option<PathBuf>,
}

impl Crash {
    /// It was in what talks to the display: that ends so when the display is gone.
    pub fn is_of_display(&self) -> bool {
        is_of_display(&self.said)
    }
}

/// Whether a text names a source of what talks to the display.
pub fn is_of_display(text: &str) -> bool {
    ["winit-", "x11rb-", "wayland-"].iter().any(|package| text.contains(package))
}

/// From now on every panic leaves a report in the folder of the settings.
pub fn watch() {
    let before = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        before(panic);
        let folder = eframe::storage_dir(APP_ID).map(|folder| folder.join("reports"));
        let report = folder.and_then(|folder| written(&folder, &text(panic)));
        let crash = Crash { said: said(panic), report };
        // A thread that ends has nobody left to ask.
        let _ = LAST.try_with(|last| last.replace(Some(crash)));
    }));
}

/// Does it; a panic becomes a [`Crash`].
pub fn guarded(work: impl FnOnce()) -> Result<(), Crash> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| last())
}

/// The last panic of this thread.
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

/// Writes a report under a name of its own.
fn written(folder: &Path, text: &str) -> Option<PathBuf> {
    std::fs::create_dir_all(folder).ok()?;
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let path = folder.join(format!("fault-{}.txt", since.as_millis()));
    write_atomically(&path, text.as_bytes()).ok().map(|()| path)
}

/// What is shown instead of the editor after a fault.
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
    /// Shows what went wrong, instead of the editor; what is not saved is on disk before anybody reads that.
    pub(super) fn crashed(&mut self, crash: Crash) {
        self.crash = Some(crash);
        keep_now(&mut self.state, &mut self.work);
    }

    /// Begins anew from what is on disk: what is in memory may be half of something.
    fn go_on_after_crash(&mut self) {
        self.crash = None;
        // Decisions are whole snapshots: the last ones are kept, and offered again.
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
