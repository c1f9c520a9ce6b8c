//! Draws lines, dots and numbers over a reduced photo and writes it as JPEG.

use std::path::Path;

use glam::DVec2;
use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;

use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{PhotoPixels, Samples};
use quadratura_files::atomic::write_atomically;
use quadratura_view::Picture;

/// How lines are drawn: with a dark seam on both sides, which keeps them readable on a light background.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LineStyle {
    /// Half the width of a line, in pixels of a picture of [`PLAIN`] pixels or less.
    half_width: f64,
    /// The width of the seam on each side, in the same unit.
    seam: f64,
    /// The opacity of the seam, 0 to 1.
    seam_strength: f64,
}

/// Many lines, as of a model's edges, which should hide little of the photo.
const FINE: LineStyle = LineStyle { half_width: 0.7, seam: 1.3, seam_strength: 0.45 };

/// Few lines that have to be found on any background.
const BOLD: LineStyle = LineStyle { half_width: 1.2, seam: 1.6, seam_strength: 0.9 };

/// The longer side up to which lines are as wide as their style says. In larger pictures they are wider in proportion,
/// because such pictures are looked at as a whole.
const PLAIN: f64 = 1024.0;

/// JPEG quality, 1 to 100.
const QUALITY: u8 = 88;

/// The seven segments of a digit one unit wide and two high: top, upper right, lower right, bottom, lower
/// left, upper left, middle.
const SEGMENTS: [[[f64; 2]; 2]; 7] = [
    [[0.0, 0.0], [1.0, 0.0]],
    [[1.0, 0.0], [1.0, 1.0]],
    [[1.0, 1.0], [1.0, 2.0]],
    [[0.0, 2.0], [1.0, 2.0]],
    [[0.0, 1.0], [0.0, 2.0]],
    [[0.0, 0.0], [0.0, 1.0]],
    [[0.0, 1.0], [1.0, 1.0]],
];

/// Segments of each digit as bits, the lowest bit for the first segment.
const DIGITS: [u8; 10] = [0x3f, 0x06, 0x5b, 0x4f, 0x66, 0x6d, 0x7d, 0x07, 0x7f, 0x6f];

/// A picture (RGB, 8 bits) with lines to be drawn over it.
pub struct Overlay {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
    /// Coverage of the line at each pixel, 0 to 1.
    ink: Vec<f32>,
    /// Coverage of the line's seam at each pixel, 0 to 1.
    seam: Vec<f32>,
    colors: Vec<[u8; 3]>,
    style: LineStyle,
    /// Pixels of the picture per pixel of the photo, along x and y.
    scale: DVec2,
    /// How much wider lines are than their style says.
    wider: f64,
}

impl Overlay {
    /// Reduces the photo to at most `longest_side` pixels on its longer side; it is never enlarged.
    pub fn new(photo: &PhotoPixels, longest_side: u32) -> Self {
        let longest = photo.width.max(photo.height);
        let side = |px: u32| (u64::from(px) * u64::from(longest_side) / u64::from(longest)).max(1) as u32;
        let small = longest > longest_side;
        let (width, height) =
            if small { (side(photo.width), side(photo.height)) } else { (photo.width, photo.height) };
        let pixels = width as usize * height as usize;
        Self {
            width,
            height,
            rgb: reduced(photo, width, height),
            ink: vec![0.0; pixels],
            seam: vec![0.0; pixels],
            colors: vec![[0; 3]; pixels],
            style: FINE,
            scale: DVec2::new(
                f64::from(width) / f64::from(photo.width),
                f64::from(height) / f64::from(photo.height),
            ),
            wider: (f64::from(width.max(height)) / PLAIN).max(1.0),
        }
    }

    /// Returns the same picture with wider lines and darker seams, for few lines that have to be found on any background.
    pub fn bold(self) -> Self {
        Self { style: BOLD, ..self }
    }

    /// Draws a line between two points (in photo pixels) with opacity `strength`, 0 to 1. Lines that overlap
    /// do not add up.
    pub fn line(&mut self, from_px: DVec2, to_px: DVec2, color: [u8; 3], strength: f32) {
        self.stroke([from_px, to_px], self.style.half_width, color, strength);
    }

    /// Draws a dot around a point (in photo pixels), three times as wide as lines. Of dots and lines that overlap, the one
    /// drawn first is on top.
    pub fn dot(&mut self, at_px: DVec2, color: [u8; 3]) {
        self.stroke([at_px, at_px], 3.0 * self.style.half_width, color, 1.0);
    }

    /// Draws a line of this half width, in the unit of the style.
    fn stroke(&mut self, ends_px: [DVec2; 2], half_width: f64, color: [u8; 3], strength: f32) {
        let [a, b] = ends_px.map(|end| end * self.scale);
        let (half_width, seam) = (half_width * self.wider, self.style.seam * self.wider);
        let reach = half_width + seam + 1.0;
        let (low, high) = (a.min(b) - reach, a.max(b) + reach);
        let clamp = |value: f64, side: u32| value.clamp(0.0, f64::from(side)) as u32;
        for y in clamp(low.y.floor(), self.height)..clamp(high.y.ceil(), self.height) {
            for x in self.columns(a, b, y, reach) {
                let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let distance = distance_to_segment(centre, a, b);
                self.blend([x, y], distance, [half_width, seam], color, strength);
            }
        }
    }

    /// Draws a number with its top-left corner at `at_px`, `height_px` high, both in photo pixels.
    pub fn number(&mut self, at_px: DVec2, height_px: f64, number: u32, color: [u8; 3]) {
        let (half, step) = (height_px / 2.0, height_px * 0.75);
        for (digit, index) in number.to_string().bytes().zip(0..) {
            let corner = at_px + DVec2::new(f64::from(index) * step, 0.0);
            for (segment, [from, to]) in SEGMENTS.iter().enumerate() {
                if DIGITS[usize::from(digit - b'0')] >> segment & 1 == 1 {
                    let [a, b] = [from, to].map(|[x, y]| corner + DVec2::new(*x, *y) * half);
                    self.line(a, b, color, 1.0);
                }
            }
        }
    }

    /// Returns the columns of row `y` that a line could cover.
    fn columns(&self, a: DVec2, b: DVec2, y: u32, reach: f64) -> std::ops::Range<u32> {
        let (top, bottom) = if a.y <= b.y { (a, b) } else { (b, a) };
        let (mut from, mut to) = (top.x.min(bottom.x), top.x.max(bottom.x));
        let along = bottom - top;
        if along.y > 1e-9 {
            // Where the line crosses the row, with its width as a margin.
            let at = |row: f64| top.x + along.x * ((row - top.y) / along.y).clamp(0.0, 1.0);
            let (first, last) = (at(f64::from(y) - reach), at(f64::from(y) + 1.0 + reach));
            (from, to) = (first.min(last), first.max(last));
        }
        let clamp = |value: f64| value.clamp(0.0, f64::from(self.width)) as u32;
        clamp((from - reach).floor())..clamp((to + reach).ceil())
    }

    /// Draws what a line of this half width and seam, `distance` away from a pixel, leaves there; all in pixels.
    fn blend(
        &mut self,
        [x, y]: [u32; 2],
        distance: f64,
        [half_width, seam]: [f64; 2],
        color: [u8; 3],
        strength: f32,
    ) {
        let coverage = |half_width: f64| (half_width + 0.5 - distance).clamp(0.0, 1.0) as f32 * strength;
        let i = y as usize * self.width as usize + x as usize;
        let ink = coverage(half_width);
        if ink > self.ink[i] {
            (self.ink[i], self.colors[i]) = (ink, color);
        }
        self.seam[i] = self.seam[i].max(coverage(half_width + seam));
    }

    /// Returns the picture, opaque.
    pub fn into_picture(self) -> Picture {
        let mut rgba = Vec::with_capacity(4 * self.ink.len());
        for (i, under) in self.rgb.as_chunks::<3>().0.iter().enumerate() {
            let ink = f64::from(self.ink[i]);
            let shade = 1.0 - self.style.seam_strength * f64::from(self.seam[i]);
            let mixed = |channel: usize| {
                let (under, over) = (f64::from(under[channel]) * shade, f64::from(self.colors[i][channel]));
                (under + (over - under) * ink).round() as u8
            };
            rgba.extend([mixed(0), mixed(1), mixed(2), u8::MAX]);
        }
        Picture { width: self.width, height: self.height, rgba }
    }

    /// Writes the picture as JPEG.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn write(self, path: &Path) -> Result<()> {
        write_jpeg(&self.into_picture(), path)
    }
}

/// Writes an opaque picture as JPEG.
///
/// # Errors
/// [`Error::Io`].
pub fn write_jpeg(picture: &Picture, path: &Path) -> Result<()> {
    let rgb: Vec<u8> = picture.pixels().iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, QUALITY);
    image::ImageEncoder::write_image(encoder, &rgb, picture.width, picture.height, ExtendedColorType::Rgb8)
        .map_err(|error| Error::io(path, "encode it")(std::io::Error::other(error)))?;
    write_atomically(path, &bytes)
}

fn distance_to_segment(point: DVec2, a: DVec2, b: DVec2) -> f64 {
    let along = b - a;
    let t = if along == DVec2::ZERO {
        0.0
    } else {
        ((point - a).dot(along) / along.length_squared()).clamp(0.0, 1.0)
    };
    point.distance(a + along * t)
}

/// Returns the photo reduced to `width` x `height` by averaging blocks of pixels: RGB, 8 bits. Blocks have any size, so
/// this is no `raster::halving`.
fn reduced(photo: &PhotoPixels, width: u32, height: u32) -> Vec<u8> {
    let sample = |i: usize| match &photo.samples {
        Samples::U8(samples) => u32::from(samples[i]),
        Samples::U16(samples) => u32::from(samples[i] >> 8),
    };
    let block = |i: u32, small: u32, large: u32| {
        let at = |i: u32| (u64::from(i) * u64::from(large) / u64::from(small)) as u32;
        at(i)..at(i + 1).max(at(i) + 1)
    };
    let mut rgb = Vec::with_capacity(3 * width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            let (columns, rows) = (block(x, width, photo.width), block(y, height, photo.height));
            let mut sums = [0u32; 3];
            for row in rows.clone() {
                for column in columns.clone() {
                    let i = (row as usize * photo.width as usize + column as usize) * photo.channels;
                    (0..3).for_each(|channel| sums[channel] += sample(i + channel));
                }
            }
            let count = (rows.len() * columns.len()) as u32;
            rgb.extend(sums.map(|sum| (sum / count) as u8));
        }
    }
    rgb
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, height: u32) -> PhotoPixels {
        let samples = Samples::U8(vec![100; 3 * width as usize * height as usize]);
        PhotoPixels { width, height, channels: 3, samples, icc: None }
    }

    #[test]
    fn a_line_covers_its_own_pixels_and_no_others() {
        let mut overlay = Overlay::new(&grey(40, 20), 2048);
        overlay.line(DVec2::new(5.0, 10.5), DVec2::new(35.0, 10.5), [255, 0, 0], 1.0);
        let ink = |x: usize, y: usize| overlay.ink[y * 40 + x];
        assert_eq!((ink(20, 10), ink(20, 14), ink(1, 10)), (1.0, 0.0, 0.0));
        assert!((ink(20, 9) - 0.2).abs() < 1e-6 && (ink(20, 11) - 0.2).abs() < 1e-6);
    }

    #[test]
    fn lines_in_every_direction_and_far_outside_are_drawn_like_their_distance_says() {
        let mut overlay = Overlay::new(&grey(60, 60), 30);
        let segments =
            [([10.0, 50.0], [50.0, 8.0]), ([30.0, -500.0], [31.0, 900.0]), ([5.0, 5.0], [5.0, 5.0])];
        for (a, b) in segments {
            overlay.line(DVec2::from_array(a), DVec2::from_array(b), [1, 2, 3], 1.0);
        }
        for y in 0..30 {
            for x in 0..30 {
                let centre = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let nearest = segments.map(|(a, b)| {
                    distance_to_segment(centre, DVec2::from_array(a) / 2.0, DVec2::from_array(b) / 2.0)
                });
                let nearest = nearest.into_iter().fold(f64::INFINITY, f64::min);
                let expected = (FINE.half_width + 0.5 - nearest).clamp(0.0, 1.0) as f32;
                assert!((overlay.ink[y * 30 + x] - expected).abs() < 1e-6, "{x} {y}");
            }
        }
    }

    #[test]
    fn lines_are_wider_in_larger_pictures_and_dots_wider_than_lines() {
        let width_of = |side: u32, draw: &dyn Fn(&mut Overlay)| {
            let mut overlay = Overlay::new(&grey(side, 20), side);
            draw(&mut overlay);
            (0..20).map(|y| overlay.ink[(y * side + 10) as usize]).sum::<f32>()
        };
        let line =
            |overlay: &mut Overlay| overlay.line(DVec2::new(0.0, 10.0), DVec2::new(40.0, 10.0), [9; 3], 1.0);
        let dot = |overlay: &mut Overlay| overlay.dot(DVec2::new(10.5, 10.0), [9; 3]);
        assert!((width_of(512, &line) - 1.4).abs() < 1e-5 && (width_of(2048, &line) - 2.8).abs() < 1e-5);
        assert!((width_of(512, &dot) - 4.2).abs() < 0.2 && (width_of(2048, &dot) - 8.4).abs() < 0.2);
    }

    /// The lightness of pixels, 0 to 255, after Rec. 709.
    fn lightness(rgb: &[u8]) -> f64 {
        0.2126 * f64::from(rgb[0]) + 0.7152 * f64::from(rgb[1]) + 0.0722 * f64::from(rgb[2])
    }

    #[test]
    fn a_bold_light_line_stands_out_on_black_and_on_white() {
        let folder = tempfile::tempdir().unwrap();
        for ground in [0, 255] {
            let samples = Samples::U8(vec![ground; 3 * 60 * 40]);
            let photo = PhotoPixels { width: 60, height: 40, channels: 3, samples, icc: None };
            let mut overlay = Overlay::new(&photo, 2048).bold();
            overlay.line(DVec2::new(5.0, 20.0), DVec2::new(55.0, 20.0), [255, 236, 120], 1.0);
            let path = folder.path().join("line.jpg");
            overlay.write(&path).unwrap();
            let picture = image::open(&path).unwrap().to_rgb8();
            let column: Vec<f64> = (0..40).map(|y| lightness(&picture.get_pixel(30, y).0)).collect();
            let (darkest, lightest) =
                column.iter().fold((255.0f64, 0.0f64), |(a, b), &v| (a.min(v), b.max(v)));
            // As strong a contrast as between dark and light grey, after the compression of colours in a JPEG.
            assert!(column[19..=20].iter().all(|v| *v > 170.0), "{ground}: the line is light: {column:?}");
            assert!(lightest - darkest > 120.0 && column[17].min(column[22]) < 90.0, "{ground}: {column:?}");
        }
    }

    #[test]
    fn a_number_is_written_digit_by_digit() {
        let mut overlay = Overlay::new(&grey(60, 40), 2048);
        overlay.number(DVec2::new(5.5, 5.5), 20.0, 17, [255, 0, 0]);
        let ink = |x: usize, y: usize| overlay.ink[y * 60 + x] > 0.5;
        assert!(ink(15, 10) && ink(15, 20) && !ink(5, 10) && !ink(10, 5), "a one has its right strokes only");
        assert!(ink(25, 5) && ink(30, 10) && !ink(25, 25), "a seven has its top and its right strokes");
    }

    #[test]
    fn a_picture_is_smaller_and_keeps_its_grey() {
        let overlay = Overlay::new(&grey(301, 100), 100);
        assert_eq!((overlay.width, overlay.height), (100, 33));
        assert!(overlay.rgb.iter().all(|&v| v == 100));
    }
}
