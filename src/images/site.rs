//! What the layered depth images of a project's photos have in common: stacks, paint, relief and gains.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::inputs::inputs;
use super::of_stack::{StackSource, ldi_of_stack};
use super::options::StackLdiOptions;
use super::place::cached_file;
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::scene::{PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::paint::PaintBook;
use quadratura_document::{Project, Stack};
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_readers::StackReader;
use quadratura_io::stack_store::StackStore;
use quadratura_ldi::Ldi;
use quadratura_ldi::file::{LdiHeader, has_whole_length, read_ldi, read_ldi_header, read_ldi_level};
use quadratura_projection::Gains;
use quadratura_projection::relief::Relief;
use quadratura_sites::budget::default_memory;
use quadratura_stacks::gains;
use quadratura_stacks::relief::SiteRelief;
use quadratura_stacks::surroundings::SiteSurroundings;
use quadratura_stacks::survey::{StackState, Survey};
use quadratura_view::agreement::{AgreementGrid, PhotoAgreement};

/// A project whose stacks become layered depth images.
pub struct LdiSite<'a> {
    folder: PathBuf,
    project: &'a Project,
    site: &'a Site,
    store: StackStore,
    /// The stacks in the site's order.
    stacks: Vec<Option<Arc<Stack>>>,
    /// The state of each photo's stack, with the reason where it cannot be used.
    states: Vec<Result<bool>>,
    book: PaintBook,
    relief: Option<Arc<Relief>>,
    gains: Option<Gains>,
    /// How far others confirm each photo's surroundings, in the site's order; empty where there are none.
    surroundings: Option<Arc<[PhotoAgreement]>>,
    /// The photos whose estimates were given, not made here: without which they were made.
    without: Vec<PhotoId>,
    /// Stacks that change meanwhile stay readable as they were.
    _reader: StackReader,
}

impl<'a> LdiSite<'a> {
    /// Reads the stacks of a project in `folder`.
    ///
    /// # Errors
    /// Returns the errors of reading the paint book, or [`Error::Cancelled`].
    pub fn open(folder: &Path, project: &'a Project, site: &'a Site) -> Result<Self> {
        let reader = StackReader::begin(folder);
        let store = StackStore::new(folder);
        let book = PaintStore::new(folder).read()?;
        let (mut stacks, mut states) = (Vec::new(), Vec::new());
        let survey = Survey::new(project, site, &store);
        for photo in &site.photos {
            let (stack, state) = match survey.state(photo)? {
                StackState::Current(stack) => (Some(stack), Ok(true)),
                StackState::Stale(stack) => (Some(stack), Ok(false)),
                StackState::Missing => (None, Err(no_stack(&photo.name))),
                StackState::Broken(error) => (None, Err(error)),
            };
            stacks.push(stack.map(Arc::new));
            states.push(state);
        }
        let folder = folder.to_owned();
        let (relief, gains, surroundings, without) = (None, None, None, Vec::new());
        let _reader = reader;
        Ok(Self {
            folder,
            project,
            site,
            store,
            stacks,
            states,
            book,
            relief,
            gains,
            surroundings,
            without,
            _reader,
        })
    }

    /// Uses gains and relief that were estimated without some photos.
    pub fn set_estimates(&mut self, gains: Gains, relief: Option<Arc<Relief>>, without: &[PhotoId]) {
        (self.gains, self.relief, self.without) = (Some(gains), relief, without.to_vec());
        self.surroundings = None;
    }

    /// Returns whether a photo has a stack that can be used.
    pub fn has_stack(&self, photo: PhotoId) -> bool {
        self.stacks[photo.index()].is_some()
    }

    /// Returns the project.
    pub(super) fn project(&self) -> &'a Project {
        self.project
    }

    /// Returns the photos and the model.
    pub fn site(&self) -> &'a Site {
        self.site
    }

    /// Returns the stacks in the site's order.
    pub(super) fn stacks(&self) -> &[Option<Arc<Stack>>] {
        &self.stacks
    }

    /// Returns the hash of everything that the layered depth image of a photo is made of; `None` where the photo has no
    /// stack that can be used.
    pub fn inputs(&self, photo: PhotoId, options: &StackLdiOptions) -> Option<String> {
        let stack = self.stacks[photo.index()].as_ref()?;
        let current = *self.states[photo.index()].as_ref().ok()?;
        Some(inputs(self.project, self.site, &self.stacks, stack, current, &self.book, options))
    }

    /// Returns a photo's layered depth image from the cache where that is up to date, else makes it.
    ///
    /// # Errors
    /// As [`Self::ldi_of_stack`].
    pub fn cached_or_made(&mut self, photo: PhotoId, options: &StackLdiOptions, task: &Task) -> Result<Ldi> {
        match self.cached(photo, options, task) {
            Some(ldi) => Ok(ldi),
            None => self.ldi_of_stack(photo, options, task),
        }
    }

    /// Returns a photo's layered depth image from the cache where that is up to date.
    fn cached(&self, photo: PhotoId, options: &StackLdiOptions, task: &Task) -> Option<Ldi> {
        self.cached_by(photo, options, |file, _| read_ldi(file, task).ok())
    }

    /// Returns the coarsest level of a photo's layered depth image in the cache that has a side of at least `side` pixels, as an
    /// image of its own, where that is up to date and has a coarser level than its first one. Nothing else of it is read.
    pub fn cached_coarsely(
        &self,
        photo: PhotoId,
        options: &StackLdiOptions,
        side: u32,
        task: &Task,
    ) -> Option<Ldi> {
        self.cached_by(photo, options, |file, header| {
            let is_enough = |index: &usize| {
                let level = &header.levels[*index];
                level.width.max(level.height) >= side
            };
            let index = (1..header.levels.len()).rev().find(is_enough)?;
            read_ldi_level(file, index, task).ok()
        })
    }

    /// Reads a photo's layered depth image from the cache where that is up to date. One with surroundings serves without
    /// them, too.
    fn cached_by(
        &self,
        photo: PhotoId,
        options: &StackLdiOptions,
        read: impl FnOnce(&Path, &LdiHeader) -> Option<Ldi>,
    ) -> Option<Ldi> {
        // What is cached was made with the estimates of all photos.
        if !self.without.is_empty() {
            return None;
        }
        let file = cached_file(&self.folder, &self.site.photo(photo).name);
        let header = read_ldi_header(&file).ok().filter(|_| has_whole_length(&file))?;
        let inputs = self.inputs(photo, options)?;
        if header.inputs == inputs {
            return read(&file, &header);
        }
        let around = StackLdiOptions { surroundings: true, ..*options };
        if options.surroundings || self.inputs(photo, &around)? != header.inputs {
            return None;
        }
        Some(Ldi { inputs, ..read(&file, &header)?.without_surroundings() })
    }

    /// Makes the layered depth image of a photo's stack. One that is older than the project is used, and noted.
    ///
    /// # Errors
    /// Where the photo has no stack that can be used; the errors of reading its files; [`Error::Cancelled`].
    pub fn ldi_of_stack(&mut self, photo: PhotoId, options: &StackLdiOptions, task: &Task) -> Result<Ldi> {
        let name = &self.site.photo(photo).name;
        let task = &task.with_subject(name);
        let current = match &mut self.states[photo.index()] {
            Ok(current) => *current,
            Err(error) => return Err(std::mem::replace(error, no_stack(name))),
        };
        if !current {
            let found = "its stack is out of date and is used as it is; ";
            task.note((found, Remedy::Build, " builds it again"));
        }
        self.estimate(options.relief, task)?;
        let stack = self.stacks[photo.index()].clone().ok_or_else(|| no_stack(name))?;
        let inputs = self.inputs(photo, options).unwrap_or_default();
        let agreement = match options.surroundings && stack.surroundings().is_some() {
            true => self.agreement_of(photo, [stack.photo.width, stack.photo.height], task)?,
            false => None,
        };
        let source = StackSource {
            store: &self.store,
            photo: self.site.photo(photo),
            stack: &stack,
            current,
            model: &self.site.model,
            book: &self.book,
            tolerance: self.project.options.tolerance,
            relief: self.relief.clone().filter(|_| options.relief),
            agreement,
            gain: self.gains.as_ref().map_or([0.0; 3], |gains| gains.of_photo[photo.index()]),
            inputs,
        };
        ldi_of_stack(&source, options, task)
    }

    /// Returns how far a photo's surroundings are confirmed to be far away, by positions in the photo reduced to a width and
    /// height in pixels.
    pub(super) fn agreement_of(
        &mut self,
        photo: PhotoId,
        size: [u32; 2],
        task: &Task,
    ) -> Result<Option<AgreementGrid>> {
        let found = match &self.surroundings {
            Some(found) => found.clone(),
            None => {
                let compare = || {
                    let mut of_site =
                        SiteSurroundings::present(&self.folder, self.project, self.site, &self.stacks, task)?;
                    match &self.gains {
                        Some(gains) => Ok(of_site.without(&self.without, gains, task)?.agreement),
                        None => Ok(of_site.whole().agreement.clone()),
                    }
                };
                self.surroundings.insert(task.timed("surroundings", compare)?).clone()
            }
        };
        let agreement = found.get(photo.index()).filter(|agreement| agreement.size[0] > 0);
        Ok(agreement.map(|agreement| agreement.whole(size)))
    }

    /// Estimates gains and relief, or reads them from the cache, the first time that they are needed.
    fn estimate(&mut self, needs_relief: bool, task: &Task) -> Result<()> {
        let (site, memory) = (self.site, default_memory());
        if self.gains.is_none() {
            let colour = &self.project.colour;
            let estimate = || gains::photo_gains(site, &self.stacks, colour, &self.folder, memory, task);
            self.gains = Some(task.timed("gains", estimate)?);
        }
        if needs_relief && self.relief.is_none() {
            let photos = gains::photo_inputs(site, &self.stacks);
            let estimate = || SiteRelief::open(site, photos, &self.folder, memory, task);
            self.relief = Some(task.timed("relief", estimate)?.whole().clone());
        }
        Ok(())
    }
}

/// Returns the error of a photo without a stack.
pub(super) fn no_stack(photo: &str) -> Error {
    Error::missing((format!("photo {photo} has no stack yet; "), Remedy::Build, " builds it"))
}
