//! The list of the history: a click goes to a step.

use eframe::egui::{Button, Context, RichText, Ui, Window};

use super::long_list;
use crate::state::request::{DecideRequest, Flag, Request, WindowRequest};
use crate::state::session::Session;
use crate::widget::dialog::escaped;

/// The height of the list, in points.
const HEIGHT: f32 = 360.0;

/// Draws the list while it is open.
pub fn history_ui(shown: bool, session: Option<&Session>, context: &Context, requests: &mut Vec<Request>) {
    if !shown {
        return;
    }
    let mut open = true;
    let window = Window::new("History").open(&mut open).default_width(300.0);
    window.show(context, |ui| steps_ui(session, ui, requests));
    if !open || escaped(context) {
        requests.push(WindowRequest::Hide(Flag::History).into());
    }
}

fn steps_ui(session: Option<&Session>, ui: &mut Ui, requests: &mut Vec<Request>) {
    let Some(session) = session else {
        ui.weak("Open a project first.");
        return;
    };
    let (names, done) = session.history.names();
    let names: Vec<&str> = names.collect();
    ui.weak("A click undoes or redoes steps up to there; the steps that are undone are grey.");
    long_list(ui, "history", HEIGHT, names.len() + 1, |ui, place| {
        let name = place.checked_sub(1).map_or("project as opened", |step| names[step]);
        let text = RichText::new(name);
        let text = if place > done { text.weak() } else { text };
        if ui.add(Button::selectable(place == done, text).truncate()).clicked() && place != done {
            requests.push(DecideRequest::GoToStep(place).into());
        }
    });
}
