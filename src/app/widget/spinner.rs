//! The sign of work whose end is not known.

use std::f32::consts::TAU;
use std::time::Duration;

use eframe::egui::{Rect, Response, Role, Sense, Shape, Stroke, Ui, Vec2, Widget, WidgetInfo, vec2};

/// The share of the circle that is drawn.
const ARC: f32 = 0.7;
/// The turns in a second.
const SPEED: f64 = 0.8;
/// The time between two steps. The spinner of egui asks for every frame that the display can show; where a processor draws the
/// window, these take the time of the work that is waited for.
const STEP: Duration = Duration::from_millis(80);
/// The corners of the drawn line.
const CORNERS: usize = 20;

/// A turning arc.
#[derive(Debug, Default)]
#[must_use = "a spinner is drawn when it is added"]
pub struct Spinner {
    size: Option<f32>,
}

impl Spinner {
    /// Makes a spinner as high as a line of the interface.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets width and height, in points.
    pub fn size(self, size: f32) -> Self {
        Self { size: Some(size) }
    }

    /// Draws it in `rect`.
    pub fn paint_at(&self, ui: &Ui, rect: Rect) {
        if !ui.is_rect_visible(rect) {
            return;
        }
        ui.ctx().request_repaint_after(STEP);
        let radius = rect.size().min_elem() / 2.0 - 2.0;
        let step = STEP.as_secs_f64();
        let turns = (ui.input(|input| input.time) / step).floor() * step * SPEED;
        let start = turns.fract() as f32 * TAU;
        let on_circle = |k: usize| {
            let (sin, cos) = (start + k as f32 / CORNERS as f32 * ARC * TAU).sin_cos();
            rect.center() + radius * vec2(cos, sin)
        };
        let stroke = Stroke::new(3.0_f32.min(radius / 2.0), ui.visuals().strong_text_color());
        ui.painter().add(Shape::line((0..=CORNERS).map(on_circle).collect(), stroke));
    }
}

impl Widget for Spinner {
    fn ui(self, ui: &mut Ui) -> Response {
        let size = self.size.unwrap_or_else(|| ui.style().spacing.interact_size.y);
        let (rect, response) = ui.allocate_exact_size(Vec2::splat(size), Sense::hover());
        response.widget_info(|| WidgetInfo::new(Role::ProgressIndicator));
        self.paint_at(ui, rect);
        response
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use eframe::egui::{Context, RawInput, ViewportId};

    use super::{STEP, Spinner};

    #[test]
    fn a_spinner_asks_for_its_next_step_and_not_for_every_frame() {
        let context = Context::default();
        // The first frames are repeated until the layout is settled.
        let mut delay = Duration::ZERO;
        for frame in 0..4 {
            let input = RawInput { time: Some(f64::from(frame)), ..RawInput::default() };
            let output = context.run_ui(input, |ui| drop(ui.add(Spinner::new())));
            delay = output.viewport_output[&ViewportId::ROOT].repaint_delay;
        }
        assert!(delay > STEP / 2 && delay <= STEP, "the next frame was asked for after {delay:?}");
    }
}
