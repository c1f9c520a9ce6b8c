//! The line that says that a view does not show yet what is asked for.

use std::time::Duration;

use eframe::egui::{Rect, Role, Sense, Ui, WidgetInfo, pos2};

/// The height of the line, in points.
const HEIGHT: f32 = 2.0;
/// The length of its moving part, as a share of the view's width.
const LENGTH: f32 = 0.25;
/// The time in which the part crosses the view, in seconds.
const CROSSING_S: f64 = 1.6;
/// The time between two steps of the part.
const STEP: Duration = Duration::from_millis(50);

/// Draws a thin line with a moving part along the upper edge of a view whose picture is not yet what is asked for.
pub fn behind_ui(ui: &Ui, view: Rect, is_behind: bool) {
    if !is_behind {
        return;
    }
    let line = Rect::from_min_max(view.min, pos2(view.right(), view.top() + HEIGHT));
    let response = ui.interact(line, ui.scope_id().with("behind"), Sense::hover());
    response
        .widget_info(|| WidgetInfo::labeled(Role::ProgressIndicator, true, "The picture is being updated"));
    let share = (ui.input(|input| input.time) / CROSSING_S).fract() as f32;
    let left = view.left() + (share * (1.0 + LENGTH) - LENGTH) * view.width();
    let part = Rect::from_x_y_ranges(left..=left + LENGTH * view.width(), line.y_range());
    let visuals = ui.visuals();
    let painter = ui.painter_at(line);
    painter.rect_filled(line, 0.0, visuals.weak_text_color().gamma_multiply(0.4));
    painter.rect_filled(part, 0.0, visuals.hyperlink_color);
    ui.ctx().request_repaint_after(STEP);
}
