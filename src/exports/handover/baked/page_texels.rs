//! The texels of pages while they are filled, chart by chart.

use super::layout::{Page, PlacedChart};
use quadratura_handover::atlas::CELL;
use quadratura_handover::atlas::pad::{carry_in_place, carry_outwards};
use quadratura_handover::textured::{PageKind, encoded};

/// The texels of a page while it is filled.
pub(super) struct PageTexels {
    kind: PageKind,
    /// Texels of the page per texel, along a side.
    step: u32,
    size: [u32; 2],
    texels: Vec<u8>,
    /// Which squares of a cell's grid hold a chart, row by row.
    used: Vec<bool>,
}

impl PageTexels {
    /// Makes a page without charts, with one texel per `step` of the page along each side.
    pub fn new(page: &Page, step: u32, kind: PageKind) -> Self {
        let size = page.size.map(|side| side / step);
        let texels = vec![0; size[0] as usize * size[1] as usize * kind.channels()];
        let squares = page.size.map(|side| (side / CELL) as usize);
        Self { kind, step, size, texels, used: vec![false; squares[0] * squares[1]] }
    }

    /// Returns the cell of a chart, whose texels are still to come.
    pub fn cell(&mut self, placed: &PlacedChart) -> Cell<'_> {
        let squares = self.squares_of_row();
        let [at, cell] = [placed.at, placed.cell].map(|sides| sides.map(|side| (side / CELL) as usize));
        for row in at[1]..at[1] + cell[1] {
            self.used[row * squares + at[0]..][..cell[0]].fill(true);
        }
        let [at, size] = [placed.at, placed.cell].map(|sides| sides.map(|side| (side / self.step) as usize));
        Cell { page: self, at, size, known: Vec::with_capacity(size[0] * size[1]) }
    }

    fn squares_of_row(&self) -> usize {
        (self.size[0] * self.step / CELL) as usize
    }

    fn offset(&self, x: usize, y: usize) -> usize {
        (y * self.size[0] as usize + x) * self.kind.channels()
    }

    /// Fills what no cell uses with the colours of the nearest cells, so that coarse mip levels are not darkened, and encodes the page.
    pub fn encoded(mut self) -> Vec<u8> {
        let (squares, side) = (self.squares_of_row(), (CELL / self.step) as usize);
        let channels = self.kind.channels();
        let corner = |square: usize| self.offset(square % squares * side, square / squares * side);
        let mut colours: Vec<[u8; 4]> = (0..self.used.len())
            .map(|square| {
                let start = corner(square);
                let mut colour = [0; 4];
                colour[..channels].copy_from_slice(&self.texels[start..start + channels]);
                // Nothing is there.
                colour[3] = 0;
                colour
            })
            .collect();
        let mut known = self.used.clone();
        carry_outwards(&mut colours, &mut known, squares);
        for (square, colour) in colours.iter().enumerate().filter(|(square, _)| !self.used[*square]) {
            for row in 0..side {
                let start = self.offset(square % squares * side, square / squares * side + row);
                let texels = self.texels[start..start + side * channels].chunks_mut(channels);
                texels.for_each(|texel| texel.copy_from_slice(&colour[..channels]));
            }
        }
        encoded(self.kind, &self.texels, self.size)
    }
}

/// A cell of a page while its texels arrive row by row from the top.
pub(super) struct Cell<'a> {
    page: &'a mut PageTexels,
    /// The left and upper edge, in texels of the page.
    at: [usize; 2],
    /// Width and height in texels.
    size: [usize; 2],
    /// Which texels that have arrived have a colour, row by row.
    known: Vec<bool>,
}

impl Cell<'_> {
    /// Adds whole rows below those that are there; `is_known` tells which texels have a colour.
    pub fn add(&mut self, texels: &[[u8; 4]], is_known: impl Fn(&[u8; 4]) -> bool) {
        for row in texels.chunks_exact(self.size[0]) {
            let (channels, start) = (self.page.kind.channels(), self.offset(self.known.len()));
            let target = self.page.texels[start..start + row.len() * channels].chunks_exact_mut(channels);
            target.zip(row).for_each(|(target, texel)| target.copy_from_slice(&texel[..channels]));
            self.known.extend(row.iter().map(&is_known));
        }
    }

    /// Returns whether no texel has a colour.
    pub fn is_empty(&self) -> bool {
        !self.known.contains(&true)
    }

    /// Returns whether the page has alpha.
    pub fn is_see_through(&self) -> bool {
        self.page.kind == PageKind::PngWithAlpha
    }

    /// Gives a texel, by its index in the cell, a colour if it has none.
    pub fn set_unknown(&mut self, at: usize, colour: [u8; 4]) {
        if !std::mem::replace(&mut self.known[at], true) {
            let (channels, start) = (self.page.kind.channels(), self.offset(at));
            self.page.texels[start..start + channels].copy_from_slice(&colour[..channels]);
        }
    }

    /// Carries colours outwards to the texels without one. Alpha stays as it is.
    pub fn carry(mut self) {
        let mut known = std::mem::take(&mut self.known);
        let colours = self.page.kind.channels().min(3);
        carry_in_place(&mut known, self.size[0], |from, to| {
            let [from, to] = [from, to].map(|at| self.offset(at));
            self.page.texels.copy_within(from..from + colours, to);
        });
    }

    /// Returns where a texel of the cell, by its index, begins in the page.
    fn offset(&self, at: usize) -> usize {
        let [x, y] = [at % self.size[0], at / self.size[0]];
        self.page.offset(self.at[0] + x, self.at[1] + y)
    }
}
