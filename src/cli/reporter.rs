//! What a running command says on standard error: progress, notes, timings.

use std::io::IsTerminal;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};

use super::args::Global;
use super::paint::{NOTE, paint};
use super::timings::Timings;
use crate::task::{Event, Task};

/// Without a terminal: no more than one line of progress in so long.
const BETWEEN_LINES: Duration = Duration::from_secs(5);

/// Takes the events of one command. Shared by its threads.
pub struct Reporter {
    quiet: bool,
    verbose: bool,
    timings_wanted: bool,
    started: Instant,
    /// `None` when quiet or not on a terminal.
    bar: Option<ProgressBar>,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    timings: Timings,
    notes: Vec<(String, String)>,
    /// The stage that the progress is of, and when its last line was written.
    stage: &'static str,
    stage_started: Option<Instant>,
    last_line: Option<Instant>,
}

impl Reporter {
    /// As loud as the user wants it.
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

    /// A task that reports here.
    pub fn task(self: &Arc<Self>) -> Task {
        let reporter = self.clone();
        Task::new(move |event| reporter.take(event))
    }

    /// Takes the progress off the screen and prints the timings if they are wanted.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        if self.timings_wanted {
            eprint!("\n{}", self.state().timings.render(self.started.elapsed()));
        }
    }

    /// Notes and, if they are wanted, timings: what `--json` adds to every result.
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
            Event::Note { subject, text } => self.note(subject, text),
            Event::Timing { stage, subject, spent } => self.timing(subject, stage, spent),
        }
    }

    fn progress(&self, stage: &'static str, done: u64, total: u64) {
        let mut state = self.state();
        let is_new = state.stage != stage;
        if is_new {
            state.stage = stage;
            state.stage_started = Some(Instant::now());
            state.last_line = None;
        }
        match &self.bar {
            Some(bar) => show(bar, stage, is_new, done, total),
            None if !self.quiet => plain_line(&mut state, done, total),
            None => (),
        }
    }

    /// A photo's own steps: shown beside the bar.
    fn step_of(&self, subject: &str, stage: &str) {
        if let Some(bar) = &self.bar {
            bar.set_message(format!("{subject}: {stage}"));
        }
    }

    fn note(&self, subject: String, text: String) {
        if !self.quiet {
            let about = if subject.is_empty() { String::new() } else { format!("{subject}: ") };
            self.line(&format!("{} {about}{text}", paint(NOTE, "note:")));
        }
        self.state().notes.push((subject, text));
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
            Some(bar) => bar.suspend(|| eprintln!("{text}")),
            None => eprintln!("{text}"),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // A thread that panicked while it held the lock leaves counts that are still worth showing.
        self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

fn new_bar() -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

fn show(bar: &ProgressBar, stage: &'static str, is_new: bool, done: u64, total: u64) {
    if is_new {
        let template = "{prefix} [{bar:30}] {pos}/{len}, {eta} left  {wide_msg}";
        let style = ProgressStyle::with_template(template).expect("the template is well formed");
        bar.set_style(style.progress_chars("=> "));
        bar.set_prefix(stage);
        bar.reset();
    }
    bar.set_length(total);
    bar.set_position(done);
}

fn plain_line(state: &mut State, done: u64, total: u64) {
    let now = Instant::now();
    let is_due = state.last_line.is_none_or(|last| now - last >= BETWEEN_LINES) || done == total;
    if !is_due || total == 0 {
        return;
    }
    state.last_line = Some(now);
    let left = state.stage_started.and_then(|start| time_left(now - start, done, total));
    let left = left.map_or(String::new(), |left| format!(", about {} s left", left.as_secs().max(1)));
    eprintln!("{}: {done} of {total}{left}", state.stage);
}

/// `None` at either end, where there is nothing to judge by and nothing left.
fn time_left(spent: Duration, done: u64, total: u64) -> Option<Duration> {
    (done > 0 && done < total).then(|| spent.mul_f64((total - done) as f64 / done as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quiet() -> Arc<Reporter> {
        Reporter::new(&Global { json: true, quiet: true, verbose: false, threads: None, timings: true })
    }

    #[test]
    fn notes_and_timings_of_all_threads_are_collected() {
        let reporter = quiet();
        let task = reporter.task();
        std::thread::scope(|scope| {
            for photo in ["a", "b"] {
                let task = task.of(photo);
                scope.spawn(move || {
                    task.step("sort", 0, 1).unwrap();
                    task.timed("sort", || task.note("something"));
                });
            }
        });
        let json = reporter.to_json();
        assert_eq!(json["notes"].as_array().unwrap().len(), 2);
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
