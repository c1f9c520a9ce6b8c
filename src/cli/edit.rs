//! The command `edit`, which opens the window.

#[cfg(feature = "gui")]
pub use self::window::run;
use rayon::ThreadPoolBuilder;

/// Makes the threads that jobs share give way to the window.
pub fn below_window(pool: ThreadPoolBuilder) -> ThreadPoolBuilder {
    #[cfg(feature = "gui")]
    let pool = pool.start_handler(|_| quadratura_app::lower_own_priority());
    pool
}

/// Refuses to open a window: this program was compiled without one.
#[cfg(not(feature = "gui"))]
pub fn run(_: &super::args::EditArgs) -> quadratura_base::error::Result<super::Outcome> {
    let found = "this program was compiled without its window (the feature `gui` is off)";
    let remedy =
        "compile it with default features to edit; `quadratura --help` lists the commands that work without";
    Err(quadratura_base::error::Error::Request(format!("{found}; {remedy}")))
}

#[cfg(feature = "gui")]
mod window {
    use std::process::exit;
    use std::time::Duration;

    use serde_json::json;

    use crate::args::EditArgs;
    use crate::{Outcome, STOPPED};
    use quadratura_app::{self as app, Ending};
    use quadratura_base::error::{Error, Result};
    use quadratura_io::project::read_project;

    /// Time that a window gets to close after a signal: longer than it waits, twice, for files that it is
    /// writing.
    const CLOSING_TIME: Duration = Duration::from_secs(20);

    pub fn run(args: &EditArgs) -> Result<Outcome> {
        // Without a display, an error about it would hide that there is no such project.
        if let Some(folder) = args.project.as_deref().filter(|folder| !folder.exists()) {
            read_project(folder)?;
        }
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
            ending.request();
            std::thread::spawn(|| {
                std::thread::sleep(CLOSING_TIME);
                exit(STOPPED.into());
            });
        };
        ctrlc::set_handler(handler)
            .map_err(|error| Error::Request(format!("could not listen for signals: {error}")))
    }
}
