//! The turns of an update: between photos other commands may write to the project, and nothing becomes current that was
//! made from an older state of it.

use std::any::Any;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::fill::inputs::FillInputs;
use crate::inputs::Inputs;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Photo, Site};
use quadratura_base::task::Task;
use quadratura_document::{Project, Stack};
use quadratura_files::stamp::Stamp;
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::StackStore;
use quadratura_sites::open::Opened;

/// The project that an update works on, as its owner knows it: a command reads it from disk, the window has it in
/// memory.
pub trait UpdateSource: Sync {
    /// Waits for the right to write to the project. It lasts until the returned value is dropped.
    ///
    /// # Errors
    /// [`Error::Cancelled`], or the reason why there is no point in waiting.
    fn right(&self, task: &Task) -> Result<Box<dyn Any>>;

    /// Returns the project as it is now; the same [`Arc`] while nothing that a stack depends on has changed.
    ///
    /// # Errors
    /// The reason why the project cannot be read, or should not be read without asking the user.
    fn project(&self, task: &Task) -> Result<Arc<Opened>>;

    /// Keeps paint as it is until the returned value is dropped, so that the last check of the inputs and the commit are
    /// one step. Where [`Self::right`] excludes imports, there is nothing to do.
    fn hold(&self) -> Box<dyn Any> {
        Box::new(())
    }
}

/// The turns of one pass over the photos, all with the same state of the project.
pub struct Turns<'a> {
    source: &'a dyn UpdateSource,
    /// The state of the project from which everything is made.
    opened: &'a Arc<Opened>,
    store: &'a StackStore,
    /// The flags that stop single photos.
    stops: &'a BTreeMap<String, Arc<AtomicBool>>,
    /// The stamps of paint and stacks, as this pass left them.
    stamp: Mutex<Derived>,
    /// Whether a turn has begun before.
    begun: AtomicBool,
}

/// How the inputs of a filling compare with those of now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FillCheck {
    /// It would be made from the same inputs.
    Same,
    /// It would be made from other paint.
    OtherPaint,
}

/// The time between two turns in which others can take the lock; longer than the pauses in which they try.
const GAP: Duration = Duration::from_millis(50);

/// The stamps of the files that fillings are made from, beside the site's.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Derived {
    paint: Stamp,
    stacks: Vec<Stamp>,
}

impl<'a> Turns<'a> {
    /// Starts a pass; call this before the stacks are read from which it works.
    pub(crate) fn new(
        source: &'a dyn UpdateSource,
        opened: &'a Arc<Opened>,
        store: &'a StackStore,
        stops: &'a BTreeMap<String, Arc<AtomicBool>>,
    ) -> Self {
        let stamp = Mutex::new(Derived::new(&opened.site, store));
        Self { source, opened, store, stops, stamp, begun: AtomicBool::new(false) }
    }

    /// Waits for the turn of the next photos, which ends when the returned value is dropped; `None` where the project
    /// has changed since this pass began, so that it must end. Another program may have written the stack of a photo (index in the
    /// site); `is_same` says whether that changes nothing for this pass.
    ///
    /// # Errors
    /// The errors of [`UpdateSource`] and of `is_same`.
    pub fn begin(
        &self,
        is_same: impl Fn(usize) -> Result<bool>,
        task: &Task,
    ) -> Result<Option<Box<dyn Any>>> {
        if self.begun.swap(true, Ordering::Relaxed) {
            std::thread::sleep(GAP);
        }
        let right = self.source.right(task)?;
        if !Arc::ptr_eq(&self.source.project(task)?, self.opened) {
            return Ok(None);
        }
        let now = Derived::new(&self.opened.site, self.store);
        let mut known = self.stamp();
        let mut is_same_yet = known.paint == now.paint;
        for (photo, (known, now)) in known.stacks.iter_mut().zip(now.stacks).enumerate() {
            if is_same_yet && *known != now {
                is_same_yet = is_same(photo)?;
                *known = now;
            }
        }
        Ok(is_same_yet.then_some(right))
    }

    /// Returns the task of one photo, which its own flag stops, too.
    pub(crate) fn task_of(&self, photo: &str, task: &Task) -> Task {
        match self.stops.get(photo) {
            Some(stop) => task.also_stopped_by(stop.clone()),
            None => task.clone(),
        }
    }

    /// Checks that a stack of `photo` that was made from `inputs` would be made from the same ones now. They stay so until
    /// the returned value is dropped.
    ///
    /// # Errors
    /// [`Error::Cancelled`] where it would not, and the errors of [`UpdateSource`].
    pub(crate) fn check_stack(&self, photo: &Photo, inputs: &str, task: &Task) -> Result<Box<dyn Any>> {
        let held = self.source.hold();
        task.check_cancelled()?;
        let now = self.source.project(task)?;
        is_made_from(&now.project, &now.site, photo, inputs)?.then_some(held).ok_or(Error::Cancelled)
    }

    /// Compares the inputs `made`, from which a filling of `stack` was made, with those of now. What is found is true
    /// until the returned value is dropped.
    ///
    /// # Errors
    /// [`Error::Cancelled`] where something else than paint has changed, and the errors of [`UpdateSource`].
    pub(crate) fn check_filling(
        &self,
        stack: &Stack,
        made: &FillInputs,
        task: &Task,
    ) -> Result<(FillCheck, Box<dyn Any>)> {
        let held = self.source.hold();
        task.check_cancelled()?;
        let now = self.source.project(task)?;
        if Arc::ptr_eq(&now, self.opened) && self.stamp().paint == paint_stamp(self.store) {
            return Ok((FillCheck::Same, held));
        }
        let photos = &now.site.photos;
        let stamp = |stack: Stack| stack.inputs().to_owned();
        let stamps = photos.iter().map(|photo| Ok(self.store.current(&photo.name)?.map(stamp)));
        let stamps: Vec<Option<String>> = stamps.collect::<Result<_>>()?;
        let id = now.site.photo_named(&stack.photo.name).ok_or(Error::Cancelled)?;
        if !is_made_from(&now.project, &now.site, now.site.photo(id), &stack.inputs)? {
            return Err(Error::Cancelled);
        }
        let of_now =
            FillInputs::of_stamps(self.store.project(), &now.project, &now.site, &stamps, &now.project.fill)?;
        if of_now.of_stack(stack) == made.of_stack(stack) {
            Ok((FillCheck::Same, held))
        } else if of_now.differs_in_paint_alone(made) {
            Ok((FillCheck::OtherPaint, held))
        } else {
            Err(Error::Cancelled)
        }
    }

    /// Notes that this pass itself has changed the stack of `photo`.
    pub fn committed(&self, photo: &str) {
        let at = self.opened.site.photo_named(photo).expect("the photo is one of the site's").index();
        self.stamp().stacks[at] = stack_stamp(self.store, photo);
    }

    /// Returns whether a photo's own flag is set.
    pub(crate) fn is_stopped(&self, photo: &str) -> bool {
        self.stops.get(photo).is_some_and(|stop| stop.load(Ordering::Relaxed))
    }

    fn stamp(&self) -> MutexGuard<'_, Derived> {
        // Stamps are replaced as a whole, so they are valid after a panic elsewhere.
        self.stamp.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Returns whether a stack of `photo` that was made from `inputs` would be made from the same ones in this project.
fn is_made_from(project: &Project, site: &Site, photo: &Photo, inputs: &str) -> Result<bool> {
    let id = site.photo_named(&photo.name).ok_or(Error::Cancelled)?;
    let (model, project) = (&site.model, project);
    let hash = Inputs::new(model, &project.options, &project.decisions).hash(site.photo(id))?;
    Ok(hash == inputs)
}

impl Derived {
    fn new(site: &Site, store: &StackStore) -> Self {
        let stacks = site.photos.iter().map(|photo| stack_stamp(store, &photo.name)).collect();
        Self { paint: paint_stamp(store), stacks }
    }
}

fn paint_stamp(store: &StackStore) -> Stamp {
    Stamp::from_path(&PaintStore::new(store.project()).book_file())
}

fn stack_stamp(store: &StackStore, photo: &str) -> Stamp {
    Stamp::from_path(&store.stack_file(photo))
}
