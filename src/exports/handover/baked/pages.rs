//! Texels of pages, with padding and the map of what is known.

use super::layout::{Layout, PlacedChart};
use super::options::BakedOptions;
use super::page_texels::{Cell, PageTexels};
use super::painter::Painter;
use super::report::Coverage;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::geometry::drawn::enclosed;
use quadratura_base::geometry::spans::Spans;
use quadratura_base::task::Task;
use quadratura_handover::atlas::GUTTER;
use quadratura_handover::textured::{PageKind, TexturePage, WrittenFile};
use quadratura_view::DisplayMode;
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
            colours(placed, painter, filled.cell(placed), task)?;
            knowledge(placed, painter, known.cell(placed), &mut coverage, task)?;
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

/// Draws the texels of a chart's cell.
fn colours(placed: &PlacedChart, painter: &mut Painter, mut cell: Cell, task: &Task) -> Result<()> {
    let [density, gutter] = [placed.density, f64::from(GUTTER)];
    let put = |texels: &[[u8; 4]]| cell.add(texels, |texel| texel[3] > 0);
    painter.paint(placed, [density, gutter], placed.cell, DisplayMode::Colour, put, task)?;
    if !cell.is_see_through() && (painter.holes || cell.is_empty()) {
        let spans = inside(placed, painter, [density, gutter], placed.cell);
        texels_of(&spans, placed.cell).for_each(|at| cell.set_unknown(at, GREY));
    }
    cell.carry();
    Ok(())
}

/// Draws the grey levels of a chart's cell in the map of what is known, and counts them.
fn knowledge(
    placed: &PlacedChart,
    painter: &mut Painter,
    mut cell: Cell,
    coverage: &mut Coverage,
    task: &Task,
) -> Result<()> {
    let step = f64::from(KNOWN_STEP);
    let scale = [placed.density / step, f64::from(GUTTER) / step];
    let size = placed.cell.map(|side| side / KNOWN_STEP);
    let mut texels: Vec<[u8; 4]> = Vec::new();
    let put = |drawn: &[[u8; 4]]| texels.extend(drawn);
    painter.paint(placed, scale, size, DisplayMode::Provenance, put, task)?;
    cell.add(&vec![[0; 4]; texels.len()], |_| false);
    for at in texels_of(&inside(placed, painter, scale, size), size) {
        let known = Known::of_colour(texels[at]);
        *number_of(coverage, known) += 1.0;
        cell.set_unknown(at, [grey(known); 4]);
    }
    cell.carry();
    Ok(())
}

/// Returns the texels of a cell whose centres are within the faces of its chart.
fn inside(
    placed: &PlacedChart,
    painter: &Painter,
    [density, gutter]: [f64; 2],
    [width, height]: [u32; 2],
) -> Spans {
    let rect = PixelRect::of_size(width, height);
    let of_part = |&part: &usize| {
        let ring = &painter.parts.faces[part].ring;
        let line: Vec<_> =
            ring.iter().map(|&point| texel_of(&placed.chart, density, point) + gutter).collect();
        enclosed(&line, rect)
    };
    placed.chart.faces.iter().map(of_part).reduce(|a, b| a.union(&b)).unwrap_or_default()
}

/// Returns the indices of texels in a cell of this width and height.
fn texels_of(spans: &Spans, [width, height]: [u32; 2]) -> impl Iterator<Item = usize> {
    let rect = PixelRect::of_size(width, height);
    spans.iter().flat_map(move |(y, run)| run.clone().map(move |x| rect.offset(x, y)))
}
