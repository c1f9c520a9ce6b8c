//! A project that is open elsewhere: shows the holder of its lock, and opens the project as soon as it is free.

use std::path::PathBuf;

use eframe::egui::{Context, Spinner};

use super::DialogRequest;
use crate::app::state::State;
use crate::app::state::ask::ProjectAsk;
use crate::app::state::running::JobKind;
use crate::app::widget::dialog::Dialog;
use crate::app::work::Work;
use crate::io::lock::{ProjectLock, holder_message};

/// The interval of checks, in seconds: short enough to seem immediate, long enough to cost nothing.
const LOOKS_EVERY_S: f64 = 1.5;

/// A project that is already open elsewhere.
pub struct Held {
    folder: PathBuf,
    holder: String,
    looked_s: f64,
}

impl Held {
    /// Makes the state of a locked project; `holder` is the signature in the lock file.
    pub fn by(folder: PathBuf, holder: String) -> Self {
        Self { folder, holder, looked_s: 0.0 }
    }
}

/// Opens the project when its lock is free.
pub fn watch_held(state: &mut State, work: &mut Work) {
    let Some(held) = &mut state.opening.held else { return };
    let now_s = state.window.now_s;
    state.window.wake_within(LOOKS_EVERY_S);
    if now_s - held.looked_s < LOOKS_EVERY_S || state.running.runs(JobKind::Lock) {
        return;
    }
    held.looked_s = now_s;
    let folder = held.folder.clone();
    work.jobs.start(&mut state.running, JobKind::Lock, "Asking for the project's lock", move |_| {
        let is_free = ProjectLock::holder(&folder).is_none();
        Ok(Box::new(move |state| {
            let waits = state.opening.held.as_ref().is_some_and(|held| held.folder == folder);
            let opens = (is_free && waits).then(|| ProjectAsk::OpenNow(folder).into());
            opens.into_iter().collect()
        }))
    });
}

/// Draws the dialog.
pub(super) fn held_ui(state: &State, context: &Context, requests: &mut Vec<DialogRequest>) {
    let Some(held) = &state.opening.held else { return };
    let answer = Dialog::new("held", 460.0).show(context, |ui, keys| {
        ui.heading("Somebody else has this project");
        ui.label(format!("{}: {}.", held.folder.display(), holder_message(&held.holder)));
        ui.horizontal(|ui| {
            ui.add(Spinner::new().size(16.0));
            ui.label("It opens here by itself as soon as it is free.");
        });
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            if keys.press_first(&ui.button("Try again")) {
                requests.push(DialogRequest::TryAgain(held.folder.clone()));
            }
            if ui.button("Do not open it").clicked() {
                requests.push(DialogRequest::Cancel);
            }
        });
    });
    if answer.is_left() {
        requests.push(DialogRequest::Cancel);
    }
}
