//! The view of one image layer: its rectangle on a checkerboard, with its pixels, missing texels, confidence and
//! provenance.

pub mod shown;
mod tools;

use eframe::egui::{CentralPanel, Panel, Rect, Role, Sense, Spinner, Stroke, StrokeKind, Ui, WidgetInfo};

use super::flat::hatch::hatch;
use super::flat::placement::{PlacedPicture, screen_rect};
use super::flat::{FlatTextures, LeftButton, background, navigate, nothing_ui};
use crate::state::State;
use crate::state::flat::layer::{LayerKey, LayerPane};
use crate::state::request::{FlatRequest, Request};
use crate::widget::behind::behind_ui;
use crate::widget::focus::{FocusKind, mark};
use quadratura_base::geometry::PixelRect;

/// Draws the view and handles its input.
pub fn layer_ui(
    ui: &mut Ui,
    state: &State,
    pane: &mut LayerPane,
    textures: &mut FlatTextures,
    requests: &mut Vec<Request>,
) {
    let Some((key, layer)) = state.looked_at_layer(pane) else {
        return nothing_ui(
            ui,
            "Select an image layer in the list, or click one in the photo, to see it here.",
        );
    };
    Panel::top("layer tools").show(ui, |ui| tools::tools_ui(ui, state, pane, &layer, requests));
    Panel::bottom("layer status").show(ui, |ui| tools::status_ui(ui, state, pane, &key, &layer));
    CentralPanel::no_frame().show(ui, |ui| canvas_ui(ui, state, pane, &key, layer.rect, textures));
    requests.push(FlatRequest::WantImageLayer.into());
}

fn canvas_ui(
    ui: &mut Ui,
    state: &State,
    pane: &mut LayerPane,
    key: &LayerKey,
    bounds: PixelRect,
    textures: &mut FlatTextures,
) {
    let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "Image layer view"));
    mark(&response, FocusKind::View);
    let fill = background(ui);
    ui.painter_at(rect).rect_filled(rect, 0.0, fill);
    pane.view.rect = Some(screen_rect(rect));
    let seen = navigate(&mut pane.view.placement, ui, &response, rect, bounds, LeftButton::Moves);
    pane.pixel = response.hover_pos().map(|at| seen.pixel(at));
    draw(ui, state, &seen, key, bounds, textures);
}

fn draw(
    ui: &mut Ui,
    state: &State,
    seen: &PlacedPicture,
    key: &LayerKey,
    bounds: PixelRect,
    textures: &mut FlatTextures,
) {
    let painter = ui.painter_at(seen.rect);
    let frame = seen.rect_of(bounds);
    textures.checkerboard.draw(&painter, frame.intersect(seen.rect));
    let (version, index, _) = key;
    let made = &state.flat.loading.image_layers;
    let exact = made.get(key);
    // Another aspect of the same layer is shown until this one is made.
    if let Some(view) = exact.or_else(|| made.last(|(other, at, _)| other == version && at == index)) {
        textures.pictures.of(&view.levels).draw(&painter, seen, (bounds.x, bounds.y));
        if state.flat.switches.hatching {
            hatch(&painter, seen, &view.hidden);
        }
    }
    let is_behind = exact.is_none() && !made.has_failed(key);
    behind_ui(ui, seen.rect, is_behind);
    if is_behind && made.last(|(other, at, _)| other == version && at == index).is_none() {
        ui.put(Rect::from_center_size(seen.rect.center(), [32.0, 32.0].into()), Spinner::new().size(32.0));
    }
    let stroke = Stroke::new(1.0, ui.visuals().weak_text_color());
    painter.rect_stroke(frame, 0.0, stroke, StrokeKind::Outside);
}
