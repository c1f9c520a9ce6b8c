//! A texture atlas for planar faces: each chart is faces in their own plane, without distortion, so nothing is unwrapped by an optimiser.
//!
//! | module | contents |
//! |---|---|
//! | [`chart`] | which faces share a chart, and the axes of its plane |
//! | [`density`] | texels per unit of each chart, from what photos show and what an atlas may hold |
//! | [`pack`] | the cells of charts on pages |
//! | [`pad`] | colours carried outwards from a chart to the border of its cell |
//!
//! Cells begin and end at multiples of [`CELL`] texels, and a chart keeps [`GUTTER`] texels from the border of its cell. So a texel of
//! mip level 4, [`CELL`] texels wide, lies in one cell, and bilinear lookups in that level, half a texel of it inside, do as well.

pub mod chart;
pub mod density;
pub mod pack;
pub mod pad;

/// The side of the grid of cells, in texels: of mip level 4.
pub const CELL: u32 = 16;

/// The least distance of a chart from the border of its cell, in texels.
pub const GUTTER: u32 = CELL / 2;

/// Returns the cells along one side of a chart, by its length in texels.
pub fn cells_of(texels: f64) -> u32 {
    ((texels.ceil() as u32).max(1) + 2 * GUTTER).div_ceil(CELL)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::atlas::pack::pack;
    use quadratura_base::scene::synthetic::Rng;

    /// Halves a page in both directions, by means of four texels.
    fn halved(texels: &[f64], width: usize) -> Vec<f64> {
        let height = texels.len() / width;
        let mean = |x: usize, y: usize| {
            let at = |dx: usize, dy: usize| texels[(2 * y + dy) * width + 2 * x + dx];
            (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) / 4.0
        };
        (0..height / 2).flat_map(|y| (0..width / 2).map(move |x| (x, y))).map(|(x, y)| mean(x, y)).collect()
    }

    #[test]
    fn with_every_chart_in_one_colour_no_level_down_to_the_fourth_shows_a_foreign_one() {
        let mut rng = Rng::new(3);
        let charts: Vec<[f64; 2]> = (0..60).map(|_| [(); 2].map(|()| rng.between(0.3, 150.0))).collect();
        let cells: Vec<[u32; 2]> = charts.iter().map(|size| size.map(cells_of)).collect();
        let packing = pack(&cells, 2048);
        let ([width, height], 1) = (packing.pages[0], packing.pages.len()) else { unreachable!("they fit") };
        let mut page = vec![f64::NAN; (width * height) as usize];
        for (number, (cell, place)) in cells.iter().zip(&packing.places).enumerate() {
            for y in place.at[1]..place.at[1] + cell[1] * CELL {
                let start = (y * width + place.at[0]) as usize;
                page[start..start + (cell[0] * CELL) as usize].fill(number as f64);
            }
        }
        for level in 0..=4 {
            let side = f64::from(1u32 << level);
            let columns = (width >> level) as usize;
            for (number, (size, place)) in charts.iter().zip(&packing.places).enumerate() {
                let ends = [0, 1].map(|axis| {
                    let low = f64::from(place.at[axis] + GUTTER);
                    [low, low + size[axis]].map(|at| at / side - 0.5)
                });
                for (x, y) in ends[0].into_iter().flat_map(|x| ends[1].map(|y| (x, y))) {
                    // A lookup on the border of a chart mixes these four texels, as far as they have a weight.
                    let texels =
                        [x.floor(), x.ceil()].into_iter().flat_map(|x| [y.floor(), y.ceil()].map(|y| (x, y)));
                    for (x, y) in texels {
                        assert_eq!(page[y as usize * columns + x as usize], number as f64, "level {level}");
                    }
                }
            }
            page = halved(&page, columns);
        }
    }
}
