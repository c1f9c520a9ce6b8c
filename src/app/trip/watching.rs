//! A thread that imports whatever is saved in the project's folder of documents to paint on.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::Duration;

use super::Turn;
use super::importing::Way;
use crate::app::action::apply;
use crate::app::state::State;
use crate::app::state::notes::{Note, Weight};
use crate::app::state::session::Session;
use crate::app::work::Work;
use crate::app::work::waker::Waker;
use crate::error::{Error, Result};
use crate::recipe::editing;
use crate::recipe::import::Imported;
use crate::recipe::watch::{WatchOptions, watch};
use crate::task::{Event, Task};

/// What the thread has to say.
enum News {
    Imported(Imported, Duration),
    Said(Note),
}

/// The thread; it ends when this is dropped.
pub struct Watching {
    stop: Arc<AtomicBool>,
    receive: Receiver<News>,
}

impl Watching {
    /// Watches the folder of documents of a project that is open. What was saved there while nobody watched is
    /// imported at once; an import that was taken back stays so.
    fn start(session: &Session, turn: Turn, waker: Waker) -> Option<Self> {
        let (send, receive) = channel();
        let tell = move |news: News| {
            // Nobody listens any more: another project is open.
            let _ = send.send(news);
            waker.wake();
        };
        let said = tell.clone();
        let task = Task::new(move |event| {
            if let Event::Note { subject, text } = event {
                said(News::Said(Note::about(Weight::Warning, subject, text)));
            }
        });
        let stop = task.stop_flag();
        let (project, lock) = (session.folder.clone(), Arc::downgrade(&session.lock));
        let run = move || {
            let folder = editing::folder(&project);
            // The project's lock is the window's as long as the project is open, and held on to while paint is
            // written.
            let hold = || Ok((lock.upgrade().ok_or(Error::Cancelled)?, turn.take()));
            let told = |imported, spent| tell(News::Imported(imported, spent));
            if let Err(error) = watched(&project, &folder, WatchOptions::default(), hold, &task, told) {
                let text = format!("{}: no longer watched: {error}", folder.display());
                tell(News::Said(Note::new(Weight::Problem, text)));
            }
        };
        std::thread::Builder::new().name("saves".into()).spawn(run).ok()?;
        Some(Self { stop, receive })
    }
}

fn watched<Held>(
    project: &Path,
    folder: &Path,
    options: WatchOptions,
    hold: impl Fn() -> Result<Held>,
    task: &Task,
    told: impl FnMut(Imported, Duration),
) -> Result<()> {
    let watching = || watch(project, folder, options, hold, task, told);
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(watching)).unwrap_or_else(|_| {
        Err(Error::Request("this is a fault of the program; open the project again".into()))
    })
}

impl Drop for Watching {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// Watches for saves, if there is a folder to watch and nobody does yet.
pub fn watch_for_saves(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    if work.watching.is_none() && editing::folder(&session.folder).is_dir() {
        work.watching = Watching::start(session, work.turn.clone(), work.waker.clone());
    }
}

/// Takes in what was saved.
pub fn take_saved(state: &mut State, work: &mut Work) {
    let Some(watching) = &work.watching else { return };
    let mut news = Vec::new();
    let ended = loop {
        match watching.receive.try_recv() {
            Ok(one) => news.push(one),
            Err(none) => break none,
        }
    };
    // What ended can begin again.
    if ended == TryRecvError::Disconnected {
        work.watching = None;
    }
    for news in news {
        let asks = match news {
            News::Imported(imported, spent) => state.paint_came(imported, spent, Way::Saved),
            News::Said(note) => {
                state.tell(note);
                Vec::new()
            }
        };
        asks.into_iter().for_each(|ask| apply(state, work, ask));
    }
}
