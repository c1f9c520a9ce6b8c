//! The panel of messages and running jobs.

use eframe::egui::{Align, Color32, Layout, ProgressBar, RichText, ScrollArea, Ui};

use super::status::{left, stop_ui};
use crate::app::command::file::READ_AGAIN;
use crate::app::command::words::worded;
use crate::app::state::State;
use crate::app::state::ask::{Ask, MaskAsk, SelectAsk, WindowAsk};
use crate::app::state::notes::{Note, Remedy, Weight};
use crate::app::state::selection::Selection;

/// Draws the panel.
pub fn notes_ui(state: &State, ui: &mut Ui, asks: &mut Vec<Ask>) {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.strong("Messages and jobs");
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui.button("Clear").on_hover_text("Removes all messages.").clicked() {
                asks.push(WindowAsk::ClearNotes.into());
            }
        });
    });
    ScrollArea::vertical().auto_shrink(false).stick_to_bottom(true).show(ui, |ui| {
        state.notes.list().iter().for_each(|note| note_ui(state, ui, note, asks));
        // A new message is scrolled into view, wherever the list was.
        let (id, count) = (ui.scope_id().with("notes"), state.notes.list().len());
        let before = ui.data_mut(|data| std::mem::replace(data.get_temp_mut_or(id, 0), count));
        if count > before {
            ui.scroll_to_cursor(Some(Align::BOTTOM));
        }
        jobs(state, ui, asks);
        if state.notes.list().is_empty() && state.running.is_idle() {
            ui.weak("There are no messages. Problems and results are listed here.");
        }
    });
    if state.notes.unseen().0 > 0 {
        asks.push(WindowAsk::SeeNotes.into());
    }
}

fn jobs(state: &State, ui: &mut Ui, asks: &mut Vec<Ask>) {
    for (id, job) in state.running.all() {
        ui.horizontal(|ui| {
            ui.add(ProgressBar::new(job.share().unwrap_or_default()).desired_width(120.0));
            ui.label(&job.name);
            ui.weak(&job.stage);
            ui.weak(left(job));
            stop_ui(ui, (id, job), asks);
        });
    }
}

fn note_ui(state: &State, ui: &mut Ui, note: &Note, asks: &mut Vec<Ask>) {
    ui.horizontal_wrapped(|ui| {
        let (mark, color) = mark(ui, note.weight);
        ui.label(RichText::new(mark).color(color).strong());
        if !note.subject.is_empty() {
            match index_of(state, &note.subject) {
                Some(index) => {
                    if ui.link(&note.subject).on_hover_text("Selects the subject of this message.").clicked()
                    {
                        asks.push(Ask::Select(SelectAsk::Only(index)));
                    }
                }
                None => {
                    ui.strong(&note.subject);
                }
            }
        }
        ui.label(worded(&note.text));
        let open: Vec<_> = note.remedies.iter().filter(|(_, remedy)| state.can_remedy(remedy)).collect();
        for (words, remedy) in &open {
            if ui.link(words).clicked() {
                asks.push(remedy_ask(remedy, state));
            }
        }
        if open.is_empty() && !note.remedies.is_empty() {
            ui.weak("Resolved.");
        }
        if note.times > 1 {
            ui.weak(format!("({} times)", note.times));
        }
    });
}

/// Returns the ask of a remedy that was clicked.
fn remedy_ask(remedy: &Remedy, state: &State) -> Ask {
    match remedy {
        Remedy::ReadAgain => READ_AGAIN.asked(state),
        Remedy::SetMask(change) => MaskAsk::Set(change.clone()).into(),
        Remedy::ChooseMask(unmasked) => MaskAsk::Choose(unmasked.clone()).into(),
    }
}

fn mark(ui: &Ui, weight: Weight) -> (&'static str, Color32) {
    match weight {
        Weight::Info => ("Info", ui.visuals().weak_text_color()),
        Weight::Warning => ("Warning", ui.visuals().warn_fg_color),
        Weight::Problem => ("Problem", ui.visuals().error_fg_color),
    }
}

/// Returns the subject of a message as a selection.
fn index_of(state: &State, subject: &str) -> Option<Selection> {
    let site = &state.session.as_ref()?.opened.site;
    let photo = site.photo_named(subject).map(Selection::Photo);
    photo.or_else(|| site.model.object_named(subject).map(Selection::Object))
}
