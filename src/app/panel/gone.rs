//! Photos that have layers and whose files are gone: they stay in the list of photos, with a way to find them.

use eframe::egui::{Label, RichText, Ui};

use super::link_ui;
use crate::state::request::{ProjectRequest, Request};
use crate::state::session::Session;

/// The number of photos that are named; the dialog lists all.
const MOST: usize = 4;

/// Draws a line for each photo that is gone.
pub fn gone_ui(ui: &mut Ui, session: &Session, requests: &mut Vec<Request>) {
    for (photo, reason) in session.gone.iter().take(MOST) {
        ui.horizontal(|ui| {
            locate_ui(ui, requests);
            ui.colored_label(ui.visuals().error_fg_color, "missing");
            ui.add(Label::new(RichText::new(photo).strong()).truncate()).on_hover_text(reason);
        });
    }
    if let Some(more) = session.gone.len().checked_sub(MOST).filter(|more| *more > 0) {
        ui.weak(format!("and {more} more are missing"));
    }
}

/// Draws the link to the dialog of missing files.
pub fn locate_ui(ui: &mut Ui, requests: &mut Vec<Request>) {
    let tooltip = "Chooses the file, or the folder in which the photos are now.";
    if link_ui(ui, "Locate…").on_hover_text(tooltip).clicked() {
        requests.push(ProjectRequest::ShowMissing.into());
    }
}
