//! The measuring tool in the 3D view: points on surfaces, the line between them, and what there is to say about it.

use eframe::egui::{
    Align2, Color32, CursorIcon, FontId, Key, Modifiers, Rect, Response, Stroke, TextEdit, Ui,
};

use super::overlay::{WorldCanvas, seen_from};
use super::px_of;
use super::view::SpacePaneView;
use crate::panel::bar::{BarPart, BarPosition};
use crate::state::request::{Request, SpaceRequest};
use crate::state::space::measure::MeasuringTool;
use crate::state::space::memory::SpaceMemory;
use crate::widget::dialog;
use quadratura_views::measure::{Measured, PointOnFace, distance, worded};

/// The parts of the tool's bar.
pub fn tools<'a>() -> [BarPart<SpacePaneView<'a>, SpaceMemory>; 3] {
    [BarPart::Tool(result), BarPart::Tool(scale), BarPart::Tool(clear)]
}

/// The colour of points and lines, and that behind text.
const LINE: Color32 = Color32::from_rgb(0x40, 0xe0, 0xff);
const BEHIND: Color32 = Color32::from_black_alpha(170);

/// Handles mouse and keys while the tool is in use: a click adds a point.
pub fn hand_ui(ui: &Ui, view: &SpacePaneView<'_>, it: &mut SpaceMemory, response: &Response, rect: Rect) {
    if !it.measure.on {
        return;
    }
    let has_keys = view.has_keys && !dialog::is_open(ui.ctx());
    if has_keys && ui.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape)) {
        it.measure = MeasuringTool::default();
        ui.ctx().request_repaint();
        return;
    }
    let Some(at) = response.hover_pos().filter(|_| !response.dragged()) else { return };
    ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
    if response.clicked() {
        let seen = seen_from(view, it);
        let pixel = it.pixel_at(px_of(at - rect.min, ui.ctx().pixels_per_point()));
        let pixel = crate::state::space::picking::ViewPixel { viewpoint: seen, ..pixel };
        if let Some((position, face)) = view.scene.surface_at(&pixel) {
            it.measure.add(PointOnFace { position, face });
        }
    }
}

/// Draws the points and the line between them.
pub fn measure_ui(ui: &Ui, view: &SpacePaneView<'_>, it: &SpaceMemory, rect: Rect) {
    if !it.measure.on {
        return;
    }
    let canvas = WorldCanvas { painter: ui.painter_at(rect), rect, view: seen_from(view, it) };
    for point in &it.measure.points {
        if let Some(at) = canvas.place(point.position) {
            canvas.painter.circle(at, 4.0, Color32::TRANSPARENT, Stroke::new(2.0, LINE));
        }
    }
    let Some(points @ [from, to]) = it.measure.both() else { return };
    canvas.line(from.position, to.position, Stroke::new(2.0, LINE));
    if let Some(at) = canvas.place(0.5 * (from.position + to.position)) {
        let session = view.scene.session;
        let found = distance(&session.opened, &session.solid, points);
        let text = worded(found.straight, &session.history.present().frame, 1);
        let font = FontId::proportional(14.0);
        let galley = canvas.painter.layout_no_wrap(text, font, Color32::WHITE);
        let at = Align2::CENTER_BOTTOM.anchor_size(at - eframe::egui::vec2(0.0, 6.0), galley.size());
        canvas.painter.rect_filled(at.expand(3.0), 3.0, BEHIND);
        canvas.painter.galley(at.min, galley, Color32::WHITE);
    }
}

/// Draws what was measured, or what to do.
fn result(ui: &mut Ui, view: &SpacePaneView<'_>, it: &mut SpaceMemory, _: BarPosition, _: &mut Vec<Request>) {
    let session = view.scene.session;
    let Some(points) = it.measure.both() else {
        let next = if it.measure.points.is_empty() { "first" } else { "second" };
        ui.label(format!("Click the {next} point on a surface"));
        return;
    };
    let frame = &session.history.present().frame;
    let found = distance(&session.opened, &session.solid, points);
    // Each part is known as well as the whole.
    let plain = |value: f64| worded(Measured { value, ..found.straight }, frame, 1);
    let straight = worded(found.straight, frame, 1);
    let help = "The uncertainty is the size of a pixel of the best photo at both points.";
    ui.strong(straight).on_hover_text(help);
    ui.label(format!("height {}, level {}", plain(found.height), plain(found.level)));
}

/// Draws the field with the known length, which sets the scale.
fn scale(
    ui: &mut Ui,
    _: &SpacePaneView<'_>,
    it: &mut SpaceMemory,
    _: BarPosition,
    requests: &mut Vec<Request>,
) {
    if it.measure.both().is_none() {
        return;
    }
    ui.horizontal(|ui| {
        let field = TextEdit::singleline(&mut it.measure.length).desired_width(64.0).hint_text("metres");
        let label = ui.label("Known length");
        ui.add(field).labelled_by(label.id);
        let help = "Sets the scale of the site, so that the distance between the points is this length.";
        let button = ui.add_enabled(it.measure.metres().is_some(), eframe::egui::Button::new("Set scale"));
        if button.on_hover_text(help).on_disabled_hover_text("Type the length in metres first.").clicked() {
            requests.push(SpaceRequest::SetScale.into());
        }
    });
}

fn clear(ui: &mut Ui, _: &SpacePaneView<'_>, it: &mut SpaceMemory, _: BarPosition, _: &mut Vec<Request>) {
    if ui.button("Clear").on_hover_text("Removes the points.").clicked() {
        it.measure.points.clear();
    }
}
