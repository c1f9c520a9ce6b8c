//! The end of the window: nothing is asked any more, and nothing is lost.

use std::time::{Duration, Instant};

use super::saving::keep_now;
use super::take_in;
use crate::app::action::masks::keeping::keep_masks;
use crate::app::state::State;
use crate::app::state::running::JobKind;
use crate::app::work::Work;

/// The longest time that closing waits for masks that are being written: a slow disk takes some seconds.
const LAST_WAIT: Duration = Duration::from_secs(8);
/// The interval at which closing checks whether they are written.
const LOOKS_EVERY: Duration = Duration::from_millis(4);

/// Ends the window, for any reason: writes pending masks, and keeps unsaved changes that were not discarded.
pub fn end(state: &mut State, work: &mut Work) {
    work.jobs.stop_all_but(&mut state.running, JobKind::Mask);
    let since = Instant::now();
    while !state.masking.is_kept() && state.session.is_some() && since.elapsed() < LAST_WAIT {
        take_in(state, work);
        keep_masks(state, work);
        std::thread::sleep(LOOKS_EVERY);
    }
    keep_now(state, work);
    work.jobs.stop_all(&mut state.running);
}
