//! The line over the photo: the outcome of a search, or the next step where layers are missing.

use eframe::egui::{Frame, Pos2, Rect, Ui, UiBuilder};

use super::view::PhotoView;
use crate::command::{Command, layers};
use crate::panel::button;
use crate::state::request::{MaskRequest, Request};
use quadratura_base::scene::PhotoId;

/// The distance from the view's lower edge to the top of the line, in points.
const OVER: f32 = 64.0;

/// Draws the outcome of the search for transient objects, or the next step where the photo's layers are missing or out
/// of date; returns the rectangle of the line.
pub fn line_ui(
    ui: &mut Ui,
    view: &PhotoView<'_>,
    rect: Rect,
    photo: PhotoId,
    requests: &mut Vec<Request>,
) -> Option<Rect> {
    let session = view.session?;
    let status = &session.photos[photo.index()];
    // The latest outcome comes first; layers that are out of date remain so.
    let is_stale = status.word == "stale";
    if let Some(outcome) = view.masking.outcome_in(session, photo).filter(|_| !is_stale) {
        let (read, line) = over(ui, rect, |ui| {
            ui.label(outcome);
            ui.button("OK").on_hover_text("Hides this line.").clicked()
        });
        requests.extend(read.then(|| MaskRequest::ForgetOutcome.into()));
        return Some(line);
    }
    let text = match status.word {
        // It is updated without a click.
        "stale" if view.keeps_up => return None,
        "stale" => "This photo’s layers are out of date.",
        _ if status.stack.is_none() => "This photo has no layers yet.",
        _ => return None,
    };
    let others = session.photos.iter().filter(|photo| !photo.is_current()).count() > 1;
    let commands: &[&'static Command] = match others && status.stack.is_some() {
        true => &[&layers::BUILD_PHOTO, &layers::BUILD],
        false => &[&layers::BUILD_PHOTO],
    };
    let ((), line) = over(ui, rect, |ui| {
        ui.label(text);
        commands.iter().for_each(|command| button(view.commands, ui, command, requests));
    });
    Some(line)
}

/// Draws a line over the photo, centred at the bottom; returns its rectangle.
fn over<R>(ui: &mut Ui, rect: Rect, contents: impl FnOnce(&mut Ui) -> R) -> (R, Rect) {
    // The width is that of the frame before, as it is not known earlier.
    let id = ui.scope_id().with("over the photo");
    let width = ui.data(|data| data.get_temp::<f32>(id)).unwrap_or(0.0);
    let left = (rect.center().x - width / 2.0).max(rect.left());
    let area = Rect::from_min_max(Pos2::new(left, rect.bottom() - OVER), rect.max);
    let drawn = ui.scope_builder(UiBuilder::new().max_rect(area), |ui| {
        Frame::popup(ui.style()).show(ui, |ui| ui.horizontal(contents).inner)
    });
    let line = drawn.inner.response.rect;
    let framed = line.width();
    if framed != width {
        ui.data_mut(|data| data.insert_temp(id, framed));
        ui.ctx().request_repaint();
    }
    (drawn.inner.inner, line)
}
