//! Long work beside the window: each job a thread, told of by events, stopped by a flag.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use eframe::egui::Context;

use super::editor::Editor;
use super::notes::{Note, Weight};
use crate::error::{Error, Result};
use crate::task::{Event, Task};

/// What a job brings back: run by the window's thread, with the editor at hand.
pub type Arrival = Box<dyn FnOnce(&mut Editor) + Send>;

/// Tells a job from all others of this run of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JobId(u64);

/// What a job is about: at most one of a kind runs at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Reads or makes a project.
    Open,
    /// Makes the renderer of the 3D view.
    Preview,
    /// Builds stacks.
    Build,
    /// Fills hidden parts.
    Fill,
    /// Compares cameras, photos and model.
    Check,
    /// Writes layered files.
    Export,
    /// Reads layered files.
    Import,
    /// Makes small pictures of the photos.
    Thumbnails,
    /// Pictures and films of views.
    Render,
    /// Reads a photo to be laid over the 3D view.
    PhotoView,
    /// Looks which stacks are up to date.
    Survey,
    /// Keeps what is not saved.
    Keep,
    /// Compares the photos' exposures.
    Colour,
    /// Looks something up that a panel shows.
    Look,
    /// Makes what the flat views show.
    FlatView,
    /// Writes masks.
    Mask,
    /// Looks for what stands in one photo alone.
    Suggest,
    /// Looks through a folder for photos, cameras and a model.
    Search,
    /// Looks at the paths of a dialog.
    Paths,
    /// Asks whether a project is free.
    Lock,
}

impl Kind {
    /// Work that nobody asked for by name is not listed when it is done.
    fn is_quiet(self) -> bool {
        matches!(
            self,
            Self::Thumbnails
                | Self::PhotoView
                | Self::FlatView
                | Self::Survey
                | Self::Keep
                | Self::Preview
                | Self::Look
                | Self::Mask
                | Self::Search
                | Self::Paths
                | Self::Lock
        )
    }

    /// It writes files that somebody waits for.
    fn writes(self) -> bool {
        matches!(self, Self::Build | Self::Fill | Self::Export | Self::Import | Self::Render)
    }
}

/// A job that runs.
#[derive(Debug)]
pub struct Job {
    /// What it is about.
    pub kind: Kind,
    /// For people: `Building layers`.
    pub name: String,
    /// What is being done right now: stage and subject, empty before the first step.
    pub stage: String,
    /// Units done and units in all of the stage that counts; none before it is known.
    pub progress: Option<(u64, u64)>,
    /// When it began.
    pub since: Instant,
    stop: Arc<AtomicBool>,
    counted: BTreeMap<&'static str, (u64, u64)>,
}

impl Job {
    /// Between 0 and 1; none before it is known.
    pub fn share(&self) -> Option<f32> {
        self.progress.map(|(done, total)| done as f32 / total.max(1) as f32)
    }

    /// Time left if it goes on as it did; none before anything is done.
    pub fn left(&self) -> Option<Duration> {
        let (done, total) = self.progress.filter(|(done, total)| *done > 0 && done < total)?;
        // A guess after a moment would only flicker.
        let spent = self.since.elapsed();
        (spent > Duration::from_secs(1)).then(|| spent.mul_f64((total - done) as f64 / done as f64))
    }

    /// Somebody asked it to stop.
    pub fn is_stopping(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

enum Message {
    Told(JobId, Event),
    Ended(JobId, Result<Arrival>),
}

/// The jobs of the editor.
pub struct Jobs {
    running: BTreeMap<JobId, Job>,
    next: u64,
    send: Sender<Message>,
    receive: Receiver<Message>,
    context: Context,
    threads: Vec<JoinHandle<()>>,
}

impl Jobs {
    /// None yet; `context` is woken whenever a job has something to say.
    pub fn new(context: Context) -> Self {
        let (send, receive) = channel();
        Self { running: BTreeMap::new(), next: 0, send, receive, context, threads: Vec::new() }
    }

    /// Those that run, the oldest first.
    pub fn running(&self) -> impl Iterator<Item = (JobId, &Job)> {
        self.running.iter().map(|(id, job)| (*id, job))
    }

    /// Whether a job of this kind runs.
    pub fn runs(&self, kind: Kind) -> bool {
        self.running.values().any(|job| job.kind == kind)
    }

    /// Whether this one still runs.
    pub fn is_running(&self, id: JobId) -> bool {
        self.running.contains_key(&id)
    }

    /// Those that write files that somebody waits for.
    pub fn writing(&self) -> impl Iterator<Item = (JobId, &Job)> {
        self.running().filter(|(_, job)| job.kind.writes())
    }

    /// Asks all that write to stop.
    pub fn stop_writing(&self) {
        self.writing().for_each(|(_, job)| job.stop.store(true, Ordering::Relaxed));
    }

    /// Nothing runs.
    pub fn is_idle(&self) -> bool {
        self.running.is_empty()
    }

    /// Asks one to stop.
    pub fn stop(&self, id: JobId) {
        if let Some(job) = self.running.get(&id) {
            job.stop.store(true, Ordering::Relaxed);
        }
    }

    /// Asks all of a kind to stop.
    pub fn stop_kind(&self, kind: Kind) {
        let of_kind = self.running.values().filter(|job| job.kind == kind);
        of_kind.for_each(|job| job.stop.store(true, Ordering::Relaxed));
    }

    /// Asks all to stop that are not of this kind.
    pub fn stop_all_but(&self, kind: Kind) {
        let others = self.running.values().filter(|job| job.kind != kind);
        others.for_each(|job| job.stop.store(true, Ordering::Relaxed));
    }

    /// Asks all to stop.
    pub fn stop_all(&self) {
        self.running.values().for_each(|job| job.stop.store(true, Ordering::Relaxed));
    }

    /// Starts one. What it returns is run on the window's thread; what goes wrong, a panic too, becomes a note.
    pub fn start(
        &mut self,
        kind: Kind,
        name: impl Into<String>,
        work: impl FnOnce(&Task) -> Result<Arrival> + Send + 'static,
    ) -> JobId {
        let id = JobId(self.next);
        self.next += 1;
        let (send, context) = (self.send.clone(), self.context.clone());
        let tell = move |message: Message| {
            // The window is being closed: nobody is left to be told.
            let _ = send.send(message);
            context.request_repaint();
        };
        let told = tell.clone();
        let task = Task::new(move |event| told(Message::Told(id, event)));
        let job = Job {
            kind,
            name: name.into(),
            stage: String::new(),
            progress: None,
            since: Instant::now(),
            stop: task.stop_flag(),
            counted: BTreeMap::new(),
        };
        let thread_name = job.name.clone();
        self.running.insert(id, job);
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
    pub fn receive(&mut self) -> (Vec<Note>, Vec<Arrival>) {
        self.threads.retain(|thread| !thread.is_finished());
        let (mut notes, mut arrivals) = (Vec::new(), Vec::new());
        while let Ok(message) = self.receive.try_recv() {
            match message {
                Message::Told(id, event) => notes.extend(self.told(id, event)),
                Message::Ended(id, ended) => {
                    let Some(job) = self.running.remove(&id) else { continue };
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

    fn told(&mut self, id: JobId, event: Event) -> Option<Note> {
        match event {
            Event::Step { stage, subject, done, total } => {
                self.running.get_mut(&id)?.step(stage, subject, done, total);
                None
            }
            Event::Note { subject, text } => Some(Note::about(Weight::Warning, subject, text)),
            Event::Timing { .. } => None,
        }
    }
}

impl Drop for Jobs {
    /// The program ends when all have ended: what they write is whole, and no driver is asked for anything while it
    /// is taken down.
    fn drop(&mut self) {
        self.stop_all();
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

impl Job {
    /// Stages nest and run side by side: the one that counts is that of most units of work without a subject
    /// (all photos, not one photo's part), else the one told last.
    fn step(&mut self, stage: &'static str, subject: String, done: u64, total: u64) {
        self.stage = if subject.is_empty() { stage.into() } else { format!("{stage}: {subject}") };
        if subject.is_empty() {
            self.counted.insert(stage, (done, total));
            self.progress =
                self.counted.values().copied().filter(|(done, total)| done < total).max_by_key(|p| p.1);
            self.progress = self.progress.or(Some((done, total)));
        }
    }
}

/// What a panic said, as an error that names it as ours.
fn fault(panic: &(dyn std::any::Any + Send)) -> Error {
    let said = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let said = said.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
    let report = super::crash::last().report;
    let report = report.map_or(String::new(), |path| format!("; a report is in {}", path.display()));
    Error::Request(format!(
        "this is a fault of the program, not yours: {said}; your work is as it was{report}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ended(jobs: &mut Jobs) -> (Vec<Note>, Vec<Arrival>) {
        let (mut notes, mut arrivals) = (Vec::new(), Vec::new());
        while !jobs.is_idle() {
            let (more_notes, more_arrivals) = jobs.receive();
            notes.extend(more_notes);
            arrivals.extend(more_arrivals);
            std::thread::yield_now();
        }
        (notes, arrivals)
    }

    #[test]
    fn a_job_that_panics_is_a_note_and_no_crash() {
        let mut jobs = Jobs::new(Context::default());
        jobs.start(Kind::Check, "Checking", |_| panic!("the wall fell"));
        let (notes, arrivals) = ended(&mut jobs);
        assert!(arrivals.is_empty());
        assert!(notes[0].text.contains("the wall fell"), "{notes:?}");
    }

    #[test]
    fn a_job_that_is_stopped_says_so_and_brings_nothing() {
        let mut jobs = Jobs::new(Context::default());
        let id = jobs.start(Kind::Build, "Building", |task| {
            loop {
                task.step("photos", 1, 2)?;
            }
        });
        jobs.stop(id);
        let (notes, arrivals) = ended(&mut jobs);
        assert!(arrivals.is_empty());
        assert_eq!(notes.last().map(|note| note.text.as_str()), Some("Building: stopped"));
    }

    #[test]
    fn the_stage_of_most_units_counts_until_it_is_done() {
        let mut job = Job {
            kind: Kind::Build,
            name: String::new(),
            stage: String::new(),
            progress: None,
            since: Instant::now(),
            stop: Arc::default(),
            counted: BTreeMap::new(),
        };
        job.step("photos", String::new(), 3, 19);
        job.step("sort", "a.jpg".into(), 1, 50);
        job.step("read", String::new(), 1, 2);
        assert_eq!(job.progress, Some((3, 19)));
        job.step("photos", String::new(), 19, 19);
        assert_eq!(job.progress, Some((1, 2)));
    }
}
