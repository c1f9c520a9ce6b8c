//! A thread that imports all files saved in the project's folder of documents.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::Duration;

use super::PaintLock;
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

/// A message of the thread.
enum News {
    Imported(Imported, Duration),
    Said(Note),
}

/// The thread; it stops when this is dropped.
pub struct Watching {
    stop: Arc<AtomicBool>,
    receive: Receiver<News>,
}

impl Watching {
    /// Watches the folder of documents of an open project. Files saved before the watch are imported at once; an import
    /// that was undone stays undone.
    fn start(session: &Session, turn: PaintLock, waker: Waker) -> Option<Self> {
        let (send, receive) = channel();
        let tell = move |news: News| {
            // The receiver is gone when another project is open.
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
            // The window holds the project's lock as long as the project is open; the thread holds it while paint is
            // written.
            let hold = || Ok((lock.upgrade().ok_or(Error::Cancelled)?, turn.take()));
            let message = |imported, spent| tell(News::Imported(imported, spent));
            if let Err(error) = watched(&project, &folder, WatchOptions::default(), hold, &task, message) {
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
    message: impl FnMut(Imported, Duration),
) -> Result<()> {
    let watching = || watch(project, folder, options, hold, task, message);
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(watching)).unwrap_or_else(|_| {
        Err(Error::Request("this is a fault of the program; open the project again".into()))
    })
}

impl Drop for Watching {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// Starts the watch for saved documents, if there is a folder and no watch yet.
pub fn watch_for_saves(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    if work.watching.is_none() && editing::folder(&session.folder).is_dir() {
        work.watching = Watching::start(session, work.turn.clone(), work.waker.clone());
    }
}

/// Handles documents that were saved.
pub fn take_saved(state: &mut State, work: &mut Work) {
    let Some(watching) = &work.watching else { return };
    let mut news = Vec::new();
    let ended = loop {
        match watching.receive.try_recv() {
            Ok(one) => news.push(one),
            Err(none) => break none,
        }
    };
    // A watch that has ended can be started again.
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
