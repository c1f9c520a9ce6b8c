//! A canvas in linear light, so that what is scaled and blended looks as it would to the eye.

use std::path::Path;

/// A picture: premultiplied RGBA in linear light, row by row from the top.
#[derive(Clone)]
pub struct Canvas {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<[f32; 4]>,
}

/// A colour as it is written in style sheets, `0xRRGGBB`, with an opacity of 0..1.
#[derive(Clone, Copy)]
pub struct Ink(pub u32, pub f32);

impl Ink {
    /// Premultiplied, in linear light.
    pub fn linear(self) -> [f32; 4] {
        let channel = |shift: u32| linear_from_srgb((self.0 >> shift & 255) as f32 / 255.0) * self.1;
        [channel(16), channel(8), channel(0), self.1]
    }
}

pub fn linear_from_srgb(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

fn srgb_from_linear(v: f32) -> f32 {
    if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// `top` over `bottom`, both premultiplied.
pub fn over(top: [f32; 4], bottom: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|c| top[c] + bottom[c] * (1.0 - top[3]))
}

pub fn scaled(color: [f32; 4], by: f32) -> [f32; 4] {
    color.map(|c| c * by)
}

impl Canvas {
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![[0.0; 4]; width * height] }
    }

    pub fn get(&self, x: usize, y: usize) -> [f32; 4] {
        self.pixels[y * self.width + x]
    }

    /// Draws `color` over the pixel in column `x`, row `y`; nothing happens outside.
    pub fn blend(&mut self, x: i64, y: i64, color: [f32; 4]) {
        if x >= 0 && y >= 0 && (x as usize) < self.width && (y as usize) < self.height {
            let at = y as usize * self.width + x as usize;
            self.pixels[at] = over(color, self.pixels[at]);
        }
    }

    /// Draws `other` with its top-left corner at (`x`, `y`).
    pub fn draw(&mut self, other: &Self, x: i64, y: i64) {
        for row in 0..other.height {
            for column in 0..other.width {
                self.blend(x + column as i64, y + row as i64, other.get(column, row));
            }
        }
    }

    /// Fills with a colour that runs from `top` to `bottom`.
    pub fn fill_gradient(&mut self, top: Ink, bottom: Ink) {
        let (top, bottom) = (top.linear(), bottom.linear());
        for (row, pixels) in self.pixels.chunks_mut(self.width).enumerate() {
            let t = row as f32 / self.height as f32;
            pixels.fill(std::array::from_fn(|c| top[c] + (bottom[c] - top[c]) * t));
        }
    }

    /// A line from `a` to `b` with round ends, `thickness` pixels wide, smooth at its edges.
    pub fn line(&mut self, a: [f64; 2], b: [f64; 2], thickness: f64, ink: Ink) {
        let reach = thickness / 2.0 + 1.0;
        let color = ink.linear();
        let from = |i: usize| (a[i].min(b[i]) - reach).floor() as i64;
        let to = |i: usize| (a[i].max(b[i]) + reach).ceil() as i64;
        for y in from(1).max(0)..to(1).min(self.height as i64) {
            for x in from(0).max(0)..to(0).min(self.width as i64) {
                let away = distance([x as f64 + 0.5, y as f64 + 0.5], a, b);
                let cover = (thickness / 2.0 + 0.5 - away).clamp(0.0, 1.0) as f32;
                if cover > 0.0 {
                    self.blend(x, y, scaled(color, cover));
                }
            }
        }
    }

    /// Each pixel the mean of the area that it stands for (or of its neighbours, when enlarged).
    pub fn resized(&self, width: usize, height: usize) -> Self {
        let turned = self.stretched(width).transposed();
        turned.stretched(height).transposed()
    }

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

    fn transposed(&self) -> Self {
        let mut out = Self::new(self.height, self.width);
        for y in 0..self.height {
            for x in 0..self.width {
                out.pixels[x * self.height + y] = self.get(x, y);
            }
        }
        out
    }

    /// The value between pixels at (`x`, `y`), pixel centres being at 0.5; nothing outside.
    pub fn sample(&self, x: f64, y: f64) -> [f32; 4] {
        let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
        let (fx, fy) = ((x - 0.5 - left) as f32, (y - 0.5 - top) as f32);
        let mut sum = [0.0; 4];
        for (dx, dy, share) in [
            (0, 0, (1.0 - fx) * (1.0 - fy)),
            (1, 0, fx * (1.0 - fy)),
            (0, 1, (1.0 - fx) * fy),
            (1, 1, fx * fy),
        ] {
            let (px, py) = (left as i64 + dx, top as i64 + dy);
            if px >= 0 && py >= 0 && (px as usize) < self.width && (py as usize) < self.height {
                let pixel = self.get(px as usize, py as usize);
                sum = std::array::from_fn(|c| sum[c] + pixel[c] * share);
            }
        }
        sum
    }

    /// Writes JPEG or PNG, by the name's ending, on black where nothing was drawn.
    pub fn save(&self, path: &Path) -> Result<(), Box<dyn std::error::Error>> {
        let byte = |v: f32| (srgb_from_linear(v.clamp(0.0, 1.0)) * 255.0).round() as u8;
        let rgb = self.pixels.iter().flat_map(|p| [byte(p[0]), byte(p[1]), byte(p[2])]).collect();
        let picture = image::RgbImage::from_raw(self.width as u32, self.height as u32, rgb)
            .expect("three bytes for each pixel");
        if path.extension().is_some_and(|e| e == "jpg" || e == "jpeg") {
            let file = std::io::BufWriter::new(std::fs::File::create(path)?);
            picture.write_with_encoder(image::codecs::jpeg::JpegEncoder::new_with_quality(file, 88))?;
        } else {
            picture.save(path)?;
        }
        Ok(())
    }
}

/// From point `p` to the segment from `a` to `b`.
fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length2 = dx * dx + dy * dy;
    let along = (p[0] - a[0]) * dx + (p[1] - a[1]) * dy;
    let t = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
    (p[0] - a[0] - t * dx).hypot(p[1] - a[1] - t * dy)
}
