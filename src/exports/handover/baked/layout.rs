//! Charts with densities, on pages.

use glam::{DVec2, DVec3};

use super::camera::texel_of;
use super::detail::details;
use super::options::{BakedOptions, NAME};
use super::parts::Parts;
use quadratura_base::scene::PhotoId;
use quadratura_handover::atlas::chart::Chart;
use quadratura_handover::atlas::density::{Limits, Wanted, densities};
use quadratura_handover::atlas::pack::pack;
use quadratura_handover::atlas::{CELL, GUTTER, cells_of};
use quadratura_handover::textured::FIRST_UDIM;
use quadratura_projection::Sources;

/// A chart on its page.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlacedChart {
    pub chart: Chart,
    /// Texels per unit.
    pub density: f64,
    pub page: usize,
    /// The cell's left and upper edge, in texels.
    pub at: [u32; 2],
    /// The cell's width and height, in texels.
    pub cell: [u32; 2],
}

/// A page.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Page {
    /// Width and height in texels.
    pub size: [u32; 2],
    /// Whether its charts are see-through.
    pub see_through: bool,
    /// The name of its file, without ending.
    pub stem: String,
    /// The name of the file of what is known, without ending.
    pub known: String,
    /// Its number among the tiles of its picture, where pages are tiles.
    pub tile: Option<u32>,
}

/// Charts on pages.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Layout {
    pub charts: Vec<PlacedChart>,
    pub pages: Vec<Page>,
    /// The largest density that the limit on texels left.
    pub cap: f64,
    /// The share of texels for which photos have fewer pixels.
    pub upsampled: f64,
    /// What is left out, in sentences.
    pub left_out: Vec<String>,
}

impl Layout {
    /// Settles the densities of all charts and packs them: opaque ones and see-through ones on pages of their own.
    pub fn new(parts: &Parts, sources: &Sources, photos: &[PhotoId], options: &BakedOptions) -> Self {
        let wanted: Vec<Wanted> = parts
            .charts
            .iter()
            .zip(details(parts, sources, photos))
            .map(|(chart, of_photos)| Wanted {
                size: chart.size(),
                of_photos,
                object: parts.object_of(chart).index(),
            })
            .collect();
        let (density, texels) = options.limits();
        let page = options.page_side();
        let found = densities(&wanted, &Limits { density, texels, page });
        let mut layout = Self { cap: found.cap, upsampled: found.upsampled, ..Self::default() };
        let unseen = wanted.iter().filter(|chart| chart.of_photos.is_empty()).count();
        if unseen > 0 {
            let (charts, they) = if unseen == 1 { ("chart", "it is") } else { ("charts", "they are") };
            let instead = if options.holes { "grey" } else { "continued from what is around them" };
            layout.left_out.push(format!(
                "{unseen} {charts} of which no photo shows the side that is textured: {they} {instead}"
            ));
        }
        if !found.larger_than_page.is_empty() {
            layout.left_out.push(format!(
                "the full detail of {} that would be larger than a page of {page} x {page} texels: --page-size and --density set both",
                counted(found.larger_than_page.len(), "chart")
            ));
        }
        let sizes: Vec<[u32; 2]> = wanted
            .iter()
            .zip(&found.of_charts)
            .map(|(chart, density)| (chart.size * *density).to_array().map(cells_of))
            .collect();
        layout.charts = parts
            .charts
            .iter()
            .zip(&found.of_charts)
            .zip(&sizes)
            .map(|((chart, &density), cells)| PlacedChart {
                chart: chart.clone(),
                density,
                page: 0,
                at: [0; 2],
                cell: cells.map(|cells| cells * CELL),
            })
            .collect();
        for see_through in [false, true] {
            layout.pack(parts, see_through, page, options.udim);
        }
        layout
    }

    /// Packs the opaque charts, or the see-through ones.
    fn pack(&mut self, parts: &Parts, see_through: bool, page: u32, udim: bool) {
        let is_meant = |chart: &PlacedChart| parts.faces[chart.chart.faces[0]].see_through == see_through;
        let meant: Vec<usize> =
            (0..self.charts.len()).filter(|&chart| is_meant(&self.charts[chart])).collect();
        let cells: Vec<[u32; 2]> =
            meant.iter().map(|&chart| self.charts[chart].cell.map(|side| side / CELL)).collect();
        let packing = pack(&cells, page);
        let first = self.pages.len();
        for (&chart, place) in meant.iter().zip(&packing.places) {
            (self.charts[chart].page, self.charts[chart].at) = (first + place.page, place.at);
        }
        let kind = if see_through { "cutout" } else { "texture" };
        self.pages.extend((0..).zip(packing.pages).map(|(number, size)| {
            let named = |set: &str| match udim {
                true => format!("{set}.{}", FIRST_UDIM + number),
                false => format!("{set}_{}", number + 1),
            };
            let stem = named(&format!("{NAME}_{kind}"));
            let known = if udim { named(&format!("{NAME}_{kind}.known")) } else { format!("{stem}.known") };
            Page { size, see_through, stem, known, tile: udim.then_some(number) }
        }));
    }

    /// Returns the median density, weighted by area.
    pub fn usual_density(&self) -> f64 {
        let mut weighted: Vec<(f64, f64)> = self
            .charts
            .iter()
            .map(|placed| (placed.density, placed.chart.size().x * placed.chart.size().y))
            .collect();
        weighted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let half = weighted.iter().map(|(_, area)| area).sum::<f64>() / 2.0;
        let mut sum = 0.0;
        let median = weighted.iter().find(|(_, area)| {
            sum += area;
            sum >= half
        });
        median.map_or(0.0, |(density, _)| *density)
    }
}

impl PlacedChart {
    /// Returns where a point of the world is on the page: 0 to 1 from the left and from the top.
    pub fn uv(&self, page: &Page, point: DVec3) -> DVec2 {
        let [at, size] = [self.at, page.size].map(|[x, y]| DVec2::new(x.into(), y.into()));
        (at + DVec2::splat(GUTTER.into()) + texel_of(&self.chart, self.density, point)) / size
    }
}

fn counted(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}
