//! What image layers have beside the visible pixels of their photo: filled and painted texels, and layers that one sees through. Each is a
//! grid of cells, cut into tiles; tiles with content are packed into pages.

use quadratura_base::geometry::PixelRect;
use quadratura_layers::fill::push_pull::WeightedGrid;
use quadratura_projection::LayerTextureId;
use quadratura_view::srgb::Srgb;

/// The cells along the side of a tile, and those of its neighbours around it, for filtering.
const TILE: usize = 60;
const GUTTER: usize = 2;
const SLOT: usize = TILE + 2 * GUTTER;
/// The side of a page, in cells, and the tiles along it.
pub const PAGE: usize = 2048;
const ACROSS: usize = PAGE / SLOT;

/// A cell: sRGB and confidence, and the matte.
type TileCell = ([u8; 4], u8);

/// The cells of a layer.
pub struct TileGrid {
    /// Photo pixels per cell along both axes.
    pub pixels: u32,
    /// The photo pixel at which the first cell begins.
    pub corner: [i32; 2],
    /// The number of columns and rows.
    size: [usize; 2],
    cells: Vec<Option<TileCell>>,
}

/// A layer with cells.
pub struct TiledPhoto {
    /// The layer.
    pub layer: LayerTextureId,
    /// Its cells.
    pub grid: TileGrid,
    /// Whether the cells have mattes.
    pub has_matte: bool,
}

impl TileGrid {
    /// Makes cells of single pixels.
    pub fn whole(rect: PixelRect, texel: impl Fn(i32, i32) -> Option<TileCell>) -> Self {
        let cells = rect.pixels().map(|(x, y)| texel(x, y)).collect();
        Self { pixels: 1, corner: [rect.x, rect.y], size: [rect.w as usize, rect.h as usize], cells }
    }

    /// Makes cells of two by two pixels, the mean of what is there of them, in linear light.
    pub fn halved(rect: PixelRect, texel: impl Fn(i32, i32) -> Option<TileCell>) -> Self {
        let corner = [rect.x.div_euclid(2) * 2, rect.y.div_euclid(2) * 2];
        let size =
            [rect.right() - corner[0], rect.bottom() - corner[1]].map(|side| (side as usize).div_ceil(2));
        let srgb = Srgb::tables();
        let cell = |at: usize| {
            let [x, y] = [at % size[0], at / size[0]];
            let [x, y] = [corner[0] + 2 * x as i32, corner[1] + 2 * y as i32];
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)];
            let found: Vec<TileCell> = four.iter().filter_map(|(dx, dy)| texel(x + dx, y + dy)).collect();
            let mean =
                |value: &dyn Fn(&TileCell) -> f32| found.iter().map(value).sum::<f32>() / found.len() as f32;
            let byte = |value: f32| (value + 0.5) as u8;
            (!found.is_empty()).then(|| {
                let [r, g, b] = [0, 1, 2].map(|c| srgb.encoded(mean(&|cell| srgb.linear(cell.0[c]))));
                let trust = byte(mean(&|cell| f32::from(cell.0[3]))).max(1);
                ([r, g, b, trust], byte(mean(&|cell| f32::from(cell.1))))
            })
        };
        Self { pixels: 2, corner, size, cells: (0..size[0] * size[1]).map(cell).collect() }
    }

    /// Returns the numbers of columns and rows of tiles.
    fn tiles(&self) -> [usize; 2] {
        self.size.map(|side| side.div_ceil(TILE))
    }

    /// Returns the cell in a column and row, which may lie beyond the grid. Within two cells of content an empty one has the mean
    /// colour of what is beside it, and no confidence.
    fn at(&self, x: i64, y: i64) -> Option<TileCell> {
        let own = |x: i64, y: i64| {
            let [column, row] = [(x, self.size[0]), (y, self.size[1])]
                .map(|(at, size)| usize::try_from(at).ok().filter(|at| *at < size));
            self.cells[row? * self.size[0] + column?]
        };
        if let Some(cell) = own(x, y) {
            return Some(cell);
        }
        [1i64, 2].into_iter().find_map(|reach| {
            let around = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)));
            let found: Vec<TileCell> = around.filter_map(|(dx, dy)| own(x + dx, y + dy)).collect();
            let mean = |value: &dyn Fn(&TileCell) -> u8| {
                (found.iter().map(|cell| u32::from(value(cell))).sum::<u32>() / found.len().max(1) as u32)
                    as u8
            };
            let [r, g, b] = [0, 1, 2].map(|c| mean(&|cell| cell.0[c]));
            (!found.is_empty()).then(|| ([r, g, b, 0], mean(&|cell| cell.1)))
        })
    }

    /// Returns whether a tile has content.
    fn has_content(&self, [column, row]: [usize; 2]) -> bool {
        let rows = row * TILE..((row + 1) * TILE).min(self.size[1]);
        let columns = column * TILE..((column + 1) * TILE).min(self.size[0]);
        rows.into_iter().any(|y| {
            self.cells[y * self.size[0] + columns.start..y * self.size[0] + columns.end]
                .iter()
                .any(Option::is_some)
        })
    }
}

/// Where the tiles of a layer are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlacedTiles {
    /// The layer.
    pub layer: LayerTextureId,
    /// Photo pixels per cell.
    pub pixels: u32,
    /// The photo pixel at which the first cell begins.
    pub corner: [i32; 2],
    /// The number of columns and rows of tiles.
    pub tiles: [usize; 2],
    /// One more than the number of each tile's slot, page by page and row by row; 0 for tiles without content.
    pub slots: Vec<u32>,
}

/// A page of tiles.
pub struct TilePage {
    cells: Vec<Option<TileCell>>,
    rows: usize,
}

/// Pages that are being filled.
#[derive(Default)]
pub struct TilePages {
    /// The layers' tiles.
    pub placed: Vec<PlacedTiles>,
    next: u32,
    open: Option<TilePage>,
}

impl TilePages {
    /// Adds a layer; `full` gets each page that is full.
    pub fn add<E>(
        &mut self,
        tiled: &TiledPhoto,
        mut full: impl FnMut(TilePage) -> Result<(), E>,
    ) -> Result<(), E> {
        let grid = &tiled.grid;
        let tiles = grid.tiles();
        let mut slots = Vec::with_capacity(tiles[0] * tiles[1]);
        for at in (0..tiles[0] * tiles[1]).map(|at| [at % tiles[0], at / tiles[0]]) {
            if !grid.has_content(at) {
                slots.push(0);
                continue;
            }
            let slot = self.next as usize % (ACROSS * ACROSS);
            let page = self.open.get_or_insert_with(TilePage::new);
            page.put(slot, grid, at);
            self.next += 1;
            slots.push(self.next);
            if slot + 1 == ACROSS * ACROSS {
                self.open.take().map_or(Ok(()), &mut full)?;
            }
        }
        let (layer, pixels, corner) = (tiled.layer, grid.pixels, grid.corner);
        self.placed.push(PlacedTiles { layer, pixels, corner, tiles, slots });
        Ok(())
    }

    /// Returns the page that is not full.
    pub fn last(&mut self) -> Option<TilePage> {
        self.open.take()
    }
}

impl TilePage {
    fn new() -> Self {
        Self { cells: vec![None; PAGE * PAGE], rows: 0 }
    }

    fn put(&mut self, slot: usize, grid: &TileGrid, [column, row]: [usize; 2]) {
        let [left, top] = [slot % ACROSS * SLOT, slot / ACROSS * SLOT];
        self.rows = self.rows.max(top + SLOT);
        for (y, x) in (0..SLOT).flat_map(|y| (0..SLOT).map(move |x| (y, x))) {
            let [from_x, from_y] =
                [(column, x), (row, y)].map(|(tile, at)| (tile * TILE + at) as i64 - GUTTER as i64);
            self.cells[(top + y) * PAGE + left + x] = grid.at(from_x, from_y);
        }
    }

    /// Returns the number of rows in use.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Returns the colours, sRGB, 3 bytes each, of the rows in use; multiplied by the matte in linear light if asked for. Between tiles
    /// they go over from one to the next, which packs well.
    pub fn colours(&self, times_matte: bool) -> Vec<u8> {
        let (srgb, shares) = (Srgb::tables(), Srgb::proportional());
        let mut grid = WeightedGrid::new([PAGE, self.rows]);
        for (at, cell) in self.cells[..PAGE * self.rows].iter().enumerate() {
            if let Some(([r, g, b, _], matte)) = cell {
                let share = if times_matte { shares.linear(*matte) } else { 1.0 };
                grid.values[at] = [*r, *g, *b].map(|byte| share * srgb.linear(byte));
                grid.weights[at] = 1.0;
            }
        }
        let filled = grid.filled().unwrap_or_else(|| vec![[0.0; 3]; PAGE * self.rows]);
        filled.into_iter().flat_map(|light| light.map(|light| srgb.encoded(light))).collect()
    }

    /// Returns the confidence of the rows in use.
    pub fn trust(&self) -> Vec<u8> {
        self.cells[..PAGE * self.rows].iter().map(|cell| cell.map_or(0, |cell| cell.0[3])).collect()
    }

    /// Returns the mattes of the rows in use.
    pub fn mattes(&self) -> Vec<u8> {
        self.cells[..PAGE * self.rows].iter().map(|cell| cell.map_or(0, |cell| cell.1)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_with_content_get_slots_and_carry_colours_past_it() {
        let rect = PixelRect { x: -4, y: 10, w: 400, h: 130 };
        let texel = |x: i32, y: i32| (x < 100 && y < 100).then_some(([40, 80, 120, 200], 255));
        let grid = TileGrid::halved(rect, texel);
        assert_eq!((grid.tiles(), grid.corner), ([4, 2], [-4, 10]));
        let mut pages = TilePages::default();
        let tiled = TiledPhoto { layer: LayerTextureId(3), grid, has_matte: false };
        pages.add::<()>(&tiled, |_| Err(())).unwrap();
        assert_eq!(pages.placed[0].slots, [1, 0, 0, 0, 0, 0, 0, 0]);
        let page = pages.last().unwrap();
        assert_eq!(page.rows(), SLOT);
        // The first cell of the layer is at the gutter; what is two cells away has its colour and no confidence.
        let at = |x: usize, y: usize| y * PAGE + x;
        assert_eq!([page.trust()[at(2, 2)], page.trust()[at(0, 0)]], [200, 0]);
        let colours = page.colours(false);
        assert!((0..3).all(|c| colours[c].abs_diff([40, 80, 120][c]) <= 1), "{:?}", &colours[..3]);
        assert_eq!(page.trust()[at(2 + 52, 2)], 0, "beyond column 100");
    }
}
