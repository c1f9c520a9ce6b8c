//! The allocation of texture memory: slots, the page tables in which shaders look tiles up, and the eviction
//! of tiles when memory runs out. This module only keeps the records; `gpu` moves the texels.

use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::ops::Range;

use rustc_hash::{FxHashMap, FxHashSet};

use super::mattes::MatteTextures;
use super::tiles::{MOST_LEVELS, Occupancy, TILE, TextureShape, TileKey};
use crate::LayerTextureId;
use quadratura_base::geometry::PixelRect;

/// The entry of a page table for a tile that is not resident, and for which no coarser tile is.
pub const NOTHING: u32 = u32::MAX;
/// The number of low bits of an entry that hold the slot; the bits above hold the number of levels by which
/// the tile in it is coarser.
pub const SLOT_BITS: u32 = 24;
/// The largest number of slots in a row of a page, and of rows of slots in a page.
pub const PAGE_SLOTS: u32 = 32;

/// A record of the buffer of layer textures (`LayerTexture` of the shaders): the position of a layer texture's page
/// tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct TextureRecord {
    /// Binary logarithms of width and height in texels.
    pub log: [u32; 2],
    /// The number of levels.
    pub levels: u32,
    /// The first level in the tail.
    pub tail: u32,
    /// The texture with its matte; [`NOTHING`] where it has none.
    pub matte: u32,
    /// The index of each level's page table in the buffer of entries; a table has the level's tiles in row
    /// order.
    pub offsets: [u32; MOST_LEVELS],
}

/// A request for the texels of a layer texture that a view needs: of all levels from `finest` on, the tiles in a
/// rectangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileRequest {
    /// The layer texture.
    pub layer_texture: LayerTextureId,
    /// The finest level that is needed.
    pub finest: u32,
    /// The rectangle in texels of level 0, from the layer texture's corner.
    pub rect: PixelRect,
}

impl TileRequest {
    /// Requests all of a layer texture.
    pub fn all(layer_texture: LayerTextureId) -> Self {
        Self::from_level(layer_texture, 0)
    }

    /// Requests all of a layer texture at levels no finer than `finest`.
    pub fn from_level(layer_texture: LayerTextureId, finest: u32) -> Self {
        let side = 1 << (MOST_LEVELS - 1);
        Self { layer_texture, finest, rect: PixelRect::of_size(side, side) }
    }
}

/// The slot of a resident tile, and the time of its last request.
#[derive(Debug, Clone, Copy)]
struct Resident {
    slot: u32,
    wanted: u64,
}

/// The records of slots and page tables.
#[derive(Debug)]
pub struct Residency {
    shapes: Vec<TextureShape>,
    records: Vec<TextureRecord>,
    entries: Vec<u32>,
    /// The occupancy of each layer texture; `None` until the layer texture is decoded, and until then no tile of it is
    /// resident.
    occupancies: Vec<Option<Occupancy>>,
    resident: FxHashMap<TileKey, Resident>,
    /// Per layer texture, the number of its resident tiles, and the time when all of them were last requested
    /// together.
    of_texture: Vec<(u32, u64)>,
    free: BTreeSet<u32>,
    capacity: u32,
    /// The layer textures whose page tables are out of date.
    stale: BTreeSet<LayerTextureId>,
    /// The current time: the number of requests so far.
    now: u64,
}

impl Residency {
    /// Starts without slots and resident tiles; `rects` are the layer textures' rectangles.
    pub fn new(rects: impl IntoIterator<Item = PixelRect>) -> Self {
        let shapes: Vec<TextureShape> = rects.into_iter().map(TextureShape::from_rect).collect();
        let mut next = 0;
        let records = shapes.iter().map(|shape| record(shape, &mut next)).collect();
        Self {
            occupancies: vec![None; shapes.len()],
            of_texture: vec![(0, 0); shapes.len()],
            shapes,
            records,
            entries: vec![NOTHING; next as usize],
            resident: FxHashMap::default(),
            free: BTreeSet::new(),
            capacity: 0,
            stale: BTreeSet::new(),
            now: 0,
        }
    }

    /// Adds which textures are the mattes of which layer textures.
    pub fn with_mattes(mut self, mattes: &MatteTextures) -> Self {
        for (layer_texture, matte) in mattes.iter() {
            self.records[layer_texture.0 as usize].matte = matte.0;
        }
        self
    }

    /// Returns the records of all layer textures.
    pub fn records(&self) -> &[TextureRecord] {
        &self.records
    }

    /// Returns the page tables of all layer textures.
    pub fn entries(&self) -> &[u32] {
        &self.entries
    }

    /// Returns the shape of a layer texture.
    pub fn shape(&self, layer_texture: LayerTextureId) -> TextureShape {
        self.shapes[layer_texture.0 as usize]
    }

    /// Returns the occupancy of a layer texture; `None` until it is decoded.
    pub fn occupancy(&self, layer_texture: LayerTextureId) -> Option<&Occupancy> {
        self.occupancies[layer_texture.0 as usize].as_ref()
    }

    /// Returns the largest number of levels of any layer texture.
    pub fn most_levels(&self) -> u32 {
        self.shapes.iter().map(TextureShape::levels).max().unwrap_or(0)
    }

    /// Returns the number of slots.
    pub fn capacity(&self) -> u32 {
        self.capacity
    }

    /// Returns the number of resident tiles.
    pub fn len(&self) -> usize {
        self.resident.len()
    }

    /// Returns true when no tile is resident.
    pub fn is_empty(&self) -> bool {
        self.resident.is_empty()
    }

    /// Returns the slot of a tile; `None` when it is not resident.
    pub fn slot(&self, key: TileKey) -> Option<u32> {
        self.resident.get(&key).map(|resident_tile| resident_tile.slot)
    }

    /// Adds slots with these numbers.
    pub fn grow(&mut self, slots: impl IntoIterator<Item = u32>) {
        let before = self.free.len();
        self.free.extend(slots);
        self.capacity += (self.free.len() - before) as u32;
    }

    /// Sets the occupancy of a layer texture. Resident tiles that are no longer occupied are evicted.
    pub fn learn(&mut self, layer_texture: LayerTextureId, occupancy: Occupancy) {
        let gone: Vec<TileKey> = self
            .resident
            .keys()
            .filter(|key| key.layer_texture == layer_texture && !occupancy.holds(key.level, key.x, key.y))
            .copied()
            .collect();
        gone.into_iter().for_each(|key| self.evict(key));
        self.occupancies[layer_texture.0 as usize] = Some(occupancy);
        self.stale.insert(layer_texture);
    }

    /// Returns the resident tiles of a layer texture, sorted.
    pub fn resident_of(&self, layer_texture: LayerTextureId) -> Vec<TileKey> {
        let mut keys: Vec<_> =
            self.resident.keys().filter(|key| key.layer_texture == layer_texture).copied().collect();
        keys.sort_unstable();
        keys
    }

    /// Returns the occupied tiles that `want` requests, but `coarser` levels coarser; the tail first.
    pub fn tiles(&self, want: &TileRequest, coarser: u32) -> Vec<TileKey> {
        let (layer_texture, shape) = (want.layer_texture, self.shape(want.layer_texture));
        let Some(occupancy) = self.occupancy(layer_texture) else { return Vec::new() };
        let mut keys = Vec::new();
        if occupancy.holds(shape.tail(), 0, 0) {
            keys.push(TileKey { layer_texture, level: shape.tail(), x: 0, y: 0 });
        }
        for level in (want.finest.saturating_add(coarser)..shape.tail()).rev() {
            let inside = reach(want.rect, level);
            let held =
                occupancy.tiles(level).filter(|&[x, y]| inside[0].contains(&x) && inside[1].contains(&y));
            keys.extend(held.map(|[x, y]| TileKey { layer_texture, level, x, y }));
        }
        keys
    }

    /// Returns true when all requested tiles are resident.
    pub fn holds(&self, wants: &[TileRequest]) -> bool {
        wants.iter().all(|want| {
            self.occupancy(want.layer_texture).is_some_and(|occupancy| {
                let resident = self.of_texture[want.layer_texture.0 as usize].0;
                u64::from(resident) == occupancy.total()
                    || self.tiles(want, 0).iter().all(|key| self.resident.contains_key(key))
            })
        })
    }

    /// Returns true when all requested tiles are resident, and then marks them as requested now. Sheets that
    /// are completely resident are handled at almost no cost, because views ask this for every frame.
    pub fn is_resident(&mut self, wants: &[TileRequest]) -> bool {
        self.now += 1;
        wants.iter().all(|want| self.is_there(want))
    }

    fn is_there(&mut self, want: &TileRequest) -> bool {
        let Some(occupancy) = self.occupancy(want.layer_texture) else { return false };
        let total = occupancy.total();
        let (resident, wanted) = &mut self.of_texture[want.layer_texture.0 as usize];
        if u64::from(*resident) == total {
            *wanted = self.now;
            return true;
        }
        self.tiles(want, 0).iter().all(|key| match self.resident.get_mut(key) {
            Some(resident_tile) => {
                resident_tile.wanted = self.now;
                true
            }
            None => false,
        })
    }

    /// Chooses the requested tiles that fit into `capacity` slots: all requests are made coarser by as many
    /// levels as necessary, and the remaining slots are filled from the next finer step. Coarse tiles come
    /// first; tails are missing only when there are more of them than slots. Also returns the number of tiles
    /// of the complete requests.
    pub fn choose(&mut self, wants: &[TileRequest], capacity: u32) -> (Vec<TileKey>, usize) {
        self.now += 1;
        let mut finer = Vec::new();
        let mut chosen = self.union(wants, 0);
        let wanted = chosen.len();
        for coarser in 1..=MOST_LEVELS as u32 {
            if chosen.len() <= capacity as usize {
                break;
            }
            finer = std::mem::replace(&mut chosen, self.union(wants, coarser));
        }
        let there: FxHashSet<TileKey> = chosen.iter().copied().collect();
        chosen.extend(finer.into_iter().filter(|key| !there.contains(key)));
        chosen.truncate(capacity as usize);
        for key in &chosen {
            self.resident.entry(*key).and_modify(|resident_tile| resident_tile.wanted = self.now);
        }
        (chosen, wanted)
    }

    /// Returns the occupied tiles that the requests cover, each once: the tails first, then by level, coarse
    /// tiles first.
    pub fn union(&self, wants: &[TileRequest], coarser: u32) -> Vec<TileKey> {
        let mut keys: Vec<TileKey> = wants.iter().flat_map(|want| self.tiles(want, coarser)).collect();
        let finest_last =
            |key: &TileKey| (self.shape(key.layer_texture).tail() != key.level, Reverse(key.level), *key);
        keys.sort_unstable_by_key(finest_last);
        keys.dedup();
        keys
    }

    /// Assigns a slot to each of these tiles; the tiles not requested for the longest time are evicted. Tiles
    /// of the last [`Self::choose`] are never evicted. Returns the tiles that got a slot, in their order,
    /// with the slot.
    pub fn enter(&mut self, keys: &[TileKey]) -> Vec<(TileKey, u32)> {
        let missing: Vec<TileKey> = keys.iter().filter(|key| self.slot(**key).is_none()).copied().collect();
        self.make_room(missing.len());
        let mut entered = Vec::with_capacity(missing.len());
        for key in missing {
            let Some(slot) = self.free.pop_first() else { break };
            self.resident.insert(key, Resident { slot, wanted: self.now });
            self.of_texture[key.layer_texture.0 as usize].0 += 1;
            self.stale.insert(key.layer_texture);
            entered.push((key, slot));
        }
        entered
    }

    fn make_room(&mut self, slots: usize) {
        let Some(short) = slots.checked_sub(self.free.len()).filter(|short| *short > 0) else { return };
        let last = |key: &TileKey, resident_tile: &Resident| {
            resident_tile.wanted.max(self.of_texture[key.layer_texture.0 as usize].1)
        };
        let old = self.resident.iter().filter(|(_, resident_tile)| resident_tile.wanted < self.now);
        let mut old: Vec<(u64, TileKey)> =
            old.map(|(key, resident_tile)| (last(key, resident_tile), *key)).collect();
        // Of tiles last requested at the same time, the finest are evicted first.
        old.sort_unstable_by_key(|(wanted, key)| (*wanted, key.level, *key));
        old.into_iter().take(short).for_each(|(_, key)| self.evict(key));
    }

    fn evict(&mut self, key: TileKey) {
        if let Some(resident_tile) = self.resident.remove(&key) {
            self.free.insert(resident_tile.slot);
            self.of_texture[key.layer_texture.0 as usize].0 -= 1;
            self.stale.insert(key.layer_texture);
        }
    }

    /// Brings the page tables up to date. Returns the parts of [`Self::entries`] that changed.
    pub fn write_entries(&mut self) -> Vec<Range<usize>> {
        std::mem::take(&mut self.stale)
            .into_iter()
            .map(|layer_texture| self.write_entries_of(layer_texture))
            .collect()
    }

    /// Writes the page tables of a layer texture: the tile itself, or the nearest coarser one that is resident.
    fn write_entries_of(&mut self, layer_texture: LayerTextureId) -> Range<usize> {
        let (shape, record) = (self.shape(layer_texture), self.records[layer_texture.0 as usize]);
        let range = record.offsets[0] as usize..(record.offsets[0] + shape.entries()) as usize;
        let Some(occupancy) = self.occupancies[layer_texture.0 as usize].take() else { return range };
        let tail = self.slot(TileKey { layer_texture, level: shape.tail(), x: 0, y: 0 }).unwrap_or(NOTHING);
        for level in shape.tail()..shape.levels() {
            self.entries[record.offsets[level as usize] as usize] = tail;
        }
        for level in (0..shape.tail()).rev() {
            let table = record.offsets[level as usize] as usize;
            let columns = shape.tiles(level)[0];
            for (i, entry) in (0..columns * shape.tiles(level)[1]).zip(table..) {
                let key = TileKey { layer_texture, level, x: i % columns, y: i / columns };
                let held = occupancy.holds(level, key.x, key.y);
                self.entries[entry] = if held { self.entry(key, &record, &shape) } else { NOTHING };
            }
        }
        self.occupancies[layer_texture.0 as usize] = Some(occupancy);
        range
    }

    /// Returns the entry of an occupied tile; those of the coarser levels are already written.
    fn entry(&self, key: TileKey, record: &TextureRecord, shape: &TextureShape) -> u32 {
        if let Some(slot) = self.slot(key) {
            return slot;
        }
        let columns = shape.tiles(key.level + 1)[0];
        let parent =
            (key.y / 2).min(shape.tiles(key.level + 1)[1] - 1) * columns + (key.x / 2).min(columns - 1);
        match self.entries[(record.offsets[key.level as usize + 1] + parent) as usize] {
            NOTHING => NOTHING,
            entry => entry + (1 << SLOT_BITS),
        }
    }
}

fn record(shape: &TextureShape, next: &mut u32) -> TextureRecord {
    let mut offsets = [0; MOST_LEVELS];
    for level in 0..shape.levels() {
        offsets[level as usize] = *next;
        let [columns, rows] = shape.tiles(level);
        *next += columns * rows;
    }
    TextureRecord { log: shape.log, levels: shape.levels(), tail: shape.tail(), matte: NOTHING, offsets }
}

/// Returns the columns and rows of tiles of a level that a lookup within the rectangle may reach.
fn reach(rect: PixelRect, level: u32) -> [Range<u32>; 2] {
    let tiles = |from: i32, to: i32| {
        let (from, to) = ((from.max(0) as u32 >> level), (to.max(0) as u32 >> level) + 1);
        from.saturating_sub(1) / TILE..to / TILE + 1
    };
    [tiles(rect.x, rect.right()), tiles(rect.y, rect.bottom())]
}

#[cfg(test)]
mod tests;
