//! What a view shows of the trees of a site: which parts of them are drawn from images and which as polygons, and the drawing.

use std::cell::Cell;
use std::num::NonZeroU64;
use std::ops::Range;
use std::time::{Duration, Instant};

use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;
use wgpu::{BufferUsages, RenderPass};

use super::daylight::DaylightWords;
use super::flake::{FlakeImageWords, rows_of};
use super::flaked::{Flaked, ShownWords};
use super::flakes::Flakes;
use super::species::InstanceWords;
use super::stock::Stock;
use super::{Cuts, TreeProgram, TreeWords};
use crate::error::Result;
use crate::foliage::{
    Ball, ImageInView, InView, PolygonsInView, Tree, TreeCost, TreePace, WalkOptions, WoodSpecies, sees,
};
use crate::gpu::bindings;
use crate::gpu::device::Gpu;
use crate::gpu::renderer::table::GrowingBuffer;
use crate::projection::{Quality, Shot, TreeMethod};

/// The trees of a view on the device.
#[derive(Debug)]
pub struct PlantsView {
    daylight: GrowingBuffer,
    /// The trees in view, each at a multiple of [`Stock::stride`].
    trees: GrowingBuffer,
    /// What is drawn as polygons, in the order of the trees.
    polygons: Vec<PolygonDraw>,
    /// [`super::species::InstanceWords`] of sub-objects of trees whose other parts are drawn from images: to the camera's frame.
    parts: GrowingBuffer,
    flakes: Flakes,
    flaked: Flaked,
    /// Whether images are in view.
    has_images: bool,
    /// How fine they are in pictures that follow each other, and the time that trees may take in this one.
    pace: Cell<TreePace>,
    within: Option<Duration>,
    cost: TreeCost,
}

/// Instances of a sub-object's triangles that are drawn as polygons.
#[derive(Debug, Clone, PartialEq)]
struct PolygonDraw {
    /// The place of the tree among those in view.
    slot: u32,
    species: usize,
    /// The sub-object; `None` for all of them.
    object: Option<usize>,
    /// In [`PlantsView::parts`]; those of all sub-objects are in [`super::species::SpeciesBuffers::instances`].
    instances: Range<u32>,
    /// Whether they are drawn in part of the sub-pixels.
    in_part: bool,
}

impl PlantsView {
    /// Creates empty tables.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            daylight: GrowingBuffer::new(gpu, "daylight", BufferUsages::UNIFORM),
            trees: GrowingBuffer::new(gpu, "trees", BufferUsages::UNIFORM),
            polygons: Vec::new(),
            parts: GrowingBuffer::new(gpu, "parts of trees", BufferUsages::VERTEX),
            flakes: Flakes::new(gpu),
            flaked: Flaked::new(gpu),
            has_images: false,
            pace: Cell::default(),
            within: None,
            cost: TreeCost::default(),
        }
    }

    /// Writes what a view needs of the trees for which `is_drawn` is true, and makes the pipelines. `of_common` is the factor from
    /// the photos' common exposure to the view's. Returns whether some of them may be in view.
    ///
    /// # Errors
    /// [`crate::Error::Request`] for a plant that has too many instances to be drawn as polygons.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        (stock, is_drawn): (&mut Stock, &dyn Fn(&Tree) -> bool),
        shot: &Shot,
        (program, samples): (TreeProgram, u32),
        of_common: [f64; 3],
    ) -> Result<bool> {
        let wood = stock.wood.clone();
        let is_in_view = |number: &usize| {
            let ball = wood.ball(&wood.trees[*number]);
            let middle = shot.pose.camera_from_world(ball.middle);
            is_drawn(&wood.trees[*number]) && sees(&shot.camera, &Ball { middle, ..ball })
        };
        let in_view: Vec<usize> = (0..wood.trees.len()).filter(is_in_view).collect();
        if in_view.is_empty() {
            return Ok(false);
        }
        self.daylight.write(gpu, &[DaylightWords::new(&wood.light, shot)]);
        let follows = shot.quality == Quality::Preview && program != TreeProgram::Numbered;
        self.within = shot.trees_within.filter(|_| follows);
        self.write_parts(gpu, stock, shot, (&in_view, samples))?;
        let exposure = DVec3::from_array(of_common).as_vec3();
        self.write_trees(gpu, stock, shot, (&in_view, exposure));
        let in_part = self.polygons.iter().any(|draw| draw.in_part);
        stock.want_pipelines(gpu, (program, samples), in_part);
        if self.has_images {
            let shown: Vec<ShownWords> =
                in_view.iter().map(|number| stock.shown(shot, *number, exposure)).collect();
            self.flaked.prepare(gpu, &shown, (program, samples), [&stock.layouts[0], &stock.layouts[3]]);
        }
        Ok(true)
    }

    /// Returns when images serve in a view.
    fn options(&self, shot: &Shot) -> WalkOptions {
        match (shot.quality, shot.trees_within) {
            (Quality::Preview, Some(_)) => WalkOptions { threshold: self.pace.get().threshold() },
            (Quality::Preview, None) => WalkOptions::PREVIEW,
            (Quality::Final, _) => WalkOptions::FINAL,
        }
    }

    /// Writes what of the trees in view is drawn from images, and what as polygons.
    fn write_parts(
        &mut self,
        gpu: &Gpu,
        stock: &mut Stock,
        shot: &Shot,
        (in_view, samples): (&[usize], u32),
    ) -> Result<()> {
        let mut found = self.find_parts(gpu, stock, shot, in_view)?;
        if self.within.is_some() && self.pace.get_mut().begin(self.cost) {
            found = self.find_parts(gpu, stock, shot, in_view)?;
        }
        let (mut images, parts) = found;
        if !parts.is_empty() {
            self.parts.write(gpu, &parts);
        }
        let size = [shot.camera.width, shot.camera.height, samples];
        self.has_images = self.flakes.prepare(gpu, &mut images, stock.species.len(), size);
        Ok(())
    }

    /// Finds what of the trees in view is drawn from images, which come species by species, and what as polygons, and what that costs.
    fn find_parts(
        &mut self,
        gpu: &Gpu,
        stock: &mut Stock,
        shot: &Shot,
        in_view: &[usize],
    ) -> Result<(Vec<FlakeImageWords>, Vec<InstanceWords>)> {
        let options = self.options(shot);
        let from_images = |number: usize| {
            let images = stock.species[stock.wood.trees[number].species].images.as_ref()?;
            (shot.trees == TreeMethod::Flakes).then(|| stock.seen(shot, number, images, &options))
        };
        let seen: Vec<Option<InView>> = in_view.par_iter().map(|number| from_images(*number)).collect();
        let (mut images, mut parts) = (vec![Vec::new(); stock.species.len()], Vec::new());
        self.polygons.clear();
        for ((slot, &number), seen) in (0u32..).zip(in_view).zip(seen) {
            let species = stock.wood.trees[number].species;
            let WoodSpecies { plant, .. } = &stock.wood.species[species];
            let buffers = &mut stock.species[species];
            let Some((InView { images: of_tree, polygons }, of_species)) = seen.zip(buffers.images.as_ref())
            else {
                buffers.want_instances(gpu, plant)?;
                self.polygons.push(PolygonDraw {
                    slot,
                    species,
                    object: None,
                    instances: 0..0,
                    in_part: false,
                });
                continue;
            };
            let words = |image: &ImageInView| FlakeImageWords {
                tree: slot,
                species: species as u32,
                ..of_species.words(plant, image)
            };
            images[species].extend(of_tree.iter().map(words));
            let kind = |of: &PolygonsInView| (of.object, !of.door.is_wide());
            for alike in polygons.chunk_by(|a, b| kind(a) == kind(b)) {
                let first = parts.len() as u32;
                parts.extend(alike.iter().map(|of| InstanceWords::new(&of.view_from_object, &of.door)));
                let ((object, in_part), instances) = (kind(&alike[0]), first..parts.len() as u32);
                self.polygons.push(PolygonDraw { slot, species, object: Some(object), instances, in_part });
            }
        }
        let images = images.concat();
        self.cost = self.cost_of(stock, &images);
        Ok((images, parts))
    }

    /// Returns what the parts in view cost; trees that are drawn as polygons alone, whatever their size in the view, are left out.
    fn cost_of(&self, stock: &Stock, images: &[FlakeImageWords]) -> TreeCost {
        let triangles = |draw: &PolygonDraw| {
            let meshes =
                stock.species[draw.species].meshes.iter().filter(|mesh| draw.object == Some(mesh.object));
            let each: u64 = meshes.map(|mesh| u64::from(mesh.index_count / 3)).sum();
            each * draw.instances.len() as u64
        };
        TreeCost {
            samples: images.iter().map(|image| u64::from(image.count)).sum(),
            triangles: self.polygons.iter().map(triangles).sum(),
        }
    }

    fn write_trees(&mut self, gpu: &Gpu, stock: &Stock, shot: &Shot, (in_view, exposure): (&[usize], Vec3)) {
        let camera_from_world = DAffine3::from_mat3_translation(shot.pose.rotation, shot.pose.translation);
        let is_whole: Vec<bool> = self.polygons.iter().fold(vec![false; in_view.len()], |mut whole, draw| {
            whole[draw.slot as usize] |= draw.object.is_none();
            whole
        });
        let mut bytes = vec![0u8; stock.stride as usize * in_view.len()];
        for ((place, &number), is_whole) in
            bytes.chunks_exact_mut(stock.stride as usize).zip(in_view).zip(is_whole)
        {
            // Parts are mapped to the camera's frame already.
            let map = match is_whole {
                true => camera_from_world * stock.wood.trees[number].world_from_plant,
                false => DAffine3::IDENTITY,
            };
            let [right, down, forward] = rows_of(&map);
            let ShownWords { tint, number, plain, crown } = stock.shown(shot, number, exposure);
            let words = TreeWords { right, down, forward, tint, number, plain, crown };
            place[..size_of::<TreeWords>()].copy_from_slice(bytemuck::bytes_of(&words));
        }
        self.trees.write(gpu, &bytes);
    }

    /// Finds the nearest samples of images in view, before the trees are drawn. Where trees may take so much time and no more, this is
    /// waited for, and the next picture follows from how long it took.
    pub fn find(
        &self,
        gpu: &Gpu,
        stock: &Stock,
        encoder: &mut wgpu::CommandEncoder,
        frame: wgpu::BindingResource,
    ) {
        if !self.has_images {
            return;
        }
        let Some(within) = self.within else {
            return self.flakes.record(gpu, encoder, frame, &stock.images());
        };
        // Waiting fails for a lost device alone, of which the drawing tells.
        let wait = || gpu.device.poll(wgpu::PollType::wait_indefinitely()).is_ok();
        let mut apart = gpu.device.create_command_encoder(&Default::default());
        self.flakes.record(gpu, &mut apart, frame, &stock.images());
        wait();
        let (began, mut pace) = (Instant::now(), self.pace.get());
        gpu.queue.submit([apart.finish()]);
        if wait() {
            pace.learn(self.cost.samples, began.elapsed().as_secs_f64());
        }
        pace.follow(self.cost, within.as_secs_f64());
        self.pace.set(pace);
    }

    /// Draws the trees in view, for which [`Self::prepare`] was called.
    pub fn draw(
        &self,
        gpu: &Gpu,
        stock: &Stock,
        drawing: &mut RenderPass,
        frame: wgpu::BindingResource,
        (program, samples): (TreeProgram, u32),
    ) {
        let frame = bindings::bind(gpu, "frame", &stock.layouts[0], &[frame]);
        let lights =
            stock.species.iter().map(|of| of.crown.bind(gpu, &stock.layouts[3], self.daylight.binding()));
        let species: Vec<_> = stock.images().into_iter().zip(lights).collect();
        drawing.set_bind_group(0, &frame, &[]);
        let size = NonZeroU64::new(size_of::<TreeWords>() as u64);
        let tree = wgpu::BufferBinding { buffer: self.trees.buffer(), offset: 0, size };
        let tree = bindings::bind(gpu, "tree", &stock.layouts[1], &[wgpu::BindingResource::Buffer(tree)]);
        for draw in &self.polygons {
            drawing.set_bind_group(1, &tree, &[(u64::from(draw.slot) * stock.stride) as u32]);
            drawing.set_bind_group(3, &species[draw.species].1, &[]);
            self.draw_polygons(stock, drawing, draw, (program, samples));
        }
        if self.has_images {
            self.flaked.draw(gpu, drawing, (program, samples), (&self.flakes, &species));
        }
    }

    fn draw_polygons(
        &self,
        stock: &Stock,
        drawing: &mut RenderPass,
        draw: &PolygonDraw,
        (program, samples): (TreeProgram, u32),
    ) {
        let species = &stock.species[draw.species];
        let all = species.instances.as_ref().filter(|_| draw.object.is_none());
        match all {
            Some(all) => drawing.set_vertex_buffer(1, all.words.slice(..)),
            None => drawing.set_vertex_buffer(1, self.parts.slice()),
        }
        for mesh in
            species.meshes.iter().filter(|mesh| draw.object.is_none_or(|object| object == mesh.object))
        {
            let instances = all.map_or(&draw.instances, |all| &all.of_object[mesh.object]);
            let cuts = Cuts { by_picture: mesh.is_cut, by_door: draw.in_part };
            drawing.set_pipeline(&stock.pipelines[&(program, cuts, samples)]);
            drawing.set_bind_group(2, &mesh.material, &[]);
            drawing.set_vertex_buffer(0, mesh.corners.slice(..));
            drawing.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
            drawing.draw_indexed(0..mesh.index_count, 0, instances.clone());
        }
    }
}
