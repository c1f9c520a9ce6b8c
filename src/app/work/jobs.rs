//! Long work beside the window: each job a thread, told of by events, stopped by a flag.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use super::waker::Waker;
use crate::app::state::State;
use crate::app::state::ask::Ask;
use crate::app::state::notes::{Note, Weight};
use crate::app::state::running::{Job, JobId, Kind, Running};
use crate::error::{Error, Result};
use crate::task::{Event, Task};

/// What a job brings back: run by the window's thread on the state; returns what is to be done next.
pub type Arrival = Box<dyn FnOnce(&mut State) -> Vec<Ask> + Send>;

/// What changes the state, and after which nothing is left to be done.
pub fn arrival(change: impl FnOnce(&mut State) + Send + 'static) -> Arrival {
    Box::new(|state| {
        change(state);
        Vec::new()
    })
}

enum Message {
    Told(JobId, Event),
    Ended(JobId, Result<Arrival>),
}

/// The threads of the jobs. What is known of each stands in [`Running`].
pub struct Jobs {
    next: u64,
    stops: BTreeMap<JobId, Arc<AtomicBool>>,
    send: Sender<Message>,
    receive: Receiver<Message>,
    waker: Waker,
    threads: Vec<JoinHandle<()>>,
}

impl Jobs {
    /// None yet; the window is woken whenever a job has something to say.
    pub fn new(waker: Waker) -> Self {
        let (send, receive) = channel();
        Self { next: 0, stops: BTreeMap::new(), send, receive, waker, threads: Vec::new() }
    }

    /// Asks all that write to stop.
    pub fn stop_writing(&self, running: &mut Running) {
        self.stop_those(running, |_, job| job.kind.writes());
    }

    /// Asks one to stop.
    pub fn stop(&self, running: &mut Running, id: JobId) {
        self.stop_those(running, |other, _| other == id);
    }

    /// Asks all of a kind to stop.
    pub fn stop_kind(&self, running: &mut Running, kind: Kind) {
        self.stop_those(running, |_, job| job.kind == kind);
    }

    /// Asks all to stop that are not of this kind.
    pub fn stop_all_but(&self, running: &mut Running, kind: Kind) {
        self.stop_those(running, |_, job| job.kind != kind);
    }

    /// Asks all to stop.
    pub fn stop_all(&self, running: &mut Running) {
        self.stop_those(running, |_, _| true);
    }

    fn stop_those(&self, running: &mut Running, are: impl Fn(JobId, &Job) -> bool) {
        for id in running.stopping(are) {
            self.stops.get(&id).into_iter().for_each(|stop| stop.store(true, Ordering::Relaxed));
        }
    }

    /// Starts one. What it returns is run on the window's thread; what goes wrong, a panic too, becomes a note.
    pub fn start(
        &mut self,
        running: &mut Running,
        kind: Kind,
        name: impl Into<String>,
        work: impl FnOnce(&Task) -> Result<Arrival> + Send + 'static,
    ) -> JobId {
        let id = JobId(self.next);
        self.next += 1;
        let (send, waker) = (self.send.clone(), self.waker.clone());
        let tell = move |message: Message| {
            // The window is being closed: nobody is left to be told.
            let _ = send.send(message);
            waker.wake();
        };
        let told = tell.clone();
        let task = Task::new(move |event| told(Message::Told(id, event)));
        let job = Job::new(kind, name.into());
        let thread_name = job.name.clone();
        running.begun(id, job);
        self.stops.insert(id, task.stop_flag());
        let run = move || {
            let ended =
                catch_unwind(AssertUnwindSafe(|| work(&task))).unwrap_or_else(|panic| Err(fault(&*panic)));
            tell(Message::Ended(id, ended));
        };
        match std::thread::Builder::new().name(thread_name).spawn(run) {
            Ok(thread) => self.threads.push(thread),
            Err(error) => {
                let refused = Error::Request(format!("the system gives no thread for it: {error}"));
                let _ = self.send.send(Message::Ended(id, Err(refused)));
            }
        }
        id
    }

    /// What has been said since the last time: notes, and what arrived.
    pub fn receive(&mut self, running: &mut Running) -> (Vec<Note>, Vec<Arrival>) {
        self.threads.retain(|thread| !thread.is_finished());
        let (mut notes, mut arrivals) = (Vec::new(), Vec::new());
        while let Ok(message) = self.receive.try_recv() {
            match message {
                Message::Told(id, event) => notes.extend(told(running, id, event)),
                Message::Ended(id, ended) => {
                    self.stops.remove(&id);
                    let Some(job) = running.ended(id) else { continue };
                    match ended {
                        Ok(arrival) => arrivals.push(arrival),
                        Err(Error::Cancelled) if job.kind.is_quiet() => (),
                        Err(Error::Cancelled) => {
                            notes.push(Note::new(Weight::Info, format!("{}: stopped", job.name)));
                        }
                        Err(error) => notes.extend(Note::of_error(&job.name, &error)),
                    }
                }
            }
        }
        (notes, arrivals)
    }
}

/// A job has said something: how far it is, or a note.
fn told(running: &mut Running, id: JobId, event: Event) -> Option<Note> {
    match event {
        Event::Step { stage, subject, done, total } => {
            running.get_mut(id)?.step(stage, subject, done, total);
            None
        }
        Event::Note { subject, text } => Some(Note::about(Weight::Warning, subject, text)),
        Event::Timing { .. } => None,
    }
}

impl Drop for Jobs {
    /// The program ends when all have ended: what they write is whole, and no driver is asked for anything while it
    /// is taken down.
    fn drop(&mut self) {
        self.stops.values().for_each(|stop| stop.store(true, Ordering::Relaxed));
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

/// What a panic said, as an error that names it as ours.
fn fault(panic: &(dyn std::any::Any + Send)) -> Error {
    let said = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let said = said.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
    let report = crate::app::crash::last().report;
    let report = report.map_or(String::new(), |path| format!("; a report is in {}", path.display()));
    Error::Request(format!(
        "this is a fault of the program, not yours: {said}; your work is as it was{report}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ended(jobs: &mut Jobs, running: &mut Running) -> (Vec<Note>, Vec<Arrival>) {
        let (mut notes, mut arrivals) = (Vec::new(), Vec::new());
        while !running.is_idle() {
            let (more_notes, more_arrivals) = jobs.receive(running);
            notes.extend(more_notes);
            arrivals.extend(more_arrivals);
            std::thread::yield_now();
        }
        (notes, arrivals)
    }

    #[test]
    fn a_job_that_panics_is_a_note_and_no_crash() {
        let (mut jobs, mut running) = (Jobs::new(Waker::default()), Running::default());
        jobs.start(&mut running, Kind::Check, "Checking", |_| panic!("the wall fell"));
        let (notes, arrivals) = ended(&mut jobs, &mut running);
        assert!(arrivals.is_empty());
        assert!(notes[0].text.contains("the wall fell"), "{notes:?}");
    }

    #[test]
    fn a_job_that_is_stopped_says_so_and_brings_nothing() {
        let (mut jobs, mut running) = (Jobs::new(Waker::default()), Running::default());
        let id = jobs.start(&mut running, Kind::Build, "Building", |task| {
            loop {
                task.step("photos", 1, 2)?;
            }
        });
        jobs.stop(&mut running, id);
        let (notes, arrivals) = ended(&mut jobs, &mut running);
        assert!(arrivals.is_empty());
        assert_eq!(notes.last().map(|note| note.text.as_str()), Some("Building: stopped"));
    }
}
