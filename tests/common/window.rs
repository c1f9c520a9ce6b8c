//! The editor's window without a display, driven by the names of its widgets.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use egui_kittest::Harness;
use quadratura::app::editor::Editor;

/// A guard against waiting for ever, far beyond what any step takes.
const NEVER: Duration = Duration::from_secs(600);

/// A window, with a project or without.
pub fn window(project: Option<PathBuf>) -> Harness<'static, Editor> {
    let builder = Harness::builder().with_size([1280.0, 800.0]);
    builder.build_eframe(|creation| Editor::new(&creation.egui_ctx, None, project))
}

/// Lets frames go by until something is as it should be.
pub fn wait(harness: &mut Harness<'_, Editor>, what: &str, done: impl Fn(&Editor) -> bool) {
    let start = Instant::now();
    while !done(harness.state()) {
        harness.step();
        std::thread::sleep(Duration::from_millis(5));
        let notes: Vec<&str> = harness.state().notes.list().iter().map(|note| note.text.as_str()).collect();
        assert!(start.elapsed() < NEVER, "waiting for {what}: {notes:?}");
    }
    harness.step();
}

/// The site that comes with the project.
pub fn piazza() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("projects/piazza")
}
