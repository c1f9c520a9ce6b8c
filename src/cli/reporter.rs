//! Prints progress, notes and timings of a running command to standard error.

use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::sync::{Arc, Mutex, MutexGuard, Weak};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use serde_json::{Value, json};

use super::args::Global;
use super::paint::{NOTE, paint};
use super::timings::Timings;
use super::words::worded;
use quadratura_base::task::{Event, Task, has_parts, in_words};

/// Time between lines of progress where there is no terminal; also the time before the first one, so that
/// quick commands print none.
const BETWEEN_LINES: Duration = Duration::from_secs(5);
/// Time between looks whether a line is due.
const BETWEEN_LOOKS: Duration = Duration::from_millis(500);

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
    /// Progress of all photos together, by stage; several stages may run side by side, or be parts of others.
    stages: BTreeMap<&'static str, StageProgress>,
    /// The stage that is shown.
    shown: Option<&'static str>,
    /// The last line of progress, and when it was printed.
    line: Option<(String, Instant)>,
}

/// How far a stage is.
#[derive(Debug, Clone, Copy)]
struct StageProgress {
    started: Instant,
    done: u64,
    total: u64,
}

impl Reporter {
    /// Creates a reporter with the verbosity of the options.
    pub fn new(global: &Global) -> Arc<Self> {
        let bar = (!global.quiet && std::io::stderr().is_terminal()).then(new_bar);
        let prints_lines = !global.quiet && bar.is_none();
        let reporter = Arc::new(Self {
            quiet: global.quiet,
            verbose: global.verbose,
            timings_wanted: global.timings,
            started: Instant::now(),
            bar,
            state: Mutex::default(),
        });
        if prints_lines {
            let weak = Arc::downgrade(&reporter);
            // Without it only the progress is missing.
            drop(std::thread::Builder::new().name("progress".into()).spawn(move || print_lines(&weak)));
        }
        reporter
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
        let before = state.shown;
        state.step(name, done, total, Instant::now());
        if let (Some(bar), Some((name, stage))) = (&self.bar, state.shown()) {
            show(bar, before != Some(name), name, stage);
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

/// Prints lines of progress as long as there is a reporter: also before the first picture is done, which may take minutes.
fn print_lines(reporter: &Weak<Reporter>) {
    while let Some(reporter) = reporter.upgrade() {
        if let Some(line) = reporter.state().due_line(Instant::now()) {
            print_line(&line);
        }
        drop(reporter);
        std::thread::sleep(BETWEEN_LOOKS);
    }
}

impl ReporterState {
    fn step(&mut self, name: &'static str, done: u64, total: u64, now: Instant) {
        let stage = self.stages.entry(name).or_insert(StageProgress { started: now, done, total });
        if done == 0 || done < stage.done {
            // A stage may start again, for example when a folder is watched.
            stage.started = now;
        }
        (stage.done, stage.total) = (done, total);
        // A stage that has this one as a part stays on the bar until it is done.
        let is_open = |(name, stage): &(&&str, &StageProgress)| has_parts(name) && stage.done < stage.total;
        let open = self.stages.iter().filter(is_open);
        let first = open.min_by_key(|(_, stage)| stage.started).map(|(name, _)| *name);
        self.shown = first.or(Some(name));
    }

    fn shown(&self) -> Option<(&'static str, StageProgress)> {
        let name = self.shown?;
        Some((name, self.stages[name]))
    }

    /// Returns the next line, once there is something new to say and the last line is some time ago.
    fn due_line(&mut self, now: Instant) -> Option<String> {
        let (name, stage) = self.shown()?;
        let spent = now.saturating_duration_since(stage.started);
        let since = self.line.as_ref().map_or(spent, |(_, at)| now.saturating_duration_since(*at).min(spent));
        let head = format!("{name}: {}", in_words(name, stage.done, stage.total));
        let is_new = self.line.as_ref().is_none_or(|(last, _)| *last != head);
        if !is_new || since < BETWEEN_LINES || stage.done >= stage.total {
            return None;
        }
        let left = time_left(spent, stage.done, stage.total);
        let left = left.map_or(String::new(), |left| format!(", about {} s left", left.as_secs().max(1)));
        let line = format!("{head}{left}");
        self.line = Some((head, now));
        Some(line)
    }
}

/// Prints a line to standard error; failing to do so is not an error.
fn print_line(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

fn new_bar() -> ProgressBar {
    let template = "[{bar:30}] {prefix}  {wide_msg}";
    let style = ProgressStyle::with_template(template).expect("the template is well formed");
    ProgressBar::new(0).with_style(style.progress_chars("=> "))
}

fn show(bar: &ProgressBar, is_new: bool, name: &'static str, stage: StageProgress) {
    if is_new {
        bar.reset();
        bar.enable_steady_tick(Duration::from_millis(500));
    }
    let left = time_left(stage.started.elapsed(), stage.done, stage.total);
    let left = left.map_or(String::new(), |left| format!(", {:#} left", HumanDuration(left)));
    bar.set_prefix(format!("{name}: {}{left}", in_words(name, stage.done, stage.total)));
    bar.set_length(stage.total);
    bar.set_position(stage.done);
}

/// Estimates the remaining time; `None` before a tenth is done, and at the end.
fn time_left(spent: Duration, done: u64, total: u64) -> Option<Duration> {
    let is_known = done > 0 && done < total && 10 * done >= total;
    is_known.then(|| spent.mul_f64((total - done) as f64 / done as f64))
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
        assert_eq!(time_left(ten, 1, 11), None, "less than a tenth is done");
    }

    #[test]
    fn a_line_is_printed_before_the_first_picture_and_its_parts_are_not_shown() {
        let mut state = ReporterState::default();
        let start = Instant::now();
        state.step("render", 0, 3, start);
        state.step("load layers", 47_217, 749_070, start + Duration::from_millis(9));
        assert_eq!(state.due_line(start + Duration::from_secs(4)), None, "a quick command prints none");
        let after = |seconds| start + Duration::from_secs(seconds);
        assert_eq!(state.due_line(after(6)).as_deref(), Some("render: 0 of 3 pictures"));
        assert_eq!(state.due_line(after(12)), None, "nothing has changed");
        state.step("render", 1, 3, after(20));
        assert_eq!(state.due_line(after(20)).as_deref(), Some("render: 1 of 3 pictures, about 40 s left"));
        state.step("render", 3, 3, after(30));
        state.step("page", 1, 2, after(31));
        assert_eq!(state.shown().map(|(name, _)| name), Some("page"), "the next one");
    }
}
