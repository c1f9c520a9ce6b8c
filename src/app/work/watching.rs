//! A thread that imports all files saved in the project's folder of documents.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::Duration;

use super::priority::lower_own_priority;
use super::waker::Waker;
use super::write_lock::WriteLock;
use crate::state::notes::{Note, Weight};
use crate::state::session::Session;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::{Event, Task};
use quadratura_editing::editing;
use quadratura_editing::import::Imported;
use quadratura_editing::watch::{WatchOptions, watch};

/// A message of the thread.
pub enum News {
    /// Files were imported, in this time.
    Imported(Imported, Duration),
    /// Something is to be reported.
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
    pub fn start(session: &Session, turn: WriteLock, waker: Waker) -> Option<Self> {
        let (send, receive) = channel();
        let notify = move |news: News| {
            // The receiver is gone when another project is open.
            let _ = send.send(news);
            waker.wake();
        };
        let said = notify.clone();
        let task = Task::new(move |event| {
            if let Event::Note { subject, text } = event {
                said(News::Said(Note::about(Weight::Warning, subject, text)));
            }
        });
        let stop = task.stop_flag();
        let (project, lock) = (session.folder.clone(), Arc::downgrade(&session.lock));
        let run = move || {
            lower_own_priority();
            let folder = editing::folder(&project);
            // The window holds the project's lock as long as the project is open; the thread holds it while paint is
            // written.
            let hold = || Ok((lock.upgrade().ok_or(Error::Cancelled)?, turn.take()));
            let message = |imported, spent| notify(News::Imported(imported, spent));
            if let Err(error) = watched(&project, &folder, WatchOptions::default(), hold, &task, message) {
                let text = format!("{} is no longer watched: {error}", folder.display());
                notify(News::Said(Note::new(Weight::Problem, text)));
            }
        };
        std::thread::Builder::new().name("saves".into()).spawn(run).ok()?;
        Some(Self { stop, receive })
    }

    /// Takes the messages since the last call, in order; the second value is whether the thread has ended.
    pub fn take(&self) -> (Vec<News>, bool) {
        let mut news = Vec::new();
        loop {
            match self.receive.try_recv() {
                Ok(one) => news.push(one),
                Err(none) => return (news, none == TryRecvError::Disconnected),
            }
        }
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
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(watching))
        .unwrap_or_else(|_| Err(Error::Request("this is an internal error; open the project again".into())))
}

impl Drop for Watching {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}
