//! The warp: a view is made by moving the depth pixels of a layered depth image into it, in an order that needs no depth
//! comparison ([`super::order`]).
//!
//! The picture is divided into bands of [`BAND`] rows, which are independent of each other: each takes the tiles that meet it
//! in drawing order, computes positions run by run, and draws them one after the other. So the result does not depend on the
//! number of threads.

mod batch;
mod drawing;
pub mod moves;
mod several;
mod tile_parts;

use std::ops::Range;

use rayon::prelude::*;

use self::batch::Batch;
use self::drawing::BandDrawing;
#[cfg(test)]
pub use self::several::set_drawn_in_order;
pub use self::several::{check_splat, common_level, warp_set};
use self::tile_parts::{TilePart, tile_parts_in_order};
use super::layout::{Ldi, ResolutionLevel};
use super::spacing::{Factors, Spacing, gradients, is_from_behind, largest, slope};
use super::splat::Canvas;
use super::splat::pixel::IndexCanvas;
use super::stretch::{PlaneMap, Squares, plane_maps};
use super::transfer::{RowTransfer, Transfer};
use quadratura_base::error::Result;
use quadratura_base::scene::light::LINEAR_FROM_BYTE;
use quadratura_base::task::Task;
use quadratura_view::{Picture, Quality, Shot};

/// The rows of a band.
pub const BAND: u32 = 64;

/// Returns the spacing from which on a level is fine enough for a picture, as median over the tiles in view. Depth pixels are
/// squares in the reference camera: where a picture shows a surface from the side, they are closer together along one axis than
/// along the other, so that final pictures take one level more.
fn fine_enough(quality: Quality) -> f64 {
    match quality {
        Quality::Preview | Quality::Finer => 0.5,
        Quality::Final => 0.25,
    }
}

/// What depth pixels are drawn with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SplatKind {
    /// One pixel.
    Pixel,
    /// The published masks.
    Over,
    /// Sums of weights in two slots.
    #[default]
    Sums,
}

/// The order in which depth pixels are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DrawingOrder {
    /// McMillan's: nearer ones come last.
    #[default]
    McMillan,
    /// The opposite, for tests, which have to fail with it.
    Reversed,
}

/// The options of a warp.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WarpOptions {
    /// What depth pixels are drawn with.
    pub splat: SplatKind,
    /// How the spacing is found.
    pub spacing: Spacing,
    /// The order of drawing.
    pub order: DrawingOrder,
    /// The level; `None` chooses the finest one that is not too fine for the picture.
    pub level: Option<u8>,
    /// Natural logarithms of the picture's exposure over that of the colours: R, G, B.
    pub exposure: [f64; 3],
    /// True when tiles that do not meet a band are drawn on it, too, which must change nothing: for tests.
    pub unculled: bool,
}

/// A view that was made of layered depth images.
#[derive(Debug, Clone, PartialEq)]
pub struct Warped {
    /// The picture.
    pub picture: Picture,
    /// The level that was used; of several images that of the first one.
    pub level: usize,
    /// The depth pixels of the levels that were used.
    pub depth_pixels: u64,
    /// The depth pixels that are so near that their splats do not close the gaps between them.
    pub too_near: u64,
}

/// Makes a view of a layered depth image. Of the shot, the camera, the pose, the quality, by which the level is chosen, and whether
/// sides are drawn that the reference camera does not see ([`Shot::backs`]) count.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn warp(ldi: &Ldi, shot: &Shot, options: &WarpOptions, task: &Task) -> Result<Warped> {
    let plan = task.timed("place", || Plan::new(ldi, shot, options));
    drawn(&[Exposed { plan, exposure: options.exposure }], shot, options.splat, task)
}

/// An image as it is drawn, with natural logarithms of the picture's exposure over that of its colours: R, G, B.
struct Exposed<'a> {
    plan: Plan<'a>,
    exposure: [f64; 3],
}

/// Draws images one after the other on the same canvases. Those of several exposures can be summed alone.
fn drawn(images: &[Exposed], shot: &Shot, splat: SplatKind, task: &Task) -> Result<Warped> {
    let (width, height) = (shot.camera.width, shot.camera.height);
    let mut rgba = vec![0u8; 4 * width as usize * height as usize];
    let drawing = BandDrawing::new(images, splat, width);
    let bands = rgba.par_chunks_mut(4 * width as usize * BAND as usize).enumerate();
    let too_near = bands.map_init(
        || None,
        |spare, (band, out)| {
            task.check_cancelled()?;
            Ok(drawing.draw(band as u32, out.as_chunks_mut::<4>().0, spare, task))
        },
    );
    let too_near = too_near.sum::<Result<u64>>()?;
    let level = images.first().map_or(0, |image| image.plan.level_index);
    let depth_pixels = images.iter().map(|image| image.plan.level.len() as u64).sum();
    Ok(Warped { picture: Picture { width, height, rgba }, level, depth_pixels, too_near })
}

/// Finds the depth pixel that is drawn last at each pixel of a view, of those that are mostly opaque: 1 + its index in the
/// level used, 0 where there is none; row by row from the top.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn last_drawn(ldi: &Ldi, shot: &Shot, options: &WarpOptions, task: &Task) -> Result<Vec<u32>> {
    let (width, height) = (shot.camera.width, shot.camera.height);
    let plan = Plan::new(ldi, shot, options);
    let mut indices = vec![0u32; width as usize * height as usize];
    let bands = indices.par_chunks_mut(width as usize * BAND as usize).enumerate();
    bands.try_for_each(|(band, out)| {
        task.check_cancelled()?;
        let band = band as u32;
        let rows = BAND.min(height - band * BAND);
        out.copy_from_slice(plan.draw(band, IndexCanvas::new(width, rows)).indices());
        Ok(())
    })?;
    Ok(indices)
}

/// Returns the level that a view is made of.
pub(super) fn level_of(ldi: &Ldi, shot: &Shot, options: &WarpOptions) -> usize {
    match options.level {
        Some(level) => usize::from(level).min(ldi.levels.len() - 1),
        None => {
            let transfer = Transfer::new(&ldi.levels[0].camera, &ldi.pose, &shot.camera, &shot.pose);
            level_by(&mut spacings_in_view(ldi, &transfer), ldi.levels.len(), shot.quality)
        }
    }
}

/// Draws all depth pixels of a view on one canvas as high as the picture, for tests of the order.
#[cfg(test)]
pub fn drawn_in_order<C: Canvas>(ldi: &Ldi, shot: &Shot, options: &WarpOptions, canvas: C) -> C {
    Plan::new(ldi, shot, options).draw(0, canvas)
}

/// Returns the linear light of stored values at an exposure, R, G, B.
pub fn light_of_bytes(exposure: [f64; 3]) -> Box<[[f32; 256]; 3]> {
    let table = |gain: f64| LINEAR_FROM_BYTE.map(|light| (f64::from(light) * gain.exp()) as f32);
    Box::new(exposure.map(table))
}

/// Everything that the bands of one picture share.
pub(crate) struct Plan<'a> {
    /// The level that is drawn.
    pub level: &'a ResolutionLevel,
    level_index: usize,
    transfer: Transfer,
    rows: RowTransfer,
    factors: Factors,
    /// By number of surface: see [`gradients`].
    gradients: Vec<[f32; 2]>,
    /// By number of surface: see [`slope`].
    slopes: Vec<f32>,
    /// By number of surface: the the maps of planes; empty where the spacing is by the table.
    maps: Vec<PlaneMap>,
    /// Likewise: by which it is told where depth pixels are stretched.
    squares: Vec<Squares>,
    /// By number of surface, whether the view shows the side that the reference camera does not see, where such sides are not
    /// drawn; empty where all are.
    behind: Vec<bool>,
    /// The parts of tiles in drawing order.
    parts: Vec<TilePart>,
    /// True when the layers of a pixel are drawn in the wrong order on purpose.
    reversed: bool,
    unculled: bool,
}

impl<'a> Plan<'a> {
    /// Prepares the drawing of a view.
    pub fn new(ldi: &'a Ldi, shot: &Shot, options: &WarpOptions) -> Self {
        let to_shot =
            |level: &ResolutionLevel| Transfer::new(&level.camera, &ldi.pose, &shot.camera, &shot.pose);
        let of_frame = to_shot(&ldi.levels[0]);
        let level_index = level_of(ldi, shot, options);
        let level = &ldi.levels[level_index];
        let transfer = to_shot(level);
        let factors = match options.spacing {
            Spacing::Exact => Factors::exact(ldi, &of_frame, transfer.focal_ratio),
            Spacing::Table => Factors::table(ldi, &shot.pose, transfer.focal_ratio),
        };
        let side = transfer.focal_ratio / of_frame.focal_ratio;
        let maps = match options.spacing {
            Spacing::Exact => plane_maps(ldi, &of_frame, side),
            Spacing::Table => Vec::new(),
        };
        let reversed = options.order == DrawingOrder::Reversed;
        let (rows, gradients) = (transfer.rows(), gradients(ldi, &of_frame));
        let squares: Vec<Squares> = maps.iter().map(Squares::new).collect();
        let roots: Vec<f32> = squares.iter().map(|squares| squares.largest_root(rows.half)).collect();
        let mut parts = tile_parts_in_order(level, &transfer, reversed);
        for part in &mut parts {
            let surfaces = &level.tiles[part.tile].surfaces;
            part.largest_spacing = largest(factors.largest(surfaces), part.least_omega);
            let root = surfaces.iter().filter_map(|surface| roots.get(usize::from(*surface)));
            let root = root.copied().fold(0.0, f32::max);
            // No number where all planes are unknown, and some points are behind the camera.
            part.largest_stretch = (root / part.least_omega).max(0.0);
        }
        Self {
            level,
            level_index,
            transfer,
            rows,
            factors,
            slopes: gradients.iter().map(|gradient| slope(*gradient)).collect(),
            gradients,
            squares,
            maps,
            behind: if shot.backs { Vec::new() } else { seen_from_behind(ldi, &of_frame) },
            parts,
            reversed,
            unculled: options.unculled,
        }
    }

    /// Draws the parts of tiles that meet a band on its canvas.
    pub fn draw<C: Canvas>(&self, band: u32, canvas: C) -> C {
        let rows = band * BAND..(band + 1) * BAND;
        self.draw_tile_parts(&self.tile_parts_on::<C>(&rows), &rows, canvas)
    }

    /// Returns the indices of the parts of tiles that meet rows of the picture, in drawing order.
    pub fn tile_parts_on<C: Canvas>(&self, rows: &Range<u32>) -> Vec<usize> {
        let meets = |(_, part): &(usize, &TilePart)| {
            let (rows, reach) = reached::<C>(part, rows);
            self.unculled || part.meets(rows, reach)
        };
        self.parts.iter().enumerate().filter(meets).map(|(index, _)| index).collect()
    }

    /// Draws some parts of tiles, in their order, on a canvas of these rows of the picture.
    pub fn draw_tile_parts<C: Canvas>(&self, parts: &[usize], rows: &Range<u32>, canvas: C) -> C {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has what the function is compiled for.
            return unsafe { self.draw_by_avx2(parts, rows, canvas) };
        }
        self.draw_by_any(parts, rows, canvas)
    }

    /// The same, compiled for processors with AVX2. No operations are fused and none is estimated, so the results are those of
    /// any other processor.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn draw_by_avx2<C: Canvas>(&self, parts: &[usize], rows: &Range<u32>, canvas: C) -> C {
        self.draw_by_any(parts, rows, canvas)
    }

    #[inline(always)]
    fn draw_by_any<C: Canvas>(&self, parts: &[usize], rows: &Range<u32>, mut canvas: C) -> C {
        let top = rows.start as f32;
        let mut batch = Batch::default();
        let mut parts = parts.iter().map(|index| &self.parts[*index]).peekable();
        while let Some(part) = parts.next() {
            let next = parts.peek();
            let (rows, _) = reached::<C>(part, rows);
            let is_whole = self.unculled || part.is_within(rows);
            let mut drawn = 0;
            while let Some(y) = part.row_in_order(drawn) {
                if let Some(next) = next {
                    self.fetch_row::<C>(next, drawn);
                }
                if is_whole || part.row_meets(self.level, &self.transfer, y, rows) {
                    self.draw_row(&mut canvas, part, y, top, &mut batch);
                }
                drawn += 1;
            }
        }
        canvas
    }
}

/// Returns the rows on which the points of a tile's part may be that is drawn on these rows, and how far its splats reach.
#[inline]
fn reached<C: Canvas>(part: &TilePart, rows: &Range<u32>) -> ((f32, f32), f32) {
    let reach = C::reach(part.largest_spacing, part.largest_stretch);
    ((rows.start as f32 - reach, rows.end as f32 + reach), reach)
}

/// Returns, by number, which surfaces a view shows from the side that the reference camera does not see; nothing where there
/// is none.
fn seen_from_behind(ldi: &Ldi, transfer: &Transfer) -> Vec<bool> {
    let known = ldi.surfaces.iter().map(|surface| is_from_behind(surface, transfer));
    let behind: Vec<bool> = std::iter::once(false).chain(known).collect();
    if behind.contains(&true) { behind } else { Vec::new() }
}

/// Returns the spacings in the middle of the tiles of the first level that are in view, each with its depth pixels.
fn spacings_in_view(ldi: &Ldi, transfer: &Transfer) -> Vec<(f64, u64)> {
    let level = &ldi.levels[0];
    let mut spacings: Vec<(f64, u64)> = Vec::new();
    for part in tile_parts_in_order(level, transfer, false) {
        let tile = &level.tiles[part.tile];
        let middle = f64::midpoint(f64::from(tile.least), f64::from(tile.largest));
        let omega = transfer.homogeneous(part.centre(), middle).z;
        if omega > 0.0 && part.meets((0.0, transfer.size[1] as f32), 0.0) {
            spacings.push((transfer.focal_ratio / omega, u64::from(tile.len())));
        }
    }
    spacings
}

/// Chooses one of so many levels by the spacings in view: the finest one whose depth pixels are not much closer together than the
/// picture's pixels, see [`fine_enough`].
fn level_by(spacings: &mut [(f64, u64)], levels: usize, quality: Quality) -> usize {
    spacings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = spacings.iter().map(|(_, weight)| weight).sum::<u64>() / 2;
    let mut seen = 0;
    let median = spacings.iter().find(|(_, weight)| {
        seen += weight;
        seen > half
    });
    let Some((median, _)) = median else { return 0 };
    let coarser = (fine_enough(quality) / median).log2().ceil().max(0.0) as usize;
    coarser.min(levels - 1)
}
