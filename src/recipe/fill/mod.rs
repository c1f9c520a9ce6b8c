//! `fill`: what the photos did not show of their image layers.

mod donors;
mod hidden;
mod report;
mod write;

use std::path::{Path, PathBuf};

use self::donors::PhotoDonors;
use self::hidden::hidden_regions;
use self::write::write_fill;
use super::gains::{self, photo_gains};
use super::named::photos_named;
use super::open::Opened;
use super::relief::SiteRelief;
use super::sources::sources;
use super::survey::{StackState, Survey};
use crate::document::{Decisions, Stack};
use crate::error::{Error, Result};
use crate::io::hash::hash_bytes;
use crate::io::stack_store::StackStore;
use crate::layers::fill::{FillOptions, Ground, Plates, Surfaces, fill_photo};
use crate::projection::{PhotoId, Sources};
use crate::scene::{Model, Photo};
use crate::task::Task;

pub use report::FillShares;

/// Changes whenever the same inputs would be filled otherwise.
const VERSION: u32 = 1;

/// What `fill` is asked to do.
#[derive(Debug, Clone, PartialEq)]
pub struct FillRequest {
    /// The method.
    pub options: FillOptions,
    /// Only these photos; empty for all.
    pub photos: Vec<String>,
    /// Bytes that decoded photos may take together.
    pub memory: u64,
    /// Also photos whose filling is up to date.
    pub force: bool,
}

/// What became of one photo.
#[derive(Debug)]
pub struct FilledPhoto {
    /// Its name.
    pub photo: String,
    /// Its stack with the filling, or why there is none.
    pub stack: Result<Stack>,
    /// Nothing had changed, nothing was written.
    pub up_to_date: bool,
    /// Files somebody had changed by hand, as they are now in `inbox/`.
    pub kept: Vec<PathBuf>,
}

/// How a photo's filling stands to the project.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FillState {
    /// Made of the stacks and options as they are now.
    Current,
    /// Something has changed since.
    Stale,
    /// There is none.
    Missing,
}

impl FillState {
    /// One word for a table.
    pub fn word(self) -> &'static str {
        match self {
            Self::Current => "filled",
            Self::Stale => "stale",
            Self::Missing => "not filled",
        }
    }

    /// Of a photo's stack; `inputs` as [`fill_inputs`] says.
    pub fn of(stack: &Stack, inputs: &str) -> Self {
        match &stack.fill {
            None => Self::Missing,
            Some(fill) if fill.inputs == inputs => Self::Current,
            Some(_) => Self::Stale,
        }
    }
}

/// Hash of all that fillings are made of: every photo may give to every other.
pub fn fill_inputs(opened: &Opened, stacks: &[Option<Stack>], options: &FillOptions) -> String {
    let options = serde_json::to_string(options).expect("plain data is JSON");
    let colour = gains::decisions(&opened.project.colour);
    let excluded = excluded(&opened.project.decisions);
    let text = format!("{VERSION} {} {options}{colour}{excluded}", gains::inputs(&opened.site, stacks));
    hash_bytes(text.as_bytes())
}

/// Photos give nothing to faces that they are excluded for; empty where none is.
fn excluded(decisions: &Decisions) -> String {
    let of_photo = decisions.photos.iter().filter(|(_, decided)| !decided.exclude.is_empty());
    let of_photo: Vec<_> = of_photo.map(|(photo, decided)| (photo, &decided.exclude)).collect();
    if of_photo.is_empty() {
        return String::new();
    }
    serde_json::to_string(&of_photo).expect("plain data is JSON")
}

/// Fills the hidden texels of the photos' current stacks, photo by photo. A fault in one photo is in its
/// [`FilledPhoto`]; the others go on. Results come in the site's order.
///
/// # Errors
/// [`Error::Request`] for a photo name that the site does not have, for an object to leave out that the
/// model does not have, and when no photo has a stack; [`Error::Cancelled`].
pub fn fill(folder: &Path, opened: &Opened, request: &FillRequest, task: &Task) -> Result<Vec<FilledPhoto>> {
    let site = &opened.site;
    check_objects(&site.model, &request.options)?;
    let photos = photos_named(site, &request.photos)?;
    let store = StackStore::new(folder);
    let states = task.timed("read stacks", || states(opened, &store))?;
    let stacks: Vec<Option<Stack>> = states.iter().map(|state| state.stack().cloned()).collect();
    if stacks.iter().all(Option::is_none) {
        return Err(Error::Request("no photo has a stack yet; `quadratura build` makes them".into()));
    }
    let inputs = fill_inputs(opened, &stacks, &request.options);
    let job = Job { store: &store, opened, request, states: &states, inputs: &inputs };
    let waiting: Vec<bool> = photos.iter().map(|photo| job.up_to_date(photo)).collect::<Result<_>>()?;
    if waiting.iter().all(|up_to_date| *up_to_date) {
        return Ok(photos.iter().map(|photo| job.untouched(photo)).collect());
    }
    let (memory, colour) = (request.memory, &opened.project.colour);
    let gains = task.timed("gains", || photo_gains(site, &stacks, colour, folder, memory, task))?;
    let relief =
        task.timed("relief", || SiteRelief::open(site, &gains::inputs(site, &stacks), folder, memory, task))?;
    let surfaces = Surfaces::of(&site.model);
    let sources = sources(site, &stacks, &opened.project.decisions);
    let donors = PhotoDonors::new(opened, &surfaces, memory, task);
    let ground = Ground {
        photos: &sources.photos,
        surfaces: &surfaces,
        serving: &serving(&sources),
        relief: relief.whole(),
        gains: &gains,
        options: &request.options,
        source: &donors,
    };
    let mut plates = Plates::default();
    let mut filled = Vec::with_capacity(photos.len());
    for ((done, photo), up_to_date) in (0..).zip(&photos).zip(waiting) {
        task.step("photos", done, photos.len() as u64)?;
        filled.push(match up_to_date {
            true => job.untouched(photo),
            false => job.photo(photo, &ground, &mut plates, &task.of(&photo.name))?,
        });
    }
    task.step("photos", photos.len() as u64, photos.len() as u64)?;
    Ok(filled)
}

fn states(opened: &Opened, store: &StackStore) -> Result<Vec<StackState>> {
    let survey = Survey::new(opened, store);
    opened.site.photos.iter().map(|photo| survey.state(photo)).collect()
}

/// By face, the photos that have it in their working set.
fn serving(sources: &Sources) -> Vec<Vec<PhotoId>> {
    let of_face = |range: &std::ops::Range<u32>| {
        let servers = &sources.servers[range.start as usize..range.end as usize];
        let mut photos: Vec<PhotoId> = servers.iter().map(|server| server.photo).collect();
        photos.dedup();
        photos
    };
    sources.of_face.iter().map(of_face).collect()
}

fn check_objects(model: &Model, options: &FillOptions) -> Result<()> {
    let unknown = |pattern: &&String| {
        let alone = FillOptions { without: vec![(*pattern).clone()], ..FillOptions::default() };
        model.objects.iter().all(|object| alone.fills(&object.name))
    };
    let errors = options.without.iter().filter(unknown);
    let errors = errors.map(|o| {
        let known = objects_in_words(model);
        Error::Request(format!("the model has no object {o:?} to leave unfilled; it has {known}"))
    });
    Error::of_all(errors.collect()).map_or(Ok(()), Err)
}

/// The first objects by name, and how many others there are.
fn objects_in_words(model: &Model) -> String {
    // As many as fit a few lines of a terminal.
    const MOST: usize = 12;
    let mut names: Vec<String> = model.objects.iter().map(|object| format!("{:?}", object.name)).collect();
    names.sort();
    let others = names.len().saturating_sub(MOST);
    let more = if others > 0 { format!(" and {others} more") } else { String::new() };
    names.truncate(MOST);
    names.join(", ") + &more
}

struct Job<'a> {
    store: &'a StackStore,
    opened: &'a Opened,
    request: &'a FillRequest,
    states: &'a [StackState],
    inputs: &'a str,
}

impl Job<'_> {
    fn state(&self, photo: &Photo) -> (PhotoId, &StackState) {
        let place = self.opened.site.photos.iter().position(|other| other.name == photo.name);
        let place = place.expect("the photo is one of the site's");
        (PhotoId(place as u32), &self.states[place])
    }

    fn up_to_date(&self, photo: &Photo) -> Result<bool> {
        let StackState::Current(stack) = self.state(photo).1 else { return Ok(false) };
        let current = FillState::of(stack, self.inputs) == FillState::Current && !self.request.force;
        Ok(current && self.store.up_to_date(&photo.name, &stack.inputs)?.is_some())
    }

    fn untouched(&self, photo: &Photo) -> FilledPhoto {
        let stack = self.state(photo).1.stack().expect("what is up to date has a stack").clone();
        FilledPhoto { photo: photo.name.clone(), stack: Ok(stack), up_to_date: true, kept: Vec::new() }
    }

    /// Only a request to stop is an error here.
    fn photo(&self, photo: &Photo, ground: &Ground, plates: &mut Plates, task: &Task) -> Result<FilledPhoto> {
        let (stack, kept) = match self.try_photo(photo, ground, plates, task) {
            Ok((stack, kept)) => (Ok(stack), kept),
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => (Err(error), Vec::new()),
        };
        Ok(FilledPhoto { photo: photo.name.clone(), stack, up_to_date: false, kept })
    }

    fn try_photo(
        &self,
        photo: &Photo,
        ground: &Ground,
        plates: &mut Plates,
        task: &Task,
    ) -> Result<(Stack, Vec<PathBuf>)> {
        task.go_on()?;
        let (id, state) = self.state(photo);
        let stack = current(photo, state)?;
        let folder = self.store.folder(&photo.name);
        let own = task.timed("read photo", || ground.source.donor(id))?;
        let own = own.ok_or_else(|| Error::Request("the photo cannot be read".into()))?;
        let model = &self.opened.site.model;
        let hidden = task.timed("hidden", || {
            hidden_regions(stack, &folder, &own, model, ground.surfaces, &self.request.options)
        })?;
        let filled = fill_photo(ground, id, hidden.regions, plates, task)?;
        let names: Vec<&str> = ground.photos.iter().map(|photo| photo.name.as_str()).collect();
        let (writer, mut bare) = self.store.amend(stack)?;
        task.timed("write", || write_fill(writer.folder(), &mut bare, &filled, &own, &names))?;
        let fill = bare.fill.as_mut().expect("it was written in the line above");
        (fill.inputs, fill.texels_hidden) = (self.inputs.to_owned(), hidden.texels);
        bare.bytes += fill.bytes;
        let committed = task.timed("commit", || writer.commit(bare))?;
        Ok((committed.stack, committed.kept))
    }
}

fn current<'a>(photo: &Photo, state: &'a StackState) -> Result<&'a Stack> {
    match state {
        StackState::Current(stack) => Ok(stack),
        StackState::Stale(_) => Err(Error::Request(
            "its stack is older than the project; run `quadratura build`, then fill again".into(),
        )),
        StackState::Missing => {
            Err(Error::Request(format!("{} has no stack yet; `quadratura build` makes it", photo.name)))
        }
        StackState::Broken(error) => Err(Error::Request(error.to_string())),
    }
}
