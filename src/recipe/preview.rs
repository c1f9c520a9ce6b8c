//! A project becomes a renderer: stacks are read, and sheets, gains and relief made ready.

use std::path::Path;
use std::sync::Arc;

use super::budget::default_memory;
use super::gains::{self, photo_gains};
use super::open::Opened;
use super::origins::SheetOrigins;
use super::relief::SiteRelief;
use super::sheets::SheetFiles;
use super::sources::sources;
use super::survey::{StackState, Survey};
use crate::document::paint::PaintBook;
use crate::document::{Decisions, Stack};
use crate::error::{Error, Result};
use crate::gpu::{Gpu, Renderer, TextureOptions};
use crate::io::stack_store::StackStore;
use crate::projection::surface::Surface;
use crate::projection::{Gains, PhotoId, Picture, Renders, Shot, Shown, SiteContent, SiteRenderer, Sliced};
use crate::scene::Site;
use crate::task::Task;

/// How a project is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PreviewOptions {
    /// Texture memory.
    pub textures: TextureOptions,
    /// Differences of exposure between photos are evened out.
    pub gains: bool,
    /// Surfaces are shown with the relief that the photos tell.
    pub relief: bool,
    /// Hidden texels are shown as they were filled, where they were.
    pub filled: bool,
}

impl Default for PreviewOptions {
    fn default() -> Self {
        Self { textures: TextureOptions::default(), gains: true, relief: true, filled: true }
    }
}

/// A project's renderer, which sees to it that photos that must not take part in a shot tell nothing of
/// the relief either.
pub struct Preview {
    renderer: Box<dyn SiteRenderer>,
    store: StackStore,
    /// Names in the site's order.
    photos: Vec<String>,
    files: SheetFiles,
    relief: Option<SiteRelief>,
    /// The photos that the relief on the device was made without.
    without: Vec<PhotoId>,
    /// What all pictures lack: whole stacks, paint.
    problems: Vec<String>,
}

/// The renderer of an opened project. Photos without a stack serve nothing, with a note; those whose
/// stack is older than the project do, with a note; one that cannot be read is in [`Preview::problems`]. Gains and
/// relief are estimated the first time, and kept in `cache/`.
///
/// # Errors
/// [`Error::Request`] when no photo has a stack, [`Error::Io`] and [`Error::Input`] for stacks that
/// cannot be read, [`Error::Gpu`].
pub fn open(
    folder: &Path,
    opened: &Opened,
    gpu: &Gpu,
    options: &PreviewOptions,
    task: &Task,
) -> Result<Preview> {
    let on_device = |site: SiteContent<'_>| -> Result<Box<dyn SiteRenderer>> {
        Ok(Box::new(Renderer::of_site(gpu, site, options.textures)?))
    };
    open_with(folder, opened, on_device, options, task)
}

/// [`open`] with another renderer, which `make` makes of the site.
///
/// # Errors
/// As [`open`], and those of `make`.
pub fn open_with(
    folder: &Path,
    opened: &Opened,
    make: impl FnOnce(SiteContent<'_>) -> Result<Box<dyn SiteRenderer>>,
    options: &PreviewOptions,
    task: &Task,
) -> Result<Preview> {
    let (store, site) = (StackStore::new(folder), &opened.site);
    let (stacks, mut problems) = task.timed("read stacks", || stacks(opened, &store, task))?;
    let sources = Arc::new(sources(site, &stacks, &opened.project.decisions));
    let files = SheetFiles::new(&store, &stacks, options.filled).with_paint(&store, &stacks)?;
    problems.extend(files.problems());
    let (gains, relief) = told_by_photos(folder, opened, &stacks, options, task)?;
    let whole = relief.as_ref().map(|relief| relief.whole().clone()).unwrap_or_default();
    let (model, texels) = (site.model.clone(), Arc::new(files.clone()));
    let renderer = make(SiteContent { model, sources, gains, relief: &whole, texels })?;
    let photos = site.photos.iter().map(|photo| photo.name.clone()).collect();
    Ok(Preview { renderer, store, photos, files, relief, without: Vec::new(), problems })
}

/// Estimates gains and relief and puts them into `cache/`, so that the first picture need not wait for
/// them. Nothing is done while a photo has no stack of the project as it is: they would not hold for long.
///
/// # Errors
/// Those of [`open`].
pub fn prepare(folder: &Path, opened: &Opened, task: &Task) -> Result<()> {
    let store = StackStore::new(folder);
    let survey = Survey::new(opened, &store);
    let mut stacks = Vec::with_capacity(opened.site.photos.len());
    for photo in &opened.site.photos {
        let StackState::Current(stack) = survey.state(photo)? else { return Ok(()) };
        stacks.push(Some(stack));
    }
    told_by_photos(folder, opened, &stacks, &PreviewOptions::default(), task).map(drop)
}

/// Gains and relief, as far as they are wanted.
fn told_by_photos(
    folder: &Path,
    opened: &Opened,
    stacks: &[Option<Stack>],
    options: &PreviewOptions,
    task: &Task,
) -> Result<(Gains, Option<SiteRelief>)> {
    let (site, memory, colour) = (&opened.site, default_memory(), &opened.project.colour);
    let gains = match options.gains {
        true => task.timed("gains", || photo_gains(site, stacks, colour, folder, memory, task))?,
        false => Gains::none(site.photos.len()),
    };
    let inputs = gains::inputs(site, stacks);
    let relief = task.timed("relief", || {
        options.relief.then(|| SiteRelief::open(site, &inputs, folder, memory, task)).transpose()
    })?;
    Ok((gains, relief))
}

impl Preview {
    /// What texture memory costs, against what it shows, in words.
    pub fn statistics(&self) -> String {
        self.renderer.statistics()
    }

    /// Shows the paint that photos of these names have in `book`, which is the project's by now. Only sheets that look other for it are read again:
    /// gains stay as they are, and so does the relief, which photos tell and not what was painted on them. Returns how
    /// many were read at once; others follow when they are needed.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::Cancelled`].
    pub fn renew_paint(&mut self, photos: &[String], book: &PaintBook, task: &Task) -> Result<usize> {
        let place = |name: &String| self.photos.iter().position(|photo| photo == name);
        let places: Vec<usize> = photos.iter().filter_map(place).collect();
        let (files, changed) = self.files.repainted(&self.store, book, &places);
        self.files = files;
        self.renderer.set_origins(None)?;
        self.renderer.renew(Arc::new(self.files.clone()), &changed, task)
    }

    /// Lets photos serve faces as it is decided by now: which of them serve a face no more, and which one serves it alone.
    /// Stacks stay as they are, and so do their texels on the device: other decisions need a build before they change
    /// any. The model is the one that this was opened with.
    ///
    /// # Errors
    /// [`Error::Gpu`].
    pub fn redecide(&mut self, site: &Site, decisions: &Decisions) -> Result<()> {
        self.renderer.set_sources(Arc::new(sources(site, &self.files.stacks(), decisions)))
    }

    /// Shows photos with other gains from now on.
    pub fn set_gains(&mut self, gains: Gains) {
        self.renderer.set_gains(gains);
    }

    /// What pictures were made without: stacks and paint that cannot be read, and single image layers, as far as they
    /// were wanted until now.
    pub fn problems(&self) -> Vec<String> {
        let unreadable = self.renderer.unreadable();
        let (layers, were) = if unreadable == 1 { ("image layer", "was") } else { ("image layers", "were") };
        let problem = || {
            format!(
                "{unreadable} {layers} could not be read and {were} left out of all pictures; see the notes"
            )
        };
        self.problems.iter().cloned().chain((unreadable > 0).then(problem)).collect()
    }

    /// The model as rays meet it, and as it is drawn.
    pub fn surface(&self) -> Arc<Surface> {
        self.renderer.surface()
    }

    /// What the shot needs besides what all shots do.
    fn make_ready(&mut self, shot: &Shot, task: &Task) -> Result<()> {
        if shot.relief {
            self.leave_out(&shot.without, task)?;
        }
        if shot.shown == Shown::Provenance && !self.renderer.has_origins() {
            self.renderer.set_origins(Some(Arc::new(SheetOrigins(self.files.clone()))))?;
        }
        Ok(())
    }

    fn leave_out(&mut self, photos: &[PhotoId], task: &Task) -> Result<()> {
        let Some(relief) = self.relief.as_mut().filter(|_| self.without != photos) else { return Ok(()) };
        let relief = task.timed("relief", || relief.without(photos, task))?;
        self.renderer.set_relief(&relief)?;
        self.without = photos.to_vec();
        Ok(())
    }
}

impl Renders for Preview {
    fn picture(&mut self, shot: &Shot, task: &Task) -> Result<Picture> {
        self.make_ready(shot, task)?;
        self.renderer.picture(shot, task)
    }

    fn faces(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>> {
        self.renderer.faces(shot, task)
    }

    fn begin(&mut self, shot: &Shot, task: &Task) -> Result<Sliced> {
        self.make_ready(shot, task)?;
        self.renderer.begin(shot, task)
    }

    fn advance(&mut self, sliced: &mut Sliced, task: &Task) -> Result<bool> {
        self.make_ready(sliced.shot(), task)?;
        self.renderer.advance(sliced, task)
    }
}

/// The photos' current stacks, in the site's order, and why some cannot be read.
fn stacks(opened: &Opened, store: &StackStore, task: &Task) -> Result<(Vec<Option<Stack>>, Vec<String>)> {
    let survey = Survey::new(opened, store);
    let mut stacks = Vec::with_capacity(opened.site.photos.len());
    let (mut missing, mut stale, mut broken) = (Vec::new(), Vec::new(), Vec::new());
    for photo in &opened.site.photos {
        stacks.push(match survey.state(photo)? {
            StackState::Current(stack) => Some(stack),
            StackState::Stale(stack) => {
                stale.push(photo.name.as_str());
                Some(stack)
            }
            StackState::Missing => {
                missing.push(photo.name.as_str());
                None
            }
            StackState::Broken(error) => {
                broken.push(format!("{}: its stack serves nothing: {error}", photo.name));
                None
            }
        });
    }
    if stacks.iter().all(Option::is_none) {
        if !broken.is_empty() {
            return Err(Error::Request(broken.join("\n")));
        }
        return Err(Error::Request("no photo has a stack yet; `quadratura build` makes them".into()));
    }
    if !missing.is_empty() {
        let missing = missing.join(", ");
        task.note(format!("no stack, so they serve nothing: {missing}; `quadratura build` makes them"));
    }
    if !stale.is_empty() {
        let stale = stale.join(", ");
        task.note(format!("older than the project: the stacks of {stale}; `quadratura build` renews them"));
    }
    Ok((stacks, broken))
}
