//! A pixel set resampled to another grid, such as a screen: the cells that show it, its rim, and rectangles to draw
//! it with. The cost grows with the rows and outlines of the cells, not with the picture's size.

use glam::DVec2;

use super::{PixelRect, Spans};

/// A grid of square cells over a picture, such as the pixels of a screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// The picture's top-left corner, in cells from the grid's top-left corner.
    pub origin: DVec2,
    /// The side of a picture pixel, in cells.
    pub scale: f64,
    /// The numbers of columns and rows.
    pub size: [u32; 2],
}

impl Grid {
    /// Returns the rectangle of all cells.
    #[inline]
    pub fn whole(&self) -> PixelRect {
        PixelRect::of_size(self.size[0], self.size[1])
    }

    /// Returns the cells that show pixels of a set. Where cells are larger than pixels, a cell counts if any pixel
    /// within it is in the set; otherwise the pixel under the cell's centre decides.
    pub fn cells(&self, pixels: &Spans) -> Spans {
        let mut runs = Vec::new();
        Spans::from_rows(0..self.size[1] as i32, |row, out| {
            runs.clear();
            for y in self.pixel_rows(row) {
                runs.extend(pixels.row(y).iter().map(|run| self.columns(run.start, run.end)));
            }
            runs.retain(|run| !run.is_empty());
            runs.sort_unstable_by_key(|run| run.start);
            out.append(&mut runs);
        })
    }

    /// Returns the rows of the picture that a row of cells shows.
    fn pixel_rows(&self, row: i32) -> std::ops::Range<i32> {
        let pixel = |cells: f64| (cells - self.origin.y) / self.scale;
        if self.scale >= 1.0 {
            let middle = pixel(f64::from(row) + 0.5).floor() as i32;
            return middle..middle + 1;
        }
        pixel(f64::from(row)).floor() as i32..pixel(f64::from(row + 1)).ceil() as i32
    }

    /// Returns the columns of cells, within the grid, that show the pixels `from..to` of a row.
    fn columns(&self, from: i32, to: i32) -> std::ops::Range<i32> {
        let cell = |pixel: i32| self.origin.x + f64::from(pixel) * self.scale;
        let (from, to) = match self.scale >= 1.0 {
            true => ((cell(from) - 0.5).ceil(), (cell(to) - 0.5).ceil()),
            false => (cell(from).floor(), cell(to).ceil()),
        };
        (from as i32).max(0)..(to as i32).min(self.size[0] as i32)
    }
}

/// Returns the cells of a set that are at most `width` rows and columns away from a cell of `whole` outside the
/// set.
#[inline]
pub fn rim(cells: &Spans, width: i32, whole: PixelRect) -> Spans {
    cells.intersection(&cells.complement(whole).grown(width))
}

/// Covers a set with disjoint rectangles: equal runs in consecutive rows make one rectangle.
pub fn boxes(cells: &Spans) -> Vec<PixelRect> {
    let mut done = Vec::new();
    let mut open: Vec<PixelRect> = Vec::new();
    for y in cells.rows() {
        let mut goes_on = Vec::with_capacity(cells.row(y).len());
        let mut above = open.into_iter().peekable();
        for run in cells.row(y) {
            while let Some(ended) = above.next_if(|above| above.x < run.start) {
                done.push(ended);
            }
            let same = above.next_if(|above| above.x == run.start && above.right() == run.end);
            let begun = PixelRect { x: run.start, y, w: run.len() as u32, h: 0 };
            let held = same.unwrap_or(begun);
            goes_on.push(PixelRect { h: held.h + 1, ..held });
        }
        done.extend(above);
        open = goes_on;
    }
    done.extend(open);
    done
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::synthetic::Rng;

    const SIDE: u32 = 40;
    const PICTURE: PixelRect = PixelRect::of_size(SIDE, SIDE);

    fn random(rng: &mut Rng) -> Spans {
        let dots: Vec<bool> = (0..SIDE * SIDE).map(|_| rng.between(0.0, 1.0) < 0.3).collect();
        let blob = PixelRect { x: 9, y: 12, w: 14, h: 11 };
        Spans::of_pixels(PICTURE, |x, y| dots[(y as u32 * SIDE + x as u32) as usize] && x > 20)
            .union(&Spans::of_pixels(blob, |_, _| true))
    }

    #[test]
    fn magnified_cells_show_the_pixel_that_they_lie_in() {
        let pixels = random(&mut Rng::new(3));
        for scale in [1.0, 1.7, 5.0] {
            let grid = Grid { origin: DVec2::new(-13.25, 6.5), scale, size: [90, 70] };
            let cells = grid.cells(&pixels);
            for (x, y) in (0..90).flat_map(|x| (0..70).map(move |y| (x, y))) {
                let middle = (DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) - grid.origin) / scale;
                let visible = pixels.holds(middle.x.floor() as i32, middle.y.floor() as i32);
                assert_eq!(cells.holds(x, y), visible, "{x}, {y} at {scale}");
            }
        }
    }

    #[test]
    fn a_cell_of_many_pixels_shows_any_of_them() {
        let pixels = random(&mut Rng::new(4));
        let grid = Grid { origin: DVec2::new(2.0, -1.0), scale: 0.25, size: [20, 20] };
        let cells = grid.cells(&pixels);
        for (x, y) in (0..20).flat_map(|x| (0..20).map(move |y| (x, y))) {
            let (left, top) = (4 * (x - 2), 4 * (y + 1));
            let any = (left..left + 4).any(|x| (top..top + 4).any(|y| pixels.holds(x, y)));
            assert_eq!(cells.holds(x, y), any, "{x}, {y}");
        }
    }

    #[test]
    fn boxes_cover_each_cell_once() {
        for seed in 0..9 {
            let cells = random(&mut Rng::new(seed));
            let boxes = boxes(&cells);
            assert_eq!(boxes.iter().map(PixelRect::area).sum::<u64>(), cells.count());
            let covered = |x: i32, y: i32| boxes.iter().any(|b| b.contains(x, y));
            assert_eq!(Spans::of_pixels(PICTURE, covered).count(), cells.count());
            assert!(cells.iter().all(|(y, run)| run.clone().all(|x| covered(x, y))));
        }
        let block = PixelRect { x: 3, y: 4, w: 7, h: 9 };
        assert_eq!(super::boxes(&Spans::of_pixels(block, |_, _| true)), [block]);
    }

    #[test]
    fn a_rim_goes_around_and_not_along_the_grids_border() {
        let block = Spans::of_pixels(PixelRect { x: 0, y: 5, w: 20, h: 20 }, |_, _| true);
        let rim = rim(&block, 2, PICTURE);
        assert_eq!(rim.count(), 20 * 20 - 18 * 16, "two cells above, below and at the right");
        assert!(!rim.holds(0, 12) && rim.holds(19, 12));
    }
}
