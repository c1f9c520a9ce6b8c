//! The division of layer textures for texture memory: levels, tiles, slots, and the tail that small levels share.
//!
//! A layer texture of `w x h` texels (powers of two) has levels `0, 1, ...` of `max(1, w >> l) x max(1, h >> l)`,
//! down to one texel. A level is cut into tiles of 64 x 64 texels from the layer texture's own corner. A tile
//! occupies a *slot* of 68 x 68 texels: the tile and two texels of its neighbours on every side, so that
//! filtering never leaves the slot. Levels of at most 32 texels share one slot, the layer texture's *tail*.

use super::pyramid::{Level, Pyramid};
use crate::LayerTextureId;
use quadratura_base::geometry::PixelRect;

/// Side of a tile, in texels.
pub const TILE: u32 = 64;
/// Texels of the neighbouring tiles on each side of a slot.
pub const GUTTER: u32 = 2;
/// Side of a slot, in texels: a multiple of 4, as compressed texture blocks require.
pub const SLOT: u32 = TILE + 2 * GUTTER;
/// The longer side, in texels, of the largest level that lies in the tail.
pub const TAIL: u32 = 32;
/// The largest number of levels: enough for layer textures of up to 32768 texels a side.
pub const MOST_LEVELS: usize = 16;

/// The position of each level of the tail in its slot, gutters included, at the binary logarithm of the
/// level's longer side.
pub const TAIL_SPOTS: [[u32; 2]; 6] = [[36, 32], [56, 20], [48, 20], [36, 20], [36, 0], [0, 0]];

/// The step, in texels, by which layer textures are moved: the same texels then form a texel of the next level
/// wherever the layer texture lies, for the five finest levels.
const STEP: i32 = 16;

/// Moves the rectangle of an image layer (photo pixels) so that its needed part lies in as few tiles as
/// possible; the position before was chosen for painting. A gutter's width remains around the needed part, as
/// far as it existed.
pub fn in_few_tiles(rect: PixelRect, needed: PixelRect) -> PixelRect {
    if needed.is_empty() || needed.intersection(&rect) != needed {
        return rect;
    }
    let x = rect.x + moved([rect.x, rect.right()], [needed.x, needed.right()]);
    let y = rect.y + moved([rect.y, rect.bottom()], [needed.y, needed.bottom()]);
    PixelRect { x, y, ..rect }
}

/// Returns the movement along one axis, from first and one past the last pixel of the rectangle and of the
/// needed part.
fn moved([low, high]: [i32; 2], needed: [i32; 2]) -> i32 {
    let gutter = GUTTER as i32;
    let (before, after) = (needed[0] - low, high - needed[1]);
    let tiles = |by: i32| {
        let tile = |at: i32| (at - low - by).clamp(0, high - low - 1) / TILE as i32;
        // Content next to a tile makes the tile occupied, too.
        tile(needed[1]) - tile(needed[0] - 1)
    };
    let most = (before - gutter).max(0) / STEP;
    let least = -((after - gutter).max(0) / STEP);
    (least..=most).rev().map(|steps| steps * STEP).min_by_key(|by| tiles(*by)).unwrap_or(0)
}

/// The key of a tile, or of the tail, which is the tile 0, 0 of its first level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TileKey {
    /// The layer texture.
    pub layer_texture: LayerTextureId,
    /// The level of detail; 0 is the layer texture itself.
    pub level: u32,
    /// Column of the tile, from the left.
    pub x: u32,
    /// Row of the tile, from the top.
    pub y: u32,
}

/// The size of a layer texture, from which the sizes of levels and tiles follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TextureShape {
    /// Binary logarithms of width and height in texels.
    pub log: [u32; 2],
}

impl TextureShape {
    /// Computes the shape of a rectangle; sides that are no powers of two are rounded up to one.
    pub fn from_rect(rect: PixelRect) -> Self {
        let log = |side: u32| (side.max(1).next_power_of_two().ilog2()).min(MOST_LEVELS as u32 - 1);
        Self { log: [log(rect.w), log(rect.h)] }
    }

    /// Returns the number of levels.
    pub fn levels(&self) -> u32 {
        self.log[0].max(self.log[1]) + 1
    }

    /// Returns the size of a level in texels.
    pub fn size(&self, level: u32) -> [u32; 2] {
        self.log.map(|log| 1 << log.saturating_sub(level))
    }

    /// Returns the number of columns and rows of tiles of a level.
    pub fn tiles(&self, level: u32) -> [u32; 2] {
        self.size(level).map(|side| side.div_ceil(TILE))
    }

    /// Returns the first level in the tail; there is always one.
    pub fn tail(&self) -> u32 {
        self.levels() - 1 - (TAIL.ilog2()).min(self.levels() - 1)
    }

    /// Returns the number of entries of the layer texture's page table: the tiles of all levels.
    pub fn entries(&self) -> u32 {
        (0..self.levels()).map(|level| self.tiles(level)).map(|[x, y]| x * y).sum()
    }

    /// Returns whether the next level is narrower, and whether it is lower.
    pub fn halves(&self, level: u32) -> [bool; 2] {
        self.log.map(|log| log > level)
    }
}

/// The tiles of a layer texture that hold content.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Occupancy {
    shape: TextureShape,
    /// The tiles of each level before the tail, in row order.
    tiles: Vec<Vec<bool>>,
    /// The number of occupied tiles of each of these levels.
    counts: Vec<u64>,
    /// True when the tail, and so the layer texture, holds content.
    any: bool,
}

impl Occupancy {
    /// Finds the occupied tiles: those with content in them or next to them, where a filtered lookup reaches
    /// it.
    pub fn from_pyramid(pyramid: &Pyramid) -> Self {
        let shape = pyramid.shape;
        let paged = pyramid.levels.iter().zip(0..shape.tail());
        let tiles: Vec<Vec<bool>> = paged.map(|(level, l)| occupied(level, shape.tiles(l))).collect();
        let counts = tiles.iter().map(|tiles| tiles.iter().filter(|held| **held).count() as u64).collect();
        Self {
            shape,
            tiles,
            counts,
            any: pyramid.levels.first().is_some_and(|level| !level.content.is_empty()),
        }
    }

    /// Returns true when the tile (or the tail) is occupied.
    pub fn holds(&self, level: u32, x: u32, y: u32) -> bool {
        match self.tiles.get(level as usize) {
            Some(tiles) => tiles[(y * self.shape.tiles(level)[0] + x) as usize],
            None => self.any,
        }
    }

    /// Returns the number of occupied tiles of all levels, the tail counting as one.
    pub fn total(&self) -> u64 {
        (0..=self.shape.tail()).map(|level| self.count(level)).sum()
    }

    /// Iterates over the occupied tiles of a level that is not in the tail, as (column, row).
    pub fn tiles(&self, level: u32) -> impl Iterator<Item = [u32; 2]> {
        let columns = self.shape.tiles(level)[0];
        let tiles = self.tiles.get(level as usize).map_or(&[][..], Vec::as_slice);
        (0u32..).zip(tiles).filter(|(_, held)| **held).map(move |(i, _)| [i % columns, i / columns])
    }

    /// Returns the number of occupied tiles of a level; 1 or 0 for the tail.
    pub fn count(&self, level: u32) -> u64 {
        match self.counts.get(level as usize) {
            Some(count) => *count,
            None => u64::from(self.any && level == self.shape.tail()),
        }
    }
}

fn occupied(level: &Level, [columns, rows]: [u32; 2]) -> Vec<bool> {
    let mut held = vec![false; (columns * rows) as usize];
    let tile = TILE as i32;
    for (y, run) in level.content.iter() {
        let across = ((run.start - 1).div_euclid(tile)).max(0)..=(run.end / tile).min(columns as i32 - 1);
        let down = ((y - 1).div_euclid(tile)).max(0)..=((y + 1) / tile).min(rows as i32 - 1);
        for row in down {
            for column in across.clone() {
                held[(row as u32 * columns + column as u32) as usize] = true;
            }
        }
    }
    held
}

impl Pyramid {
    /// Writes the slot of a tile or of the tail: 68 rows of 68 texels, 4 bytes each, `row_bytes` apart.
    /// Texels that the layer texture does not have are 0.
    pub fn cut(&self, key: TileKey, slot: &mut [u8], row_bytes: usize) {
        if key.level < self.shape.tail() {
            let corner = [key.x, key.y].map(|tile| (tile * TILE) as i32 - GUTTER as i32);
            copy(&self.levels[key.level as usize], corner, [SLOT; 2], slot, row_bytes);
            return;
        }
        for row in slot.chunks_mut(row_bytes).take(SLOT as usize) {
            row[..SLOT as usize * 4].fill(0);
        }
        for (level, l) in self.levels.iter().zip(0..).skip(self.shape.tail() as usize) {
            let size = self.shape.size(l);
            let [x, y] = TAIL_SPOTS[size[0].max(size[1]).ilog2() as usize];
            let part = &mut slot[y as usize * row_bytes + x as usize * 4..];
            copy(level, [-(GUTTER as i32); 2], size.map(|side| side + 2 * GUTTER), part, row_bytes);
        }
    }

    /// Returns true when the slot of a tile (or of the tail) is the same in `other`, a pyramid of the same
    /// layer texture.
    pub fn same_tile(&self, other: &Self, key: TileKey) -> bool {
        let tail = self.shape.tail();
        if key.level < tail {
            let level = key.level as usize;
            let corner = [key.x, key.y].map(|tile| (tile * TILE) as i32 - GUTTER as i32);
            return same(&self.levels[level], &other.levels[level], corner, [SLOT; 2]);
        }
        let mut levels = self.levels.iter().zip(&other.levels).zip(0..).skip(tail as usize);
        levels.all(|((a, b), level)| {
            let size = self.shape.size(level).map(|side| side + 2 * GUTTER);
            same(a, b, [-(GUTTER as i32); 2], size)
        })
    }
}

/// Returns true when two levels are equal over `size` texels from `corner` on.
fn same(a: &Level, b: &Level, corner: [i32; 2], size: [u32; 2]) -> bool {
    let bytes = 4 * size[0] as usize;
    let mut rows = [vec![0; bytes], vec![0; bytes]];
    (corner[1]..corner[1] + size[1] as i32).all(|y| {
        copy(a, [corner[0], y], [size[0], 1], &mut rows[0], bytes);
        copy(b, [corner[0], y], [size[0], 1], &mut rows[1], bytes);
        rows[0] == rows[1]
    })
}

/// Copies `size` texels of a level from `corner` on; texels outside of the level are 0.
fn copy(level: &Level, corner: [i32; 2], size: [u32; 2], to: &mut [u8], row_bytes: usize) {
    let wanted = PixelRect { x: corner[0], y: corner[1], w: size[0], h: size[1] };
    let there = wanted.intersection(&level.rect);
    let before = 4 * (there.x - wanted.x) as usize;
    let bytes = 4 * there.w as usize;
    for (y, row) in (wanted.y..wanted.bottom()).zip(to.chunks_mut(row_bytes)) {
        let row = &mut row[..4 * size[0] as usize];
        if there.is_empty() || !(there.y..there.bottom()).contains(&y) {
            row.fill(0);
            continue;
        }
        let from = level.index(there.x, y);
        row[..before].fill(0);
        row[before..before + bytes].copy_from_slice(&level.rgba[from..from + bytes]);
        row[before + bytes..].fill(0);
    }
}

#[cfg(test)]
mod tests;
