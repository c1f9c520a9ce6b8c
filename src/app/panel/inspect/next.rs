//! The beginning of a photo's page: what to do next with it.

use eframe::egui::{Button, Ui};

use crate::app::command::{Command, layers, mask, paint};
use crate::app::panel::{button, counted};
use crate::app::state::State;
use crate::app::state::ask::{Ask, QualityAsk, SelectAsk};
use crate::app::state::next_steps::{HiddenAreas, NextStep};
use crate::app::state::selection::Selection;
use crate::app::state::session::Session;
use crate::recipe::layer_table::LayerFigures;
use crate::scene::PhotoId;

/// Draws a photo's state in a line, and below it what to do next.
pub fn next_ui(state: &State, session: &Session, photo: PhotoId, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let status = &session.photos[photo.index()];
    if status.stack.as_ref().is_some_and(|stack| stack.image_layers.iter().any(|layer| layer.fill.is_some()))
    {
        // By these it is known what is painted already.
        asks.push(QualityAsk::WantShares(photo).into());
    }
    let mut words = vec![status.word.to_owned()];
    if let (Some(stack), Some(figures)) = (&status.stack, status.figures()) {
        words.push(counted(stack.image_layers.len() as u64, "image layer"));
        words.push(hidden_words(&figures));
    }
    ui.weak(words.join(" · "));
    if let Some(problem) = &status.problem {
        ui.colored_label(ui.visuals().error_fg_color, problem);
    }
    let steps = state.next_steps(photo);
    if steps.is_empty() {
        return;
    }
    ui.add_space(6.0);
    ui.strong("Next");
    for step in &steps {
        step_ui(state, session, photo, step, ui, asks);
        ui.add_space(4.0);
    }
}

/// Describes how much of one or several layers is hidden.
pub fn hidden_words(figures: &LayerFigures) -> String {
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    match figures.filled_share() {
        None => "nothing hidden".into(),
        Some(0.0) => format!("{} hidden", percent(figures.hidden_share())),
        Some(filled) => {
            format!("{} hidden, {} of that filled", percent(figures.hidden_share()), percent(filled))
        }
    }
}

fn step_ui(
    state: &State,
    session: &Session,
    photo: PhotoId,
    step: &NextStep,
    ui: &mut Ui,
    asks: &mut Vec<Ask>,
) {
    let mut say = |ui: &mut Ui, text: &str, commands: &[&'static Command]| {
        ui.label(text);
        ui.horizontal_wrapped(|ui| commands.iter().for_each(|command| button(state, ui, command, asks)));
    };
    match step {
        NextStep::Build { again: false } => {
            say(ui, "It has no layers yet.", &[&layers::BUILD_PHOTO]);
        }
        NextStep::Build { again: true } => {
            say(ui, "Its layers are out of date.", &[&layers::BUILD_PHOTO]);
        }
        NextStep::Fill => say(ui, "Its occluded areas are empty.", &[&layers::FILL]),
        NextStep::Mask => {
            let text = "Mask what is not part of the site, such as people and cars.";
            say(ui, text, &[&mask::BRUSH, &mask::LASSO, &mask::LOOK]);
        }
        NextStep::Paint(areas) => {
            paint_ui(session, photo, areas, ui, asks);
            ui.horizontal_wrapped(|ui| button(state, ui, &paint::EDIT, asks));
        }
    }
}

/// Draws the layers to paint, each with a button that selects it.
fn paint_ui(session: &Session, photo: PhotoId, areas: &HiddenAreas, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let Some(stack) = session.stack_of(photo) else { return };
    let largest = if areas.count > areas.largest.len() { ", the largest first" } else { "" };
    ui.label(format!("Paint {}{largest}:", counted(areas.count as u64, "hidden area")));
    for (layer, share) in &areas.largest {
        let Some(it) = stack.image_layers.get(layer.index()) else { continue };
        let share = format!("{:.0} % hidden", 100.0 * share);
        let row = Button::selectable(false, &it.name).right_text(share).truncate();
        let row = ui.add(row.min_size([ui.available_width(), 0.0].into()));
        if row.on_hover_text("Selects this image layer.").clicked() {
            asks.push(SelectAsk::Only(Selection::Layer { photo, layer: *layer }).into());
        }
    }
}
