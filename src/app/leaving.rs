//! Leaving a project with something that is not saved, and coming back to it after a crash.

use std::path::PathBuf;

use eframe::egui::{Context, RichText, Ui, ViewportCommand};

use super::dialog::{Dialog, Keys};
use super::editor::Editor;
use super::notes::{Note, Weight};
use super::panel::answers_ui;
use crate::document::masks::Masks;
use crate::io::recovery::Recovered;

/// What becomes of what is not saved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Answer {
    Save,
    Discard,
    Stay,
}

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
    /// The masks when that was found.
    masks: Option<Masks>,
    /// What is not saved is to be forgotten when the project is left.
    discards: bool,
    /// All is to be saved, once masks that wait are written.
    saves: bool,
    /// Why it could not be saved, when somebody wanted to save and leave.
    failed: Option<String>,
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
        if self.ending.is_asked() && !self.questions.quits {
            return self.quit();
        }
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
        // Until it is answered it stays on disk as it is, whatever is done meanwhile.
        self.session.iter().for_each(|session| session.keeper.hold(true));
        self.questions.masks = self.session.as_ref().map(|session| session.history.present().masks.clone());
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
        let asked = Dialog::new("leaving", 440.0).show(context, |ui, keys| self.leaving_ui(ui, keys));
        match (asked.inner, asked.is_left()) {
            (Some(Answer::Save), _) => self.questions.saves = true,
            (Some(Answer::Discard), _) => {
                self.questions.discards = true;
                self.go();
            }
            (Some(Answer::Stay), _) | (None, true) => self.stay(),
            (None, false) => (),
        }
        // What was drawn last is a decision, too.
        if self.questions.saves && self.masking.is_kept() {
            self.questions.saves = false;
            match self.save() {
                Ok(()) => self.go(),
                Err(error) => self.questions.failed = Some(error.to_string()),
            }
        }
    }

    /// Asks what becomes of what is not saved, and says why it could not be saved.
    fn leaving_ui(&self, ui: &mut Ui, keys: &mut Keys) -> Option<Answer> {
        let name = self.session.as_ref().map(super::session::Session::name).unwrap_or_default();
        let answers = match &self.questions.failed {
            None => {
                ui.label(RichText::new(format!("Save what you decided about {name}?")).heading());
                ui.add_space(4.0);
                ui.label(
                    "Layers, fillings and paint are on disk already. Decisions that are not saved would be lost.",
                );
                [("Save", Answer::Save), ("Do not save", Answer::Discard), ("Cancel", Answer::Stay)]
            }
            Some(failed) => {
                ui.label(RichText::new(format!("{name} could not be saved")).heading());
                ui.add_space(4.0);
                ui.colored_label(ui.visuals().error_fg_color, failed);
                ui.label(
                    "What is on disk is as it was, without your last decisions: mend that, and try again.",
                );
                [
                    ("Try again", Answer::Save),
                    ("Leave without saving", Answer::Discard),
                    ("Stay here", Answer::Stay),
                ]
            }
        };
        ui.add_space(10.0);
        ui.horizontal(|ui| {
            let names = answers.map(|(name, _)| name);
            let chosen = answers_ui(ui, keys, &names);
            if self.questions.saves {
                ui.spinner();
                ui.label("Keeping masks…");
            }
            answers.into_iter().find(|(name, _)| chosen == Some(*name)).map(|(_, answer)| answer)
        })
        .inner
    }

    fn stay(&mut self) {
        (self.questions.leaving, self.questions.saves, self.questions.failed) = (None, false, None);
    }

    fn go(&mut self) {
        self.questions.failed = None;
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
                answer = answers_ui(ui, keys, &["Restore", "Discard"]);
            });
        });
        let Some(answer) = answer else { return };
        let Some(recovered) = self.questions.recovered.take() else { return };
        self.session.iter().for_each(|session| session.keeper.hold(false));
        if answer == "Restore" {
            let mut project = recovered.project;
            if let (Some(session), Some(masks)) = (&self.session, self.questions.masks.take()) {
                // Masks that came home while nobody had answered yet are on disk, and stay.
                project.masks = project.masks.with_news(&masks, &session.history.present().masks);
            }
            self.edit("recovery", project, None);
        } else {
            self.discard_unsaved();
            self.tell(Note::new(Weight::Info, "What was not saved is discarded"));
        }
    }
}

/// `5 minutes ago`, in a sentence.
pub(super) fn ago(passed: std::time::Duration) -> String {
    match passed.as_secs() / 60 {
        0 => "a moment ago".into(),
        1 => "a minute ago".into(),
        minutes @ 2..=119 => format!("{minutes} minutes ago"),
        minutes if minutes < 48 * 60 => format!("{} hours ago", minutes / 60),
        minutes => format!("{} days ago", minutes / 60 / 24),
    }
}
