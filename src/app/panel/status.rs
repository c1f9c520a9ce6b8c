//! The line at the bottom: what runs, what was said, what draws, how large all is.

use eframe::egui::{Align, Layout, ProgressBar, RichText, Spinner, Ui};

use super::grouped;
use crate::app::command::{edit, file};
use crate::app::editor::{Ask, Editor};
use crate::app::jobs::Job;
use crate::app::notes::Weight;

/// Draws it.
pub fn status_ui(editor: &mut Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    ui.horizontal(|ui| {
        jobs(editor, ui, asks);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            notes(editor, ui, asks);
            ui.separator();
            site(editor, ui, asks);
        });
    });
}

fn jobs(editor: &Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let Some((id, job)) = editor.jobs.running().next() else {
        ui.weak("Ready");
        return;
    };
    match job.share() {
        Some(share) => ui.add(ProgressBar::new(share).desired_width(120.0).show_percentage()),
        None => ui.add(Spinner::new().size(14.0)),
    };
    ui.label(&job.name);
    ui.weak(left(job));
    if ui.add_enabled(!job.is_stopping(), eframe::egui::Button::new("Stop").small()).clicked() {
        asks.push(Ask::Stop(id));
    }
    let more = editor.jobs.running().count() - 1;
    if more > 0 {
        ui.weak(format!("and {more} more"));
    }
    // Time goes by without anything happening.
    ui.ctx().request_repaint_after_secs(0.5);
}

/// How long a job will still take, in words.
pub fn left(job: &Job) -> String {
    if job.is_stopping() {
        return "stopping…".into();
    }
    match job.left().map(|left| left.as_secs()) {
        Some(seconds) if seconds >= 90 => format!("about {} min left", (seconds + 30) / 60),
        Some(seconds) => format!("about {} s left", seconds + 1),
        None => String::new(),
    }
}

fn notes(editor: &Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let (count, weight) = editor.notes.unseen();
    let text = match (count, weight) {
        (0, _) => RichText::new("Notes"),
        (count, Some(Weight::Problem)) => {
            RichText::new(format!("Notes ({count})")).color(ui.visuals().error_fg_color).strong()
        }
        (count, Some(Weight::Warning)) => {
            RichText::new(format!("Notes ({count})")).color(ui.visuals().warn_fg_color).strong()
        }
        (count, _) => RichText::new(format!("Notes ({count})")),
    };
    if ui.selectable_label(editor.settings.notes_shown, text).on_hover_text(file::NOTES.tooltip).clicked() {
        asks.push(Ask::Run(&file::NOTES));
    }
}

fn site(editor: &Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let Some(session) = &editor.session else { return };
    if let Some(painter) = &session.painter {
        // Its name without what makers put behind it: `llvmpipe (LLVM 15.0.6, 256 bits)`.
        let name = painter.adapter.split(" (").next().unwrap_or_default();
        ui.weak(name).on_hover_text(&painter.adapter);
        ui.separator();
    }
    if editor.is_dirty() {
        let text = RichText::new("Not saved").color(ui.visuals().warn_fg_color);
        if ui.button(text).on_hover_text(edit::SAVE.tooltip).clicked() {
            asks.push(Ask::Run(&edit::SAVE));
        }
        ui.separator();
    }
    let texels: u64 = session.photos.iter().filter_map(|photo| Some(photo.stack.as_ref()?.texels_used)).sum();
    let bytes: u64 = session.photos.iter().filter_map(|photo| Some(photo.stack.as_ref()?.bytes)).sum();
    ui.weak(format!("{} texels, {} MB of layers", grouped(texels), grouped(bytes / 1_000_000)));
    ui.separator();
    let (photos, faces) = (session.photos.len(), session.model().faces.len());
    ui.weak(format!("{photos} photos, {} faces", grouped(faces as u64)));
}
