//! Loading of layer textures to the device: decode, cut and write, one batch after the other.

use std::collections::BTreeSet;

use rayon::prelude::*;
use rustc_hash::FxHashMap;
use wgpu::PollType;

use super::{Loaded, Shortage, TileStore};
use crate::pyramids::{DecodedPyramids, MadePyramid};
use crate::tile_atlas::{SlotStrip, place};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_projection::LayerTextureId;
use quadratura_projection::pyramid::Pyramid;
use quadratura_projection::residency::TileRequest;
use quadratura_projection::tiles::{SLOT, TileKey};

/// The number of rows of slots that are cut at once, 0.6 MB each.
const BATCH_STRIPS: usize = 64;
/// The share of texels decoded from which the total number of tiles is extrapolated.
const ENOUGH_SEEN: f64 = 0.2;

/// The progress of a load.
#[derive(Debug, Clone, Copy)]
struct LoadProgress {
    /// The number of tiles uploaded.
    tiles: usize,
    /// The share of the new layer textures that is decoded, including those being uploaded now.
    share: f64,
}

impl LoadProgress {
    /// Estimates the number of tiles of the complete load, assuming that the remaining layer textures are like the
    /// decoded ones.
    fn of_all(&self, tiles_now: usize) -> f64 {
        (self.tiles + tiles_now) as f64 / self.share
    }
}

impl TileStore {
    /// Uploads the requested tiles that are not resident.
    pub(super) fn load_absent(
        &mut self,
        wants: &[TileRequest],
        shortage: Shortage,
        loaded: &mut Loaded,
        task: &Task,
    ) -> Result<()> {
        // Resident tiles that are requested must not be evicted for new ones.
        self.residency.choose(wants, self.most_slots);
        self.load_unknown(wants, loaded, task)?;
        let (mut chosen, wanted) = self.residency.choose(wants, self.most_slots);
        self.make_room(chosen.len())?;
        if chosen.len() > self.residency.capacity() as usize {
            (chosen, _) = self.residency.choose(wants, self.residency.capacity());
        }
        loaded.left_out = wanted - chosen.len();
        if loaded.left_out > 0 && shortage == Shortage::Refused {
            return Ok(());
        }
        self.load_missing(&chosen, loaded, task)
    }

    /// Decodes layer textures that were never decoded, and uploads their tiles as long as there is room: usually
    /// there is room for all of them, and nothing is decoded twice. While one batch is uploaded, the next is
    /// decoded.
    fn load_unknown(&mut self, wants: &[TileRequest], loaded: &mut Loaded, task: &Task) -> Result<()> {
        let is_new = |layer_texture: &LayerTextureId| self.residency.occupancy(*layer_texture).is_none();
        let unknown: BTreeSet<LayerTextureId> =
            wants.iter().map(|want| want.layer_texture).filter(is_new).collect();
        if unknown.is_empty() {
            return Ok(());
        }
        let texels: u64 = unknown.iter().map(|layer_texture| self.pyramids.area(*layer_texture)).sum();
        let (mut decoded, mut seen) = (DecodedPyramids::default(), 0);
        for batch in self.pyramids.batches(unknown).into_iter().chain([Vec::new()]) {
            task.step("load layers", seen, texels)?;
            self.give_up(&decoded.failed, task);
            loaded.layer_textures += decoded.made.len();
            let failed = decoded.failed.iter().map(|(layer_texture, _)| layer_texture);
            let all = decoded.made.iter().map(|(layer_texture, _)| layer_texture).chain(failed);
            seen += all.map(|layer_texture| self.pyramids.area(*layer_texture)).sum::<u64>();
            let maker = self.pyramids.maker();
            let progress = LoadProgress { tiles: loaded.tiles, share: seen as f64 / texels as f64 };
            let (brought, next) = rayon::join(
                || self.bring_new(wants, &decoded.made, progress),
                || maker.decode_all(&batch, task),
            );
            loaded.tiles += brought?;
            decoded = next?;
        }
        Ok(())
    }

    /// Uploads tiles of layer textures that were just decoded.
    fn bring_new(
        &mut self,
        wants: &[TileRequest],
        decoded: &[MadePyramid],
        progress: LoadProgress,
    ) -> Result<usize> {
        if decoded.is_empty() {
            return Ok(0);
        }
        decoded.iter().for_each(|(layer_texture, pyramid)| self.learn(*layer_texture, pyramid));
        let keys = self.tiles_that_fit(wants, decoded, progress);
        let slots = self.residency.len() + keys.len();
        if slots > self.residency.capacity() as usize {
            // Growing copies everything, so it is done seldom: as soon as the total can be extrapolated,
            // directly to that size.
            let extrapolated = (1.03 * progress.of_all(keys.len())) as usize
                + self.residency.len().saturating_sub(progress.tiles);
            self.make_room(if progress.share < ENOUGH_SEEN { 2 * slots } else { extrapolated })?;
        }
        let brought = self.bring(&keys, decoded)?;
        self.pyramids.keep(decoded);
        Ok(brought)
    }

    /// Selects the tiles to upload of layer textures that were just decoded: all of them if all layer textures will
    /// probably fit, because decoding takes longer than writing; otherwise the requested ones, as coarse as necessary
    /// to fit.
    fn tiles_that_fit(
        &self,
        wants: &[TileRequest],
        decoded: &[MadePyramid],
        progress: LoadProgress,
    ) -> Vec<TileKey> {
        let fits = |keys: &[TileKey]| progress.of_all(keys.len()) <= f64::from(self.most_slots);
        let all: Vec<TileRequest> =
            decoded.iter().map(|(layer_texture, _)| TileRequest::all(*layer_texture)).collect();
        let is_own = |want: &&TileRequest| {
            decoded.iter().any(|(layer_texture, _)| *layer_texture == want.layer_texture)
        };
        let own: Vec<TileRequest> = wants.iter().filter(is_own).copied().collect();
        let mut keys = self.residency.union(&all, 0);
        for coarser in 0..self.residency.most_levels() {
            if fits(&keys) {
                break;
            }
            keys = self.residency.union(&own, coarser);
        }
        keys
    }

    /// Uploads those of the chosen tiles that are not resident.
    fn load_missing(&mut self, chosen: &[TileKey], loaded: &mut Loaded, task: &Task) -> Result<()> {
        let is_missing = |key: &&TileKey| self.residency.slot(**key).is_none();
        let missing: Vec<TileKey> = chosen.iter().filter(is_missing).copied().collect();
        let layer_textures: BTreeSet<LayerTextureId> = missing.iter().map(|key| key.layer_texture).collect();
        for batch in self.pyramids.batches(layer_textures) {
            task.check_cancelled()?;
            let (DecodedPyramids { made: pyramids, failed }, decoded) = self.pyramids.get(&batch, task)?;
            self.give_up(&failed, task);
            loaded.layer_textures += decoded;
            let is_own = |key: &&TileKey| {
                pyramids.iter().any(|(layer_texture, _)| *layer_texture == key.layer_texture)
            };
            let own: Vec<TileKey> = missing.iter().filter(is_own).copied().collect();
            self.make_room(self.residency.len() + own.len())?;
            loaded.tiles += self.bring(&own, &pyramids)?;
            loaded.tiles += self.bring_rest(&pyramids)?;
        }
        Ok(())
    }

    /// Marks layer textures that cannot be read as empty from now on.
    pub(super) fn give_up(&mut self, failed: &[(LayerTextureId, Error)], task: &Task) {
        for (layer_texture, error) in failed {
            let nothing = self.pyramids.maker().of_nothing(*layer_texture);
            self.learn(*layer_texture, &nothing);
            // A matte is in the file of its layer.
            if self.mattes.source(*layer_texture).is_none() {
                task.note(format!("an image layer is not used: {error}"));
                self.unreadable.insert(*layer_texture);
            }
        }
    }

    /// Uploads the other tiles of decoded layer textures, too, if no tile has to be evicted for them.
    fn bring_rest(&mut self, pyramids: &[MadePyramid]) -> Result<usize> {
        let all: Vec<TileRequest> =
            pyramids.iter().map(|(layer_texture, _)| TileRequest::all(*layer_texture)).collect();
        let mut rest = self.residency.union(&all, 0);
        rest.retain(|key| self.residency.slot(*key).is_none());
        let slots = self.residency.len() + rest.len();
        if slots > self.most_slots as usize {
            return Ok(0);
        }
        self.make_room(slots)?;
        rest.truncate(self.residency.capacity() as usize - self.residency.len());
        self.bring(&rest, pyramids)
    }

    /// Assigns slots to tiles and writes them; tiles without a slot are left out.
    fn bring(&mut self, keys: &[TileKey], pyramids: &[MadePyramid]) -> Result<usize> {
        let entered = self.residency.enter(keys);
        self.upload(entered, pyramids)
    }

    /// Cuts tiles and writes them into their slots.
    pub(super) fn upload(&mut self, mut slots: Vec<(TileKey, u32)>, of: &[MadePyramid]) -> Result<usize> {
        slots.sort_unstable_by_key(|(_, slot)| *slot);
        let pyramids: FxHashMap<LayerTextureId, &Pyramid> =
            of.iter().map(|(layer_texture, p)| (*layer_texture, &**p)).collect();
        let storage = self.atlas.storage();
        let cut = |strip: &[(TileKey, u32)]| {
            let texels = cut_strip(strip, |key| pyramids[&key.layer_texture]);
            SlotStrip::new(strip[0].1, strip.len() as u32, texels, storage)
        };
        let neighbours =
            |a: &(TileKey, u32), b: &(TileKey, u32)| a.1 + 1 == b.1 && place(a.1)[1..] == place(b.1)[1..];
        let strips: Vec<&[(TileKey, u32)]> = slots.chunk_by(neighbours).collect();
        for some in strips.chunks(BATCH_STRIPS) {
            let cut: Vec<SlotStrip> = some.par_iter().map(|strip| cut(strip)).collect();
            cut.iter().for_each(|strip| self.atlas.write(strip));
            self.flush()?;
        }
        Ok(slots.len())
    }

    /// Submits what was written, with at most two batches in flight, because each is kept in memory until it
    /// is done.
    fn flush(&mut self) -> Result<()> {
        let submitted = self.gpu.queue.submit([]);
        if let Some(before) = self.uploading.replace(submitted) {
            let wait = PollType::Wait { submission_index: Some(before), timeout: None };
            self.gpu.device.poll(wait).map_err(|error| Error::Gpu(format!("writing textures: {error}")))?;
        }
        Ok(())
    }
}

/// Cuts the texels of adjacent slots of a row of a page: 68 rows.
fn cut_strip<'a>(slots: &[(TileKey, u32)], pyramid_of: impl Fn(TileKey) -> &'a Pyramid) -> Vec<u8> {
    let slot_bytes = 4 * SLOT as usize;
    let row_bytes = slots.len() * slot_bytes;
    let mut texels = vec![0; SLOT as usize * row_bytes];
    for (i, (key, _)) in slots.iter().enumerate() {
        pyramid_of(*key).cut(*key, &mut texels[i * slot_bytes..], row_bytes);
    }
    texels
}
