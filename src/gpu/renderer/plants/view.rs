//! What a view shows of the trees of a site: which parts of them are drawn from images and which as polygons, and the drawing.

use std::cell::Cell;
use std::num::NonZeroU64;
use std::time::{Duration, Instant};

use bytemuck::Zeroable;
use glam::{DAffine3, DVec2, DVec3, Vec2, Vec3};
use rayon::prelude::*;
use wgpu::{BindGroup, BufferUsages, RenderPass};

use super::daylight::DaylightWords;
use super::flake::{FlakeImageWords, SpeciesImages, rows_of};
use super::flaked::{Flaked, ShownWords};
use super::flakes::{Flakes, FlakesExtent};
use super::pipeline::{PlacementWords, SampledProgram, TreeProgram};
use super::polygons::{PolygonDraw, Polygons, PolygonsOfTree};
use super::ratio::RatioWords;
use super::resources::TreeResources;
use super::slices::Slices;
use crate::bindings;
use crate::device::Gpu;
use crate::renderer::table::GrowingBuffer;
use quadratura_base::error::Result;
use quadratura_base::geometry::{Pinhole, PixelRect};
use quadratura_foliage::{Ball, ImageInView, InView, Tree, TreeCost, TreePace, WalkOptions, sees};
use quadratura_view::{Quality, Shot, TreeMethod};

/// The trees of a view on the device.
#[derive(Debug)]
pub struct PlantsView {
    daylight: GrowingBuffer,
    /// [`ShownWords`] of the trees in view.
    shown: GrowingBuffer,
    /// [`super::ratio::RatioWords`] of the trees in view.
    ratios: GrowingBuffer,
    /// How instances are placed ([`PlacementWords`]), each at a multiple of [`TreeResources::stride`].
    placements: GrowingBuffer,
    /// The trees that are drawn as polygons alone.
    whole: Vec<usize>,
    pub(in crate::renderer) polygons: Polygons,
    pub(in crate::renderer) flakes: Flakes,
    flaked: Flaked,
    /// Whether images are in view.
    has_images: bool,
    /// The pixels in which their samples may be.
    pub(in crate::renderer) rect: PixelRect,
    /// How fine they are in pictures that follow each other, and the time that trees may take in this one.
    pub(in crate::renderer) pace: Cell<TreePace>,
    within: Option<Duration>,
    /// The finest images of previews.
    pub(in crate::renderer) finest: WalkOptions,
    /// When images serve in the view.
    pub(in crate::renderer) options: WalkOptions,
    /// The picture that the tables are of, and its samples a pixel; `None` where that holds no more.
    of: Option<(Shot, u32)>,
    /// Whether the nearest samples of these tables were found.
    pub(in crate::renderer) is_found: Cell<bool>,
    cost: TreeCost,
    /// How long it took to find and write what is in view.
    listed: Duration,
    /// The focal lengths of the view and its centre, in pixels.
    lens: [Vec2; 2],
}

/// What a view shows of a tree from its images and as polygons.
struct TreeInView {
    images: Vec<FlakeImageWords>,
    polygons: PolygonsOfTree,
}

impl TreeInView {
    fn new(
        resources: &TreeResources,
        shot: &Shot,
        slot: u32,
        number: usize,
        images: &SpeciesImages,
        options: &WalkOptions,
        with_balls: bool,
    ) -> Self {
        let species = resources.placed.trees[number].species;
        let plant = &resources.placed.species[species].plant;
        let InView { images: of_tree, polygons } = resources.seen(shot, number, images, options);
        let words = |image: &ImageInView| FlakeImageWords {
            tree: slot,
            species: species as u32,
            ..images.words(plant, image)
        };
        Self {
            images: of_tree.iter().map(words).collect(),
            polygons: PolygonsOfTree::new(plant, &polygons, slot, species, with_balls),
        }
    }
}

/// Begins a pass over what is there, or where the second argument is true, over nothing.
pub type BeginPass<'a> = dyn for<'e> Fn(&'e mut wgpu::CommandEncoder, bool) -> RenderPass<'e> + 'a;

/// What trees are drawn onto.
pub struct TreeTarget<'a> {
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
            shown: GrowingBuffer::new(gpu, "trees in view", BufferUsages::STORAGE),
            ratios: GrowingBuffer::new(gpu, "ratio images in view", BufferUsages::STORAGE),
            placements: GrowingBuffer::new(gpu, "placements", BufferUsages::UNIFORM),
            whole: Vec::new(),
            polygons: Polygons::new(gpu),
            flakes: Flakes::new(gpu),
            flaked: Flaked::new(gpu),
            has_images: false,
            rect: PixelRect::EMPTY,
            pace: Cell::default(),
            within: None,
            finest: WalkOptions::PREVIEW,
            options: WalkOptions::PREVIEW,
            of: None,
            is_found: Cell::default(),
            cost: TreeCost::default(),
            listed: Duration::ZERO,
            lens: [Vec2::ZERO; 2],
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
    /// [`quadratura_base::Error::Request`] for a plant that has too many instances to be drawn as polygons.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        resources: &mut TreeResources,
        is_drawn: &dyn Fn(&Tree) -> bool,
        shot: &Shot,
        program: SampledProgram,
        of_common: [f64; 3],
    ) -> Result<bool> {
        let placed = resources.placed.clone();
        let is_in_view = |number: &usize| {
            let ball = placed.ball(&placed.trees[*number]);
            let middle = shot.pose.camera_from_world(ball.middle);
            is_drawn(&placed.trees[*number]) && sees(&shot.camera, &Ball { middle, ..ball })
        };
        let in_view: Vec<usize> = (0..placed.trees.len()).filter(is_in_view).collect();
        if in_view.is_empty() {
            return Ok(false);
        }
        self.daylight.write(gpu, &[DaylightWords::new(&placed.light, shot)]);
        // Numbers are those of what the picture of the view shows, where that was drawn just before.
        let is_numbered = program.program == TreeProgram::Numbered;
        let is_same = self.of.as_ref().is_some_and(|(of, count)| of == shot && *count == program.samples);
        if !(is_numbered && is_same) {
            (self.of, self.is_found) = (None, Cell::default());
            self.within = shot.trees_within.filter(|_| shot.quality == Quality::Preview && !is_numbered);
            self.write_parts(gpu, resources, shot, &in_view, program.samples)?;
            self.of = (!is_numbered).then(|| (shot.clone(), program.samples));
        }
        let exposure = DVec3::from_array(of_common).as_vec3();
        self.write_trees(gpu, resources, shot, &in_view, exposure);
        resources.want_pipelines(gpu, program, self.polygons.any_in_part());
        if self.has_images {
            self.flaked.prepare(gpu, program, [&resources.layouts[0], &resources.layouts[3]]);
        }
        Ok(true)
    }

    /// Returns when images serve in a view, if it is drawn now.
    fn options_now(&self, shot: &Shot) -> WalkOptions {
        match (shot.quality, shot.trees_within) {
            (Quality::Preview, Some(_)) => {
                WalkOptions { threshold: self.pace.get().threshold().max(self.finest.threshold) }
            }
            // Of a finer image, several pixels become one.
            (Quality::Preview, None) | (Quality::Finer, _) => self.finest,
            (Quality::Final, _) => WalkOptions::FINAL,
        }
    }

    /// Writes what of the trees in view is drawn from images, and what as polygons.
    fn write_parts(
        &mut self,
        gpu: &Gpu,
        resources: &mut TreeResources,
        shot: &Shot,
        in_view: &[usize],
        samples: u32,
    ) -> Result<()> {
        let mut began = Instant::now();
        let mut images = self.find_parts(gpu, resources, shot, in_view)?;
        if self.within.is_some() && self.pace.get_mut().begin(self.cost) {
            began = Instant::now();
            images = self.find_parts(gpu, resources, shot, in_view)?;
        }
        self.polygons.divide(gpu, resources);
        self.listed = began.elapsed();
        let Pinhole { fx, fy, cx, cy, .. } = shot.camera;
        self.lens = [DVec2::new(fx, fy), DVec2::new(cx, cy)].map(|of| of.as_vec2());
        let size = [shot.camera.width, shot.camera.height];
        if !images.is_empty() || self.polygons.are_tested() {
            self.flakes.make(gpu, FlakesExtent { size, samples, reach: self.options.reach_px() });
        }
        let began = Instant::now();
        let of_images = images.par_iter().map(|image| image.rect(self.lens));
        let of_images = of_images.reduce(|| PixelRect::EMPTY, |a, b| a.hull(&b));
        // Samples extend this far beyond the pixel of their point, which rounding may move by one.
        let around = of_images.grown(self.options.reach_px() + 1);
        self.rect = around.intersection(&PixelRect::of_size(size[0], size[1]));
        self.has_images = self.flakes.prepare(gpu, &mut images, &resources.images()) && !self.rect.is_empty();
        self.listed += began.elapsed();
        Ok(())
    }

    /// Finds what of the trees in view is drawn from images, which come species by species, and what as polygons, and what that costs.
    fn find_parts(
        &mut self,
        gpu: &Gpu,
        resources: &mut TreeResources,
        shot: &Shot,
        in_view: &[usize],
    ) -> Result<Vec<FlakeImageWords>> {
        let options = self.options_now(shot);
        self.options = options;
        let with_balls = self.polygons.least_of_batch.is_some();
        let from_images = |(slot, number): (usize, &usize)| {
            let images = resources.species[resources.placed.trees[*number].species].images.as_ref()?;
            let is_wanted = shot.trees == TreeMethod::Flakes;
            is_wanted
                .then(|| TreeInView::new(resources, shot, slot as u32, *number, images, &options, with_balls))
        };
        let seen: Vec<Option<TreeInView>> = in_view.par_iter().enumerate().map(from_images).collect();
        let (mut images, mut polygons) = (vec![Vec::new(); resources.species.len()], Vec::new());
        let mut species_of_whole = Vec::new();
        self.whole.clear();
        for (&number, seen) in in_view.iter().zip(&seen) {
            let species = resources.placed.trees[number].species;
            let Some(seen) = seen else {
                resources.species[species].want_instances(gpu, &resources.placed.species[species].plant)?;
                species_of_whole.push(species);
                self.whole.push(number);
                continue;
            };
            images[species].push(&seen.images[..]);
            polygons.push(&seen.polygons);
        }
        self.polygons.set(&polygons, &species_of_whole);
        let images = images.concat().concat();
        self.cost = TreeCost {
            samples: images.iter().map(|image| u64::from(image.count)).sum(),
            triangles: self.polygons.triangles(resources),
        };
        Ok(images)
    }

    fn write_trees(
        &mut self,
        gpu: &Gpu,
        resources: &TreeResources,
        shot: &Shot,
        in_view: &[usize],
        exposure: Vec3,
    ) {
        let mut ratios = Vec::new();
        let shown = in_view.iter().map(|number| resources.shown(shot, *number, exposure, &mut ratios));
        self.shown.write(gpu, &shown.collect::<Vec<ShownWords>>());
        // Nothing cannot be bound.
        ratios.resize(ratios.len().max(1), RatioWords::zeroed());
        self.ratios.write(gpu, &ratios);
        let camera_from_world = DAffine3::from_mat3_translation(shot.pose.rotation, shot.pose.translation);
        let stride = resources.stride as usize;
        let mut bytes = vec![0u8; stride * (1 + self.whole.len())];
        let mut write = |index: usize, map: &DAffine3, first: u32| {
            let [right, down, forward] = rows_of(map);
            let words = PlacementWords { right, down, forward, first, ..PlacementWords::zeroed() };
            bytes[stride * index..][..size_of::<PlacementWords>()]
                .copy_from_slice(bytemuck::bytes_of(&words));
        };
        // Parts are mapped to the camera's frame already, and know their trees.
        write(0, &DAffine3::IDENTITY, 0);
        for (index, number) in (1..).zip(&self.whole) {
            // Both are in the order of the trees.
            let first = in_view.binary_search(number).expect("whole trees are in view");
            write(
                index,
                &(camera_from_world * resources.placed.trees[*number].world_from_plant),
                first as u32,
            );
        }
        self.placements.write(gpu, &bytes);
    }

    /// Returns what of the trees is handed to the device at once, as a cost in samples.
    pub fn most_at_once(&self) -> f64 {
        self.pace.get().most_at_once()
    }

    /// Draws the trees in view, for which [`Self::prepare`] was called: polygons first, since these are near and hide much. Where trees have a
    /// time limit, they are waited for, and the next picture follows from how long they took.
    ///
    /// # Errors
    /// Those of [`Slices::hand_over`] and [`Flakes::tiles`].
    pub fn draw(
        &self,
        resources: &TreeResources,
        slices: &mut Slices,
        onto: &TreeTarget,
        frame: wgpu::BindingResource,
        program: SampledProgram,
    ) -> Result<()> {
        let gpu = slices.gpu();
        let light = || {
            let (ratios, cells) = (self.ratios.binding(), resources.ratios.binding());
            [self.daylight.binding(), ratios, cells, resources.sunlit.binding()]
        };
        let lights = resources.species.iter().map(|of| of.crown.bind(gpu, &resources.layouts[3], light()));
        let size = NonZeroU64::new(size_of::<PlacementWords>() as u64);
        let placement = wgpu::BufferBinding { buffer: self.placements.buffer(), offset: 0, size };
        let trees = [wgpu::BindingResource::Buffer(placement), self.shown.binding()];
        let bound = Bound {
            frame: bindings::bind(gpu, "frame", &resources.layouts[0], std::slice::from_ref(&frame)),
            trees: bindings::bind(gpu, "trees", &resources.layouts[1], &trees),
            species: resources.images().into_iter().zip(lights).collect(),
        };
        let within = self.within.filter(|_| !self.is_found.get());
        if within.is_some() {
            slices.hand_over()?;
        }
        let (began, done_before) = (Instant::now(), slices.done());
        let mut found = self.find(resources, slices, onto, frame, &bound, program);
        if let Some(within) = within {
            found = found.and_then(|()| slices.hand_over());
            // Where it was given up, what was done tells as much. What is hidden counts as drawn: how much that is changes little from
            // one picture to the next.
            let (done, seconds) = match &found {
                Ok(()) => (
                    self.cost.in_samples() + self.polygons.cost_of_whole(resources),
                    self.listed + began.elapsed(),
                ),
                Err(_) => (slices.done() - done_before, began.elapsed()),
            };
            let mut pace = self.pace.get();
            pace.learn(done, seconds.as_secs_f64());
            pace.follow(self.cost, within.as_secs_f64());
            self.pace.set(pace);
        }
        found?;
        if self.has_images {
            let mut drawing = (onto.begin)(slices.encoder(), false);
            let PixelRect { x, y, w, h } = self.rect;
            drawing.set_scissor_rect(x as u32, y as u32, w, h);
            drawing.set_bind_group(0, &bound.frame, &[]);
            self.flaked.draw(gpu, &mut drawing, program, &self.flakes, &self.shown, &bound.species);
        }
        self.is_found.set(true);
        Ok(())
    }

    /// Draws polygons, and finds the nearest samples of images, as far as they are not behind what is drawn before them.
    fn find(
        &self,
        resources: &TreeResources,
        slices: &mut Slices,
        onto: &TreeTarget,
        frame: wgpu::BindingResource,
        bound: &Bound,
        program: SampledProgram,
    ) -> Result<()> {
        let gpu = slices.gpu();
        drop((onto.begin)(slices.encoder(), true));
        if self.is_found.get() {
            let parts = self.polygons.drawn(resources, slices.most());
            return self.draw_polygons(resources, slices, onto, bound, program, &parts);
        }
        for batch in 0..self.polygons.batches.len() {
            let tiles = match self.polygons.are_tested() {
                true => Some(self.flakes.tiles(slices, frame.clone(), onto.depths, batch == 0, self.lens)?),
                false => None,
            };
            let parts = self.polygons.write(gpu, resources, batch, tiles.as_ref(), slices.most());
            self.draw_polygons(resources, slices, onto, bound, program, &parts)?;
        }
        if self.has_images {
            self.flakes.record(slices, frame, &resources.images(), onto.depths)?;
        }
        Ok(())
    }

    fn draw_polygons(
        &self,
        resources: &TreeResources,
        slices: &mut Slices,
        onto: &TreeTarget,
        bound: &Bound,
        program: SampledProgram,
        parts: &[(Vec<PolygonDraw>, f64)],
    ) -> Result<()> {
        for (draws, cost) in parts {
            let mut drawing = (onto.begin)(slices.encoder(), false);
            drawing.set_bind_group(0, &bound.frame, &[]);
            for draw in draws {
                drawing.set_bind_group(
                    1,
                    &bound.trees,
                    &[(u64::from(draw.placement) * resources.stride) as u32],
                );
                drawing.set_bind_group(3, &bound.species[draw.species].1, &[]);
                self.polygons.draw(resources, &mut drawing, draw, program);
            }
            drop(drawing);
            slices.count(*cost)?;
        }
        Ok(())
    }
}

/// What is bound where trees are drawn.
struct Bound<'a> {
    frame: BindGroup,
    /// At the offset of how instances are placed.
    trees: BindGroup,
    /// Of each species the images, and light.
    species: Vec<(Option<&'a SpeciesImages>, BindGroup)>,
}
