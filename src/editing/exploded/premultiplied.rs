//! A canvas in linear light, so that scaling and blending look right.

use glam::DVec2;

use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::bilinear::BilinearCorner;
use quadratura_base::raster::over::premultiplied;
use quadratura_view::srgb::Srgb;

/// A picture of premultiplied RGBA in linear light, row by row from the top.
#[derive(Debug, Clone)]
pub struct PremultipliedPicture {
    /// The width in pixels.
    pub width: usize,
    /// The height in pixels.
    pub height: usize,
    /// The pixels, `width * height` of them.
    pub pixels: Vec<[f32; 4]>,
}

/// A colour `0xRRGGBB` in sRGB with an opacity of 0..=1.
#[derive(Debug, Clone, Copy)]
pub struct Ink(pub u32, pub f32);

impl Ink {
    /// Returns the premultiplied colour in linear light.
    pub fn linear(self) -> [f32; 4] {
        let [_, red, green, blue] = self.0.to_be_bytes();
        let light = |value: u8| Srgb::tables().linear(value) * self.1;
        [light(red), light(green), light(blue), self.1]
    }
}

/// Multiplies all channels by a factor.
pub fn scaled(color: [f32; 4], by: f32) -> [f32; 4] {
    color.map(|c| c * by)
}

impl PremultipliedPicture {
    /// Makes an empty, transparent canvas.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![[0.0; 4]; width * height] }
    }

    fn rect(&self) -> PixelRect {
        PixelRect::of_size(self.width as u32, self.height as u32)
    }

    /// Returns the pixel in column `x`, row `y`.
    pub fn get(&self, x: usize, y: usize) -> [f32; 4] {
        self.pixels[y * self.width + x]
    }

    /// Composites `color` over the pixel in column `x`, row `y`; positions outside are ignored.
    pub fn blend(&mut self, x: i32, y: i32, color: [f32; 4]) {
        if let Some(at) = self.rect().index(x, y) {
            self.pixels[at] = premultiplied(color, self.pixels[at]);
        }
    }

    /// Composites `other` with its top-left corner at (`x`, `y`).
    pub fn draw(&mut self, other: &Self, x: i32, y: i32) {
        for ((column, row), pixel) in other.rect().pixels().zip(&other.pixels) {
            self.blend(x + column, y + row, *pixel);
        }
    }

    /// Fills the canvas with a vertical gradient from `top` to `bottom`.
    pub fn fill_gradient(&mut self, top: Ink, bottom: Ink) {
        let (top, bottom) = (top.linear(), bottom.linear());
        for (row, pixels) in self.pixels.chunks_mut(self.width).enumerate() {
            let t = row as f32 / self.height as f32;
            pixels.fill(std::array::from_fn(|c| top[c] + (bottom[c] - top[c]) * t));
        }
    }

    /// Draws an antialiased line from `a` to `b` with round ends, `thickness` pixels wide.
    pub fn line(&mut self, a: [f64; 2], b: [f64; 2], thickness: f64, ink: Ink) {
        let reach = thickness / 2.0 + 1.0;
        let color = ink.linear();
        let from = |i: usize| (a[i].min(b[i]) - reach).floor() as i32;
        let to = |i: usize| (a[i].max(b[i]) + reach).ceil() as i32;
        for y in from(1).max(0)..to(1).min(self.height as i32) {
            for x in from(0).max(0)..to(0).min(self.width as i32) {
                let away = distance([f64::from(x) + 0.5, f64::from(y) + 0.5], a, b);
                let cover = (thickness / 2.0 + 0.5 - away).clamp(0.0, 1.0) as f32;
                if cover > 0.0 {
                    self.blend(x, y, scaled(color, cover));
                }
            }
        }
    }

    /// Resamples with a tent filter: the mean over a pixel's area when reducing, linear interpolation when
    /// enlarging.
    pub fn resized(&self, width: usize, height: usize) -> Self {
        let turned = self.stretched(width).transposed();
        turned.stretched(height).transposed()
    }

    /// Resamples the rows to another width.
    fn stretched(&self, width: usize) -> Self {
        let mut out = Self::new(width, self.height);
        let step = self.width as f64 / width as f64;
        let reach = step.max(1.0);
        for x in 0..width {
            let centre = (x as f64 + 0.5) * step;
            let first = (centre - reach).floor().max(0.0) as usize;
            let last = ((centre + reach).ceil() as usize).min(self.width);
            let weight = |i: usize| (1.0 - (i as f64 + 0.5 - centre).abs() / reach).max(0.0) as f32;
            let sum: f32 = (first..last).map(weight).sum();
            for y in 0..self.height {
                let mut mean = [0.0; 4];
                for i in first..last {
                    let pixel = self.get(i, y);
                    let share = weight(i) / sum;
                    mean = std::array::from_fn(|c| mean[c] + pixel[c] * share);
                }
                out.pixels[y * width + x] = mean;
            }
        }
        out
    }

    /// Swaps rows and columns.
    fn transposed(&self) -> Self {
        let mut out = Self::new(self.height, self.width);
        for y in 0..self.height {
            for x in 0..self.width {
                out.pixels[x * self.height + y] = self.get(x, y);
            }
        }
        out
    }

    /// Interpolates bilinearly at (`x`, `y`), pixel centres being at 0.5; positions outside are transparent.
    pub fn sample(&self, x: f64, y: f64) -> [f32; 4] {
        let BilinearCorner { first: [left, top], share } = BilinearCorner::from_px(DVec2::new(x, y));
        let (fx, fy) = (share.x as f32, share.y as f32);
        let mut sum = [0.0; 4];
        for (dx, dy, share) in [
            (0, 0, (1.0 - fx) * (1.0 - fy)),
            (1, 0, fx * (1.0 - fy)),
            (0, 1, (1.0 - fx) * fy),
            (1, 1, fx * fy),
        ] {
            if let Some(at) = self.rect().index(left.saturating_add(dx), top.saturating_add(dy)) {
                sum = std::array::from_fn(|c| sum[c] + self.pixels[at][c] * share);
            }
        }
        sum
    }

    /// Returns 8-bit sRGB without alpha, on black where the canvas is transparent.
    pub fn rgb(&self) -> Vec<u8> {
        let srgb = Srgb::tables();
        self.pixels.iter().flat_map(|p| [p[0], p[1], p[2]].map(|light| srgb.encoded(light))).collect()
    }
}

/// Returns the distance from point `p` to the segment from `a` to `b`.
fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length2 = dx * dx + dy * dy;
    let along = (p[0] - a[0]) * dx + (p[1] - a[1]) * dy;
    let t = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
    (p[0] - a[0] - t * dx).hypot(p[1] - a[1] - t * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_scaled_keeps_its_light() {
        // Away from the border, where the filter is truncated.
        let mut canvas = PremultipliedPicture::new(8, 12);
        (0..8).for_each(|x| canvas.blend(x, 5, Ink(0xff_ff_ff, 1.0).linear()));
        canvas.blend(-1, 99, [1.0; 4]);
        let light = |canvas: &PremultipliedPicture| canvas.pixels.iter().map(|p| p[1]).sum::<f32>();
        let small = canvas.resized(4, 6);
        assert!((light(&small) - light(&canvas) / 4.0).abs() < 1e-4);
        assert_eq!(canvas.rgb()[3 * 40..3 * 40 + 3], [255; 3]);
    }

    #[test]
    fn a_sample_between_two_pixels_is_their_mean() {
        let mut canvas = PremultipliedPicture::new(2, 1);
        canvas.pixels[1] = [1.0; 4];
        assert_eq!(canvas.sample(1.0, 0.5), [0.5; 4]);
        assert_eq!(canvas.sample(1.5, 0.5), [1.0; 4]);
    }
}
