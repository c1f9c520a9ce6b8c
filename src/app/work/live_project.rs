//! The open project as a background update sees it: the window publishes it, the update reads it from its thread.

use std::any::Any;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

use super::write_lock::{WriteGuard, WriteLock};
use crate::state::session::Session;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_files::lock::ProjectLock;
use quadratura_sites::open::Opened;
use quadratura_sites::site_stamp::SiteStamp;
use quadratura_stacks::turns::UpdateSource;

/// The interval at which an update that waits for imports and masks looks again.
const AGAIN: Duration = Duration::from_millis(20);

/// The flags that stop single photos of an update, by name.
pub type PhotoStops = BTreeMap<String, Arc<AtomicBool>>;

/// The open project, shared with the thread of an update.
#[derive(Clone, Default)]
pub struct LiveProject {
    inputs: Arc<Mutex<UpdateInputs>>,
    /// Whether imports or masks come first.
    gives_way: Arc<AtomicBool>,
    /// The number of photos, or groups of them, that updates are done with.
    turns: Arc<AtomicUsize>,
    /// The lock for writing stacks.
    pub stacks: WriteLock,
    /// The lock for writing paint.
    pub paint: WriteLock,
}

/// What an update reads: the project as it was published last, and the flags that stop its photos.
#[derive(Default)]
struct UpdateInputs {
    now: Option<ProjectState>,
    stops: PhotoStops,
}

/// A state of the project.
struct ProjectState {
    folder: PathBuf,
    /// What the window has, whatever has changed of it.
    latest: Arc<Opened>,
    /// The same, unchanged while nothing changes that stacks depend on.
    opened: Arc<Opened>,
    seen: SiteStamp,
    lock: Weak<ProjectLock>,
}

impl LiveProject {
    /// Publishes the project as it is now; `None` while no project is open, or the site in memory is not yet what the
    /// decisions say. Photos that are being updated from other inputs are stopped. Returns whether anything has changed
    /// that stacks depend on.
    pub fn publish(&self, session: Option<&Session>) -> bool {
        let mut inputs = self.inputs();
        let Some(session) = session else {
            inputs.now = None;
            return false;
        };
        let before = inputs.now.as_ref().filter(|now| now.folder == session.folder);
        if before.is_some_and(|now| Arc::ptr_eq(&now.latest, &session.opened) && now.seen == session.seen) {
            return false;
        }
        let same = before.map(|now| &now.opened).filter(|opened| makes_the_same(opened, &session.opened));
        let (opened, is_other) = (same.unwrap_or(&session.opened).clone(), same.is_none());
        if let Some(before) = before.filter(|_| is_other) {
            stop_changed(&inputs.stops, &before.opened, &opened);
        }
        inputs.now = Some(ProjectState {
            folder: session.folder.clone(),
            latest: session.opened.clone(),
            opened,
            seen: session.seen.clone(),
            lock: Arc::downgrade(&session.lock),
        });
        is_other
    }

    /// Makes updates wait before their next photo (`true`), because an import or a mask comes first.
    pub fn give_way(&self, gives_way: bool) {
        self.gives_way.store(gives_way, Ordering::Relaxed);
    }

    /// Returns the number of turns of updates that have ended.
    pub fn turns(&self) -> usize {
        self.turns.load(Ordering::Relaxed)
    }

    /// Returns new flags for an update of all photos, in place of those of the last one.
    pub fn new_stops(&self) -> PhotoStops {
        let mut inputs = self.inputs();
        let photos = inputs.now.iter().flat_map(|now| &now.opened.site.photos);
        let stops: PhotoStops = photos.map(|photo| (photo.name.clone(), Arc::default())).collect();
        inputs.stops = stops.clone();
        stops
    }

    fn inputs(&self) -> MutexGuard<'_, UpdateInputs> {
        // Its parts are replaced as wholes, so they are valid after a panic elsewhere.
        self.inputs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the lock of the project while it is open.
    fn project_lock(&self) -> Result<Arc<ProjectLock>> {
        let lock = self.inputs().now.as_ref().and_then(|now| now.lock.upgrade());
        lock.ok_or(Error::Cancelled)
    }

    /// Returns whether an update could go on with its next photo now.
    #[cfg(test)]
    pub fn is_free_now(&self) -> bool {
        matches!(self.next_turn(), Ok(Some(_)))
    }

    fn next_turn(&self) -> Result<Option<UpdateTurn>> {
        let lock = self.project_lock()?;
        let waits = self.gives_way.load(Ordering::Relaxed) || self.paint.try_take().is_none();
        let stacks = self.stacks.try_take().filter(|_| !waits);
        Ok(stacks.map(|stacks| UpdateTurn { _locks: (lock, stacks), ended: self.turns.clone() }))
    }
}

/// The right to write during one turn of an update.
struct UpdateTurn {
    _locks: (Arc<ProjectLock>, WriteGuard),
    ended: Arc<AtomicUsize>,
}

impl Drop for UpdateTurn {
    fn drop(&mut self) {
        self.ended.fetch_add(1, Ordering::Relaxed);
    }
}

impl UpdateSource for LiveProject {
    /// The window holds the project's lock as long as the project is open. The update shares it while it works on a
    /// photo, and waits for imports, masks, and the jobs that the user has started.
    fn right(&self, task: &Task) -> Result<Box<dyn Any>> {
        loop {
            task.check_cancelled()?;
            match self.next_turn()? {
                Some(turn) => return Ok(Box::new(turn)),
                None => std::thread::sleep(AGAIN),
            }
        }
    }

    /// Returns the project with its unsaved decisions. The update ends where files of the site have changed on disk: they
    /// are reloaded only by the user.
    fn project(&self, _: &Task) -> Result<Arc<Opened>> {
        let now = |inputs: &UpdateInputs| {
            let now = inputs.now.as_ref()?;
            Some((now.folder.clone(), now.opened.clone(), now.seen.clone()))
        };
        let (folder, opened, seen) = now(&self.inputs()).ok_or(Error::Cancelled)?;
        match seen.changes(&SiteStamp::new(&folder, &opened.project)).is_empty() {
            true => Ok(opened),
            false => Err(Error::Cancelled),
        }
    }

    fn hold(&self) -> Box<dyn Any> {
        Box::new(self.paint.take())
    }
}

/// Returns whether two states of a project make the same stacks and fillings.
fn makes_the_same(one: &Opened, other: &Opened) -> bool {
    let project = Project {
        views: other.project.views.clone(),
        flight: other.project.flight.clone(),
        ..one.project.clone()
    };
    is_same_site(one, other) && project == other.project
}

fn is_same_site(one: &Opened, other: &Opened) -> bool {
    Arc::ptr_eq(&one.whole, &other.whole) && Arc::ptr_eq(&one.site.model, &other.site.model)
}

/// Stops the photos whose stacks would be others now.
fn stop_changed(stops: &PhotoStops, before: &Opened, now: &Opened) {
    let all = !is_same_site(before, now) || before.project.options != now.project.options;
    let decided = |opened: &Opened, photo: &str| opened.project.decisions.of(photo).of_stack();
    for (photo, stop) in stops {
        let is_other = before.project.masks.of(photo) != now.project.masks.of(photo)
            || decided(before, photo) != decided(now, photo);
        if all || is_other {
            stop.store(true, Ordering::Relaxed);
        }
    }
}
