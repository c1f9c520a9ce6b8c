//! Watches the files of the site on disk: a thread looks for changes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::priority::lower_own_priority;
use super::waker::Waker;
use crate::state::session::Session;
use quadratura_document::Project;
use quadratura_io::project::resolved;
use quadratura_sites::site_stamp::SiteStamp;
use quadratura_trees::plant_files::PlantFiles;

/// The interval of checks: a user looks at the window some seconds after exporting a model.
const LOOKS_EVERY: Duration = Duration::from_secs(2);
/// Checking takes at most this share of the time (1 / `SHARE`): thousands of photos on a slow drive take a while.
const SHARE: u32 = 50;
/// The interval at which the thread looks for a request to stop.
const LISTEN: Duration = Duration::from_millis(200);

/// The thread; it stops when this is dropped.
pub struct OnDisk {
    ends: Arc<AtomicBool>,
    /// The project, whose trees change.
    project: Arc<Mutex<Arc<Project>>>,
    receive: Receiver<FoundOnDisk>,
}

/// What has changed on disk.
pub enum FoundOnDisk {
    /// Files of the site, which have this stamp now.
    Site(SiteStamp),
    /// Plants, by their files.
    Plants {
        /// Those that are there.
        there: Vec<String>,
        /// Those whose own file is missing.
        missing: Vec<String>,
    },
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
        let present = Arc::new(Mutex::new(project.clone()));
        let (asked, of_window) = (ends.clone(), present.clone());
        let look = move || {
            lower_own_priority();
            let mut plants = PlantFiles::new(&folder, &project.trees);
            let mut last_plants = plants.clone();
            let mut rest = LOOKS_EVERY;
            while waited(rest, &asked) {
                let since = Instant::now();
                let now = SiteStamp::new(&folder, &project);
                let trees = of_window.lock().unwrap_or_else(PoisonError::into_inner).clone();
                let plants_now = PlantFiles::new(&folder, &trees.trees);
                rest = LOOKS_EVERY.max(since.elapsed() * SHARE);
                let mut found = Vec::new();
                // Files that are still being written are reported when they are complete.
                let steady = std::mem::replace(&mut last, now.clone()) == now;
                if steady && now != message {
                    message = now.clone();
                    found.push(FoundOnDisk::Site(now));
                }
                let steady = std::mem::replace(&mut last_plants, plants_now.clone()) == plants_now;
                if steady {
                    let changed = plants.changed(&plants_now).into_iter();
                    let (there, missing): (Vec<String>, Vec<String>) =
                        changed.map(str::to_owned).partition(|file| resolved(&folder, file).is_file());
                    if !(there.is_empty() && missing.is_empty()) {
                        found.push(FoundOnDisk::Plants { there, missing });
                    }
                    plants.update(plants_now);
                }
                for found in found {
                    if send.send(found).is_err() {
                        return;
                    }
                    waker.wake();
                }
            }
        };
        std::thread::Builder::new().name("files".into()).spawn(look).ok()?;
        Some(Self { ends, project: present, receive })
    }

    /// Watches the plants of the trees of the project as it is now.
    pub fn follow(&self, project: &Arc<Project>) {
        let mut watched = self.project.lock().unwrap_or_else(PoisonError::into_inner);
        if !Arc::ptr_eq(&watched, project) {
            watched.clone_from(project);
        }
    }

    /// Takes what was found since the last time, in its order.
    pub fn take(&self) -> Vec<FoundOnDisk> {
        self.receive.try_iter().collect()
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
