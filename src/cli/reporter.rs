//! Prints progress, notes and timings of a running command to standard error.

use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use serde_json::{Value, json};

use super::args::Global;
use super::paint::{NOTE, paint};
use super::timings::Timings;
use super::words::worded;
use crate::recipe::render;
use crate::task::{Event, Task};

/// Time between lines of progress where there is no terminal; also the time before the first one, so that
/// quick commands print none.
const BETWEEN_LINES: Duration = Duration::from_secs(5);

/// The receiver of a command's events, shared by its threads.
pub struct Reporter {
    quiet: bool,
    verbose: bool,
    timings_wanted: bool,
    started: Instant,
    /// The progress bar; `None` when quiet or not on a terminal.
    bar: Option<ProgressBar>,
    state: Mutex<ReporterState>,
}

#[derive(Default)]
struct ReporterState {
    timings: Timings,
    notes: Vec<(String, String)>,
    /// Progress of all photos together, by stage; several stages may run side by side.
    stages: BTreeMap<&'static str, Stage>,
    /// The stage on the bar, which is the one that reported last.
    shown: &'static str,
}

struct Stage {
    started: Instant,
    last_line: Instant,
}

impl Reporter {
    /// Creates a reporter with the verbosity of the options.
    pub fn new(global: &Global) -> Arc<Self> {
        let bar = (!global.quiet && std::io::stderr().is_terminal()).then(new_bar);
        Arc::new(Self {
            quiet: global.quiet,
            verbose: global.verbose,
            timings_wanted: global.timings,
            started: Instant::now(),
            bar,
            state: Mutex::default(),
        })
    }

    /// Returns a task that reports here.
    pub fn task(self: &Arc<Self>) -> Task {
        let reporter = self.clone();
        Task::new(move |event| reporter.take(event))
    }

    /// Clears the progress and prints the timings if requested.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        if self.timings_wanted {
            print_line(&format!("\n{}", self.state().timings.render(self.started.elapsed()).trim_end()));
        }
    }

    /// Returns notes and, if requested, timings as JSON, which `--json` adds to every result.
    pub fn to_json(&self) -> Value {
        let state = self.state();
        let notes: Vec<_> =
            state.notes.iter().map(|(subject, text)| json!({"subject": subject, "text": text})).collect();
        let mut value = json!({ "notes": notes });
        if self.timings_wanted {
            value["timings"] = state.timings.to_json(self.started.elapsed());
        }
        value
    }

    fn take(&self, event: Event) {
        match event {
            Event::Step { stage, subject, done, total } if subject.is_empty() => {
                self.progress(stage, done, total);
            }
            Event::Step { stage, subject, .. } => self.step_of(&subject, stage),
            Event::Note { subject, text } => self.note(subject, worded(&text)),
            Event::Detail { subject, text } => self.detail(&subject, &text),
            Event::Timing { stage, subject, spent } => self.timing(subject, stage, spent),
        }
    }

    fn progress(&self, name: &'static str, done: u64, total: u64) {
        let mut state = self.state();
        match &self.bar {
            Some(bar) => {
                let is_new = std::mem::replace(&mut state.shown, name) != name;
                show(bar, is_new.then_some(name), done, total);
            }
            None if !self.quiet => {
                let now = Instant::now();
                let stage = state.stages.entry(name).or_insert(Stage { started: now, last_line: now });
                stage.plain_line(name, done, total);
            }
            None => (),
        }
    }

    /// Shows a photo's own step beside the bar.
    fn step_of(&self, subject: &str, step: &str) {
        if let Some(bar) = &self.bar {
            bar.set_message(format!("{subject}: {step}"));
        }
    }

    /// Tells a note once: several steps of a command may find the same.
    fn note(&self, subject: String, text: String) {
        let note = (subject, text);
        {
            let notes = &mut self.state().notes;
            if notes.contains(&note) {
                return;
            }
            notes.push(note.clone());
        }
        let (subject, text) = note;
        if !self.quiet {
            let about = if subject.is_empty() { String::new() } else { format!("{subject}: ") };
            self.line(&format!("{} {about}{text}", paint(NOTE, "note:")));
        }
    }

    fn detail(&self, subject: &str, text: &str) {
        if self.verbose {
            let about = if subject.is_empty() { String::new() } else { format!("{subject}: ") };
            self.line(&format!("{about}{text}"));
        }
    }

    fn timing(&self, subject: String, stage: &'static str, spent: Duration) {
        if self.verbose {
            let about = if subject.is_empty() { "all photos" } else { &subject };
            self.line(&format!("{about}: {stage} {:.3} s", spent.as_secs_f64()));
        }
        self.state().timings.add(subject, stage, spent);
    }

    fn line(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| print_line(text)),
            None => print_line(text),
        }
    }

    fn state(&self) -> MutexGuard<'_, ReporterState> {
        // After a panic of another thread the counts are still worth showing.
        self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

impl Stage {
    fn plain_line(&mut self, name: &str, done: u64, total: u64) {
        let now = Instant::now();
        if done == 0 {
            // A stage may start again, for example when a folder is watched.
            (self.started, self.last_line) = (now, now);
            if name == render::STAGE {
                // What all pictures need is read or made for the first one, which may take minutes.
                print_line(&format!("{name}: {done} of {total}, and the first takes longest"));
            }
        }
        if now - self.last_line < BETWEEN_LINES {
            return;
        }
        self.last_line = now;
        let left = time_left(now - self.started, done, total);
        let left = left.map_or(String::new(), |left| format!(", about {} s left", left.as_secs().max(1)));
        print_line(&format!("{name}: {done} of {total}{left}"));
    }
}

/// Prints a line to standard error; failing to do so is not an error.
fn print_line(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

fn new_bar() -> ProgressBar {
    let template = "{prefix} [{bar:30}] {pos}/{len}{left}  {wide_msg}";
    let style = ProgressStyle::with_template(template).expect("the template is well formed");
    ProgressBar::new(0).with_style(style.progress_chars("=> ").with_key("left", write_left))
}

/// Writes the remaining time, but not before the first step, when it cannot be estimated.
fn write_left(state: &ProgressState, out: &mut dyn std::fmt::Write) {
    if state.pos() > 0 {
        // A bar that cannot be written to is no reason to fail.
        let _ = write!(out, ", {:#} left", HumanDuration(state.eta()));
    }
}

fn show(bar: &ProgressBar, new_stage: Option<&'static str>, done: u64, total: u64) {
    if let Some(stage) = new_stage {
        bar.set_prefix(stage);
        bar.set_length(total);
        bar.reset();
        // The remaining time decreases between steps, too.
        bar.enable_steady_tick(Duration::from_millis(500));
    }
    bar.set_length(total);
    bar.set_position(done);
}

/// Estimates the remaining time; `None` at the beginning and at the end.
fn time_left(spent: Duration, done: u64, total: u64) -> Option<Duration> {
    (done > 0 && done < total).then(|| spent.mul_f64((total - done) as f64 / done as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quiet() -> Arc<Reporter> {
        Reporter::new(&Global {
            json: true,
            json_file: None,
            quiet: true,
            verbose: false,
            threads: None,
            timings: true,
        })
    }

    #[test]
    fn notes_and_timings_of_all_threads_are_collected() {
        let reporter = quiet();
        let task = reporter.task();
        std::thread::scope(|scope| {
            for photo in ["a", "b"] {
                let task = task.with_subject(photo);
                scope.spawn(move || {
                    task.step("sort", 0, 1).unwrap();
                    task.timed("sort", || task.note("something"));
                });
            }
        });
        let json = reporter.to_json();
        assert_eq!(json["notes"].as_array().unwrap().len(), 2);
        task.with_subject("a").note("something");
        assert_eq!(reporter.to_json()["notes"], json["notes"], "the same is told once");
        assert_eq!(json["timings"]["seconds"].as_object().unwrap().len(), 2);
    }

    #[test]
    fn the_time_left_is_in_proportion() {
        let ten = Duration::from_secs(10);
        assert_eq!(time_left(ten, 2, 8), Some(3 * ten));
        assert_eq!(time_left(ten, 0, 8), None);
        assert_eq!(time_left(ten, 8, 8), None);
    }
}
