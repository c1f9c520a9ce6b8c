//! What is at the paths of a dialog, looked at beside the window while somebody types.

use std::time::Instant;

use crate::app::state::State;
use crate::app::state::running::Kind;
use crate::app::work::Work;
use crate::app::work::jobs::arrival;
use crate::recipe::discover::{Look, Parts, look_at};

/// A path that did not change for so long is meant, not still being typed.
const TYPED_S: f64 = 0.35;
/// Files change while a dialog is open, as when a model is exported again: it is looked so often,
const AGAIN_S: f64 = 2.0;
/// and where a look takes long, as on a drive far away, no more than so much of the time goes into it.
const SHARE: f64 = 0.05;

/// What is wanted, and what was seen last.
#[derive(Default)]
pub struct Looking {
    wanted: Parts,
    since_s: f64,
    asked: Option<Parts>,
    asked_s: f64,
    /// How long the last look took.
    took_s: f64,
    /// What was seen, maybe of other paths than are wanted now.
    pub look: Option<Look>,
}

impl Looking {
    /// These are the paths now.
    pub fn want(&mut self, parts: Parts, now_s: f64) {
        if self.wanted != parts {
            (self.wanted, self.since_s) = (parts, now_s);
        }
    }

    /// What is there, once it is known of the paths as they are.
    pub fn now(&self) -> Option<&Look> {
        self.look.as_ref().filter(|look| look.parts() == self.wanted)
    }
}

/// Looks at paths that have been typed to their end.
pub fn keep_looking(state: &mut State, work: &mut Work) {
    let now_s = state.window.now_s;
    let is_shown = state.opening.assistant.is_some() || state.opening.relinking.is_some();
    let looking = &mut state.opening.looking;
    let is_new = looking.asked.as_ref().unwrap_or(&Parts::default()) != &looking.wanted;
    // What is looked at is not asked for again before it is seen.
    if !is_new && (!is_shown || looking.asked.is_none() || state.running.runs(Kind::Paths)) {
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
    work.jobs.stop_kind(&mut state.running, Kind::Paths);
    work.jobs.start(&mut state.running, Kind::Paths, "Looking at files", move |task| {
        let since = Instant::now();
        let look = look_at(&parts, before.as_ref(), task)?;
        let took_s = since.elapsed().as_secs_f64();
        Ok(arrival(move |state| {
            // A later look may have been asked for, and may even have been quicker.
            if state.opening.looking.asked.as_ref() == Some(&look.parts()) {
                state.opening.looking.look = Some(look);
                state.opening.looking.took_s = took_s;
            }
        }))
    });
}
