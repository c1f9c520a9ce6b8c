//! The list of layers whose occluded areas are most visible, from chosen viewpoints.

use eframe::egui::{ComboBox, Grid, Ui};

use super::not_there;
use crate::panel::fill::FillView;
use crate::panel::{NameCell, counted, name_cell, percent, room_for_names};
use crate::state::quality::filling::Worst;
use crate::state::request::{QualityRequest, Request, SelectRequest, SpaceRequest};
use crate::state::selection::Selection;
use crate::state::session::Session;
use crate::widget::elide::beside;
use quadratura_stacks::fill::viewpoints::{Viewpoints, bookmark_count};
use quadratura_stacks::fill::worst::HiddenLayer;

/// The number of listed layers: the areas of the others are hardly visible.
const WORST: usize = 24;
/// The width of the columns beside the names, in points, with the gaps.
const BESIDE_NAMES: f32 = 54.0 + 46.0 + 24.0;
/// The width of the choice of viewpoints, in points, with its label.
const SEEN_FROM: f32 = 190.0;

/// Draws the list.
pub fn worst_ui(view: &FillView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    ui.strong("Worst first").on_hover_text(
        "Sorted by hidden area times its visibility in the views: the most noticeable layers first.",
    );
    choose(view, ui, requests);
    let Some(session) = view.session else { return };
    let lookup = &view.fill.worst;
    let Some(worst) = lookup.found() else { return not_there(lookup.failed(view.running), ui) };
    if worst.layers.is_empty() {
        ui.weak("No occluded areas are visible in these views.");
        return;
    }
    let names = room_for_names(ui, BESIDE_NAMES);
    Grid::new("worst").num_columns(3).spacing([8.0, 4.0]).striped(true).show(ui, |ui| {
        ui.weak("Layer");
        ui.weak("Visible").on_hover_text("Share of everything that is visible in the views.");
        ui.weak("Filled").on_hover_text("Share of the layer's hidden area that is filled.");
        ui.end_row();
        let listed = &worst.layers[..worst.layers.len().min(WORST)];
        let texts: Vec<String> = listed.iter().map(|hidden| text_of(session, hidden)).collect();
        for (index, hidden) in listed.iter().enumerate() {
            let others = beside(index, |place| texts.get(place).map(String::as_str));
            let cell = NameCell { name: &texts[index], others: &others, width: names };
            row(view, worst, hidden, &cell, ui, requests);
        }
    });
    let more = worst.layers.len().saturating_sub(WORST);
    if more > 0 {
        ui.weak(format!("{} more are less visible.", counted(more as u64, "layer")));
    }
}

/// Draws the choice of viewpoints.
fn choose(view: &FillView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    let Some(session) = view.session else { return };
    let (kept, photos) = (bookmark_count(&session.opened.project), session.photos.len());
    if kept == 0 && view.fill.viewpoints.is_none() {
        ui.weak(
            "Seen from the photos' cameras. Add bookmarks (Ctrl+D) or keyframes (K) to use those instead.",
        );
        return;
    }
    let name = |viewpoints: Viewpoints| match viewpoints {
        Viewpoints::Kept => format!("bookmarks and keyframes ({kept})"),
        Viewpoints::Photos => format!("the photos' cameras ({photos})"),
    };
    let now = view.fill.seen_from(&session.opened.project);
    let mut chosen = now;
    ui.horizontal_wrapped(|ui| {
        let label = ui.label("Seen from");
        let width = SEEN_FROM.min(ui.max_rect().width());
        let list = ComboBox::from_id_salt("seen from").selected_text(name(now)).width(width).truncate();
        let list = list.show_ui(ui, |ui| {
            for viewpoints in [Viewpoints::Kept, Viewpoints::Photos] {
                ui.selectable_value(&mut chosen, viewpoints, name(viewpoints));
            }
        });
        list.response.labelled_by(label.id);
    });
    if chosen != now {
        requests.push(QualityRequest::SeeFrom(chosen).into());
    }
    if chosen == Viewpoints::Kept && kept == 0 {
        ui.weak("There are no bookmarks or keyframes: Ctrl+D adds a bookmark, K a keyframe.");
    }
}

/// Returns what a layer is called in the list; empty where its stack is another one by now.
fn text_of(session: &Session, hidden: &HiddenLayer) -> String {
    let stack = session.stack_of(hidden.photo);
    let layer = stack.and_then(|stack| stack.image_layers.get(hidden.layer.index()));
    let photo = &session.opened.site.photo(hidden.photo).name;
    layer.map_or(String::new(), |layer| format!("{} – {photo}", layer.name))
}

fn row(
    view: &FillView<'_>,
    worst: &Worst,
    hidden: &HiddenLayer,
    cell: &NameCell<'_>,
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    if cell.name.is_empty() {
        return;
    }
    let this = Selection::Layer { photo: hidden.photo, layer: hidden.layer };
    let response = name_cell(ui, view.selection.main == this, cell);
    let view = worst.views.get(hidden.view.0);
    if response.double_clicked() {
        requests.extend(view.cloned().map(|view| Request::Space(SpaceRequest::LookFrom(Box::new(view)))));
    } else if response.clicked() {
        requests.push(Request::Select(SelectRequest::Only(this)));
    }
    if let Some(view) = view {
        response.on_hover_text(format!("Most visible from {}: a double click flies there.", view.name));
    }
    ui.label(format!("{:.2} %", 100.0 * hidden.seen));
    ui.label(percent(hidden.filled, hidden.hidden));
    ui.end_row();
}
