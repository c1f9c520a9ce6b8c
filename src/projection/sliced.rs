//! Images drawn in slices, tiles with one submission each, so that other users of the device wait for one
//! tile and never for a whole image. Data common to all tiles is computed once, for the whole image.
//!
//! An image may be drawn finer than it is asked for, and reduced while its rows arrive ([`super::reducer`]).

use std::ops::Range;

use super::exposure::ViewExposure;
use super::reducer::{Reducer, Values};
use super::texture_memory::TextureOptions;
use quadratura_base::scene::light::{linear_of_srgb, srgb_from_linear};
use quadratura_view::shot::MOST_SAMPLES;
use quadratura_view::{LinearPicture, Picture, Shot};

/// The time that a slice should take, in seconds: a window that waits for it misses at most one frame.
const WANTED_S: f64 = 0.01;
/// The least number of pixels of a slice; preparing the cells and tables of a slice takes as long as drawing
/// this many pixels on a CPU.
const LEAST_PX: f64 = 131_072.0;
/// The largest number of pixels of a slice where nobody waits for the device, and the longest side of any slice: what is
/// drawn into takes up to 64 bytes a pixel.
const MOST_PX: f64 = 2_097_152.0;
const LONGEST_PX: u32 = 4096;
/// The texture memory that a pixel needs, in bytes: texels of sixteen photos with their coarser levels.
const TEXTURE_BYTES_PER_PX: f64 = 100.0;
/// The rows of a finer image that are reduced at once.
const REDUCED_ROWS: usize = 64;
/// The time per pixel assumed for the first slice, in seconds; a slow one, because nothing is known yet.
const FIRST_PER_PX_S: f64 = 1e-7;

/// How large slices are.
#[derive(Debug, Clone, Copy, PartialEq)]
enum SlicePace {
    /// Other users of the device wait: the measured time per pixel, in seconds.
    Shared(f64),
    /// Nobody waits: the largest number of pixels of a slice.
    Alone(f64),
    /// All rows at once.
    Whole,
}

/// An image that is being drawn; complete when [`super::Renders::advance`] returns true.
#[derive(Debug)]
pub struct Sliced {
    shot: Shot,
    /// The view that is drawn: that which is asked for, or a finer one.
    drawn: Shot,
    /// What reduces the finer image; `None` where it is not finer.
    reducer: Option<Reducer>,
    /// The exposure of the whole image; bands of different exposure would be visible.
    exposure: ViewExposure,
    /// sRGB and alpha of the rows of the result so far, where the image is not drawn in linear light.
    rgba: Vec<u8>,
    /// The rows of the result so far in linear light.
    linear: Vec<[f32; 4]>,
    /// The row of the drawn image at which the present slice begins, and the row behind the last one that is drawn.
    row: u32,
    end: u32,
    /// The present slice: its rows, and its tiles so far from the left, whose widths sum to `column`.
    rows: u32,
    column: u32,
    tiles: Vec<DrawnTile>,
    pace: SlicePace,
    /// The largest numbers of columns and rows of a tile whose texels fit into memory, as far as is known.
    most: [u32; 2],
    /// Whether texels of some tile did not fit, however small it was.
    is_coarser: bool,
}

/// A part of the image as it was drawn, rows from the top.
#[derive(Debug)]
enum DrawnTile {
    Bytes(Picture),
    Linear(LinearPicture),
}

impl Sliced {
    /// Creates an image without rows. `exposure` is common to all slices.
    pub fn new(shot: &Shot, exposure: ViewExposure) -> Self {
        let end = shot.camera.height;
        Self {
            shot: shot.clone(),
            drawn: Shot { supersampled: false, ..shot.clone() },
            reducer: None,
            exposure,
            rgba: Vec::new(),
            linear: Vec::new(),
            row: 0,
            end,
            rows: 0,
            column: 0,
            tiles: Vec::new(),
            pace: SlicePace::Shared(FIRST_PER_PX_S),
            most: [u32::MAX; 2],
            is_coarser: false,
        }
    }

    /// Creates an image without rows of which photos have `finer` times as many pixels along each side: it is drawn with as many
    /// up to two, with half as many from four on, at most [`MOST_SAMPLES`], and reduced. Half of them lose 0.02 dB
    /// (docs/method.md, section 7). Where photos have no more, as in a photo's own camera, it is drawn as it is asked for.
    pub fn finer(shot: &Shot, finer: f64, exposure: ViewExposure) -> Self {
        let whole = Self::new(shot, exposure);
        let samples = finer.min((0.5 * finer).max(2.0));
        let drawn = shot.finer(samples.clamp(1.0, MOST_SAMPLES));
        let size = |shot: &Shot| [shot.camera.width, shot.camera.height];
        if size(&drawn) == size(shot) {
            return whole;
        }
        let reducer = Some(Reducer::new(size(&drawn), size(shot)));
        Self { reducer, end: drawn.camera.height, drawn, ..whole }
    }

    /// Creates an image of which some rows are drawn at once; all others stay empty.
    pub fn of_rows(shot: &Shot, exposure: ViewExposure, rows: Range<u32>) -> Self {
        let whole = Self::new(shot, exposure);
        let above = shot.camera.width as usize * rows.start as usize;
        let (rgba, linear) = if shot.linear { (0, above) } else { (4 * above, 0) };
        let (rgba, linear) = (vec![0; rgba], vec![[0.0; 4]; linear]);
        Self { rgba, linear, row: rows.start, end: rows.end.min(whole.end), pace: SlicePace::Whole, ..whole }
    }

    /// Returns the same where no other user of the device waits for its slices.
    pub fn alone(self) -> Self {
        Self { pace: SlicePace::Alone(MOST_PX), ..self }
    }

    /// As [`Self::alone`], with slices of fewer pixels where textures have less than the usual memory: what a slice shows has to be in it.
    pub fn alone_within(self, textures: &TextureOptions) -> Self {
        let px = textures.budget_bytes as f64 / TEXTURE_BYTES_PER_PX;
        Self { pace: SlicePace::Alone(px.clamp(LEAST_PX, MOST_PX)), ..self }
    }

    /// Returns the next tile as a view of its own: whole rows and columns of cells, so that each cell is the same as in
    /// the whole image.
    pub fn tile(&mut self, cell_px: u32) -> Shot {
        let mut shot = self.drawn.clone();
        let (width, left) = (shot.camera.width, self.end.saturating_sub(self.row).max(1));
        let longest = match self.pace {
            SlicePace::Whole => width,
            SlicePace::Shared(_) | SlicePace::Alone(_) => (LONGEST_PX / cell_px).max(1) * cell_px,
        };
        if self.column == 0 {
            let px = match self.pace {
                SlicePace::Whole => f64::INFINITY,
                SlicePace::Alone(px) => px,
                SlicePace::Shared(per_px_s) => (WANTED_S / per_px_s).clamp(LEAST_PX, MOST_PX),
            };
            let rows = (px / f64::from(width.min(longest))).ceil().min(f64::from(left)) as u32;
            self.rows = rows.next_multiple_of(cell_px).min(self.most[1]).clamp(1, left);
        }
        shot.camera.height = self.rows;
        shot.camera.width = (width - self.column).min(longest).min(self.most[0]);
        shot.camera.cy -= f64::from(self.row);
        shot.camera.cx -= f64::from(self.column);
        shot
    }

    /// Returns whether the present tile, with cells of this side, can be divided: while nobody waits for the device, down to one cell.
    pub fn is_divisible(&self, cell_px: u32) -> bool {
        let is_alone = matches!(self.pace, SlicePace::Alone(_));
        is_alone && (self.may_be_lower(cell_px) || self.columns() > cell_px)
    }

    /// Makes the present tile and all later ones half as large, in whole cells of this side, because memory does not hold the texels that it
    /// needs: of fewer rows, then of fewer columns. Returns false where it cannot be divided.
    pub fn halve(&mut self, cell_px: u32) -> bool {
        let half = |px: u32| (px / 2).next_multiple_of(cell_px);
        if !self.is_divisible(cell_px) {
            return false;
        }
        match self.may_be_lower(cell_px) {
            true => self.most[1] = half(self.rows),
            false => self.most[0] = half(self.columns()),
        }
        true
    }

    /// Returns whether the present tile is the first one of its rows, of which there may be fewer.
    fn may_be_lower(&self, cell_px: u32) -> bool {
        self.column == 0 && self.rows > cell_px
    }

    /// Returns the largest number of columns of the present tile.
    fn columns(&self) -> u32 {
        (self.drawn.camera.width - self.column).min(self.most[0]).min(LONGEST_PX)
    }

    /// Notes that texels of a tile are coarser than it needs, because memory does not hold them.
    pub fn becomes_coarser(&mut self) {
        self.is_coarser = true;
    }

    /// Returns whether texels of some tile are coarser than it needs, because memory does not hold them.
    pub fn is_coarser(&self) -> bool {
        self.is_coarser
    }

    /// Returns the exposure of the whole image.
    pub fn exposure(&self) -> &ViewExposure {
        &self.exposure
    }

    /// Takes the next tile, or the whole image; returns whether it is complete.
    pub fn add(&mut self, tile: Picture) -> bool {
        if tile.height == self.shot.camera.height
            && tile.width == self.shot.camera.width
            && self.reducer.is_none()
        {
            (self.row, self.rows, self.end) = (0, tile.height, tile.height);
            (self.rgba, self.linear) = (Vec::new(), Vec::new());
        }
        let width = tile.width;
        self.take(DrawnTile::Bytes(tile), width)
    }

    /// As [`Self::add`], of an image in linear light.
    pub fn add_linear(&mut self, tile: LinearPicture) -> bool {
        let width = tile.width;
        self.take(DrawnTile::Linear(tile), width)
    }

    fn take(&mut self, tile: DrawnTile, width: u32) -> bool {
        self.tiles.push(match (tile, self.shot.linear) {
            (DrawnTile::Bytes(tile), true) => DrawnTile::Linear(LinearPicture::of(&tile)),
            (DrawnTile::Linear(tile), false) => DrawnTile::Bytes(tile.picture()),
            (tile, _) => tile,
        });
        self.column += width;
        if self.column >= self.drawn.camera.width {
            let tiles = std::mem::take(&mut self.tiles);
            for row in 0..self.rows as usize {
                tiles.iter().for_each(|tile| self.append(tile, row));
            }
            self.reduce(&tiles);
            (self.row, self.column) = (self.row + self.rows, 0);
        }
        self.row >= self.end
    }

    /// Appends a row of a tile to an image that is drawn as it is asked for.
    fn append(&mut self, tile: &DrawnTile, row: usize) {
        if self.reducer.is_some() {
            return;
        }
        match tile {
            DrawnTile::Bytes(tile) => {
                let width = 4 * tile.width as usize;
                self.rgba.extend_from_slice(&tile.rgba[row * width..(row + 1) * width]);
            }
            DrawnTile::Linear(tile) => {
                let width = tile.width as usize;
                self.linear.extend_from_slice(&tile.rgba[row * width..(row + 1) * width]);
            }
        }
    }

    /// Reduces the rows of a finer image.
    fn reduce(&mut self, tiles: &[DrawnTile]) {
        let Some(reducer) = &mut self.reducer else { return };
        let width = self.drawn.camera.width as usize;
        // A few rows at a time: values take four times the memory of bytes.
        for first in (0..self.rows as usize).step_by(REDUCED_ROWS) {
            let last = (first + REDUCED_ROWS).min(self.rows as usize);
            let mut rows = Vec::with_capacity(width * (last - first));
            for (row, tile) in (first..last).flat_map(|row| tiles.iter().map(move |tile| (row, tile))) {
                match tile {
                    DrawnTile::Bytes(tile) => {
                        let width = tile.width as usize;
                        rows.extend(
                            tile.pixels()[row * width..(row + 1) * width].iter().map(values_of_bytes),
                        );
                    }
                    DrawnTile::Linear(tile) => {
                        let width = tile.width as usize;
                        rows.extend(tile.rgba[row * width..(row + 1) * width].iter().map(values_of_light));
                    }
                }
            }
            let reduced = reducer.add(width, &rows).into_iter().flatten();
            match self.shot.linear {
                true => self.linear.extend(reduced.map(light_of_values)),
                false => self.rgba.extend(reduced.flat_map(bytes_of_values)),
            }
        }
    }

    /// Sets the measured time per pixel, in seconds.
    pub fn costs(&mut self, per_px_s: f64) {
        if let SlicePace::Shared(known) = &mut self.pace {
            *known = per_px_s;
        }
    }

    /// Takes the rows of the result that were drawn since this was called last: sRGB and alpha, row by row. What is taken is no part of
    /// [`Self::picture`], so that an image need not fit into memory.
    pub fn take_rows(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.rgba)
    }

    /// Returns the view that is asked for.
    pub fn shot(&self) -> &Shot {
        &self.shot
    }

    /// Returns the view that is drawn, which may be finer.
    pub fn drawn(&self) -> &Shot {
        &self.drawn
    }

    /// Returns the image, once it is complete.
    pub fn picture(mut self) -> Picture {
        if self.shot.linear {
            return self.linear_picture().picture();
        }
        let (width, height) = (self.shot.camera.width, self.shot.camera.height);
        self.rgba.resize(4 * width as usize * height as usize, 0);
        Picture { width, height, rgba: self.rgba }
    }

    /// Returns the image in linear light, without depths, once it is complete.
    pub fn linear_picture(mut self) -> LinearPicture {
        if !self.shot.linear {
            return LinearPicture::of(&self.picture());
        }
        let (width, height) = (self.shot.camera.width, self.shot.camera.height);
        self.linear.resize(width as usize * height as usize, [0.0; 4]);
        LinearPicture { width, height, rgba: self.linear, depths: None }
    }
}

/// Less than this share of a pixel is nothing: its colour is rounding.
const LEAST_ALPHA: f32 = 1e-3;

/// Returns what is reduced of a pixel.
fn values_of_bytes(pixel: &[u8; 4]) -> Values {
    let [r, g, b, alpha] = pixel.map(|byte| f32::from(byte) / 255.0);
    [r * alpha, g * alpha, b * alpha, alpha]
}

fn values_of_light(&[r, g, b, alpha]: &[f32; 4]) -> Values {
    let [r, g, b] = [r, g, b].map(|light| srgb_from_linear(f64::from(light.max(0.0))) as f32 * alpha);
    [r, g, b, alpha]
}

/// Divides reduced values by their alpha. The filter overshoots beside edges.
fn straight([r, g, b, alpha]: Values) -> [f32; 4] {
    let alpha = if alpha < LEAST_ALPHA { 0.0 } else { alpha.min(1.0) };
    let own = |value: f32| if alpha > 0.0 { (value / alpha).max(0.0) } else { 0.0 };
    [own(r), own(g), own(b), alpha]
}

fn bytes_of_values(values: Values) -> [u8; 4] {
    straight(values).map(|value| (255.0 * value.min(1.0)).round() as u8)
}

fn light_of_values(values: Values) -> [f32; 4] {
    let [r, g, b, alpha] = straight(values);
    let [r, g, b] = [r, g, b].map(|value| linear_of_srgb(f64::from(value)) as f32);
    [r, g, b, alpha]
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::{camera_is_world, centred};

    #[test]
    fn rows_are_drawn_at_once_where_they_are_in_the_image_and_the_others_stay_empty() {
        let shot = Shot::new(centred(4, 9, 5.0), camera_is_world());
        let mut sliced = Sliced::of_rows(&shot, ViewExposure::default(), 3..7);
        let band = sliced.tile(16);
        assert_eq!((band.camera.height, band.camera.cy), (4, shot.camera.cy - 3.0));
        sliced.costs(1.0);
        assert!(sliced.add(Picture { width: 4, height: 4, rgba: vec![7; 64] }));
        let picture = sliced.picture();
        let rows: Vec<u8> = picture.rgba.chunks(16).map(|row| row[0]).collect();
        assert_eq!(rows, [0, 0, 0, 7, 7, 7, 7, 0, 0]);
        let mut sliced = Sliced::of_rows(&shot, ViewExposure::default(), 3..7);
        assert!(sliced.add(Picture { width: 4, height: 9, rgba: vec![7; 144] }));
        assert_eq!(sliced.picture().rgba, [7; 144], "a renderer without slices draws all");
    }

    #[test]
    fn rows_in_linear_light_are_joined_and_those_of_bytes_are_taken_as_light() {
        let shot = Shot { linear: true, ..Shot::new(centred(2, 3, 5.0), camera_is_world()) };
        let mut sliced = Sliced::new(&shot, ViewExposure::default());
        let row = |light: f32| LinearPicture { width: 2, height: 1, rgba: vec![[light; 4]; 2], depths: None };
        sliced.pace = SlicePace::Shared(1e9);
        let one = |sliced: &mut Sliced| sliced.rows = sliced.tile(1).camera.height.min(1);
        one(&mut sliced);
        assert!(!sliced.add_linear(row(2.5)));
        one(&mut sliced);
        assert!(!sliced.add(Picture { width: 2, height: 1, rgba: vec![255; 8] }));
        one(&mut sliced);
        assert!(sliced.add_linear(row(0.5)));
        let lights: Vec<f32> = sliced.linear_picture().rgba.iter().map(|pixel| pixel[0]).collect();
        assert_eq!(lights, [2.5, 2.5, 1.0, 1.0, 0.5, 0.5]);
    }

    /// Draws a view of which each pixel shows its column and row in the view that is drawn.
    fn drawn(mut sliced: Sliced, cell_px: u32) -> (Picture, usize) {
        let (whole, mut count) = (sliced.drawn().clone(), 0);
        loop {
            let tile = sliced.tile(cell_px);
            let Shot { camera, .. } = &tile;
            let from = [whole.camera.cx - camera.cx, whole.camera.cy - camera.cy].map(|at| at as u32);
            let colour = |at: u32, of: u32| (255 * at / of) as u8;
            let pixel = |x: u32, y: u32| {
                let [x, y] = [x + from[0], y + from[1]];
                [
                    colour(x, whole.camera.width),
                    colour(y, whole.camera.height),
                    40,
                    if y % 2 == 0 { 255 } else { 0 },
                ]
            };
            let rgba = (0..camera.height).flat_map(|y| (0..camera.width).flat_map(move |x| pixel(x, y)));
            let picture = Picture { width: camera.width, height: camera.height, rgba: rgba.collect() };
            count += 1;
            if sliced.add(picture) {
                return (sliced.picture(), count);
            }
        }
    }

    #[test]
    fn wide_images_are_drawn_in_columns_too_and_each_pixel_is_at_its_place() {
        let shot = Shot::new(centred(9000, 40, 9000.0), camera_is_world());
        let (picture, count) = drawn(Sliced::new(&shot, ViewExposure::default()), 16);
        assert_eq!((picture.width, picture.height, count), (9000, 40, 6));
        for (x, y) in [(0usize, 0usize), (4096, 38), (8999, 16), (4095, 20)] {
            let expected = [(255 * x / 9000) as u8, (255 * y / 40) as u8, 40, 255];
            assert_eq!(picture.pixels()[y * 9000 + x], expected);
        }
    }

    #[test]
    fn a_finer_image_is_reduced_to_the_size_that_is_asked_for_by_its_alpha() {
        let shot = Shot::new(centred(60, 40, 50.0), camera_is_world());
        for finer in [2.0, 5.4, 16.0] {
            let sliced = Sliced::finer(&shot, finer, ViewExposure::default());
            let (picture, _) = drawn(sliced, 16);
            assert_eq!((picture.width, picture.height), (60, 40));
            for (at, pixel) in picture.pixels().iter().enumerate() {
                let (x, y) = (at % 60, at / 60);
                // Every other row is empty: half of a pixel remains, in the colours of the others. The filter ends at the borders.
                let is_inside = (4..56).contains(&x) && (4..36).contains(&y);
                let near =
                    |found: u8, expected: usize, by: usize| usize::from(found).abs_diff(expected) <= by;
                let colours = near(pixel[0], (255 * (2 * x + 1)) / 120, 3)
                    && near(pixel[1], (255 * (2 * y + 1)) / 80, 6);
                assert!(!is_inside || (colours && near(pixel[3], 128, 12)), "{finer}, {x} {y}: {pixel:?}");
            }
        }
    }

    #[test]
    fn an_image_is_never_coarser_than_asked_for_nor_more_than_eight_times_finer() {
        let shot = Shot::new(centred(60, 40, 50.0), camera_is_world());
        let width = |finer| Sliced::finer(&shot, finer, ViewExposure::default()).drawn().camera.width;
        assert_eq!(
            [0.5, 1.0, 1.001, 1.1, 2.0, 3.0, 8.0, 50.0].map(width),
            [60, 60, 60, 66, 120, 120, 240, 480]
        );
    }

    #[test]
    fn tiles_are_halved_to_one_cell_where_nobody_waits_and_the_later_ones_stay_small() {
        let shot = Shot::new(centred(100, 90, 100.0), camera_is_world());
        let size = |tile: &Shot| [tile.camera.width, tile.camera.height];
        let mut sliced = Sliced::new(&shot, ViewExposure::default());
        sliced.tile(16);
        assert!(!sliced.is_divisible(16) && !sliced.halve(16), "a window waits");
        let mut sliced = sliced.alone();
        let mut sizes = vec![size(&sliced.tile(16))];
        while sliced.halve(16) {
            sizes.push(size(&sliced.tile(16)));
        }
        assert_eq!(sizes, [[100, 90], [100, 48], [100, 32], [100, 16], [64, 16], [32, 16], [16, 16]]);
        assert!(!sliced.is_coarser());
        let (picture, count) = drawn(sliced, 16);
        assert_eq!((picture.width, picture.height, count), (100, 90, 42));
    }
}
