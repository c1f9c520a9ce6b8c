//! The warp: a view is made by moving the depth pixels of a layered depth image into it, in an order that needs no depth
//! comparison ([`super::order`]).
//!
//! The picture is divided into bands of [`BAND`] rows, which are independent of each other: each takes the tiles that meet it
//! in drawing order, computes positions run by run, and draws them one after the other. So the result does not depend on the
//! number of threads.

mod pieces;

use std::ops::Range;

use rayon::prelude::*;

use self::pieces::{Piece, pieces_in_order};
use super::layout::{DepthPixelOrigin, Ldi, Level};
use super::spacing::{Factors, Spacing, exact, is_from_behind};
use super::splat::over::OverCanvas;
use super::splat::pixel::{IndexCanvas, PixelCanvas};
use super::splat::sums::{COLOUR, SumsCanvas};
use super::splat::{Canvas, Dot};
use super::transfer::{Positions, RowTransfer, Transfer};
use crate::error::Result;
use crate::projection::{Picture, Shot};
use crate::scene::light::{LINEAR_FROM_BYTE, bytes_of_light_times};
use crate::task::Task;

/// The rows of a band.
pub const BAND: u32 = 64;
/// The spacing from which on a level is fine enough for a picture, as median over the tiles in view.
const FINE_ENOUGH: f64 = 0.5;

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

/// A view that was made of a layered depth image.
#[derive(Debug, Clone, PartialEq)]
pub struct Warped {
    /// The picture.
    pub picture: Picture,
    /// The level that was used.
    pub level: usize,
    /// The depth pixels that are so near that their splats do not close the gaps between them.
    pub too_near: u64,
}

/// Makes a view of a layered depth image. Of the shot, the camera, the pose and whether sides are drawn that the reference
/// camera does not see ([`Shot::backs`]) count.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn warp(ldi: &Ldi, shot: &Shot, options: &WarpOptions, task: &Task) -> Result<Warped> {
    let (width, height) = (shot.camera.width, shot.camera.height);
    let plan = Plan::new(ldi, shot, options);
    let mut rgba = vec![0u8; 4 * width as usize * height as usize];
    let light = light_of_bytes(options.exposure);
    let bytes = options.exposure.map(|gain| bytes_of_light_times(gain.exp()));
    let as_stored = options.exposure == [0.0; 3];
    let exposed = |colour: [u8; 4]| {
        let [r, g, b, a] = colour;
        let brought = |c: usize, byte: u8| bytes[c][usize::from(byte)];
        if as_stored { colour } else { [brought(0, r), brought(1, g), brought(2, b), a] }
    };
    let bands = rgba.par_chunks_mut(4 * width as usize * BAND as usize).enumerate();
    let too_near = bands.map(|(band, out)| {
        task.go_on()?;
        let band = band as u32;
        let rows = BAND.min(height - band * BAND);
        let out = out.as_chunks_mut::<4>().0.iter_mut();
        Ok(match options.splat {
            SplatKind::Pixel => {
                let canvas = plan.draw(band, PixelCanvas::new(width, rows));
                out.zip(canvas.colours).for_each(|(pixel, colour)| *pixel = exposed(colour));
                0
            }
            SplatKind::Over => {
                let canvas = plan.draw(band, OverCanvas::new(width, rows));
                out.zip(canvas.colours()).for_each(|(pixel, colour)| *pixel = exposed(colour));
                canvas.too_near
            }
            SplatKind::Sums => {
                let canvas = plan.draw(band, SumsCanvas::<COLOUR>::new(width, rows, &light));
                out.zip(canvas.colours()).for_each(|(pixel, colour)| *pixel = colour);
                canvas.too_near
            }
        })
    });
    let too_near = too_near.sum::<Result<u64>>()?;
    Ok(Warped { picture: Picture { width, height, rgba }, level: plan.level_index, too_near })
}

/// Finds the depth pixel that is drawn last at each pixel of a view, of those that are mostly opaque: 1 + its index in the
/// level used, 0 where there is none; row by row from the top.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn last_drawn(ldi: &Ldi, shot: &Shot, options: &WarpOptions, task: &Task) -> Result<Vec<u32>> {
    let (width, height) = (shot.camera.width, shot.camera.height);
    let plan = Plan::new(ldi, shot, options);
    let mut indices = vec![0u32; width as usize * height as usize];
    let bands = indices.par_chunks_mut(width as usize * BAND as usize).enumerate();
    bands.try_for_each(|(band, out)| {
        task.go_on()?;
        let band = band as u32;
        let rows = BAND.min(height - band * BAND);
        out.copy_from_slice(&plan.draw(band, IndexCanvas::new(width, rows)).indices);
        Ok(())
    })?;
    Ok(indices)
}

/// Draws all depth pixels of a view on one canvas as high as the picture, for tests of the order.
#[cfg(test)]
pub fn drawn_in_order<C: Canvas>(ldi: &Ldi, shot: &Shot, options: &WarpOptions, canvas: C) -> C {
    Plan::new(ldi, shot, options).draw(0, canvas)
}

/// Returns the linear light of stored values at an exposure, R, G, B.
pub(crate) fn light_of_bytes(exposure: [f64; 3]) -> Box<[[f32; 256]; 3]> {
    let table = |gain: f64| LINEAR_FROM_BYTE.map(|light| (f64::from(light) * gain.exp()) as f32);
    Box::new(exposure.map(table))
}

/// Everything that the bands of one picture share.
pub(crate) struct Plan<'a> {
    /// The level that is drawn.
    pub level: &'a Level,
    level_index: usize,
    rows: RowTransfer,
    factors: Factors,
    /// By number of surface, whether the view shows the side that the reference camera does not see, where such sides are not
    /// drawn; empty where all are.
    behind: Vec<bool>,
    /// The pieces of tiles in drawing order.
    pieces: Vec<Piece>,
    /// True when the layers of a pixel are drawn in the wrong order on purpose.
    reversed: bool,
    unculled: bool,
}

impl<'a> Plan<'a> {
    /// Prepares the drawing of a view.
    pub fn new(ldi: &'a Ldi, shot: &Shot, options: &WarpOptions) -> Self {
        let to_shot = |level: &Level| Transfer::new((&level.camera, &ldi.pose), (&shot.camera, &shot.pose));
        let of_frame = to_shot(&ldi.levels[0]);
        let level_index = match options.level {
            Some(level) => usize::from(level).min(ldi.levels.len() - 1),
            None => level_for(ldi, &of_frame),
        };
        let level = &ldi.levels[level_index];
        let transfer = to_shot(level);
        let factors = match options.spacing {
            Spacing::Exact => Factors::exact(ldi, &of_frame, transfer.focal_ratio),
            Spacing::Table => Factors::table(ldi, &shot.pose, transfer.focal_ratio),
        };
        let reversed = options.order == DrawingOrder::Reversed;
        Self {
            level,
            level_index,
            rows: transfer.rows(),
            factors,
            behind: if shot.backs { Vec::new() } else { seen_from_behind(ldi, &of_frame) },
            pieces: pieces_in_order(level, &transfer, reversed),
            reversed,
            unculled: options.unculled,
        }
    }

    /// Draws the pieces that meet a band on its canvas.
    pub fn draw<C: Canvas>(&self, band: u32, mut canvas: C) -> C {
        let top = (band * BAND) as f32;
        let rows = (top - C::REACH, top + BAND as f32 + C::REACH);
        let mut positions = Positions::default();
        let meets = |piece: &&Piece| self.unculled || piece.meets(rows, C::REACH);
        for piece in self.pieces.iter().filter(meets) {
            for y in piece.rows_in_order() {
                self.draw_row(&mut canvas, piece, y, top, &mut positions);
            }
        }
        canvas
    }

    /// Draws the depth pixels of a row of a piece, in batches that end between layered depth pixels.
    fn draw_row<C: Canvas>(
        &self,
        canvas: &mut C,
        piece: &Piece,
        y: u32,
        top: f32,
        positions: &mut Positions,
    ) {
        let mut rest = piece.row(self.level, y);
        while !rest.is_empty() {
            let batch = self.next_batch(&rest, piece.right);
            if piece.right {
                rest.start = batch.end;
            } else {
                rest.end = batch.start;
            }
            let columns = &self.level.columns[batch.clone()];
            let run = self.rows.start(u32::from(columns[0]), y);
            self.rows.place(&run, columns, &self.level.inverse_depths[batch.clone()], positions);
            canvas.begin(&positions.u[..columns.len()], &positions.v[..columns.len()], top);
            let mut draw = |i: usize| self.draw_one(canvas, batch.start + i, i, top, positions);
            // The layer farthest from the picture's camera comes first: the last one where the camera looks ahead.
            let last_first =
                |i: usize| (self.rows.omega_at_infinity(&run, columns[i].into()) >= 0.0) != self.reversed;
            let ends = [last_first(0), last_first(columns.len() - 1)];
            let single = self.level.tiles[piece.tile].single;
            match (piece.right, ends) {
                (true, _) if single => (0..columns.len()).for_each(draw),
                (false, _) if single => (0..columns.len()).rev().for_each(draw),
                (true, [false, false]) => (0..columns.len()).for_each(draw),
                (false, [true, true]) => (0..columns.len()).rev().for_each(draw),
                (right, _) => {
                    let mut draw_pixel = |pixel: Range<usize>| match last_first(pixel.start) {
                        true => pixel.rev().for_each(&mut draw),
                        false => pixel.for_each(&mut draw),
                    };
                    walk_pixels(columns, right, &mut draw_pixel);
                }
            }
        }
    }

    /// Returns the next batch of a row of a piece: as many depth pixels as fit, without a part of a layered depth pixel
    /// only. A piece's columns are in one run, since its tile's are.
    #[inline]
    fn next_batch(&self, rest: &Range<usize>, right: bool) -> Range<usize> {
        if rest.len() <= Positions::MOST {
            return rest.clone();
        }
        let columns = &self.level.columns;
        let parts = |at: usize| columns[at] == columns[at - 1];
        if right {
            let end = (rest.start + 1..=rest.start + Positions::MOST).rev().find(|&end| !parts(end));
            rest.start..end.unwrap_or(rest.start + Positions::MOST)
        } else {
            let start = (rest.end - Positions::MOST..rest.end).find(|&start| !parts(start));
            start.unwrap_or(rest.end - Positions::MOST)..rest.end
        }
    }

    #[inline(always)]
    fn draw_one<C: Canvas>(&self, canvas: &mut C, index: usize, at: usize, top: f32, positions: &Positions) {
        let (u, v, per_omega) = (positions.u[at], positions.v[at] - top, positions.per_omega[at]);
        let q = self.level.inverse_depths[index] * per_omega;
        if !self.behind.is_empty() && self.behind[usize::from(self.level.surfaces[index])] {
            return;
        }
        let s = if C::SPACED { self.spacing(index, per_omega, q) } else { 1.0 };
        let origin = if C::ORIGINS { self.level.splats[index].origin() } else { DepthPixelOrigin::Photo };
        canvas.draw(&Dot { u, v, q, s, index, at, colour: self.level.colours[index], origin });
    }

    /// Returns the spacing of a depth pixel.
    #[inline]
    fn spacing(&self, index: usize, per_omega: f32, q: f32) -> f32 {
        match &self.factors {
            Factors::Exact(factors) => match self.level.surfaces[index] {
                0 => factors[0] * per_omega,
                surface => exact(factors[usize::from(surface)], per_omega),
            },
            Factors::Table(table) => table[usize::from(self.level.splats[index].entry())] * q,
        }
    }
}

/// Returns, by number, which surfaces a view shows from the side that the reference camera does not see; nothing where there
/// is none.
fn seen_from_behind(ldi: &Ldi, transfer: &Transfer) -> Vec<bool> {
    let known = ldi.surfaces.iter().map(|surface| is_from_behind(surface, transfer));
    let behind: Vec<bool> = std::iter::once(false).chain(known).collect();
    if behind.contains(&true) { behind } else { Vec::new() }
}

/// Visits the layered depth pixels of a row's columns, to the right or to the left.
#[inline]
fn walk_pixels(columns: &[u16], right: bool, visit: &mut impl FnMut(Range<usize>)) {
    let (mut start, mut end) = (0, columns.len());
    while start < end {
        if right {
            let column = columns[start];
            let width = columns[start..end].iter().take_while(|other| **other == column).count();
            visit(start..start + width);
            start += width;
        } else {
            let column = columns[end - 1];
            let width = columns[start..end].iter().rev().take_while(|other| **other == column).count();
            visit(end - width..end);
            end -= width;
        }
    }
}

/// Chooses the finest level whose depth pixels are not much closer together than the picture's pixels: their spacing is
/// [`FINE_ENOUGH`] at least, as median over the tiles in view.
fn level_for(ldi: &Ldi, transfer: &Transfer) -> usize {
    let level = &ldi.levels[0];
    let mut spacings: Vec<(f64, u64)> = Vec::new();
    for piece in pieces_in_order(level, transfer, false) {
        let tile = &level.tiles[piece.tile];
        let middle = f64::midpoint(f64::from(tile.least), f64::from(tile.largest));
        let omega = transfer.homogeneous(piece.centre(), middle).z;
        if omega > 0.0 && piece.meets((0.0, transfer.size[1] as f32), 0.0) {
            spacings.push((transfer.focal_ratio / omega, u64::from(tile.len())));
        }
    }
    spacings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = spacings.iter().map(|(_, weight)| weight).sum::<u64>() / 2;
    let mut seen = 0;
    let median = spacings.iter().find(|(_, weight)| {
        seen += weight;
        seen > half
    });
    let Some((median, _)) = median else { return 0 };
    let coarser = (FINE_ENOUGH / median).log2().ceil().max(0.0) as usize;
    coarser.min(ldi.levels.len() - 1)
}
