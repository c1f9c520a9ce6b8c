//! The command `fill`: fills the hidden texels of the photos' image layers.

pub mod both_ways;
mod donors;
mod hidden;
pub(crate) mod inputs;
mod kept;
pub mod mattes;
mod named;
mod paint;
mod parts;
pub mod projected;
pub mod propagation;
mod report;
mod request;
mod see_through;
pub mod seen;
mod servers;
pub mod shares;
mod stacks;
mod surroundings;
mod unknown;
pub mod viewpoints;
pub mod worst;
mod write;

use std::path::Path;

use self::donors::{PLATES_SHARE, PhotoDonors};
use self::hidden::hidden_regions;
use self::kept::FillReuse;
use self::mattes::{MatteBasis, SiteMattes};
use self::paint::SitePaint;
use self::parts::FillParts;
use self::propagation::propagation_entries;
use self::see_through::{SeeThroughFilling, SurfaceMattes};
use self::servers::{keeps_pixels, serving};
use self::stacks::{current, states, without_former};
use self::surroundings::SurroundingsFiller;
use self::write::write_fill;
use crate::agreement::{AgreementInputs, SiteAgreement};
use crate::gains::{self, photo_gains};
use crate::relief::SiteRelief;
use crate::sources::sources;
use crate::surroundings::SiteSurroundings;
use crate::survey::StackState;
use crate::turns::{FillCheck, Turns};
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::scene::{Photo, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::{Project, Stack};
use quadratura_io::failures::{forget_failure, note_failure};
use quadratura_io::paint_store::PaintStore;
use quadratura_io::photo_lock::WorkLock;
use quadratura_io::stack_store::StackStore;
use quadratura_layers::fill::see_through::MattePixels;
use quadratura_layers::fill::{
    Donors, FillContext, FillSurfaceId, FillSurfaces, FilledRegion, KeptTexels, RectifiedTextures, Region,
    fill_photo, photos_asked, propagate_paint,
};
use quadratura_sites::named::photos_named;
use quadratura_sites::shared::while_read;

pub use inputs::{FillInputs, FillState, photos_to_fill, stale_among, stale_fillings};
pub use named::check_options;
pub use report::FillShares;
pub use request::{FillRequest, FilledPhoto};
pub use unknown::unknown_matte_pixels;

/// Ends the hash of the inputs of a filling without mattes that could not be found: it equals no hash.
const WITHOUT_MATTES: &str = " without mattes";

/// The purpose for which a filling is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FillPurpose {
    /// Fill the stacks and write them.
    Fill,
    /// Report propagated paint only; nothing is filled, and no stack is written.
    Report,
}

/// Fills the hidden texels of the photos' current stacks, photo by photo. An error in one photo is in its
/// [`FilledPhoto`] and does not stop the others. Results are in the site's order.
///
/// # Errors
/// Returns [`Error::Request`] for a photo name that the site does not have, for an object to leave unfilled that
/// the model does not have, and when no photo has a stack; an error when the paint book cannot be read; or
/// [`Error::Cancelled`].
pub fn fill(
    folder: &Path,
    project: &Project,
    site: &Site,
    request: &FillRequest,
    task: &Task,
) -> Result<Vec<FilledPhoto>> {
    let work = || fill_or_report(folder, project, site, request, FillPurpose::Fill, None, task);
    while_read(folder, task, || without_former(folder, request, work()?))
}

/// [`fill`] within an update: in the order of the request, with a turn for each photo that is filled. No filling is
/// committed that has become obsolete. Where the project changes, this ends early, with the results so far.
///
/// # Errors
/// As [`fill`].
pub(super) fn fill_in_turns(
    folder: &Path,
    project: &Project,
    site: &Site,
    request: &FillRequest,
    turns: &Turns,
    task: &Task,
) -> Result<Vec<FilledPhoto>> {
    let work = || fill_or_report(folder, project, site, request, FillPurpose::Fill, Some(turns), task);
    while_read(folder, task, || without_former(folder, request, work()?))
}

/// Returns the paint that [`fill`] would propagate to each photo, whether the filling is up to date or not. The
/// stacks are not modified.
///
/// # Errors
/// Returns the errors of [`fill`].
pub fn tell(
    folder: &Path,
    project: &Project,
    site: &Site,
    request: &FillRequest,
    task: &Task,
) -> Result<Vec<FilledPhoto>> {
    while_read(folder, task, || {
        fill_or_report(folder, project, site, request, FillPurpose::Report, None, task)
    })
}

/// Fills the photos or reports their propagated paint.
fn fill_or_report(
    folder: &Path,
    project: &Project,
    site: &Site,
    request: &FillRequest,
    purpose: FillPurpose,
    turns: Option<&Turns>,
    task: &Task,
) -> Result<Vec<FilledPhoto>> {
    check_options(project, site, &request.options)?;
    let mut photos = photos_named(site, &request.photos)?;
    if turns.is_some() {
        photos.sort_by_key(|photo| request.photos.iter().position(|name| *name == photo.name));
    }
    let store = StackStore::new(folder).keeping_former();
    let states = task.timed("read stacks", || states(project, site, &store))?;
    let stacks: Vec<Option<Stack>> = states.iter().map(|state| state.stack().cloned()).collect();
    if stacks.iter().all(Option::is_none) {
        return Err(Error::missing(("no photo has a stack yet; ", Remedy::Build, " builds them")));
    }
    let inputs = FillInputs::new(folder, project, site, &stacks, &request.options)?;
    let surfaces = FillSurfaces::from_model(&site.model);
    let options = &request.options;
    let paint =
        SitePaint::new(options, inputs.book(), &PaintStore::new(folder), &stacks, &site.model, &surfaces);
    let store = &store;
    let states = &states[..];
    let inputs = &inputs;
    let paint = &paint;
    let donors = PhotoDonors::new(project, site, &surfaces, paint, request.memory, task);
    let common = inputs.without_paint(donors.at_once());
    let reuse = FillReuse::new(project, site, &surfaces, paint, common, inputs.paint_around());
    let job = FillJob { store, project, site, request, purpose, states, inputs, paint, turns, reuse };
    let waiting: Vec<bool> = photos.iter().map(|photo| job.up_to_date(photo)).collect::<Result<_>>()?;
    if waiting.iter().all(|up_to_date| *up_to_date) {
        return Ok(photos.iter().map(|photo| job.untouched(photo)).collect());
    }
    let (memory, colour) = (request.memory, &project.colour);
    let gains = task.timed("gains", || photo_gains(site, &stacks, colour, folder, memory, task))?;
    let relief = task.timed("relief", || {
        SiteRelief::open(site, gains::photo_inputs(site, &stacks), folder, memory, task)
    })?;
    let compare = || {
        let inputs = AgreementInputs::new(project, site, &stacks, memory);
        SiteAgreement::open(folder, site, inputs, &gains, relief.whole(), task)
    };
    let agreement = task.timed("agreement", compare)?;
    let donors = donors.without_contradicted(agreement.whole());
    let sources = sources(site, &stacks, &project.decisions);
    let context = FillContext {
        photos: &sources.photos,
        surfaces: &surfaces,
        serving: &serving(&sources),
        painters: &paint.painters(&site.model),
        relief: relief.whole(),
        gains: &gains,
        options: &request.options,
        source: &donors,
    };
    let around = task.timed("surroundings", || {
        SiteSurroundings::open(folder, project, site, &stacks, &gains, memory, task)
    })?;
    let basis = MatteBasis {
        folder,
        project,
        site,
        stacks: &stacks,
        sources: &sources,
        gains: &gains,
        relief: relief.whole(),
        agreement: agreement.whole(),
        surroundings: &around,
        memory,
    };
    let found = match request.options.no_mattes {
        true => SiteMattes::default(),
        false => task.timed("mattes", || SiteMattes::open(&basis, false, task))?,
    };
    let mattes = SurfaceMattes::new(&found, &site.model, &surfaces);
    let (evidence, stamp) = (agreement.whole(), around.stamp());
    let parts = FillParts::new((project, site), inputs, &stacks, &context, evidence, &mattes, stamp);
    let mut around = SurroundingsFiller::new(&around, &gains, memory);
    let mut plates = RectifiedTextures::new(memory / PLATES_SHARE);
    let mut filled = Vec::with_capacity(photos.len());
    for ((done, photo), up_to_date) in (0..).zip(&photos).zip(waiting) {
        task.step("fill", done, photos.len() as u64)?;
        if up_to_date {
            filled.push(job.untouched(photo));
            continue;
        }
        let turn = turns.map(|turns| turns.begin(|other| job.is_as_before(other), task)).transpose()?;
        if matches!(turn, Some(None)) {
            return Ok(filled);
        }
        let mut means =
            FillMeans { plates: &mut plates, around: &mut around, mattes: &mattes, parts: &parts };
        filled.push(job.photo(photo, &context, &mut means, &task.with_subject(&photo.name))?);
    }
    task.step("fill", photos.len() as u64, photos.len() as u64)?;
    Ok(filled)
}

/// What the filling of all photos uses, and extends.
struct FillMeans<'a, 'b> {
    plates: &'a mut RectifiedTextures,
    around: &'a mut SurroundingsFiller<'b>,
    mattes: &'a SurfaceMattes<'b>,
    parts: &'a FillParts<'b>,
}

/// The inputs that all photos of a filling share.
struct FillJob<'a> {
    store: &'a StackStore,
    project: &'a Project,
    site: &'a Site,
    request: &'a FillRequest,
    purpose: FillPurpose,
    states: &'a [StackState],
    inputs: &'a FillInputs,
    paint: &'a SitePaint<'a>,
    /// The turns of the update that this belongs to.
    turns: Option<&'a Turns<'a>>,
    reuse: FillReuse<'a>,
}

impl FillJob<'_> {
    /// Returns the id and the stack's state of a photo.
    fn state(&self, photo: &Photo) -> (PhotoId, &StackState) {
        let id = self.site.photo_named(&photo.name).expect("the photo is one of the site's");
        (id, &self.states[id.index()])
    }

    /// Returns true when a photo's filling need not be made again.
    fn up_to_date(&self, photo: &Photo) -> Result<bool> {
        let StackState::Current(stack) = self.state(photo).1 else { return Ok(false) };
        let again = self.request.force || self.purpose == FillPurpose::Report;
        Ok(!again && self.is_filled(photo, stack)?)
    }

    /// Returns whether a stack has the filling that it would get now.
    fn is_filled(&self, photo: &Photo, stack: &Stack) -> Result<bool> {
        let current = FillState::new(stack, self.inputs) == FillState::Current;
        Ok(current && self.store.up_to_date(&photo.name, &stack.inputs)?.is_some())
    }

    /// Returns the result for a photo whose filling is up to date.
    fn untouched(&self, photo: &Photo) -> FilledPhoto {
        FilledPhoto::untouched(
            photo,
            self.state(photo).1.stack().expect("what is up to date has a stack").clone(),
        )
    }

    /// Fills one photo and moves any error but cancellation into the result.
    fn photo(
        &self,
        photo: &Photo,
        context: &FillContext,
        means: &mut FillMeans,
        task: &Task,
    ) -> Result<FilledPhoto> {
        let own = self.turns.map_or_else(|| task.clone(), |turns| turns.task_of(&photo.name, task));
        let filled = self.try_photo(photo, context, means, &own);
        let failed = |error| FilledPhoto {
            photo: photo.name.clone(),
            stack: Err(self.store.with_final_path(&photo.name, error)),
            up_to_date: false,
            propagated: Vec::new(),
            anew: 0,
            kept: Vec::new(),
            is_behind: false,
            laid: Vec::new(),
        };
        match filled {
            // A photo that is stopped alone is a result like others.
            Err(Error::Cancelled) if self.turns.is_none() || task.check_cancelled().is_err() => {
                Err(Error::Cancelled)
            }
            filled => {
                let filled = filled.unwrap_or_else(failed);
                if let Some(error) = filled.stack.as_ref().err().filter(|_| self.purpose == FillPurpose::Fill)
                {
                    note_failure(self.store.project(), &photo.name, error);
                }
                Ok(filled)
            }
        }
    }

    /// Fills one photo.
    fn try_photo(
        &self,
        photo: &Photo,
        context: &FillContext,
        means: &mut FillMeans,
        task: &Task,
    ) -> Result<FilledPhoto> {
        task.check_cancelled()?;
        let (id, state) = self.state(photo);
        let before = current(photo, state)?;
        let lock =
            (self.purpose == FillPurpose::Fill).then(|| self.store.lock(&photo.name, task)).transpose()?;
        let (lock, mut cleaned) = lock.map_or((None, Vec::new()), |(lock, kept)| (Some(lock), kept));
        let stack = &match lock {
            // Another program may have made it again, or filled it, while this one waited for the lock.
            Some(_) => self.made_meanwhile(photo, before)?,
            None => before.clone(),
        };
        if stack.fill != before.fill && !self.request.force && self.is_filled(photo, stack)? {
            return Ok(FilledPhoto { kept: cleaned, ..FilledPhoto::untouched(photo, stack.clone()) });
        }
        if let Some(confirmed) = self.confirmed(photo, stack, means.parts, lock.as_ref(), task)? {
            return Ok(FilledPhoto { kept: cleaned, ..confirmed });
        }
        let folder = self.store.folder(&photo.name);
        let own = task.timed("read photo", || context.source.own(id))?;
        let own = own.ok_or_else(|| Error::Request("the photo cannot be read".into()))?;
        let model = &self.site.model;
        let surfaces = context.surfaces;
        let options = &self.request.options;
        let painters = self.painters(context, id);
        let painted = painters.iter().flat_map(|painter| self.paint.surfaces_of(*painter));
        let painted = painted
            .filter(|surface| !keeps_pixels(self.project, self.site, photo, surfaces.get(*surface).face))
            .collect();
        let mut hidden = task
            .timed("hidden", || hidden_regions(stack, &folder, &own, model, surfaces, options, &painted))?;
        let visible = std::mem::take(&mut hidden.visible_regions);
        let laid = propagate_paint(context, id, visible, &painters, task)?;
        let propagated = propagation_entries(self.site, context, &laid.offers);
        let done = |stack: Stack, anew, kept| FilledPhoto {
            photo: photo.name.clone(),
            stack: Ok(stack),
            up_to_date: false,
            propagated: propagated.clone(),
            anew,
            kept,
            is_behind: false,
            laid: Vec::new(),
        };
        if self.purpose == FillPurpose::Report {
            return Ok(FilledPhoto { laid: laid.regions, ..done(stack.clone(), 0, Vec::new()) });
        }
        let see_through = SeeThroughFilling::take(means.mattes, context, photo, id, &mut hidden)?;
        let mut kept = task.timed("keep", || self.kept(context, id, stack, &hidden.regions))?;
        let mut corrected = Vec::new();
        if let Some(see_through) = &see_through {
            corrected = see_through.corrected(hidden.regions.iter().chain(&hidden.surroundings));
            corrected.iter().for_each(|surface| drop(kept.remove(surface)));
        }
        let untouched = kept.values().map(|texels| texels.len() as u64).sum::<u64>();
        let basis = means.parts.basis(
            self.reuse.basis(stack),
            stack,
            photos_asked(context, id, &hidden.regions),
            &painters,
        );
        let mut filled = fill_photo(context, id, hidden.regions, kept, means.plates, task)?;
        let may_keep = !corrected.contains(&FillSurfaceId::SURROUNDINGS);
        let around = hidden.surroundings.map(|region| (region, may_keep));
        let fill_around = || self.surroundings(id, stack, own.bits, around, means.around, task);
        let (surroundings, kept_around) = task.timed("fill surroundings", fill_around)?;
        let untouched = untouched + kept_around;
        filled.surroundings = surroundings;
        let mut matte_pixels = MattePixels::default();
        if let Some(see_through) = see_through {
            let lay = || see_through.lay_over(means.mattes, context, &own, &mut filled);
            let (counts, message) = task.timed("lay mattes", lay)?;
            message.into_iter().for_each(|message| task.note(message));
            matte_pixels = counts;
        }
        let names: Vec<&str> = context.photos.iter().map(|photo| photo.name.as_str()).collect();
        let (writer, mut bare) = self.store.begin_from(stack)?;
        task.timed("write", || write_fill(writer.folder(), &mut bare, &filled, &laid, &own, &names))?;
        let fill = bare.fill.as_mut().expect("write_fill sets it");
        // What is seen through see-through surfaces is the photo's own, and not hidden.
        let seen_through = filled.own_texels(id);
        (fill.inputs, fill.texels_hidden) = (self.inputs.of_stack(stack), hidden.texels - seen_through);
        fill.texels_from_photos -= seen_through;
        (fill.matte_pixels, fill.matte_unknown) = (matte_pixels.shown, matte_pixels.unknown);
        if means.mattes.failed(id) {
            // The next filling looks for them again.
            fill.inputs.push_str(WITHOUT_MATTES);
        }
        fill.propagated = propagated.clone();
        fill.basis = Some(basis);
        bare.bytes += fill.bytes;
        let checked = self.turns.map(|turns| turns.check_filling(stack, self.inputs, task)).transpose()?;
        let is_behind = checked.as_ref().is_some_and(|(check, _)| *check == FillCheck::OtherPaint);
        // Where more than paint has changed since the filling before, most of this one can be kept, and continuous
        // painting does not hold it up. A stroke alone is computed again at once.
        if is_behind && self.reuse.differs_in_paint_alone(stack) {
            return Err(Error::Cancelled);
        }
        lock.iter().try_for_each(WorkLock::check)?;
        let committed = task.timed("commit", || writer.commit(bare))?;
        forget_failure(self.store.project(), &photo.name);
        self.turns.inspect(|turns| turns.committed(&photo.name));
        drop(checked);
        cleaned.extend(committed.kept);
        Ok(FilledPhoto { is_behind, ..done(committed.stack, filled.texels() - untouched, cleaned) })
    }

    /// Returns the stack of a photo as it is now, which has to be made from the inputs of the one `before`.
    fn made_meanwhile(&self, photo: &Photo, before: &Stack) -> Result<Stack> {
        let now = self.store.current(&photo.name)?.filter(|now| now.inputs == before.inputs);
        now.ok_or_else(|| match self.turns {
            // An update tries again.
            Some(_) => Error::Cancelled,
            None => {
                Error::missing(("its stack has changed meanwhile; run ", Remedy::Build, ", then fill again"))
            }
        })
    }

    /// Returns whether a photo's stack (index in the site) is made from the same inputs as when this filling began; fillings
    /// depend on nothing else of other stacks.
    fn is_as_before(&self, photo: usize) -> Result<bool> {
        let now = self.store.current(&self.site.photos[photo].name)?;
        let inputs = |stack: Option<&Stack>| stack.map(|stack| stack.inputs.clone());
        Ok(inputs(now.as_ref()) == inputs(self.states[photo].stack()))
    }

    /// Returns the filling of a region of a photo's surroundings, and how many of its texels were taken from the present
    /// one, if that may be: all or none.
    fn surroundings(
        &self,
        id: PhotoId,
        stack: &Stack,
        bits: u8,
        region: Option<(Region, bool)>,
        around: &mut SurroundingsFiller,
        task: &Task,
    ) -> Result<(Option<FilledRegion>, u64)> {
        let Some((region, may_keep)) = region else { return Ok((None, 0)) };
        let photo = &stack.photo.name;
        if may_keep && !self.request.force && self.store.up_to_date(photo, &stack.inputs)?.is_some() {
            let kept = self.reuse.kept_surroundings(stack, &self.store.folder(photo), &region)?;
            if let Some(texels) = kept {
                let count = texels.len() as u64;
                return Ok((Some(FilledRegion { region, texels }), count));
            }
        }
        Ok((around.fill(id, stack, bits, region, task)?, 0))
    }

    /// Returns the texels of a photo's present filling that need not be computed again. Nothing is kept of files that
    /// were changed by hand.
    fn kept(
        &self,
        context: &FillContext,
        id: PhotoId,
        stack: &Stack,
        regions: &[Region],
    ) -> Result<KeptTexels> {
        let photo = &stack.photo.name;
        if self.request.force || self.store.up_to_date(photo, &stack.inputs)?.is_none() {
            return Ok(KeptTexels::new());
        }
        self.reuse.kept(context, id, stack, &self.store.folder(photo), regions)
    }
}
