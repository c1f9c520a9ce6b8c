//! Opening a project for rendering: stacks are read, and layer textures, gains and relief are prepared.

mod estimates;
mod faces;
mod in_use;
mod options;
mod renders;
mod stacks;
mod trees;
mod unseen;

pub use self::options::{MORE_MEMORY, PreviewOptions};
pub use self::stacks::ReadStacks;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use self::estimates::{Estimates, LayerAgreement, estimates_from_photos, shown_gains, with_dome};
use self::stacks::stacks;
use self::trees::PreviewTrees;
use crate::continuation::SiteContinuation;
use quadratura_base::error::{Message, Result};
use quadratura_base::scene::{PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::paint::PaintBook;
use quadratura_document::{Decisions, Project, Stack};
use quadratura_io::stack_readers::StackReader;
use quadratura_io::stack_store::StackStore;
use quadratura_layers::agreement::PhotoEvidence;
use quadratura_layers::device::{PlantedRenderer, SiteDevice};
use quadratura_layers::sky_model::Daylight;
use quadratura_projection::agreement::Agreement;
use quadratura_projection::dome::Dome;
use quadratura_projection::model_surface::ModelSurface;
use quadratura_projection::pyramid::PyramidOptions;
use quadratura_projection::relief::Relief;
use quadratura_projection::twin::ReferenceRenderer;
use quadratura_projection::{Gains, LayerTextureId, SiteContent, Sources, TextureOptions};
use quadratura_stacks::agreement::SiteAgreement;
use quadratura_stacks::far_backdrops::FarBackdrops;
use quadratura_stacks::gains::SiteGains;
use quadratura_stacks::layer_textures::LayerTextureFiles;
use quadratura_stacks::origins::LayerTextureOrigins;
use quadratura_stacks::projected_paint::ProjectedPaint;
use quadratura_stacks::relief::SiteRelief;
use quadratura_stacks::sources::sources;
use quadratura_stacks::surroundings::{SiteSurroundings, SurroundingsEvidence};
use quadratura_stacks::survey::{StackState, Survey};
use quadratura_view::{DisplayMode, Shot};

/// A project's renderer. Photos that a shot excludes do not contribute to gains, relief and agreement either.
pub struct Preview {
    renderer: Box<dyn PlantedRenderer>,
    /// The texture memory that it may use.
    textures: TextureOptions,
    /// The trees that stand in the site.
    trees: PreviewTrees,
    store: StackStore,
    /// The names of the photos, in the site's order.
    photos: Vec<String>,
    files: LayerTextureFiles,
    /// The gains, with which photos are compared, too.
    gains: SiteGains,
    /// Whether pictures show matched exposures.
    shows_gains: bool,
    /// The relief, on which photos are compared, too.
    relief: Option<SiteRelief>,
    /// Whether pictures show the relief.
    shows_relief: bool,
    agreement: Option<SiteAgreement>,
    surroundings: SiteSurroundings,
    /// The evidence of the surroundings by which photos are weighted now.
    around: SurroundingsEvidence,
    /// The evidence by which photos are weighted now.
    evidence: Arc<[PhotoEvidence]>,
    /// The agreement of image layers before and after paint was spared.
    agreement_of_layers: LayerAgreement,
    sources: Arc<Sources>,
    /// The photos without which the estimates in use were made.
    without: Vec<PhotoId>,
    /// The gains in use, whether pictures show them or not.
    gains_in_use: Gains,
    /// The relief in use, whether pictures show it or not.
    relief_in_use: Option<Arc<Relief>>,
    /// Messages about unreadable stacks and paint, which all pictures lack.
    problems: Vec<Message>,
    /// Whether fillings of hidden texels are shown.
    filled: bool,
    /// The project's folder and site, and what surfaces continue from, once that was needed.
    folder: PathBuf,
    site: Site,
    continuation: Option<SiteContinuation>,
    /// Whether surfaces continue on the device as the photos in use say.
    continues: bool,
}

/// Makes the renderer of a project and its site. Photos without a stack are not used; stacks older than the project are.
/// Both are noted. A stack that cannot be read is in [`Preview::problems`]. Gains and relief are estimated the
/// first time and cached in `cache/`.
///
/// # Errors
/// Returns [`quadratura_base::Error::Request`] when no photo has a stack, [`quadratura_base::Error::Io`] and [`quadratura_base::Error::Input`] for stacks that cannot
/// be read, or [`quadratura_base::Error::Gpu`].
pub fn open(
    folder: &Path,
    project: &Project,
    site: &Site,
    device: &dyn SiteDevice,
    options: &PreviewOptions,
    task: &Task,
) -> Result<Preview> {
    // Stacks that change from now on stay readable as they are.
    let _reader = StackReader::begin(folder);
    let read = read(folder, project, site, options, task)?;
    open_read(folder, project, site, read, device, options, task)
}

/// Reads the stacks that a preview shows, for [`open_read`].
///
/// # Errors
/// [`Error::Missing`](quadratura_base::Error::Missing) when no photo has a stack.
pub fn read(
    folder: &Path,
    project: &Project,
    site: &Site,
    options: &PreviewOptions,
    task: &Task,
) -> Result<ReadStacks> {
    let store = StackStore::new(folder);
    task.timed("read stacks", || stacks(project, site, &store, options, task))
}

/// Makes the renderer of a project and its site from stacks that were read before, whatever is on disk now.
///
/// # Errors
/// As [`open`], except those of reading stacks.
pub fn open_read(
    folder: &Path,
    project: &Project,
    site: &Site,
    read: ReadStacks,
    device: &dyn SiteDevice,
    options: &PreviewOptions,
    task: &Task,
) -> Result<Preview> {
    let mut preview = without_trees(folder, project, site, read, device, options, task)?;
    preview.plant(project, site, task)?;
    Ok(preview)
}

fn without_trees(
    folder: &Path,
    project: &Project,
    site: &Site,
    ReadStacks { stacks, mut problems }: ReadStacks,
    device: &dyn SiteDevice,
    options: &PreviewOptions,
    task: &Task,
) -> Result<Preview> {
    let reader = StackReader::begin(folder);
    let (store, site) = (StackStore::new(folder), site);
    let files = LayerTextureFiles::new(&store, &stacks, options.filled)
        .with_far(&stacks, FarBackdrops::new(site).into())
        .with_paint(&store, &stacks)?;
    let files = files.held_by(reader);
    problems.extend(files.problems().into_iter().map(Message::from));
    let Estimates { gains, relief, agreement, surroundings } =
        estimates_from_photos(folder, project, site, &stacks, options, task)?;
    let around = surroundings.whole().clone();
    let files = files.with_dome(around.dome.clone());
    let sources = sources(site, &stacks, &project.decisions);
    let sources = Arc::new(with_dome(sources, &surroundings));
    let shown = relief.as_ref().filter(|_| options.relief);
    let whole = shown.map(|relief| relief.whole().clone()).unwrap_or_default();
    let (model, texels) = (site.model.clone(), Arc::new(files.clone()));
    let evidence = agreement.as_ref().map(|agreement| agreement.whole().clone()).unwrap_or_default();
    let agreement_of_layers = LayerAgreement::new(&evidence, &around, &sources, &files);
    let content = SiteContent {
        model,
        sources: sources.clone(),
        gains: shown_gains(gains.whole(), options.gains, &around),
        relief: &whole,
        agreement: agreement_of_layers.present.clone(),
        texels,
    };
    let renderer = device.renderer(content, options.textures)?;
    let photos = site.photos.iter().map(|photo| photo.name.clone()).collect();
    let (without, filled) = (Vec::new(), options.filled);
    let gains_in_use = gains.whole().clone();
    let relief_in_use = relief.as_ref().map(|relief| relief.whole().clone());
    Ok(Preview {
        renderer,
        textures: options.textures,
        trees: PreviewTrees::new(folder, site, options.tree_parts),
        store,
        photos,
        files,
        gains,
        shows_gains: options.gains,
        relief,
        shows_relief: options.relief,
        agreement,
        surroundings,
        around,
        evidence,
        agreement_of_layers,
        sources,
        without,
        gains_in_use,
        relief_in_use,
        problems,
        filled,
        folder: folder.to_owned(),
        site: site.clone(),
        continuation: None,
        continues: false,
    })
}

/// Makes the reference renderer of a project and its site, which runs on the CPU: it needs no graphics adapter, and takes
/// seconds for a picture that a GPU draws at once. The options of the texture memory have no effect.
///
/// # Errors
/// As [`open`], except those of the GPU.
pub fn open_reference(
    folder: &Path,
    project: &Project,
    site: &Site,
    options: &PreviewOptions,
    task: &Task,
) -> Result<ReferenceRenderer> {
    let reader = StackReader::begin(folder);
    let (store, site) = (StackStore::new(folder), site);
    let ReadStacks { stacks, problems } =
        task.timed("read stacks", || stacks(project, site, &store, options, task))?;
    problems.into_iter().for_each(|problem| task.note(problem));
    let files = LayerTextureFiles::new(&store, &stacks, options.filled)
        .with_far(&stacks, FarBackdrops::new(site).into())
        .with_paint(&store, &stacks)?;
    let files = files.held_by(reader);
    files.problems().into_iter().for_each(|problem| task.note(problem));
    let Estimates { gains, relief, agreement, surroundings } =
        estimates_from_photos(folder, project, site, &stacks, options, task)?;
    let sources = sources(site, &stacks, &project.decisions);
    let sources = Arc::new(with_dome(sources, &surroundings));
    let around = surroundings.whole();
    let files = files.with_dome(around.dome.clone());
    let shown = relief.as_ref().filter(|_| options.relief);
    let relief = shown.map(|relief| Relief::clone(relief.whole())).unwrap_or_default();
    let evidence = agreement.as_ref().map(|agreement| agreement.whole().clone()).unwrap_or_default();
    let agreement = LayerAgreement::new(&evidence, around, &sources, &files).present;
    let (model, texels) = (site.model.clone(), Arc::new(files));
    let gains = shown_gains(gains.whole(), options.gains, around);
    let renderer = ReferenceRenderer::new(model, sources, gains, relief, texels, PyramidOptions::default());
    Ok(renderer.with_agreement(agreement).with_skirts())
}

/// What the photos say of each other, for those who blend them elsewhere.
pub struct PhotoEstimates {
    /// The gains of all photos, in the site's order.
    pub gains: Gains,
    /// The surroundings in directions that no photo shows.
    pub dome: Option<Arc<Dome>>,
    /// How far other photos confirm each texel.
    pub agreement: Agreement,
}

/// Estimates these from the stacks of all photos (in the site's order), and divides the agreement among the layer textures of `sources`,
/// whose files are `files`.
///
/// # Errors
/// The errors of reading photos and paint, and of a stop.
pub fn photo_estimates(
    folder: &Path,
    project: &Project,
    site: &Site,
    stacks: &[Option<Stack>],
    (sources, files): (&Sources, &LayerTextureFiles),
    task: &Task,
) -> Result<PhotoEstimates> {
    let options = PreviewOptions::default();
    let Estimates { gains, agreement, surroundings, .. } =
        estimates_from_photos(folder, project, site, stacks, &options, task)?;
    let evidence = agreement.as_ref().map(|agreement| agreement.whole().clone()).unwrap_or_default();
    let around = surroundings.whole();
    let agreement = LayerAgreement::new(&evidence, around, sources, files).present;
    Ok(PhotoEstimates { gains: gains.whole().clone(), dome: around.dome.clone(), agreement })
}

/// Estimates gains and relief and caches them in `cache/`, so that the first picture does not wait for them.
/// Nothing is done while a photo has no up-to-date stack, because the estimates would soon be obsolete.
///
/// # Errors
/// Returns the errors of [`open`].
pub fn prepare(folder: &Path, project: &Project, site: &Site, task: &Task) -> Result<()> {
    let store = StackStore::new(folder);
    let survey = Survey::new(project, site, &store);
    let mut stacks = Vec::with_capacity(site.photos.len());
    for photo in &site.photos {
        let StackState::Current(stack) = survey.state(photo)? else { return Ok(()) };
        stacks.push(Some(stack));
    }
    estimates_from_photos(folder, project, site, &stacks, &PreviewOptions::default(), task).map(drop)
}

impl Preview {
    /// Returns the costs of texture memory, against what it shows, in words.
    pub fn statistics(&self) -> String {
        self.renderer.statistics()
    }

    /// Shows the paint that the photos with these names have in `book`, the project's present paint. Only layer
    /// textures that change are read again. Gains stay, and so does the relief, which is estimated from photos without
    /// paint. Returns the number of layer textures that were read at once; others follow when they are needed.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`], [`quadratura_base::Error::Cancelled`].
    pub fn reload_paint(&mut self, photos: &[String], book: &PaintBook, task: &Task) -> Result<usize> {
        let id = |name: &String| self.photos.iter().position(|photo| photo == name).map(PhotoId::new);
        let ids: Vec<PhotoId> = photos.iter().filter_map(id).collect();
        let (files, changed) = self.files.repainted(&self.store, book, &ids);
        self.renew(files, &changed, task)
    }

    /// Shows paint on these photos (indices in the site) that their files do not contain yet, instead of what was shown
    /// so before. Returns the number of layer textures that were read at once.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`], [`quadratura_base::Error::Cancelled`].
    pub fn show_projected(
        &mut self,
        photos: &[PhotoId],
        projected: Vec<ProjectedPaint>,
        task: &Task,
    ) -> Result<usize> {
        let (files, changed) = self.files.with_projected(photos, projected);
        self.renew(files, &changed, task)
    }

    /// Shows the present stacks, in the site's order, where only their fillings have changed. Paint that was shown before
    /// it was in the files is taken from the files now. Returns false where image layers are others, so that the preview
    /// has to be opened again.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`], [`quadratura_base::Error::Cancelled`].
    pub fn refill(&mut self, stacks: &[Option<Arc<Stack>>], task: &Task) -> Result<bool> {
        match self.files.with_stacks(&self.store, stacks, self.filled) {
            Some((files, changed)) => self.renew(files, &changed, task).map(|_| true),
            None => Ok(false),
        }
    }

    /// Reads layer textures from other files from now on, at once those that changed and are in use.
    fn renew(&mut self, files: LayerTextureFiles, changed: &[LayerTextureId], task: &Task) -> Result<usize> {
        self.files = files;
        self.renderer.set_origins(None)?;
        let read = self.renderer.renew(Arc::new(self.files.clone()), changed, task)?;
        let repainted = match self.agreement {
            Some(_) => self.agreement_of_layers.repaint(changed, &self.files),
            None => Vec::new(),
        };
        if !repainted.is_empty() {
            self.renderer.renew_agreement(&self.agreement_of_layers.present, &repainted)?;
        }
        Ok(read)
    }

    /// Applies the present decisions about which photos may texture a face, and which one does so alone. Stacks
    /// stay as they are, and so do their texels on the device: other decisions take effect only after a build. The
    /// model must be the one with which this was opened.
    ///
    /// # Errors
    /// Returns [`quadratura_base::Error::Gpu`] when the device fails.
    pub fn redecide(&mut self, site: &Site, decisions: &Decisions) -> Result<()> {
        let sources = sources(site, &self.files.stacks(), decisions);
        self.sources = Arc::new(with_dome(sources, &self.surroundings));
        self.renderer.set_sources(self.sources.clone())?;
        self.renew_agreement()
    }

    /// Changes the photos' gains, which were estimated from all of them. The surroundings stay as they are until
    /// [`Self::set_surroundings`].
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`].
    pub fn set_gains(&mut self, gains: Gains) -> Result<()> {
        self.gains.replace_whole(gains.clone());
        self.gains_in_use = gains.clone();
        self.continues = false;
        self.renderer.set_gains(shown_gains(&gains, true, &self.around))
    }

    /// Replaces the surroundings by those of other gains, or of other paint on them. Stacks and model must be those with which
    /// this was opened.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`], [`quadratura_base::Error::Cancelled`].
    pub fn set_surroundings(&mut self, surroundings: SiteSurroundings, task: &Task) -> Result<()> {
        if surroundings.stamp() == self.surroundings.stamp() {
            return Ok(());
        }
        self.surroundings = surroundings;
        let without = self.without.clone();
        let gains = self.gains.without(&without, task)?;
        let around = self.surroundings.without(&without, &gains, task)?;
        self.show_around(around, task)?;
        self.renew_agreement()
    }

    /// Shows the dome of this evidence of the surroundings.
    fn show_around(&mut self, around: SurroundingsEvidence, task: &Task) -> Result<()> {
        if around.dome != self.around.dome {
            let files = self.files.clone().with_dome(around.dome.clone());
            let changed: Vec<LayerTextureId> = self.sources.dome_textures().collect();
            self.renew(files, &changed, task)?;
        }
        self.around = around;
        let gains = shown_gains(&self.gains_in_use, self.shows_gains, &self.around);
        self.renderer.set_gains(gains)
    }

    /// Returns the daylight of the sky that takes the place of all that photos show around the model; `None` where they show it.
    pub fn daylight(&self) -> Option<&Daylight> {
        self.surroundings.daylight()
    }

    /// Returns what pictures lack: unreadable stacks and paint, and single image layers as far as they were needed
    /// until now.
    pub fn problems(&self) -> Vec<Message> {
        let unreadable = self.renderer.unreadable();
        let (layers, were) = if unreadable == 1 { ("image layer", "was") } else { ("image layers", "were") };
        let problem = || {
            let found =
                format!("{unreadable} {layers} could not be read and {were} left out of all pictures");
            Message::from(found + "; see the notes")
        };
        self.problems.iter().cloned().chain((unreadable > 0).then(problem)).collect()
    }

    /// Returns the model's surface, for ray casts and for drawing.
    pub fn surface(&self) -> Arc<ModelSurface> {
        self.renderer.surface()
    }

    /// Prepares what this shot needs in addition: estimates without excluded photos, or provenance colours.
    fn make_ready(&mut self, shot: &Shot, task: &Task) -> Result<()> {
        self.leave_out(&shot.without, task)?;
        if shot.display == DisplayMode::Provenance && !self.renderer.has_origins() {
            self.renderer.set_origins(Some(Arc::new(LayerTextureOrigins(self.files.clone()))))?;
        }
        self.show_unseen(shot.unseen, task)
    }

    /// Puts gains, relief and agreement without these photos on the device, if they are not there yet.
    fn leave_out(&mut self, photos: &[PhotoId], task: &Task) -> Result<()> {
        if self.without == photos {
            return Ok(());
        }
        // What is on the device changes only when everything is known.
        let gains = task.timed("gains", || self.gains.without(photos, task))?;
        let relief = match &mut self.relief {
            Some(relief) => Some(task.timed("relief", || relief.without(photos, task))?),
            None => None,
        };
        let evidence = match (&mut self.agreement, &relief) {
            (Some(agreement), Some(relief)) => {
                Some(task.timed("agreement", || agreement.without(photos, relief, &gains, task))?)
            }
            _ => None,
        };
        let around = task.timed("surroundings", || self.surroundings.without(photos, &gains, task))?;
        self.renderer.set_gains(shown_gains(&gains, self.shows_gains, &around))?;
        self.gains_in_use = gains;
        if let Some(relief) = relief.as_ref().filter(|_| self.shows_relief) {
            self.renderer.set_relief(relief)?;
        }
        self.relief_in_use = relief;
        self.show_around(around, task)?;
        if let Some(evidence) = evidence {
            self.evidence = evidence;
            self.renew_agreement()?;
        }
        self.without = photos.to_vec();
        self.continues = false;
        Ok(())
    }

    /// Weights photos by the present evidence, decisions and paint.
    fn renew_agreement(&mut self) -> Result<()> {
        if self.agreement.is_none() {
            return Ok(());
        }
        self.agreement_of_layers =
            LayerAgreement::new(&self.evidence, &self.around, &self.sources, &self.files);
        self.renderer.set_agreement(self.agreement_of_layers.present.clone())
    }
}
