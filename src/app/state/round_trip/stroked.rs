//! Changes of state that follow from strokes of the brush in the 3D view.

use std::path::Path;
use std::sync::Arc;

use crate::app::state::State;
use crate::app::state::ask::{Ask, RoundTripAsk};
use crate::app::state::notes::{Note, Weight};
use crate::app::state::numbers::grouped;
use crate::app::state::space::brush::DrawnStroke;
use crate::error::Result;
use crate::recipe::stroke::StrokeReport;

impl State {
    /// Handles a stroke that has become paint: records it as a step, reports what was left out, and updates all views.
    /// `again` is the number of the import that was undone before.
    pub fn stroke_came(
        &mut self,
        folder: &Path,
        drawn: &Arc<DrawnStroke>,
        done: Result<StrokeReport>,
        again: Option<u32>,
    ) -> Vec<Ask> {
        let brush = &mut self.space.brush;
        if brush.waiting.front().is_some_and(|first| Arc::ptr_eq(first, drawn)) {
            brush.waiting.pop_front();
            brush.is_painting = false;
        }
        if self.session.as_ref().is_none_or(|session| session.folder != folder) {
            return Vec::new();
        }
        let report = match done {
            Ok(report) => report,
            Err(error) => {
                self.tell(Note::new(Weight::Problem, format!("The stroke was not painted: {error}")));
                return Vec::new();
            }
        };
        self.tell_what_was_left_out(&report);
        let Some(number) = report.number else { return Vec::new() };
        self.remember_stroke(number, again, drawn.stroke.clone());
        let photos = report.layers.iter().map(|layer| layer.photo.clone()).collect();
        vec![RoundTripAsk::PaintChanged(photos, report.book.clone()).into()]
    }

    fn tell_what_was_left_out(&mut self, report: &StrokeReport) {
        if report.uncovered > 0 {
            let text = format!(
                "No photo covers the surface at {} pixels of the stroke; they were not painted",
                grouped(report.uncovered)
            );
            self.tell(Note::new(Weight::Warning, text));
        }
        if report.without_source > 0 {
            let text = format!(
                "The view shows nothing at the source of {} pixels; they were not painted",
                grouped(report.without_source)
            );
            self.tell(Note::new(Weight::Warning, text));
        }
    }
}
