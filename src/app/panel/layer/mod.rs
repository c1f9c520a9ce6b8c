//! The view of one image layer: its rectangle on a checkerboard, with its pixels, missing texels, confidence and
//! provenance.

pub mod shown;
mod tools;

use eframe::egui::{CentralPanel, Panel, Rect, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo};

use super::flat::hatch::hatch;
use super::flat::placement::{PlacedPicture, screen_rect};
use super::flat::{FlatTextures, LeftButton, background, navigate, nothing_ui};
use crate::command::Commands;
use crate::state::State;
use crate::state::flat::FlatViews;
use crate::state::flat::layer::{LayerKey, LayerPane};
use crate::state::request::{FlatRequest, Request};
use crate::state::session::Session;
use crate::widget::behind::behind_ui;
use crate::widget::focus::{FocusKind, mark};
use crate::widget::spinner::Spinner;
use quadratura_base::geometry::PixelRect;

/// What the view of an image layer shows.
pub struct LayerPaneView<'a> {
    /// The commands that the panel offers.
    commands: Commands<'a>,
    /// The open project.
    session: Option<&'a Session>,
    /// The flat views.
    flat: &'a FlatViews,
}

impl<'a> LayerPaneView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self { commands: Commands::of(state), session: state.session.as_ref(), flat: &state.flat }
    }
}

/// Draws the view and handles its input.
pub fn layer_ui(
    ui: &mut Ui,
    view: &LayerPaneView<'_>,
    pane: &mut LayerPane,
    textures: &mut FlatTextures,
    requests: &mut Vec<Request>,
) {
    let looked_at = view.session.and_then(|session| view.flat.looked_at_layer(session, pane));
    let Some((key, layer)) = looked_at else {
        return nothing_ui(
            ui,
            "Select an image layer in the list, or click one in the photo, to see it here.",
        );
    };
    Panel::top("layer tools").show(ui, |ui| tools::tools_ui(ui, view, pane, &layer, requests));
    Panel::bottom("layer status").show(ui, |ui| tools::status_ui(ui, view, pane, &key, &layer));
    CentralPanel::no_frame().show(ui, |ui| canvas_ui(ui, view, pane, &key, layer.rect, textures));
    requests.push(FlatRequest::WantImageLayer.into());
}

fn canvas_ui(
    ui: &mut Ui,
    view: &LayerPaneView<'_>,
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
    draw(ui, view, &seen, key, bounds, textures);
}

fn draw(
    ui: &mut Ui,
    view: &LayerPaneView<'_>,
    seen: &PlacedPicture,
    key: &LayerKey,
    bounds: PixelRect,
    textures: &mut FlatTextures,
) {
    let painter = ui.painter_at(seen.rect);
    let frame = seen.rect_of(bounds);
    textures.checkerboard.draw(&painter, frame.intersect(seen.rect));
    let (version, index, _) = key;
    let made = &view.flat.loading.image_layers;
    let exact = made.get(key);
    // Another aspect of the same layer is shown until this one is made.
    if let Some(made) = exact.or_else(|| made.last(|(other, at, _)| other == version && at == index)) {
        textures.pictures.of(&made.levels).draw(&painter, seen, (bounds.x, bounds.y));
        if view.flat.switches.hatching {
            hatch(&painter, seen, &made.hidden);
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
