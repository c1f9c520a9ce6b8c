//! What a device needs that moves the depth pixels of a view itself: everything of [`Plan`] that is composed in double
//! precision.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};

use super::{Plan, WarpOptions};
use crate::layout::Ldi;
use crate::spacing::{Factors, Spacing};
use crate::stretch::{Jacobian, PlaneMap, Stretch};
use crate::transfer::{RUN, RowTransfer};
use quadratura_view::Shot;

/// The factor of surfaces that are not drawn, because the view shows the side that the reference camera does not see.
pub const NOT_DRAWN: f32 = -1.0;

/// A surface in a view.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct SurfaceMove {
    /// The factor of the spacing by planes, see [`Factors::exact`], or [`NOT_DRAWN`].
    pub factor: f32,
    /// See [`slope`](crate::spacing::slope).
    pub slope: f32,
    /// See [`Stretch::gradient`].
    pub gradient: [f32; 2],
    /// See [`PlaneMap`].
    pub map: PlaneMap,
}

/// How the depth pixels of one level move into a view.
pub struct Moves<'a> {
    /// The index of the level.
    pub level: usize,
    /// The transfer.
    pub rows: RowTransfer,
    /// By row of the level, then by run of [`RUN`] columns: the homogeneous position at the first column and d = 0.
    pub starts: Vec<[f32; 4]>,
    /// By number of surface.
    pub surfaces: Vec<SurfaceMove>,
    plan: Plan<'a>,
}

impl<'a> Moves<'a> {
    /// Prepares a view; the spacing is found by planes, whatever the options say.
    pub fn new(ldi: &'a Ldi, shot: &Shot, options: &WarpOptions) -> Self {
        let plan = Plan::new(ldi, shot, &WarpOptions { spacing: Spacing::Exact, ..*options });
        let Factors::Exact(factors) = &plan.factors else { unreachable!("the spacing is exact") };
        let is_behind = |number: usize| plan.behind.get(number).copied().unwrap_or(false);
        let surfaces = factors.iter().zip(&plan.slopes).enumerate();
        let surfaces = surfaces.map(|(number, (g, slope))| SurfaceMove {
            factor: if is_behind(number) { NOT_DRAWN } else { *g },
            slope: *slope,
            gradient: Stretch::new(Jacobian::default(), plan.gradients[number]).gradient,
            map: plan.maps[number],
        });
        let surfaces = surfaces.collect();
        let camera = plan.level.camera;
        let start = |x: u32, y: u32| {
            let [x, y, z] = plan.rows.start(x, y).start;
            [x, y, z, 0.0]
        };
        let row = |y: u32| (0..camera.width.div_ceil(RUN)).map(move |run| start(run * RUN, y));
        let starts = (0..camera.height).flat_map(row).collect();
        Self { level: plan.level_index, rows: plan.rows, starts, surfaces, plan }
    }

    /// Returns the number of runs in a row of the level.
    pub fn runs(&self) -> u32 {
        self.plan.level.camera.width.div_ceil(RUN)
    }

    /// Returns a range of depth pixels outside of which none is drawn on rows of the picture, by splats that reach so far, in
    /// pixels: from the first to the last row of the frame that has one.
    pub fn within(&self, rows: &Range<u32>, reach: f32) -> Range<u32> {
        let band = (rows.start as f32 - reach, rows.end as f32 + reach);
        let met = self.plan.parts.iter().filter(|part| part.meets(band, reach));
        let (mut from, mut to) = (u32::MAX, 0);
        for rows in met.map(super::tile_parts::TilePart::rows) {
            (from, to) = (from.min(rows.start), to.max(rows.end));
        }
        let offsets = &self.plan.level.rows;
        if from < to { offsets[from as usize]..offsets[to as usize] } else { 0..0 }
    }
}
