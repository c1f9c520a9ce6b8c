//! The list of faces without texture from the photo, each with the reason; a click shows the face.

use eframe::egui::{Button, ComboBox, RichText, Ui};
use glam::DVec2;

use crate::app::panel::{long_list, named};
use crate::app::state::State;
use crate::app::state::ask::{Ask, SelectAsk};
use crate::app::state::flat::photo::PhotoPane;
use crate::app::state::selection::Selection;
use crate::app::state::session::Session;
use crate::document::stack::{Untextured, UntexturedReason};
use crate::recipe::survey::face_named;
use crate::recipe::untextured::{REASONS, untextured, words};
use crate::scene::PhotoId;

/// Returns the faces without texture from a photo whose layers are built.
fn listed(session: &Session, photo: PhotoId) -> Option<Vec<Untextured>> {
    let stack = session.stack_of(photo)?;
    let decided = session.history.present().decisions.of(&session.opened.site.photo(photo).name);
    Some(untextured(stack, &decided))
}

/// Draws the list.
pub fn reasons_ui(ui: &mut Ui, state: &State, pane: &mut PhotoPane, photo: PhotoId, asks: &mut Vec<Ask>) {
    ui.add_space(4.0);
    ui.strong("Faces without texture from this photo");
    let Some(faces) = state.session.as_ref().and_then(|session| listed(session, photo)) else {
        ui.weak("This list is available when the photo's layers are built.");
        return;
    };
    let faces: Vec<&Untextured> = faces.iter().collect();
    choose(ui, &mut pane.reason, &faces);
    let wanted = pane.reason;
    let is_wanted = |face: &&Untextured| wanted.is_none_or(|reason| face.reason == reason);
    let listed: Vec<&Untextured> = faces.into_iter().filter(is_wanted).collect();
    if listed.is_empty() {
        ui.weak(match wanted {
            None => "None: this photo textures every face.",
            Some(_) => "None for this reason.",
        });
        return;
    }
    long_list(ui, "untextured", f32::INFINITY, listed.len(), |ui, layer_index| {
        row(ui, state, pane, listed[layer_index], asks);
    });
}

fn choose(ui: &mut Ui, filter: &mut Option<UntexturedReason>, faces: &[&Untextured]) {
    let count = |reason: Option<UntexturedReason>| {
        faces.iter().filter(|face| reason.is_none_or(|reason| face.reason == reason)).count()
    };
    let text = |reason: Option<UntexturedReason>| {
        let name = reason.map_or("all reasons", words);
        format!("{name} ({})", count(reason))
    };
    let width = ui.available_width() - 16.0;
    let combo = ComboBox::from_id_salt("reason").selected_text(text(*filter)).width(width);
    let combo = combo.show_ui(ui, |ui| {
        ui.selectable_value(filter, None, text(None));
        for reason in REASONS.into_iter().filter(|reason| count(Some(*reason)) > 0) {
            ui.selectable_value(filter, Some(reason), text(Some(reason)));
        }
    });
    named(&combo.response, "Reason");
}

fn row(ui: &mut Ui, state: &State, pane: &mut PhotoPane, it: &Untextured, asks: &mut Vec<Ask>) {
    let Some(session) = &state.session else { return };
    let face = session.model().face_named(&it.object, it.face);
    let selected = face.is_some_and(|face| state.selection == Selection::Face(face));
    let mut gone_to = false;
    ui.horizontal(|ui| {
        let name = format!("{}[{}]", it.object, it.face);
        let button = ui.add_enabled(face.is_some(), Button::selectable(selected, name));
        gone_to = button.on_disabled_hover_text("The face is no longer in the model.").clicked();
        match &it.by {
            Some(by) => {
                ui.weak("hidden by");
                let front = face_named(session.model(), by).ok();
                if ui.link(by).on_hover_text("Selects the face in front.").clicked() {
                    asks.extend(front.map(|front| Ask::Select(SelectAsk::Only(Selection::Face(front)))));
                }
            }
            None => {
                ui.label(RichText::new(words(it.reason)).weak());
            }
        }
    });
    if let Some(face) = face.filter(|_| gone_to) {
        asks.push(Ask::Select(SelectAsk::Only(Selection::Face(face))));
        let at = it.at.map(|[x, y]| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        pane.go_to(face, at);
    }
}
