//! The inspector: what to do next with the selection, and facts about it.

use eframe::egui::{ScrollArea, Ui};

use super::inspect::details_ui;
use super::inspect::layer::layer_page;
use super::inspect::next::{next_ui, site_steps_ui};
use super::inspect::surface::{face_page, object_page};
use super::inspect::tree::tree_page;
use super::inspect::trees::trees_page;
use super::inspect::view::InspectorView;
use super::{button, counted, grouped, layer_options, masks, percent, title};
use crate::command::{paint, view};
use crate::state::next_steps::NextStep;
use crate::state::request::{DecideRequest, Request};
use crate::state::selection::Selection;
use crate::state::session::Session;
use quadratura_base::scene::PhotoId;
use quadratura_document::Stack;
use quadratura_stacks::decide::decided;
use quadratura_stacks::layer_table::LayerFigures;

/// Draws the inspector.
pub fn inspector_ui(ui: &mut Ui, view: &InspectorView<'_>, requests: &mut Vec<Request>) {
    ui.add_space(4.0);
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| match view.selection.main {
        Selection::Object(object) => object_page(ui, view, object, requests),
        Selection::Face(face) => face_page(ui, view, face, requests),
        Selection::Layer { photo, layer } => layer_page(ui, view, photo, layer, requests),
        Selection::Tree(tree) => tree_page(ui, view, tree, requests),
        Selection::Trees => trees_page(ui, view, requests),
        Selection::Nothing | Selection::Photo(_) => {
            let Some(session) = view.session else { return };
            match view.selection.main {
                Selection::Photo(photo) => {
                    photo_ui(view, session, photo, ui, requests);
                }
                _ => nothing(view, session, ui, requests),
            }
        }
    });
}

fn nothing(view: &InspectorView<'_>, session: &Session, ui: &mut Ui, requests: &mut Vec<Request>) {
    title(ui, "Project", &session.name());
    let model = session.model();
    let built = session.photos.iter().filter(|photo| photo.is_current()).count();
    ui.weak(format!("{} · {built} built", counted(session.photos.len() as u64, "photo")));
    site_steps_ui(view, None, ui, requests);
    ui.label("Click a photo, an object or a layer to see its properties, and what to do next with it.");
    let project = &session.opened.project;
    let facts = [
        ("Objects", grouped(model.objects.len() as u64)),
        ("Faces", grouped(model.faces.len() as u64)),
        ("Photos from", project.photos.clone()),
        ("Cameras from", project.cameras.clone()),
        ("Model from", project.model.clone()),
    ];
    details_ui(ui, &facts);
}

fn photo_ui(
    view: &InspectorView<'_>,
    session: &Session,
    id: PhotoId,
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    let photo = session.opened.site.photo(id);
    title(ui, "Photo", &photo.name);
    next_ui(view, session, id, ui, requests);
    masks::masks_ui(view, id, ui, requests);
    decisions(session, &photo.name, ui, requests);
    ui.add_space(8.0);
    ui.horizontal_wrapped(|ui| {
        button(view.commands, ui, &view::SNAP, requests);
        // Where areas are hidden, this is among what to do next.
        let paints = session.next_steps(id, view.fill).iter().any(|step| matches!(step, NextStep::Paint(_)));
        if session.stack_of(id).is_some() && !paints {
            button(view.commands, ui, &paint::EDIT, requests);
        }
    });
    ui.add_space(4.0);
    layer_options::photo_options_ui(view.commands, session, &photo.name, ui, requests);
    details_ui(ui, &facts(session, id));
}

/// Returns what is known about a photo and its stack.
fn facts(session: &Session, id: PhotoId) -> Vec<(&'static str, String)> {
    let camera = &session.opened.site.photo(id).camera;
    let status = &session.photos[id.index()];
    let field = 2.0 * (f64::from(camera.height) / 2.0 / camera.fy).atan().to_degrees();
    let mut facts = vec![
        ("Size", format!("{} × {} px", camera.width, camera.height)),
        ("Focal length", format!("{:.1} px", camera.fx)),
        ("Field of view", format!("{field:.1}° high")),
    ];
    if let Some(stack) = &status.stack {
        let own = u64::from(camera.width) * u64::from(camera.height);
        facts.push(("Visibility layers", stack.visibility_layers.len().to_string()));
        facts.push(("Image layers", image_layers(stack)));
        facts
            .push(("Texels", format!("{} ({:.2} × photo)", grouped(stack.texels), ratio(stack.texels, own))));
        facts.push(("Used", percent(stack.texels_used, stack.texels)));
        if let Some(LayerFigures { hidden, filled, used, .. }) = status.figures() {
            facts.push(("Hidden", format!("{} ({})", grouped(hidden), percent(hidden, used))));
            facts.push(("Filled", percent(filled, hidden)));
        }
    }
    facts
}

/// Formats the number of image layers and of depths. An image layer with surfaces of several visibility layers lies
/// behind all that occlude any of them, so there are more depths than visibility layers.
fn image_layers(stack: &Stack) -> String {
    let count = stack.image_layers.len();
    let depths = stack.image_layers.last().map_or(0, |deepest| u64::from(deepest.order) + 1);
    format!("{count}, at {}", counted(depths, "depth"))
}

fn ratio(part: u64, all: u64) -> f64 {
    part as f64 / all.max(1) as f64
}

/// Draws the decisions about a photo, each with a button to remove it.
fn decisions(session: &Session, name: &str, ui: &mut Ui, requests: &mut Vec<Request>) {
    let Some(decisions) = session.opened.project.decisions.photos.get(name) else { return };
    ui.add_space(8.0);
    ui.strong("Decisions");
    for decision in decided(decisions) {
        ui.horizontal_wrapped(|ui| {
            if ui.small_button("Remove").on_hover_text("Removes this decision.").clicked() {
                requests.push(Request::Decide(DecideRequest::Forget(name.to_owned(), decision.number)));
            }
            ui.label(&decision.text);
        });
    }
}
