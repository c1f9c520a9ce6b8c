//! Mouse and keys of the 3D view.

use eframe::egui::{InputState, Key, PointerButton, Rect, Response, Ui, Vec2};
use glam::{DVec2, DVec3};

use super::px_of;
use super::view::SpacePaneView;
use crate::state::settings::Navigation;
use crate::state::space::memory::SpaceMemory;
use crate::state::space::picking::ViewPixel;
use crate::widget::dialog;
use quadratura_view::navigation::Viewpoint;

/// The rotation of a drag across the view's height: half a turn.
const TURN_RAD_PER_HEIGHT: f64 = std::f64::consts::PI;
/// The zoom factor of one point of wheel movement: a step of about 40 points in egui moves an eighth nearer.
const ZOOM_PER_POINT: f64 = 1.003;
/// The flight speed, as the time in seconds to reach the pivot at the initial speed: slow enough to stop before a
/// facade, fast enough to cross a square.
const SECONDS_AHEAD: f64 = 4.0;
/// The distance that orbiting keeps from walls, in steps of the current turn.
const KEPT_AWAY: f64 = 1.0;
/// The speed factor of Shift; Ctrl divides by it.
const HURRY: f64 = 4.0;

/// Navigates with mouse and keys; returns whether the view moves.
pub fn navigate(
    ui: &Ui,
    view: &SpacePaneView<'_>,
    it: &mut SpaceMemory,
    response: &Response,
    rect: Rect,
) -> bool {
    let before = it.viewpoint;
    if response.clicked() || response.drag_started() {
        response.request_focus();
    }
    drag(ui, view, it, response, rect);
    if response.contains_pointer() {
        wheel(ui, view, it, rect);
    }
    let flying = view.has_keys;
    if flying && !ui.ctx().text_edit_focused() && !dialog::is_open(ui.ctx()) {
        fly(ui, view, it);
    }
    let moves = it.viewpoint != before;
    if moves {
        it.through = None;
        ui.ctx().request_repaint();
    }
    moves || (response.dragged() && !(has_tool(view, it) && response.dragged_by(PointerButton::Primary)))
}

/// Returns whether the left button belongs to a tool.
fn has_tool(view: &SpacePaneView<'_>, it: &SpaceMemory) -> bool {
    it.brush.on || it.grip.edge.is_some() || view.scene.trees.hand.on
}

/// The function of a drag.
enum Drag {
    Orbit,
    Pan,
    Look,
}

fn drag(ui: &Ui, view: &SpacePaneView<'_>, it: &mut SpaceMemory, response: &Response, rect: Rect) {
    let by = response.drag_delta();
    let (shift, ctrl, alt) = ui.input(|input| {
        let held = input.modifiers;
        (held.shift, held.command, held.alt)
    });
    let with = |button| response.dragged_by(button);
    let tool = has_tool(view, it);
    let drag = match view.navigation {
        // The left button paints, or places trees.
        _ if tool && with(PointerButton::Primary) => return,
        Navigation::Simple if tool && with(PointerButton::Middle) && shift => Drag::Pan,
        Navigation::Simple if tool && with(PointerButton::Middle) => Drag::Orbit,
        Navigation::Simple if with(PointerButton::Primary) && (shift || ctrl) => Drag::Pan,
        Navigation::Simple if with(PointerButton::Primary) && alt => Drag::Look,
        Navigation::Simple if with(PointerButton::Primary) => Drag::Orbit,
        Navigation::Simple if with(PointerButton::Secondary) || with(PointerButton::Middle) => Drag::Pan,
        Navigation::Blender if with(PointerButton::Middle) && shift => Drag::Pan,
        Navigation::Blender if with(PointerButton::Middle) => Drag::Orbit,
        Navigation::Blender if with(PointerButton::Secondary) => Drag::Look,
        _ => return,
    };
    if response.drag_started() && matches!(drag, Drag::Orbit | Drag::Pan) {
        hold(ui, view, it, rect);
    }
    if by == Vec2::ZERO {
        return;
    }
    let session = view.scene.session;
    let up = session.scene_frame.up;
    let turn =
        -DVec2::new(f64::from(by.x), f64::from(by.y)) * (TURN_RAD_PER_HEIGHT / f64::from(rect.height()));
    let viewpoint = &mut it.viewpoint;
    match drag {
        Drag::Orbit => orbit(view, viewpoint, turn, up),
        Drag::Look => viewpoint.look(turn.x, turn.y, up),
        Drag::Pan => viewpoint.pan(px_of(by, 1.0), f64::from(rect.height())),
    }
}

/// Orbits around the pivot, as far as no wall that photos show is in the way: where one is, the view slides along it by
/// the part of the turn that stays free, or stops.
fn orbit(view: &SpacePaneView<'_>, viewpoint: &mut Viewpoint, turn: DVec2, up: DVec3) {
    for part in [turn, DVec2::new(turn.x, 0.0), DVec2::new(0.0, turn.y)] {
        let mut there = *viewpoint;
        there.orbit(part.x, -part.y, up);
        let (from, to) = (viewpoint.position(), there.position());
        // The view also keeps a distance, so that it does not stop within the wall.
        let beyond = to + (to - from) * KEPT_AWAY;
        if view.scene.session.solid.blocks(from, beyond, &view.scene.space.look.hidden).is_none() {
            *viewpoint = there;
            return;
        }
    }
}

/// Takes the point under the pointer as the pivot of orbiting and panning.
fn hold(ui: &Ui, view: &SpacePaneView<'_>, it: &mut SpaceMemory, rect: Rect) {
    let origin = ui.input(|input| input.pointer.press_origin());
    let held = origin.and_then(|at| under(view, it, &pixel_under(ui, it, at - rect.min)));
    let session = view.scene.session;
    match held {
        Some(point) => it.viewpoint.pivot = point,
        None => it.viewpoint.settle_pivot(&session.scene_frame),
    }
}

/// Returns how a position is seen, as an offset from the top left corner in points.
fn pixel_under(ui: &Ui, it: &SpaceMemory, offset: Vec2) -> ViewPixel {
    it.pixel_at(px_of(offset, ui.ctx().pixels_per_point()))
}

/// Returns the point of the model, or of the layers that are pulled apart, under a position in the view.
fn under(view: &SpacePaneView<'_>, it: &SpaceMemory, pixel: &ViewPixel) -> Option<DVec3> {
    if view.scene.space.exploded.is_on() {
        return view.scene.layer_at(pixel, it.now_apart).map(|(point, _)| point);
    }
    view.scene.point_at(pixel)
}

fn wheel(ui: &Ui, view: &SpacePaneView<'_>, it: &mut SpaceMemory, rect: Rect) {
    let scrolled = ui.input(|input| f64::from(input.smooth_scroll_delta().y));
    let pinched = ui.input(|input| f64::from(input.zoom_delta()));
    let factor = ZOOM_PER_POINT.powf(scrolled) * pinched;
    if factor == 1.0 {
        return;
    }
    let Some(pointer) = ui.input(|input| input.pointer.hover_pos()) else { return };
    let pixel = pixel_under(ui, it, pointer - rect.min);
    let target = under(view, it, &pixel).unwrap_or_else(|| beyond(&pixel));
    let session = view.scene.session;
    it.viewpoint.zoom(target, factor, &session.scene_frame);
}

/// Returns the point at the pivot's depth, where the ray hits nothing.
fn beyond(pixel: &ViewPixel) -> DVec3 {
    let view = &pixel.viewpoint;
    view.position() + pixel.ray() * view.pose.camera_from_world(view.pivot).z.max(f64::MIN_POSITIVE)
}

fn fly(ui: &Ui, view: &SpacePaneView<'_>, it: &mut SpaceMemory) {
    let session = view.scene.session;
    let held =
        |key| ui.input(|input| is_held(input, key) && !input.modifiers.command && !input.modifiers.alt);
    let axis = |more, less| f64::from(held(more)) - f64::from(held(less));
    let direction = DVec3::new(axis(Key::D, Key::A), axis(Key::Q, Key::E), axis(Key::W, Key::S));
    if direction == DVec3::ZERO {
        return;
    }
    let (seconds, shift) = ui.input(|input| (f64::from(input.stable_dt.min(0.1)), input.modifiers.shift));
    let hurry = if shift { HURRY } else { 1.0 };
    let viewpoint = &mut it.viewpoint;
    let first = |origin: DVec3, ray| {
        session
            .solid
            .first_visible(origin, ray, view.scene.space.look.culling())
            .map(|hit| hit.t * ray.length())
    };
    let pace = viewpoint.ahead(&session.scene_frame, first) / SECONDS_AHEAD;
    viewpoint.fly(direction.normalize() * (pace * seconds * hurry));
    ui.ctx().request_repaint();
}

/// Returns whether a key is down, or was pressed and released within a slow frame.
fn is_held(input: &InputState, key: Key) -> bool {
    input.key_down(key) || input.key_pressed(key)
}
