//! A project that somebody else has open: who it is, and the project opened as soon as it is free.

use std::path::PathBuf;

use eframe::egui::{Context, Spinner};

use super::Wish;
use crate::app::dialog::Dialog;
use crate::app::editor::Editor;
use crate::app::jobs::Kind;
use crate::io::lock::{ProjectLock, advice};

/// Often enough to seem at once, seldom enough to cost nothing.
const LOOKS_EVERY_S: f64 = 1.5;

/// Somebody else has the project.
pub struct Held {
    folder: PathBuf,
    holder: String,
    looked_s: f64,
}

impl Held {
    /// `holder` as the lock file signs it.
    pub fn by(folder: PathBuf, holder: String) -> Self {
        Self { folder, holder, looked_s: 0.0 }
    }
}

impl Editor {
    /// Opens the project when it is free.
    pub(super) fn watch_held(&mut self, context: &Context) {
        let Some(held) = &mut self.opening.held else { return };
        context.request_repaint_after_secs(LOOKS_EVERY_S as f32);
        let now_s = context.input(|input| input.time);
        if now_s - held.looked_s < LOOKS_EVERY_S || self.jobs.runs(Kind::Lock) {
            return;
        }
        held.looked_s = now_s;
        let folder = held.folder.clone();
        self.jobs.start(Kind::Lock, "Asking for the project's lock", move |_| {
            let is_free = ProjectLock::holder(&folder).is_none();
            Ok(Box::new(move |editor| {
                let waits = editor.opening.held.as_ref().is_some_and(|held| held.folder == folder);
                if is_free && waits {
                    editor.open_now(folder);
                }
            }))
        });
    }
}

/// Draws it.
pub(super) fn held_ui(editor: &Editor, context: &Context, wishes: &mut Vec<Wish>) {
    let Some(held) = &editor.opening.held else { return };
    let answer = Dialog::new("held", 460.0).show(context, |ui, keys| {
        ui.heading("Somebody else has this project");
        ui.label(format!("{}: {}.", held.folder.display(), advice(&held.holder)));
        ui.horizontal(|ui| {
            ui.add(Spinner::new().size(16.0));
            ui.label("It opens here by itself as soon as it is free.");
        });
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            if keys.press_first(&ui.button("Try again")) {
                wishes.push(Wish::TryAgain(held.folder.clone()));
            }
            if ui.button("Do not open it").clicked() {
                wishes.push(Wish::Cancel);
            }
        });
    });
    if answer.is_left() {
        wishes.push(Wish::Cancel);
    }
}
