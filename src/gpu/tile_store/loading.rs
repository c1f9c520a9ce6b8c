//! From sheets to the device: decode, cut, write, one batch after the other.

use std::collections::BTreeSet;

use rayon::prelude::*;
use rustc_hash::FxHashMap;
use wgpu::PollType;

use super::{Loaded, TileStore};
use crate::error::{Error, Result};
use crate::gpu::atlas::{Strip, place};
use crate::gpu::pyramids::Made;
use crate::projection::SheetId;
use crate::projection::pyramid::Pyramid;
use crate::projection::residency::Want;
use crate::projection::tiles::{SLOT, TileKey};
use crate::task::Task;

/// Rows of slots that are cut at once: 0.6 MB each.
const BATCH_STRIPS: usize = 64;
/// From what share of the texels the rest is foretold.
const ENOUGH_SEEN: f64 = 0.2;

impl TileStore {
    /// Decodes sheets that were never seen, and brings their tiles to the device as long as there is room:
    /// usually there is for all of them, and nothing is decoded twice. While one batch goes to the device
    /// the next is decoded.
    pub(super) fn load_unknown(&mut self, wants: &[Want], loaded: &mut Loaded, task: &Task) -> Result<()> {
        let is_new = |sheet: &SheetId| self.residency.occupancy(*sheet).is_none();
        let unknown: BTreeSet<SheetId> = wants.iter().map(|want| want.sheet).filter(is_new).collect();
        let texels: u64 = unknown.iter().map(|sheet| self.pyramids.area(*sheet)).sum();
        let (mut decoded, mut seen) = (Vec::new(), 0);
        for batch in self.pyramids.batches(unknown).into_iter().chain([Vec::new()]) {
            task.step("load layers", seen, texels)?;
            loaded.sheets += decoded.len();
            seen += decoded.iter().map(|(sheet, _)| self.pyramids.area(*sheet)).sum::<u64>();
            let maker = self.pyramids.maker();
            let share = seen as f64 / texels as f64;
            let (brought, next) =
                rayon::join(|| self.bring_new(wants, &decoded, share), || maker.make_all(&batch));
            loaded.tiles += brought?;
            decoded = next?;
        }
        Ok(())
    }

    /// Brings sheets that were just decoded. `seen`: which share of all that are to come these and those
    /// before them are.
    fn bring_new(&mut self, wants: &[Want], decoded: &[Made], seen: f64) -> Result<usize> {
        if decoded.is_empty() {
            return Ok(0);
        }
        decoded.iter().for_each(|(sheet, pyramid)| self.learn(*sheet, pyramid));
        let is_own = |want: &&Want| decoded.iter().any(|(sheet, _)| *sheet == want.sheet);
        let own: Vec<Want> = wants.iter().filter(is_own).copied().collect();
        let mut keys = self.residency.union(&own, 0);
        // Where it will not all fit, finer levels are left out from the start.
        let tails = own.len();
        let expected = |keys: &[TileKey]| (keys.len() as f64 / seen) as usize;
        for coarser in 1..self.residency.most_levels() {
            if expected(&keys) <= self.most_slots as usize || keys.len() <= tails {
                break;
            }
            keys = self.residency.union(&own, coarser);
        }
        let slots = self.residency.len() + keys.len();
        // Growing copies everything: seldom, and once what is to come can be foretold, to what it will be.
        let foreseen = if seen < ENOUGH_SEEN { 2 * slots } else { (1.03 * slots as f64 / seen) as usize };
        if slots > self.residency.capacity() as usize {
            self.make_room(foreseen)?;
        }
        let brought = self.bring(&keys, decoded)?;
        self.pyramids.keep(decoded);
        Ok(brought)
    }

    /// Brings those of the chosen tiles that are not there.
    pub(super) fn load_missing(
        &mut self,
        chosen: &[TileKey],
        loaded: &mut Loaded,
        task: &Task,
    ) -> Result<()> {
        let is_missing = |key: &&TileKey| self.residency.slot(**key).is_none();
        let missing: Vec<TileKey> = chosen.iter().filter(is_missing).copied().collect();
        let sheets: BTreeSet<SheetId> = missing.iter().map(|key| key.sheet).collect();
        for batch in self.pyramids.batches(sheets) {
            task.go_on()?;
            let (pyramids, decoded) = self.pyramids.get(&batch)?;
            loaded.sheets += decoded;
            let is_own = |key: &&TileKey| pyramids.iter().any(|(sheet, _)| *sheet == key.sheet);
            let own: Vec<TileKey> = missing.iter().filter(is_own).copied().collect();
            loaded.tiles += self.bring(&own, &pyramids)?;
        }
        Ok(())
    }

    /// Gives tiles slots and writes them there; those that find no room stay away.
    fn bring(&mut self, keys: &[TileKey], pyramids: &[Made]) -> Result<usize> {
        let entered = self.residency.enter(keys);
        self.upload(entered, pyramids)
    }

    /// Cuts tiles and writes them into their slots.
    pub(super) fn upload(&mut self, mut slots: Vec<(TileKey, u32)>, of: &[Made]) -> Result<usize> {
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
