//! The layout of a layered depth image in memory: arrays with one entry a depth pixel, rows from the top, in a row by
//! column, in a column nearest first. Nothing is padded to a number of layers.
//!
//! Gortler, He & Cohen, *Rendering Layered Depth Images* (MSR-TR-97-09, 1997), section 2, with arrays for their structure
//! of slots, and inverse depth instead of depth.

use std::ops::Range;

use glam::DVec3;

use super::report::LdiReport;
use super::tiles::Tile;
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::scene::FaceIndex;

/// The longest side of a frame in pixels.
pub const LONGEST_SIDE: u32 = 16_384;
/// The largest number of surfaces that depth pixels can name; 0 stands for an unknown one.
pub const MOST_SURFACES: usize = u16::MAX as usize;
/// The largest inverse depth that is valid, in 1/world unit.
pub const LARGEST_INVERSE_DEPTH: f32 = 1e18;

/// A layered depth image: all surfaces along the rays of one pinhole camera, the *reference camera*.
#[derive(Debug, Clone, PartialEq)]
pub struct Ldi {
    /// What it was made from.
    pub kind: LdiKind,
    /// The hash of everything that it was made of; empty for depth images from elsewhere.
    pub inputs: String,
    /// The reference camera, with the size of the frame in pixels, which may be larger than the photo's.
    pub camera: Pinhole,
    /// The reference camera's pose, world to camera.
    pub pose: Pose,
    /// Where the photo is in the frame, in pixels; `None` where the camera is no photo's.
    pub photo_rect: Option<PixelRect>,
    /// Natural logarithms of the exposure of its colours over the common exposure: R, G, B.
    pub gain: [f64; 3],
    /// The surfaces that depth pixels name: number i is `surfaces[i - 1]`.
    pub surfaces: Vec<LdiSurface>,
    /// The names of the photos or files that it was made from.
    pub sources: Vec<String>,
    /// The levels of resolution: the first has the frame's size, each other one half of the one before.
    pub levels: Vec<ResolutionLevel>,
    /// What its making reports.
    pub report: LdiReport,
}

impl Ldi {
    /// Returns the image with what its camera sees alone: its depth image ([`ResolutionLevel::nearest`]).
    pub fn depth_image(&self) -> Self {
        self.with_levels(self.levels.iter().map(ResolutionLevel::nearest).collect())
    }

    pub(super) fn with_levels(&self, levels: Vec<ResolutionLevel>) -> Self {
        let Self { kind, camera, pose, photo_rect, gain, .. } = *self;
        Self {
            kind,
            inputs: self.inputs.clone(),
            camera,
            pose,
            photo_rect,
            gain,
            surfaces: self.surfaces.clone(),
            sources: self.sources.clone(),
            levels,
            report: self.report.clone(),
        }
    }

    /// Returns the camera of the photo, which is the reference camera without the guard band about the photo; the reference
    /// camera where it is no photo's.
    pub fn own_camera(&self) -> Pinhole {
        let Some(PixelRect { x, y, w: width, h: height }) = self.photo_rect else { return self.camera };
        let (cx, cy) = (self.camera.cx - f64::from(x), self.camera.cy - f64::from(y));
        Pinhole { width, height, cx, cy, ..self.camera }
    }

    /// Returns the image without the nearest `count` depth pixels of each layered depth pixel: what is behind them. Surfaces,
    /// sources and report stay those of the whole image.
    pub fn without_nearest(&self, count: u32) -> Self {
        self.with_levels(self.levels.iter().map(|level| level.without_nearest(count as usize)).collect())
    }

    /// Returns the image without what is infinitely far away, and of a stack without what rises above outlines before it, which
    /// is on no surface.
    pub fn without_surroundings(&self) -> Self {
        let on_surfaces = self.kind == LdiKind::Stack && self.report.unknown_surfaces == 0;
        let of_level = |level: &ResolutionLevel| level.without_surroundings(on_surfaces);
        self.with_levels(self.levels.iter().map(of_level).collect())
    }

    /// Returns the image without what is infinitely far away from a row of the frame on downwards.
    pub fn without_surroundings_from(&self, row: u32) -> Self {
        let height = f64::from(self.camera.height.max(1));
        let of_level = |level: &ResolutionLevel| {
            let row = (f64::from(row) / height * f64::from(level.camera.height)).round() as u32;
            level.without_surroundings_from(row)
        };
        self.with_levels(self.levels.iter().map(of_level).collect())
    }

    /// Returns the image without depth pixels that are hidden right behind an opaque one: their inverse depth differs from its
    /// by no more than a share. Splats of both would be mixed.
    pub fn without_close(&self, share: f32) -> Self {
        self.with_levels(self.levels.iter().map(|level| level.without_close(share)).collect())
    }

    /// Returns the image without the depth pixels of the surfaces that `left_out` marks, in the order of [`Self::surfaces`].
    pub fn without_surfaces(&self, left_out: &[bool]) -> Self {
        self.with_levels(self.levels.iter().map(|level| level.without_surfaces(left_out)).collect())
    }

    /// Returns the bytes that its depth pixels take in memory.
    pub fn bytes(&self) -> u64 {
        let of_level = |level: &ResolutionLevel| 13 * level.len() as u64 + 4 * level.rows.len() as u64;
        self.levels.iter().map(of_level).sum()
    }
}

/// What a layered depth image was made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LdiKind {
    /// The image layers of one photo.
    Stack,
    /// The depth images of several photos, warped into one camera.
    Photos,
    /// All that the photos together show, rendered for one camera.
    Site,
    /// Depth images from elsewhere.
    Depth,
}

impl LdiKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Stack, Self::Photos, Self::Site, Self::Depth];

    /// Returns the kind's name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stack => "stack",
            Self::Photos => "photos",
            Self::Site => "site",
            Self::Depth => "depth",
        }
    }
}

/// A plane that depth pixels belong to.
#[derive(Debug, Clone, PartialEq)]
pub struct LdiSurface {
    /// The inverse depth of the plane at image position (x, y) of the frame, in pixels: `nu . (x, y, 1)`, in 1/world unit.
    pub nu: DVec3,
    /// The unique name of the object.
    pub object: String,
    /// The face's index within the object; `None` for the surroundings.
    pub face: Option<FaceIndex>,
}

/// Where the colour of a depth pixel is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum DepthPixelOrigin {
    /// The reference camera's own photo.
    Photo = 0,
    /// Paint.
    Paint = 1,
    /// Other photos.
    OtherPhotos = 2,
    /// Inpainted.
    Invented = 3,
}

impl DepthPixelOrigin {
    /// All origins, by their numbers.
    pub const ALL: [Self; 4] = [Self::Photo, Self::Paint, Self::OtherPhotos, Self::Invented];
}

/// The splat index of a depth pixel: six bits for the table of the published spacing ([`super::spacing`]), two for the
/// origin of its colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Splat(pub u8);

impl Splat {
    /// Makes an index of an entry of the table, 0..64, and an origin.
    pub fn new(entry: u8, origin: DepthPixelOrigin) -> Self {
        Self((entry & 63) | ((origin as u8) << 6))
    }

    /// Returns the entry of the table, 0..64.
    pub fn entry(self) -> u8 {
        self.0 & 63
    }

    /// Returns the origin of the colour.
    pub fn origin(self) -> DepthPixelOrigin {
        DepthPixelOrigin::ALL[usize::from(self.0 >> 6)]
    }

    /// Returns the index with another entry of the table.
    pub fn with_entry(self, entry: u8) -> Self {
        Self::new(entry, self.origin())
    }
}

/// One sample of a surface: what the arrays of a [`ResolutionLevel`] hold at one index.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DepthPixel {
    /// Inverse depth 1/z along the reference camera's axis, in 1/world unit; finite, >= 0. 0 is infinitely far.
    pub inverse_depth: f32,
    /// sRGB and opacity, not premultiplied.
    pub colour: [u8; 4],
    /// 0 for an unknown surface, otherwise 1 + its index in [`Ldi::surfaces`].
    pub surface: u16,
    /// The splat index.
    pub splat: Splat,
}

/// One resolution of a layered depth image. The arrays from `columns` on have one entry a depth pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct ResolutionLevel {
    /// The reference camera at this resolution.
    pub camera: Pinhole,
    /// `height + 1` offsets: the depth pixels of row y are `rows[y]..rows[y + 1]`.
    pub rows: Vec<u32>,
    /// The column of each depth pixel; within a row it never decreases.
    pub columns: Vec<u16>,
    /// See [`DepthPixel::inverse_depth`]; within a layered depth pixel it never increases.
    pub inverse_depths: Vec<f32>,
    /// See [`DepthPixel::colour`].
    pub colours: Vec<[u8; 4]>,
    /// See [`DepthPixel::surface`].
    pub surfaces: Vec<u16>,
    /// See [`DepthPixel::splat`].
    pub splats: Vec<Splat>,
    /// Tiles of the frame with the range of their depths, derived: see [`Tile`].
    pub tiles: Vec<Tile>,
}

impl ResolutionLevel {
    /// Makes a level without depth pixels, to whose end rows can be added.
    pub fn without_rows(camera: Pinhole) -> Self {
        Self {
            camera,
            rows: vec![0],
            columns: Vec::new(),
            inverse_depths: Vec::new(),
            colours: Vec::new(),
            surfaces: Vec::new(),
            splats: Vec::new(),
            tiles: Vec::new(),
        }
    }

    /// Makes a level of all its rows: each has its depth pixels with their columns, in the order of the layout.
    pub fn of_rows(camera: Pinhole, rows: impl IntoIterator<Item = Vec<(u16, DepthPixel)>>) -> Self {
        let mut level = Self::without_rows(camera);
        rows.into_iter().for_each(|row| level.push_row(&row));
        level.finished()
    }

    /// Adds the next row.
    pub fn push_row(&mut self, row: &[(u16, DepthPixel)]) {
        self.columns.extend(row.iter().map(|(column, _)| *column));
        self.inverse_depths.extend(row.iter().map(|(_, pixel)| pixel.inverse_depth));
        self.colours.extend(row.iter().map(|(_, pixel)| pixel.colour));
        self.surfaces.extend(row.iter().map(|(_, pixel)| pixel.surface));
        self.splats.extend(row.iter().map(|(_, pixel)| pixel.splat));
        self.rows.push(self.columns.len() as u32);
    }

    /// Returns the level with its tiles, once all rows were added.
    pub fn finished(mut self) -> Self {
        debug_assert_eq!(self.rows.len(), self.camera.height as usize + 1);
        self.tiles = Tile::all_of(&self);
        self
    }

    /// Returns the number of depth pixels.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Returns true when it has no depth pixel.
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    /// Returns the indices of the depth pixels of row `y`.
    pub fn row(&self, y: u32) -> Range<usize> {
        self.rows[y as usize] as usize..self.rows[y as usize + 1] as usize
    }

    /// Returns the indices of the depth pixels of row `y` whose columns are in a range.
    pub fn row_within(&self, y: u32, columns: &Range<u32>) -> Range<usize> {
        let row = self.row(y);
        let of_row = &self.columns[row.clone()];
        let before = |end: u32| row.start + of_row.partition_point(|&column| u32::from(column) < end);
        before(columns.start)..before(columns.end)
    }

    /// Returns the layered depth pixels of row `y` from the left: the indices of each one's depth pixels, nearest first.
    pub fn layered_pixels(&self, y: u32) -> impl Iterator<Item = Range<usize>> + '_ {
        let row = self.row(y);
        let first = row.start;
        self.columns[row].chunk_by(|a, b| a == b).scan(first, |at, chunk| {
            let from = *at;
            *at += chunk.len();
            Some(from..*at)
        })
    }

    /// Returns the depth pixel at an index.
    pub fn pixel(&self, index: usize) -> DepthPixel {
        DepthPixel {
            inverse_depth: self.inverse_depths[index],
            colour: self.colours[index],
            surface: self.surfaces[index],
            splat: self.splats[index],
        }
    }

    /// Returns whether an opaque depth pixel is before the one at an index, so that the reference camera does not see it.
    pub fn is_hidden(&self, index: usize) -> bool {
        let Some(before) = index.checked_sub(1) else { return false };
        self.columns[before] == self.columns[index]
            && self.colours[before][3] == u8::MAX
            // The one before may be the last of the row above.
            && self.rows.binary_search(&(index as u32)).is_err()
    }

    /// Returns the layered depth pixel at a position: its depth pixels, nearest first.
    pub fn at(&self, x: u32, y: u32) -> Range<usize> {
        let row = self.row(y);
        // Where every column up to it has one depth pixel, there is nothing to search.
        let guess = row.start
            + (x as usize).saturating_sub(self.columns.get(row.start).map_or(0, |first| usize::from(*first)));
        let is_at = |index: usize| row.contains(&index) && u32::from(self.columns[index]) == x;
        if is_at(guess) && !is_at(guess + 1) && !(guess > row.start && is_at(guess - 1)) {
            return guess..guess + 1;
        }
        self.row_within(y, &(x..x + 1))
    }

    /// Returns the level with what the reference camera sees alone: of each layered depth pixel the depth pixels up to the
    /// first opaque one. This is the depth image of the camera.
    pub fn nearest(&self) -> Self {
        let row = |y: u32| {
            let seen = |pixel: Range<usize>| {
                let opaque = pixel.clone().position(|index| self.colours[index][3] == u8::MAX);
                let end = opaque.map_or(pixel.end, |at| pixel.start + at + 1);
                (pixel.start..end).map(|index| (self.columns[index], self.pixel(index)))
            };
            self.layered_pixels(y).flat_map(seen).collect::<Vec<_>>()
        };
        Self::of_rows(self.camera, (0..self.camera.height).map(row))
    }

    /// Returns the level without the nearest `count` depth pixels of each layered depth pixel.
    pub fn without_nearest(&self, count: usize) -> Self {
        let behind = |pixel: Range<usize>| (pixel.start + count).min(pixel.end)..pixel.end;
        self.of_those(|y| self.layered_pixels(y).flat_map(behind))
    }

    /// Returns the level without what is infinitely far away, and also without what is on no surface where `on_surfaces`.
    pub fn without_surroundings(&self, on_surfaces: bool) -> Self {
        let is_near =
            |index: &usize| self.inverse_depths[*index] > 0.0 && !(on_surfaces && self.surfaces[*index] == 0);
        self.of_those(|y| self.row(y).filter(is_near))
    }

    /// Returns the level without what is infinitely far away in a row and in those below.
    fn without_surroundings_from(&self, row: u32) -> Self {
        self.of_those(|y| self.row(y).filter(move |index| y < row || self.inverse_depths[*index] > 0.0))
    }

    /// Returns the level without depth pixels right behind an opaque one: see [`Ldi::without_close`].
    pub fn without_close(&self, share: f32) -> Self {
        // The last opaque depth pixel of the layered one that is left: its column and inverse depth.
        let is_left = |before: &mut Option<(u16, f32)>, index: usize| {
            let (column, inverse_depth) = (self.columns[index], self.inverse_depths[index]);
            let hides = |(of, nearer): (u16, f32)| of == column && nearer - inverse_depth <= share * nearer;
            if before.is_some_and(hides) {
                return false;
            }
            if self.colours[index][3] == u8::MAX {
                *before = Some((column, inverse_depth));
            }
            true
        };
        self.of_those(|y| {
            let mut before = None;
            self.row(y).filter(move |index| is_left(&mut before, *index))
        })
    }

    /// Returns the level without the depth pixels of some surfaces: see [`Ldi::without_surfaces`].
    fn without_surfaces(&self, left_out: &[bool]) -> Self {
        let stays = |index: &usize| match self.surfaces[*index] {
            0 => true,
            number => !left_out[usize::from(number) - 1],
        };
        self.of_those(|y| self.row(y).filter(stays))
    }

    /// Returns the level of those depth pixels of each row whose indices are given, in their order.
    fn of_those<I: Iterator<Item = usize>>(&self, indices: impl Fn(u32) -> I) -> Self {
        let row = |y| indices(y).map(|index| (self.columns[index], self.pixel(index))).collect();
        Self::of_rows(self.camera, (0..self.camera.height).map(row))
    }

    /// Returns the number of layered depth pixels that hold any depth pixel.
    pub fn layered(&self) -> u64 {
        (0..self.camera.height).map(|y| self.layered_pixels(y).count() as u64).sum()
    }

    /// Returns how many layered depth pixels have each number of layers, from none on.
    pub fn histogram(&self) -> Vec<u64> {
        let mut histogram = vec![0u64];
        for y in 0..self.camera.height {
            for pixel in self.layered_pixels(y) {
                if histogram.len() <= pixel.len() {
                    histogram.resize(pixel.len() + 1, 0);
                }
                histogram[pixel.len()] += 1;
            }
        }
        let held: u64 = histogram.iter().sum();
        histogram[0] = u64::from(self.camera.width) * u64::from(self.camera.height) - held;
        histogram
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixel(inverse_depth: f32) -> DepthPixel {
        DepthPixel { inverse_depth, colour: [1, 2, 3, 255], surface: 0, splat: Splat(0) }
    }

    fn small() -> ResolutionLevel {
        let camera = Pinhole { width: 4, height: 2, fx: 4.0, fy: 4.0, cx: 2.0, cy: 1.0 };
        let rows = [vec![(1, pixel(2.0)), (1, pixel(1.0)), (3, pixel(0.5))], vec![(0, pixel(1.5))]];
        ResolutionLevel::of_rows(camera, rows)
    }

    #[test]
    fn the_depth_pixels_of_rows_columns_and_pixels_are_found() {
        let level = small();
        assert_eq!(level.rows, [0, 3, 4]);
        assert_eq!(level.row_within(0, &(0..2)), 0..2);
        assert_eq!((level.at(3, 0), level.at(2, 0), level.at(0, 1)), (2..3, 2..2, 3..4));
        assert_eq!(level.layered_pixels(0).collect::<Vec<_>>(), [0..2, 2..3]);
        assert_eq!((level.layered(), level.len()), (3, 4));
        assert_eq!(level.histogram(), [5, 2, 1]);
        assert_eq!(level.pixel(1), pixel(1.0));
        assert_eq!([0, 1, 2, 3].map(|index| level.is_hidden(index)), [false, true, false, false]);
        let one_column = Pinhole { width: 1, ..level.camera };
        let column = ResolutionLevel::of_rows(one_column, [vec![(0, pixel(2.0))], vec![(0, pixel(1.0))]]);
        assert!(!column.is_hidden(1), "it is in a row of its own");
    }

    #[test]
    fn without_the_nearest_the_depth_pixels_behind_them_are_left() {
        let level = small();
        assert_eq!(level.without_nearest(0), level);
        let behind = level.without_nearest(1);
        assert_eq!((behind.len(), behind.pixel(0)), (1, pixel(1.0)));
        assert_eq!((behind.rows.clone(), behind.columns.clone()), (vec![0, 1, 1], vec![1]));
        assert!(level.without_nearest(2).is_empty() && level.without_nearest(9).is_empty());
        assert_eq!(level.without_surroundings(false), level);
        assert!(level.without_surroundings(true).is_empty(), "nothing is on a known surface");
        assert_eq!(level.without_close(0.49), level);
        assert_eq!(level.without_close(0.5).inverse_depths, [2.0, 0.5, 1.5], "1 is half of 2 behind it");
        let sky = ResolutionLevel::of_rows(
            level.camera,
            [vec![(1, pixel(2.0)), (1, pixel(0.0)), (3, pixel(0.0))], vec![]],
        );
        let near = sky.without_surroundings(false);
        assert_eq!((near.columns.clone(), near.inverse_depths.clone()), (vec![1], vec![2.0]));
        assert_eq!((sky.without_surroundings_from(0), sky.without_surroundings_from(1)), (near, sky));
    }

    #[test]
    fn a_splat_index_holds_its_entry_and_its_origin() {
        for origin in DepthPixelOrigin::ALL {
            let splat = Splat::new(37, origin);
            assert_eq!((splat.entry(), splat.origin()), (37, origin));
            assert_eq!(splat.with_entry(5), Splat::new(5, origin));
        }
    }
}
