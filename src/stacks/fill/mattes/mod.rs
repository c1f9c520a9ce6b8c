//! The mattes of a site's photos: how much of what they show at a see-through surface is that surface. Derived from photos,
//! cameras, model and decisions, and cached in `cache/mattes/`.

mod behind;
mod pieces;
mod search;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use self::pieces::SeeThroughPiece;
use self::search::{FoundMattes, Search};
use super::donors::{PhotoDonors, donors_at_once, given_by_pin};
use super::paint::SitePaint;
use super::surroundings::SurroundingsFiller;
use crate::agreement::{AgreementInputs, SiteAgreement};
use crate::gains::{self, photo_gains};
use crate::relief::SiteRelief;
use crate::sources::sources;
use crate::surroundings::SiteSurroundings;
use quadratura_base::error::{Error, Message, Remedy, Result};
use quadratura_base::scene::{PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::names::file_name_of_photo;
use quadratura_document::paint::PaintBook;
use quadratura_document::{Project, Stack};
use quadratura_files::cached::{CachedKind, read_cached, write_cached};
use quadratura_files::hash::hash_bytes;
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::StackStore;
use quadratura_layers::agreement::PhotoEvidence;
use quadratura_layers::fill::{FillContext, FillOptions, FillSurfaces, MOST_DONORS};
use quadratura_layers::matte::Matte;
use quadratura_projection::relief::Relief;
use quadratura_projection::{Gains, Sources};
use quadratura_sites::shared::{Shared, while_read};

/// A counter of changes in how the same mattes are found.
const VERSION: u32 = 2;

/// The files `cache/mattes/PHOTO.bin`.
const CACHED: CachedKind = CachedKind { name: "mattes", version: 3 };

/// What mattes are found from.
pub struct MatteBasis<'a> {
    /// The project's folder.
    pub folder: &'a Path,
    /// The contents of `project.json`.
    pub project: &'a Project,
    /// The project's photos and model.
    pub site: &'a Site,
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

/// Returns the mattes of the project in `folder`, found anew if they are not up to date, or in any case with `force`. `memory`
/// is the budget in bytes for decoded photos.
///
/// # Errors
/// [`Error::Missing`] when no photo has a stack, and the errors of [`SiteMattes::open`] and of what it needs.
pub fn mattes(
    folder: &Path,
    project: &Project,
    site: &Site,
    force: bool,
    memory: u64,
    task: &Task,
) -> Result<SiteMattes> {
    while_read(folder, task, || found_or_cached(folder, project, site, force, memory, task))
}

fn found_or_cached(
    folder: &Path,
    project: &Project,
    site: &Site,
    force: bool,
    memory: u64,
    task: &Task,
) -> Result<SiteMattes> {
    let states = super::stacks::states(project, site, &StackStore::new(folder))?;
    let stacks: Vec<Option<Stack>> = states.iter().map(|state| state.stack().cloned()).collect();
    if stacks.iter().all(Option::is_none) {
        return Err(Error::missing(("no photo has a stack yet; ", Remedy::Build, " builds them")));
    }
    let gains = photo_gains(site, &stacks, &project.colour, folder, memory, task)?;
    let relief = SiteRelief::open(site, gains::photo_inputs(site, &stacks), folder, memory, task)?;
    let inputs = AgreementInputs::new(project, site, &stacks, memory);
    let agreement = SiteAgreement::open(folder, site, inputs, &gains, relief.whole(), task)?;
    let surroundings = SiteSurroundings::open(folder, project, site, &stacks, &gains, memory, task)?;
    let basis = MatteBasis {
        folder,
        project,
        site,
        stacks: &stacks,
        sources: &sources(site, &stacks, &project.decisions),
        gains: &gains,
        relief: relief.whole(),
        agreement: agreement.whole(),
        surroundings: &surroundings,
        memory,
    };
    SiteMattes::open(&basis, force, task)
}

/// The mattes of a site's photos.
#[derive(Debug, Clone, Default)]
pub struct SiteMattes {
    of_photo: Vec<Arc<[Matte]>>,
    /// Whether they were found anew.
    is_anew: bool,
    /// The photos whose mattes could not be found.
    failed: BTreeSet<PhotoId>,
    /// The object of each piece, by the piece's name.
    objects: BTreeMap<String, String>,
}

impl SiteMattes {
    /// Returns the mattes of all photos: those in the cache if all were made from the same inputs, otherwise anew, and then
    /// they are cached. With `force` they are made anew in any case.
    ///
    /// # Errors
    /// [`Error::Cancelled`]; [`Error::Request`] for too many see-through faces. A photo that fails is noted and has no mattes; a cache that cannot be written is noted.
    pub fn open(basis: &MatteBasis, force: bool, task: &Task) -> Result<Self> {
        let site = basis.site;
        let surfaces = FillSurfaces::from_model(&site.model);
        let pieces = SeeThroughPiece::of_model(&site.model, &surfaces, &site.photos);
        let photos: Vec<PhotoId> = site.photo_ids().filter(|id| basis.stacks[id.index()].is_some()).collect();
        let mut of_photo = vec![Arc::default(); site.photos.len()];
        if pieces.len() >= usize::from(u16::MAX) {
            return Err(Error::Request(format!(
                "{} faces and triangles are declared see-through, of which mattes can tell 65,534 apart; declare objects that \
                 one does not see through solid (`quadratura decide --no-see-through`)",
                pieces.len()
            )));
        }
        if pieces.is_empty() {
            return Ok(Self { of_photo, ..Self::default() });
        }
        let object =
            |piece: &SeeThroughPiece| (piece.name.clone(), site.model.object(piece.object).name.clone());
        let objects = pieces.iter().map(object).collect();
        let inputs = inputs(basis, &pieces);
        let cached = |id: &PhotoId| Some((*id, read_cached(&file_of(basis, *id), CACHED, &inputs)?));
        let cached = || -> Option<Vec<(PhotoId, Vec<Matte>)>> {
            if force { None } else { photos.iter().map(cached).collect() }
        };
        let cached = Shared::find(basis.folder, cached, task)?;
        let is_anew = matches!(cached, Shared::Missing(_));
        let FoundMattes { of_photo: found, failed } = match cached {
            Shared::Known(of_photo) => FoundMattes { of_photo, failed: BTreeSet::new() },
            Shared::Missing(_lock) => make(basis, &photos, &pieces, &surfaces, &inputs, task)?,
        };
        found.into_iter().for_each(|(id, mattes)| of_photo[id.index()] = mattes.into());
        Ok(Self { of_photo, is_anew, failed, objects })
    }

    /// Returns the mattes of a photo, by piece.
    pub fn of(&self, photo: PhotoId) -> &Arc<[Matte]> {
        &self.of_photo[photo.index()]
    }

    /// Returns the mattes of a photo that are of an object, by its name.
    pub fn of_object<'a>(&'a self, photo: PhotoId, object: &'a str) -> impl Iterator<Item = &'a Matte> {
        let is_meant = move |matte: &&Matte| self.objects.get(&matte.object).is_some_and(|it| it == object);
        self.of(photo).iter().filter(is_meant)
    }

    /// Returns the names of the objects that have mattes, in the order of their names.
    pub fn objects(&self) -> BTreeSet<&str> {
        self.objects.values().map(String::as_str).collect()
    }

    /// Returns the mattes of all photos.
    pub fn all(&self) -> impl Iterator<Item = (PhotoId, &[Matte])> {
        PhotoId::all(self.of_photo.len()).zip(self.of_photo.iter().map(|of_photo| &of_photo[..]))
    }

    /// Returns the photos whose mattes could not be found.
    pub fn failed(&self) -> &BTreeSet<PhotoId> {
        &self.failed
    }

    /// Returns whether the mattes were found anew.
    pub fn is_anew(&self) -> bool {
        self.is_anew
    }
}

/// Finds the mattes of these photos and caches them. Returns also the photos that failed.
fn make(
    basis: &MatteBasis,
    photos: &[PhotoId],
    pieces: &[SeeThroughPiece],
    surfaces: &FillSurfaces,
    inputs: &str,
    task: &Task,
) -> Result<FoundMattes> {
    let site = basis.site;
    // Mattes are those of the photos: paint neither hides what they show nor gives colours.
    let (book, options) = (PaintBook::default(), FillOptions::default());
    let store = PaintStore::new(basis.folder);
    let paint = SitePaint::new(&options, &book, &store, basis.stacks, &site.model, surfaces);
    let donors = PhotoDonors::new(basis.project, basis.site, surfaces, &paint, basis.memory, task)
        .without_contradicted(basis.agreement);
    let context = FillContext {
        photos: &basis.sources.photos,
        surfaces,
        serving: &super::servers::serving(basis.sources),
        painters: &vec![Vec::new(); site.model.faces.len()],
        relief: basis.relief,
        gains: basis.gains,
        options: &options,
        source: &donors,
    };
    let around = SurroundingsFiller::new(basis.surroundings, basis.gains, basis.memory);
    let found =
        Search { basis, context: &context, pieces, around, failed: BTreeSet::new(), task }.mattes(photos)?;
    for (id, mattes) in &found.of_photo {
        if let Err(error) = write_cached(&file_of(basis, *id), CACHED, inputs, mattes) {
            task.note(Message::from("mattes cannot be cached and will be found again: ").and(&error));
            break;
        }
    }
    Ok(found)
}

fn file_of(basis: &MatteBasis, photo: PhotoId) -> PathBuf {
    let name = file_name_of_photo(&basis.site.photo(photo).name);
    basis.folder.join("cache/mattes").join(format!("{name}.bin"))
}

/// Returns the hash of everything that mattes are made from.
fn inputs(basis: &MatteBasis, pieces: &[SeeThroughPiece]) -> String {
    let (project, site) = (basis.project, basis.site);
    let serving = super::servers::serving(basis.sources);
    let all = (
        (VERSION, donors_at_once(site, basis.memory).min(MOST_DONORS), project.options.tolerance),
        gains::inputs(site, basis.stacks),
        gains::decisions(&project.colour),
        (&basis.gains.of_photo, &basis.gains.optics),
        serving.iter().map(|photos| photos.iter().map(|id| id.0).collect::<Vec<_>>()).collect::<Vec<_>>(),
        basis.surroundings.stamp(),
        pieces.iter().map(|piece| &piece.name).collect::<Vec<_>>(),
    );
    let mut text = serde_json::to_vec(&all).expect("plain data is JSON");
    for (photo, evidence) in site.photo_ids().zip(basis.agreement) {
        let pinned = given_by_pin(project, site, photo, &evidence.agreement);
        pinned.iter().for_each(|face| text.extend([photo.0, face.0].map(u32::to_le_bytes).as_flattened()));
    }
    hash_bytes(&text)
}
