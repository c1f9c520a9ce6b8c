//! The inspector page of one or several image layers: cost, contents and decisions.

use eframe::egui::{Button, Key, TextEdit, Ui};

use super::next::hidden_words;
use super::{LIST, details_ui};
use crate::command::{Command, edit, flat, paint};
use crate::panel::inspect::view::InspectorView;
use crate::panel::layer::shown::shown_ui;
use crate::panel::{button, counted, grouped, long_list, percent, rows, title};
use crate::state::request::{DecideRequest, QualityRequest, Request, SelectRequest};
use crate::state::selection::Selection;
use crate::state::session::Session;
use quadratura_base::scene::{FaceIndex, ObjectId, PhotoId};
use quadratura_document::decisions::overlap;
use quadratura_document::{Element, ImageLayer, Stack};
use quadratura_layers::{Faces, LayerIndex};
use quadratura_stacks::decide::{decided, faces_of_layer};
use quadratura_stacks::layer_table::LayerFigures;

/// Draws the page of the selected image layers of a photo; `layer` was selected last.
pub fn layer_page(
    ui: &mut Ui,
    view: &InspectorView<'_>,
    photo: PhotoId,
    layer: LayerIndex,
    requests: &mut Vec<Request>,
) {
    let (_, all) = view.selection.layers();
    if all.len() > 1 {
        several(view, photo, &all, ui, requests);
    } else {
        one(view, photo, layer, ui, requests);
    }
}

fn several(
    view: &InspectorView<'_>,
    photo: PhotoId,
    all: &[LayerIndex],
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    let Some(session) = view.session else { return };
    let Some(stack) = session.stack_of(photo) else {
        return;
    };
    let layers = || all.iter().filter_map(|index| stack.image_layers.get(index.index()));
    title(ui, "Selected", &format!("{} image layers", all.len()));
    let sum = LayerFigures::sum(layers().map(LayerFigures::from_layer));
    ui.weak(format!("{} · {}", stack.photo.name, hidden_words(&sum)));
    let mut facts = Vec::new();
    if let Some(cost) = session.merge_cost(photo, all) {
        let [width, height] = cost.size;
        let texels = grouped(cost.texels);
        facts.push(("Merged", format!("{width} × {height} px, {texels} texels ({:.1} ×)", cost.times())));
    }
    rows(ui, &facts);
    ui.add_space(6.0);
    ui.horizontal_wrapped(|ui| button(view.commands, ui, &edit::MERGE, requests));
    ui.add_space(6.0);
    ui.strong("Layers");
    long_list(ui, "selected layers", LIST, all.len(), |ui, index| {
        let Some(it) = stack.image_layers.get(all[index].index()) else { return };
        if ui.add(Button::selectable(false, &it.name).truncate()).clicked() {
            requests
                .push(Request::Select(SelectRequest::Only(Selection::Layer { photo, layer: all[index] })));
        }
    });
    details_ui(ui, &figures(&sum));
}

fn one(
    view: &InspectorView<'_>,
    photo: PhotoId,
    layer: LayerIndex,
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    let filled = stack_of(view, photo).and_then(|stack| stack.image_layers.get(layer.index())?.fill.as_ref());
    if filled.is_some() {
        requests.push(QualityRequest::WantShares(photo).into());
    }
    let (Some(session), Some(stack)) = (view.session, stack_of(view, photo)) else { return };
    let Some(it) = stack.image_layers.get(layer.index()) else { return };
    title(ui, "Image layer", &it.name);
    let figures = LayerFigures::from_layer(it);
    let deepest = stack.image_layers.last().map_or(it.order, |last| last.order);
    let name = &session.opened.site.photo(photo).name;
    ui.weak(format!("{name} · depth {} · {}", depth(it.order, deepest), hidden_words(&figures)));
    if !session.photos[photo.index()].is_current() {
        let text = "This layer is out of date, because the project has changed: build the photo again.";
        ui.colored_label(ui.visuals().warn_fg_color, text);
    }
    ui.add_space(6.0);
    let commands = |ui: &mut Ui, requests: &mut Vec<Request>, commands: &[&'static Command]| {
        ui.horizontal_wrapped(|ui| {
            commands.iter().for_each(|command| button(view.commands, ui, command, requests))
        });
    };
    if figures.hidden > 0 {
        ui.strong("Next");
        ui.label("Paint what the photo does not show of it.");
    }
    commands(ui, requests, &[&paint::EDIT, &flat::SHOW_LAYER]);
    ui.add_space(6.0);
    rename(it, photo, layer, ui, requests);
    shown_ui(&view.flat.layer_views, ui, photo, layer, it, requests);
    ui.add_space(4.0);
    commands(ui, requests, &[&edit::MERGE, &edit::SPLIT, &edit::PIN, &edit::EXCLUDE]);
    decisions(session, photo, &faces_of_layer(stack, layer), ui, requests);
    ui.add_space(6.0);
    held(session, stack, it, ui, requests);
    details_ui(ui, &facts(view, stack, photo, layer, it));
}

fn stack_of<'a>(view: &InspectorView<'a>, photo: PhotoId) -> Option<&'a Stack> {
    view.session?.stack_of(photo).map(|stack| &**stack)
}

/// Formats the totals of one or several layers.
fn figures(sum: &LayerFigures) -> Vec<(&'static str, String)> {
    let of = |part: u64, all: u64| format!("{} ({})", grouped(part), percent(part, all));
    let mut facts = vec![
        ("Texels", grouped(sum.texels)),
        ("Used", of(sum.used, sum.texels)),
        ("Waste", of(sum.waste, sum.texels)),
        ("Hidden", of(sum.hidden, sum.used)),
    ];
    if sum.hidden > 0 {
        facts.push(("Filled", of(sum.filled, sum.hidden)));
    }
    facts
}

fn facts(
    view: &InspectorView<'_>,
    stack: &Stack,
    photo: PhotoId,
    layer: LayerIndex,
    it: &ImageLayer,
) -> Vec<(&'static str, String)> {
    let rect = it.rect;
    let mut facts = Vec::new();
    if let Some(own) = &it.own_name {
        facts.push(("Original name", own.clone()));
    }
    facts.extend(visibility(stack, it).map(|text| ("Visibility layers", text)));
    facts.push(("Rectangle", format!("{} × {} px at {}, {}", rect.w, rect.h, rect.x, rect.y)));
    facts.extend(figures(&LayerFigures::from_layer(it)));
    if let Some(shares) = view.fill.shares.get(&photo).and_then(|found| found.found()?.get(layer.index())) {
        if shares.confidence > 0.0 {
            facts.push(("Confidence of filling", format!("{:.2} of 1", shares.confidence)));
        }
        if shares.painted > 0 {
            facts.push(("Hidden, painted", grouped(shares.painted)));
        }
    }
    facts.push(("Token", it.id.clone()));
    facts
}

fn depth(order: u32, deepest: u32) -> String {
    format!("{} of {}, 1 nearest", order + 1, deepest + 1)
}

/// Formats the visibility layers of the photo that an image layer contains: `1`, `2 to 4`, counted from 1 as in the
/// photo view.
fn visibility(stack: &Stack, it: &ImageLayer) -> Option<String> {
    let mut first = 0;
    let mut held = Vec::new();
    for (index, elements) in stack.visibility_layers.iter().enumerate() {
        let range = first..first + elements.len() as u32;
        held.extend(it.elements.iter().any(|element| range.contains(&element.0)).then_some(index + 1));
        first = range.end;
    }
    match held[..] {
        [] => None,
        [only] => Some(only.to_string()),
        [first, .., last] => Some(format!("{first} to {last}")),
    }
}

/// Draws a field for the layer's name; the name is applied when the field loses the focus.
fn rename(it: &ImageLayer, photo: PhotoId, layer: LayerIndex, ui: &mut Ui, requests: &mut Vec<Request>) {
    let id = ui.make_persistent_id(("name of layer", photo, &it.id));
    let mut typed = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| it.name.clone());
    ui.horizontal(|ui| {
        let label = ui.label("Name");
        let field = TextEdit::singleline(&mut typed).desired_width(ui.available_width() - 16.0);
        let tooltip = "The layer's name; leave it empty to restore the original name.";
        let field = ui.add(field).on_hover_text(tooltip).labelled_by(label.id);
        if field.lost_focus() && typed != it.name && !ui.input(|input| input.key_pressed(Key::Escape)) {
            requests.push(Request::Decide(DecideRequest::Rename(photo, layer, typed.clone())));
        }
        if field.has_focus() {
            ui.data_mut(|data| data.insert_temp(id, typed));
        } else {
            ui.data_mut(|data| data.remove::<String>(id));
        }
    });
}

/// Draws the decisions about the layer's contents, each with a button to remove it.
fn decisions(session: &Session, photo: PhotoId, of: &[Faces], ui: &mut Ui, requests: &mut Vec<Request>) {
    let name = &session.opened.site.photo(photo).name;
    let all = decided(&session.history.present().decisions.of(name));
    let about = |decided: &quadratura_stacks::decide::ListedDecision| {
        decided.of.iter().any(|faces| of.iter().any(|held| overlap(faces, held)))
    };
    let all: Vec<_> = all.into_iter().filter(about).collect();
    if all.is_empty() {
        return;
    }
    ui.add_space(6.0);
    ui.strong("Decisions");
    for decision in all {
        ui.horizontal_wrapped(|ui| {
            if ui.small_button("Remove").on_hover_text("Removes this decision.").clicked() {
                requests.push(Request::Decide(DecideRequest::Forget(name.clone(), decision.number)));
            }
            ui.label(&decision.text);
        });
    }
}

/// Draws the objects and faces that the layer contains.
fn held(session: &Session, stack: &Stack, it: &ImageLayer, ui: &mut Ui, requests: &mut Vec<Request>) {
    let all: Vec<&Element> = stack.visibility_layers.iter().flatten().collect();
    let elements: Vec<&Element> =
        it.elements.iter().filter_map(|element| all.get(element.index()).copied()).collect();
    if stack.is_of_surroundings(it) {
        ui.label("Contains what the photo shows where no surface of the model is: sky, hills, far houses.");
        return;
    }
    let faces: usize = elements.iter().map(|element| element.all_faces().len()).sum();
    ui.strong(format!(
        "Contains {} of {}",
        counted(faces as u64, "face"),
        counted(elements.len() as u64, "element")
    ))
    .on_hover_text("An element consists of faces of one object that do not occlude each other.");
    long_list(ui, "held", LIST, elements.len(), |ui, index| {
        let element = elements[index];
        let faces = element.all_faces();
        let back = if element.back.is_empty() { "" } else { ", seen from the back" };
        let text = format!("{}: {}{back}", element.object, counted(faces.len() as u64, "face"));
        let known = session.model().object_named(&element.object);
        let button = ui.add_enabled(known.is_some(), Button::selectable(false, text).truncate());
        let button = button.on_disabled_hover_text("The object was removed, or is no longer in the model.");
        if button.on_hover_text(element.known_by().to_string()).clicked() {
            requests.extend(
                known
                    .and_then(|object| selected(session, object, &faces))
                    .map(|it| Request::Select(SelectRequest::Only(it))),
            );
        }
    });
}

/// Returns the object as a selection, or the face where the layer contains only one of several.
fn selected(session: &Session, object: ObjectId, faces: &[FaceIndex]) -> Option<Selection> {
    let it = session.model().object(object);
    match faces {
        [face] if it.faces.len() > 1 => it.face(*face).map(Selection::Face),
        _ => Some(Selection::Object(object)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_is_told_from_the_front() {
        assert_eq!(depth(0, 7), "1 of 8, 1 nearest");
        assert_eq!(depth(3, 7), "4 of 8, 1 nearest");
    }
}
