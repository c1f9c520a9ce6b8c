//! Watches the files of the site on disk: a thread looks for changes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use super::waker::Waker;
use crate::app::state::session::Session;
use crate::recipe::site_stamp::SiteStamp;

/// The interval of checks: a user looks at the window some seconds after exporting a model.
const LOOKS_EVERY: Duration = Duration::from_secs(2);
/// Checking takes at most this share of the time (1 / `SHARE`): thousands of photos on a slow drive take a while.
const SHARE: u32 = 50;
/// The interval at which the thread looks for a request to stop.
const LISTEN: Duration = Duration::from_millis(200);

/// The thread; it stops when this is dropped.
pub struct OnDisk {
    ends: Arc<AtomicBool>,
    receive: Receiver<SiteStamp>,
}

impl Drop for OnDisk {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
    }
}

impl OnDisk {
    /// Starts the thread; none where the system cannot start one.
    pub fn new(session: &Session, waker: Waker) -> Option<Self> {
        let (send, receive) = channel();
        let ends = Arc::new(AtomicBool::new(false));
        let (folder, project) = (session.folder.clone(), session.history.present().clone());
        let (mut message, mut last) = (session.seen.clone(), session.seen.clone());
        let asked = ends.clone();
        let look = move || {
            let mut rest = LOOKS_EVERY;
            while waited(rest, &asked) {
                let since = Instant::now();
                let now = SiteStamp::new(&folder, &project);
                rest = LOOKS_EVERY.max(since.elapsed() * SHARE);
                // Files that are still being written are reported when they are complete.
                let steady = std::mem::replace(&mut last, now.clone()) == now;
                if steady && now != message {
                    message = now.clone();
                    if send.send(now).is_err() {
                        return;
                    }
                    waker.wake();
                }
            }
        };
        std::thread::Builder::new().name("files".into()).spawn(look).ok()?;
        Some(Self { ends, receive })
    }

    /// Takes the latest stamp of the files, where they have changed.
    pub fn take(&self) -> Option<SiteStamp> {
        self.receive.try_iter().last()
    }
}

/// Waits; returns false where the thread is asked to stop.
fn waited(time: Duration, ends: &AtomicBool) -> bool {
    let since = Instant::now();
    while since.elapsed() < time {
        if ends.load(Ordering::Relaxed) {
            return false;
        }
        std::thread::sleep(LISTEN);
    }
    !ends.load(Ordering::Relaxed)
}
