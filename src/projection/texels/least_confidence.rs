//! Lower bounds of a layer texture's confidence per block of texels, so that the photos for a cell can be judged
//! without access to texels.

use super::pyramid::Pyramid;
use quadratura_base::geometry::PixelRect;

/// Side of a block, in texels: smaller than the extent of a cell in a photo, larger than half a tile.
const BLOCK: i32 = 32;

/// The least confidence in each block of a layer texture's level 0.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LeastConfidence {
    /// The range of blocks, in blocks from the layer texture's corner; blocks outside of it have confidence 0.
    bounds: Blocks,
    /// The least confidence of each block in 255ths, row by row.
    least: Vec<u8>,
}

/// A range of columns and rows of blocks: first and one past the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Blocks {
    x: [i32; 2],
    y: [i32; 2],
}

impl LeastConfidence {
    /// Computes the bounds from a pyramid's finest level.
    pub fn from_pyramid(pyramid: &Pyramid) -> Self {
        let level = &pyramid.levels[0];
        let rect = level.rect;
        let range = |from: i32, to: i32| [from.div_euclid(BLOCK), (to + BLOCK - 1).div_euclid(BLOCK)];
        let bounds = Blocks { x: range(rect.x, rect.right()), y: range(rect.y, rect.bottom()) };
        let columns = (bounds.x[1] - bounds.x[0]) as usize;
        let mut least = vec![u8::MAX; columns * (bounds.y[1] - bounds.y[0]) as usize];
        for (i, value) in least.iter_mut().enumerate() {
            let x = (bounds.x[0] + (i % columns) as i32) * BLOCK;
            let y = (bounds.y[0] + (i / columns) as i32) * BLOCK;
            let block = PixelRect { x, y, w: BLOCK as u32, h: BLOCK as u32 };
            // Texels that the level does not store are empty.
            let kept = block.intersection(&rect);
            *value = if kept == block { least_of(level, kept) } else { 0 };
        }
        Self { bounds, least }
    }

    /// Returns a lower bound of the confidence within `rect` (texels from the layer texture's corner), 0 to 1.
    pub fn within(&self, rect: PixelRect) -> f64 {
        let x = [rect.x.div_euclid(BLOCK), (rect.right() - 1).div_euclid(BLOCK)];
        let y = [rect.y.div_euclid(BLOCK), (rect.bottom() - 1).div_euclid(BLOCK)];
        let inside = x[0] >= self.bounds.x[0] && x[1] < self.bounds.x[1];
        if !inside || y[0] < self.bounds.y[0] || y[1] >= self.bounds.y[1] {
            return 0.0;
        }
        let columns = (self.bounds.x[1] - self.bounds.x[0]) as usize;
        let mut least = u8::MAX;
        for row in y[0]..=y[1] {
            let first = (row - self.bounds.y[0]) as usize * columns;
            let [from, to] = x.map(|x| first + (x - self.bounds.x[0]) as usize);
            least = self.least[from..=to].iter().fold(least, |a, b| a.min(*b));
        }
        f64::from(least) / 255.0
    }
}

fn least_of(level: &super::pyramid::Level, rect: PixelRect) -> u8 {
    let mut least = u8::MAX;
    for y in rect.y..rect.bottom() {
        let from = level.index(rect.x, y);
        let row = level.rgba[from..from + 4 * rect.w as usize].as_chunks::<4>().0;
        least = row.iter().fold(least, |a, texel| a.min(texel[3]));
        if least == 0 {
            break;
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LayerTexturePixels;
    use crate::pyramid::{PyramidOptions, pyramid};

    #[test]
    fn inside_it_is_whole_and_near_a_border_as_low_as_the_lowest_texel() {
        let rect = PixelRect { x: 100, y: 50, w: 256, h: 256 };
        let kept = PixelRect { x: 110, y: 50, w: 200, h: 200 };
        let pixels = LayerTexturePixels {
            rect: kept,
            rgba: vec![255; 4 * 40_000],
            needed: vec![1; 40_000],
            matte: None,
        };
        let least = LeastConfidence::from_pyramid(&pyramid(rect, &pixels, &PyramidOptions::default()));
        let at = |x: i32, y: i32, side: u32| least.within(PixelRect { x, y, w: side, h: side });
        assert_eq!(at(100, 100, 20), 1.0);
        assert!(at(10, 100, 8) < 1.0, "the border of the content");
        assert_eq!(at(0, 100, 20), 0.0, "partly empty");
        assert_eq!(at(-500, 0, 20), 0.0, "outside");
        assert_eq!(at(230, 230, 20), 0.0);
    }
}
