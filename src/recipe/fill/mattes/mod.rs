//! The mattes of a site's photos: how much of what they show at an impostor is the impostor. Derived from photos,
//! cameras, model and decisions, and cached in `cache/mattes/`.

mod behind;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use self::behind::evidence;
use super::donors::PhotoDonors;
use super::paint::SitePaint;
use super::surroundings::SurroundingsFiller;
use crate::document::Stack;
use crate::document::paint::PaintBook;
use crate::error::{Error, Message, Remedy, Result};
use crate::io::hash::hash_bytes;
use crate::io::matte_file::{matte_file, read_mattes, write_mattes};
use crate::io::paint_store::PaintStore;
use crate::io::stack_store::StackStore;
use crate::layers::agreement::PhotoEvidence;
use crate::layers::fill::{FillContext, FillOptions, MOST_DONORS, Surfaces};
use crate::layers::matte::{FindOptions, Matte, find_mattes};
use crate::projection::relief::Relief;
use crate::projection::{Gains, Sources};
use crate::recipe::agreement::SiteAgreement;
use crate::recipe::gains::{self, photo_gains};
use crate::recipe::open::Opened;
use crate::recipe::relief::SiteRelief;
use crate::recipe::sources::sources;
use crate::recipe::surroundings::SiteSurroundings;
use crate::recipe::survey::StackState;
use crate::scene::PhotoId;
use crate::task::Task;

/// A counter of changes in how the same mattes are found.
const VERSION: u32 = 1;

/// What mattes are found from.
pub struct MatteBasis<'a> {
    /// The project's folder.
    pub folder: &'a Path,
    /// The project and its site.
    pub opened: &'a Opened,
    /// The stacks, in the site's order; `None` for photos without one, which get no mattes.
    pub stacks: &'a [Option<Stack>],
    /// Which photos serve which faces.
    pub sources: &'a Sources,
    /// The exposures of the photos.
    pub gains: &'a Gains,
    /// The heights of the true surfaces over the model's.
    pub relief: &'a Relief,
    /// How far other photos confirm each photo, in the site's order.
    pub agreement: &'a [PhotoEvidence],
    /// What is around the model.
    pub surroundings: &'a SiteSurroundings,
    /// The budget in bytes for decoded photos.
    pub memory: u64,
}

/// A request to [`mattes`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MatteRequest {
    /// The photos whose mattes are found anew; empty for all.
    pub photos: Vec<PhotoId>,
    /// Whether mattes that are up to date are found anew, too.
    pub force: bool,
    /// The budget in bytes for decoded photos.
    pub memory: u64,
}

/// Returns the mattes of the project in `folder`, found where they are not up to date.
///
/// # Errors
/// [`Error::Missing`] when no photo has a stack, and the errors of [`SiteMattes::open`] and of what it needs.
pub fn mattes(folder: &Path, opened: &Opened, request: &MatteRequest, task: &Task) -> Result<SiteMattes> {
    let site = &opened.site;
    let states = super::states(opened, &StackStore::new(folder))?;
    let current = |state: &StackState| match state {
        StackState::Current(stack) => Some(stack.clone()),
        _ => None,
    };
    let stacks: Vec<Option<Stack>> = states.iter().map(current).collect();
    if stacks.iter().all(Option::is_none) {
        return Err(Error::missing(("no photo has an up-to-date stack; ", Remedy::Build, " builds them")));
    }
    let memory = request.memory;
    let gains = photo_gains(site, &stacks, &opened.project.colour, folder, memory, task)?;
    let relief = SiteRelief::open(site, &gains::inputs(site, &stacks), folder, memory, task)?;
    let agreement = SiteAgreement::open(folder, opened, &stacks, &gains, relief.whole(), memory, task)?;
    let surroundings = SiteSurroundings::open(folder, opened, &stacks, &gains, memory, task)?;
    let basis = MatteBasis {
        folder,
        opened,
        stacks: &stacks,
        sources: &sources(site, &stacks, &opened.project.decisions),
        gains: &gains,
        relief: relief.whole(),
        agreement: agreement.whole(),
        surroundings: &surroundings,
        memory,
    };
    SiteMattes::open(&basis, &request.photos, request.force, task)
}

/// The mattes of a site's photos.
#[derive(Debug, Clone, Default)]
pub struct SiteMattes {
    of_photo: Vec<Arc<[Matte]>>,
    /// What was made anew, by photo.
    anew: Vec<bool>,
}

impl SiteMattes {
    /// Returns the mattes of all photos: those in the cache that were made from the same inputs, and the others anew,
    /// which are then cached. With `force` those of `photos` are made anew in any case; without `photos` of all.
    ///
    /// # Errors
    /// [`Error::Cancelled`]. A photo that fails is noted and has no mattes; a cache that cannot be written is noted.
    pub fn open(basis: &MatteBasis, photos: &[PhotoId], force: bool, task: &Task) -> Result<Self> {
        let site = &basis.opened.site;
        let count = site.photos.len();
        let mut found = Self { of_photo: vec![Arc::default(); count], anew: vec![false; count] };
        if !site.model.has_impostors() {
            return Ok(found);
        }
        let inputs = inputs(basis);
        let is_chosen = |id: &PhotoId| photos.is_empty() || photos.contains(id);
        let mut missing = Vec::new();
        for id in site.photo_ids().filter(|id| basis.stacks[id.index()].is_some()) {
            let file = file_of(basis, id);
            match read_mattes(&file, &inputs).filter(|_| !(force && is_chosen(&id))) {
                Some(mattes) => found.of_photo[id.index()] = mattes.into(),
                None => missing.push(id),
            }
        }
        if !missing.is_empty() {
            found.make(basis, &missing, &inputs, task)?;
        }
        Ok(found)
    }

    /// Returns the mattes of a photo, by object.
    pub fn of(&self, photo: PhotoId) -> &Arc<[Matte]> {
        &self.of_photo[photo.index()]
    }

    /// Returns the mattes of all photos.
    pub fn all(&self) -> impl Iterator<Item = (PhotoId, &[Matte])> {
        PhotoId::all(self.of_photo.len()).zip(self.of_photo.iter().map(|of_photo| &of_photo[..]))
    }

    /// Returns whether a photo's mattes were made anew.
    pub fn is_anew(&self, photo: PhotoId) -> bool {
        self.anew[photo.index()]
    }

    fn make(&mut self, basis: &MatteBasis, photos: &[PhotoId], inputs: &str, task: &Task) -> Result<()> {
        let site = &basis.opened.site;
        let surfaces = Surfaces::from_model(&site.model);
        // Mattes are those of the photos: paint neither hides what they show nor gives colours.
        let (book, options) = (PaintBook::default(), FillOptions::default());
        let store = PaintStore::new(basis.folder);
        let paint = SitePaint::new(&options, &book, &store, basis.stacks, &site.model, &surfaces);
        let donors = PhotoDonors::new(basis.opened, &surfaces, &paint, basis.memory, task)
            .without_contradicted(basis.agreement);
        let context = FillContext {
            photos: &basis.sources.photos,
            surfaces: &surfaces,
            serving: &super::serving(basis.sources),
            painters: &vec![Vec::new(); site.model.faces.len()],
            relief: basis.relief,
            gains: basis.gains,
            options: &options,
            source: &donors,
        };
        let mut around = SurroundingsFiller::new(basis.surroundings, basis.gains, basis.memory);
        for (done, &id) in (0..).zip(photos) {
            task.step("mattes", done, photos.len() as u64)?;
            let own = task.with_subject(&site.photo(id).name);
            match of_photo(basis, &context, id, &mut around, &own) {
                Ok(mattes) => {
                    if let Err(error) = write_mattes(&file_of(basis, id), &mattes, inputs) {
                        own.note(Message::from("its mattes cannot be cached: ").and(&error));
                    }
                    self.of_photo[id.index()] = mattes.into();
                    self.anew[id.index()] = true;
                }
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                Err(error) => own.note(Message::from("its mattes cannot be found: ").and(&error)),
            }
        }
        task.step("mattes", photos.len() as u64, photos.len() as u64)
    }
}

/// Finds the mattes of a photo.
fn of_photo(
    basis: &MatteBasis,
    context: &FillContext,
    photo: PhotoId,
    around: &mut SurroundingsFiller,
    task: &Task,
) -> Result<Vec<Matte>> {
    let own = context.source.own(photo)?;
    let own = own.ok_or_else(|| Error::Request("the photo cannot be read".into()))?;
    let Some((objects, evidence)) = evidence(basis, context, photo, &own, around, task)? else {
        return Ok(Vec::new());
    };
    let model = &basis.opened.site.model;
    let names: Vec<&str> = objects.iter().map(|object| &model.object(*object).name[..]).collect();
    task.timed("matte", || find_mattes(&evidence, &names, &FindOptions::default(), task))
}

fn file_of(basis: &MatteBasis, photo: PhotoId) -> PathBuf {
    matte_file(basis.folder, &basis.opened.site.photo(photo).name)
}

/// Returns the hash of everything that mattes are made from.
fn inputs(basis: &MatteBasis) -> String {
    let Opened { project, site, .. } = basis.opened;
    let serving = super::serving(basis.sources);
    let all = (
        (VERSION, MOST_DONORS, project.options.tolerance),
        gains::inputs(site, basis.stacks),
        gains::decisions(&project.colour),
        (&basis.gains.of_photo, &basis.gains.optics),
        serving.iter().map(|photos| photos.iter().map(|id| id.0).collect::<Vec<_>>()).collect::<Vec<_>>(),
        basis.surroundings.stamp(),
    );
    hash_bytes(&serde_json::to_vec(&all).expect("plain data is JSON"))
}
