//! The page that replaces the editor after a fault of the program: the window stays open.

use eframe::egui::{CentralPanel, RichText, Ui};

use super::editor::Editor;
use crate::action::build::close_project;
use crate::action::opening::open::open_now;
use crate::action::saving::keep_now;
use crate::work::crash::Crash;

/// The answer to the crash page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrashAnswer {
    /// Opens the project again.
    Reopen,
    /// Ends the program.
    Quit,
}

/// Draws the crash page; returns what the user chose.
pub fn crash_ui(crash: &Crash, ui: &mut Ui) -> Option<CrashAnswer> {
    let mut answer = None;
    CentralPanel::default_margins().show(ui, |ui| {
        ui.vertical_centered(|ui| {
            ui.add_space(ui.available_height() * 0.2);
            ui.label(RichText::new("An internal error occurred").size(26.0).strong());
            ui.add_space(8.0);
            ui.label("Your project is intact: each of its files is written completely or not at all.");
            ui.label(
                "Running jobs continue. Unsaved decisions are kept; you can restore them when you reopen the \
                      project.",
            );
            ui.label("Only the picture that was being drawn is lost.");
            ui.add_space(12.0);
            ui.monospace(&crash.said);
            if let Some(report) = &crash.report {
                ui.label(format!("A report is in {}. Please send it to the developers.", report.display()));
            }
            ui.add_space(16.0);
            if ui.button("Reopen project").clicked() {
                answer = Some(CrashAnswer::Reopen);
            }
            if ui.button("Quit").clicked() {
                answer = Some(CrashAnswer::Quit);
            }
        });
    });
    answer
}

impl Editor {
    /// Shows the crash page; unsaved changes are on disk before it appears.
    pub(super) fn crashed(&mut self, crash: Crash) {
        self.crash = Some(crash);
        keep_now(&mut self.state, &mut self.work);
    }

    /// Does what the user chose on the crash page.
    pub(super) fn answer_crash(&mut self, answer: CrashAnswer) {
        match answer {
            CrashAnswer::Reopen => self.go_on_after_crash(),
            CrashAnswer::Quit => self.state.quit(),
        }
    }

    /// Restarts from the files on disk, as the state in memory may be inconsistent.
    fn go_on_after_crash(&mut self) {
        self.crash = None;
        // Decisions are complete snapshots: the last ones are autosaved, and offered for recovery.
        keep_now(&mut self.state, &mut self.work);
        let folder = self.state.session.as_ref().map(|session| session.folder.clone());
        match folder {
            Some(folder) => open_now(&mut self.state, &mut self.work, folder),
            None => close_project(&mut self.state, &mut self.work),
        }
    }
}
