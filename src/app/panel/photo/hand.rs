//! Strokes of brush and lasso in the photo: the mouse and keys while a tool is in use.

use eframe::egui::{CursorIcon, Event, Key, Modifiers, PointerButton, Pos2, Response, Ui};

use super::placed::PlacedPhoto;
use super::view::PhotoView;
use crate::panel::flat::placement::on_screen;
use crate::state::flat::placement::ScreenRect;
use crate::state::masking::Masking;
use crate::state::masking::stroke::MaskStroke;
use crate::state::masking::tool::MaskTool;
use crate::state::request::{MaskRequest, Request};
use crate::widget::dialog;
use quadratura_base::geometry::PixelRect;

/// Returns whether the left button draws now; otherwise it pans the photo. The other buttons always pan.
pub fn draws(view: &PhotoView<'_>, ui: &Ui) -> bool {
    view.masking.tool.is_some() && !ui.input(|input| input.key_down(Key::Space))
}

/// What a stroke of a mask tool is drawn on: a photo as it is seen in the view.
pub struct StrokeTarget<'a> {
    /// The photo.
    pub placed: &'a PlacedPhoto,
    /// The rectangle of the line over it, in which no stroke starts.
    pub line: Option<ScreenRect>,
}

impl StrokeTarget<'_> {
    fn go_to(&self, stroke: &mut MaskStroke, at: Pos2) {
        stroke.go_to(on_screen(at), self.placed.seen.position(at), self.placed.bounds);
    }

    fn may_begin_at(&self, at: Pos2) -> bool {
        self.placed.seen.rect.contains(at) && !self.line.is_some_and(|line| line.contains(on_screen(at)))
    }
}

/// Handles the mouse and keys of the mask tool in use; a stroke that ends becomes an edit of the mask.
pub fn hand_ui(
    ui: &Ui,
    view: &PhotoView<'_>,
    stroke: &mut Option<MaskStroke>,
    response: &Response,
    target: &StrokeTarget<'_>,
    requests: &mut Vec<Request>,
) {
    let Some(tool) = view.masking.tool else { return };
    if escaped(ui) {
        // Escape cancels the stroke first, then deselects the tool.
        if stroke.take().is_none() {
            requests.push(MaskRequest::PutAway.into());
        }
        return;
    }
    if response.hovered() {
        ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
        requests.extend(resized(ui));
    }
    *stroke = stroke.take().filter(|stroke| stroke.photo == target.placed.photo);
    let may_begin = draws(view, ui) && (response.hovered() || response.is_pointer_button_down_on());
    for event in ui.input(|input| input.events.clone()) {
        match event {
            Event::PointerButton { pos, button: PointerButton::Primary, pressed: true, modifiers }
                if may_begin && target.may_begin_at(pos) =>
            {
                response.request_focus();
                let begun = stroke.insert(begun(view.masking, tool, modifiers, target));
                target.go_to(begun, pos);
            }
            Event::PointerMoved(at) => {
                if let Some(stroke) = stroke {
                    target.go_to(stroke, at);
                }
            }
            Event::PointerButton { pos, button: PointerButton::Primary, pressed: false, .. } => {
                if let Some(mut stroke) = stroke.take() {
                    target.go_to(&mut stroke, pos);
                    requests.extend(edit(view, &stroke, target.placed.bounds));
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
fn resized(ui: &Ui) -> Option<Request> {
    let factor = ui.input(|input| if input.modifiers.command { input.zoom_delta() } else { 1.0 });
    (factor != 1.0).then(|| MaskRequest::ResizeBrush(f64::from(factor)).into())
}

/// Starts a stroke; held modifier keys switch between masking and erasing.
fn begun(masking: &Masking, tool: MaskTool, held: Modifiers, target: &StrokeTarget<'_>) -> MaskStroke {
    let uncovers = masking.uncovers ^ (held.command || held.alt);
    let radius_px = masking.radius_px([target.placed.bounds.w, target.placed.bounds.h]);
    MaskStroke::new(target.placed.photo, tool, uncovers, radius_px)
}

fn edit(view: &PhotoView<'_>, stroke: &MaskStroke, within: PixelRect) -> Option<Request> {
    let session = view.session?;
    let photo = session.opened.site.photos.get(stroke.photo.index())?;
    if let MaskTool::Matte(_) = stroke.tool {
        let painted = stroke.of_matte(photo, session.matte_layer(view.selection.main, stroke.photo))?;
        return Some(MaskRequest::Matte(Box::new(painted)).into());
    }
    let (name, work) = stroke.step(&photo.name, within)?;
    Some(MaskRequest::Mask(name, work).into())
}
