//! Paint of a photo prepared for sampling by other photos: where a surface is painted, its paint counts
//! instead of the photo underneath.

use glam::DVec2;

use super::surfaces::SurfaceId;
use crate::geometry::PixelRect;
use crate::projection::srgb::Srgb;

/// The least alpha at which soft paint provides a colour: below half its opacity, the photo underneath
/// contributes more.
const GIVING_ALPHA: u8 = 128;

/// The number of levels of detail, the same as of photos (see [`super::donor`]).
pub(super) const LEVELS: usize = 4;

/// The paint on one surface of a photo.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PaintedSurface {
    /// The surface.
    pub surface: SurfaceId,
    /// Bounds in photo pixels; they may reach outside the photo.
    pub rect: PixelRect,
    /// The pixels of `rect`, row by row from the top: R, G, B, A in the photo's encoding, with alpha 0 where
    /// paint was erased; `None` where there is no paint.
    pub pixels: Vec<Option<[u8; 4]>>,
}

impl PaintedSurface {
    /// Iterates over the painted pixels that lie within a photo of this size: column, row, and the colour if
    /// the pixel provides one.
    pub(super) fn within(
        &self,
        width: u32,
        height: u32,
    ) -> impl Iterator<Item = (u32, u32, Option<[u8; 3]>)> {
        let row = self.rect.w.max(1) as usize;
        self.pixels.iter().enumerate().filter_map(move |(i, pixel)| {
            let (x, y) = (self.rect.x + (i % row) as i32, self.rect.y + (i / row) as i32);
            let inside = x >= 0 && y >= 0 && (x as u32) < width && (y as u32) < height;
            pixel.filter(|_| inside).map(|pixel| (x as u32, y as u32, given(pixel)))
        })
    }
}

fn given([r, g, b, a]: [u8; 4]) -> Option<[u8; 3]> {
    (a >= GIVING_ALPHA).then_some([r, g, b])
}

/// The result of sampling paint at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Word {
    /// There is no paint: the photo's own pixel counts.
    None,
    /// The paint was erased or is too faint: neither paint nor photo is to be used.
    Silence,
    /// The colour of the paint: linear light, full range 1.
    Colour([f32; 3]),
}

/// The paint of one surface at several levels of detail.
#[derive(Debug)]
pub struct Paint {
    /// Bounds in photo pixels. The corner is a multiple of the coarsest texel, so that the texels of all
    /// levels are aligned with the photo's.
    rect: PixelRect,
    /// The state of each pixel of `rect`, row by row.
    marks: Vec<Mark>,
    levels: Vec<Level>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mark {
    Bare,
    Silent,
    Gives,
}

/// One level: sRGB, 8 bits; alpha is 0 where no paint provides a colour.
#[derive(Debug)]
struct Level {
    width: usize,
    height: usize,
    texels: Vec<[u8; 4]>,
}

impl Paint {
    /// Builds the levels of detail.
    pub fn of(painted: &PaintedSurface) -> Self {
        let step = 1 << (LEVELS - 1);
        let down = |at: i32| at.div_euclid(step) * step;
        let up = |at: i32| -down(-at);
        let inner = painted.rect;
        let rect = PixelRect::from_edges(down(inner.x), down(inner.y), up(inner.right()), up(inner.bottom()));
        let (width, height) = (rect.w as usize, rect.h as usize);
        let mut marks = vec![Mark::Bare; width * height];
        let mut texels = vec![[0; 4]; width * height];
        for (i, pixel) in painted.pixels.iter().enumerate() {
            let Some(pixel) = pixel else { continue };
            let (x, y) = (i % inner.w.max(1) as usize, i / inner.w.max(1) as usize);
            let at = (y + (inner.y - rect.y) as usize) * width + x + (inner.x - rect.x) as usize;
            marks[at] = Mark::Silent;
            if let Some([r, g, b]) = given(*pixel) {
                (marks[at], texels[at]) = (Mark::Gives, [r, g, b, u8::MAX]);
            }
        }
        let mut levels = vec![Level { width, height, texels }];
        while levels.len() < LEVELS {
            levels.push(levels[levels.len() - 1].halved());
        }
        Self { rect, marks, levels }
    }

    /// Returns the bounds of the paint in photo pixels, rounded outwards to the coarsest texel.
    pub fn rect(&self) -> PixelRect {
        self.rect
    }

    /// Returns the memory that the paint uses, in bytes.
    pub fn bytes(&self) -> u64 {
        let texels: usize = self.levels.iter().map(|level| level.texels.len()).sum();
        (self.marks.len() + 4 * texels) as u64
    }

    /// Samples the paint at a position of the photo in pixels, at a level of detail.
    pub fn at(&self, px: DVec2, level: usize) -> Word {
        let pixel = (px - DVec2::new(f64::from(self.rect.x), f64::from(self.rect.y))).floor();
        let inside = pixel.cmpge(DVec2::ZERO).all()
            && pixel.x < f64::from(self.rect.w)
            && pixel.y < f64::from(self.rect.h);
        if !inside {
            return Word::None;
        }
        match self.marks[pixel.y as usize * self.rect.w as usize + pixel.x as usize] {
            Mark::Bare => Word::None,
            Mark::Silent => Word::Silence,
            Mark::Gives => Word::Colour(self.colour(px, level)),
        }
    }

    /// Interpolates between those of four texels of the level that are painted; the pixel at `px` is.
    fn colour(&self, px: DVec2, level: usize) -> [f32; 3] {
        let scale = 1.0 / f64::from(1u32 << level);
        let corner = DVec2::new(f64::from(self.rect.x), f64::from(self.rect.y));
        let at = (px - corner) * scale - 0.5;
        let first = at.floor();
        let share = at - first;
        let mut sum = [0.0f32; 3];
        let mut weights = 0.0;
        for (dx, wx) in [(0.0, 1.0 - share.x), (1.0, share.x)] {
            for (dy, wy) in [(0.0, 1.0 - share.y), (1.0, share.y)] {
                let weight = (wx * wy) as f32;
                if let Some(colour) = self.levels[level].at(first.x + dx, first.y + dy) {
                    (0..3).for_each(|c| sum[c] += weight * colour[c]);
                    weights += weight;
                }
            }
        }
        if weights > 0.0 {
            return sum.map(|sum| sum / weights);
        }
        // An isolated pixel disappears in coarser levels, but a finer level still has its colour.
        if level == 0 { [0.0; 3] } else { self.colour(px, level - 1) }
    }
}

impl Level {
    fn at(&self, x: f64, y: f64) -> Option<[f32; 3]> {
        let inside = x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
        linear(inside.then(|| self.texels[y as usize * self.width + x as usize])?)
    }

    /// Halves the level: each texel is the mean of the painted ones of two by two texels, when at least two
    /// are painted.
    fn halved(&self) -> Self {
        let (width, height) = (self.width / 2, self.height / 2);
        let mean = |i: usize| {
            let at = 2 * (i / width * self.width + i % width);
            let four = [at, at + 1, at + self.width, at + self.width + 1].map(|at| linear(self.texels[at]));
            let count = four.iter().flatten().count();
            let sum = |c: usize| four.iter().flatten().map(|colour| colour[c]).sum::<f32>();
            let [r, g, b] = [0, 1, 2].map(|c| Srgb::tables().encoded(sum(c) / count.max(1) as f32));
            if count >= 2 { [r, g, b, u8::MAX] } else { [0; 4] }
        };
        Self { width, height, texels: (0..width * height).map(mean).collect() }
    }
}

fn linear([r, g, b, a]: [u8; 4]) -> Option<[f32; 3]> {
    (a > 0).then(|| [r, g, b].map(|value| Srgb::tables().linear(value)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn painted(pixels: &[(i32, i32, [u8; 4])]) -> PaintedSurface {
        let rect = PixelRect { x: -3, y: 5, w: 20, h: 10 };
        let mut all = vec![None; 200];
        for (x, y, colour) in pixels {
            all[((y - rect.y) * 20 + x - rect.x) as usize] = Some(*colour);
        }
        PaintedSurface { surface: SurfaceId(0), rect, pixels: all }
    }

    fn centre(x: i32, y: i32) -> DVec2 {
        DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
    }

    #[test]
    fn a_pixel_says_what_was_painted_there_and_nothing_where_it_was_painted_away() {
        let paint = Paint::of(&painted(&[
            (2, 7, [255, 0, 0, 255]),
            (3, 7, [9, 9, 9, 0]),
            (4, 7, [9, 9, 9, 100]),
            (-3, 5, [0, 0, 255, 200]),
        ]));
        let at = |x: i32, y: i32| paint.at(centre(x, y), 0);
        assert_eq!(
            (at(2, 7), at(3, 7), at(4, 7)),
            (Word::Colour([1.0, 0.0, 0.0]), Word::Silence, Word::Silence)
        );
        assert_eq!((at(-3, 5), at(5, 7), at(99, 7)), (Word::Colour([0.0, 0.0, 1.0]), Word::None, Word::None));
    }

    #[test]
    fn coarser_levels_mix_paint_with_paint_alone_and_lonely_pixels_keep_their_colour() {
        let red = |x: i32, y: i32| (x, y, [255, 0, 0, 255]);
        let field: Vec<_> = (0..8).flat_map(|y| (0..8).map(move |x| red(x, y + 5))).collect();
        let paint = Paint::of(&painted(&field));
        for level in 0..LEVELS {
            assert_eq!(paint.at(centre(0, 5), level), Word::Colour([1.0, 0.0, 0.0]), "level {level}");
        }
        let lonely = Paint::of(&painted(&[red(4, 9)]));
        assert_eq!(lonely.at(centre(4, 9), 3), Word::Colour([1.0, 0.0, 0.0]));
    }

    #[test]
    fn only_pixels_within_the_photo_are_told() {
        let painted = painted(&[(-1, 6, [1; 4]), (0, 6, [200; 4]), (16, 14, [7, 7, 7, 3])]);
        let within: Vec<_> = painted.within(16, 15).collect();
        assert_eq!(within, [(0, 6, Some([200; 3]))]);
    }
}
