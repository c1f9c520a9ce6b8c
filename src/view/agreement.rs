//! Agreement: how far the other photos confirm what a photo shows of a surface, from 0 to 1 (`docs/method.md`,
//! section 7). It is kept apart from confidence, which says whether a texel shows its surface at all.
//!
//! Agreement is known for photo pixels ([`PhotoAgreement`]). A pixel shows one surface, so its agreement concerns the
//! image layer of that surface alone: the filling of a surface behind it does not come from this pixel.

use std::collections::BTreeMap;

use glam::DVec2;

use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::FaceId;

/// Side of a block for which the least agreement is kept, in cells.
const BLOCK: u32 = 8;

/// The agreement, in 255ths, below which a pixel is outvoted, and gives nothing to other photos: from here on the votes
/// against it have a lead of more than one.
const OUTVOTED: u8 = 128;

/// Stands for the face of pixels that show none.
pub const NO_FACE: FaceId = FaceId(u32::MAX);

/// A pixel of a reduced photo that other photos contradict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct ContradictedPixel {
    /// Column and row in the reduced photo.
    pub at: [u16; 2],
    /// The face that the pixel shows.
    pub face: FaceId,
    /// The agreement in 255ths.
    pub agreement: u8,
}

/// The agreement of one photo, on a grid of cells: the pixels of a reduced photo.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct PhotoAgreement {
    /// The number of columns and rows of cells.
    pub size: [u32; 2],
    /// The pixels with an agreement below 1, row by row.
    pub contradicted: Vec<ContradictedPixel>,
    /// Pixels beside these, with the agreement of the neighbouring face: interpolation at a face's outline must not mix its
    /// agreement with that of the next face.
    pub beside: Vec<ContradictedPixel>,
}

impl PhotoAgreement {
    /// Returns the pixels that are outvoted, as rectangles of the photo itself (`photo` is its width and height), each
    /// with the face that it shows.
    pub fn outvoted(&self, photo: [u32; 2]) -> impl Iterator<Item = (PixelRect, FaceId)> {
        let edge = move |at: u32, axis: usize| {
            (u64::from(at) * u64::from(photo[axis]) / u64::from(self.size[axis])) as i32
        };
        let outvoted = self.contradicted.iter().filter(|pixel| pixel.agreement < OUTVOTED);
        outvoted.map(move |pixel| {
            let [x, y] = pixel.at.map(u32::from);
            let rect = PixelRect::from_edges(edge(x, 0), edge(y, 1), edge(x + 1, 0), edge(y + 1, 1));
            (rect, pixel.face)
        })
    }

    /// Returns the agreement of all that the photo shows, whatever the face, on the grid of the reduced photo (`photo` is the
    /// photo's width and height in pixels).
    pub fn whole(&self, photo: [u32; 2]) -> AgreementGrid {
        let size = self.size.map(|side| side.max(1));
        let mut values = vec![u8::MAX; size[0] as usize * size[1] as usize];
        for pixel in &self.contradicted {
            let [x, y] = pixel.at.map(u32::from);
            let value = &mut values[(y * size[0] + x) as usize];
            *value = (*value).min(pixel.agreement);
        }
        let [x, y] = [0, 1].map(|axis| f64::from(size[axis]) / f64::from(photo[axis].max(1)));
        let cells_per_px = DVec2::new(x, y);
        let mut grid = AgreementGrid { cells_per_px, corner: [0; 2], size, values, least: Vec::new() };
        grid.summarise();
        grid
    }

    /// Returns the sum of what is missing to full agreement, as a share of the photo.
    pub fn contradicted_share(&self) -> f64 {
        let missing: u64 = self.contradicted.iter().map(|pixel| u64::from(u8::MAX - pixel.agreement)).sum();
        let cells = f64::from(self.size[0]) * f64::from(self.size[1]);
        if cells > 0.0 { missing as f64 / 255.0 / cells } else { 0.0 }
    }
}

/// The agreement of the texels of one image layer, on a grid of cells in the photo. It is 1 in the outermost cells, and
/// beyond them.
#[derive(Debug, Clone, PartialEq)]
pub struct AgreementGrid {
    /// Cells per photo pixel, along x and y.
    pub cells_per_px: DVec2,
    /// Column and row of the first cell; -1 where it lies beyond the photo.
    pub corner: [i32; 2],
    /// The number of columns and rows.
    pub size: [u32; 2],
    /// The agreement of each cell in 255ths, row by row.
    pub values: Vec<u8>,
    /// The least value of each block of cells, row by row.
    least: Vec<u8>,
}

impl AgreementGrid {
    /// Makes the grid around these cells (column, row, agreement in 255ths), of which there is at least one.
    pub fn new(cells_per_px: DVec2, cells: &BTreeMap<(u16, u16), u8>) -> Option<Self> {
        let columns = || cells.keys().map(|(_, x)| i32::from(*x));
        let rows = || cells.keys().map(|(y, _)| i32::from(*y));
        let corner = [columns().min()? - 1, rows().min()? - 1];
        let size = [columns().max()? + 2 - corner[0], rows().max()? + 2 - corner[1]].map(|side| side as u32);
        let mut values = vec![u8::MAX; (size[0] * size[1]) as usize];
        for (&(y, x), &value) in cells {
            let [column, row] = [i32::from(x) - corner[0], i32::from(y) - corner[1]].map(|at| at as u32);
            values[(row * size[0] + column) as usize] = value;
        }
        let mut grid = Self { cells_per_px, corner, size, values, least: Vec::new() };
        grid.summarise();
        Some(grid)
    }

    /// Computes the least value of each block.
    fn summarise(&mut self) {
        let [columns, rows] = self.size.map(|side| side.div_ceil(BLOCK));
        self.least = vec![u8::MAX; (columns * rows) as usize];
        for (at, value) in (0..).zip(&self.values) {
            let block = (at / self.size[0] / BLOCK) * columns + at % self.size[0] / BLOCK;
            let least = &mut self.least[block as usize];
            *least = (*least).min(*value);
        }
    }

    /// Returns the position of a photo position in the grid, in cells from the first cell's corner.
    fn place(&self, px: DVec2) -> DVec2 {
        px * self.cells_per_px - DVec2::new(self.corner[0].into(), self.corner[1].into())
    }

    /// Interpolates the agreement at a position in the photo, 0 to 1. It is written out, without `raster::bilinear`, so
    /// that it reads like the shader (`agreement_at`).
    pub fn at(&self, px: DVec2) -> f64 {
        let most = DVec2::new(self.size[0].into(), self.size[1].into()) - 0.5;
        let at = self.place(px).max(DVec2::splat(0.5)).min(most) - 0.5;
        let (x, y) = (at.x as u32, at.y as u32);
        let (sx, sy) = (at.x.fract(), at.y.fract());
        let value = |x: u32, y: u32| {
            let (x, y) = (x.min(self.size[0] - 1), y.min(self.size[1] - 1));
            f64::from(self.values[(y * self.size[0] + x) as usize]) / 255.0
        };
        let row = |y: u32| value(x, y) * (1.0 - sx) + value(x + 1, y) * sx;
        row(y) * (1.0 - sy) + row(y + 1) * sy
    }

    /// Returns a lower bound of the agreement within `low_px..high_px` (photo pixels).
    pub fn least(&self, low_px: DVec2, high_px: DVec2) -> f64 {
        let most = DVec2::new(self.size[0].into(), self.size[1].into());
        // Interpolation reaches half a cell.
        let low = (self.place(low_px) - 0.5).max(DVec2::ZERO);
        let high = (self.place(high_px) + 0.5).min(most);
        if low.cmpge(high).any() {
            return 1.0;
        }
        let block = |at: f64| at as u32 / BLOCK;
        let columns = self.size[0].div_ceil(BLOCK);
        let blocks = block(low.y)..=block((high.y - 1e-9).max(low.y));
        let across = block(low.x)..=block((high.x - 1e-9).max(low.x));
        let values = blocks.flat_map(|y| across.clone().map(move |x| (y * columns + x) as usize));
        f64::from(values.map(|at| self.least[at]).min().unwrap_or(u8::MAX)) / 255.0
    }

    /// Gives these pixels of the photo full agreement, wherever interpolation reaches them.
    pub fn spare(&mut self, pixels: impl Iterator<Item = (i32, i32)>) {
        let [columns, rows] = self.size.map(|side| side as i32);
        let mut changed = false;
        for (x, y) in pixels {
            let low = self.place(DVec2::new(x.into(), y.into())) - 0.5;
            let high = self.place(DVec2::new(f64::from(x) + 1.0, f64::from(y) + 1.0)) + 0.5;
            for row in (low.y.floor() as i32).max(0)..(high.y.ceil() as i32).min(rows) {
                for column in (low.x.floor() as i32).max(0)..(high.x.ceil() as i32).min(columns) {
                    self.values[(row * columns + column) as usize] = u8::MAX;
                    changed = true;
                }
            }
        }
        if changed {
            self.summarise();
        }
    }

    /// Returns a grid with half as many cells per pixel along both axes. Each has the largest agreement of four, so that
    /// what was spared stays so.
    pub fn halved(&self) -> Self {
        // One more cell on each side keeps the outermost ones at 1.
        let corner = self.corner.map(|at| at.div_euclid(2) - 1);
        let last = [0, 1].map(|axis| (self.corner[axis] + self.size[axis] as i32 - 1).div_euclid(2) + 1);
        let size = [0, 1].map(|axis| (last[axis] - corner[axis] + 1) as u32);
        let value = |x: i32, y: i32| {
            let at = [x - self.corner[0], y - self.corner[1]].map(|at| u32::try_from(at).ok());
            match at {
                [Some(x), Some(y)] if x < self.size[0] && y < self.size[1] => {
                    self.values[(y * self.size[0] + x) as usize]
                }
                _ => u8::MAX,
            }
        };
        let cell = |at: u32| {
            let (x, y) = (2 * (corner[0] + (at % size[0]) as i32), 2 * (corner[1] + (at / size[0]) as i32));
            value(x, y).max(value(x + 1, y)).max(value(x, y + 1)).max(value(x + 1, y + 1))
        };
        let values = (0..size[0] * size[1]).map(cell).collect();
        let mut grid =
            Self { cells_per_px: self.cells_per_px * 0.5, corner, size, values, least: Vec::new() };
        grid.summarise();
        grid
    }

    /// Returns the pixels of the photo that the grid concerns.
    pub fn rect(&self) -> PixelRect {
        let corner = DVec2::new(self.corner[0].into(), self.corner[1].into());
        let low = corner / self.cells_per_px;
        let high = (corner + DVec2::new(self.size[0].into(), self.size[1].into())) / self.cells_per_px;
        PixelRect::from_edges(low.x as i32 - 1, low.y as i32 - 1, high.x as i32 + 1, high.y as i32 + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    fn grid(rng: &mut Rng) -> AgreementGrid {
        let mut cells = BTreeMap::new();
        for _ in 0..rng.whole(1, 60) {
            let at = (rng.whole(0, 40) as u16, rng.whole(0, 30) as u16);
            cells.insert(at, rng.whole(3, 254) as u8);
        }
        AgreementGrid::new(DVec2::new(0.25, 0.3), &cells).unwrap()
    }

    #[test]
    fn agreement_is_what_was_found_at_a_cells_centre_and_full_beyond_all_cells() {
        let mut rng = Rng::new(3);
        for _ in 0..20 {
            let grid = grid(&mut rng);
            for (at, value) in (0..).zip(&grid.values) {
                let cell = DVec2::new(f64::from(at % grid.size[0]), f64::from(at / grid.size[0])) + 0.5;
                let corner = DVec2::new(grid.corner[0].into(), grid.corner[1].into());
                let found = grid.at((cell + corner) / grid.cells_per_px);
                assert!((found - f64::from(*value) / 255.0).abs() < 1e-9);
            }
            for far in [DVec2::splat(-50.0), DVec2::new(1000.0, 3.0), DVec2::splat(1e5)] {
                assert_eq!(grid.at(far), 1.0);
            }
        }
    }

    #[test]
    fn the_bound_of_a_rectangle_is_never_above_its_agreement() {
        let mut rng = Rng::new(4);
        for _ in 0..40 {
            let grid = grid(&mut rng);
            let low = DVec2::new(rng.between(-20.0, 120.0), rng.between(-20.0, 120.0));
            let high = low + DVec2::new(rng.between(0.0, 60.0), rng.between(0.0, 60.0));
            let bound = grid.least(low, high);
            for _ in 0..200 {
                let share = DVec2::new(rng.between(0.0, 1.0), rng.between(0.0, 1.0));
                assert!(grid.at(low + (high - low) * share) >= bound - 1e-12);
            }
        }
        assert_eq!(grid(&mut rng).least(DVec2::splat(1e4), DVec2::splat(2e4)), 1.0);
    }

    #[test]
    fn a_halved_grid_lies_in_the_same_place_and_never_has_less_than_the_least_of_four() {
        let mut rng = Rng::new(6);
        for _ in 0..20 {
            let grid = grid(&mut rng);
            let halved = grid.halved();
            for _ in 0..100 {
                let px = DVec2::new(rng.between(-10.0, 180.0), rng.between(-10.0, 120.0));
                // Interpolation between cells of two pixels reaches three cells of one.
                let reach = DVec2::splat(3.0) / grid.cells_per_px;
                assert!(halved.at(px) >= grid.least(px - reach, px + reach) - 1e-9);
            }
            for far in [DVec2::splat(-90.0), DVec2::splat(1e4)] {
                assert_eq!(halved.at(far), 1.0);
            }
        }
        let block = (4..8).flat_map(|y| (6..10).map(move |x| ((y, x), 51)));
        let grid = AgreementGrid::new(DVec2::ONE, &block.collect()).unwrap();
        assert!(
            (grid.halved().at(DVec2::new(8.0, 6.0)) - 0.2).abs() < 1e-9,
            "what is low throughout stays low"
        );
    }

    #[test]
    fn outvoted_pixels_cover_their_place_in_the_photo_without_gaps() {
        let face = FaceId(3);
        let pixel = |x: u16, agreement: u8| ContradictedPixel { at: [x, 1], face, agreement };
        let contradicted = vec![pixel(0, 3), pixel(1, 100), pixel(2, 200)];
        let agreement = PhotoAgreement { size: [3, 2], contradicted, beside: Vec::new() };
        let rects: Vec<PixelRect> = agreement.outvoted([10, 7]).map(|(rect, _)| rect).collect();
        assert_eq!(rects, [PixelRect::from_edges(0, 3, 3, 7), PixelRect::from_edges(3, 3, 6, 7)]);
    }

    #[test]
    fn spared_pixels_agree_fully() {
        let mut rng = Rng::new(5);
        let mut grid = grid(&mut rng);
        let painted = (20..40).flat_map(|y| (30..60).map(move |x| (x, y)));
        grid.spare(painted);
        for _ in 0..500 {
            let px = DVec2::new(rng.between(30.0, 60.0), rng.between(20.0, 40.0));
            assert_eq!(grid.at(px), 1.0);
        }
        let values = (grid.values.clone(), grid.least.clone());
        grid.spare(std::iter::empty());
        assert_eq!((grid.values, grid.least), values);
    }
}
