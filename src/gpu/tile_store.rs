//! Texture memory: sheets are decoded, cut into tiles and brought to the device as far as a view needs
//! them and a budget allows; what does not fit is served by coarser levels.

use std::collections::BTreeSet;
use std::sync::Arc;

use rayon::prelude::*;
use rustc_hash::FxHashMap;
use wgpu::{Buffer, PollType, SubmissionIndex, TextureView};

use super::atlas::{Atlas, SLOT_BYTES, Strip, place};
use super::device::Gpu;
use super::pyramid_cache::PyramidCache;
use super::texture_statistics::TextureStatistics;
use crate::error::{Error, Result};
use crate::geometry::PixelRect;
use crate::projection::pyramid::{Pyramid, PyramidOptions, pyramid};
use crate::projection::residency::{Residency, Want};
use crate::projection::tiles::{Occupancy, SLOT, TileKey};
use crate::projection::{SheetId, SheetPixels, Sources, Texels};
use crate::task::Task;

/// Texture memory's limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextureOptions {
    /// Bytes of texels on the device, at most.
    pub budget_bytes: u64,
    /// Bytes of decoded sheets kept in the program's own memory, at most.
    pub cache_bytes: u64,
    /// How levels and confidence are made.
    pub pyramid: PyramidOptions,
}

impl Default for TextureOptions {
    fn default() -> Self {
        Self { budget_bytes: 4 << 30, cache_bytes: 256 << 20, pyramid: PyramidOptions::default() }
    }
}

/// What a load came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Loaded {
    /// Tiles that were brought to the device.
    pub tiles: usize,
    /// Sheets that were decoded.
    pub sheets: usize,
    /// Tiles that there was no room for: coarser ones serve.
    pub left_out: usize,
}

/// The sheets' tiles on the device.
pub struct TileStore {
    gpu: Gpu,
    texels: Arc<dyn Texels>,
    rects: Vec<PixelRect>,
    options: TextureOptions,
    residency: Residency,
    atlas: Atlas,
    cache: PyramidCache,
    /// Texels that faces cover and that hold something, per sheet that was decoded.
    texels_of: Vec<[u64; 2]>,
    /// No more slots than this: the budget's, or fewer where the device had no memory for them.
    most_slots: u32,
    generation: u64,
    uploading: Option<SubmissionIndex>,
}

/// Texels of sheets that are decoded at once: bounds the memory for it.
const BATCH_TEXELS: u64 = 48 << 20;
/// Rows of slots that are cut at once: 0.6 MB each.
const BATCH_STRIPS: usize = 64;
/// With fewer slots than a page has there is nothing to be seen.
const LEAST_SLOTS: u32 = 1024;

impl TileStore {
    /// Nothing is loaded yet: sheets serve nothing until [`Self::load`] was asked for them.
    ///
    /// # Errors
    /// [`Error::Gpu`] when the device cannot hold the page tables.
    pub fn new(
        gpu: &Gpu,
        sources: &Sources,
        texels: Arc<dyn Texels>,
        options: TextureOptions,
    ) -> Result<Self> {
        let rects: Vec<_> = sources.sheets.iter().map(|sheet| sheet.rect).collect();
        let residency = Residency::new(rects.iter().copied());
        let budget = u32::try_from(options.budget_bytes / SLOT_BYTES).unwrap_or(u32::MAX);
        Ok(Self {
            atlas: Atlas::new(gpu, &residency)?,
            gpu: gpu.clone(),
            texels,
            texels_of: vec![[0; 2]; rects.len()],
            cache: PyramidCache::new(options.cache_bytes),
            most_slots: budget.clamp(1, Atlas::most_slots(gpu)),
            rects,
            options,
            residency,
            generation: 0,
            uploading: None,
        })
    }

    /// For `atlas`: an array of pages. Another one after each change of [`Self::generation`].
    pub fn atlas(&self) -> &TextureView {
        self.atlas.view()
    }

    /// For `pages`: the page tables.
    pub fn pages(&self) -> &Buffer {
        self.atlas.pages()
    }

    /// For `sheets`: per sheet where its page tables are.
    pub fn sheets(&self) -> &Buffer {
        self.atlas.sheets()
    }

    /// Changes when [`Self::atlas`] does: bindings have to be made anew then.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Everything of every sheet, as far as the budget allows.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn load_all(&mut self, task: &Task) -> Result<Loaded> {
        let wants: Vec<Want> = (0..self.rects.len() as u32).map(|i| Want::all(SheetId(i))).collect();
        self.load(&wants, task)
    }

    /// Brings what a view needs to the device; what was not wanted for the longest time leaves. Where the
    /// budget does not hold it all, every sheet gets coarser by the same number of levels.
    ///
    /// # Errors
    /// [`Error::Input`] and [`Error::Io`] for sheets that cannot be read, [`Error::Cancelled`]; what was
    /// loaded until then stays. [`Error::Gpu`] when the device has no memory at all; where it has less
    /// than the budget, less is resident.
    pub fn load(&mut self, wants: &[Want], task: &Task) -> Result<Loaded> {
        let mut loaded = Loaded::default();
        // What is there and wanted must not leave for what comes.
        self.residency.choose(wants, self.most_slots);
        let result = self.load_unknown(wants, &mut loaded, task).and_then(|()| {
            let wanted = self.residency.union(wants, 0).len();
            self.make_room(wanted)?;
            let chosen = self.residency.choose(wants, self.residency.capacity());
            loaded.left_out = wanted - chosen.len();
            self.load_missing(&chosen, &mut loaded, task)
        });
        self.write_tables();
        result.map(|()| loaded)
    }

    /// Another picture for a sheet, or what its files hold now. Of the tiles on the device only those that
    /// differ are written. Tiles that are needed only now come with the next [`Self::load`].
    ///
    /// # Errors
    /// None but the device's.
    pub fn replace_sheet(&mut self, sheet: SheetId, pixels: &SheetPixels) -> Result<Loaded> {
        let new = Arc::new(pyramid(self.rects[sheet.0 as usize], pixels, &self.options.pyramid));
        let old = self.cache.get(sheet);
        self.learn(sheet, &new);
        let mut changed = self.residency.resident_of(sheet);
        if let Some(old) = old {
            changed.retain(|key| !new.same_tile(&old, *key));
        }
        let slots = changed.iter().filter_map(|key| Some((*key, self.residency.slot(*key)?))).collect();
        let loaded = Loaded { tiles: self.upload(slots, &[(sheet, new.clone())])?, sheets: 1, left_out: 0 };
        self.cache.keep(sheet, new);
        self.write_tables();
        Ok(loaded)
    }

    /// What texture memory holds, and what it costs.
    pub fn statistics(&self) -> TextureStatistics {
        let mut sum = TextureStatistics { bytes: self.atlas.bytes(), ..TextureStatistics::default() };
        for (sheet, rect) in (0..).map(SheetId).zip(&self.rects) {
            let Some(occupancy) = self.residency.occupancy(sheet) else { continue };
            sum.add(rect, &self.residency.shape(sheet), occupancy, self.texels_of[sheet.0 as usize]);
        }
        sum.resident_tiles = self.residency.len() as u64;
        sum
    }

    /// Decodes sheets that were never seen, and brings their tiles to the device as long as there is room:
    /// usually there is for all of them, and nothing is decoded twice.
    fn load_unknown(&mut self, wants: &[Want], loaded: &mut Loaded, task: &Task) -> Result<()> {
        let is_new = |sheet: &SheetId| self.residency.occupancy(*sheet).is_none();
        let unknown: BTreeSet<SheetId> = wants.iter().map(|want| want.sheet).filter(is_new).collect();
        let texels: u64 = unknown.iter().map(|sheet| self.area(*sheet)).sum();
        let mut seen = 0;
        for batch in self.batches(unknown) {
            task.step("load layers", seen, texels)?;
            let pyramids = self.decode(&batch)?;
            seen += batch.iter().map(|sheet| self.area(*sheet)).sum::<u64>();
            loaded.sheets += batch.len();
            let own: Vec<Want> = wants.iter().filter(|want| batch.contains(&want.sheet)).copied().collect();
            let keys = self.residency.union(&own, 0);
            // As much room as all will need if the rest is like what was seen: growing copies everything.
            let expected = (self.residency.len() + keys.len()) as f64 * (texels as f64 / seen as f64);
            self.make_room((1.05 * expected) as usize)?;
            loaded.tiles += self.bring(&keys, &pyramids)?;
        }
        task.step("load layers", texels, texels)
    }

    /// Brings those of the chosen tiles that are not there.
    fn load_missing(&mut self, chosen: &[TileKey], loaded: &mut Loaded, task: &Task) -> Result<()> {
        let missing: Vec<TileKey> =
            chosen.iter().filter(|key| self.residency.slot(**key).is_none()).copied().collect();
        let sheets: BTreeSet<SheetId> = missing.iter().map(|key| key.sheet).collect();
        for batch in self.batches(sheets) {
            task.go_on()?;
            let pyramids = self.decode(&batch)?;
            loaded.sheets += batch.len();
            let own: Vec<TileKey> =
                missing.iter().filter(|key| batch.contains(&key.sheet)).copied().collect();
            loaded.tiles += self.bring(&own, &pyramids)?;
        }
        Ok(())
    }

    /// Sheets that are decoded at the same time, within a bound on memory.
    fn batches(&self, sheets: BTreeSet<SheetId>) -> Vec<Vec<SheetId>> {
        let mut batches: Vec<Vec<SheetId>> = Vec::new();
        let mut room = 0;
        for sheet in sheets {
            let texels = self.area(sheet);
            if texels > room || batches.is_empty() {
                batches.push(Vec::new());
                room = BATCH_TEXELS;
            }
            room = room.saturating_sub(texels);
            batches.last_mut().into_iter().for_each(|batch| batch.push(sheet));
        }
        batches
    }

    fn area(&self, sheet: SheetId) -> u64 {
        self.rects[sheet.0 as usize].area()
    }

    /// The pyramids of sheets, from the cache or from their files, in parallel.
    fn decode(&mut self, sheets: &[SheetId]) -> Result<Vec<(SheetId, Arc<Pyramid>)>> {
        let cached: Vec<_> = sheets.iter().map(|sheet| (*sheet, self.cache.get(*sheet))).collect();
        let (rects, texels, options) = (&self.rects, &self.texels, &self.options.pyramid);
        let decoded: Result<Vec<_>> = cached
            .into_par_iter()
            .map(|(sheet, cached)| match cached {
                Some(pyramid) => Ok((sheet, pyramid)),
                None => {
                    let pixels = texels.sheet(sheet)?;
                    Ok((sheet, Arc::new(pyramid(rects[sheet.0 as usize], &pixels, options))))
                }
            })
            .collect();
        let decoded = decoded?;
        for (sheet, pyramid) in &decoded {
            if self.residency.occupancy(*sheet).is_none() {
                self.learn(*sheet, pyramid);
            }
            self.cache.keep(*sheet, pyramid.clone());
        }
        Ok(decoded)
    }

    fn learn(&mut self, sheet: SheetId, pyramid: &Pyramid) {
        self.residency.learn(sheet, Occupancy::of(pyramid));
        let content = pyramid.levels.first().map_or(0, |level| level.content.count());
        self.texels_of[sheet.0 as usize] = [pyramid.covered, content];
    }

    /// Gives tiles slots and writes them there; those that find no room stay away.
    fn bring(&mut self, keys: &[TileKey], pyramids: &[(SheetId, Arc<Pyramid>)]) -> Result<usize> {
        let entered = self.residency.enter(keys);
        self.upload(entered, pyramids)
    }

    /// Cuts tiles and writes them into their slots.
    fn upload(&mut self, mut slots: Vec<(TileKey, u32)>, of: &[(SheetId, Arc<Pyramid>)]) -> Result<usize> {
        slots.sort_unstable_by_key(|(_, slot)| *slot);
        let pyramids: FxHashMap<SheetId, &Pyramid> = of.iter().map(|(sheet, p)| (*sheet, &**p)).collect();
        let cut = |strip: &[(TileKey, u32)]| cut_strip(strip, |key| pyramids[&key.sheet]);
        let neighbours =
            |a: &(TileKey, u32), b: &(TileKey, u32)| a.1 + 1 == b.1 && place(a.1)[1..] == place(b.1)[1..];
        let strips: Vec<&[(TileKey, u32)]> = slots.chunk_by(neighbours).collect();
        for some in strips.chunks(BATCH_STRIPS) {
            let cut: Vec<Strip> = some.par_iter().map(|strip| cut(strip)).collect();
            cut.iter().for_each(|strip| self.atlas.write(strip));
            self.flush()?;
        }
        Ok(slots.len())
    }

    /// What was written goes its way, at most two batches at a time: each is kept in memory until then.
    fn flush(&mut self) -> Result<()> {
        let submitted = self.gpu.queue.submit([]);
        if let Some(before) = self.uploading.replace(submitted) {
            let wait = PollType::Wait { submission_index: Some(before), timeout: None };
            self.gpu.device.poll(wait).map_err(|error| Error::Gpu(format!("writing textures: {error}")))?;
        }
        Ok(())
    }

    /// Slots for so many tiles, if the budget and the device have them.
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
            // The device has less memory than the budget: what there is has to do.
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

/// Neighbouring slots of a row of a page.
fn cut_strip<'a>(slots: &[(TileKey, u32)], pyramid_of: impl Fn(TileKey) -> &'a Pyramid) -> Strip {
    let first = slots.first().map_or(0, |(_, slot)| *slot);
    let mut strip = Strip::new(first, slots.len() as u32);
    let row_bytes = strip.row_bytes();
    for (i, (key, _)) in slots.iter().enumerate() {
        let begin = i * 4 * SLOT as usize;
        pyramid_of(*key).cut(*key, &mut strip.texels[begin..], row_bytes);
    }
    strip
}

#[cfg(test)]
pub(super) mod tests;
