//! Checks the paths of a dialog on disk, in a job, while the user types.

use std::time::Instant;

use crate::app::state::State;
use crate::app::state::running::JobKind;
use crate::app::work::Work;
use crate::app::work::jobs::arrival;
use crate::recipe::discover::{DiscoveryReport, SiteParts, look_at};

/// The time without typing after which a path is checked, in seconds.
const TYPED_S: f64 = 0.35;
/// Files change while a dialog is open, for example when a model is exported again: paths are checked at this interval,
/// in seconds,
const AGAIN_S: f64 = 2.0;
/// and where a check is slow, as on a network drive, it takes no more than this share of the time.
const SHARE: f64 = 0.05;

/// The paths of a dialog, and the last check of them.
#[derive(Default)]
pub struct Looking {
    wanted: SiteParts,
    since_s: f64,
    asked: Option<SiteParts>,
    asked_s: f64,
    /// The duration of the last check, in seconds.
    took_s: f64,
    /// The result of the last check, maybe of other paths than the current ones.
    pub look: Option<DiscoveryReport>,
}

impl Looking {
    /// Sets the current paths.
    pub fn want(&mut self, parts: SiteParts, now_s: f64) {
        if self.wanted != parts {
            (self.wanted, self.since_s) = (parts, now_s);
        }
    }

    /// Returns the result for the current paths, once it is known.
    pub fn now(&self) -> Option<&DiscoveryReport> {
        self.look.as_ref().filter(|look| look.parts() == self.wanted)
    }
}

/// Starts a check of the paths when one is due.
pub fn keep_looking(state: &mut State, work: &mut Work) {
    let now_s = state.window.now_s;
    let is_shown = state.opening.assistant.is_some() || state.opening.relinking.is_some();
    let looking = &mut state.opening.looking;
    let is_new = looking.asked.as_ref().unwrap_or(&SiteParts::default()) != &looking.wanted;
    // A check is only repeated once its result was seen.
    if !is_new && (!is_shown || looking.asked.is_none() || state.running.runs(JobKind::Paths)) {
        return;
    }
    let due_s = if is_new {
        looking.since_s + TYPED_S
    } else {
        looking.asked_s + AGAIN_S.max(looking.took_s / SHARE)
    };
    let rest_s = due_s - now_s;
    if rest_s > 0.0 {
        return state.window.wake_within(rest_s);
    }
    let (parts, before) = (looking.wanted.clone(), looking.look.clone());
    (looking.asked, looking.asked_s) = (Some(parts.clone()), now_s);
    work.jobs.stop_kind(&mut state.running, JobKind::Paths);
    work.jobs.start(&mut state.running, JobKind::Paths, "Looking at files", move |task| {
        let since = Instant::now();
        let look = look_at(&parts, before.as_ref(), task)?;
        let took_s = since.elapsed().as_secs_f64();
        Ok(arrival(move |state| {
            // A later check may have been started, and may even have finished first.
            if state.opening.looking.asked.as_ref() == Some(&look.parts()) {
                state.opening.looking.look = Some(look);
                state.opening.looking.took_s = took_s;
            }
        }))
    });
}
