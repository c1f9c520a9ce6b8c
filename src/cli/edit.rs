//! The command `edit`, which opens the window.

use std::process::exit;
use std::time::Duration;

use serde_json::json;

use super::args::EditArgs;
use super::{Outcome, STOPPED};
use crate::app::{self, Ending};
use crate::error::{Error, Result};

/// Time that a window gets to close after a signal: longer than it waits, twice, for files that it is
/// writing.
const CLOSING_TIME: Duration = Duration::from_secs(20);

pub fn run(args: &EditArgs) -> Result<Outcome> {
    let ending = Ending::default();
    end_on_signals(ending.clone())?;
    let frames = app::run(args.project.clone(), ending)?;
    Ok(Outcome { text: String::new(), json: json!({ "frames": frames }), problems: Vec::new() })
}

/// Ends the window on Ctrl-C, when its terminal is closed, or when the system shuts down: without a question,
/// and without losing a decision. A second signal ends the program at once.
fn end_on_signals(ending: Ending) -> Result<()> {
    let handler = move || {
        if ending.is_asked() {
            exit(STOPPED.into());
        }
        ending.ask();
        std::thread::spawn(|| {
            std::thread::sleep(CLOSING_TIME);
            exit(STOPPED.into());
        });
    };
    ctrlc::set_handler(handler)
        .map_err(|error| Error::Request(format!("could not listen for signals: {error}")))
}
