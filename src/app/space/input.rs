//! Mouse and keys of the 3D view.

use eframe::egui::{InputState, Key, PointerButton, Rect, Response, Ui, Vec2};
use glam::{DVec2, DVec3};

use super::{Editor, px_of};
use crate::app::state::State;
use crate::app::state::settings::Navigation;
use crate::app::widget::dialog;
use crate::projection::navigation::Viewpoint;

/// The rotation of a drag across the view's height: half a turn.
const TURN_RAD_PER_HEIGHT: f64 = std::f64::consts::PI;
/// The zoom factor of one point of wheel movement: a step of about 40 points in egui moves an eighth nearer.
const ZOOM_PER_POINT: f64 = 1.003;
/// The flight speed, as the time in seconds to reach the pivot at the initial speed: slow enough to stop before a
/// facade, fast enough to cross a square.
const SECONDS_AHEAD: f64 = 4.0;
/// The speed factor of Shift; Ctrl divides by it.
const HURRY: f64 = 4.0;

/// Navigates with mouse and keys; returns whether the view moves.
pub fn navigate(editor: &mut Editor, ui: &Ui, response: &Response, rect: Rect, now_s: f64) -> bool {
    let before = editor.state.space.viewpoint;
    if response.clicked() || response.drag_started() {
        response.request_focus();
    }
    drag(editor, ui, response, rect);
    if response.contains_pointer() {
        wheel(editor, ui, rect);
    }
    let flying = response.contains_pointer() || response.has_focus();
    if flying && !ui.ctx().text_edit_focused() && !dialog::is_open(ui.ctx()) {
        fly(editor, ui);
    }
    let moves = editor.state.space.viewpoint != before;
    if moves {
        editor.state.space.moved(now_s);
        ui.ctx().request_repaint();
    }
    moves || response.dragged()
}

/// The function of a drag.
enum Drag {
    Orbit,
    Pan,
    Look,
}

fn drag(editor: &mut Editor, ui: &Ui, response: &Response, rect: Rect) {
    let by = response.drag_delta();
    let (shift, ctrl, alt) = ui.input(|input| {
        let held = input.modifiers;
        (held.shift, held.command, held.alt)
    });
    let with = |button| response.dragged_by(button);
    let drag = match editor.state.settings.navigation {
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
        hold(editor, ui, rect);
    }
    if by == Vec2::ZERO {
        return;
    }
    let Some(session) = &editor.state.session else { return };
    let up = session.scene_frame.up;
    let turn =
        -DVec2::new(f64::from(by.x), f64::from(by.y)) * (TURN_RAD_PER_HEIGHT / f64::from(rect.height()));
    let view = &mut editor.state.space.viewpoint;
    match drag {
        Drag::Orbit => view.orbit(turn.x, -turn.y, up),
        Drag::Look => view.look(turn.x, turn.y, up),
        Drag::Pan => view.pan(px_of(by, 1.0), f64::from(rect.height())),
    }
}

/// Takes the point under the pointer as the pivot of orbiting and panning.
fn hold(editor: &mut Editor, ui: &Ui, rect: Rect) {
    let held = ui.input(|input| input.pointer.press_origin()).and_then(|at| under(editor, ui, at - rect.min));
    let Some(session) = &editor.state.session else { return };
    match held {
        Some(point) => editor.state.space.viewpoint.pivot = point,
        None => editor.state.space.viewpoint.settle_pivot(&session.scene_frame),
    }
}

/// Returns the point of the model, or of the exploded layers, under a position in the view.
pub fn under(state: &State, ui: &Ui, offset: Vec2) -> Option<DVec3> {
    let session = state.session.as_ref()?;
    let (view, size_px) = (&state.space.viewpoint, state.space.size_px);
    let ray = view.ray(px_of(offset, ui.ctx().pixels_per_point()), size_px);
    let backs = !state.space.look.without_backs;
    if state.space.exploded.is_on() {
        return state.layer_along(ray).map(|(point, _)| point);
    }
    let hit = session.solid.first_visible(view.position(), ray, backs)?;
    Some(view.position() + ray * hit.t)
}

fn wheel(editor: &mut Editor, ui: &Ui, rect: Rect) {
    let scrolled = ui.input(|input| f64::from(input.smooth_scroll_delta().y));
    let pinched = ui.input(|input| f64::from(input.zoom_delta()));
    let factor = ZOOM_PER_POINT.powf(scrolled) * pinched;
    if factor == 1.0 {
        return;
    }
    let Some(pointer) = ui.input(|input| input.pointer.hover_pos()) else { return };
    let target =
        under(editor, ui, pointer - rect.min).unwrap_or_else(|| beyond(editor, ui, pointer - rect.min));
    let Some(session) = &editor.state.session else { return };
    editor.state.space.viewpoint.zoom(target, factor, &session.scene_frame);
}

/// Returns the point at the pivot's depth, where the ray hits nothing.
fn beyond(state: &State, ui: &Ui, offset: Vec2) -> DVec3 {
    let view: &Viewpoint = &state.space.viewpoint;
    let ray = view.ray(px_of(offset, ui.ctx().pixels_per_point()), state.space.size_px);
    view.position() + ray * view.pose.camera_from_world(view.pivot).z.max(f64::MIN_POSITIVE)
}

fn fly(editor: &mut Editor, ui: &Ui) {
    let Some(session) = &editor.state.session else { return };
    let held =
        |key| ui.input(|input| is_held(input, key) && !input.modifiers.command && !input.modifiers.alt);
    let axis = |more, less| f64::from(held(more)) - f64::from(held(less));
    let direction = DVec3::new(axis(Key::D, Key::A), axis(Key::Q, Key::E), axis(Key::W, Key::S));
    if direction == DVec3::ZERO {
        return;
    }
    let (seconds, shift) = ui.input(|input| (f64::from(input.stable_dt.min(0.1)), input.modifiers.shift));
    let hurry = if shift { HURRY } else { 1.0 };
    let backs = !editor.state.space.look.without_backs;
    let view = &mut editor.state.space.viewpoint;
    let first =
        |origin: DVec3, ray| session.solid.first_visible(origin, ray, backs).map(|hit| hit.t * ray.length());
    let pace = view.ahead(&session.scene_frame, first) / SECONDS_AHEAD;
    view.fly(direction.normalize() * (pace * seconds * hurry));
    ui.ctx().request_repaint();
}

/// Returns whether a key is down, or was pressed and released within a slow frame.
fn is_held(input: &InputState, key: Key) -> bool {
    input.key_down(key) || input.key_pressed(key)
}
