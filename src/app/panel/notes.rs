//! The panel of messages and running jobs.

use eframe::egui::{Align, Color32, Label, Layout, Response, RichText, ScrollArea, Sense, Ui};

use super::link_ui;
use super::status::{bar_ui, left, stop_ui};
use crate::command::Commands;
use crate::command::file::READ_AGAIN;
use crate::command::words::worded;
use crate::state::State;
use crate::state::notes::{Note, NoteLog, NoteRemedy, Weight};
use crate::state::request::{MaskRequest, Request, SelectRequest, WindowRequest};
use crate::state::running::Running;
use crate::state::selection::Selection;
use crate::state::session::Session;

/// What the panel of messages shows.
pub struct NotesView<'a> {
    /// The commands that the panel offers.
    commands: Commands<'a>,
    /// The messages.
    notes: &'a NoteLog,
    /// The running jobs.
    running: &'a Running,
    /// The open project.
    session: Option<&'a Session>,
}

impl<'a> NotesView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self {
            commands: Commands::of(state),
            notes: &state.notes,
            running: &state.running,
            session: state.session.as_ref(),
        }
    }
}

/// Draws the panel.
pub fn notes_ui(view: &NotesView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
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
        view.notes.list().iter().for_each(|note| note_ui(view, ui, note, requests));
        // A new message is scrolled into view, wherever the list was.
        let (id, count) = (ui.scope_id().with("notes"), view.notes.list().len());
        let before = ui.data_mut(|data| std::mem::replace(data.get_temp_mut_or(id, 0), count));
        if count > before {
            ui.scroll_to_cursor(Some(Align::BOTTOM));
        }
        jobs(view, ui, requests);
        if view.notes.list().is_empty() && view.running.is_idle() {
            ui.weak("There are no messages. Problems and results are listed here.");
        }
    });
    if view.notes.unseen().0 > 0 {
        requests.push(WindowRequest::SeeNotes.into());
    }
}

fn jobs(view: &NotesView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    for (id, job) in view.running.all() {
        ui.horizontal(|ui| {
            bar_ui(ui, job);
            stop_ui(ui, id, job, requests);
            ui.label(&job.name);
            ui.weak(job.in_words());
            ui.weak(left(job));
        });
    }
}

fn note_ui(view: &NotesView<'_>, ui: &mut Ui, note: &Note, requests: &mut Vec<Request>) {
    let texts = ui.horizontal_wrapped(|ui| {
        let texts = texts(view, ui, note, requests);
        let open: Vec<_> = note.remedies.iter().filter(|(_, remedy)| remedy.applies(view.session)).collect();
        for (words, remedy) in &open {
            if link_ui(ui, words.as_str()).clicked() {
                requests.push(remedy_request(remedy, view));
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
    texts.inner.context_menu(|ui| menu(view, ui, note, requests));
}

/// Draws weight, subject and text of a message; returns them as one, for their menu. Its links are not part of it: a
/// line that takes clicks would take theirs.
fn texts(view: &NotesView<'_>, ui: &mut Ui, note: &Note, requests: &mut Vec<Request>) -> Response {
    let label = |ui: &mut Ui, text: RichText| ui.add(Label::new(text).sense(Sense::click()));
    let (mark, color) = mark(ui, note.weight);
    let mut texts = label(ui, RichText::new(mark).color(color).strong());
    match index_of(view, &note.subject) {
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
fn menu(view: &NotesView<'_>, ui: &mut Ui, note: &Note, requests: &mut Vec<Request>) {
    if ui.button("Copy message").clicked() {
        ui.ctx().copy_text(line(note));
        ui.close();
    }
    if ui.button("Copy all messages").clicked() {
        let all: Vec<String> = view.notes.list().iter().map(line).collect();
        ui.ctx().copy_text(all.join("\n"));
        ui.close();
    }
    if let Some(subject) = index_of(view, &note.subject)
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

/// Returns the request of a remedy that was clicked.
fn remedy_request(remedy: &NoteRemedy, view: &NotesView<'_>) -> Request {
    match remedy {
        NoteRemedy::ReadAgain => view.commands.requested(&READ_AGAIN),
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
fn index_of(view: &NotesView<'_>, subject: &str) -> Option<Selection> {
    let site = &view.session?.opened.site;
    let photo = site.photo_named(subject).map(Selection::Photo);
    photo.or_else(|| site.model.object_named(subject).map(Selection::Object))
}
