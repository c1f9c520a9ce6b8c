//! Batches: up to 256 depth pixels of one row, whose positions are computed together, before they are drawn one after the
//! other.

use std::ops::Range;

use super::Plan;
use super::tile_parts::TilePart;
use crate::layout::{DepthPixelOrigin, Splat};
use crate::spacing::{Factors, exact};
use crate::splat::sums::{COVERS, LEVEL};
use crate::splat::{BatchPositions, Canvas, Dot};
use crate::stretch::{Stretch, jacobian};
use crate::transfer::{Positions, RunStart};

/// What is computed for the depth pixels of a batch: inverse depths and spacings only where the canvas asks for them.
#[derive(Debug)]
pub struct Batch {
    positions: Positions,
    /// Inverse depths in the picture's camera.
    q: [f32; Positions::MOST],
    /// Spacings.
    s: [f32; Positions::MOST],
    /// How stretched depth pixels are stretched.
    stretches: [Stretch; Positions::MOST],
}

impl Default for Batch {
    fn default() -> Self {
        Self {
            positions: Positions::default(),
            q: [0.0; Positions::MOST],
            s: [1.0; Positions::MOST],
            stretches: [Stretch::default(); Positions::MOST],
        }
    }
}

/// The depth pixels of a batch as they are drawn.
struct Dots<'a> {
    batch: &'a Batch,
    colours: &'a [[u8; 4]],
    splats: &'a [Splat],
    surfaces: &'a [u16],
    /// By number of surface.
    slopes: &'a [f32],
    /// The index of the first in its level.
    first: usize,
    /// The first of the rows that are drawn on.
    top: f32,
}

impl Dots<'_> {
    #[inline(always)]
    fn draw<C: Canvas>(&self, canvas: &mut C, at: usize) {
        let Batch { positions: Positions { u, v, .. }, q, s, stretches } = self.batch;
        // The remainder is the index itself, and tells the compiler that it is in the arrays.
        let i = at % Positions::MOST;
        let surface = if C::SPACED { self.surfaces[at] } else { 0 };
        canvas.draw(&Dot {
            u: u[i],
            v: v[i] - self.top,
            q: q[i],
            s: s[i],
            stretch: &stretches[i],
            index: self.first + at,
            at: i,
            colour: self.colours[at],
            surface: surface.into(),
            slope: if C::SPACED { self.slopes[usize::from(surface)] } else { 0.0 },
            origin: if C::ORIGINS { self.splats[at].origin() } else { DepthPixelOrigin::Photo },
        });
    }

    #[inline(always)]
    fn draw_forwards<C: Canvas>(&self, canvas: &mut C) {
        if canvas.draw_whole(self.colours, true) {
            return;
        }
        let mut at = 0;
        while at < self.colours.len() {
            self.draw(canvas, at);
            at += 1;
        }
    }

    #[inline(always)]
    fn draw_backwards<C: Canvas>(&self, canvas: &mut C) {
        if canvas.draw_whole(self.colours, false) {
            return;
        }
        let mut at = self.colours.len();
        while at > 0 {
            at -= 1;
            self.draw(canvas, at);
        }
    }
}

impl Plan<'_> {
    /// Draws the depth pixels of a row of a tile's part, in batches that end between layered depth pixels.
    #[inline(always)]
    pub(super) fn draw_row<C: Canvas>(
        &self,
        canvas: &mut C,
        part: &TilePart,
        y: u32,
        top: f32,
        batch: &mut Batch,
    ) {
        let mut rest = part.row(self.level, y);
        let single = self.level.tiles[part.tile].single;
        while !rest.is_empty() {
            let range = self.next_batch(&rest, part.right);
            if part.right {
                rest.start = range.end;
            } else {
                rest.end = range.start;
            }
            let run = self.place::<C>(&range, y, single, self.unculled || part.can_be_stretched(), batch);
            self.draw_batch(canvas, part, range, &run, top, batch);
        }
    }

    /// Asks the processor to fetch the depth pixels of the row of a tile's part that is drawn after `before` others. By itself it
    /// waits for each line of memory, because rows of a tile are far apart.
    #[inline(always)]
    pub(super) fn fetch_row<C: Canvas>(&self, part: &TilePart, before: u32) {
        let Some(y) = part.row_in_order(before) else { return };
        let range = part.row(self.level, y);
        fetch(&self.level.columns[range.clone()]);
        fetch(&self.level.inverse_depths[range.clone()]);
        fetch(&self.level.colours[range.clone()]);
        if C::SPACED {
            fetch(&self.level.surfaces[range]);
        }
    }

    /// Returns the next batch of a row of a tile's part: as many depth pixels as fit, without cutting a layered depth pixel. Its
    /// columns are in one run, since its tile's are.
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

    /// Computes what the canvas needs of a batch, of which `single` tells whether no ray has two depth pixels, and
    /// `stretched` whether any can be stretched. What is not to be
    /// seen gets a position that is no number.
    // Iterators are calls in the profile `quick`, which does not optimise across all functions.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    fn place<C: Canvas>(
        &self,
        range: &Range<usize>,
        y: u32,
        single: bool,
        stretched: bool,
        batch: &mut Batch,
    ) -> RunStart {
        let level = self.level;
        let (columns, depths) = (&level.columns[range.clone()], &level.inverse_depths[range.clone()]);
        let run = self.rows.start(u32::from(columns[0]), y);
        self.rows.place(&run, columns, depths, &mut batch.positions);
        let Batch { positions, q, s, stretches } = batch;
        if C::SPACED {
            let (q, per_omega) = (&mut q[..depths.len()], &positions.per_omega[..depths.len()]);
            for i in 0..depths.len() {
                q[i] = depths[i] * per_omega[i];
            }
            self.space(range, positions, q, s);
            if C::STRETCHED && stretched && !self.maps.is_empty() {
                self.stretch(range, positions, s, stretches);
            }
        }
        if !self.behind.is_empty() {
            let surfaces = &level.surfaces[range.clone()];
            let places = positions.u.iter_mut().zip(&mut positions.v).zip(s.iter_mut());
            for (surface, ((u, v), s)) in surfaces.iter().zip(places) {
                if self.behind[usize::from(*surface)] {
                    (*u, *v, *s) = (f32::NAN, f32::NAN, f32::NAN);
                }
            }
        }
        if C::COVERED && !single {
            leave_out_covered(columns, &level.colours[range.clone()], batch);
        }
        run
    }

    /// Computes the spacings of a batch.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    fn space(&self, range: &Range<usize>, positions: &Positions, q: &[f32], s: &mut [f32]) {
        match &self.factors {
            Factors::Exact(factors) => {
                let surfaces = &self.level.surfaces[range.clone()];
                let count = surfaces.len();
                let (s, per_omega) = (&mut s[..count], &positions.per_omega[..count]);
                if let Some(only) = only_surface(surfaces) {
                    let factor = factors[usize::from(only)];
                    for i in 0..count {
                        s[i] = factor;
                    }
                } else {
                    for i in 0..count {
                        s[i] = factors[usize::from(surfaces[i])];
                    }
                }
                for i in 0..count {
                    let of_plane = exact(s[i], per_omega[i]);
                    s[i] = if surfaces[i] == 0 { s[i] * per_omega[i] } else { of_plane };
                }
            }
            Factors::Table(table) => {
                let splats = &self.level.splats[range.clone()];
                for ((s, splat), q) in s.iter_mut().zip(splats).zip(q) {
                    *s = table[usize::from(splat.entry())] * q;
                }
            }
        }
    }

    /// Finds the stretched depth pixels of a batch: their spacings become negative.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    fn stretch(&self, range: &Range<usize>, positions: &Positions, s: &mut [f32], stretches: &mut [Stretch]) {
        let surfaces = &self.level.surfaces[range.clone()];
        let count = surfaces.len();
        let (s, stretches) = (&mut s[..count], &mut stretches[..count]);
        let (u, v, per_omega) = (&positions.u[..count], &positions.v[..count], &positions.per_omega[..count]);
        let [half_u, half_v] = self.rows.half;
        let at = |i: usize| [u[i] - half_u, v[i] - half_v];
        let mut any = false;
        if let Some(only) = only_surface(surfaces) {
            let squares = self.squares[usize::from(only)];
            for i in 0..count {
                let is_stretched = squares.is_stretched(at(i), per_omega[i], s[i]);
                any |= is_stretched;
                s[i] = if is_stretched { -s[i] } else { s[i] };
            }
        } else {
            for i in 0..count {
                let squares = &self.squares[usize::from(surfaces[i])];
                let is_stretched = squares.is_stretched(at(i), per_omega[i], s[i]);
                any |= is_stretched;
                s[i] = if is_stretched { -s[i] } else { s[i] };
            }
        }
        for i in 0..if any { count } else { 0 } {
            if s[i] < 0.0 {
                let surface = usize::from(surfaces[i]);
                let jacobian = jacobian(&self.maps[surface], at(i), per_omega[i]);
                stretches[i] = Stretch::new(jacobian, self.gradients[surface]);
            }
        }
    }

    /// Draws a batch whose positions are known.
    #[inline(always)]
    fn draw_batch<C: Canvas>(
        &self,
        canvas: &mut C,
        part: &TilePart,
        range: Range<usize>,
        run: &RunStart,
        top: f32,
        batch: &Batch,
    ) {
        let count = range.len();
        let (first, columns) = (range.start, &self.level.columns[range.clone()]);
        let (u, v) = (&batch.positions.u[..count], &batch.positions.v[..count]);
        canvas.begin(&BatchPositions { u, v, s: &batch.s[..count], top });
        let (colours, splats) = (&self.level.colours[range.clone()], &self.level.splats[range.clone()]);
        let surfaces = &self.level.surfaces[range];
        let dots = Dots { batch, colours, splats, surfaces, slopes: &self.slopes, first, top };
        // The layer farthest from the picture's camera comes first: the last one where the camera looks ahead.
        let last_first =
            |i: usize| (self.rows.omega_at_infinity(run, columns[i].into()) >= 0.0) != self.reversed;
        let ends = [last_first(0), last_first(count - 1)];
        let single = self.level.tiles[part.tile].single;
        match (part.right, ends) {
            (true, [false, false]) => dots.draw_forwards(canvas),
            (false, [true, true]) => dots.draw_backwards(canvas),
            (right, _) if single && right => dots.draw_forwards(canvas),
            (_, _) if single => dots.draw_backwards(canvas),
            (right, _) => {
                let mut draw_pixel = |pixel: Range<usize>| match last_first(pixel.start) {
                    true => pixel.rev().for_each(|i| dots.draw(canvas, i)),
                    false => pixel.for_each(|i| dots.draw(canvas, i)),
                };
                walk_pixels(columns, right, &mut draw_pixel);
            }
        }
    }
}

/// Returns the surface of a batch if all of it is of one, as most batches are.
// Iterators are calls in the profile `quick`.
#[inline(always)]
#[allow(clippy::needless_range_loop)]
fn only_surface(surfaces: &[u16]) -> Option<u16> {
    let (first, mut others) = (surfaces[0], 0);
    for i in 0..surfaces.len() {
        others |= surfaces[i] ^ first;
    }
    (others == 0).then_some(first)
}

/// Leaves out the depth pixels that the nearer ones of their rays cover, see [`COVERS`].
#[inline(always)]
fn leave_out_covered(columns: &[u16], colours: &[[u8; 4]], batch: &mut Batch) {
    let Batch { positions: Positions { u, v, .. }, q, .. } = batch;
    // From the last one on, so that each is compared with a nearer one that is still there.
    for i in (1..columns.len()).rev() {
        let of_ray = columns[i] == columns[i - 1] && colours[i - 1][3] == u8::MAX;
        // False where one of them is not to be seen.
        let covers = (u[i] - u[i - 1]).abs() <= COVERS && (v[i] - v[i - 1]).abs() <= COVERS;
        let level = q[i - 1] > q[i] && q[i - 1] - q[i] <= LEVEL * q[i - 1];
        if of_ray && covers && level {
            (u[i], v[i]) = (f32::NAN, f32::NAN);
        }
    }
}

/// Asks the processor to fetch entries.
#[inline(always)]
fn fetch<T>(entries: &[T]) {
    /// The bytes that are fetched together.
    const LINE: usize = 64;
    #[cfg(target_arch = "x86_64")]
    for entry in entries.iter().step_by(LINE / size_of::<T>()) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: it reads nothing, and every processor of this architecture has it.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(entry).cast()) };
    }
}

/// Visits the layered depth pixels of a row's columns, to the right or to the left.
#[inline(always)]
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
