//! The plain twin of the GPU's rasteriser: the same passes with the same names, in an order and a
//! form that are easy to check by reading. It serves tests, benchmarks and machines without Vulkan.
//!
//! | here | shader | what it leaves |
//! |---|---|---|
//! | `passes::nearest` | *nearest* | inverse depth of the nearest fragment, per pixel |
//! | `passes::presence` | *item* | the working set; where and by which item the others are hidden |
//! | `passes::owners` | | who owns each pixel |
//! | `passes::lists` | *lists* | every fragment of the working set, per pixel |
//! | [`super::count_pairs`] | *pairs* | the table of occlusions |
//!
//! Depths are compared bit for bit as on the GPU ([`super::InverseDepth::at`], [`super::is_behind`]).
//! Coverage is exact here, while a GPU moves corners to a grid of 1/256 pixel first: the two may
//! differ where an outline passes within a hundredth of a pixel of a pixel centre, and nowhere else.

mod coverage;
mod passes;
mod peeling;

pub use coverage::Footprint;

use super::pairs::count_pairs;
use super::rasteriser::{Fragments, Presence, Rasteriser, StencilLayers};
use super::view::View;
use crate::error::Result;
use crate::task::Task;
use passes::Drawing;

/// Rasterises on the CPU. Results do not depend on the number of threads.
#[derive(Debug, Clone, Copy, Default)]
pub struct SoftwareRasteriser;

impl Rasteriser for SoftwareRasteriser {
    fn fragments(&self, view: &View, tolerance: f32, task: &Task) -> Result<Fragments> {
        let drawing = Drawing::new(view);
        let mut presence = passes::presence(&drawing, task)?;
        let working: Vec<bool> = presence.iter().map(|p| *p == Presence::Working).collect();
        let lists = passes::lists(&drawing, tolerance, &working, task)?;
        passes::name_owners(&mut presence, &lists);
        let occlusions = count_pairs(view, &lists, tolerance);
        Ok(Fragments { presence, lists, occlusions })
    }

    fn occluded(
        &self,
        view: &View,
        tolerance: f32,
        alive: &[bool],
        forgiven: &[(u32, u32)],
    ) -> Result<Vec<bool>> {
        let lists = passes::lists(&Drawing::new(view), tolerance, alive, &Task::silent())?;
        Ok(peeling::occluded(view, &lists, tolerance, forgiven))
    }

    fn stencil_peeling(
        &self,
        view: &View,
        tolerance: f32,
        working: &[bool],
        task: &Task,
    ) -> Result<StencilLayers> {
        let lists = passes::lists(&Drawing::new(view), tolerance, working, task)?;
        peeling::stencil(view, &lists, tolerance, working, task)
    }
}

/// Per pixel, row by row from the top, the item that owns it plus one: of those visible there, within the
/// tolerance of the nearest, the last in model order. 0 where there is none.
pub fn owners(view: &View, tolerance: f32) -> Vec<u32> {
    passes::owners(&Drawing::new(view), tolerance)
}

#[cfg(test)]
mod tests;
