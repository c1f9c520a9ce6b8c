//! The end of the window: nothing is asked any more, and nothing is lost.

use std::time::{Duration, Instant};

use super::brush::paint_strokes;
use super::saving::keep_now;
use super::take_in;
use crate::action::masks::keeping::keep_masks;
use crate::state::State;
use crate::state::running::JobKind;
use crate::work::Work;

/// The longest time that closing waits for masks that are being written: a slow disk takes some seconds.
const LAST_WAIT: Duration = Duration::from_secs(8);
/// The longest time that closing waits for strokes of the brush that are not paint yet: each takes some seconds.
const LAST_STROKES: Duration = Duration::from_secs(60);
/// The interval at which closing checks whether they are written.
const LOOKS_EVERY: Duration = Duration::from_millis(4);

/// Ends the window, for any reason: writes pending masks, paints pending strokes, and keeps unsaved changes that were not
/// discarded.
pub fn end(state: &mut State, work: &mut Work) {
    state.space.brush.end();
    let paints = state.space.brush.is_painting;
    work.jobs.stop_all_but(&mut state.running, |kind| {
        kind == JobKind::Mask || (paints && kind == JobKind::Import)
    });
    let since = Instant::now();
    let waits = |state: &State| {
        let passed = since.elapsed();
        let masks = !state.masking.is_kept() && passed < LAST_WAIT;
        state.session.is_some() && (masks || (state.space.brush.unpainted() > 0 && passed < LAST_STROKES))
    };
    while waits(state) {
        take_in(state, work);
        keep_masks(state, work);
        paint_strokes(state, work);
        std::thread::sleep(LOOKS_EVERY);
    }
    keep_now(state, work);
    work.jobs.stop_all(&mut state.running);
}
