//! The plants of a site on the device, whatever the view: trees, species, and the pipelines that draw them.

use std::sync::Arc;

use glam::{DAffine3, Vec3};
use rustc_hash::FxHashMap;
use wgpu::{BindGroupLayout, RenderPipeline, ShaderStages};

use super::daylight;
use super::flake::SpeciesImages;
use super::flaked::ShownWords;
use super::pipeline::{Cuts, PlacementWords, SampledProgram, pipeline, trees_layout};
use super::ratio::{RatioCells, RatioWords, have_same_ratios};
use super::species::{SpeciesBuffers, material_layout};
use super::sunlit::SunlitCells;
use crate::bindings::{self, BindingKind};
use crate::device::Gpu;
use crate::renderer::render_target::FLAT_LINEAR;
use quadratura_base::error::Result;
use quadratura_foliage::{InView, PlacedSpecies, PlacedTrees, View, WalkOptions, in_view};
use quadratura_projection::TREE;
use quadratura_view::legend;
use quadratura_view::legend::{colour_of_number, linear};
use quadratura_view::{DisplayMode, Shot};

/// Trees and species on the device.
#[derive(Debug)]
pub struct TreeResources {
    /// The trees.
    pub placed: Arc<PlacedTrees>,
    /// The species, in the order of the trees' indices.
    pub species: Vec<SpeciesBuffers>,
    /// The cells of the trees' ratio images.
    pub ratios: RatioCells,
    /// The share of sunlight that reaches the trees.
    pub sunlit: SunlitCells,
    /// Frame, trees, material and light.
    pub layouts: [BindGroupLayout; 4],
    /// The pipelines that were made so far.
    pub pipelines: FxHashMap<(SampledProgram, Cuts), RenderPipeline>,
    /// The distance of two [`PlacementWords`] in a uniform buffer, in bytes.
    pub stride: u64,
    faces: usize,
}

impl TreeResources {
    /// Uploads the trees of a site whose model has this many faces.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Request`] for a plant without images that has too many instances.
    pub fn new(gpu: &Gpu, placed: Arc<PlacedTrees>, faces: usize) -> Result<Self> {
        let shot = bindings::layout(gpu, "frame", ShaderStages::VERTEX_FRAGMENT, &[BindingKind::Uniform]);
        let layouts = [shot, trees_layout(gpu), material_layout(gpu), daylight::layout(gpu)];
        let species = (0..).zip(&placed.species);
        let species = species.map(|(number, species)| SpeciesBuffers::new(gpu, species, number, &layouts[2]));
        let alignment = u64::from(gpu.device.limits().min_uniform_buffer_offset_alignment);
        Ok(Self {
            species: species.collect::<Result<_>>()?,
            ratios: RatioCells::new(gpu, &placed),
            sunlit: SunlitCells::new(gpu, &placed),
            layouts,
            pipelines: FxHashMap::default(),
            stride: (size_of::<PlacementWords>() as u64).next_multiple_of(alignment),
            faces,
            placed,
        })
    }

    /// Replaces the trees by others of the same species ([`Self::has_species_of`]).
    pub fn set_trees(&mut self, gpu: &Gpu, placed: Arc<PlacedTrees>) {
        if !have_same_ratios(&self.placed, &placed) {
            self.ratios = RatioCells::new(gpu, &placed);
        }
        if !self.sunlit.is_of(&placed) {
            self.sunlit = SunlitCells::new(gpu, &placed);
        }
        self.placed = placed;
    }

    /// Returns whether the species of other trees are on the device already, in the same order.
    pub fn has_species_of(&self, placed: &PlacedTrees) -> bool {
        let same = |(known, other): (&PlacedSpecies, &PlacedSpecies)| {
            let images = [known, other].map(|species| species.images.as_ref().map(Arc::as_ptr));
            let openness = [known, other].map(|species| species.openness.as_ref().map(Arc::as_ptr));
            Arc::ptr_eq(&known.plant, &other.plant) && images[0] == images[1] && openness[0] == openness[1]
        };
        let (known, other) = (&self.placed.species, &placed.species);
        known.len() == other.len() && known.iter().zip(other).all(same)
    }

    /// Returns the depths of the nearest and the farthest point of the trees that a view may show; `None` where there are none.
    pub fn depths(&self, shot: &Shot) -> Option<[f64; 2]> {
        let balls = self.placed.trees.iter().map(|tree| self.placed.ball(tree));
        let depths = balls.filter_map(|ball| {
            let middle = shot.pose.camera_from_world(ball.middle).z;
            let far = middle + ball.radius;
            (far > 0.0).then(|| [(middle - ball.radius).max(0.0), far])
        });
        depths.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }

    /// Makes the pipelines of a program; those through stipples where `in_part` is true.
    pub fn want_pipelines(&mut self, gpu: &Gpu, program: SampledProgram, in_part: bool) {
        let layouts = &self.layouts;
        let by_stipples: &[bool] = if in_part { &[false, true] } else { &[false] };
        let all = by_stipples
            .iter()
            .flat_map(|&by_stipple| [false, true].map(|by_picture| Cuts { by_picture, by_stipple }));
        for cuts in all {
            self.pipelines.entry((program, cuts)).or_insert_with(|| pipeline(gpu, program, cuts, layouts));
        }
    }

    /// Returns what a view shows of a tree that has images.
    pub fn seen(&self, shot: &Shot, number: usize, images: &SpeciesImages, options: &WalkOptions) -> InView {
        let tree = &self.placed.trees[number];
        let plant = &self.placed.species[tree.species].plant;
        let ball = plant.whole().bounds.ball;
        let view = View::of_tree(shot.camera, &shot.pose, &tree.world_from_plant, &ball);
        in_view(plant, &images.images, &view, options, u64::from(tree.number))
    }

    /// Returns what a view shows of a tree, and adds its ratio images in the view to `ratios`.
    pub fn shown(
        &self,
        shot: &Shot,
        number: usize,
        exposure: Vec3,
        ratios: &mut Vec<RatioWords>,
    ) -> ShownWords {
        let tree = &self.placed.trees[number];
        let camera_from_world = DAffine3::from_mat3_translation(shot.pose.rotation, shot.pose.translation);
        let camera_from_plant = camera_from_world * tree.world_from_plant;
        let textures = &self.species[tree.species].crown;
        let crown = textures.words(shot, &camera_from_plant, self.placed.light.towards_sun);
        let first_ratio = ratios.len() as u32;
        let (in_view, rest) = self.ratios.in_view(shot, &self.placed, number);
        ratios.extend(in_view);
        let (tint, plain) = ((tree.tint * rest * exposure).to_array(), self.plain(shot, tree.number));
        let ratio_count = ratios.len() as u32 - first_ratio;
        ShownWords {
            tint,
            number: TREE | tree.number,
            plain,
            crown,
            first_ratio,
            ratio_count,
            sunlit: self.sunlit.block(number),
            pad0: 0,
        }
    }

    /// Returns the colour of a tree where a view shows no light.
    fn plain(&self, shot: &Shot, number: u32) -> [f32; 4] {
        let opaque = |colour: [u8; 3]| {
            let [r, g, b] = linear(colour).map(|light| light as f32);
            [r, g, b, 1.0]
        };
        match shot.display {
            DisplayMode::Item => opaque(colour_of_number(self.faces as u32 + number)),
            DisplayMode::Provenance => opaque(legend::TREE),
            // No photo serves trees.
            _ => {
                let flat = FLAT_LINEAR as f32;
                [flat, flat, flat, 0.0]
            }
        }
    }

    /// Returns the images of the species, where there are any.
    pub fn images(&self) -> Vec<Option<&SpeciesImages>> {
        self.species.iter().map(|species| species.images.as_ref()).collect()
    }
}
