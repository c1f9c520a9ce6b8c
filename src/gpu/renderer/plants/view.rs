//! What a view shows of the trees of a site: which parts of them are drawn from images and which as polygons, and the drawing.

use std::cell::Cell;
use std::num::NonZeroU64;
use std::ops::Range;
use std::time::{Duration, Instant};

use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;
use wgpu::{BufferUsages, RenderPass};

use super::daylight::DaylightWords;
use super::flake::{FlakeImageWords, SpeciesImages, rows_of};
use super::flaked::{Flaked, ShownWords};
use super::flakes::{Flakes, FlakesExtent};
use super::slices::Slices;
use super::species::{InstanceWords, MeshBuffers};
use super::stock::Stock;
use super::{Cuts, TreeProgram, TreeWords};
use crate::error::Result;
use crate::foliage::{
    Ball, ImageInView, InView, PolygonsInView, Tree, TreeCost, TreePace, WalkOptions, sees,
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
    pub(in crate::gpu::renderer) flakes: Flakes,
    flaked: Flaked,
    /// Whether images are in view.
    has_images: bool,
    /// How fine they are in pictures that follow each other, and the time that trees may take in this one.
    pub(in crate::gpu::renderer) pace: Cell<TreePace>,
    within: Option<Duration>,
    /// The finest images of previews.
    pub(in crate::gpu::renderer) finest: WalkOptions,
    /// When images serve in the view.
    pub(in crate::gpu::renderer) options: WalkOptions,
    /// The picture that the tables are of, and its samples a pixel; `None` where that holds no more.
    of: Option<(Shot, u32)>,
    /// Whether the nearest samples of these tables were found.
    is_found: Cell<bool>,
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

/// What a view shows of a tree from its images and as polygons.
struct TreeInView {
    images: Vec<FlakeImageWords>,
    parts: Vec<InstanceWords>,
    /// What is drawn of `parts`: the sub-object, whether in part of the sub-pixels, and the parts.
    draws: Vec<(usize, bool, Range<u32>)>,
}

impl TreeInView {
    fn new(
        stock: &Stock,
        shot: &Shot,
        (slot, number): (u32, usize),
        images: &SpeciesImages,
        options: &WalkOptions,
    ) -> Self {
        let species = stock.wood.trees[number].species;
        let plant = &stock.wood.species[species].plant;
        let InView { images: of_tree, polygons } = stock.seen(shot, number, images, options);
        let words = |image: &ImageInView| FlakeImageWords {
            tree: slot,
            species: species as u32,
            ..images.words(plant, image)
        };
        let kind = |of: &PolygonsInView| (of.object, !of.door.is_wide());
        let mut end = 0;
        let draw = |alike: &[PolygonsInView]| {
            let ((object, in_part), first) = (kind(&alike[0]), end);
            end += alike.len() as u32;
            (object, in_part, first..end)
        };
        Self {
            images: of_tree.iter().map(words).collect(),
            parts: polygons.iter().map(|of| InstanceWords::new(&of.view_from_object, &of.door)).collect(),
            draws: polygons.chunk_by(|a, b| kind(a) == kind(b)).map(draw).collect(),
        }
    }
}

/// Begins a pass over what is there, or where the second argument is true, over nothing.
pub type BeginPass<'a> = dyn for<'e> Fn(&'e mut wgpu::CommandEncoder, bool) -> RenderPass<'e> + 'a;

/// What trees are drawn onto.
pub struct Onto<'a> {
    /// Begins a pass.
    pub begin: &'a BeginPass<'a>,
    /// Its depth buffer.
    pub depths: &'a wgpu::TextureView,
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
            finest: WalkOptions::PREVIEW,
            options: WalkOptions::PREVIEW,
            of: None,
            is_found: Cell::default(),
            cost: TreeCost::default(),
        }
    }

    /// Forgets the picture, because trees or faces have changed.
    pub fn forget(&mut self) {
        self.of = None;
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
        // Numbers are those of what the picture of the view shows, where that was drawn just before.
        let is_numbered = program == TreeProgram::Numbered;
        let is_same = self.of.as_ref().is_some_and(|(of, count)| of == shot && *count == samples);
        if !(is_numbered && is_same) {
            (self.of, self.is_found) = (None, Cell::default());
            self.within = shot.trees_within.filter(|_| shot.quality == Quality::Preview && !is_numbered);
            self.write_parts(gpu, stock, shot, (&in_view, samples))?;
            self.of = (!is_numbered).then(|| (shot.clone(), samples));
        }
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

    /// Returns when images serve in a view, if it is drawn now.
    fn options_now(&self, shot: &Shot) -> WalkOptions {
        match (shot.quality, shot.trees_within) {
            (Quality::Preview, Some(_)) => {
                WalkOptions { threshold: self.pace.get().threshold().max(self.finest.threshold) }
            }
            (Quality::Preview, None) => self.finest,
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
        let size = [shot.camera.width, shot.camera.height];
        let extent = FlakesExtent { size, samples, reach: self.options.reach_px() };
        self.has_images = self.flakes.prepare(gpu, &mut images, &stock.images(), extent);
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
        let options = self.options_now(shot);
        self.options = options;
        let from_images = |(slot, number): (usize, &usize)| {
            let images = stock.species[stock.wood.trees[*number].species].images.as_ref()?;
            let is_wanted = shot.trees == TreeMethod::Flakes;
            is_wanted.then(|| TreeInView::new(stock, shot, (slot as u32, *number), images, &options))
        };
        let seen: Vec<Option<TreeInView>> = in_view.par_iter().enumerate().map(from_images).collect();
        let (mut images, mut parts) = (vec![Vec::new(); stock.species.len()], Vec::new());
        let mut before = 0;
        self.polygons.clear();
        for ((slot, &number), seen) in (0u32..).zip(in_view).zip(&seen) {
            let species = stock.wood.trees[number].species;
            let Some(TreeInView { images: of_tree, parts: of_polygons, draws }) = seen else {
                stock.species[species].want_instances(gpu, &stock.wood.species[species].plant)?;
                self.polygons.push(PolygonDraw {
                    slot,
                    species,
                    object: None,
                    instances: 0..0,
                    in_part: false,
                });
                continue;
            };
            images[species].push(&of_tree[..]);
            let first = before;
            before += of_polygons.len() as u32;
            parts.push(&of_polygons[..]);
            self.polygons.extend(draws.iter().map(|(object, in_part, instances)| PolygonDraw {
                slot,
                species,
                object: Some(*object),
                instances: first + instances.start..first + instances.end,
                in_part: *in_part,
            }));
        }
        let (images, parts) = (images.concat().concat(), parts.concat());
        self.cost = self.cost_of(stock, &images);
        Ok((images, parts))
    }

    /// Returns what the parts in view cost; trees that are drawn as polygons alone, whatever their size in the view, are left out.
    fn cost_of(&self, stock: &Stock, images: &[FlakeImageWords]) -> TreeCost {
        let parts = self.polygons.iter().filter(|draw| draw.object.is_some());
        TreeCost {
            samples: images.iter().map(|image| u64::from(image.count)).sum(),
            triangles: parts.map(|draw| triangles_of(stock, draw)).sum(),
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

    /// Returns what of the trees is handed to the device at once, as a cost in samples.
    pub fn most_at_once(&self) -> f64 {
        self.pace.get().most_at_once()
    }

    /// Finds the nearest samples of images in view, of those that are not behind what `depths` holds. Where trees may take so much time
    /// and no more, this is waited for, and the next picture follows from how long it took.
    fn find(
        &self,
        stock: &Stock,
        slices: &mut Slices,
        frame: wgpu::BindingResource,
        depths: &wgpu::TextureView,
    ) -> Result<()> {
        let Some(within) = self.within else {
            return self.flakes.record(slices, frame, &stock.images(), depths);
        };
        slices.hand_over()?;
        let (began, done_before) = (Instant::now(), slices.done());
        let recorded = self.flakes.record(slices, frame, &stock.images(), depths);
        let recorded = recorded.and_then(|()| slices.hand_over());
        // Where it was given up, what was done tells as much. Hidden samples count as drawn: how many are hidden changes little from one
        // picture to the next.
        let mut pace = self.pace.get();
        pace.learn((slices.done() - done_before) as u64, began.elapsed().as_secs_f64());
        pace.follow(self.cost, within.as_secs_f64());
        self.pace.set(pace);
        recorded
    }

    /// Draws the trees in view, for which [`Self::prepare`] was called: polygons first, since these are near and hide much.
    ///
    /// # Errors
    /// Those of [`Slices::hand_over`].
    pub fn draw(
        &self,
        stock: &Stock,
        slices: &mut Slices,
        onto: &Onto,
        frame: wgpu::BindingResource,
        (program, samples): (TreeProgram, u32),
    ) -> Result<()> {
        let gpu = slices.gpu();
        let of_frame = bindings::bind(gpu, "frame", &stock.layouts[0], std::slice::from_ref(&frame));
        let lights =
            stock.species.iter().map(|of| of.crown.bind(gpu, &stock.layouts[3], self.daylight.binding()));
        let species: Vec<_> = stock.images().into_iter().zip(lights).collect();
        let size = NonZeroU64::new(size_of::<TreeWords>() as u64);
        let tree = wgpu::BufferBinding { buffer: self.trees.buffer(), offset: 0, size };
        let tree = bindings::bind(gpu, "tree", &stock.layouts[1], &[wgpu::BindingResource::Buffer(tree)]);
        let parts = self.polygons_at_once(stock, slices.most());
        if parts.is_empty() {
            drop((onto.begin)(slices.encoder(), true));
        }
        let mut is_first = true;
        for (draws, cost) in parts {
            let mut drawing = (onto.begin)(slices.encoder(), std::mem::take(&mut is_first));
            drawing.set_bind_group(0, &of_frame, &[]);
            for draw in draws {
                drawing.set_bind_group(1, &tree, &[(u64::from(draw.slot) * stock.stride) as u32]);
                drawing.set_bind_group(3, &species[draw.species].1, &[]);
                self.draw_polygons(stock, &mut drawing, draw, (program, samples));
            }
            drop(drawing);
            slices.count(cost)?;
        }
        if self.has_images {
            if !self.is_found.get() {
                self.find(stock, slices, frame, onto.depths)?;
                self.is_found.set(true);
            }
            let mut drawing = (onto.begin)(slices.encoder(), false);
            drawing.set_bind_group(0, &of_frame, &[]);
            self.flaked.draw(gpu, &mut drawing, (program, samples), (&self.flakes, &species));
        }
        Ok(())
    }

    /// Divides what is drawn as polygons into parts that cost about `most` samples, each with its cost.
    fn polygons_at_once(&self, stock: &Stock, most: f64) -> Vec<(&[PolygonDraw], f64)> {
        let cost = |draw: &PolygonDraw| {
            let triangles = triangles_of(stock, draw);
            TreeCost { samples: 0, triangles }.in_samples()
        };
        let (mut parts, mut first, mut sum) = (Vec::new(), 0, 0.0);
        for (end, draw) in (1..).zip(&self.polygons) {
            sum += cost(draw);
            if sum >= most || end == self.polygons.len() {
                parts.push((&self.polygons[first..end], sum));
                (first, sum) = (end, 0.0);
            }
        }
        parts
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

/// Returns the number of triangles of what is drawn.
fn triangles_of(stock: &Stock, draw: &PolygonDraw) -> u64 {
    let species = &stock.species[draw.species];
    let all = species.instances.as_ref().filter(|_| draw.object.is_none());
    let meshes = species.meshes.iter().filter(|mesh| draw.object.is_none_or(|object| object == mesh.object));
    let of_mesh = |mesh: &MeshBuffers| {
        let instances = all.map_or(&draw.instances, |all| &all.of_object[mesh.object]);
        u64::from(mesh.index_count / 3) * instances.len() as u64
    };
    meshes.map(of_mesh).sum()
}
