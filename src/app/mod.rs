//! The editor window: it displays the state and pushes requests, and computes nothing. Only this module knows egui.
//!
//! A frame has one direction: results of jobs and painter are applied, keys become commands, panels draw the state and
//! push `Request`s, and `action` applies those. Everything that takes longer than a frame is a job on a thread of its own.
//!
//! The layers, in an order in which none may use a later one: `state` (plain values), `widget` (parts of panels),
//! `work` (threads), `action` (changes of the state), `command` (menus and keys), `panel` (drawing), `shell` (the
//! window). Each of the other modules contains the state, the actions and the drawing of one subject.

mod action;
pub mod command;
mod panel;
mod shell;
mod state;
mod widget;
mod work;

use std::path::PathBuf;

use eframe::NativeOptions;
use eframe::egui::ViewportBuilder;

use self::crash::Crash;
use self::editor::Editor;
use self::frame_times::{FrameTimes, FrameTimesReport};
use self::shell::APP_ID;
pub use self::shell::{editor, frame_times};
pub use self::state::space::view_pixel;
pub use self::state::{
    life, model_suggestions, notes, panes, request, running, selection, settings, site_frame,
};
pub use self::work::autosave::Ending;
pub use self::work::crash;
pub use self::work::priority::lower_own_priority;
use quadratura_base::error::{Error, Result};

/// Opens the window, with a project or without; returns the frame times when it is closed. `ending` ends it from
/// outside.
///
/// # Errors
/// [`Error::Request`] when there is no display, no adapter that draws on it, or the display is lost;
/// [`Error::Cancelled`] where the window was ended from outside.
pub fn run(project: Option<PathBuf>, ending: Ending) -> Result<FrameTimesReport> {
    refuse_no_display()?;
    let times = FrameTimes::default();
    let frame_times = times.clone();
    let viewport = ViewportBuilder::default()
        .with_app_id(APP_ID)
        .with_title("Quadratura")
        .with_inner_size([1440.0, 900.0])
        .with_min_inner_size([720.0, 480.0])
        .with_drag_and_drop(true);
    let options = NativeOptions { viewport, ..NativeOptions::default() };
    let outside = ending.clone();
    let start = |creation: &eframe::CreationContext<'_>| {
        let mut editor = Editor::new(&creation.egui_ctx, creation.storage, project);
        outside.wakes(&editor.work.waker);
        (editor.frame_times, editor.work.ending) = (frame_times, outside);
        Ok(Box::new(editor) as Box<dyn eframe::App>)
    };
    crash::watch(eframe::storage_dir(APP_ID).map(|folder| folder.join("reports")));
    let mut ended = Ok(());
    let fault = crash::guarded(|| ended = eframe::run_native(APP_ID, options, Box::new(start)));
    // The window is closed by now, and unsaved changes are in the autosave.
    if ending.is_asked() {
        return Err(Error::Cancelled);
    }
    fault.map_err(|crash| Error::Request(crash_message(&crash, &ending)))?;
    ended.map(|()| times.report()).map_err(|error| {
        Error::Request(format!(
            "the window could not be opened: {error}; if no graphics driver supports the display, install a software \
             driver (on Debian and Ubuntu the package mesa-vulkan-drivers, which `sh examples/setup.sh` installs); \
             all other commands work without a window{}",
            kept(&ending)
        ))
    })
}

/// Fails where there is no display: the window system's own message would only name a line of its source.
fn refuse_no_display() -> Result<()> {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let displays = ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "DISPLAY"];
    if cfg!(target_os = "linux") && !displays.into_iter().any(is_set) {
        let message = "there is no display to open a window on: neither DISPLAY nor WAYLAND_DISPLAY is set; all \
                       other commands work without a display, and `quadratura --help` lists them";
        return Err(Error::Request(message.into()));
    }
    Ok(())
}

/// Describes a fault outside of the editor's drawing, such as in the window system.
fn crash_message(crash: &Crash, ending: &Ending) -> String {
    let kept = kept(ending);
    if crash.is_of_display() {
        return format!(
            "the connection to the display was lost or failed, and the window closed ({}); your project is intact: \
             each of its files is written completely or not at all{kept}",
            crash.said
        );
    }
    let report = crash.report.as_ref();
    let report = report.map_or(String::new(), |path| format!("; a report is in {}", path.display()));
    format!(
        "the window closed because of an internal error: {}; your project is intact: each of its files is written \
         completely or not at all{report}{kept}",
        crash.said
    )
}

/// Returns the sentence that says where the unsaved changes are.
fn kept(ending: &Ending) -> String {
    let folder = ending.left_behind();
    folder.map_or(String::new(), |folder| {
        let folder = folder.display();
        format!("; your unsaved changes are kept: `quadratura edit {folder}` offers to restore them")
    })
}
