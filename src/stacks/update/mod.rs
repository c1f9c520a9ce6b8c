//! The command `update`: builds and fills every photo that needs it, and lets others write to the project in between.
//!
//! Stacks come first, then fillings, because a filling is made from the stacks of all photos. The right to write is held
//! for one photo (or for those that are built at the same time) and released between them. What was made becomes
//! current only if it would be made from the same inputs then; otherwise the photo is tried again.

mod on_disk;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

pub use self::on_disk::ProjectOnDisk;
use crate::build::{BuildOptions, Built, STAGE, build, build_in_turn};
use crate::fill::{FillRequest, FilledPhoto, fill_in_turns};
use crate::layer_names::rename;
use crate::survey::{StackState, Survey};
use crate::turns::{Turns, UpdateSource};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Photo, Site};
use quadratura_base::task::Task;
use quadratura_document::{Project, Stack};
use quadratura_io::stack_store::StackStore;
use quadratura_layers::Rasteriser;
use quadratura_sites::budget::default_memory;
use quadratura_sites::named::index_of_photo;
use quadratura_sites::open::Opened;

/// How often the photos that are left are tried while nothing of them becomes current, because their inputs change each
/// time.
const ROUNDS: usize = 3;

/// A request to [`update`].
#[derive(Debug, Clone)]
pub struct UpdateRequest {
    /// The names of the photos in the order in which they are updated; empty for all, in the site's order.
    pub photos: Vec<String>,
    /// Whether photos that were never built are skipped.
    pub only_existing: bool,
    /// The largest number of photos that are built at the same time, while the lock is held.
    pub together: usize,
    /// The memory budget in bytes.
    pub memory: u64,
    /// Whether earlier versions of stacks are kept, as [`StackStore::keeping_former`] does.
    pub keep_former: bool,
    /// The flags that stop single photos, by name; the others go on.
    pub stops: BTreeMap<String, Arc<AtomicBool>>,
}

/// All photos, a photo per core at a time, a quarter of the available memory.
impl Default for UpdateRequest {
    fn default() -> Self {
        Self {
            photos: Vec::new(),
            only_existing: false,
            together: rayon::current_num_threads(),
            memory: default_memory(),
            keep_former: false,
            stops: BTreeMap::new(),
        }
    }
}

/// The result for one photo.
#[derive(Debug)]
pub struct UpdatedPhoto {
    /// The photo's name.
    pub photo: String,
    /// Whether its stack was built.
    pub built: bool,
    /// Whether its stack was filled.
    pub filled: bool,
    /// How it ended.
    pub end: UpdateEnd,
    /// Files that were edited by hand; they were moved to these paths in `inbox/`.
    pub kept: Vec<PathBuf>,
}

/// How the update of a photo ended.
#[derive(Debug)]
pub enum UpdateEnd {
    /// Stack and filling are up to date.
    Current(Box<Stack>),
    /// The photo was never built and was skipped.
    NeverBuilt,
    /// Its inputs changed each time that it was tried. What was current is still current.
    Changed,
    /// It was stopped by its own flag.
    Stopped,
    /// It failed; the others went on.
    Failed(Error),
}

/// Updates photos of a project. `rasteriser` is asked for when a photo has to be built, so that nothing is started when
/// all are up to date. Results are in the order of the request.
///
/// # Errors
/// [`Error::Request`] for names that the site does not have, the errors of `source` and `rasteriser`, and
/// [`Error::Cancelled`]. Photos that were finished before the error are up to date.
pub fn update(
    store: &StackStore,
    source: &dyn UpdateSource,
    request: &UpdateRequest,
    rasteriser: &dyn Fn() -> Result<Box<dyn Rasteriser>>,
    task: &Task,
) -> Result<Vec<UpdatedPhoto>> {
    let store = &if request.keep_former { store.clone().keeping_former() } else { store.clone() };
    let names = in_order(&*source.project(task)?, &request.photos)?;
    let photos = open(names);
    let mut job =
        UpdateJob { store, source, request, make: rasteriser, rasteriser: None, photos, commits: 0 };
    job.clean(task)?;
    let mut in_vain = 0;
    let mut known = source.project(task)?;
    while in_vain <= ROUNDS {
        let opened = source.project(task)?;
        if !Arc::ptr_eq(&opened, &known) {
            job.reopen();
        }
        if job.open(&opened.site).is_empty() {
            break;
        }
        let before = job.commits;
        // A filling is made from the stacks of all photos, so these come first, but not for ever.
        let complete = job.build(&opened, task)?;
        if (complete || in_vain == ROUNDS) && !job.fill(&opened, task)? {
            job.reopen();
        }
        known = opened;
        in_vain = if job.commits > before { 0 } else { in_vain + 1 };
    }
    Ok(job.photos.into_iter().map(OpenPhoto::ended).collect())
}

/// Builds the stacks of these photos that are missing, out of date or damaged, and returns those. The caller holds the
/// project's lock.
///
/// # Errors
/// The errors of `rasteriser`; [`Error::Cancelled`].
pub fn build_needed(
    project: &Project,
    site: &Site,
    store: &StackStore,
    photos: &[&Photo],
    memory: u64,
    rasteriser: impl FnOnce() -> Result<Box<dyn Rasteriser>>,
    task: &Task,
) -> Result<Vec<Built>> {
    let survey = Survey::new(project, site, store);
    let mut needed = Vec::new();
    for photo in photos {
        if is_photos_to_build(store, project, photo, &survey.state(photo)?)? {
            needed.push(photo.name.clone());
        }
    }
    if needed.is_empty() {
        return Ok(Vec::new());
    }
    let options = options(project, needed, memory, rayon::current_num_threads());
    build(site, store, &*rasteriser()?, &options, task)
}

/// Returns the names of photos in the order of a request; all of them where it names none.
fn in_order(opened: &Opened, names: &[String]) -> Result<Vec<String>> {
    // This judges all names at once.
    let all = opened.photos_named(names)?;
    if names.is_empty() {
        return Ok(all.into_iter().map(|photo| photo.name.clone()).collect());
    }
    let mut ordered = Vec::with_capacity(names.len());
    for name in names {
        let photo = &opened.site.photo(index_of_photo(&opened.site, name)?).name;
        if !ordered.contains(photo) {
            ordered.push(photo.clone());
        }
    }
    Ok(ordered)
}

/// Returns whether a photo's stack has to be built, or its layers renamed.
fn is_photos_to_build(
    store: &StackStore,
    project: &Project,
    photo: &Photo,
    state: &StackState,
) -> Result<bool> {
    let StackState::Current(stack) = state else { return Ok(true) };
    let Some(mut stack) = store.up_to_date(&photo.name, &stack.inputs)? else { return Ok(true) };
    Ok(rename(&mut stack, &project.decisions.of(&photo.name).names).changed)
}

fn options(project: &Project, photos: Vec<String>, memory: u64, threads: usize) -> BuildOptions {
    BuildOptions {
        layers: project.options.clone(),
        decisions: project.decisions.clone(),
        photos,
        memory,
        threads,
        force: false,
    }
}

/// A photo on its way.
struct OpenPhoto {
    photo: String,
    built: bool,
    filled: bool,
    end: Option<UpdateEnd>,
    kept: Vec<PathBuf>,
}

fn open(names: Vec<String>) -> Vec<OpenPhoto> {
    let open = |photo| OpenPhoto { photo, built: false, filled: false, end: None, kept: Vec::new() };
    names.into_iter().map(open).collect()
}

impl OpenPhoto {
    fn ended(self) -> UpdatedPhoto {
        let Self { photo, built, filled, end, kept } = self;
        UpdatedPhoto { photo, built, filled, end: end.unwrap_or(UpdateEnd::Changed), kept }
    }
}

struct UpdateJob<'a> {
    store: &'a StackStore,
    source: &'a dyn UpdateSource,
    request: &'a UpdateRequest,
    make: &'a dyn Fn() -> Result<Box<dyn Rasteriser>>,
    rasteriser: Option<Box<dyn Rasteriser>>,
    photos: Vec<OpenPhoto>,
    /// The number of stacks and fillings that became current.
    commits: usize,
}

impl UpdateJob<'_> {
    /// Removes what killed builds left over.
    fn clean(&mut self, task: &Task) -> Result<()> {
        let _right = self.source.right(task)?;
        if !self.request.photos.is_empty() {
            // Each photo is cleaned when it has its turn.
            return Ok(());
        }
        for file in self.store.clean()? {
            task.note(format!("a file that was changed by hand was moved to {}", file.display()));
        }
        Ok(())
    }

    /// Returns the names of the photos that have not ended. Those that the site has no longer end here.
    fn open(&mut self, site: &Site) -> Vec<String> {
        let gone = |name: &str| Error::Request(format!("{name} is no longer one of the project's photos"));
        for photo in self.photos.iter_mut().filter(|photo| photo.end.is_none()) {
            if site.photo_named(&photo.photo).is_none() {
                photo.end = Some(UpdateEnd::Failed(gone(&photo.photo)));
            }
        }
        self.photos.iter().filter(|photo| photo.end.is_none()).map(|photo| photo.photo.clone()).collect()
    }

    /// Looks again at photos that were up to date, because the project has changed since.
    fn reopen(&mut self) {
        let current = |photo: &&mut OpenPhoto| matches!(photo.end, Some(UpdateEnd::Current(_)));
        self.photos.iter_mut().filter(current).for_each(|photo| photo.end = None);
    }

    fn photo(&mut self, name: &str) -> &mut OpenPhoto {
        self.photos.iter_mut().find(|photo| photo.photo == name).expect("only these photos are updated")
    }

    /// Builds the stacks that need it. Returns false where the project has changed meanwhile.
    fn build(&mut self, opened: &Arc<Opened>, task: &Task) -> Result<bool> {
        let needed = self.photos_to_build(&opened.project, &opened.site, task)?;
        let turns = Turns::new(self.source, opened, self.store, &self.request.stops);
        let (mut done, total) = (0, needed.len() as u64);
        for some in needed.chunks(self.request.together.max(1)) {
            task.step(STAGE, done, total)?;
            done += some.len() as u64;
            // A stack depends on no other.
            let Some(_turn) = turns.begin(|_| Ok(true), task)? else { return Ok(false) };
            let rasteriser = match &mut self.rasteriser {
                Some(rasteriser) => rasteriser,
                none => none.insert((self.make)()?),
            };
            let options = options(&opened.project, some.to_vec(), self.request.memory, self.request.together);
            let part = task.within_step();
            for built in build_in_turn(&opened.site, self.store, &**rasteriser, &options, &turns, &part)? {
                self.note_built(built, &turns);
            }
        }
        task.step(STAGE, total, total)?;
        Ok(Arc::ptr_eq(&self.source.project(task)?, opened))
    }

    /// Returns the photos whose stacks are to be built, in order. Photos to be skipped end here.
    fn photos_to_build(&mut self, project: &Project, site: &Site, task: &Task) -> Result<Vec<String>> {
        let survey = Survey::new(project, site, self.store);
        let mut needed = Vec::new();
        let names = self.open(site);
        let count = names.len() as u64;
        for (name, done) in names.into_iter().zip(0..) {
            task.step("check stacks", done, count)?;
            let photo = photo_of(site, &name);
            let state = survey.state(photo)?;
            if matches!(state, StackState::Missing) && self.request.only_existing {
                self.photo(&name).end = Some(UpdateEnd::NeverBuilt);
            } else if is_photos_to_build(self.store, project, photo, &state)? {
                needed.push(name);
            }
        }
        Ok(needed)
    }

    fn note_built(&mut self, built: Built, turns: &Turns) {
        let stopped = turns.is_stopped(&built.photo);
        self.commits += usize::from(built.stack.is_ok() && !built.up_to_date);
        let photo = self.photo(&built.photo);
        photo.kept.extend(built.kept);
        match built.stack {
            Ok(_) => {
                photo.built |= !built.up_to_date;
                turns.committed(&built.photo);
            }
            Err(Error::Cancelled) => photo.end = stopped.then_some(UpdateEnd::Stopped),
            Err(error) => photo.end = Some(UpdateEnd::Failed(error)),
        }
    }

    /// Fills the stacks that need it. Returns false where it ended early, because the project has changed.
    fn fill(&mut self, opened: &Arc<Opened>, task: &Task) -> Result<bool> {
        let turns = Turns::new(self.source, opened, self.store, &self.request.stops);
        let survey = Survey::new(&opened.project, &opened.site, self.store);
        let mut photos = Vec::new();
        for name in self.open(&opened.site) {
            // Another program may have changed the project meanwhile: the photo is built in the next round.
            if matches!(survey.state(photo_of(&opened.site, &name))?, StackState::Current(_)) {
                photos.push(name);
            }
        }
        if photos.is_empty() {
            return Ok(true);
        }
        let wanted = photos.len();
        let request = FillRequest {
            options: opened.project.fill.clone(),
            photos,
            memory: self.request.memory,
            force: false,
            keep_former: self.request.keep_former,
        };
        let filled =
            fill_in_turns(self.store.project(), &opened.project, &opened.site, &request, &turns, task)?;
        let complete = filled.len() == wanted;
        filled.into_iter().for_each(|filled| self.note_filled(filled, &turns));
        Ok(complete)
    }

    fn note_filled(&mut self, filled: FilledPhoto, turns: &Turns) {
        let stopped = turns.is_stopped(&filled.photo);
        self.commits += usize::from(filled.stack.is_ok() && !filled.up_to_date);
        let photo = self.photo(&filled.photo);
        photo.kept.extend(filled.kept);
        match filled.stack {
            // What was computed is not lost; paint that came meanwhile is added in the next round.
            Ok(_) if filled.is_behind => photo.filled = true,
            Ok(stack) => {
                photo.filled |= !filled.up_to_date;
                photo.end = Some(UpdateEnd::Current(Box::new(stack)));
            }
            Err(Error::Cancelled) => photo.end = stopped.then_some(UpdateEnd::Stopped),
            Err(error) => photo.end = Some(UpdateEnd::Failed(error)),
        }
    }
}

fn photo_of<'a>(site: &'a Site, name: &str) -> &'a Photo {
    site.photo(site.photo_named(name).expect("open() keeps photos of the site only"))
}
