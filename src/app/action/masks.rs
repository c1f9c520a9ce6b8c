//! Actions on masks: tools, strokes, suggestions, and writing.

use crate::app::masking::MaskTool;
use crate::app::masking::keeping::MaskWork;
use crate::app::masking::keeping::{keep_masks, queue_mask};
use crate::app::masking::repairing::{tell_masks, tell_problems};
use crate::app::masking::suggesting::{accept_suggestions, look_for_transients};
use crate::app::opening::Purpose;
use crate::app::opening::chooser::choose;
use crate::app::state::State;
use crate::app::state::ask::MaskAsk;
use crate::app::state::panes::Pane;
use crate::app::work::Work;

/// Applies an ask about masks.
pub fn apply(state: &mut State, work: &mut Work, ask: MaskAsk) {
    match ask {
        MaskAsk::Mask(name, change) => queue_mask(state, work, name, change),
        MaskAsk::Accept(numbers) => accept_suggestions(state, work, &numbers),
        MaskAsk::Dismiss(numbers) => state.dismiss_suggestions(&numbers),
        MaskAsk::Margin(margin_px) => state.masking.margin_px = margin_px,
        MaskAsk::TakeUp(tool) => state.take_up(tool),
        MaskAsk::Uncover => state.masking.uncovers = state.switched_in_photo(state.masking.uncovers),
        MaskAsk::ResizeBrush(factor) => state.resize_brush(factor),
        MaskAsk::Show => state.masking.shown = state.switched_in_photo(state.masking.shown),
        MaskAsk::Look(photos) => look_for_transients(state, work, photos),
        MaskAsk::Object => mask_object(state, work),
        MaskAsk::GiveUpStroke => drop(state.masking.give_up()),
        MaskAsk::WriteNext => keep_masks(state, work),
        MaskAsk::Report(unusable, therefore) => tell_masks(state, work, unusable, therefore),
        MaskAsk::ReportProblems => tell_problems(state, work),
        MaskAsk::Set(change) => state.set_mask(&change),
        MaskAsk::Choose(unmasked) => choose(work, Purpose::Mask(unmasked)),
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
    use crate::app::command::Command;
    use crate::app::command::mask::{BRUSH, LASSO, SHOW, UNCOVER};
    use crate::app::state::ask::Ask;
    use crate::app::work::waker::Waker;

    #[test]
    fn a_switch_of_the_photo_shows_the_photo_before_it_switches_anything_off() {
        let (mut state, mut work) = (State::default(), Work::new(Waker::default()));
        let mut run = |command: &Command, state: &mut State| match (command.ask)(state) {
            Ask::Mask(ask) => apply(state, &mut work, ask),
            _ => panic!("{} is about masks", command.name),
        };
        for (command, is_on) in [
            (&BRUSH, false),
            (&BRUSH, true),
            (&LASSO, false),
            (&UNCOVER, false),
            (&UNCOVER, true),
            (&SHOW, true),
        ] {
            let on = command.on.expect("it switches");
            state.panes.show(Pane::Photo);
            while on(&state) != is_on {
                run(command, &mut state);
            }
            state.panes.show(Pane::Space);
            run(command, &mut state);
            assert!(on(&state) && state.panes.is_shown(Pane::Photo), "{} from the 3D view", command.name);
            run(command, &mut state);
            assert!(!on(&state), "{} in the photo's view", command.name);
        }
    }
}
