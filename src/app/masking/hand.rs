//! Strokes of brush and lasso in the photo: the mouse and keys while a tool is in use.

use eframe::egui::{CursorIcon, Event, Key, Modifiers, PointerButton, Pos2, Response, Ui};
use glam::DVec2;
use std::sync::Arc;

use super::keeping::MaskWork;
use super::{MaskTool, Masking};
use crate::app::editor::Editor;
use crate::app::flat::placement::PlacedPicture;
use crate::app::state::State;
use crate::app::state::ask::{Ask, MaskAsk};
use crate::app::widget::dialog;
use crate::document::masks::MaskOrigin;
use crate::geometry::drawn::{brushed, enclosed};
use crate::geometry::{PixelRect, Spans};
use crate::recipe::masks::MaskEdit;

/// The smallest distance between points of a lasso, in points of the screen; smaller details do not matter.
const NEAR: f32 = 1.5;

/// The stroke that is being drawn.
pub struct Stroke {
    /// The photo in which the stroke began.
    pub photo: usize,
    /// The tool of the stroke.
    pub tool: MaskTool,
    /// Whether the stroke erases.
    pub uncovers: bool,
    /// The radius of the brush, in photo pixels.
    radius_px: f64,
    /// The path of the pointer, in photo pixels.
    pub line: Vec<DVec2>,
    /// The pixels that the brush has covered; those of the lasso are computed at the end.
    pub pixels: Spans,
    last: Pos2,
}

impl Stroke {
    fn go_to(&mut self, at: Pos2, seen: &PlacedPicture, within: PixelRect) {
        if at.distance(self.last) < NEAR && !self.line.is_empty() {
            return;
        }
        let position = seen.position(at);
        if self.tool == MaskTool::Brush {
            let from = self.line.last().copied();
            let way: Vec<DVec2> = from.into_iter().chain([position]).collect();
            self.pixels = self.pixels.union(&brushed(&way, self.radius_px, within));
        }
        self.line.push(position);
        self.last = at;
    }

    fn drawn(&self, within: PixelRect) -> Spans {
        match self.tool {
            MaskTool::Brush => self.pixels.clone(),
            MaskTool::Lasso => enclosed(&self.line, within),
        }
    }
}

/// Returns whether the left button draws now; otherwise it pans the photo. The other buttons always pan.
pub fn draws(state: &State, ui: &Ui) -> bool {
    state.masking.tool.is_some() && !ui.input(|input| input.key_down(Key::Space))
}

/// Handles mouse and keys of the tool; a stroke that ends becomes an edit.
pub fn hand_ui(
    editor: &mut Editor,
    ui: &Ui,
    response: &Response,
    seen: &PlacedPicture,
    (photo, within): (usize, PixelRect),
    asks: &mut Vec<Ask>,
) {
    let Some(tool) = editor.state.masking.tool else { return };
    if escaped(ui) {
        // Escape cancels the stroke first, then deselects the tool.
        if editor.state.masking.stroke.take().is_none() {
            editor.state.masking.tool = None;
        }
        return;
    }
    if response.hovered() {
        ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
        resize(&mut editor.state.masking, ui, [within.w, within.h]);
        // Space pans the photo here, and does not play the flight.
        if ui.memory(|memory| memory.focused().is_none()) {
            response.request_focus();
        }
    }
    editor.state.masking.stroke = editor.state.masking.stroke.take().filter(|stroke| stroke.photo == photo);
    let may_begin = draws(editor, ui) && (response.hovered() || response.is_pointer_button_down_on());
    for event in ui.input(|input| input.events.clone()) {
        match event {
            Event::PointerButton { pos, button: PointerButton::Primary, pressed: true, modifiers }
                if may_begin
                    && seen.rect.contains(pos)
                    && !editor.state.flat.photo.line.is_some_and(|line| line.contains(pos)) =>
            {
                response.request_focus();
                let mut stroke = begun(&editor.state.masking, tool, modifiers, (photo, within), pos);
                stroke.go_to(pos, seen, within);
                editor.state.masking.stroke = Some(stroke);
            }
            Event::PointerMoved(at) => {
                if let Some(stroke) = &mut editor.state.masking.stroke {
                    stroke.go_to(at, seen, within);
                }
            }
            Event::PointerButton { pos, button: PointerButton::Primary, pressed: false, .. } => {
                if let Some(mut stroke) = editor.state.masking.stroke.take() {
                    stroke.go_to(pos, seen, within);
                    asks.extend(edit(editor, &stroke, within));
                }
            }
            _ => (),
        }
    }
}

/// Returns whether Escape was pressed and no dialog is open for it.
fn escaped(ui: &Ui) -> bool {
    !dialog::is_open(ui.ctx()) && ui.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape))
}

/// Resizes the brush with Ctrl and the wheel.
fn resize(masking: &mut Masking, ui: &Ui, size: [u32; 2]) {
    let factor = ui.input(|input| if input.modifiers.command { input.zoom_delta() } else { 1.0 });
    if factor != 1.0 {
        masking.resize(f64::from(factor), size);
    }
}

/// Starts a stroke; held modifier keys switch between masking and erasing.
fn begun(
    masking: &Masking,
    tool: MaskTool,
    held: Modifiers,
    (photo, within): (usize, PixelRect),
    last: Pos2,
) -> Stroke {
    let uncovers = masking.uncovers ^ (held.command || held.alt);
    let radius_px = masking.radius_px([within.w, within.h]);
    Stroke { photo, tool, uncovers, radius_px, line: Vec::new(), pixels: Spans::default(), last }
}

fn edit(state: &State, stroke: &Stroke, within: PixelRect) -> Option<Ask> {
    let pixels = stroke.drawn(within);
    let photo = state.session.as_ref()?.opened.site.photos[stroke.photo].name.clone();
    let tool = stroke.tool.name();
    let (name, edit) = match stroke.uncovers {
        true => {
            (format!("uncovering of {photo} by {tool}"), MaskEdit::Uncover { photo, pixels: pixels.clone() })
        }
        false => {
            let name = format!("mask of {photo} by {tool}");
            (name, MaskEdit::Add { photo, from: MaskOrigin::Drawn, masked: pixels.clone() })
        }
    };
    (!pixels.is_empty()).then(|| Ask::Mask(MaskAsk::Mask(name, MaskWork::Edits(Arc::new(vec![edit])))))
}
