//! Progress and stop of a long computation.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::error::{Error, Result};

/// What a long computation tells whoever watches it.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// `done` of `total` units of `stage` are finished. `subject` is the photo or file, or empty.
    Step { stage: &'static str, subject: String, done: u64, total: u64 },
    /// Something the user should know and that did not stop the work.
    Note { subject: String, text: String },
    /// A stage of one subject took this long (wall time of the thread that ran it).
    Timing { stage: &'static str, subject: String, spent: Duration },
}

type Sink = dyn Fn(Event) + Send + Sync;

/// A handle to report progress with and to be stopped by. Cloning shares both.
#[derive(Clone)]
pub struct Task {
    stop: Arc<AtomicBool>,
    sink: Arc<Sink>,
    subject: Arc<str>,
}

impl Task {
    /// A task whose events go to `sink`, which may be called from any thread.
    pub fn new(sink: impl Fn(Event) + Send + Sync + 'static) -> Self {
        Self { stop: Arc::default(), sink: Arc::new(sink), subject: "".into() }
    }

    /// Nobody watches; it can still be stopped.
    pub fn silent() -> Self {
        Self::new(|_| ())
    }

    /// The same task, with its events attributed to one photo or file.
    pub fn of(&self, subject: &str) -> Self {
        Self { subject: subject.into(), ..self.clone() }
    }

    /// The same task, stopped by another flag: for one of many short works that are told to the same sink.
    pub fn stopped_by(&self, stop: Arc<AtomicBool>) -> Self {
        Self { stop, ..self.clone() }
    }

    /// The flag that stops the task when set (for signal handlers and cancel buttons).
    pub fn stop_flag(&self) -> Arc<AtomicBool> {
        self.stop.clone()
    }

    /// Progress and stop in one: `done` of `total` units of `stage` are finished.
    ///
    /// # Errors
    /// [`Error::Cancelled`] when somebody asked to stop.
    pub fn step(&self, stage: &'static str, done: u64, total: u64) -> Result<()> {
        self.go_on()?;
        (self.sink)(Event::Step { stage, subject: self.subject.to_string(), done, total });
        Ok(())
    }

    /// # Errors
    /// [`Error::Cancelled`] when somebody asked to stop.
    pub fn go_on(&self) -> Result<()> {
        if self.stop.load(Ordering::Relaxed) { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// Something the user should know and that does not stop the work.
    pub fn note(&self, text: impl Into<String>) {
        (self.sink)(Event::Note { subject: self.subject.to_string(), text: text.into() });
    }

    /// Runs `work` and reports how long it took as `stage`.
    pub fn timed<T>(&self, stage: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        let spent = start.elapsed();
        (self.sink)(Event::Timing { stage, subject: self.subject.to_string(), spent });
        result
    }
}
