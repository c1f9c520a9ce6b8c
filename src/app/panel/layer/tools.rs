//! The bars above and below an image layer: aspect, legend, size and coverage.

use eframe::egui::{Color32, Sense, Ui, vec2};

use super::LayerPaneView;
use crate::command::{Command, flat};
use crate::panel::bar::{Bar, BarPart, BarPosition};
use crate::panel::flat::scale_ui;
use crate::panel::{grouped, percent, switch_ui, toggle_ui};
use crate::state::flat::layer::{Aspect, LayerKey, LayerPane};
use crate::state::request::Request;
use quadratura_document::ImageLayer;

/// The parts of the bar above, the most needed first.
fn parts<'a>() -> [BarPart<LayerPaneView<'a>, LayerPane>; 9] {
    [
        BarPart::Tool(|ui, _, pane, _, _| aspect(ui, &mut pane.aspect, Aspect::Pixels)),
        BarPart::Tool(|ui, _, pane, _, _| aspect(ui, &mut pane.aspect, Aspect::Confidence)),
        BarPart::Tool(|ui, _, pane, _, _| aspect(ui, &mut pane.aspect, Aspect::Provenance)),
        BarPart::Gap,
        BarPart::Switch(&flat::HATCHING),
        BarPart::Tool(|ui, view, pane, _, requests| {
            of_pixels(ui, view, pane.aspect, &flat::FILLING, requests)
        }),
        BarPart::Tool(|ui, view, pane, _, requests| of_pixels(ui, view, pane.aspect, &flat::PAINT, requests)),
        BarPart::Gap,
        BarPart::Tool(scale),
    ]
}

/// Returns the name and the tooltip of an aspect.
fn texts(aspect: Aspect) -> (&'static str, &'static str) {
    match aspect {
        Aspect::Pixels => ("Pixels", "Shows the layer's content."),
        Aspect::Confidence => ("Confidence", "Shows the confidence of its texels."),
        Aspect::Provenance => (
            "Provenance",
            "Shows where its texels come from: this photo, paint, other photos, or inpainting.",
        ),
    }
}

/// Draws the bar above.
pub fn tools_ui(
    ui: &mut Ui,
    view: &LayerPaneView<'_>,
    pane: &mut LayerPane,
    layer: &ImageLayer,
    requests: &mut Vec<Request>,
) {
    let (name, commands) = (Some(&layer.name[..]), view.commands);
    Bar { of: "image layer", name, parts: &parts(), commands, view }.show(ui, pane, requests);
    ui.horizontal_wrapped(|ui| facts(ui, layer));
}

fn aspect(ui: &mut Ui, now: &mut Aspect, aspect: Aspect) {
    let (name, tooltip) = texts(aspect);
    if switch_ui(ui, *now == aspect, name).on_hover_text(tooltip).clicked() {
        *now = aspect;
    }
}

/// Draws a switch that applies to the pixels only; the other aspects do not use it.
fn of_pixels(
    ui: &mut Ui,
    view: &LayerPaneView<'_>,
    now: Aspect,
    command: &'static Command,
    requests: &mut Vec<Request>,
) {
    ui.add_enabled_ui(now == Aspect::Pixels, |ui| toggle_ui(view.commands, ui, command, requests));
}

fn scale(
    ui: &mut Ui,
    view: &LayerPaneView<'_>,
    pane: &mut LayerPane,
    _: BarPosition,
    requests: &mut Vec<Request>,
) {
    let magnification = pane.view.placement.magnification(ui.ctx().pixels_per_point());
    scale_ui(view.commands, ui, magnification, requests);
}

fn facts(ui: &mut Ui, layer: &ImageLayer) {
    let (rect, used) = (layer.rect, layer.texels_used);
    let (area, hidden) = (rect.area(), used.saturating_sub(layer.texels_visible));
    ui.weak(format!("{} × {} px", rect.w, rect.h))
        .on_hover_text("The sides of an image layer are powers of two, which suits textures.");
    ui.weak(format!("{} texels used ({})", grouped(used), percent(used, area)));
    ui.weak(format!("{} wasted", percent(area.saturating_sub(used), area)))
        .on_hover_text("Texels of the rectangle that no surface needs.");
    let filled = layer.fill.as_ref().map_or(0, |fill| fill.texels_filled);
    let text = match (hidden, filled) {
        (0, _) => "nothing hidden".to_owned(),
        (hidden, 0) => format!("{} hidden, not filled", percent(hidden, used)),
        (hidden, filled) => {
            format!("{} hidden, {} of it filled", percent(hidden, used), percent(filled, hidden))
        }
    };
    ui.weak(text)
        .on_hover_text("Hidden: a surface needs the texel, and the photo shows something else there.");
}

/// Draws the bar below.
pub fn status_ui(
    ui: &mut Ui,
    view: &LayerPaneView<'_>,
    pane: &LayerPane,
    key: &LayerKey,
    layer: &ImageLayer,
) {
    let Some(view) = view.flat.loading.image_layers.get(key) else {
        ui.weak("Reading the image layer…");
        return;
    };
    ui.horizontal_wrapped(|ui| {
        if let Some((x, y)) = pane.pixel {
            ui.monospace(format!("{}, {}", x - layer.rect.x, y - layer.rect.y));
            ui.weak(format!("photo {x}, {y}"));
            ui.separator();
        }
        for (name, [r, g, b], texels) in &view.legend {
            let (rect, _) = ui.allocate_exact_size(vec2(14.0, 14.0), Sense::hover());
            ui.painter().rect_filled(rect, 2.0, Color32::from_rgb(*r, *g, *b));
            ui.label(name);
            ui.weak(percent(*texels, layer.texels_used));
        }
        if view.legend.is_empty() && pane.pixel.is_none() {
            ui.weak("Drag pans, the wheel zooms, a double click switches to 1:1 and back.");
        }
    });
}
