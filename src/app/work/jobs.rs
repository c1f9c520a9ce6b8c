//! Jobs: long work beside the window, each on a thread, reported by events and stopped by a flag.

use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use super::priority::lower_own_priority;
use super::waker::Waker;
use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::request::Request;
use crate::state::running::{Job, JobId, JobKind, Running};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::{Event, Task};

/// The result of a job: the window's thread runs it on the state; returns the requests to apply next.
pub type Arrival = Box<dyn FnOnce(&mut State) -> Vec<Request> + Send>;

/// Makes a result that changes the state and returns no requests.
pub fn arrival(change: impl FnOnce(&mut State) + Send + 'static) -> Arrival {
    Box::new(|state| {
        change(state);
        Vec::new()
    })
}

/// What the thread of a job sends to the window.
enum JobMessage {
    Reported(JobId, Event),
    Ended(JobId, Result<Arrival>),
}

/// The threads of the jobs. Their progress is in [`Running`].
pub struct Jobs {
    next: u64,
    stops: BTreeMap<JobId, Arc<AtomicBool>>,
    send: Sender<JobMessage>,
    receive: Receiver<JobMessage>,
    waker: Waker,
    threads: Vec<JoinHandle<()>>,
    /// The jobs whose project was left.
    left: BTreeSet<JobId>,
}

impl Jobs {
    /// Makes an empty list; `waker` wakes the window whenever a job sends an event.
    pub fn new(waker: Waker) -> Self {
        let (send, receive) = channel();
        let (stops, threads, left) = Default::default();
        Self { next: 0, stops, send, receive, waker, threads, left }
    }

    /// Stops all jobs that write.
    pub fn stop_writing(&self, running: &mut Running) {
        self.stop_those(running, |_, job| job.kind.writes());
    }

    /// Stops a job.
    pub fn stop(&self, running: &mut Running, id: JobId) {
        self.stop_those(running, |other, _| other == id);
    }

    /// Stops all jobs of a kind.
    pub fn stop_kind(&self, running: &mut Running, kind: JobKind) {
        self.stop_those(running, |_, job| job.kind == kind);
    }

    /// Stops all jobs but those of the kinds to be kept.
    pub fn stop_all_but(&self, running: &mut Running, is_kept: impl Fn(JobKind) -> bool) {
        self.stop_those(running, |_, job| !is_kept(job.kind));
    }

    /// Stops all jobs, because their project is left: they tell nothing any more, but faults.
    pub fn leave_all(&mut self, running: &mut Running) {
        self.left.extend(running.all().map(|(id, _)| id));
        self.stop_all(running);
    }

    /// Stops all jobs.
    pub fn stop_all(&self, running: &mut Running) {
        self.stop_those(running, |_, _| true);
    }

    fn stop_those(&self, running: &mut Running, are: impl Fn(JobId, &Job) -> bool) {
        for id in running.stopping(are) {
            self.stops.get(&id).into_iter().for_each(|stop| stop.store(true, Ordering::Relaxed));
        }
    }

    /// Starts a job. Its result runs on the window's thread; an error or panic becomes a note.
    pub fn start(
        &mut self,
        running: &mut Running,
        kind: JobKind,
        name: impl Into<String>,
        work: impl FnOnce(&Task) -> Result<Arrival> + Send + 'static,
    ) -> JobId {
        let id = JobId(self.next);
        self.next += 1;
        let (send, waker) = (self.send.clone(), self.waker.clone());
        let notify = move |message: JobMessage| {
            // The receiver is gone while the window closes.
            let _ = send.send(message);
            waker.wake();
        };
        let message = notify.clone();
        let task = Task::new(move |event| message(JobMessage::Reported(id, event)));
        let job = Job::new(kind, name.into());
        let thread_name = job.name.clone();
        running.begun(id, job);
        self.stops.insert(id, task.stop_flag());
        let run = move || {
            // The threads that it starts have its priority, too: those of the 3D view are not to have a low one.
            if kind != JobKind::Preview {
                lower_own_priority();
            }
            let ended =
                catch_unwind(AssertUnwindSafe(|| work(&task))).unwrap_or_else(|panic| Err(fault(&*panic)));
            notify(JobMessage::Ended(id, ended));
        };
        match std::thread::Builder::new().name(thread_name).spawn(run) {
            Ok(thread) => self.threads.push(thread),
            Err(error) => {
                let refused = Error::Request(format!("the system cannot start a thread for it: {error}"));
                let _ = self.send.send(JobMessage::Ended(id, Err(refused)));
            }
        }
        id
    }

    /// Receives the events since the last call: notes, and results.
    pub fn receive(&mut self, running: &mut Running) -> (Vec<Note>, Vec<Arrival>) {
        self.threads.retain(|thread| !thread.is_finished());
        let (mut notes, mut arrivals) = (Vec::new(), Vec::new());
        while let Ok(message) = self.receive.try_recv() {
            match message {
                JobMessage::Reported(id, event) => {
                    let note = note_of_event(running, id, event);
                    notes.extend(note.filter(|_| !self.left.contains(&id)));
                }
                JobMessage::Ended(id, ended) => {
                    self.stops.remove(&id);
                    let was_left = self.left.remove(&id);
                    let Some(job) = running.ended(id) else { continue };
                    match ended {
                        Ok(arrival) => arrivals.push(arrival),
                        Err(Error::Cancelled) if job.kind.is_quiet() || was_left => (),
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

/// Applies an event of a job: its progress, or a note.
fn note_of_event(running: &mut Running, id: JobId, event: Event) -> Option<Note> {
    match event {
        Event::Step { stage, subject, done, total } => {
            running.get_mut(id)?.step(stage, subject, done, total);
            None
        }
        Event::Note { subject, text } => Some(Note::about(Weight::Warning, subject, text)),
        Event::Detail { .. } | Event::Timing { .. } => None,
    }
}

impl Drop for Jobs {
    /// Waits for all jobs: their files are completed, and no driver is in use while it is unloaded.
    fn drop(&mut self) {
        self.stops.values().for_each(|stop| stop.store(true, Ordering::Relaxed));
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

/// Makes the error of a panic, which is reported as a fault of this program.
fn fault(panic: &(dyn std::any::Any + Send)) -> Error {
    let said = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let said = said.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
    let report = super::crash::last().report;
    let report = report.map_or(String::new(), |path| format!("; a report is in {}", path.display()));
    Error::Request(format!(
        "this is an internal error of the program: {said}; your work has not changed{report}"
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
        jobs.start(&mut running, JobKind::Check, "Checking", |_| panic!("the wall fell"));
        let (notes, arrivals) = ended(&mut jobs, &mut running);
        assert!(arrivals.is_empty());
        assert!(notes[0].text.to_string().contains("the wall fell"), "{notes:?}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_job_and_the_threads_that_it_starts_give_way_to_the_window() {
        let nice = || rustix::process::nice(0).unwrap();
        let (mut jobs, mut running) = (Jobs::new(Waker::default()), Running::default());
        let (send, receive) = channel();
        jobs.start(&mut running, JobKind::Build, "Building", move |_| {
            let of_thread = std::thread::spawn(nice).join().unwrap();
            send.send([nice(), of_thread]).unwrap();
            Ok(arrival(|_| ()))
        });
        ended(&mut jobs, &mut running);
        let lower = receive.recv().unwrap();
        assert!(lower.iter().all(|lower| *lower > nice()), "{lower:?}");
    }

    #[test]
    fn a_job_that_is_stopped_says_so_and_brings_nothing() {
        let (mut jobs, mut running) = (Jobs::new(Waker::default()), Running::default());
        let id = jobs.start(&mut running, JobKind::Build, "Building", |task| {
            loop {
                task.step("photos", 1, 2)?;
            }
        });
        jobs.stop(&mut running, id);
        let (notes, arrivals) = ended(&mut jobs, &mut running);
        assert!(arrivals.is_empty());
        assert_eq!(notes.last().map(|note| note.text.to_string()).as_deref(), Some("Building: stopped"));
    }
}
