//! What changes on a site while its renderer is used: decisions, exposures, relief, the agreement of photos and texels.

use std::sync::Arc;

use glam::DVec3;

use super::Renderer;
use super::agreement::AgreementTexture;
use super::sky::SkyFactors;
use super::surfaces::ModelBuffers;
use super::tables::Tables;
use crate::{Gpu, TileStore};
use quadratura_base::error::Result;
use quadratura_base::scene::impostor::Facing;
use quadratura_base::task::Task;
use quadratura_foliage::PlacedTrees;
use quadratura_layers::device::{PlantedRenderer, SiteDevice};
use quadratura_projection::agreement::Agreement;
use quadratura_projection::continuation::Continuation;
use quadratura_projection::model_surface::ModelSurface;
use quadratura_projection::peeling::Peels;
use quadratura_projection::relief::Relief;
use quadratura_projection::skirts::Skirts;
use quadratura_projection::{
    Gains, LayerTextureId, SiteContent, SiteRenderer, Sources, Texels, TextureOptions,
};

/// The divisor of the texture memory for provenance colours, which have little detail.
const ORIGINS_SHARE: u64 = 4;

/// Starts the device on which sites are drawn.
///
/// # Errors
/// Those of [`Gpu::headless`].
pub fn start_device() -> Result<Box<dyn SiteDevice>> {
    Ok(Box::new(Gpu::headless()?))
}

impl SiteDevice for Gpu {
    fn renderer(&self, site: SiteContent<'_>, textures: TextureOptions) -> Result<Box<dyn PlantedRenderer>> {
        Ok(Box::new(Renderer::of_site(self, site, textures)?))
    }
}

impl PlantedRenderer for Renderer {
    fn set_trees(&mut self, placed: Option<Arc<PlacedTrees>>) -> Result<()> {
        Self::set_trees(self, placed)
    }
}

impl SiteRenderer for Renderer {
    fn surface(&self) -> Arc<ModelSurface> {
        self.surface.clone()
    }

    fn set_sources(&mut self, sources: Arc<Sources>) -> Result<()> {
        self.ready = None;
        debug_assert!(
            sources.layer_textures == self.skirts.own_textures(&self.sources),
            "texels on the device go by layer textures"
        );
        let surface = ModelSurface::from_model(&self.site_model).with_backs(&self.site_model, &sources);
        let skirts = match self.texels {
            Some(_) => Skirts::new(&self.site_model, &sources, &surface),
            None => Skirts::none(&self.site_model, &sources),
        };
        let model = skirts.model.facing(&Facing { eye: DVec3::ZERO, right: DVec3::X });
        let (surfaces, tables) = self.gpu.guarded("preparing the renderer", || {
            let sources = &skirts.sources;
            let surfaces = ModelBuffers::new(&self.gpu, &model, sources, surface.sides(), &skirts);
            Ok((surfaces, Tables::new(&self.gpu, &model, sources)))
        })?;
        (self.surfaces, self.tables, self.model) = (surfaces, tables, model);
        (self.sources, self.skirts) = (skirts.sources.clone(), skirts);
        self.surface = surface.into();
        self.forget_shadows();
        self.forget_drawn_trees();
        self.pins = self.sources.servers.iter().any(|server| server.pinned);
        Ok(())
    }

    fn set_gains(&mut self, gains: Gains) -> Result<()> {
        self.ready = None;
        if !Arc::ptr_eq(&gains.surroundings, &self.gains.surroundings) {
            let gpu = self.gpu.clone();
            self.sky = gpu.guarded("preparing the sky", || Ok(SkyFactors::new(&gpu, &gains.surroundings)))?;
        }
        self.gains = gains;
        Ok(())
    }

    fn set_relief(&mut self, relief: &Relief) -> Result<()> {
        self.ready = None;
        self.forget_drawn_trees();
        let origin = self.surfaces.origin();
        let gpu = self.gpu.clone();
        let mut grids = self.grids.clone();
        gpu.guarded("preparing the relief", || {
            grids.set_relief(&gpu, relief, origin);
            Ok(())
        })?;
        self.grids = grids;
        Ok(())
    }

    fn set_continuation(&mut self, continuation: Continuation) -> Result<()> {
        self.ready = None;
        let (gpu, origin) = (self.gpu.clone(), self.surfaces.origin());
        let mut grids = self.grids.clone();
        gpu.guarded("preparing what continues", || {
            grids.set_continuation(&gpu, &continuation, origin);
            Ok(())
        })?;
        self.grids = grids;
        self.continued_mean = (!continuation.of_face.is_empty()).then_some(continuation.mean);
        Ok(())
    }

    fn set_agreement(&mut self, agreement: Agreement) -> Result<()> {
        self.ready = None;
        let layer_textures = self.sources.layer_textures.len();
        let present = self.gpu.guarded("preparing the photos' agreement", || {
            Ok(AgreementTexture::new(&self.gpu, agreement, layer_textures))
        })?;
        let before = std::mem::replace(&mut self.agreement, present);
        let (before, present) = (&before.agreement, &self.agreement.agreement);
        let grids =
            |agreement: &'_ Agreement, of| (agreement.of(of).cloned(), agreement.outline_of(of).cloned());
        let changed = self.skirts.textures_of(|of| grids(before, of) != grids(present, of));
        self.renew_skirts(&changed)
    }

    fn renew_agreement(&mut self, agreement: &Agreement, changed: &[LayerTextureId]) -> Result<()> {
        self.ready = None;
        match self.agreement.renew(&self.gpu, agreement, changed) {
            true => {
                let changed = self.skirts.textures_of(|of| changed.contains(&of));
                self.renew_skirts(&changed)
            }
            false => self.set_agreement(agreement.clone()),
        }
    }

    fn renew(&mut self, texels: Arc<dyn Texels>, changed: &[LayerTextureId], task: &Task) -> Result<usize> {
        self.ready = None;
        let all = self.skirts.texels(texels.clone(), &self.agreement.agreement);
        self.texels = self.texels.as_ref().map(|_| texels);
        let mut changed = changed.to_vec();
        let of_skirts = self.skirts.textures_of(|of| changed.contains(&of));
        changed.extend(of_skirts);
        Ok(self.tiles.renew(all, &changed, task)?.layer_textures)
    }

    fn set_origins(&mut self, origins: Option<Arc<dyn Texels>>) -> Result<()> {
        self.ready = None;
        let tiles = self.tiles.options();
        let options = TextureOptions { budget_bytes: tiles.budget_bytes / ORIGINS_SHARE, ..tiles };
        let store = |texels| {
            let texels = self.skirts.texels(texels, &self.agreement.agreement);
            TileStore::new(&self.gpu, &self.sources, texels, options)
        };
        self.origins = origins.map(store).transpose()?;
        Ok(())
    }

    fn has_origins(&self) -> bool {
        self.origins.is_some()
    }

    fn peels(&mut self) -> Option<&mut dyn Peels> {
        Some(self)
    }

    fn unreadable(&self) -> usize {
        self.tiles.unreadable().len()
    }

    fn statistics(&self) -> String {
        format!("{}; {}", self.tiles.statistics(), self.agreement.statistics())
    }
}

impl Renderer {
    /// Reads these textures of skirts again, whose mattes follow the agreement of photos.
    fn renew_skirts(&mut self, changed: &[LayerTextureId]) -> Result<()> {
        let Some(texels) = self.texels.clone().filter(|_| !changed.is_empty()) else { return Ok(()) };
        let texels = self.skirts.texels(texels, &self.agreement.agreement);
        self.tiles.renew(texels, changed, &Task::silent()).map(drop)
    }
}
