//! Trees in the 3D view: the outline of the selected one, and the tool that places and drags them.

use eframe::egui::{
    Color32, ComboBox, CursorIcon, Event, Key, Modifiers, PointerButton, Pos2, Rect, Response, Stroke, Ui,
};
use glam::DVec3;

use super::overlay::{HOVERED, SELECTED, WorldCanvas, seen_from};
use super::px_of;
use super::view::SpacePaneView;
use crate::panel::bar::{BarPart, BarPosition};
use crate::panel::inspect::tree::species_choice;
use crate::panel::named;
use crate::state::notes::{Note, Weight};
use crate::state::request::{Request, TreeRequest, WindowRequest};
use crate::state::selection::Selection;
use crate::state::space::memory::SpaceMemory;
use crate::state::trees::hand::Hold;
use crate::widget::dialog;
use quadratura_document::trees::PlacedTree;
use quadratura_foliage::level_axes;

/// The parts of the tool's bar.
pub fn tools<'a>() -> [BarPart<SpacePaneView<'a>, SpaceMemory>; 2] {
    [BarPart::Tool(species), BarPart::Tool(hint)]
}

/// The number of corners of circles.
const CORNERS: u32 = 40;
/// The colour of the place where a tree would stand.
const GHOST: Color32 = Color32::from_rgb(0x9f, 0xe0, 0x90);

/// Draws the outlines of the selected tree and of that under the pointer, and where a tree would be placed.
pub fn outlines_ui(ui: &Ui, view: &SpacePaneView<'_>, it: &SpaceMemory, response: &Response, rect: Rect) {
    let canvas = WorldCanvas { painter: ui.painter_at(rect), rect, view: seen_from(view, it) };
    let trees = view.scene.session.trees();
    if let Some(tree) = view.scene.session.tree_of(view.selection.main) {
        outline(&canvas, view, tree, Stroke::new(2.0, SELECTED));
    }
    let Some(at) = response.hover_pos().filter(|_| !response.dragged()) else { return };
    let pixel = it.pixel_at(px_of(at - rect.min, ui.ctx().pixels_per_point()));
    let hovered = view.scene.tree_at(&pixel).filter(|index| view.selection.main != Selection::Tree(*index));
    if let Some(tree) = hovered.and_then(|index| trees.at(index)) {
        outline(&canvas, view, tree, Stroke::new(1.5, HOVERED));
    } else if view.scene.trees.hand.on
        && view.scene.trees.hand.held.is_none()
        && let Some(ground) = view.scene.ground_at(&pixel)
    {
        let ghost = size_of_new(view);
        cylinder(&canvas, view, ground, ghost, Stroke::new(1.5, GHOST));
    }
}

/// Returns the height and width of a tree that would be placed.
fn size_of_new(view: &SpacePaneView<'_>) -> [f64; 2] {
    let known = (view.scene.trees.figures_of(view.scene.session.trees(), &view.scene.trees.hand.species))
        .map(|figures| [figures.height, figures.width]);
    let radius = Some(view.scene.session).map_or(1.0, |session| session.scene_frame.radius);
    known.unwrap_or([0.1 * radius, 0.05 * radius])
}

fn outline(canvas: &WorldCanvas, view: &SpacePaneView<'_>, tree: &PlacedTree, stroke: Stroke) {
    let size =
        (view.scene.trees.size_of(view.scene.session.trees(), tree)).unwrap_or_else(|| size_of_new(view));
    cylinder(canvas, view, DVec3::from_array(tree.at), size, stroke);
}

/// Draws a circle around a foot, one around the top, and a line between their middles.
fn cylinder(
    canvas: &WorldCanvas,
    view: &SpacePaneView<'_>,
    foot: DVec3,
    [height, width]: [f64; 2],
    stroke: Stroke,
) {
    let session = view.scene.session;
    let up = session.scene_frame.up;
    let (x, y) = level_axes(up);
    let top = foot + height * up;
    canvas.line(foot, top, stroke);
    for middle in [foot, top] {
        let corner = |number: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(number) / f64::from(CORNERS)).sin_cos();
            middle + 0.5 * width * (cos * x + sin * y)
        };
        (0..CORNERS).for_each(|number| canvas.line(corner(number), corner(number + 1), stroke));
    }
}

/// Handles mouse and keys while the tool is in use.
pub fn hand_ui(
    ui: &Ui,
    view: &SpacePaneView<'_>,
    it: &SpaceMemory,
    response: &Response,
    rect: Rect,
    requests: &mut Vec<Request>,
) {
    if !view.scene.trees.hand.on {
        return;
    }
    requests.push(TreeRequest::WantFigures.into());
    let held = view.scene.trees.hand.held.is_some();
    let has_keys = view.has_keys && !dialog::is_open(ui.ctx());
    if (has_keys || held) && ui.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape)) {
        // Escape gives the drag up first, then puts the tool away.
        requests.push(if held { TreeRequest::GiveUp } else { TreeRequest::Hand }.into());
        ui.ctx().request_repaint();
        return;
    }
    if response.hovered() {
        ui.ctx().set_cursor_icon(if held { CursorIcon::Grabbing } else { CursorIcon::Crosshair });
    }
    let density = ui.ctx().pixels_per_point();
    let pixel = |at: Pos2| it.pixel_at(px_of(at - rect.min, density));
    let may_begin = response.hovered() || response.is_pointer_button_down_on();
    let (mut held, mut last) = (held, None);
    let modifiers = ui.input(|input| input.modifiers);
    for event in ui.input(|input| input.events.clone()) {
        match event {
            Event::PointerButton { pos, button: PointerButton::Primary, pressed: true, .. }
                if may_begin && rect.contains(pos) =>
            {
                response.request_focus();
                if seen_from(view, it) != it.viewpoint {
                    let text = "The picture is not of this view yet: place trees when it is";
                    requests.push(WindowRequest::Say(Note::new(Weight::Info, text)).into());
                } else {
                    requests.push(TreeRequest::Press(pixel(pos)).into());
                    held = true;
                }
            }
            Event::PointerMoved(at) if held => last = Some(at),
            Event::PointerButton { pos, button: PointerButton::Primary, pressed: false, .. } if held => {
                requests.push(TreeRequest::Drag(pixel(pos), hold_of(modifiers)).into());
                requests.push(TreeRequest::Release.into());
                (held, last) = (false, None);
            }
            _ => (),
        }
    }
    // Of several moves within a frame, the last one counts.
    requests.extend(last.map(|at| Request::from(TreeRequest::Drag(pixel(at), hold_of(modifiers)))));
}

fn hold_of(modifiers: Modifiers) -> Hold {
    match (modifiers.alt, modifiers.shift) {
        (true, _) => Hold::Height,
        (false, true) => Hold::Turn,
        (false, false) => Hold::Move,
    }
}

fn species(
    ui: &mut Ui,
    view: &SpacePaneView<'_>,
    _: &mut SpaceMemory,
    place: BarPosition,
    requests: &mut Vec<Request>,
) {
    let now = &view.scene.trees.hand.species;
    let mut chosen = None;
    if place == BarPosition::Menu {
        chosen = species_choice(ui, Some(view.scene.session.trees()), now);
    } else {
        let combo = ComboBox::from_id_salt("species to place").selected_text(now);
        let combo =
            combo.show_ui(ui, |ui| chosen = species_choice(ui, Some(view.scene.session.trees()), now));
        named(&combo.response, "Species to place");
    }
    requests.extend(chosen.map(|species| Request::from(TreeRequest::Choose(species))));
}

fn hint(ui: &mut Ui, _: &SpacePaneView<'_>, _: &mut SpaceMemory, _: BarPosition, _: &mut Vec<Request>) {
    ui.weak("Click: place · drag: move · Alt: height · Shift: turn · Esc: end");
}
