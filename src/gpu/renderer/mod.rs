//! The renderer: one pass over the model, in which every pixel samples the layer textures that may texture it.
//!
//! A view is drawn in three steps: the cells with their candidates (on the CPU,
//! [`quadratura_projection::cells`]), the tiles that they need, and the passes: *nearness* (depth), then
//! *project* (colour) or *faces*. Faces through which one sees are not in *nearness*: they are cut where they cross,
//! ordered from back to front on the CPU ([`quadratura_projection::back_to_front`]), and laid over the picture last.

mod agreement;
mod bounds;
mod frame;
mod grid_packing;
mod grids;
mod peel;
mod pipeline;
mod plants;
mod prepared;
mod program;
mod project;
pub(super) mod render_target;
mod seen;
mod shadows;
mod site;
mod sky;
mod sliced;
mod surfaces;
pub(super) mod table;
mod tables;
#[cfg(test)]
mod tests;
pub(super) mod texels;
mod wanted;

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;

use agreement::AgreementTexture;
use bounds::StoredBounds;
use grids::FaceGrids;
use plants::{Plants, SampledProgram, TreeProgram};
use prepared::{DrawnSurfaces, Prepared};
use program::{Program, SiteFeatures};
use project::{Pass, Passes};
use render_target::{FLAT_LINEAR, RenderTarget, TargetKey};
use shadows::Shadows;
pub use site::start_device;
use sky::SkyFactors;
use surfaces::ModelBuffers;
use table::GrowingBuffer;
use tables::{TableData, Tables};

use super::TileStore;
use super::device::Gpu;
use quadratura_base::error::Result;
use quadratura_base::scene::impostor::Facing;
use quadratura_base::scene::{Model, PhotoId};
use quadratura_base::task::Task;
use quadratura_projection::agreement::Agreement;
use quadratura_projection::cells::{Cells, Finder, TexelBounds};
use quadratura_projection::exposure::{Shares, ViewExposure, visible_shares};
use quadratura_projection::model_surface::ModelSurface;
use quadratura_projection::relief::Relief;
use quadratura_projection::skirts::Skirts;
use quadratura_projection::{
    Gains, Renders, SiteContent, SiteRenderer, Sliced, Sources, Texels, TextureOptions,
};
use quadratura_view::legend;
use quadratura_view::optics::Optics;
use quadratura_view::{DisplayMode, Picture, Shot, TreeMethod, Unseen};

/// The number of cells across an image, whatever its size in pixels: the angle that a cell spans determines
/// the length of its list of candidates. Cells smaller than [`LEAST_CELL_PX`] cost more to prepare than they
/// save.
const CELLS_ACROSS: u32 = 60;
const LEAST_CELL_PX: u32 = 16;
/// Cells of orthographic images, which may be very wide, are not larger: slices have whole rows of cells.
const MOST_PARALLEL_CELL_PX: u32 = 256;
/// The side of the cells from which the shares of groups of light are computed, in cells of the view.
const CELLS_OF_SHARES: u32 = 4;

/// A renderer of views of one site. It is long-lived: textures, tables and pipelines are reused from view to
/// view.
pub struct Renderer {
    gpu: Gpu,
    /// The site's own model.
    site_model: Arc<Model>,
    /// What stands on its outlines.
    skirts: Skirts,
    /// The model with the skirts, as the view sees it.
    model: Arc<Model>,
    /// The sources with those of the skirts.
    sources: Arc<Sources>,
    /// True when some face is pinned to a photo.
    pins: bool,
    /// True when some layer texture has a matte.
    mattes: bool,
    /// The corners of the skirts and the see-through faces of a view, each from back to front.
    see_through: GrowingBuffer,
    gains: Gains,
    surface: Arc<ModelSurface>,
    tiles: TileStore,
    /// The source of the texels of the site's own layer textures; `None` where no skirts are made of them.
    texels: Option<Arc<dyn Texels>>,
    /// The layer textures' texels replaced by colours of their origins, for [`DisplayMode::Provenance`]; `None` until
    /// provided.
    origins: Option<TileStore>,
    surfaces: ModelBuffers,
    grids: FaceGrids,
    /// The mean of the colours with which surfaces continue, sRGB; `None` where these are not there.
    continued_mean: Option<[u8; 3]>,
    agreement: AgreementTexture,
    /// The factors that bring photos' surroundings to one sky.
    sky: SkyFactors,
    tables: Tables,
    /// The view that tables and tiles are ready for, as a whole, with what decides about its passes.
    ready: Option<(Shot, Prepared)>,
    passes: Passes,
    /// The trees that stand in the site.
    plants: Option<Plants>,
    /// What shadows these cast on faces; made when they cast some for the first time.
    shadows: Option<Shadows>,
    targets: BTreeMap<TargetKey, RenderTarget>,
}

impl Renderer {
    /// Builds a renderer of a site, with texture memory of its own.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`].
    pub fn of_site(gpu: &Gpu, site: SiteContent<'_>, textures: TextureOptions) -> Result<Self> {
        let SiteContent { model, sources, gains, relief, agreement, texels } = site;
        let surface = ModelSurface::from_model(&model);
        let skirts = Skirts::new(&model, &sources, &surface);
        let tiles =
            TileStore::new(gpu, &skirts.sources, skirts.texels(texels.clone(), &agreement), textures)?;
        let mut renderer = Self::with_skirts(gpu, model, skirts, gains, relief, tiles)?;
        renderer.texels = Some(texels);
        renderer.set_agreement(agreement)?;
        Ok(renderer)
    }

    /// Builds a renderer for the model's faces and the layer textures that texture them, which do not contradict each other
    /// until [`SiteRenderer::set_agreement`]. It draws no skirts.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`].
    pub fn new(
        gpu: &Gpu,
        model: Arc<Model>,
        sources: Arc<Sources>,
        gains: Gains,
        relief: &Relief,
        tiles: TileStore,
    ) -> Result<Self> {
        let skirts = Skirts::none(&model, &sources);
        Self::with_skirts(gpu, model, skirts, gains, relief, tiles)
    }

    fn with_skirts(
        gpu: &Gpu,
        site_model: Arc<Model>,
        skirts: Skirts,
        gains: Gains,
        relief: &Relief,
        tiles: TileStore,
    ) -> Result<Self> {
        gpu.guarded("preparing the renderer", || {
            let sources = skirts.sources.clone();
            let surface = ModelSurface::from_model(&site_model).with_backs(&site_model, &sources);
            // Impostors have one rectangle each from here on, which turns with the views.
            let model = skirts.model.facing(&Facing { eye: DVec3::ZERO, right: DVec3::X });
            let surfaces = ModelBuffers::new(gpu, &model, &sources, surface.sides(), &skirts);
            Ok(Self {
                grids: FaceGrids::new(gpu, &model, relief, surfaces.origin()),
                continued_mean: None,
                agreement: AgreementTexture::new(gpu, Agreement::default(), sources.layer_textures.len()),
                sky: SkyFactors::new(gpu, &gains.surroundings),
                surfaces,
                tables: Tables::new(gpu, &model, &sources),
                ready: None,
                passes: Passes::new(gpu, &sources),
                plants: None,
                shadows: None,
                targets: BTreeMap::new(),
                gpu: gpu.clone(),
                surface: surface.into(),
                model,
                pins: sources.servers.iter().any(|server| server.pinned),
                mattes: skirts.own_textures(&sources).iter().any(|texture| texture.see_through),
                see_through: GrowingBuffer::new(gpu, "see-through corners", wgpu::BufferUsages::VERTEX),
                sources,
                gains,
                tiles,
                origins: None,
                site_model,
                skirts,
                texels: None,
            })
        })
    }

    /// Returns the layer textures' texels on the device.
    pub fn tiles(&self) -> &TileStore {
        &self.tiles
    }

    /// Returns the texels that a view samples.
    fn store(&self, shot: &Shot) -> &TileStore {
        self.origins.as_ref().filter(|_| shot.display == DisplayMode::Provenance).unwrap_or(&self.tiles)
    }

    fn store_mut(&mut self, shot: &Shot) -> &mut TileStore {
        self.origins.as_mut().filter(|_| shot.display == DisplayMode::Provenance).unwrap_or(&mut self.tiles)
    }

    /// Returns the layer textures' texels on the device, for changes.
    pub fn tiles_mut(&mut self) -> &mut TileStore {
        &mut self.tiles
    }

    /// Computes the exposure of this view, in which the photos have these shares.
    fn exposure(&self, shot: &Shot, shares: impl FnOnce() -> Shares) -> ViewExposure {
        // The colours of sources are symbols and have no exposure.
        match shot.display == DisplayMode::Provenance {
            true if self.gains.light.groups.is_one() => ViewExposure::neutral(self.sources.photos.len()),
            true => {
                let leaning = self.gains.exposed(shot, &self.sources.photos, shares).leaning;
                ViewExposure { leaning, ..ViewExposure::neutral(self.sources.photos.len()) }
            }
            false => self.gains.exposed(shot, &self.sources.photos, shares),
        }
    }

    /// Returns the side of a cell of the view, in pixels.
    fn cell_px(&self, shot: &Shot) -> u32 {
        let side_px = shot.camera.width.div_ceil(CELLS_ACROSS).max(LEAST_CELL_PX);
        if shot.parallel.is_some() { side_px.min(MOST_PARALLEL_CELL_PX) } else { side_px }
    }

    fn cells(&self, shot: &Shot, side_px: u32, leaning: &[f64], confidence: &impl TexelBounds) -> Cells {
        self.finder(shot, side_px, leaning, confidence).cells()
    }

    fn finder<'a, C>(
        &'a self,
        shot: &'a Shot,
        side_px: u32,
        leaning: &'a [f64],
        confidence: &'a C,
    ) -> Finder<'a, C> {
        let heights: &[f64] = if shot.relief { &self.grids.largest } else { &[] };
        let (model, sources) = (&*self.model, &self.sources);
        Finder { model, sources, shot, side_px, heights, leaning, confidence }
    }

    /// Computes the cells of a view and its exposure, unless that is given. Which groups of light a view leans to follows
    /// from its cells without leaning; a few large ones, whose longer lists have the same photos with weights, are enough.
    fn cells_and_exposure(
        &self,
        shot: &Shot,
        side_px: u32,
        exposure: Option<&ViewExposure>,
    ) -> (Cells, ViewExposure) {
        let bounds = StoredBounds { tiles: self.store(shot), agreement: &self.agreement.agreement };
        if let Some(exposure) = exposure {
            return (self.cells(shot, side_px, &exposure.leaning, &bounds), exposure.clone());
        }
        let shares = |cells: &Cells| visible_shares(shot, &self.model, &self.sources, &self.surface, cells);
        if self.gains.light.groups.is_one() {
            let cells = self.cells(shot, side_px, &[], &bounds);
            let exposure = self.exposure(shot, || shares(&cells));
            return (cells, exposure);
        }
        let exposure =
            self.exposure(shot, || shares(&self.cells(shot, CELLS_OF_SHARES * side_px, &[], &bounds)));
        (self.cells(shot, side_px, &exposure.leaning, &bounds), exposure)
    }

    /// Turns the impostors towards a view, whose tables are to be written.
    fn face(&mut self, shot: &Shot) {
        self.ready = None;
        if self.model.has_impostors() {
            Arc::make_mut(&mut self.model).turn_towards(&Facing::of_pose(&shot.pose));
            self.surfaces.turn(&self.gpu, &self.model);
        }
    }

    /// Updates tables and tiles for a view, of which `shown` is drawn; returns what decides about its passes. `exposure` is that of
    /// the whole image when the view is a band of it.
    fn prepare(
        &mut self,
        shot: &Shot,
        side_px: u32,
        exposure: Option<&ViewExposure>,
        shown: DrawnSurfaces,
        task: &Task,
    ) -> Result<Prepared> {
        self.face(shot);
        // A band of an image has an exposure that is not its own.
        let is_whole = exposure.is_none();
        let (mut cells, exposure) = task.timed("cells", || self.cells_and_exposure(shot, side_px, exposure));
        cells.depths = self.depths_with_trees(shot, cells.depths);
        task.check_cancelled()?;
        let (cells, is_short) = self.load_shown(shot, cells, &exposure.leaning, shown, task)?;
        if is_short && shown == DrawnSurfaces::NearestIfTheyFit {
            return Ok(Prepared { is_short, ..Prepared::default() });
        }
        let photos = PhotoId::all(self.sources.photos.len());
        let of_photo = |photo| match shot.display {
            DisplayMode::Provenance => Optics::default(),
            DisplayMode::Colour
            | DisplayMode::Weights
            | DisplayMode::BestPhoto
            | DisplayMode::Group
            | DisplayMode::Density
            | DisplayMode::Confidence
            | DisplayMode::Agreement
            | DisplayMode::Matte
            | DisplayMode::Layer
            | DisplayMode::Item
            | DisplayMode::Coverage => self.gains.optics(shot, photo),
        };
        let optics: Vec<Optics> = photos.map(of_photo).collect();
        let origin = self.surfaces.origin();
        let groups = &self.gains.light.groups;
        let (cells, exposure, optics, sky) = (&cells, &exposure, &optics, &self.sky);
        let content = TableData { shot, cells, exposure, optics, groups, sky, origin };
        self.tables.write(&self.gpu, &self.sources, &content);
        let undoes_optics = optics.iter().any(|optics| *optics != Optics::default());
        let [skirts, see_through] = self.order_see_through(shot, cells);
        let prepared = Prepared {
            undoes_optics,
            has_surroundings: cells.surroundings.is_some(),
            skirts,
            see_through,
            of_common: exposure.of_common,
            opaque_alone: false,
            is_short,
        };
        self.ready = is_whole.then(|| (shot.clone(), prepared));
        Ok(prepared)
    }

    /// Writes the skirts of a view and its see-through faces, each from back to front; returns the numbers of their corners.
    fn order_see_through(&mut self, shot: &Shot, cells: &Cells) -> [u32; 2] {
        let is_in_view = |face| {
            let is_shown = cells.faces.binary_search_by_key(&face, |cells| cells.face).is_ok();
            is_shown && !shot.hidden.contains(face)
        };
        let mut drawn = self.skirts.of_view(shot);
        drawn.retain(|face| is_in_view(*face));
        let mut corners = self.surfaces.corners_of_skirts(&self.model, &self.skirts, &drawn);
        let skirts = corners.len() as u32;
        corners.extend(self.surfaces.back_to_front(&self.model, shot.viewpoint(), is_in_view));
        if !corners.is_empty() {
            self.see_through.write(&self.gpu, &corners);
        }
        [skirts, corners.len() as u32 - skirts]
    }

    /// Draws the image of a view, or of a band of the image of `whole`, as it was prepared, and reads it back.
    fn drawn<T>(
        &mut self,
        shot: &Shot,
        whole: &Shot,
        prepared: Prepared,
        read: impl FnOnce(&RenderTarget, &Gpu) -> Result<T>,
        task: &Task,
    ) -> Result<T> {
        let gpu = self.gpu.clone();
        gpu.guarded("drawing a picture", || {
            let casts = self.cast_shadows(whole, task)?;
            task.timed("draw", || {
                let program = Program::new(shot, &self.features(prepared.undoes_optics)).with_shadows(casts);
                // Faces and numbers of faces are shown without what is behind them.
                let has_surroundings = prepared.has_surroundings && shot.display != DisplayMode::Item;
                let prepared = Prepared { has_surroundings, ..prepared };
                self.draw(shot, [program, program.of_see_through()], &prepared, task)?;
                read(&self.targets[&TargetKey::of_picture(shot)], &gpu)
            })
        })
    }

    /// Returns what the programs of a view must do.
    fn features(&self, undoes_optics: bool) -> SiteFeatures {
        let agreement = &self.agreement.agreement;
        let (contradicted, outlines) = (!agreement.is_full(), agreement.has_outlines());
        let (pins, impostors, mattes) = (self.pins, self.model.has_impostors(), self.mattes);
        SiteFeatures { undoes_optics, pins, impostors, contradicted, mattes, outlines }
    }

    /// Draws a view with a program, and its see-through faces with another one.
    fn draw(
        &mut self,
        shot: &Shot,
        [program, program_of_see_through]: [Program; 2],
        prepared: &Prepared,
        task: &Task,
    ) -> Result<()> {
        let key = match program {
            Program::Faces => TargetKey::of_faces(shot),
            Program::Picture { .. } => TargetKey::of_picture(shot),
        };
        // Targets of other sizes are unlikely to be needed again soon.
        self.targets.retain(|other, _| (other.width, other.height) == (key.width, key.height));
        let samples = self.targets.entry(key).or_insert_with(|| RenderTarget::new(&self.gpu, key)).samples;
        let see_through = (prepared.skirts + prepared.see_through > 0).then_some(program_of_see_through);
        self.passes.make(&self.gpu, program, samples, see_through, prepared.has_surroundings);
        let of_trees = match program {
            Program::Faces => TreeProgram::Numbered,
            Program::Picture { .. } => TreeProgram::of_picture(shot),
        };
        let trees = SampledProgram { program: of_trees, samples };
        let drawn = self.plants.as_mut().filter(|_| shot.trees != TreeMethod::None);
        let has_trees = match drawn {
            Some(plants) => plants.prepare(&self.gpu, shot, trees, prepared.of_common)?,
            None => false,
        };
        let pass = Pass {
            plants: self.trees(shot).filter(|_| has_trees).map(|plants| (plants, of_trees)),
            ..self.pass(shot, &self.targets[&key], prepared, program_of_see_through)
        };
        self.passes.draw(&pass, program, task)
    }

    /// Returns what a view shows where nothing is: of a site without surroundings, in a final picture, the mean of what is known.
    fn background(&self, shot: &Shot, prepared: &Prepared) -> wgpu::Color {
        let is_without = self.sources.surroundings.is_empty() && shot.surroundings;
        let mean = self.continued_mean.filter(|_| shot.unseen == Unseen::Continued && is_without);
        let light = match (mean, shot.display) {
            (Some(mean), DisplayMode::Colour) => {
                let mean = legend::linear(mean);
                Some([0, 1, 2].map(|c| (mean[c] * prepared.of_common[c]).min(1.0)))
            }
            (Some(_), DisplayMode::Provenance) => Some(legend::linear(legend::CONTINUED)),
            _ => None,
        };
        let [r, g, b] = light.unwrap_or([FLAT_LINEAR; 3]);
        wgpu::Color { r, g, b, a: f64::from(u8::from(light.is_some())) }
    }

    /// Collects what a drawing of a view reads and writes.
    fn pass<'a>(
        &'a self,
        shot: &Shot,
        target: &'a RenderTarget,
        prepared: &Prepared,
        program_of_see_through: Program,
    ) -> Pass<'a> {
        Pass {
            gpu: &self.gpu,
            surfaces: &self.surfaces,
            grids: &self.grids,
            sky: &self.sky,
            agreement: &self.agreement,
            tables: &self.tables,
            tiles: self.store(shot),
            target,
            surroundings: prepared.has_surroundings,
            background: self.background(shot, prepared),
            opaque_alone: prepared.opaque_alone,
            see_through: (&self.see_through, [prepared.skirts, prepared.see_through]),
            program_of_see_through,
            shadows: self.shadows.as_ref().and_then(Shadows::group),
            plants: None,
        }
    }
}

impl Renders for Renderer {
    fn picture(&mut self, shot: &Shot, task: &Task) -> Result<Picture> {
        if shot.supersampled || render_target::judge(&self.gpu, shot).is_err() {
            return self.sliced_picture(shot, task);
        }
        let prepared = self.prepare_picture(shot, self.cell_px(shot), None, DrawnSurfaces::Nearest, task)?;
        self.drawn(shot, shot, prepared, RenderTarget::picture, task)
    }

    fn faces(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>> {
        self.drawn_faces(shot, Prepared::default(), task, |target, gpu, _| target.faces(gpu))
    }

    fn depths(&mut self, shot: &Shot, task: &Task) -> Result<Option<Vec<f32>>> {
        self.drawn_depths(shot, task).map(Some)
    }

    fn seen_faces(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>> {
        if self.mattes { self.drawn_seen(shot, task) } else { self.faces(&seen::of_seen(shot), task) }
    }

    fn begin(&mut self, shot: &Shot, _task: &Task) -> Result<Sliced> {
        self.begun(shot)
    }

    fn advance(&mut self, sliced: &mut Sliced, task: &Task) -> Result<bool> {
        self.advanced(sliced, task)
    }
}
