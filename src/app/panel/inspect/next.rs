//! The beginning of the pages of a photo, an object and the project: what to do next.

use eframe::egui::{Button, Ui};

use crate::command::{Command, first_keys, layers, mask, paint};
use crate::panel::inspect::view::InspectorView;
use crate::panel::{button, counted};
use crate::state::next_steps::{HiddenAreas, NextStep, SiteAreas, SiteStep};
use crate::state::request::{QualityRequest, Request, SelectRequest};
use crate::state::selection::Selection;
use crate::state::session::Session;
use quadratura_base::scene::{ObjectId, PhotoId};
use quadratura_stacks::layer_table::LayerFigures;

/// Draws a photo's state in a line, and below it what to do next.
pub fn next_ui(
    view: &InspectorView<'_>,
    session: &Session,
    photo: PhotoId,
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    let status = &session.photos[photo.index()];
    if status.stack.as_ref().is_some_and(|stack| stack.image_layers.iter().any(|layer| layer.fill.is_some()))
    {
        // By these it is known what is painted already.
        requests.push(QualityRequest::WantShares(photo).into());
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
    let steps = session.next_steps(photo, view.fill);
    if steps.is_empty() {
        return;
    }
    ui.add_space(6.0);
    ui.strong("Next");
    for step in &steps {
        step_ui(view, session, photo, step, ui, requests);
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
    view: &InspectorView<'_>,
    session: &Session,
    photo: PhotoId,
    step: &NextStep,
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    let mut say = |ui: &mut Ui, text: &str, commands: &[&'static Command]| {
        ui.label(text);
        ui.horizontal_wrapped(|ui| {
            commands.iter().for_each(|command| button(view.commands, ui, command, requests))
        });
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
            paint_ui(session, photo, areas, ui, requests);
            ui.horizontal_wrapped(|ui| button(view.commands, ui, &paint::EDIT, requests));
        }
    }
}

/// Draws what to do next with all photos, or with what they show of an object.
pub fn site_steps_ui(
    view: &InspectorView<'_>,
    object: Option<ObjectId>,
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    let Some(session) = view.session else { return };
    ui.add_space(6.0);
    ui.strong("Next");
    let steps = session.next_steps_of_site(object, view.fill, &view.selection.facts);
    let photos = |count: usize| counted(count as u64, "photo");
    for step in &steps {
        match step {
            SiteStep::Build(count) => {
                // The view or the list of photos has the button.
                let keys = first_keys(ui.ctx(), &layers::BUILD);
                ui.label(format!("Build the layers of {} ({keys}).", photos(*count)));
            }
            SiteStep::Fill(count) => {
                ui.label(format!("The occluded areas of {} are empty.", photos(*count)));
                button(view.commands, ui, &layers::FILL, requests);
            }
            SiteStep::Paint(areas) => areas_ui(session, areas, ui, requests),
            SiteStep::Cover(count) => {
                let text = "not covered by any photo: the list of faces marks them; a click says why.";
                let are = if *count == 1 { "is" } else { "are" };
                ui.label(format!("{} {are} {text}", counted(*count as u64, "face")));
            }
        }
        ui.add_space(4.0);
    }
    if steps.is_empty() {
        let what = if object.is_some() { "The photos show all of it" } else { "All layers are filled" };
        ui.label(format!("{what}, and no large hidden area is left to paint."));
    }
}

/// Draws the largest hidden areas of several photos, each with a button that selects its layer.
fn areas_ui(session: &Session, areas: &SiteAreas, ui: &mut Ui, requests: &mut Vec<Request>) {
    let largest = if areas.count > areas.largest.len() { ", the largest first" } else { "" };
    let (count, photos) = (counted(areas.count as u64, "hidden area"), counted(areas.photos as u64, "photo"));
    ui.label(format!("Paint {count} in {photos}{largest}:"));
    for (photo, layer, share) in &areas.largest {
        let Some(stack) = session.stack_of(*photo) else { continue };
        let it = stack.layer(*layer);
        if it.fill.is_some() {
            // By these it is known what is painted already.
            requests.push(QualityRequest::WantShares(*photo).into());
        }
        let name = format!("{}: {}", session.opened.site.photo(*photo).name, it.name);
        area_ui(ui, &name, Selection::Layer { photo: *photo, layer: *layer }, *share, requests);
    }
}

/// Draws a hidden area with a button that selects its layer.
fn area_ui(ui: &mut Ui, name: &str, layer: Selection, share: f64, requests: &mut Vec<Request>) {
    let share = format!("{:.0} % hidden", 100.0 * share);
    let row = Button::selectable(false, name).right_text(share).truncate();
    let row = ui.add(row.min_size([ui.available_width(), 0.0].into()));
    if row.on_hover_text(format!("Selects this image layer: {name}")).clicked() {
        requests.push(SelectRequest::Only(layer).into());
    }
}

/// Draws the layers to paint, each with a button that selects it.
fn paint_ui(
    session: &Session,
    photo: PhotoId,
    areas: &HiddenAreas,
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    let Some(stack) = session.stack_of(photo) else { return };
    let largest = if areas.count > areas.largest.len() { ", the largest first" } else { "" };
    ui.label(format!("Paint {}{largest}:", counted(areas.count as u64, "hidden area")));
    for (layer, share) in &areas.largest {
        let Some(it) = stack.image_layers.get(layer.index()) else { continue };
        area_ui(ui, &it.name, Selection::Layer { photo, layer: *layer }, *share, requests);
    }
}
