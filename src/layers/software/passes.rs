//! The passes over the geometry; each runs in bands of rows, in parallel.

use std::ops::Range;

use rayon::prelude::*;

use super::coverage::TriangleFootprint;
use crate::is_behind;
use crate::projected_model::{ItemId, ProjectedModel};
use crate::rasteriser::{Band, FragmentLists, Presence, TIE, VISIBLE};
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// Rows of a band: few enough to occupy many threads, enough that few triangles lie in several bands.
const BAND_ROWS: u32 = 32;

/// A view with the footprints of its triangles.
pub struct SoftwareDrawing<'a> {
    /// The view that is drawn.
    pub view: &'a ProjectedModel,
    /// The item and footprint of every triangle that may cover pixels, in model order.
    triangles: Vec<(ItemId, TriangleFootprint)>,
}

impl<'a> SoftwareDrawing<'a> {
    /// Computes the footprints of a view's triangles.
    pub fn new(view: &'a ProjectedModel) -> Self {
        let footprint = |(corners, &item)| {
            Some((ItemId(item), TriangleFootprint::new(corners, view.width, view.height)?))
        };
        let triangles = view.corners.par_iter().zip(&view.triangle_items).filter_map(footprint).collect();
        Self { view, triangles }
    }

    /// Returns the bands of rows, from the top.
    fn bands(&self) -> Vec<Range<u32>> {
        let height = self.view.height;
        (0..height).step_by(BAND_ROWS as usize).map(|y| y..(y + BAND_ROWS).min(height)).collect()
    }

    /// Calls `visit` for every fragment of some rows in model order, with its item, the index of its pixel
    /// within the rows, and its inverse depth.
    fn each_fragment(&self, rows: &Range<u32>, mut visit: impl FnMut(ItemId, usize, f32)) {
        for (item, footprint) in &self.triangles {
            let inverse_depth = &self.view.items[item.0 as usize].inverse_depth;
            let own = footprint.rows();
            for y in own.start.max(rows.start)..own.end.min(rows.end) {
                let row = ((y - rows.start) * self.view.width) as usize;
                for x in footprint.columns(y) {
                    let depth = inverse_depth.at(x, y);
                    // At an outline, rounding can carry a plane past its horizon, where the value is not
                    // positive.
                    if depth > 0.0 {
                        visit(*item, row + x as usize, depth);
                    }
                }
            }
        }
    }

    fn pixels(&self, rows: &Range<u32>) -> usize {
        rows.len() * self.view.width as usize
    }
}

/// Computes the largest inverse depth at each pixel of some rows (pass *nearest*); 0 where no item is.
pub fn nearest(drawing: &SoftwareDrawing, rows: &Range<u32>) -> Vec<f32> {
    let mut nearest = vec![0.0_f32; drawing.pixels(rows)];
    drawing.each_fragment(rows, |_, pixel, inverse_depth| {
        nearest[pixel] = nearest[pixel].max(inverse_depth);
    });
    nearest
}

/// Determines the state of every item of the view (pass *presence*): see-through items hide nothing. The owners that hide the hidden items
/// are added by [`name_owners`], once the lists exist.
pub fn presence(drawing: &SoftwareDrawing, task: &Task) -> Result<Vec<Presence>> {
    let nowhere = || vec![Presence::Nowhere; drawing.view.items.len()];
    drawing
        .bands()
        .into_par_iter()
        .map(|rows| {
            task.check_cancelled()?;
            Ok(presence_in(drawing, &rows))
        })
        .try_reduce(nowhere, |above, below| {
            Ok(above.into_iter().zip(below).map(|(above, below)| merged(above, below)).collect())
        })
}

/// Combines the states of an item in the rows above and in the rows below.
fn merged(above: Presence, below: Presence) -> Presence {
    match (above, below) {
        (Presence::Working, _) | (_, Presence::Working) => Presence::Working,
        (Presence::Nowhere, below) => below,
        (above, _) => above,
    }
}

fn presence_in(drawing: &SoftwareDrawing, rows: &Range<u32>) -> Vec<Presence> {
    let mut nearest = vec![0.0_f32; drawing.pixels(rows)];
    drawing.each_fragment(rows, |item, pixel, inverse_depth| {
        if !drawing.view.items[item.0 as usize].see_through {
            nearest[pixel] = nearest[pixel].max(inverse_depth);
        }
    });
    let mut working = vec![false; drawing.view.items.len()];
    let mut first_hidden = vec![usize::MAX; drawing.view.items.len()];
    drawing.each_fragment(rows, |item, pixel, inverse_depth| {
        let index = item.0 as usize;
        if is_behind(inverse_depth, nearest[pixel], TIE) {
            first_hidden[index] = first_hidden[index].min(pixel);
        } else {
            working[index] = true;
        }
    });
    let presence = |(working, pixel)| match (working, pixel) {
        (true, _) => Presence::Working,
        (false, usize::MAX) => Presence::Nowhere,
        (false, pixel) => {
            let (x, y) = (pixel as u32 % drawing.view.width, pixel as u32 / drawing.view.width);
            Presence::Hidden { x, y: rows.start + y, by: u32::MAX }
        }
    };
    working.into_iter().zip(first_hidden).map(presence).collect()
}

/// Finds the owner of each pixel, see [`super::owners`].
pub fn owners(drawing: &SoftwareDrawing, tolerance: f32) -> Vec<u32> {
    let of_band = |rows: Range<u32>| {
        let nearest = nearest(drawing, &rows);
        let mut owners = vec![0; drawing.pixels(&rows)];
        drawing.each_fragment(&rows, |item, pixel, inverse_depth| {
            if !is_behind(inverse_depth, nearest[pixel], tolerance) {
                owners[pixel] = item.0 + 1;
            }
        });
        owners
    };
    drawing.bands().into_par_iter().map(of_band).collect::<Vec<_>>().concat()
}

/// Sets the owners of the pixels where items are hidden.
pub fn name_owners(presence: &mut [Presence], lists: &FragmentLists) {
    for presence in presence {
        if let Presence::Hidden { x, y, by } = presence {
            *by = lists.owner(*x, *y).unwrap_or(u32::MAX);
        }
    }
}

/// Builds the lists of the fragments of the items flagged in `kept` (passes *count*, *scan* and *fill*):
/// entries are in model order within a pixel, visibility is judged among the kept items only.
pub fn lists(drawing: &SoftwareDrawing, tolerance: f32, kept: &[bool], task: &Task) -> Result<FragmentLists> {
    let bands = drawing
        .bands()
        .into_par_iter()
        .map(|rows| {
            task.check_cancelled()?;
            Ok(band(drawing, &rows, tolerance, kept))
        })
        .collect::<Result<Vec<_>>>()?;
    Ok(FragmentLists { width: drawing.view.width, bands })
}

/// Builds the lists of one band: count, prefix sum, fill.
fn band(drawing: &SoftwareDrawing, rows: &Range<u32>, tolerance: f32, kept: &[bool]) -> Band {
    let mut offsets = vec![0_u32; drawing.pixels(rows) + 1];
    let mut nearest = vec![0.0_f32; drawing.pixels(rows)];
    let is_kept = |item: ItemId| kept[item.0 as usize];
    drawing.each_fragment(rows, |item, pixel, inverse_depth| {
        if is_kept(item) {
            offsets[pixel + 1] += 1;
            nearest[pixel] = nearest[pixel].max(inverse_depth);
        }
    });
    for pixel in 1..offsets.len() {
        offsets[pixel] += offsets[pixel - 1];
    }
    let mut cursors = offsets.clone();
    let mut entries = vec![0_u32; offsets[offsets.len() - 1] as usize];
    drawing.each_fragment(rows, |item, pixel, inverse_depth| {
        if is_kept(item) {
            let visible = !is_behind(inverse_depth, nearest[pixel], tolerance);
            entries[cursors[pixel] as usize] = item.0 | if visible { VISIBLE } else { 0 };
            cursors[pixel] += 1;
        }
    });
    Band { y0: rows.start, y1: rows.end, offsets, entries }
}
