//! The life cycle of a project, how it is left and recovered: one state machine, without a window, threads or files.
//!
//! A project is left to close it, to open or create another one, or to quit. Neither unsaved decisions nor files that a
//! job is writing may be lost. [`Phase::next`] defines the next state and the effect for every state and event;
//! `action::life` executes effects, `panel::closing` draws the questions.
//!
//! | state | event | condition | next state | effect |
//! |---|---|---|---|---|
//! | any | Leave | there are unsaved changes | Asking | |
//! | any | Leave | all is saved, a job writes | Writing | |
//! | any | Leave | all is saved, no job writes | Staying | Go |
//! | Asking | Save | | Saving | Save, if no mask is pending |
//! | Asking, Saving | Discard | a job writes | Writing, discards | |
//! | Asking, Saving | Discard | no job writes | Staying | Go, discards |
//! | Saving | Frame | no mask is pending | Saving | Save |
//! | Saving | Saved | it failed | Asking, with the error | |
//! | Saving | Saved | a job writes | Writing | |
//! | Saving | Saved | no job writes | Staying | Go |
//! | Writing, Waiting | Stop | | Waiting | StopWriting |
//! | Writing | Wait | | Waiting | |
//! | Writing, Waiting | Frame | no job writes any more | Staying | Go |
//! | any but Staying | Stay | | Staying | |
//!
//! Every other event changes nothing. `Go` carries out the goal; nothing is closed before.
//!
//! The autosave ([`Autosave`]) keeps unsaved changes on disk, however the program ends. When such a file is found on
//! opening a project, it stays unchanged until the user has answered ([`Life::found`], [`Life::answer`]): its changes
//! are restored as a step of the history, or discarded.

use std::path::PathBuf;

use quadratura_document::masks::Masks;
use quadratura_io::recovery::UnsavedChanges;

/// The reason why a project is left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Goal {
    /// To close it.
    Close,
    /// To open another project.
    Open(PathBuf),
    /// To create the project that the assistant describes.
    Create,
    /// To end the program.
    Quit,
}

/// An event of the life cycle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LifeEvent {
    /// The user wants to leave the project.
    Leave(Goal),
    /// The user chose to save the changes.
    Save,
    /// The user chose to discard the changes.
    Discard,
    /// The user chose not to leave the project.
    Stay,
    /// Saving ended, maybe with an error.
    Saved(Result<(), String>),
    /// The user chose to stop running writes.
    Stop,
    /// The user chose to wait for running writes.
    Wait,
    /// A frame began: masks may be written, and jobs may have ended.
    Frame,
}

/// The facts that transitions depend on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Facts {
    /// Whether there are unsaved changes.
    pub is_dirty: bool,
    /// Whether a mask edit is still to be written.
    pub masks_wait: bool,
    /// Whether a job writes files that the user waits for, or strokes of the brush are not paint yet.
    pub writes: bool,
}

/// An effect of a transition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Effect {
    /// Saves the project; [`LifeEvent::Saved`] reports the result.
    Save,
    /// Stops the jobs that write.
    StopWriting,
    /// Leaves the project and carries out the goal.
    Go {
        /// The reason why the project is left.
        goal: Goal,
        /// Whether unsaved changes are discarded.
        discards: bool,
    },
}

/// The phase of leaving a project.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Phase {
    /// The project is not being left.
    #[default]
    Staying,
    /// The user is asked about unsaved changes.
    Asking {
        /// The reason why the project is left.
        goal: Goal,
        /// The error of saving, if it failed.
        failed: Option<String>,
    },
    /// The project is saved as soon as pending masks are written.
    Saving {
        /// The reason why the project is left.
        goal: Goal,
    },
    /// The user is asked about running writes.
    Writing {
        /// The reason why the project is left.
        goal: Goal,
        /// Whether unsaved changes are discarded.
        discards: bool,
    },
    /// The project is left as soon as no job writes any more.
    Waiting {
        /// The reason why the project is left.
        goal: Goal,
        /// Whether unsaved changes are discarded.
        discards: bool,
    },
}

impl Phase {
    /// Returns the next state after an event, and its effect, as in the module's table.
    pub fn next(self, event: LifeEvent, facts: Facts) -> (Self, Option<Effect>) {
        match (self, event) {
            (_, LifeEvent::Leave(goal)) if facts.is_dirty => (Self::Asking { goal, failed: None }, None),
            (_, LifeEvent::Leave(goal)) => past_saving(goal, false, facts),
            (Self::Asking { goal, .. }, LifeEvent::Save) => saving(goal, facts),
            (Self::Saving { goal }, LifeEvent::Frame) => saving(goal, facts),
            (Self::Asking { goal, .. } | Self::Saving { goal }, LifeEvent::Discard) => {
                past_saving(goal, true, facts)
            }
            (Self::Saving { goal }, LifeEvent::Saved(Ok(()))) => past_saving(goal, false, facts),
            (Self::Saving { goal }, LifeEvent::Saved(Err(why))) => {
                (Self::Asking { goal, failed: Some(why) }, None)
            }
            (Self::Writing { goal, discards } | Self::Waiting { goal, discards }, LifeEvent::Stop) => {
                (Self::Waiting { goal, discards }, Some(Effect::StopWriting))
            }
            (Self::Writing { goal, discards }, LifeEvent::Wait) => (Self::Waiting { goal, discards }, None),
            (Self::Writing { goal, discards } | Self::Waiting { goal, discards }, LifeEvent::Frame)
                if !facts.writes =>
            {
                (Self::Staying, Some(Effect::Go { goal, discards }))
            }
            (_, LifeEvent::Stay) => (Self::Staying, None),
            (phase, _) => (phase, None),
        }
    }
}

/// Saves the project at once, or when pending masks are written.
fn saving(goal: Goal, facts: Facts) -> (Phase, Option<Effect>) {
    (Phase::Saving { goal }, (!facts.masks_wait).then_some(Effect::Save))
}

/// Leaves the project after saving, unless a job still writes.
fn past_saving(goal: Goal, discards: bool, facts: Facts) -> (Phase, Option<Effect>) {
    match facts.writes {
        true => (Phase::Writing { goal, discards }, None),
        false => (Phase::Staying, Some(Effect::Go { goal, discards })),
    }
}

/// Unsaved changes that were found from an earlier run.
#[derive(Debug)]
pub struct Recovery {
    /// The project with its unsaved changes.
    pub found: UnsavedChanges,
    /// The masks of the project at that time: masks added since are kept.
    pub masks: Masks,
}

/// The life cycle of the open project.
#[derive(Debug, Default)]
pub struct Life {
    /// The phase of leaving the project.
    pub phase: Phase,
    /// The unsaved changes that the user is asked about after a crash.
    pub recovery: Option<Recovery>,
    quits: bool,
}

impl Life {
    /// Returns whether the user is asked about unsaved changes.
    pub fn is_asking(&self) -> bool {
        matches!(self.phase, Phase::Asking { .. } | Phase::Saving { .. }) || self.recovery.is_some()
    }

    /// Returns whether the user is asked about running writes, or waits for them.
    pub fn asks_about_writing(&self) -> bool {
        matches!(self.phase, Phase::Writing { .. } | Phase::Waiting { .. })
    }

    /// Returns whether the program quits without any further question.
    pub fn quits(&self) -> bool {
        self.quits
    }

    /// Makes the program quit.
    pub fn quit(&mut self) {
        self.quits = true;
    }

    /// Stores unsaved changes that were found from an earlier run.
    pub fn found(&mut self, found: UnsavedChanges, masks: Masks) {
        self.recovery = Some(Recovery { found, masks });
    }

    /// Takes the unsaved changes when the user has answered.
    pub fn answer(&mut self) -> Option<Recovery> {
        self.recovery.take()
    }

    /// Closes the open question, because the project is closed.
    pub fn closed(&mut self) {
        *self = Self { quits: self.quits, ..Self::default() };
    }
}

/// The time without an edit, in seconds, after which an ongoing gesture is saved: a slider that is being dragged is not
/// written at every step. All other edits are saved at once.
const KEPT_AFTER_S: f64 = 0.4;
/// The longest time between the first unsaved edit and the autosave, in seconds: continuous work loses no more.
const KEPT_AT_LATEST_S: f64 = 2.0;
/// The time until a failed autosave is tried again, in seconds: a full disk may have free space again.
const KEPT_AGAIN_S: f64 = 5.0;

/// The schedule of the autosave.
///
/// | state | event | next state |
/// |---|---|---|
/// | any | edited | due, and the autosave gets the contents of the file |
/// | due, in a gesture | the gesture ends | due at once |
/// | due | it is time ([`Self::begins`]) | kept |
/// | kept | writing failed | due again after a delay |
/// | any | saved, or discarded | kept: nothing is left to be written |
#[derive(Debug, Default, Clone, PartialEq)]
pub struct Autosave {
    is_due: bool,
    /// Whether the autosave does not know of the last edit yet.
    is_news: bool,
    /// Whether a gesture continues, of which only the end matters.
    in_gesture: bool,
    edited_s: f64,
    /// The time of the first edit that is not saved, in seconds.
    unkept_s: f64,
    /// The earliest time of the next try, in seconds, after a failed one.
    not_before_s: f64,
}

impl Autosave {
    /// Records an edit.
    pub fn edited(&mut self, in_gesture: bool, now_s: f64) {
        if !self.is_due {
            self.unkept_s = now_s;
        }
        (self.is_due, self.is_news) = (true, true);
        (self.in_gesture, self.edited_s) = (in_gesture, now_s);
    }

    /// Records the end of the gesture.
    pub fn gesture_ended(&mut self) {
        self.in_gesture = false;
    }

    /// Records that writing failed.
    pub fn failed(&mut self, now_s: f64) {
        self.edited(false, now_s);
        self.not_before_s = now_s + KEPT_AGAIN_S;
    }

    /// Returns whether the autosave has to get the last edit, once for each edit.
    pub fn take_news(&mut self) -> bool {
        std::mem::take(&mut self.is_news)
    }

    /// Returns whether an edit waits to be written.
    pub fn is_due(&self) -> bool {
        self.is_due
    }

    /// Returns the time until the next check, in seconds.
    pub fn rest_s(&self) -> f64 {
        KEPT_AFTER_S
    }

    /// Returns whether writing starts now; it is not due any more then.
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
