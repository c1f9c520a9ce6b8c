//! Actions on masks: tools, strokes, suggestions, and writing.

pub mod keeping;
pub mod reading;
pub mod repairing;
pub mod suggesting;

use std::sync::Arc;

use self::keeping::{keep_masks, queue_mask};
use self::reading::want_masks;
use self::repairing::{tell_masks, tell_problems};
use self::suggesting::{accept_suggestions, look_for_transients, want_suggestions};
use crate::action::opening::chooser::choose;
use crate::state::State;
use crate::state::masking::keeping::MaskWork;
use crate::state::masking::tool::MaskTool;
use crate::state::opening::Purpose;
use crate::state::panes::Pane;
use crate::state::request::MaskRequest;
use crate::state::space::brush::DrawnStroke;
use crate::work::Work;
use quadratura_document::stroke::Stroke;

/// Applies a request about masks.
pub fn apply(state: &mut State, work: &mut Work, request: MaskRequest) {
    match request {
        MaskRequest::Mask(name, change) => queue_mask(state, work, name, change),
        MaskRequest::Accept(numbers) => accept_suggestions(state, work, &numbers),
        MaskRequest::Dismiss(numbers) => state.dismiss_suggestions(&numbers),
        MaskRequest::Margin(margin_px) => state.masking.margin_px = margin_px,
        MaskRequest::Matte(stroke) => state.paint_matte(*stroke),
        MaskRequest::TakeUp(tool) => state.take_up(tool),
        MaskRequest::PutAway => state.masking.tool = None,
        MaskRequest::Uncover => state.masking.uncovers = state.switched_in_photo(state.masking.uncovers),
        MaskRequest::ResizeBrush(factor) => state.resize_brush(factor),
        MaskRequest::Show => state.masking.shown = state.switched_in_photo(state.masking.shown),
        MaskRequest::WantMasks(photo) => want_masks(state, work, photo),
        MaskRequest::WantSuggestions => want_suggestions(state, work),
        MaskRequest::OfferUnlikely(on) => state.masking.suggested.offer_unlikely(on),
        MaskRequest::PointAt(suggestion) => state.masking.suggested.pointed = suggestion,
        MaskRequest::ForgetOutcome => state.masking.suggested.outcome = None,
        MaskRequest::Look(photos) => look_for_transients(state, work, photos),
        MaskRequest::Object => mask_object(state, work),
        MaskRequest::GiveUpStroke => drop(state.masking.give_up()),
        MaskRequest::WriteNext => keep_masks(state, work),
        MaskRequest::Report(unusable, therefore) => tell_masks(state, work, unusable, therefore),
        MaskRequest::ReportProblems => tell_problems(state, work),
        MaskRequest::Set(change) => state.set_mask(&change),
        MaskRequest::Choose(unmasked) => choose(work, Purpose::Mask(unmasked)),
    }
}

impl State {
    /// Selects a tool in the photo view, or deselects it where the photo view is visible and already uses it.
    fn take_up(&mut self, tool: MaskTool) {
        let is_on = self.masking.tool == Some(tool);
        if self.switched_in_photo(is_on) != is_on {
            self.masking.toggle(tool);
        }
    }

    /// Returns the new value of a switch of the photo view. Where the view is visible, the switch is toggled; otherwise
    /// the view comes to the front and the switch is turned on, so that no change happens out of sight.
    fn switched_in_photo(&mut self, is_on: bool) -> bool {
        let is_seen = self.panes.is_shown(Pane::Photo);
        self.panes.show(Pane::Photo);
        !is_seen || !is_on
    }

    /// Lets a stroke of the matte brush wait to become paint, like those of the 3D view.
    fn paint_matte(&mut self, stroke: Stroke) {
        let drawn = DrawnStroke { viewpoint: self.space.viewpoint, stroke };
        self.space.brush.waiting.push_back(Arc::new(drawn));
    }

    fn resize_brush(&mut self, factor: f64) {
        if let Some(size) = self.selected_photo_size() {
            self.masking.resize(factor, size);
        }
    }
}

fn mask_object(state: &mut State, work: &mut Work) {
    let (Some(photo), Some(object)) = (state.selected_photo_name(), state.selected_object()) else {
        return;
    };
    let margin_px = state.masking.margin_px;
    queue_mask(
        state,
        work,
        format!("mask of {object} in {photo}"),
        MaskWork::Object { photo, object, margin_px },
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::work::waker::Waker;

    #[test]
    fn a_switch_of_the_photo_shows_the_photo_before_it_switches_anything_off() {
        type Switch = (fn() -> MaskRequest, fn(&State) -> bool);
        const BRUSH: Switch =
            (|| MaskRequest::TakeUp(MaskTool::Brush), |state| state.masking.tool == Some(MaskTool::Brush));
        const LASSO: Switch =
            (|| MaskRequest::TakeUp(MaskTool::Lasso), |state| state.masking.tool == Some(MaskTool::Lasso));
        const UNCOVER: Switch = (|| MaskRequest::Uncover, |state| state.masking.uncovers);
        const SHOW: Switch = (|| MaskRequest::Show, |state| state.masking.shown);
        let (mut state, mut work) = (State::default(), Work::new(Waker::default()));
        let cases =
            [(BRUSH, false), (BRUSH, true), (LASSO, false), (UNCOVER, false), (UNCOVER, true), (SHOW, true)];
        for (place, ((request, on), is_on)) in cases.into_iter().enumerate() {
            state.panes.show(Pane::Photo);
            while on(&state) != is_on {
                apply(&mut state, &mut work, request());
            }
            state.panes.show(Pane::Space);
            apply(&mut state, &mut work, request());
            assert!(on(&state) && state.panes.is_shown(Pane::Photo), "switch {place} from the 3D view");
            apply(&mut state, &mut work, request());
            assert!(!on(&state), "switch {place} in the photo's view");
        }
    }
}
