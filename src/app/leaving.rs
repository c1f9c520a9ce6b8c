//! Leaving a project with something that is not saved, and coming back to it after a crash.

use std::path::PathBuf;

use eframe::egui::{Button, Context, RichText, Ui, ViewportCommand, vec2};

use super::dialog::{Dialog, Keys};
use super::editor::Editor;
use super::notes::{Note, Weight};
use crate::io::recovery::Recovered;

/// Where one is going.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Leaving {
    /// To no project.
    Close,
    /// To another project.
    Open(PathBuf),
    /// To the project that the assistant makes.
    Create,
    /// Out of the program.
    Quit,
}

/// Questions before a project is left, or after it was opened.
#[derive(Debug, Default)]
pub struct Questions {
    leaving: Option<Leaving>,
    /// What was not saved when the program ended last.
    recovered: Option<Recovered>,
    /// What is not saved is to be forgotten when the project is left.
    discards: bool,
    /// All is to be saved, once masks that wait are written.
    saves: bool,
    /// It was said that nothing is to be asked any more.
    quits: bool,
}

impl Editor {
    /// Leaves the project; asks first where something is not saved.
    pub fn leave(&mut self, leaving: Leaving) {
        if self.is_dirty() {
            self.questions.leaving = Some(leaving);
        } else {
            self.leave_writers(leaving);
        }
    }

    pub(super) fn left(&mut self, leaving: Leaving) {
        if std::mem::take(&mut self.questions.discards) {
            self.discard_unsaved();
        }
        match leaving {
            Leaving::Close => self.close_project(),
            Leaving::Open(project) => self.open_now(project),
            Leaving::Create => self.create_project(),
            Leaving::Quit => self.quit(),
        }
    }

    /// A question waits for an answer: keys and files are for it.
    pub(super) fn asks(&self) -> bool {
        self.questions.leaving.is_some() || self.questions.recovered.is_some() || self.lists.asks()
    }

    /// What was asked about a project that is being closed.
    pub(super) fn forget_questions(&mut self) {
        self.questions = Questions { quits: self.questions.quits, ..Questions::default() };
    }

    /// Closes the window; nothing is asked any more.
    pub(super) fn quit(&mut self) {
        self.questions.quits = true;
        self.context.send_viewport_cmd(ViewportCommand::Close);
    }

    /// The window's own button asks, too.
    pub(super) fn take_close_request(&mut self, context: &Context) {
        let asked = context.input(|input| input.viewport().close_requested());
        let ends = self.is_dirty() || self.jobs.writing().next().is_some();
        // After a fault no question is shown that could be answered; what is not saved is kept.
        if asked && ends && !self.questions.quits && self.crash.is_none() {
            context.send_viewport_cmd(ViewportCommand::CancelClose);
            self.leave(Leaving::Quit);
        }
    }

    /// Something was found that was not saved when the program ended last.
    pub(super) fn offer_recovery(&mut self, recovered: Recovered) {
        self.questions.recovered = Some(recovered);
    }

    pub(super) fn questions_ui(&mut self, context: &Context) {
        if self.questions.leaving.is_some() {
            self.ask_leaving(context);
        } else if self.questions.recovered.is_some() {
            self.ask_recovery(context);
        }
    }

    fn ask_leaving(&mut self, context: &Context) {
        let name = self.session.as_ref().map(super::session::Session::name).unwrap_or_default();
        let mut answer = None;
        let asked = Dialog::new("leaving", 400.0).show(context, |ui, keys| {
            ui.label(RichText::new(format!("Save what you decided about {name}?")).heading());
            ui.add_space(4.0);
            ui.label(
                "Layers, fillings and paint are on disk already. Decisions that are not saved would be lost.",
            );
            ui.add_space(10.0);
            ui.horizontal(|ui| {
                answer = choice(ui, keys, &["Save", "Do not save", "Cancel"]);
                if self.questions.saves {
                    ui.spinner();
                    ui.label("Keeping masks…");
                }
            });
        });
        match (answer, asked.is_left()) {
            (Some("Save"), _) => self.questions.saves = true,
            (Some("Do not save"), _) => {
                self.questions.discards = true;
                self.go();
            }
            (Some(_), _) | (None, true) => (self.questions.leaving, self.questions.saves) = (None, false),
            (None, false) => (),
        }
        // What was drawn last is a decision, too.
        if self.questions.saves && self.masking.is_kept() {
            self.questions.saves = false;
            if self.save_project() {
                self.go();
            }
        }
    }

    fn go(&mut self) {
        if let Some(leaving) = self.questions.leaving.take() {
            self.leave_writers(leaving);
        }
    }

    fn ask_recovery(&mut self, context: &Context) {
        let Some(recovered) = &self.questions.recovered else { return };
        let when = recovered.time.elapsed().map_or_else(|_| "the end".into(), ago);
        let since = recovered.saved_since;
        let mut answer = None;
        Dialog::new("recovery", 440.0).show(context, |ui, keys| {
            ui.label(RichText::new("Something was not saved").heading());
            ui.add_space(4.0);
            ui.label(format!(
                "The program ended before you saved. What you had decided until {when} is kept: restore it, or discard \
                 it and go on from what was saved last."
            ));
            if since {
                ui.colored_label(
                    ui.visuals().warn_fg_color,
                    "The project was saved by another program since: restoring replaces what that changed.",
                );
            }
            ui.add_space(10.0);
            ui.horizontal(|ui| {
                answer = choice(ui, keys, &["Restore", "Discard"]);
            });
        });
        let Some(answer) = answer else { return };
        let Some(recovered) = self.questions.recovered.take() else { return };
        if answer == "Restore" {
            self.edit("recovery", recovered.project, None);
        } else {
            self.discard_unsaved();
            self.tell(Note::new(Weight::Info, "What was not saved is discarded"));
        }
    }
}

/// Buttons in a row, the first one as the usual answer, which has the focus; the one that was pressed.
fn choice(ui: &mut Ui, keys: &mut Keys, answers: &[&'static str]) -> Option<&'static str> {
    let mut chosen = None;
    for (place, answer) in answers.iter().enumerate() {
        let is_usual = place == 0;
        let text = if is_usual { RichText::new(*answer).strong() } else { RichText::new(*answer) };
        let button = ui.add(Button::new(text).min_size(vec2(96.0, 28.0)));
        let is_pressed = if is_usual { keys.press_first(&button) } else { button.clicked() };
        if is_pressed {
            chosen = Some(*answer);
        }
    }
    chosen
}

/// `5 minutes ago`, in a sentence.
fn ago(passed: std::time::Duration) -> String {
    match passed.as_secs() / 60 {
        0 => "a moment ago".into(),
        1 => "a minute ago".into(),
        minutes @ 2..=119 => format!("{minutes} minutes ago"),
        minutes if minutes < 48 * 60 => format!("{} hours ago", minutes / 60),
        minutes => format!("{} days ago", minutes / 60 / 24),
    }
}
