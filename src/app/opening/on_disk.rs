//! Watches the files of the site on disk: a thread looks for changes, and a message offers to reload them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use crate::app::state::State;
use crate::app::state::notes::{Note, Remedy, Weight};
use crate::app::state::session::Session;
use crate::app::work::Work;
use crate::app::work::waker::Waker;
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
    fn new(session: &Session, waker: Waker) -> Option<Self> {
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

/// Starts watching the files that the site was read from.
pub fn watch_disk(state: &mut State, work: &mut Work) {
    work.on_disk = state.session.as_ref().and_then(|session| OnDisk::new(session, work.waker.clone()));
}

/// Reports changes that the thread has found.
pub fn take_changes(state: &mut State, work: &mut Work) {
    let (Some(on_disk), Some(session)) = (&work.on_disk, &state.session) else { return };
    let Some(now) = on_disk.receive.try_iter().last() else { return };
    let changes = session.seen.changes(&now);
    if !changes.is_empty() {
        state.tell(changed(&changes).with("Read files again", Remedy::ReadAgain));
    }
}

/// Makes the message: `The model and photos have changed on disk …`
pub fn changed(parts: &[&str]) -> Note {
    let (last, first) = parts.split_last().unwrap_or((&"something", &[]));
    let parts =
        if first.is_empty() { (*last).to_owned() } else { format!("{} and {last}", first.join(", ")) };
    Note::new(Weight::Warning, format!("On disk it is no longer as it was read: {parts}."))
}
