//! Texture memory: layer textures are decoded, cut into tiles and uploaded as far as a view needs them and the budget
//! allows; coarser levels replace tiles that do not fit.

mod loading;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{DVec2, IVec2};
use wgpu::{Buffer, SubmissionIndex, TextureView};

use super::device::Gpu;
use super::pyramids::{DecodedPyramids, Pyramids};
use super::texture_statistics::TextureStatistics;
use super::tile_atlas::TileAtlas;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::task::Task;
use quadratura_projection::cells::TexelBounds;
use quadratura_projection::least_confidence::LeastConfidence;
use quadratura_projection::mattes::MatteTextures;
use quadratura_projection::pyramid::Pyramid;
use quadratura_projection::residency::{Residency, TileRequest};
use quadratura_projection::tiles::Occupancy;
use quadratura_projection::{
    LayerTextureId, LayerTexturePixels, Server, Sources, Storage, Texels, TextureOptions,
};

/// The result of a load.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Loaded {
    /// The number of tiles uploaded.
    pub tiles: usize,
    /// The number of layer textures decoded.
    pub layer_textures: usize,
    /// The number of tiles that did not fit; coarser ones are used instead.
    pub left_out: usize,
}

/// What becomes of requests that the budget does not hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shortage {
    /// Coarser levels take the place of what does not fit.
    Coarser,
    /// They are refused.
    Refused,
}

/// The layer textures' tiles on the device.
pub struct TileStore {
    gpu: Gpu,
    options: TextureOptions,
    pyramids: Pyramids,
    /// The textures of mattes, which are loaded with their layer textures.
    mattes: MatteTextures,
    residency: Residency,
    atlas: TileAtlas,
    /// Per decoded layer texture, the number of texels that faces cover, and the number of texels with content.
    texels_of: Vec<[u64; 2]>,
    /// Lower bounds of confidence per layer texture, known from when it was decoded.
    least: Vec<LeastConfidence>,
    /// The corner of each layer texture in its photo, in pixels.
    corners: Vec<IVec2>,
    /// True when texels are stored uncompressed.
    exact: bool,
    /// The largest number of slots: the budget's, or fewer where the device ran out of memory.
    most_slots: u32,
    generation: u64,
    /// Sheets whose files could not be read; they texture nothing.
    unreadable: BTreeSet<LayerTextureId>,
    /// The last requests, and the number of tiles left out of them.
    settled: (Vec<TileRequest>, usize),
    uploading: Option<SubmissionIndex>,
}

/// The least number of slots worth having, that of one page.
const LEAST_SLOTS: u32 = 1024;

impl TileStore {
    /// Returns the limits that the store was created with.
    pub fn options(&self) -> TextureOptions {
        self.options
    }

    /// Creates a store without tiles: layer textures texture nothing until [`Self::load`] was called for them.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`] when the device cannot hold the page tables.
    pub fn new(
        gpu: &Gpu,
        sources: &Sources,
        texels: Arc<dyn Texels>,
        options: TextureOptions,
    ) -> Result<Self> {
        let mattes = MatteTextures::new(&sources.layer_textures);
        let of_colours = sources.layer_textures.iter().map(|layer_texture| layer_texture.rect);
        let of_mattes = mattes.iter().map(|(layer_texture, _)| sources.layer_texture(layer_texture).rect);
        let rects: Vec<PixelRect> = of_colours.chain(of_mattes).collect();
        let residency = Residency::new(rects.iter().copied()).with_mattes(&mattes);
        let budget = u32::try_from(options.budget_bytes / options.storage.slot_bytes()).unwrap_or(u32::MAX);
        Ok(Self {
            atlas: TileAtlas::new(gpu, &residency, options.storage)?,
            gpu: gpu.clone(),
            options,
            texels_of: vec![[0; 2]; rects.len()],
            least: vec![LeastConfidence::default(); rects.len()],
            corners: rects.iter().map(|rect| IVec2::new(rect.x, rect.y)).collect(),
            exact: options.storage == Storage::default(),
            most_slots: budget.clamp(1, TileAtlas::most_slots(gpu)),
            pyramids: Pyramids::new(texels, rects, mattes.clone(), &options),
            mattes,
            residency,
            generation: 0,
            unreadable: BTreeSet::new(),
            settled: Default::default(),
            uploading: None,
        })
    }

    /// Returns the view for the binding `atlas`: an array of pages. It is another one after each change of
    /// [`Self::generation`].
    pub fn atlas(&self) -> &TextureView {
        self.atlas.view()
    }

    /// Returns the same as [`Self::atlas`], with colours read as stored, in sRGB.
    pub fn stored_atlas(&self) -> &TextureView {
        self.atlas.stored_view()
    }

    /// Returns the buffer for the binding `pages`: the page tables.
    pub fn pages(&self) -> &Buffer {
        self.atlas.pages()
    }

    /// Returns the buffer for the binding `layer_textures`: the positions of each layer texture's page tables.
    pub fn layer_textures(&self) -> &Buffer {
        self.atlas.layer_textures()
    }

    /// Returns a number that changes when [`Self::atlas`] does; bindings have to be made anew then.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Loads everything of every layer texture, as far as the budget allows.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn load_all(&mut self, task: &Task) -> Result<Loaded> {
        let wants: Vec<TileRequest> =
            (0..self.pyramids.rects().len() as u32).map(|i| TileRequest::all(LayerTextureId(i))).collect();
        self.load(&wants, task)
    }

    /// Uploads the tiles that a view needs; the tiles not needed for the longest time are evicted. Where the
    /// budget does not hold all, every layer texture becomes coarser by the same number of levels. A layer texture that
    /// cannot be read textures nothing from then on, and a note says so; see [`Self::unreadable`].
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`]; tiles loaded until then remain. [`quadratura_base::Error::Gpu`] when the device has
    /// no memory at all; where it has less than the budget, less is resident.
    pub fn load(&mut self, wants: &[TileRequest], task: &Task) -> Result<Loaded> {
        self.load_as(wants, Shortage::Coarser, task)
    }

    /// As [`Self::load`], but where the budget does not hold all, nothing is there to be drawn with: [`Loaded::left_out`] says
    /// that less has to be asked for. What was decoded to know that is remembered.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn load_if_it_fits(&mut self, wants: &[TileRequest], task: &Task) -> Result<Loaded> {
        self.load_as(wants, Shortage::Refused, task)
    }

    fn load_as(&mut self, wants: &[TileRequest], shortage: Shortage, task: &Task) -> Result<Loaded> {
        let wants = self.mattes.and_requests(wants);
        let wants = &*wants;
        if wants == self.settled.0 {
            return Ok(Loaded { left_out: self.settled.1, ..Loaded::default() });
        }
        let mut loaded = Loaded::default();
        if !self.residency.is_resident(wants) {
            let result = self.load_absent(wants, shortage, &mut loaded, task);
            self.write_tables();
            result?;
        }
        let is_refused = shortage == Shortage::Refused && loaded.left_out > 0;
        self.settled = (if is_refused { Vec::new() } else { wants.to_vec() }, loaded.left_out);
        Ok(loaded)
    }

    /// Returns whether a layer texture was decoded before, so that bounds of its confidence are known.
    pub fn is_decoded(&self, layer_texture: LayerTextureId) -> bool {
        self.residency.occupancy(layer_texture).is_some()
    }

    /// Returns whether all layer textures of these requests were decoded before.
    pub fn has_decoded(&self, wants: &[TileRequest]) -> bool {
        wants.iter().all(|want| self.is_decoded(want.layer_texture))
    }

    /// Returns whether all of these texels are on the device.
    pub fn holds(&self, wants: &[TileRequest]) -> bool {
        self.residency.holds(&self.mattes.and_requests(wants))
    }

    /// Replaces a layer texture's pixels. Of the tiles on the device only those that differ are written. Tiles that
    /// become necessary by this come with the next [`Self::load`].
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`].
    pub fn replace_texture(
        &mut self,
        layer_texture: LayerTextureId,
        pixels: &LayerTexturePixels,
    ) -> Result<Loaded> {
        let mut loaded = Loaded::default();
        for texture in &*self.mattes.and_mattes(&[layer_texture]) {
            let new = self.pyramids.maker().of_pixels(*texture, pixels);
            loaded.tiles += self.replace(*texture, new)?.tiles;
        }
        self.write_tables();
        Ok(Loaded { layer_textures: 1, ..loaded })
    }

    /// Reads layer textures from `texels` from now on, of which those in `changed` have other contents than before.
    /// Those of them that were decoded are decoded again at once, and their differences are written to the
    /// device; gains, relief and all other layer textures remain.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`]; [`quadratura_base::Error::Cancelled`], after which layer textures may show their old contents.
    pub fn renew(
        &mut self,
        texels: Arc<dyn Texels>,
        changed: &[LayerTextureId],
        task: &Task,
    ) -> Result<Loaded> {
        self.pyramids.read_from(texels);
        let is_known = |layer_texture: &&LayerTextureId| self.residency.occupancy(**layer_texture).is_some();
        let known = self.mattes.and_mattes(changed).iter().filter(is_known).copied().collect();
        let mut loaded = Loaded::default();
        for batch in self.pyramids.batches(known) {
            let DecodedPyramids { made, failed } = self.pyramids.maker().decode_all(&batch, task)?;
            self.give_up(&failed, task);
            for (layer_texture, new) in made {
                let one = self.replace(layer_texture, new)?;
                loaded.tiles += one.tiles;
                loaded.layer_textures += one.layer_textures;
            }
        }
        self.settled.0.clear();
        self.write_tables();
        Ok(loaded)
    }

    fn replace(&mut self, layer_texture: LayerTextureId, new: Arc<Pyramid>) -> Result<Loaded> {
        let old = self.pyramids.cached(layer_texture);
        self.unreadable.remove(&layer_texture);
        self.learn(layer_texture, &new);
        self.settled.0.clear();
        let mut changed = self.residency.resident_of(layer_texture);
        if let Some(old) = old {
            changed.retain(|key| !new.same_tile(&old, *key));
        }
        let slots = changed.iter().filter_map(|key| Some((*key, self.residency.slot(*key)?))).collect();
        let made = [(layer_texture, new)];
        let loaded = Loaded { tiles: self.upload(slots, &made)?, layer_textures: 1, left_out: 0 };
        self.pyramids.keep(&made);
        Ok(loaded)
    }

    /// Returns the layer textures whose files could not be read when they were needed.
    pub fn unreadable(&self) -> &BTreeSet<LayerTextureId> {
        &self.unreadable
    }

    /// Returns the statistics of texture memory.
    pub fn statistics(&self) -> TextureStatistics {
        let mut sum = TextureStatistics { bytes: self.atlas.bytes(), ..TextureStatistics::default() };
        for (layer_texture, rect) in (0..).map(LayerTextureId).zip(self.pyramids.rects()) {
            let Some(occupancy) = self.residency.occupancy(layer_texture) else { continue };
            sum.add(
                rect,
                &self.residency.shape(layer_texture),
                occupancy,
                self.texels_of[layer_texture.0 as usize],
            );
        }
        sum.resident_tiles = self.residency.len() as u64;
        sum
    }

    fn learn(&mut self, layer_texture: LayerTextureId, pyramid: &Pyramid) {
        self.residency.learn(layer_texture, Occupancy::from_pyramid(pyramid));
        let content = pyramid.levels.first().map_or(0, |level| level.content.count());
        self.texels_of[layer_texture.0 as usize] = [pyramid.covered, content];
        self.least[layer_texture.0 as usize] = LeastConfidence::from_pyramid(pyramid);
    }

    /// Makes room for this many tiles, as far as the budget and the device allow.
    fn make_room(&mut self, slots: usize) -> Result<()> {
        let wanted = u32::try_from(slots).unwrap_or(u32::MAX).min(self.most_slots);
        if wanted <= self.residency.capacity() {
            return Ok(());
        }
        match self.atlas.grow(wanted) {
            Ok(new) => {
                let room = self.most_slots - self.residency.capacity();
                self.generation += 1;
                self.residency.grow(new.into_iter().flatten().take(room as usize));
                Ok(())
            }
            // The device has less memory than the budget, so the present slots have to suffice.
            Err(_) if self.residency.capacity() > 0 => {
                self.most_slots = self.residency.capacity();
                Ok(())
            }
            Err(error) if wanted <= LEAST_SLOTS => Err(error),
            Err(_) => self.make_room(slots.min(wanted as usize) / 2),
        }
    }

    fn write_tables(&mut self) {
        for range in self.residency.write_entries() {
            self.atlas.write_entries(self.residency.entries(), range);
        }
    }
}

impl TexelBounds for TileStore {
    /// The bound is known for decoded layer textures, as long as all requested tiles are on the device: coarser tiles
    /// in place of finer ones average over larger areas.
    fn least(&self, server: &Server, low_px: DVec2, high_px: DVec2) -> f64 {
        if self.settled.1 > 0 || !self.exact || !low_px.is_finite() || !high_px.is_finite() {
            return 0.0;
        }
        let layer_texture = server.layer_texture.0 as usize;
        let low = low_px.floor().as_ivec2() - self.corners[layer_texture];
        let high = high_px.ceil().as_ivec2() - self.corners[layer_texture];
        self.least[layer_texture].within(PixelRect::from_edges(low.x, low.y, high.x, high.y))
    }
}
