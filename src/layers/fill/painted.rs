//! Paint of a photo prepared for sampling by other photos: where a surface is painted, its paint counts
//! instead of the photo underneath.

use glam::DVec2;

use super::surfaces::FillSurfaceId;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Image;
use quadratura_base::raster::bilinear::BilinearCorner;
use quadratura_base::raster::halving::OddSide;
use quadratura_view::srgb::Srgb;

/// The least alpha at which soft paint provides a colour: below half its opacity, the photo underneath
/// contributes more.
const GIVING_ALPHA: u8 = 128;

/// The number of levels of detail, the same as of photos (see [`super::donor`]).
pub(super) const LEVELS: usize = 4;

/// The paint on one surface of a photo.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PaintedSurface {
    /// The surface.
    pub surface: FillSurfaceId,
    /// In photo pixels; the bounds may reach outside the photo. R, G, B, A in the photo's encoding, with alpha 0 where
    /// paint was erased; `None` where there is no paint.
    pub pixels: Image<Option<[u8; 4]>>,
}

impl PaintedSurface {
    /// Iterates over the painted pixels that lie within a photo of this size: column, row, and the colour if
    /// the pixel provides one.
    pub(super) fn within(
        &self,
        width: u32,
        height: u32,
    ) -> impl Iterator<Item = (u32, u32, Option<[u8; 3]>)> {
        let photo = PixelRect::of_size(width, height);
        let painted = self.pixels.iter().filter(move |((x, y), _)| photo.contains(*x, *y));
        painted.filter_map(|((x, y), pixel)| pixel.map(|pixel| (x as u32, y as u32, given(pixel))))
    }
}

fn given([r, g, b, a]: [u8; 4]) -> Option<[u8; 3]> {
    (a >= GIVING_ALPHA).then_some([r, g, b])
}

/// The result of sampling paint at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PaintSample {
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
    levels: Vec<PaintedLevel>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mark {
    Bare,
    Silent,
    Gives,
}

/// One level: sRGB, 8 bits; alpha is 0 where no paint provides a colour. Counted from the paint's corner.
type PaintedLevel = Image<[u8; 4]>;

impl Paint {
    /// Builds the levels of detail.
    pub fn from_painted(painted: &PaintedSurface) -> Self {
        let step = 1 << (LEVELS - 1);
        let down = |at: i32| at.div_euclid(step) * step;
        let up = |at: i32| -down(-at);
        let inner = painted.pixels.rect();
        let rect = PixelRect::from_edges(down(inner.x), down(inner.y), up(inner.right()), up(inner.bottom()));
        let mut marks = vec![Mark::Bare; rect.area() as usize];
        let mut texels = vec![[0; 4]; marks.len()];
        for ((x, y), pixel) in painted.pixels.iter() {
            let Some(pixel) = pixel else { continue };
            let at = rect.offset(x, y);
            marks[at] = Mark::Silent;
            if let Some([r, g, b]) = given(*pixel) {
                (marks[at], texels[at]) = (Mark::Gives, [r, g, b, u8::MAX]);
            }
        }
        let mut levels = vec![PaintedLevel::new(PixelRect::of_size(rect.w, rect.h), texels)];
        while levels.len() < LEVELS {
            levels.push(half(&levels[levels.len() - 1]));
        }
        Self { rect, marks, levels }
    }

    /// Returns the bounds of the paint in photo pixels, rounded outwards to the coarsest texel.
    pub fn rect(&self) -> PixelRect {
        self.rect
    }

    /// Returns the memory that the paint uses, in bytes.
    pub fn bytes(&self) -> u64 {
        let texels: usize = self.levels.iter().map(|level| level.pixels().len()).sum();
        (self.marks.len() + 4 * texels) as u64
    }

    /// Samples the paint at a position of the photo in pixels, at a level of detail.
    pub fn at(&self, px: DVec2, level: usize) -> PaintSample {
        let pixel = px.floor().as_ivec2();
        match self.rect.index(pixel.x, pixel.y).map(|at| self.marks[at]) {
            None | Some(Mark::Bare) => PaintSample::None,
            Some(Mark::Silent) => PaintSample::Silence,
            Some(Mark::Gives) => PaintSample::Colour(self.colour(px, level)),
        }
    }

    /// Interpolates between those of four texels of the level that are painted; the pixel at `px` is.
    fn colour(&self, px: DVec2, level: usize) -> [f32; 3] {
        let scale = 1.0 / f64::from(1u32 << level);
        let corner = DVec2::new(f64::from(self.rect.x), f64::from(self.rect.y));
        let mut sum = [0.0f32; 3];
        let mut weights = 0.0;
        for (x, y, weight) in BilinearCorner::from_px((px - corner) * scale).taps() {
            let weight = weight as f32;
            if let Some(colour) = self.levels[level].get(x, y).copied().and_then(linear) {
                (0..3).for_each(|c| sum[c] += weight * colour[c]);
                weights += weight;
            }
        }
        if weights > 0.0 {
            return sum.map(|sum| sum / weights);
        }
        // An isolated pixel disappears in coarser levels, but a finer level still has its colour.
        if level == 0 { [0.0; 3] } else { self.colour(px, level - 1) }
    }
}

/// Halves the level: each texel is the mean of the painted ones of two by two texels, when at least two are painted.
fn half(level: &PaintedLevel) -> PaintedLevel {
    let mean = |four: &[usize]| {
        let painted = four.iter().filter_map(|at| linear(level.pixels()[*at]));
        let count = painted.clone().count();
        let sum = |c: usize| painted.clone().map(|colour| colour[c]).sum::<f32>();
        let [r, g, b] = [0, 1, 2].map(|c| Srgb::tables().encoded(sum(c) / count.max(1) as f32));
        if count >= 2 { [r, g, b, u8::MAX] } else { [0; 4] }
    };
    level.halved(OddSide::Dropped, mean)
}

fn linear([r, g, b, a]: [u8; 4]) -> Option<[f32; 3]> {
    (a > 0).then(|| [r, g, b].map(|value| Srgb::tables().linear(value)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn painted(pixels: &[(i32, i32, [u8; 4])]) -> PaintedSurface {
        let rect = PixelRect { x: -3, y: 5, w: 20, h: 10 };
        let mut all = Image::filled(rect, None);
        for (x, y, colour) in pixels {
            *all.get_mut(*x, *y).unwrap() = Some(*colour);
        }
        PaintedSurface { surface: FillSurfaceId(0), pixels: all }
    }

    fn centre(x: i32, y: i32) -> DVec2 {
        DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
    }

    #[test]
    fn a_pixel_says_what_was_painted_there_and_nothing_where_it_was_painted_away() {
        let paint = Paint::from_painted(&painted(&[
            (2, 7, [255, 0, 0, 255]),
            (3, 7, [9, 9, 9, 0]),
            (4, 7, [9, 9, 9, 100]),
            (-3, 5, [0, 0, 255, 200]),
        ]));
        let at = |x: i32, y: i32| paint.at(centre(x, y), 0);
        assert_eq!(
            (at(2, 7), at(3, 7), at(4, 7)),
            (PaintSample::Colour([1.0, 0.0, 0.0]), PaintSample::Silence, PaintSample::Silence)
        );
        assert_eq!(
            (at(-3, 5), at(5, 7), at(99, 7)),
            (PaintSample::Colour([0.0, 0.0, 1.0]), PaintSample::None, PaintSample::None)
        );
    }

    #[test]
    fn coarser_levels_mix_paint_with_paint_alone_and_lonely_pixels_keep_their_colour() {
        let red = |x: i32, y: i32| (x, y, [255, 0, 0, 255]);
        let field: Vec<_> = (0..8).flat_map(|y| (0..8).map(move |x| red(x, y + 5))).collect();
        let paint = Paint::from_painted(&painted(&field));
        for level in 0..LEVELS {
            assert_eq!(paint.at(centre(0, 5), level), PaintSample::Colour([1.0, 0.0, 0.0]), "level {level}");
        }
        let lonely = Paint::from_painted(&painted(&[red(4, 9)]));
        assert_eq!(lonely.at(centre(4, 9), 3), PaintSample::Colour([1.0, 0.0, 0.0]));
    }

    #[test]
    fn only_pixels_within_the_photo_are_told() {
        let painted = painted(&[(-1, 6, [1; 4]), (0, 6, [200; 4]), (16, 14, [7, 7, 7, 3])]);
        let within: Vec<_> = painted.within(16, 15).collect();
        assert_eq!(within, [(0, 6, Some([200; 3]))]);
    }
}
