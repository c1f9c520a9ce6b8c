//! How a project is left, and what is asked after a crash: one state machine, without a window, threads or files.
//!
//! A project is left to close it, to open or make another one, or to quit. Nothing may be lost by that: neither what was
//! decided and not saved, nor what a job is writing. [`Phase::next`] says for every state and event what comes next
//! and what has to be done; `action::life` does it and draws nothing, `panel::leaving` draws the questions.
//!
//! | state | event | condition | next state | effect |
//! |---|---|---|---|---|
//! | any | Leave | something is not saved | Asking | |
//! | any | Leave | all is saved, a job writes | Writing | |
//! | any | Leave | all is saved, no job writes | Staying | Go |
//! | Asking | Save | | Saving | Save, if no mask waits |
//! | Asking, Saving | Discard | a job writes | Writing, discards | |
//! | Asking, Saving | Discard | no job writes | Staying | Go, discards |
//! | Saving | Frame | no mask waits | Saving | Save |
//! | Saving | Saved | it failed | Asking, says why | |
//! | Saving | Saved | a job writes | Writing | |
//! | Saving | Saved | no job writes | Staying | Go |
//! | Writing, Waiting | Stop | | Waiting | StopWriting |
//! | Writing | Wait | | Waiting | |
//! | Writing, Waiting | Frame | no job writes any more | Staying | Go |
//! | any but Staying | Stay | | Staying | |
//!
//! Every other event changes nothing. `Go` hands over to what the goal says; only then is anything closed.
//!
//! What is not saved is kept on disk by the autosave ([`Autosave`]), for whatever way the program ends. When a project is
//! opened and such a file is found, it is held as it is until the user has answered ([`Life::found`],
//! [`Life::answer`]): restored as a step of the history, or discarded.

use std::path::PathBuf;

use crate::document::masks::Masks;
use crate::io::recovery::UnsavedChanges;

/// Why a project is left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Goal {
    /// To close it.
    Close,
    /// To open another project.
    Open(PathBuf),
    /// To make the project that the assistant describes.
    Create,
    /// To end the program.
    Quit,
}

/// What happens to a project that may be left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Event {
    /// The user wants to leave.
    Leave(Goal),
    /// What is not saved is to be saved.
    Save,
    /// What is not saved is to be discarded.
    Discard,
    /// The project is not left.
    Stay,
    /// The project was saved, or why it was not.
    Saved(Result<(), String>),
    /// What is being written is to be stopped.
    Stop,
    /// What is being written is to be waited for.
    Wait,
    /// Time has passed: masks may be written, and jobs may have ended.
    Frame,
}

/// What is true of the project when something happens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Facts {
    /// Something is not saved.
    pub is_dirty: bool,
    /// A mask that was drawn is still to be written.
    pub masks_wait: bool,
    /// A job writes files that the user waits for.
    pub writes: bool,
}

/// What has to be done.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Effect {
    /// Saves the project; [`Event::Saved`] says how that went.
    Save,
    /// Asks the jobs that write to stop.
    StopWriting,
    /// Leaves the project.
    Go {
        /// Where to.
        goal: Goal,
        /// What is not saved is discarded.
        discards: bool,
    },
}

/// How far the leaving of a project is.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Phase {
    /// Nobody leaves.
    #[default]
    Staying,
    /// The user is asked what becomes of what is not saved.
    Asking {
        /// Why the project is left.
        goal: Goal,
        /// Why it could not be saved, where that was tried.
        failed: Option<String>,
    },
    /// The project is saved as soon as masks that wait are written.
    Saving {
        /// Why the project is left.
        goal: Goal,
    },
    /// The user is asked what becomes of what is being written.
    Writing {
        /// Why the project is left.
        goal: Goal,
        /// What is not saved is discarded.
        discards: bool,
    },
    /// The project is left as soon as nothing is written any more.
    Waiting {
        /// Why the project is left.
        goal: Goal,
        /// What is not saved is discarded.
        discards: bool,
    },
}

impl Phase {
    /// The state after an event, and what has to be done. The table is the module's.
    pub fn next(self, event: Event, facts: Facts) -> (Self, Option<Effect>) {
        match (self, event) {
            (_, Event::Leave(goal)) if facts.is_dirty => (Self::Asking { goal, failed: None }, None),
            (_, Event::Leave(goal)) => past_saving(goal, false, facts),
            (Self::Asking { goal, .. }, Event::Save) => saving(goal, facts),
            (Self::Saving { goal }, Event::Frame) => saving(goal, facts),
            (Self::Asking { goal, .. } | Self::Saving { goal }, Event::Discard) => {
                past_saving(goal, true, facts)
            }
            (Self::Saving { goal }, Event::Saved(Ok(()))) => past_saving(goal, false, facts),
            (Self::Saving { goal }, Event::Saved(Err(why))) => {
                (Self::Asking { goal, failed: Some(why) }, None)
            }
            (Self::Writing { goal, discards } | Self::Waiting { goal, discards }, Event::Stop) => {
                (Self::Waiting { goal, discards }, Some(Effect::StopWriting))
            }
            (Self::Writing { goal, discards }, Event::Wait) => (Self::Waiting { goal, discards }, None),
            (Self::Writing { goal, discards } | Self::Waiting { goal, discards }, Event::Frame)
                if !facts.writes =>
            {
                (Self::Staying, Some(Effect::Go { goal, discards }))
            }
            (_, Event::Stay) => (Self::Staying, None),
            (phase, _) => (phase, None),
        }
    }
}

/// The project is saved at once, or when masks that wait are written.
fn saving(goal: Goal, facts: Facts) -> (Phase, Option<Effect>) {
    (Phase::Saving { goal }, (!facts.masks_wait).then_some(Effect::Save))
}

/// Nothing is left to be saved: the project is left, unless that ends something that writes.
fn past_saving(goal: Goal, discards: bool, facts: Facts) -> (Phase, Option<Effect>) {
    match facts.writes {
        true => (Phase::Writing { goal, discards }, None),
        false => (Phase::Staying, Some(Effect::Go { goal, discards })),
    }
}

/// What was found that was not saved when the program ended last.
#[derive(Debug)]
pub struct Recovery {
    /// The project as it was then.
    pub found: UnsavedChanges,
    /// The masks of the project when that was found: masks that came since stay.
    pub masks: Masks,
}

/// How the open project may end, and what is left of the last time.
#[derive(Debug, Default)]
pub struct Life {
    /// How far the leaving of the project is.
    pub phase: Phase,
    /// What the user is asked about after a crash.
    pub recovery: Option<Recovery>,
    quits: bool,
}

impl Life {
    /// The user is asked about something that is not saved.
    pub fn asks(&self) -> bool {
        matches!(self.phase, Phase::Asking { .. } | Phase::Saving { .. }) || self.recovery.is_some()
    }

    /// The user is asked about something that is being written, or waits for it.
    pub fn asks_about_writing(&self) -> bool {
        matches!(self.phase, Phase::Writing { .. } | Phase::Waiting { .. })
    }

    /// The program ends: nothing is asked any more.
    pub fn quits(&self) -> bool {
        self.quits
    }

    /// The program is to end.
    pub fn quit(&mut self) {
        self.quits = true;
    }

    /// Something was found that was not saved when the program ended last.
    pub fn found(&mut self, found: UnsavedChanges, masks: Masks) {
        self.recovery = Some(Recovery { found, masks });
    }

    /// The user has answered what becomes of it.
    pub fn answer(&mut self) -> Option<Recovery> {
        self.recovery.take()
    }

    /// The project is closed: what was asked about it is asked no more.
    pub fn closed(&mut self) {
        *self = Self { quits: self.quits, ..Self::default() };
    }
}

/// A gesture that goes on is kept when nothing has been edited for so long, in seconds: a slider that is being dragged
/// is not written at every step. Every other edit is kept at once.
const KEPT_AFTER_S: f64 = 0.4;
/// At the latest it is kept so long after the first edit that is not, in seconds: a user who works without a rest loses
/// no more than that.
const KEPT_AT_LATEST_S: f64 = 2.0;
/// Where it could not be kept, that is tried again after so long, in seconds: a disk was full, and may not be any more.
const KEPT_AGAIN_S: f64 = 5.0;

/// When the autosave writes what is not saved.
///
/// | state | event | next state |
/// |---|---|---|
/// | any | edited | due, and the autosave is told what the file is to hold |
/// | due, in a gesture | the gesture ends | due at once |
/// | due | it is time ([`Self::begins`]) | kept |
/// | kept | writing failed | due again after a rest |
/// | any | saved, or discarded | kept: nothing is left to be written |
#[derive(Debug, Default, Clone, PartialEq)]
pub struct Autosave {
    is_due: bool,
    /// The autosave was not told of it yet.
    is_news: bool,
    /// A gesture goes on, of which only the end matters.
    in_gesture: bool,
    edited_s: f64,
    /// When the first edit was made that is not kept.
    unkept_s: f64,
    /// It is not kept before: the last try failed.
    not_before_s: f64,
}

impl Autosave {
    /// Something was edited.
    pub fn edited(&mut self, in_gesture: bool, now_s: f64) {
        if !self.is_due {
            self.unkept_s = now_s;
        }
        (self.is_due, self.is_news) = (true, true);
        (self.in_gesture, self.edited_s) = (in_gesture, now_s);
    }

    /// The gesture has ended.
    pub fn gesture_ended(&mut self) {
        self.in_gesture = false;
    }

    /// It could not be written.
    pub fn failed(&mut self, now_s: f64) {
        self.edited(false, now_s);
        self.not_before_s = now_s + KEPT_AGAIN_S;
    }

    /// Whether the autosave has to be told of something, once for each edit.
    pub fn take_news(&mut self) -> bool {
        std::mem::take(&mut self.is_news)
    }

    /// Something waits to be written.
    pub fn is_due(&self) -> bool {
        self.is_due
    }

    /// How long it can rest until it has to be asked again, in seconds.
    pub fn rest_s(&self) -> f64 {
        KEPT_AFTER_S
    }

    /// Whether it is written now; if so it is not due any more.
    pub fn begins(&mut self, now_s: f64) -> bool {
        let begins = self.is_time(now_s);
        self.is_due &= !begins;
        begins
    }

    fn is_time(&self, now_s: f64) -> bool {
        let rests = now_s - self.edited_s >= KEPT_AFTER_S || now_s - self.unkept_s >= KEPT_AT_LATEST_S;
        self.is_due && (rests || !self.in_gesture) && now_s >= self.not_before_s
    }
}

#[cfg(test)]
mod tests;
