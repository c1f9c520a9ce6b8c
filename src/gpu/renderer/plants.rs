//! The trees of a site, drawn between *nearness* and *project*: they hide faces and faces hide them, sample by sample. What is
//! large in a view is drawn as polygons (`shaders/plants.wgsl`), the rest from images ([`flakes`], [`flaked`]).

pub(super) mod daylight;
mod extent;
pub(super) mod flake;
pub(super) mod flaked;
pub(super) mod flakes;
mod flakes_narrow;
mod flakes_wide;
pub(super) mod hidden;
mod painted;
pub(super) mod pipeline;
pub(super) mod polygons;
pub(super) mod ratio;
pub(super) mod resources;
pub(super) mod slices;
pub(super) mod species;
mod stipple;
pub(super) mod sunlit;
#[cfg(test)]
mod tests;
pub(super) mod view;

use std::sync::Arc;

pub use self::pipeline::{SampledProgram, TreeProgram};
use self::resources::TreeResources;
use self::slices::Slices;
use self::view::{PlantsView, TreeTarget};
use super::Renderer;
use crate::device::Gpu;
use quadratura_base::error::Result;
use quadratura_foliage::PlacedTrees;
use quadratura_view::{Shot, TreeMethod};

/// The trees of a site on the device, and what a view shows of them.
#[derive(Debug)]
pub struct Plants {
    resources: TreeResources,
    view: PlantsView,
}

impl Plants {
    /// Uploads the trees of a site whose model has this many faces.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Request`] for a plant without images that has too many instances.
    pub fn new(gpu: &Gpu, placed: Arc<PlacedTrees>, faces: usize) -> Result<Self> {
        Ok(Self { resources: TreeResources::new(gpu, placed, faces)?, view: PlantsView::new(gpu) })
    }

    /// Prepares the trees for a view ([`PlantsView::prepare`]). Returns whether some tree may be in view.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Request`] for a plant that has too many instances to be drawn as polygons.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        shot: &Shot,
        program: SampledProgram,
        of_common: [f64; 3],
    ) -> Result<bool> {
        let Self { resources, view } = self;
        view.prepare(gpu, resources, &|_| true, shot, program, of_common)
    }

    /// Forgets the picture that was drawn last, because trees or faces have changed.
    pub fn forget(&mut self) {
        self.view.forget();
    }

    /// Returns whether some tree casts a shadow.
    pub fn casts(&self) -> bool {
        self.resources.placed.trees.iter().any(|tree| tree.casts)
    }

    /// Returns the trees and species, whatever the view.
    pub fn resources(&mut self) -> &mut TreeResources {
        &mut self.resources
    }

    /// Returns what of the trees is handed to the device at once, as a cost in samples.
    pub fn most_at_once(&self) -> f64 {
        self.view.most_at_once()
    }

    /// Draws the trees in view, for which [`Self::prepare`] was called, onto what is there.
    ///
    /// # Errors
    /// Those of [`Slices::hand_over`].
    pub fn draw(
        &self,
        slices: &mut Slices,
        onto: &TreeTarget,
        frame: wgpu::BindingResource,
        program: SampledProgram,
    ) -> Result<()> {
        self.view.draw(&self.resources, slices, onto, frame, program)
    }
}

impl Renderer {
    /// Sets the trees that stand in the site.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Request`] for a plant without images that has too many instances to be drawn as polygons; [`quadratura_base::Error::Gpu`]. The trees
    /// before remain.
    pub fn set_trees(&mut self, placed: Option<Arc<PlacedTrees>>) -> Result<()> {
        self.ready = None;
        self.forget_shadows();
        if !placed.as_ref().is_some_and(|placed| placed.trees.iter().any(|tree| tree.casts)) {
            // Their maps take 125 MB.
            self.shadows = None;
        }
        if let (Some(plants), Some(placed)) = (&mut self.plants, &placed)
            && plants.resources.has_species_of(placed)
        {
            let (gpu, resources) = (self.gpu.clone(), &mut plants.resources);
            gpu.guarded("uploading trees", || {
                resources.set_trees(&gpu, placed.clone());
                Ok(())
            })?;
            plants.forget();
            return Ok(());
        }
        let (gpu, faces) = (self.gpu.clone(), self.model.faces.len());
        let plants = gpu.guarded("uploading trees", || {
            placed.map(|placed| Plants::new(&gpu, placed, faces)).transpose()
        })?;
        self.plants = plants;
        Ok(())
    }

    /// Returns the trees that a view shows, if there are any.
    pub(super) fn trees(&self, shot: &Shot) -> Option<&Plants> {
        self.plants.as_ref().filter(|_| shot.trees != TreeMethod::None)
    }

    /// Returns the depths of the nearest and the farthest visible point with those of the trees.
    pub(super) fn depths_with_trees(&self, shot: &Shot, depths: [f64; 2]) -> [f64; 2] {
        match self.trees(shot).and_then(|plants| plants.resources.depths(shot)) {
            Some([nearest, farthest]) if depths[1] > 0.0 => [depths[0].min(nearest), depths[1].max(farthest)],
            Some(of_trees) => of_trees,
            None => depths,
        }
    }
}
