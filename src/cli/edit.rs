//! `quadratura edit`: the window.

use std::process::exit;
use std::time::Duration;

use serde_json::json;

use super::args::EditArgs;
use super::{Outcome, STOPPED};
use crate::app::{self, Ending};
use crate::error::{Error, Result};

/// A window that was asked to end by a signal has so long to close by itself: longer than it waits, twice, for what it
/// writes.
const PATIENCE: Duration = Duration::from_secs(20);

pub fn run(args: &EditArgs) -> Result<Outcome> {
    let ending = Ending::default();
    end_on_signals(ending.clone())?;
    let frames = app::run(args.project.clone(), ending)?;
    Ok(Outcome { text: String::new(), json: json!({ "frames": frames }), problems: Vec::new() })
}

/// Ctrl-C, a terminal that is closed and a system that shuts down end the window without a question, and lose nothing
/// that was decided. A second signal ends the program where it stands.
fn end_on_signals(ending: Ending) -> Result<()> {
    let handler = move || {
        if ending.is_asked() {
            exit(STOPPED.into());
        }
        ending.ask();
        std::thread::spawn(|| {
            std::thread::sleep(PATIENCE);
            exit(STOPPED.into());
        });
    };
    ctrlc::set_handler(handler)
        .map_err(|error| Error::Request(format!("could not listen for signals: {error}")))
}
