//! Cells of charts on pages: a skyline, by falling height.

use super::CELL;

/// The place of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// The page.
    pub page: usize,
    /// The left and the upper edge, in texels.
    pub at: [u32; 2],
}

/// Cells on pages.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Packing {
    /// The place of each cell.
    pub places: Vec<Place>,
    /// Width and height of each page in texels: powers of two.
    pub pages: Vec<[u32; 2]>,
}

/// Places cells, given by width and height in units of [`CELL`] texels, on as few pages as the skyline needs. `page` is the largest side
/// of a page in texels, a power of two; the last page is as small as its cells allow. The result depends on the cells' order only where two have
/// one size.
///
/// # Panics
/// When a cell is larger than a page.
pub fn pack(cells: &[[u32; 2]], page: u32) -> Packing {
    let side = page / CELL;
    let mut order: Vec<usize> = (0..cells.len()).collect();
    order.sort_by_key(|&cell| (std::cmp::Reverse((cells[cell][1], cells[cell][0])), cell));
    let mut packing = Packing { places: vec![Place { page: 0, at: [0; 2] }; cells.len()], pages: Vec::new() };
    while !order.is_empty() {
        let size = sizes(side).find(|size| fits(cells, &order, *size)).unwrap_or([side; 2]);
        let mut skyline = Skyline::new(size);
        let number = packing.pages.len();
        let left = order.len();
        order.retain(|&cell| match skyline.place(cells[cell]) {
            Some(at) => {
                packing.places[cell] = Place { page: number, at: at.map(|at| at * CELL) };
                false
            }
            None => true,
        });
        assert!(order.len() < left, "a cell is larger than a page");
        packing.pages.push(size.map(|cells| cells * CELL));
    }
    packing
}

/// Returns the sizes of pages up to a square with this side, by area: powers of two, as wide as high or twice as wide.
fn sizes(side: u32) -> impl Iterator<Item = [u32; 2]> {
    let squares = std::iter::successors(Some(1), move |&width| (width < side).then_some(width * 2));
    squares
        .flat_map(move |width| [[width, width], [width * 2, width]])
        .filter(move |[width, _]| *width <= side)
}

/// Returns whether all of these cells fit on a page.
fn fits(cells: &[[u32; 2]], order: &[usize], size: [u32; 2]) -> bool {
    let area = |[width, height]: [u32; 2]| u64::from(width) * u64::from(height);
    let wanted: u64 = order.iter().map(|&cell| area(cells[cell])).sum();
    let mut skyline = Skyline::new(size);
    wanted <= area(size) && order.iter().all(|&cell| skyline.place(cells[cell]).is_some())
}

/// The used height of each column of a page.
struct Skyline {
    used: Vec<u32>,
    height: u32,
}

impl Skyline {
    fn new([width, height]: [u32; 2]) -> Self {
        Self { used: vec![0; width as usize], height }
    }

    /// Places a cell as high up as possible, then as far left; `None` where it does not fit.
    fn place(&mut self, [width, height]: [u32; 2]) -> Option<[u32; 2]> {
        let places =
            self.used.windows(width as usize).map(|columns| columns.iter().copied().max().unwrap_or(0));
        let (x, y) = places.enumerate().min_by_key(|(_, y)| *y)?;
        if y + height > self.height {
            return None;
        }
        self.used[x..x + width as usize].fill(y + height);
        Some([x as u32, y])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    /// Checks that no cell overlaps another one or leaves its page; returns the share of the pages that is used.
    fn used(cells: &[[u32; 2]], packing: &Packing) -> f64 {
        let mut taken: Vec<Vec<bool>> =
            packing.pages.iter().map(|[w, h]| vec![false; (w / CELL * h / CELL) as usize]).collect();
        for (cell, place) in cells.iter().zip(&packing.places) {
            let [width, height] = packing.pages[place.page].map(|side| side / CELL);
            let [x, y] = place.at.map(|at| at / CELL);
            assert!(x + cell[0] <= width && y + cell[1] <= height);
            for (x, y) in (y..y + cell[1]).flat_map(|y| (x..x + cell[0]).map(move |x| (x, y))) {
                let taken = &mut taken[place.page][(y * width + x) as usize];
                assert!(!*taken, "two cells at {x}, {y}");
                *taken = true;
            }
        }
        let all: Vec<bool> = taken.concat();
        all.iter().filter(|taken| **taken).count() as f64 / all.len() as f64
    }

    #[test]
    fn cells_of_all_sizes_fill_most_of_their_pages_without_overlap() {
        let mut rng = Rng::new(5);
        for count in [1, 7, 300, 4000] {
            let mut side = || 1 + (f64::from(rng.whole(1, 100)).powi(3) / 4e4) as u32;
            let cells: Vec<[u32; 2]> = (0..count).map(|_| [side(), side()]).collect();
            let packing = pack(&cells, 1024);
            let full = used(&cells, &packing);
            // The last page is the smallest power of two that holds the rest: half of it may be empty.
            assert!(full > 0.4 || packing.pages.len() == 1, "{count} cells: {full}, {:?}", packing.pages);
        }
    }

    #[test]
    fn few_cells_get_a_small_page_and_many_get_more_pages() {
        assert_eq!(pack(&[[2, 1], [2, 1]], 4096).pages, [[32, 32]]);
        assert_eq!(pack(&[[3, 2]], 4096).pages, [[64, 32]]);
        assert_eq!(pack(&[[64, 64], [64, 64], [1, 1]], 1024).pages, [[1024, 1024], [1024, 1024], [16, 16]]);
        assert_eq!(pack(&[], 1024), Packing::default());
    }
}
