//! Which tiles are where in texture memory: slots, the page tables that shaders look them up in, and who
//! has to leave when room runs out. Pure book-keeping; `gpu` moves the texels.

use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::ops::Range;

use rustc_hash::{FxHashMap, FxHashSet};

use super::tiles::{MOST_LEVELS, Occupancy, Shape, TILE, TileKey};
use crate::geometry::PixelRect;
use crate::projection::SheetId;

/// An entry of a page table: nothing is there.
pub const NOTHING: u32 = u32::MAX;
/// Bits of an entry that hold the slot; those above say by how many levels the tile in it is coarser.
pub const SLOT_BITS: u32 = 24;
/// Slots in a row of a page, and rows of slots in a page, at most.
pub const PAGE_SLOTS: u32 = 32;

/// `Sheet` of the shaders: where a sheet's page tables are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SheetRecord {
    /// Binary logarithms of width and height.
    pub log: [u32; 2],
    /// How many levels.
    pub levels: u32,
    /// The first level in the tail.
    pub tail: u32,
    /// Where the table of each level begins in the buffer of entries: its tiles in row order.
    pub offsets: [u32; MOST_LEVELS],
}

/// What a view needs of a sheet: of all levels from one on, the tiles in a rectangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Want {
    /// The sheet.
    pub sheet: SheetId,
    /// The finest level that is needed.
    pub finest: u32,
    /// In texels of level 0, from the sheet's corner.
    pub rect: PixelRect,
}

impl Want {
    /// Everything of a sheet.
    pub fn all(sheet: SheetId) -> Self {
        Self::from_level(sheet, 0)
    }

    /// All of a sheet that is no finer than `finest`.
    pub fn from_level(sheet: SheetId, finest: u32) -> Self {
        let side = 1 << (MOST_LEVELS - 1);
        Self { sheet, finest, rect: PixelRect::of_size(side, side) }
    }
}

/// Where a tile is, and when it was last wanted.
#[derive(Debug, Clone, Copy)]
struct Place {
    slot: u32,
    wanted: u64,
}

/// The book of slots and page tables.
#[derive(Debug)]
pub struct Residency {
    shapes: Vec<Shape>,
    records: Vec<SheetRecord>,
    entries: Vec<u32>,
    /// `None`: not decoded yet, and nothing of it can be resident.
    occupancies: Vec<Option<Occupancy>>,
    resident: FxHashMap<TileKey, Place>,
    /// Per sheet how many of its tiles are resident, and when all of them were last wanted together.
    of_sheet: Vec<(u32, u64)>,
    free: BTreeSet<u32>,
    capacity: u32,
    /// Sheets whose page tables no longer say what is resident.
    stale: BTreeSet<SheetId>,
    /// Counts the calls of [`Self::choose`].
    now: u64,
}

impl Residency {
    /// Nothing is resident, and there are no slots.
    pub fn new(rects: impl IntoIterator<Item = PixelRect>) -> Self {
        let shapes: Vec<Shape> = rects.into_iter().map(Shape::of).collect();
        let mut next = 0;
        let records = shapes.iter().map(|shape| record(shape, &mut next)).collect();
        Self {
            occupancies: vec![None; shapes.len()],
            of_sheet: vec![(0, 0); shapes.len()],
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

    /// One per sheet.
    pub fn records(&self) -> &[SheetRecord] {
        &self.records
    }

    /// The page tables of all sheets.
    pub fn entries(&self) -> &[u32] {
        &self.entries
    }

    /// The sheet's shape.
    pub fn shape(&self, sheet: SheetId) -> Shape {
        self.shapes[sheet.0 as usize]
    }

    /// What the sheet holds, if that is known.
    pub fn occupancy(&self, sheet: SheetId) -> Option<&Occupancy> {
        self.occupancies[sheet.0 as usize].as_ref()
    }

    /// Levels of the sheet that has most.
    pub fn most_levels(&self) -> u32 {
        self.shapes.iter().map(Shape::levels).max().unwrap_or(0)
    }

    /// How many slots there are.
    pub fn capacity(&self) -> u32 {
        self.capacity
    }

    /// How many tiles are resident.
    pub fn len(&self) -> usize {
        self.resident.len()
    }

    /// No tile is resident.
    pub fn is_empty(&self) -> bool {
        self.resident.is_empty()
    }

    /// The slot of a tile.
    pub fn slot(&self, key: TileKey) -> Option<u32> {
        self.resident.get(&key).map(|place| place.slot)
    }

    /// Slots of these numbers are there, too.
    pub fn grow(&mut self, slots: impl IntoIterator<Item = u32>) {
        let before = self.free.len();
        self.free.extend(slots);
        self.capacity += (self.free.len() - before) as u32;
    }

    /// Says what a sheet holds. Tiles that are no longer occupied leave.
    pub fn learn(&mut self, sheet: SheetId, occupancy: Occupancy) {
        let gone: Vec<TileKey> = self
            .resident
            .keys()
            .filter(|key| key.sheet == sheet && !occupancy.holds(key.level, key.x, key.y))
            .copied()
            .collect();
        gone.into_iter().for_each(|key| self.leave(key));
        self.occupancies[sheet.0 as usize] = Some(occupancy);
        self.stale.insert(sheet);
    }

    /// The tiles of a sheet that are resident.
    pub fn resident_of(&self, sheet: SheetId) -> Vec<TileKey> {
        let mut keys: Vec<_> = self.resident.keys().filter(|key| key.sheet == sheet).copied().collect();
        keys.sort_unstable();
        keys
    }

    /// The occupied tiles that `want` asks for, `coarser` levels coarser than it does; the tail first.
    pub fn tiles(&self, want: &Want, coarser: u32) -> Vec<TileKey> {
        let (sheet, shape) = (want.sheet, self.shape(want.sheet));
        let Some(occupancy) = self.occupancy(sheet) else { return Vec::new() };
        let mut keys = Vec::new();
        if occupancy.holds(shape.tail(), 0, 0) {
            keys.push(TileKey { sheet, level: shape.tail(), x: 0, y: 0 });
        }
        for level in (want.finest.saturating_add(coarser)..shape.tail()).rev() {
            let inside = reach(want.rect, level);
            let held =
                occupancy.tiles(level).filter(|&[x, y]| inside[0].contains(&x) && inside[1].contains(&y));
            keys.extend(held.map(|[x, y]| TileKey { sheet, level, x, y }));
        }
        keys
    }

    /// True when all that is wanted is resident; then it counts as wanted just now. Costs next to nothing for
    /// sheets that are there as a whole: views ask this at every frame.
    pub fn all_there(&mut self, wants: &[Want]) -> bool {
        self.now += 1;
        wants.iter().all(|want| self.is_there(want))
    }

    fn is_there(&mut self, want: &Want) -> bool {
        let Some(occupancy) = self.occupancy(want.sheet) else { return false };
        let total = occupancy.total();
        let (resident, wanted) = &mut self.of_sheet[want.sheet.0 as usize];
        if u64::from(*resident) == total {
            *wanted = self.now;
            return true;
        }
        self.tiles(want, 0).iter().all(|key| match self.resident.get_mut(key) {
            Some(place) => {
                place.wanted = self.now;
                true
            }
            None => false,
        })
    }

    /// What of the wants there is room for in `capacity` slots: everything as many levels coarser as has to
    /// be, then, coarse tiles first, what still fits of the next finer step; and how many tiles all of the
    /// wants are. Coarse tiles come first; less than the tails only when there are more of them than slots.
    pub fn choose(&mut self, wants: &[Want], capacity: u32) -> (Vec<TileKey>, usize) {
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
            self.resident.entry(*key).and_modify(|place| place.wanted = self.now);
        }
        (chosen, wanted)
    }

    /// The occupied tiles that the wants ask for, each once, the tails first, then coarse tiles first.
    pub fn union(&self, wants: &[Want], coarser: u32) -> Vec<TileKey> {
        let mut keys: Vec<TileKey> = wants.iter().flat_map(|want| self.tiles(want, coarser)).collect();
        let finest_last =
            |key: &TileKey| (self.shape(key.sheet).tail() != key.level, Reverse(key.level), *key);
        keys.sort_unstable_by_key(finest_last);
        keys.dedup();
        keys
    }

    /// Gives each of these tiles a slot; those that were not wanted for the longest time leave. Tiles of
    /// the last [`Self::choose`] never do. Returns which tiles got one, in their order, with it.
    pub fn enter(&mut self, keys: &[TileKey]) -> Vec<(TileKey, u32)> {
        let missing: Vec<TileKey> = keys.iter().filter(|key| self.slot(**key).is_none()).copied().collect();
        self.make_room(missing.len());
        let mut entered = Vec::with_capacity(missing.len());
        for key in missing {
            let Some(slot) = self.free.pop_first() else { break };
            self.resident.insert(key, Place { slot, wanted: self.now });
            self.of_sheet[key.sheet.0 as usize].0 += 1;
            self.stale.insert(key.sheet);
            entered.push((key, slot));
        }
        entered
    }

    fn make_room(&mut self, slots: usize) {
        let Some(short) = slots.checked_sub(self.free.len()).filter(|short| *short > 0) else { return };
        let last = |key: &TileKey, place: &Place| place.wanted.max(self.of_sheet[key.sheet.0 as usize].1);
        let old = self.resident.iter().filter(|(_, place)| place.wanted < self.now);
        let mut old: Vec<(u64, TileKey)> = old.map(|(key, place)| (last(key, place), *key)).collect();
        // Of those wanted at the same time the finest leave first.
        old.sort_unstable_by_key(|(wanted, key)| (*wanted, key.level, *key));
        old.into_iter().take(short).for_each(|(_, key)| self.leave(key));
    }

    fn leave(&mut self, key: TileKey) {
        if let Some(place) = self.resident.remove(&key) {
            self.free.insert(place.slot);
            self.of_sheet[key.sheet.0 as usize].0 -= 1;
            self.stale.insert(key.sheet);
        }
    }

    /// Brings the page tables up to date. Returns which parts of [`Self::entries`] changed.
    pub fn write_entries(&mut self) -> Vec<Range<usize>> {
        std::mem::take(&mut self.stale).into_iter().map(|sheet| self.write_entries_of(sheet)).collect()
    }

    /// The page tables of a sheet: the tile itself, or the nearest coarser one that is resident.
    fn write_entries_of(&mut self, sheet: SheetId) -> Range<usize> {
        let (shape, record) = (self.shape(sheet), self.records[sheet.0 as usize]);
        let range = record.offsets[0] as usize..(record.offsets[0] + shape.entries()) as usize;
        let Some(occupancy) = self.occupancies[sheet.0 as usize].take() else { return range };
        let tail = self.slot(TileKey { sheet, level: shape.tail(), x: 0, y: 0 }).unwrap_or(NOTHING);
        for level in shape.tail()..shape.levels() {
            self.entries[record.offsets[level as usize] as usize] = tail;
        }
        for level in (0..shape.tail()).rev() {
            let table = record.offsets[level as usize] as usize;
            let columns = shape.tiles(level)[0];
            for (i, entry) in (0..columns * shape.tiles(level)[1]).zip(table..) {
                let key = TileKey { sheet, level, x: i % columns, y: i / columns };
                let held = occupancy.holds(level, key.x, key.y);
                self.entries[entry] = if held { self.entry(key, &record, &shape) } else { NOTHING };
            }
        }
        self.occupancies[sheet.0 as usize] = Some(occupancy);
        range
    }

    /// The entry of an occupied tile, those of the coarser levels being written.
    fn entry(&self, key: TileKey, record: &SheetRecord, shape: &Shape) -> u32 {
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

fn record(shape: &Shape, next: &mut u32) -> SheetRecord {
    let mut offsets = [0; MOST_LEVELS];
    for level in 0..shape.levels() {
        offsets[level as usize] = *next;
        let [columns, rows] = shape.tiles(level);
        *next += columns * rows;
    }
    SheetRecord { log: shape.log, levels: shape.levels(), tail: shape.tail(), offsets }
}

/// The columns and rows of tiles of a level that a lookup within the rectangle may reach.
fn reach(rect: PixelRect, level: u32) -> [Range<u32>; 2] {
    let tiles = |from: i32, to: i32| {
        let (from, to) = ((from.max(0) as u32 >> level), (to.max(0) as u32 >> level) + 1);
        from.saturating_sub(1) / TILE..to / TILE + 1
    };
    [tiles(rect.x, rect.right()), tiles(rect.y, rect.bottom())]
}

#[cfg(test)]
mod tests;
