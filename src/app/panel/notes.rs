//! The panel of messages and running jobs.

use eframe::egui::{Align, Color32, Label, Layout, Response, RichText, ScrollArea, Sense, Ui};

use super::link_ui;
use super::status::{bar_ui, left, stop_ui};
use crate::command::file::READ_AGAIN;
use crate::command::words::worded;
use crate::state::State;
use crate::state::notes::{Note, NoteRemedy, Weight};
use crate::state::request::{MaskRequest, Request, SelectRequest, WindowRequest};
use crate::state::selection::Selection;

/// Draws the panel.
pub fn notes_ui(state: &State, ui: &mut Ui, requests: &mut Vec<Request>) {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.strong("Messages and jobs");
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui.button("Clear").on_hover_text("Removes all messages.").clicked() {
                requests.push(WindowRequest::ClearNotes.into());
            }
        });
    });
    ScrollArea::vertical().auto_shrink(false).stick_to_bottom(true).show(ui, |ui| {
        state.notes.list().iter().for_each(|note| note_ui(state, ui, note, requests));
        // A new message is scrolled into view, wherever the list was.
        let (id, count) = (ui.scope_id().with("notes"), state.notes.list().len());
        let before = ui.data_mut(|data| std::mem::replace(data.get_temp_mut_or(id, 0), count));
        if count > before {
            ui.scroll_to_cursor(Some(Align::BOTTOM));
        }
        jobs(state, ui, requests);
        if state.notes.list().is_empty() && state.running.is_idle() {
            ui.weak("There are no messages. Problems and results are listed here.");
        }
    });
    if state.notes.unseen().0 > 0 {
        requests.push(WindowRequest::SeeNotes.into());
    }
}

fn jobs(state: &State, ui: &mut Ui, requests: &mut Vec<Request>) {
    for (id, job) in state.running.all() {
        ui.horizontal(|ui| {
            bar_ui(ui, job);
            stop_ui(ui, id, job, requests);
            ui.label(&job.name);
            ui.weak(job.in_words());
            ui.weak(left(job));
        });
    }
}

fn note_ui(state: &State, ui: &mut Ui, note: &Note, requests: &mut Vec<Request>) {
    let texts = ui.horizontal_wrapped(|ui| {
        let texts = texts(state, ui, note, requests);
        let open: Vec<_> = note.remedies.iter().filter(|(_, remedy)| state.can_remedy(remedy)).collect();
        for (words, remedy) in &open {
            if link_ui(ui, words.as_str()).clicked() {
                requests.push(remedy_request(remedy, state));
            }
        }
        if open.is_empty() && !note.remedies.is_empty() {
            ui.weak("Resolved.");
        }
        if note.times > 1 {
            ui.weak(format!("({} times)", note.times));
        }
        texts
    });
    texts.inner.context_menu(|ui| menu(state, ui, note, requests));
}

/// Draws weight, subject and text of a message; returns them as one, for their menu. Its links are not part of it: a
/// line that takes clicks would take theirs.
fn texts(state: &State, ui: &mut Ui, note: &Note, requests: &mut Vec<Request>) -> Response {
    let label = |ui: &mut Ui, text: RichText| ui.add(Label::new(text).sense(Sense::click()));
    let (mark, color) = mark(ui, note.weight);
    let mut texts = label(ui, RichText::new(mark).color(color).strong());
    match index_of(state, &note.subject) {
        Some(index) => {
            let subject = link_ui(ui, &note.subject).on_hover_text("Selects the subject of this message.");
            if subject.clicked() {
                requests.push(Request::Select(SelectRequest::Only(index)));
            }
            texts |= subject;
        }
        None if note.subject.is_empty() => (),
        None => texts |= label(ui, RichText::new(&note.subject).strong()),
    }
    texts | label(ui, RichText::new(worded(&note.text)))
}

/// Draws the menu of a message.
fn menu(state: &State, ui: &mut Ui, note: &Note, requests: &mut Vec<Request>) {
    if ui.button("Copy message").clicked() {
        ui.ctx().copy_text(line(note));
        ui.close();
    }
    if ui.button("Copy all messages").clicked() {
        let all: Vec<String> = state.notes.list().iter().map(line).collect();
        ui.ctx().copy_text(all.join("\n"));
        ui.close();
    }
    if let Some(subject) = index_of(state, &note.subject)
        && ui.button(format!("Select {}", note.subject)).clicked()
    {
        requests.push(Request::Select(SelectRequest::Only(subject)));
        ui.close();
    }
    ui.separator();
    if ui.button("Clear messages").clicked() {
        requests.push(WindowRequest::ClearNotes.into());
        ui.close();
    }
}

/// Returns a message with its subject as text to be copied.
fn line(note: &Note) -> String {
    let text = worded(&note.text);
    if note.subject.is_empty() { text } else { format!("{}: {text}", note.subject) }
}

/// Returns the ask of a remedy that was clicked.
fn remedy_request(remedy: &NoteRemedy, state: &State) -> Request {
    match remedy {
        NoteRemedy::ReadAgain => READ_AGAIN.asked(state),
        NoteRemedy::SetMask(change) => MaskRequest::Set((**change).clone()).into(),
        NoteRemedy::ChooseMask(unmasked) => MaskRequest::Choose(unmasked.clone()).into(),
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
