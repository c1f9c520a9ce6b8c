//! `fill`: what the photos did not show of their image layers.

mod donors;
mod hidden;
mod inputs;
pub mod lookouts;
mod paint;
pub mod propagation;
mod report;
pub mod shares;
pub mod worst;
mod write;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use self::donors::PhotoDonors;
use self::hidden::hidden_regions;
use self::paint::SitePaint;
use self::write::write_fill;
use super::gains::{self, photo_gains};
use super::named::photos_named;
use super::open::Opened;
use super::relief::SiteRelief;
use super::sources::sources;
use super::survey::{StackState, Survey};
use crate::document::Stack;
use crate::document::stack::SpreadPaint;
use crate::error::{Error, Result};
use crate::io::paint_store::PaintStore;
use crate::io::stack_store::StackStore;
use crate::layers::fill::options::is_named;
use crate::layers::fill::{FillOptions, Ground, Offer, Plates, Surfaces, fill_photo, spread_paint};
use crate::projection::{PhotoId, Sources};
use crate::scene::{Model, Photo};
use crate::task::Task;

pub use inputs::FillInputs;
pub use report::FillShares;

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
    /// Former versions of stacks stay, as [`StackStore::keeping_former`] has it.
    pub keep_former: bool,
}

/// What is done with what is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Purpose {
    Fill,
    /// Nothing is filled, and no stack is written.
    Tell,
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
    /// Paint of other photos that belongs on what it shows.
    pub spread: Vec<SpreadPaint>,
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

    /// Of a photo's stack.
    pub fn of(stack: &Stack, inputs: &FillInputs) -> Self {
        match &stack.fill {
            None => Self::Missing,
            Some(fill) if fill.inputs == inputs.of_stack(stack) => Self::Current,
            Some(_) => Self::Stale,
        }
    }
}

/// Fills the hidden texels of the photos' current stacks, photo by photo. A fault in one photo is in its
/// [`FilledPhoto`]; the others go on. Results come in the site's order.
///
/// # Errors
/// [`Error::Request`] for a photo name that the site does not have, for an object to leave out that the
/// model does not have, and when no photo has a stack; when the book of paint cannot be read;
/// [`Error::Cancelled`].
pub fn fill(folder: &Path, opened: &Opened, request: &FillRequest, task: &Task) -> Result<Vec<FilledPhoto>> {
    fill_or_tell(folder, opened, request, Purpose::Fill, task)
}

/// Tells what paint [`fill`] would lay over what photos, whether they are up to date or not; the stacks are as they
/// were.
///
/// # Errors
/// Those of [`fill`].
pub fn tell(folder: &Path, opened: &Opened, request: &FillRequest, task: &Task) -> Result<Vec<FilledPhoto>> {
    fill_or_tell(folder, opened, request, Purpose::Tell, task)
}

fn fill_or_tell(
    folder: &Path,
    opened: &Opened,
    request: &FillRequest,
    purpose: Purpose,
    task: &Task,
) -> Result<Vec<FilledPhoto>> {
    let site = &opened.site;
    check_objects(opened, &request.options)?;
    check_painters(&site.photos, &request.options)?;
    let photos = photos_named(site, &request.photos)?;
    let store = StackStore::new(folder);
    let store = if request.keep_former { store.keeping_former() } else { store };
    let states = task.timed("read stacks", || states(opened, &store))?;
    let stacks: Vec<Option<Stack>> = states.iter().map(|state| state.stack().cloned()).collect();
    if stacks.iter().all(Option::is_none) {
        return Err(Error::Request("no photo has a stack yet; `quadratura build` builds them".into()));
    }
    let inputs = FillInputs::of(folder, opened, &stacks, &request.options)?;
    let surfaces = Surfaces::of(&site.model);
    let paint = SitePaint::of(inputs.book(), &PaintStore::new(folder), &stacks, &site.model, &surfaces);
    let (store, states, inputs, paint) = (&store, &states[..], &inputs, &paint);
    let job = Job { store, opened, request, purpose, states, inputs, paint };
    let waiting: Vec<bool> = photos.iter().map(|photo| job.up_to_date(photo)).collect::<Result<_>>()?;
    if waiting.iter().all(|up_to_date| *up_to_date) {
        return Ok(photos.iter().map(|photo| job.untouched(photo)).collect());
    }
    let (memory, colour) = (request.memory, &opened.project.colour);
    let gains = task.timed("gains", || photo_gains(site, &stacks, colour, folder, memory, task))?;
    let relief =
        task.timed("relief", || SiteRelief::open(site, &gains::inputs(site, &stacks), folder, memory, task))?;
    let sources = sources(site, &stacks, &opened.project.decisions);
    let donors = PhotoDonors::new(opened, &surfaces, paint, memory, task);
    let ground = Ground {
        photos: &sources.photos,
        surfaces: &surfaces,
        serving: &serving(&sources),
        painters: &paint.painters(&site.model),
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

fn check_objects(opened: &Opened, options: &FillOptions) -> Result<()> {
    let objects = opened.site.model.objects.iter().map(|object| &object.name);
    // What is switched off is known, and left unfilled in any case.
    let names: Vec<&String> = objects.chain(&opened.project.objects_off).collect();
    let unknown = |pattern: &&String| {
        let alone = FillOptions { without: vec![(*pattern).clone()], ..FillOptions::default() };
        names.iter().all(|name| alone.fills(name))
    };
    let errors = options.without.iter().filter(unknown);
    let errors = errors.map(|o| {
        let known = objects_in_words(&opened.site.model);
        Error::Request(format!(
            "the model has no object {o:?}, which is to stay unfilled; its objects are \
            {known}"
        ))
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

fn check_painters(photos: &[Photo], options: &FillOptions) -> Result<()> {
    let unknown = |pattern: &&String| !photos.iter().any(|photo| is_named(&photo.name, pattern));
    let errors = options.propagate.iter().filter(unknown);
    let errors =
        errors.map(|p| Error::Request(format!("the site has no photo {p:?} whose paint to propagate")));
    Error::of_all(errors.collect()).map_or(Ok(()), Err)
}

struct Job<'a> {
    store: &'a StackStore,
    opened: &'a Opened,
    request: &'a FillRequest,
    purpose: Purpose,
    states: &'a [StackState],
    inputs: &'a FillInputs,
    paint: &'a SitePaint<'a>,
}

impl Job<'_> {
    fn state(&self, photo: &Photo) -> (PhotoId, &StackState) {
        let place = self.opened.site.photos.iter().position(|other| other.name == photo.name);
        let place = place.expect("the photo is one of the site's");
        (PhotoId(place as u32), &self.states[place])
    }

    fn up_to_date(&self, photo: &Photo) -> Result<bool> {
        let StackState::Current(stack) = self.state(photo).1 else { return Ok(false) };
        let again = self.request.force || self.purpose == Purpose::Tell;
        let current = !again && FillState::of(stack, self.inputs) == FillState::Current;
        Ok(current && self.store.up_to_date(&photo.name, &stack.inputs)?.is_some())
    }

    fn untouched(&self, photo: &Photo) -> FilledPhoto {
        let stack = self.state(photo).1.stack().expect("what is up to date has a stack").clone();
        let spread = stack.fill.as_ref().map(|fill| fill.spread.clone()).unwrap_or_default();
        let (photo, kept) = (photo.name.clone(), Vec::new());
        FilledPhoto { photo, stack: Ok(stack), up_to_date: true, spread, kept }
    }

    /// Only a request to stop is an error here.
    fn photo(&self, photo: &Photo, ground: &Ground, plates: &mut Plates, task: &Task) -> Result<FilledPhoto> {
        let filled = self.try_photo(photo, ground, plates, task);
        let failed = |error| FilledPhoto {
            photo: photo.name.clone(),
            stack: Err(self.store.at_home(&photo.name, error)),
            up_to_date: false,
            spread: Vec::new(),
            kept: Vec::new(),
        };
        match filled {
            Err(Error::Cancelled) => Err(Error::Cancelled),
            filled => Ok(filled.unwrap_or_else(failed)),
        }
    }

    fn try_photo(
        &self,
        photo: &Photo,
        ground: &Ground,
        plates: &mut Plates,
        task: &Task,
    ) -> Result<FilledPhoto> {
        task.go_on()?;
        let (id, state) = self.state(photo);
        let stack = current(photo, state)?;
        let folder = self.store.folder(&photo.name);
        let own = task.timed("read photo", || ground.source.donor(id))?;
        let own = own.ok_or_else(|| Error::Request("the photo cannot be read".into()))?;
        let (model, surfaces, options) = (&self.opened.site.model, ground.surfaces, &self.request.options);
        let painters = self.painters(ground, id);
        let painted = painters.iter().flat_map(|painter| self.paint.surfaces_of(*painter)).collect();
        let hidden = task
            .timed("hidden", || hidden_regions(stack, &folder, &own, model, surfaces, options, &painted))?;
        let laid = spread_paint(ground, id, hidden.shown, &painters, task)?;
        let spread = self.told(ground, &laid.offers);
        let done = |stack: Stack, kept| FilledPhoto {
            photo: photo.name.clone(),
            stack: Ok(stack),
            up_to_date: false,
            spread: spread.clone(),
            kept,
        };
        if self.purpose == Purpose::Tell {
            return Ok(done(stack.clone(), Vec::new()));
        }
        let filled = fill_photo(ground, id, hidden.regions, plates, task)?;
        let names: Vec<&str> = ground.photos.iter().map(|photo| photo.name.as_str()).collect();
        let (writer, mut bare) = self.store.amend(stack)?;
        task.timed("write", || write_fill(writer.folder(), &mut bare, &filled, &laid, &own, &names))?;
        let fill = bare.fill.as_mut().expect("it was written in the line above");
        (fill.inputs, fill.texels_hidden) = (self.inputs.of_stack(stack), hidden.texels);
        fill.spread = spread.clone();
        bare.bytes += fill.bytes;
        let committed = task.timed("commit", || writer.commit(bare))?;
        Ok(done(committed.stack, committed.kept))
    }

    /// The other photos whose paint is laid over this one.
    fn painters(&self, ground: &Ground, own: PhotoId) -> Vec<PhotoId> {
        let mut painters: Vec<PhotoId> = ground.painters.iter().flatten().copied().collect();
        painters.sort_unstable();
        painters.dedup();
        let name = |photo: PhotoId| &self.opened.site.photos[photo.0 as usize].name;
        painters.retain(|photo| *photo != own && self.request.options.propagates(name(*photo)));
        painters
    }

    /// Offers in the document's words; the triangles of a face are one.
    fn told(&self, ground: &Ground, offers: &[Offer]) -> Vec<SpreadPaint> {
        let mut by_face: BTreeMap<(String, &str), Offer> = BTreeMap::new();
        for offer in offers {
            let face = self.opened.site.model.face_name(ground.surfaces.get(offer.surface).face);
            let from = ground.photos[offer.from.0 as usize].name.as_str();
            let sum = by_face.entry((face, from)).or_insert(Offer {
                texels: 0,
                own: 0,
                conflicts: 0,
                dissents: 0,
                ..*offer
            });
            sum.texels += offer.texels;
            sum.own += offer.own;
            sum.conflicts += offer.conflicts;
            sum.dissents += offer.dissents;
        }
        let told = |((face, from), offer): ((String, &str), Offer)| {
            let Offer { texels, own, conflicts, dissents, .. } = offer;
            SpreadPaint { face, from: from.to_owned(), texels, own, conflicts, dissents }
        };
        by_face.into_iter().map(told).collect()
    }
}

fn current<'a>(photo: &Photo, state: &'a StackState) -> Result<&'a Stack> {
    match state {
        StackState::Current(stack) => Ok(stack),
        StackState::Stale(_) => {
            Err(Error::Request("its stack is out of date; run `quadratura build`, then fill again".into()))
        }
        StackState::Missing => {
            Err(Error::Request(format!("{} has no stack yet; `quadratura build` builds it", photo.name)))
        }
        StackState::Broken(error) => Err(Error::Request(error.to_string())),
    }
}
