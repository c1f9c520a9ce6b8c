//! Progress reports and cancellation of long computations.
//!
//! Every long computation takes a [`Task`]. It reports steps and notes to the task's observer, and ends with
//! [`Error::Cancelled`] soon after the flag was set.

mod amount;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

pub use self::amount::{has_parts, in_words};
use crate::error::{Error, Message, Result};

/// A message of a long computation to its observer.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// A step of progress: `done` of `total` units of `stage` are finished. `subject` is the photo or file, or
    /// empty.
    Step {
        /// The stage that is in progress.
        stage: &'static str,
        /// The photo or file that the step is about, or empty.
        subject: String,
        /// The number of finished units.
        done: u64,
        /// The number of all units.
        total: u64,
    },
    /// A message for the user about something that did not stop the work.
    Note {
        /// The photo or file that the message is about, or empty.
        subject: String,
        /// The message.
        text: Message,
    },
    /// A fact about the work for users who ask for more.
    Detail {
        /// The photo or file that the fact is about, or empty.
        subject: String,
        /// The fact.
        text: String,
    },
    /// The wall time that a stage took for one subject, on the thread that ran it.
    Timing {
        /// The stage that has ended.
        stage: &'static str,
        /// The photo or file that it worked on, or empty.
        subject: String,
        /// The wall time.
        spent: Duration,
    },
}

type Sink = dyn Fn(Event) + Send + Sync;

/// A handle for progress reports and cancellation. Clones share both.
#[derive(Clone)]
pub struct Task {
    stop: Arc<AtomicBool>,
    /// A second flag that cancels, too.
    also: Option<Arc<AtomicBool>>,
    sink: Arc<Sink>,
    subject: Arc<str>,
    /// Whether steps of all photos together are reported.
    tells_steps: bool,
}

impl Task {
    /// Makes a task whose events go to `sink`, which may be called from any thread.
    pub fn new(sink: impl Fn(Event) + Send + Sync + 'static) -> Self {
        Self { stop: Arc::default(), also: None, sink: Arc::new(sink), subject: "".into(), tells_steps: true }
    }

    /// Makes a task without an observer; it can still be cancelled.
    pub fn silent() -> Self {
        Self::new(|_| ())
    }

    /// Returns the same task with its events attributed to one photo or file.
    pub fn with_subject(&self, subject: &str) -> Self {
        Self { subject: subject.into(), ..self.clone() }
    }

    /// Returns the same task with another flag for cancellation, for one of many short jobs that report to the same
    /// sink.
    pub fn with_stop_flag(&self, stop: Arc<AtomicBool>) -> Self {
        Self { stop, ..self.clone() }
    }

    /// Returns the same task, which a second flag cancels as well as its own, for one of many parts of a job.
    pub fn also_stopped_by(&self, also: Arc<AtomicBool>) -> Self {
        Self { also: Some(also), ..self.clone() }
    }

    /// Returns the same task for a part of a stage whose steps the caller reports: only steps of single photos are
    /// reported as well.
    pub fn within_step(&self) -> Self {
        Self { tells_steps: false, ..self.clone() }
    }

    /// Returns the flag that cancels the task when set (for signal handlers and cancel buttons).
    pub fn stop_flag(&self) -> Arc<AtomicBool> {
        self.stop.clone()
    }

    /// Reports progress and checks for cancellation: `done` of `total` units of `stage` are finished.
    ///
    /// # Errors
    /// Returns [`Error::Cancelled`] when the task was cancelled.
    pub fn step(&self, stage: &'static str, done: u64, total: u64) -> Result<()> {
        self.check_cancelled()?;
        if self.tells_steps || !self.subject.is_empty() {
            (self.sink)(Event::Step { stage, subject: self.subject.to_string(), done, total });
        }
        Ok(())
    }

    /// Checks for cancellation.
    ///
    /// # Errors
    /// Returns [`Error::Cancelled`] when the task was cancelled.
    pub fn check_cancelled(&self) -> Result<()> {
        let is_set = |flag: &Arc<AtomicBool>| flag.load(Ordering::Relaxed);
        if is_set(&self.stop) || self.also.as_ref().is_some_and(is_set) {
            return Err(Error::Cancelled);
        }
        Ok(())
    }

    /// Reports something that the user should know and that does not stop the work.
    pub fn note(&self, text: impl Into<Message>) {
        (self.sink)(Event::Note { subject: self.subject.to_string(), text: text.into() });
    }

    /// Reports a fact about the work for users who ask for more.
    pub fn detail(&self, text: impl Into<String>) {
        (self.sink)(Event::Detail { subject: self.subject.to_string(), text: text.into() });
    }

    /// Runs `work` and reports its wall time as `stage`.
    pub fn timed<T>(&self, stage: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        let spent = start.elapsed();
        (self.sink)(Event::Timing { stage, subject: self.subject.to_string(), spent });
        result
    }
}
