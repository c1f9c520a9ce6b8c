//! Statistics of texture memory: its size relative to the content that it holds.

use std::fmt;

use quadratura_base::geometry::PixelRect;
use quadratura_projection::tiles::{Occupancy, SLOT, TILE, TextureShape};

/// Counts over the layer textures that were decoded, in texels unless stated otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TextureStatistics {
    /// Texels that faces cover.
    pub covered: u64,
    /// Texels with content: visible, filled or painted.
    pub content: u64,
    /// Texels of the occupied tiles of level 0, without gutters.
    pub level_0: u64,
    /// Texels of the occupied tiles of level 0, with gutters.
    pub level_0_slots: u64,
    /// Texels of the occupied tiles of all levels and the tails, with gutters.
    pub all_slots: u64,
    /// Texels of the layer textures' rectangles with all levels: the size of plain textures.
    pub rectangles: u64,
    /// The number of tiles on the device.
    pub resident_tiles: u64,
    /// The size of the pages on the device, in bytes.
    pub bytes: u64,
}

impl TextureStatistics {
    /// Adds a layer texture.
    pub(super) fn add(
        &mut self,
        rect: &PixelRect,
        shape: &TextureShape,
        occupancy: &Occupancy,
        [covered, content]: [u64; 2],
    ) {
        let (tile, slot) = (u64::from(TILE * TILE), u64::from(SLOT * SLOT));
        let in_tail = shape.tail() == 0;
        self.covered += covered;
        self.content += content;
        self.level_0 += if in_tail { rect.area() } else { occupancy.count(0) * tile };
        self.level_0_slots += occupancy.count(0) * slot;
        self.all_slots += (0..=shape.tail()).map(|level| occupancy.count(level) * slot).sum::<u64>();
        let of_level = |level| shape.size(level).map(u64::from).iter().product::<u64>();
        self.rectangles += (0..shape.levels()).map(of_level).sum::<u64>();
    }
}

impl fmt::Display for TextureStatistics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mega = |texels: u64| texels as f64 / 1e6;
        let share = |texels: u64| texels as f64 / self.content.max(1) as f64;
        write!(
            f,
            "{:.1} M texels with content of {:.1} M covered; tiles {:.2} x content, with gutters {:.2} x, with \
             all levels {:.2} x (rectangles {:.2} x); {} tiles resident in {:.0} MiB",
            mega(self.content),
            mega(self.covered),
            share(self.level_0),
            share(self.level_0_slots),
            share(self.all_slots),
            share(self.rectangles),
            self.resident_tiles,
            self.bytes as f64 / f64::from(1 << 20),
        )
    }
}
