//! The status bar: running jobs, messages, the device of the 3D view, the size of the site.

use eframe::egui::{Align, Button, Label, Layout, ProgressBar, RichText, Ui};

use super::{grouped, text_width};
use crate::command::{Commands, file, layers};
use crate::state::State;
use crate::state::notes::{NoteLog, Weight};
use crate::state::request::{JobRequest, Request};
use crate::state::running::{Job, JobId, JobKind, Running};
use crate::state::session::Session;
use crate::widget::spinner::Spinner;

/// What the status bar shows.
pub struct StatusView<'a> {
    /// The commands that the panel offers.
    commands: Commands<'a>,
    /// The running jobs.
    running: &'a Running,
    /// The open project.
    session: Option<&'a Session>,
    /// The messages.
    notes: &'a NoteLog,
    /// Whether the messages are shown.
    notes_shown: bool,
    /// The name of the device that draws the 3D view.
    device: Option<&'a str>,
    /// What is said of layered depth images.
    images: Option<String>,
    /// What waits because updates are switched off.
    paused: Option<String>,
    /// Whether there are changes to save.
    is_dirty: bool,
}

impl<'a> StatusView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self {
            commands: Commands::of(state),
            running: &state.running,
            session: state.session.as_ref(),
            notes: &state.notes,
            notes_shown: state.settings.notes_shown,
            device: state.space.device.as_deref(),
            images: state.images_in_words(),
            paused: state.paused_updates().in_words(),
            is_dirty: state.is_dirty(),
        }
    }
}

/// Draws the status bar.
pub fn status_ui(view: &StatusView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    ui.horizontal(|ui| {
        jobs(view, ui, requests);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            notes(view, ui, requests);
            unsaved(view, ui, requests);
            site(view, ui);
        });
    });
}

fn jobs(view: &StatusView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    // What the user has started comes first, and then an update in the background.
    let is_update = |job: &Job| job.kind == JobKind::Update;
    let rank = |job: &Job| (job.kind.is_quiet() && !is_update(job), is_update(job));
    let first = view.running.all().min_by_key(|(id, job)| (rank(job), *id));
    let images = view.images.clone();
    let Some((id, job)) = first else {
        let Some(images) = images else { return rest(view, ui, requests) };
        // What the view shows is said in place of nothing.
        if view.paused.is_some() {
            rest(view, ui, requests);
            ui.separator();
        }
        return images_ui(ui, images);
    };
    bar_ui(ui, job);
    // The button comes before the words, whose length changes, so that it stays under the pointer.
    stop_ui(ui, id, job, requests);
    ui.label(&job.name);
    if !job.progress.in_words().is_empty() {
        let words = ui.weak(job.progress.in_words());
        if is_update(job) {
            words.on_hover_text(
                "An update looks at all photos, because they fill each other; most need nothing.",
            );
        }
    }
    ui.weak(left(job));
    let more = view.running.all().count() - 1;
    if more > 0 {
        ui.weak(format!("and {more} more"));
    }
    if let Some(images) = images {
        ui.separator();
        images_ui(ui, images);
    }
    // The remaining time is updated even where no job reports progress.
    ui.ctx().request_repaint_after_secs(0.5);
}

/// Draws how far a job is, always as wide.
pub fn bar_ui(ui: &mut Ui, job: &Job) {
    match job.progress.share() {
        Some(share) => ui.add(ProgressBar::new(share).desired_width(BAR).show_percentage()),
        None => ui.add_sized([BAR, 14.0], Spinner::new().size(14.0)),
    };
}

/// Draws the button that stops a job; an update in the background is paused.
pub fn stop_ui(ui: &mut Ui, id: JobId, job: &Job, requests: &mut Vec<Request>) {
    let (name, tooltip) = match job.kind {
        JobKind::Update => ("Pause", "Switches “Keep everything up to date” off."),
        _ => ("Stop", "Stops this job; finished results are kept."),
    };
    let button = ui.add_enabled(!job.is_stopping(), Button::new(name).small());
    if button.on_hover_text(tooltip).clicked() {
        requests.push(Request::Build(JobRequest::Stop(id)));
    }
}

/// The width of the progress bar, in points.
const BAR: f32 = 120.0;
/// The room that other parts of the bar need at least, in points.
const OTHERS: f32 = 130.0;

/// Draws what the view is drawn from, as far as there is room.
fn images_ui(ui: &mut Ui, text: String) {
    let room = (ui.available_width() - OTHERS).max(0.0);
    ui.scope(|ui| {
        ui.set_max_width(room);
        ui.add(Label::new(RichText::new(&text).weak()).truncate()).on_hover_text(text);
    });
}

/// Draws what is said while no job runs.
fn rest(view: &StatusView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    let Some(waits) = &view.paused else {
        ui.weak("Ready");
        return;
    };
    // The button comes first, so that its place does not depend on the text.
    let button = ui.add(Button::new("Resume").small());
    if button.on_hover_text(layers::KEEP_UP.tooltip).clicked() {
        requests.push(view.commands.requested(&layers::KEEP_UP));
    }
    ui.weak(format!("Updates are paused: {waits}"));
}

/// Returns the remaining time of a job as text: `stopping…` once it was asked to stop, and nothing while there is no
/// estimate.
pub fn left(job: &Job) -> String {
    if job.is_stopping() {
        return "stopping…".into();
    }
    match job.progress.left().map(|left| left.as_secs()) {
        Some(seconds) if seconds >= 90 => format!("about {} min left", (seconds + 30) / 60),
        Some(seconds) => format!("about {} s left", seconds + 1),
        None => String::new(),
    }
}

fn notes(view: &StatusView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    let (count, weight) = view.notes.unseen();
    let text = match (count, weight) {
        (0, _) => RichText::new("Messages"),
        (count, Some(Weight::Problem)) => {
            RichText::new(format!("Messages ({count})")).color(ui.visuals().error_fg_color).strong()
        }
        (count, Some(Weight::Warning)) => {
            RichText::new(format!("Messages ({count})")).color(ui.visuals().warn_fg_color).strong()
        }
        (count, _) => RichText::new(format!("Messages ({count})")),
    };
    if ui.selectable_label(view.notes_shown, text).on_hover_text(file::NOTES.tooltip).clicked() {
        requests.push(view.commands.requested(&file::NOTES));
    }
}

fn unsaved(view: &StatusView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    if view.session.is_some() && view.is_dirty {
        ui.separator();
        let text = RichText::new("Unsaved").color(ui.visuals().warn_fg_color);
        if ui.button(text).on_hover_text(file::SAVE.tooltip).clicked() {
            requests.push(view.commands.requested(&file::SAVE));
        }
    }
}

/// The width of a separator with its gaps, in points.
const BETWEEN: f32 = 24.0;

/// Draws device and site size from the right, as far as they fit.
fn site(view: &StatusView<'_>, ui: &mut Ui) {
    let Some(session) = view.session else { return };
    let stacks = || session.photos.iter().filter_map(|photo| photo.stack.as_ref());
    let texels: u64 = stacks().map(|stack| stack.texels_used).sum();
    let megabytes = stacks().map(|stack| stack.bytes).sum::<u64>() / 1_000_000;
    let (photos, faces) = (session.photos.len(), session.model().faces.len());
    let adapter = view.device;
    // The name is cut at the vendor's suffix: `llvmpipe (LLVM 15.0.6, 256 bits)`.
    let device = adapter.as_ref().map(|name| name.split(" (").next().unwrap_or_default().to_owned());
    let size = format!("{} texels, {} MB of layers", grouped(texels), grouped(megabytes));
    let site = format!("{photos} photos, {} faces", grouped(faces as u64));
    for (text, more) in [(device.unwrap_or_default(), adapter), (size, None), (site, None)] {
        if text.is_empty() {
            continue;
        }
        if text_width(ui, &text) + BETWEEN > ui.available_width() {
            return;
        }
        ui.separator();
        let label = ui.weak(text);
        if let Some(more) = more {
            label.on_hover_text(more);
        }
    }
}
