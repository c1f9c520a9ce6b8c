//! Texels of pages, with padding and the map of what is known.

use super::layout::{Layout, Page, PlacedChart};
use super::options::BakedOptions;
use super::painter::Painter;
use super::report::Coverage;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::geometry::drawn::enclosed;
use quadratura_base::task::Task;
use quadratura_handover::atlas::pad::carry_outwards;
use quadratura_handover::atlas::{CELL, GUTTER};
use quadratura_handover::textured::{PageKind, TexturePage, WrittenFile, encoded};
use quadratura_view::{DisplayMode, Picture};
use quadratura_views::known::Known;

use super::camera::texel_of;

/// Texels of the page per texel of the map of what is known, along a side.
const KNOWN_STEP: u32 = 4;

/// The colour of what no photo shows, where it is not filled.
const GREY: [u8; 4] = [128, 128, 128, 255];

/// Returns the grey level of what is known in the map.
fn grey(known: Known) -> u8 {
    match known {
        Known::Photographed => 255,
        Known::Filled => 170,
        Known::Inpainted => 85,
        Known::Nothing => 0,
    }
}

/// Returns the number of texels that show this.
fn number_of(coverage: &mut Coverage, known: Known) -> &mut f64 {
    match known {
        Known::Photographed => &mut coverage.photographed,
        Known::Filled => &mut coverage.filled,
        Known::Inpainted => &mut coverage.inpainted,
        Known::Nothing => &mut coverage.nothing,
    }
}

/// A page with its map of what is known.
pub(super) struct BakedPage {
    pub texture: TexturePage,
    pub known: WrittenFile,
    /// The numbers of texels in the map.
    pub coverage: Coverage,
}

impl BakedPage {
    /// Draws all charts of a page.
    pub fn new(
        layout: &Layout,
        number: usize,
        painter: &mut Painter,
        options: &BakedOptions,
        task: &Task,
    ) -> Result<Self> {
        let page = &layout.pages[number];
        let before = layout.charts.iter().filter(|placed| placed.page < number).count() as u64;
        let charts = || (before..).zip(layout.charts.iter().filter(|placed| placed.page == number));
        let kind = match (page.see_through, options.png) {
            (true, _) => PageKind::PngWithAlpha,
            (false, true) => PageKind::Png,
            (false, false) => PageKind::Jpeg,
        };
        let mut filled = PageTexels::new(page, 1, kind);
        let mut known = PageTexels::new(page, KNOWN_STEP, PageKind::Grey);
        let mut coverage = Coverage::default();
        for (done, placed) in charts() {
            task.step("bake charts", done, layout.charts.len() as u64)?;
            filled.put(placed, colours(placed, painter, page.see_through, task)?.pixels());
            known.put(placed, &knowledge(placed, painter, &mut coverage, task)?);
        }
        let texture = TexturePage {
            file: format!("{}{}", page.stem, kind.ending()),
            kind,
            tile: page.tile,
            bytes: filled.encoded(),
        };
        let known = WrittenFile { name: format!("{}.png", page.known), bytes: known.encoded() };
        Ok(Self { texture, known, coverage })
    }
}

/// Returns the texels of a chart's cell.
fn colours(placed: &PlacedChart, painter: &mut Painter, see_through: bool, task: &Task) -> Result<Picture> {
    let [density, gutter] = [placed.density, f64::from(GUTTER)];
    let mut picture = painter.paint(placed, [density, gutter], placed.cell, DisplayMode::Colour, task)?;
    let texels = picture.rgba.as_chunks_mut::<4>().0;
    let width = placed.cell[0] as usize;
    if see_through {
        // Colours are carried to where one sees through, and alpha is not.
        let alphas: Vec<u8> = texels.iter().map(|texel| texel[3]).collect();
        let mut known: Vec<bool> = alphas.iter().map(|alpha| *alpha > 0).collect();
        carry_outwards(texels, &mut known, width);
        texels.iter_mut().zip(alphas).for_each(|(texel, alpha)| texel[3] = alpha);
        return Ok(picture);
    }
    let mut known: Vec<bool> = texels.iter().map(|texel| texel[3] > 0).collect();
    let is_empty = !known.contains(&true);
    if painter.holes || is_empty {
        for at in inside(placed, painter, [density, gutter], placed.cell) {
            if !known[at] {
                (texels[at], known[at]) = (GREY, true);
            }
        }
    }
    carry_outwards(texels, &mut known, width);
    Ok(picture)
}

/// Returns the grey levels of a chart's cell in the map of what is known, and counts them.
fn knowledge(
    placed: &PlacedChart,
    painter: &mut Painter,
    coverage: &mut Coverage,
    task: &Task,
) -> Result<Vec<[u8; 4]>> {
    let step = f64::from(KNOWN_STEP);
    let scale = [placed.density / step, f64::from(GUTTER) / step];
    let cell = placed.cell.map(|side| side / KNOWN_STEP);
    let picture = painter.paint(placed, scale, cell, DisplayMode::Provenance, task)?;
    let texels = picture.pixels();
    let mut greys = vec![[0; 4]; texels.len()];
    let mut within = vec![false; texels.len()];
    for at in inside(placed, painter, scale, cell) {
        let known = Known::of_colour(texels[at]);
        *number_of(coverage, known) += 1.0;
        (greys[at], within[at]) = ([grey(known); 4], true);
    }
    carry_outwards(&mut greys, &mut within, cell[0] as usize);
    Ok(greys)
}

/// Returns the indices of the texels of a cell whose centres are within the faces of its chart.
fn inside(
    placed: &PlacedChart,
    painter: &Painter,
    [density, gutter]: [f64; 2],
    [width, height]: [u32; 2],
) -> Vec<usize> {
    let rect = PixelRect::of_size(width, height);
    let of_part = |&part: &usize| {
        let ring = &painter.parts.faces[part].ring;
        let line: Vec<_> =
            ring.iter().map(|&point| texel_of(&placed.chart, density, point) + gutter).collect();
        enclosed(&line, rect)
    };
    let spans = placed.chart.faces.iter().map(of_part).reduce(|a, b| a.union(&b));
    let runs =
        spans.iter().flat_map(|spans| spans.iter().map(|(y, run)| (y, run.clone())).collect::<Vec<_>>());
    runs.flat_map(|(y, run)| run.map(move |x| rect.offset(x, y))).collect()
}

/// The texels of a page while it is filled.
struct PageTexels {
    kind: PageKind,
    /// Texels of the page per texel, along a side.
    step: u32,
    size: [u32; 2],
    texels: Vec<u8>,
    /// Which squares of a cell's grid hold a chart, row by row.
    used: Vec<bool>,
}

impl PageTexels {
    fn new(page: &Page, step: u32, kind: PageKind) -> Self {
        let size = page.size.map(|side| side / step);
        let texels = vec![0; size[0] as usize * size[1] as usize * kind.channels()];
        let squares = page.size.map(|side| (side / CELL) as usize);
        Self { kind, step, size, texels, used: vec![false; squares[0] * squares[1]] }
    }

    /// Puts the texels of a cell to its place.
    fn put(&mut self, placed: &PlacedChart, texels: &[[u8; 4]]) {
        let [at, cell] = [placed.at, placed.cell].map(|sides| sides.map(|side| (side / self.step) as usize));
        for (row, texels) in texels.chunks(cell[0]).enumerate() {
            let start = self.offset(at[0], at[1] + row);
            let channels = self.kind.channels();
            let target = self.texels[start..start + cell[0] * channels].chunks_mut(channels);
            target.zip(texels).for_each(|(target, texel)| target.copy_from_slice(&texel[..channels]));
        }
        let squares = self.squares_of_row();
        let [at, cell] = [placed.at, placed.cell].map(|sides| sides.map(|side| (side / CELL) as usize));
        for row in at[1]..at[1] + cell[1] {
            self.used[row * squares + at[0]..][..cell[0]].fill(true);
        }
    }

    fn squares_of_row(&self) -> usize {
        (self.size[0] * self.step / CELL) as usize
    }

    fn offset(&self, x: usize, y: usize) -> usize {
        (y * self.size[0] as usize + x) * self.kind.channels()
    }

    /// Fills what no cell uses with the colours of the nearest cells, so that coarse mip levels are not darkened, and encodes the page.
    fn encoded(mut self) -> Vec<u8> {
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
