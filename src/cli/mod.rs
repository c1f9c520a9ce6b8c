//! The command line: parses arguments, runs a command and prints its result.
//!
//! [`run`] parses the arguments ([`args`]), sets up what all commands share ([`reporter`], threads, Ctrl-C)
//! and calls the file of the command, which calls a task and turns its result into an `Outcome`: text for
//! people, JSON for programs. Results go to standard output, everything else to standard error.

use std::ffi::OsString;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;

use clap::FromArgMatches;
use serde_json::{Value, json};

use self::words::{about_project, error_text, worded};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_files::atomic::{is_stream, write_atomically};
use quadratura_files::known_hashes;
use quadratura_files::lock::introduce;
use quadratura_files::writable::check_file;

pub mod args;
mod build;
mod bytes;
mod check;
mod coarse;
mod colour;
mod decide;
mod edit;
mod estimate;
mod export;
mod fault;
mod fill;
mod fill_table;
mod formats;
mod frame;
mod import;
mod info;
mod layer_table;
mod ldi;
mod live;
mod lock;
mod machine;
mod mask;
mod masked;
mod matte;
mod merge_table;
mod model;
mod new;
mod object;
mod ortho;
mod paint;
mod painted;
mod photo_state_table;
mod plan;
mod propagation_table;
mod render;
pub mod reporter;
mod score;
mod seen;
mod stacks;
mod status;
mod stroke;
mod surroundings;
mod table;
mod text;
mod timings;
mod transients;
mod tree;
mod unexplained;
mod unknown_mattes;
mod untextured;
mod update;
pub mod view_args;
mod words;

use args::{Cli, CommandArgs, Global};
use paint::{ERROR, paint};
use reporter::Reporter;

const FAILED: u8 = 1;
/// As of arguments that the parser refuses.
const MISUSED: u8 = 2;
const STOPPED: u8 = 130;

/// The result of a command.
struct Outcome {
    /// The result as text for people.
    text: String,
    /// The result as a JSON object for programs.
    json: Value,
    /// One message for each photo that failed while the others went on.
    problems: Vec<String>,
}

/// Parses the command line (with the program's name first), runs the command and returns the exit status.
pub fn run(typed: impl IntoIterator<Item = OsString>) -> ExitCode {
    fault::install_message();
    let matches = args::command().try_get_matches_from(typed);
    let cli = match matches.and_then(|matches| Ok((Cli::from_arg_matches(&matches)?, matches))) {
        Ok((cli, matches)) => {
            introduce(matches.subcommand_name().unwrap_or("edit"));
            let mut innermost = &matches;
            while let Some((_, of)) = innermost.subcommand() {
                innermost = of;
            }
            let project = innermost.try_get_one::<PathBuf>("project").ok().flatten();
            if let Some(project) = project {
                about_project(project);
                // The window looks at every file itself, and may run for days.
                if !matches!(cli.command, None | Some(CommandArgs::Edit(_))) {
                    known_hashes::begin(project);
                }
            }
            cli
        }
        Err(usage) => {
            // If even this cannot be printed, nothing can be done.
            let _ = usage.print();
            return ExitCode::from(usage.exit_code() as u8);
        }
    };
    let command = cli.command.unwrap_or_else(|| CommandArgs::Edit(args::EditArgs::default()));
    let reporter = Reporter::new(&cli.global);
    let task = reporter.task();
    let done = prepare(&cli.global, &command, &task).and_then(|()| dispatch(&command, &task));
    known_hashes::save();
    reporter.finish();
    print_result(&cli.global, &reporter, done)
}

fn dispatch(command: &CommandArgs, task: &Task) -> Result<Outcome> {
    match command {
        CommandArgs::Edit(args) => edit::run(args),
        CommandArgs::New(args) => new::run(args, task),
        CommandArgs::Info(args) => info::run(args, task),
        CommandArgs::Model(args) => model::run(args, task),
        CommandArgs::Sample(args) => new::run_sample(args, task),
        CommandArgs::Formats => Ok(formats::run()),
        CommandArgs::Check(args) => check::run(args, task),
        CommandArgs::Update(args) => update::run(args, task),
        CommandArgs::Build(args) => build::run(args, task),
        CommandArgs::Fill(args) => fill::run(args, task),
        CommandArgs::Estimate(args) => estimate::run(args, task),
        CommandArgs::Status(args) => status::run(args, task),
        CommandArgs::Plan(args) => plan::run(args, task),
        CommandArgs::Export(args) => export::run(args, task),
        CommandArgs::Colour(args) => colour::run(args, task),
        CommandArgs::Surroundings(args) => surroundings::run(args, task),
        CommandArgs::Decide(args) => decide::run(args, task),
        CommandArgs::Mask(args) => mask::run(args, task),
        CommandArgs::Matte(args) => matte::run(args, task),
        CommandArgs::Object(args) => object::run(args, task),
        CommandArgs::Import(args) => import::run(args, task),
        CommandArgs::Watch(args) => import::run_watch(args, task),
        CommandArgs::Stroke(args) => stroke::run(args, task),
        CommandArgs::Paint(args) => seen::run(args, task),
        CommandArgs::Render(args) => render::run(args, task),
        CommandArgs::Frame(args) => frame::run(args, task),
        CommandArgs::Ortho(args) => ortho::run(args, task),
        CommandArgs::Text(args) => text::run(args, task),
        CommandArgs::Score(args) => score::run(args, task),
        CommandArgs::Ldi(args) => ldi::run(args, task),
        CommandArgs::Tree(args) => tree::run(args, task),
        CommandArgs::Completions { shell } => Ok(completions(*shell)),
        CommandArgs::Man => Ok(manual()),
    }
}

fn prepare(global: &Global, command: &CommandArgs, task: &Task) -> Result<()> {
    global.json_file.as_deref().filter(|file| !is_stream(file)).map(check_file).transpose()?;
    let is_window = matches!(command, CommandArgs::Edit(_));
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = global.threads {
        pool = pool.num_threads(threads);
    }
    if is_window {
        pool = edit::below_window(pool);
    }
    if is_window || global.threads.is_some() {
        pool.build_global()
            .map_err(|error| Error::Request(format!("could not start the threads: {error}")))?;
    }
    // In the window jobs are stopped one by one, and a signal ends it.
    if is_window { Ok(()) } else { stop_on_ctrl_c(task) }
}

/// Installs the Ctrl-C handler: the first Ctrl-C requests a stop, the second one ends the program at once.
/// Files on disk are complete at every moment.
fn stop_on_ctrl_c(task: &Task) -> Result<()> {
    let stop = task.stop_flag();
    let handler = move || {
        if stop.swap(true, Ordering::Relaxed) {
            std::process::exit(STOPPED.into());
        }
        eprintln!("stopping; press Ctrl-C again to quit at once");
    };
    ctrlc::set_handler(handler)
        .map_err(|error| Error::Request(format!("could not listen for Ctrl-C: {error}")))
}

/// Prints the result or the error and returns the exit status.
fn print_result(global: &Global, reporter: &Reporter, done: Result<Outcome>) -> ExitCode {
    let status = match &done {
        Ok(outcome) if !outcome.problems.is_empty() => FAILED,
        Ok(_) => 0,
        Err(Error::Cancelled) => STOPPED,
        Err(Error::Usage(_)) => MISUSED,
        Err(_) => FAILED,
    };
    let (json, text) = match done {
        Ok(outcome) => {
            outcome.problems.iter().for_each(|problem| print_error(problem));
            (outcome.json, outcome.text)
        }
        Err(error) => {
            match &error {
                Error::Several(errors) => {
                    let messages = Error::gathered(&errors.iter().collect::<Vec<_>>());
                    messages.iter().for_each(|message| print_error(&worded(message)));
                }
                error => print_error(&error_text(error)),
            }
            (json!({"error": error_text(&error)}), String::new())
        }
    };
    let json = as_json(json, reporter);
    // A file that cannot be written may be the very error that was printed.
    let is_possible = |file: &&Path| status == 0 || is_stream(file) || check_file(file).is_ok();
    let json_file = global.json_file.as_deref().filter(is_possible);
    let text = if global.json { &json } else { &text };
    let status = match std::io::stdout().lock().write_all(text.as_bytes()) {
        // The reader of the output may have closed it on purpose, as `head` does.
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            print_error(&format!("could not write the result: {error}"));
            FAILED
        }
        _ => status,
    };
    // After the text, which may go to the same place.
    match json_file.map(|file| write_json(file, &json)) {
        Some(Err(error)) => {
            print_error(&error_text(&error));
            ExitCode::from(FAILED)
        }
        _ => ExitCode::from(status),
    }
}

/// Writes the result to a file, or at the end of what takes a stream.
fn write_json(file: &Path, json: &str) -> Result<()> {
    if !is_stream(file) {
        return write_atomically(file, json.as_bytes());
    }
    let written = OpenOptions::new().append(true).open(file).and_then(|mut to| to.write_all(json.as_bytes()));
    written.map_err(Error::io(file, "write it"))
}

/// Prints an error to standard error.
fn print_error(text: &str) {
    // If standard error is closed, the message is lost.
    let _ = writeln!(std::io::stderr(), "{} {text}", paint(ERROR, "error:"));
}

fn as_json(mut result: Value, reporter: &Reporter) -> String {
    if let (Some(result), Value::Object(more)) = (result.as_object_mut(), reporter.to_json()) {
        result.extend(more);
    }
    format!("{result:#}\n")
}

fn completions(shell: clap_complete::Shell) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut args::command(), "quadratura", &mut script);
    printed(&script)
}

/// Returns the manual pages of the program and of its commands.
fn manual() -> Outcome {
    let mut command = args::command();
    command.build();
    let visible = command.get_subcommands().filter(|sub| !sub.is_hide_set() && sub.get_name() != "help");
    let pages: Vec<_> = std::iter::once(command.clone()).chain(visible.cloned()).collect();
    let mut text = Vec::new();
    for page in pages {
        clap_mangen::Man::new(page).render(&mut text).expect("a vector takes every byte");
    }
    printed(&text)
}

fn printed(bytes: &[u8]) -> Outcome {
    let text = String::from_utf8_lossy(bytes).into_owned();
    Outcome { json: json!({ "text": text }), text, problems: Vec::new() }
}
