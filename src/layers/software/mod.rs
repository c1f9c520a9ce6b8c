//! The CPU reference of the GPU's rasteriser: the same passes under the same names, in an order and a form
//! that are easy to verify by reading. It serves tests, benchmarks and machines without Vulkan.
//!
//! | here | GPU pass | result |
//! |---|---|---|
//! | `passes::nearest` | *nearest* | inverse depth of the nearest fragment, per pixel |
//! | `passes::presence` | *presence* | the working set; where the other items are hidden |
//! | `passes::owners` | none | the item that owns each pixel |
//! | `passes::lists` | *count*, *scan*, *fill* | the fragments of the working set, as one list per pixel |
//! | [`super::count_pairs`] | *pairs* | the table of occlusions |
//!
//! Depths are compared bit for bit as on the GPU ([`InverseDepth::at`](quadratura_base::geometry::InverseDepth::at), [`super::is_behind`]).
//! Coverage is exact here, while a GPU rounds corners to a grid of 1/256 pixel: the two may differ where an
//! outline passes within a hundredth of a pixel of a pixel centre, and nowhere else.

mod coverage;
mod passes;
mod peeling;

pub use coverage::TriangleFootprint;

use super::pairs::count_pairs;
use super::projected_model::ProjectedModel;
use super::rasteriser::{Fragments, Presence, Rasteriser, StencilLayers};
use passes::SoftwareDrawing;
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// A rasteriser that runs on the CPU. Its results do not depend on the number of threads.
#[derive(Debug, Clone, Copy, Default)]
pub struct SoftwareRasteriser;

impl Rasteriser for SoftwareRasteriser {
    fn fragments(&self, view: &ProjectedModel, tolerance: f32, task: &Task) -> Result<Fragments> {
        let drawing = SoftwareDrawing::new(view);
        let mut presence = passes::presence(&drawing, task)?;
        let working: Vec<bool> = presence.iter().map(|p| *p == Presence::Working).collect();
        let lists = passes::lists(&drawing, tolerance, &working, task)?;
        passes::name_owners(&mut presence, &lists);
        let occlusions = count_pairs(view, &lists, tolerance);
        Ok(Fragments { presence, lists, occlusions })
    }

    fn occluded(
        &self,
        view: &ProjectedModel,
        tolerance: f32,
        alive: &[bool],
        forgiven: &[(u32, u32)],
    ) -> Result<Vec<bool>> {
        let lists = passes::lists(&SoftwareDrawing::new(view), tolerance, alive, &Task::silent())?;
        Ok(peeling::occluded(view, &lists, tolerance, forgiven))
    }

    fn stencil_peeling(
        &self,
        view: &ProjectedModel,
        tolerance: f32,
        working: &[bool],
        task: &Task,
    ) -> Result<StencilLayers> {
        let lists = passes::lists(&SoftwareDrawing::new(view), tolerance, working, task)?;
        peeling::stencil(view, &lists, tolerance, working, task)
    }
}

/// Finds the owner of each pixel, row by row from the top: the index plus one of the last item in model order
/// among those visible at the pixel (within the tolerance of the nearest); 0 where there is none.
pub fn owners(view: &ProjectedModel, tolerance: f32) -> Vec<u32> {
    passes::owners(&SoftwareDrawing::new(view), tolerance)
}

#[cfg(test)]
mod tests;
