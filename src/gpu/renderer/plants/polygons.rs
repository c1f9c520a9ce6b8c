//! Sub-objects of trees that are drawn as polygons. Where these have many triangles, they come in batches from near to far, and those of a
//! batch are left out that are behind what was drawn before it.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::Range;

use glam::Vec4;
use rayon::prelude::*;
use wgpu::{BufferUsages, RenderPass};

use super::hidden::TileDepths;
use super::pipeline::{Cuts, SampledProgram};
use super::resources::TreeResources;
use super::species::{InstanceWords, LevelInBuffers, MeshBuffers};
use crate::device::Gpu;
use crate::renderer::table::GrowingBuffer;
use quadratura_foliage::{Ball, Plant, PolygonsInView, TreeCost};

/// The most batches.
const MOST_BATCHES: u32 = 6;
/// The least number of instances that are handed to the device by themselves, however slow it is: software Vulkan keeps memory for each
/// time.
const LEAST_AT_ONCE: u32 = 512;
/// The least number of triangles in the first batch: looking at the picture so far takes about as long as drawing them.
const LEAST_OF_BATCH: u64 = 1 << 18;

/// Instances of a sub-object's triangles that are drawn as polygons.
#[derive(Debug, Clone, PartialEq)]
pub struct PolygonDraw {
    /// How they are placed: 0 for parts, else 1 and the place of the tree among those that are drawn as polygons alone.
    pub placement: u32,
    /// The species of the trees.
    pub species: usize,
    /// The sub-object with its level of detail; `None` for all sub-objects in full detail.
    object: Option<(usize, usize)>,
    /// Of one sub-object: in [`Polygons::all`] they are indices into [`Polygons::words`], in what is drawn those into
    /// [`Polygons::buffer`]. Those of all sub-objects are in [`super::species::SpeciesBuffers::instances`].
    instances: Range<u32>,
    /// Whether they are drawn in part of the sub-pixels.
    in_part: bool,
}

impl PolygonDraw {
    /// Returns the level of detail.
    fn level(&self) -> usize {
        self.object.map_or(0, |(_, level)| level)
    }
}

/// A species, a sub-object of it with its level of detail, and whether it is drawn in part of the sub-pixels: what is drawn at once.
type PolygonKind = (usize, (usize, usize), bool);

/// What a view shows of one tree as polygons.
#[derive(Debug, Default)]
pub struct PolygonsOfTree {
    words: Vec<InstanceWords>,
    /// As [`Polygons::balls`].
    balls: Vec<Vec4>,
    /// Which of them are of one kind.
    kinds: Vec<(PolygonKind, Range<usize>)>,
}

impl PolygonsOfTree {
    /// Prepares what is in view of a tree: its place among those in view, and its species. Balls are needed where parts are tested.
    pub fn new(
        plant: &Plant,
        polygons: &[PolygonsInView],
        tree: u32,
        species: usize,
        with_balls: bool,
    ) -> Self {
        let kind = |of: &PolygonsInView| (species, (of.object, of.level), !of.stipple.is_wide());
        let mut end = 0;
        let draw = |alike: &[PolygonsInView]| {
            let first = end;
            end += alike.len();
            (kind(&alike[0]), first..end)
        };
        let ball = |of: &PolygonsInView| {
            let Ball { middle, radius } = of.ball(plant);
            middle.extend(radius).as_vec4()
        };
        let words = |of: &PolygonsInView| InstanceWords::new(&of.view_from_object, &of.stipple, tree);
        Self {
            words: polygons.iter().map(words).collect(),
            balls: polygons.iter().filter(|_| with_balls).map(ball).collect(),
            kinds: polygons.chunk_by(|a, b| kind(a) == kind(b)).map(draw).collect(),
        }
    }
}

/// What a view shows as polygons.
#[derive(Debug)]
pub struct Polygons {
    /// Trees that are drawn as polygons alone, then kind by kind.
    all: Vec<PolygonDraw>,
    /// Of each part the map to the camera's frame.
    words: Vec<InstanceWords>,
    /// Of each part a ball around it in the camera's frame, the middle and the radius; none where parts are not tested.
    balls: Vec<Vec4>,
    /// The distances of the batches from the viewer, from near to far.
    pub batches: Vec<Range<f32>>,
    /// [`InstanceWords`] of what is drawn.
    buffer: GrowingBuffer,
    /// What is drawn of the batches so far.
    drawn: RefCell<Vec<PolygonDraw>>,
    /// [`LEAST_OF_BATCH`], or less in tests; `None` where parts are not tested.
    pub least_of_batch: Option<u64>,
}

impl Polygons {
    /// Creates an empty table. Parts are tested on software adapters alone: an H100 draws what is hidden in less time than the tests take
    /// (docs/performance.md).
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            all: Vec::new(),
            words: Vec::new(),
            balls: Vec::new(),
            batches: Vec::new(),
            buffer: GrowingBuffer::new(gpu, "parts of trees", BufferUsages::VERTEX),
            drawn: RefCell::default(),
            least_of_batch: gpu.is_software().then_some(LEAST_OF_BATCH),
        }
    }

    /// Sets what is in view: the parts of trees, and the species of trees that are drawn as polygons alone.
    pub fn set(&mut self, of_trees: &[&PolygonsOfTree], whole: &[usize]) {
        self.all.clear();
        let all_of = |(placement, species): (u32, &usize)| PolygonDraw {
            placement,
            species: *species,
            object: None,
            instances: 0..0,
            in_part: false,
        };
        self.all.extend((1..).zip(whole).map(all_of));
        let mut kinds: BTreeMap<PolygonKind, Vec<(&PolygonsOfTree, &Range<usize>)>> = BTreeMap::new();
        for of_tree in of_trees {
            for (kind, parts) in &of_tree.kinds {
                kinds.entry(*kind).or_default().push((of_tree, parts));
            }
        }
        self.words.clear();
        self.balls.clear();
        for ((species, object, in_part), parts) in kinds {
            let first = self.words.len() as u32;
            for (of_tree, parts) in parts {
                self.words.extend_from_slice(&of_tree.words[parts.clone()]);
                self.balls.extend(of_tree.balls.get(parts.clone()).unwrap_or_default());
            }
            let instances = first..self.words.len() as u32;
            self.all.push(PolygonDraw { placement: 0, species, object: Some(object), instances, in_part });
        }
    }

    /// Returns the number of triangles of parts; trees that are drawn as polygons alone, whatever their size in the view, are left out.
    pub fn triangles(&self, resources: &TreeResources) -> u64 {
        self.all.iter().filter(|draw| draw.object.is_some()).map(|draw| triangles_of(resources, draw)).sum()
    }

    /// Returns what trees cost that are drawn as polygons alone, in samples.
    pub fn cost_of_whole(&self, resources: &TreeResources) -> f64 {
        let whole = self.all.iter().filter(|draw| draw.object.is_none());
        TreeCost { samples: 0, triangles: whole.map(|draw| triangles_of(resources, draw)).sum() }.in_samples()
    }

    /// Returns whether something is drawn in part of the sub-pixels.
    pub fn any_in_part(&self) -> bool {
        self.all.iter().any(|draw| draw.in_part)
    }

    /// Divides what was set into batches, and makes room for it.
    pub fn divide(&mut self, gpu: &Gpu, resources: &TreeResources) {
        self.drawn.get_mut().clear();
        self.buffer.reserve(gpu, (self.words.len() * size_of::<InstanceWords>()) as u64);
        self.batches = match self.least_of_batch {
            Some(least) => batches(&self.triangles_by_depth(resources), least),
            None => vec![0.0..f32::INFINITY],
        };
    }

    /// Returns whether parts are looked for that are behind others.
    pub fn are_tested(&self) -> bool {
        self.batches.len() > 1
    }

    /// Returns the number of triangles by the depth of the nearest point of what they belong to: [`bin`].
    fn triangles_by_depth(&self, resources: &TreeResources) -> Vec<u64> {
        let mut triangles = vec![0; BINS];
        for draw in self.all.iter().filter(|draw| draw.object.is_some()) {
            let of_each = triangles_of(resources, draw) / draw.instances.len().max(1) as u64;
            for ball in &self.balls[range(&draw.instances)] {
                triangles[bin(nearest(ball))] += of_each;
            }
        }
        triangles
    }

    /// Writes those parts of a batch that tiles do not hide; all parts where there are no tiles. Returns what of it is drawn in slices that
    /// cost about `most` samples, each with its cost.
    pub fn write(
        &self,
        gpu: &Gpu,
        resources: &TreeResources,
        batch: usize,
        tiles: Option<&TileDepths>,
        most: f64,
    ) -> Vec<(Vec<PolygonDraw>, f64)> {
        let mut drawn = self.drawn.borrow_mut();
        let Some(tiles) = tiles else {
            self.buffer.write_at(gpu, 0, &self.words);
            drawn.clone_from(&self.all);
            return at_once(resources, &drawn, most);
        };
        let (distances, all_words, all_balls) = (&self.batches[batch], &self.words, &self.balls);
        let is_seen = |ball: &Vec4| distances.contains(&nearest(ball)) && !tiles.hide(ball);
        let seen = |draw: &PolygonDraw| -> Vec<InstanceWords> {
            let parts = range(&draw.instances);
            let parts = all_words[parts.clone()].par_iter().zip(&all_balls[parts]);
            parts.filter(|(_, ball)| is_seen(ball)).map(|(words, _)| *words).collect()
        };
        if batch == 0 {
            // A drawing that was given up may have left some.
            drawn.clear();
        }
        let first_draw = drawn.len();
        let mut end = drawn.last().map_or(0, |draw| draw.instances.end);
        for draw in &self.all {
            let Some(_) = draw.object else {
                // All of a tree comes first.
                drawn.extend((batch == 0).then(|| draw.clone()));
                continue;
            };
            let words = seen(draw);
            let instances = end..end + words.len() as u32;
            if !words.is_empty() {
                self.buffer.write_at(gpu, u64::from(end), &words);
                end = instances.end;
                drawn.push(PolygonDraw { instances, ..draw.clone() });
            }
        }
        // The time of hidden parts counts as that of seen ones where the device's speed is learned, so that seen ones take longer.
        let in_batch = self.balls.par_iter().filter(|ball| distances.contains(&nearest(ball))).count();
        let seen = drawn[first_draw..].iter().map(|draw| draw.instances.len()).sum::<usize>();
        at_once(
            resources,
            &drawn[first_draw..],
            most * (seen.max(1) as f64 / in_batch.max(1) as f64).min(1.0),
        )
    }

    /// Returns what was drawn of the batches, in slices as those of [`Self::write`].
    pub fn drawn(&self, resources: &TreeResources, most: f64) -> Vec<(Vec<PolygonDraw>, f64)> {
        at_once(resources, &self.drawn.borrow(), most)
    }

    /// Returns how many parts are in view, and how many of these were drawn.
    #[cfg(test)]
    pub fn counts(&self) -> [usize; 2] {
        [self.words.len(), self.drawn.borrow().iter().map(|draw| draw.instances.len()).sum()]
    }

    /// Draws instances; frame, trees and light are bound.
    pub fn draw(
        &self,
        resources: &TreeResources,
        drawing: &mut RenderPass,
        draw: &PolygonDraw,
        program: SampledProgram,
    ) {
        let species = &resources.species[draw.species];
        let all = species.instances.as_ref().filter(|_| draw.object.is_none());
        match all {
            Some(all) => drawing.set_vertex_buffer(1, all.words.slice(..)),
            None => drawing.set_vertex_buffer(1, self.buffer.buffer().slice(..)),
        }
        for mesh in meshes_of(resources, draw) {
            let instances = all.map_or(&draw.instances, |all| &all.of_object[mesh.object]);
            let cuts = Cuts { by_picture: mesh.is_cut, by_stipple: draw.in_part };
            drawing.set_pipeline(&resources.pipelines[&(program, cuts)]);
            drawing.set_bind_group(2, &mesh.material, &[]);
            drawing.set_vertex_buffer(0, mesh.corners.slice(..));
            drawing.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
            let LevelInBuffers { indices, first_corner } = mesh.level(draw.level());
            drawing.draw_indexed(indices.clone(), *first_corner, instances.clone());
        }
    }
}

/// Returns a depth that no point of a ball lies before.
fn nearest(ball: &Vec4) -> f32 {
    // No negative zero, whose bits are not in the order of depths.
    (ball.z - ball.w).max(0.0) + 0.0
}

/// The number of bins of depths.
const BINS: usize = 1 << 15;

/// Returns the bin of a depth that is not negative: its exponent and seven bits more, so that bins are in the order of depths and less
/// than a hundredth of a depth wide.
fn bin(depth: f32) -> usize {
    (depth.to_bits() >> 16) as usize
}

/// Divides depths into batches, where triangles are counted by [`bin`]s of depth: in the first two there are about as many triangles, in each
/// other as many as in all before it.
fn batches(triangles: &[u64], least: u64) -> Vec<Range<f32>> {
    let total: u64 = triangles.iter().sum();
    let doublings = (total / least.max(1)).max(1).ilog2().min(MOST_BATCHES - 1);
    let (mut batches, mut from, mut sum, mut wanted) = (Vec::new(), 0.0, 0, total >> doublings);
    for (bin, count) in triangles.iter().enumerate() {
        sum += count;
        if sum >= wanted && sum < total && batches.len() < doublings as usize {
            let to = f32::from_bits((bin as u32 + 1) << 16);
            batches.push(from..to);
            from = to;
            while wanted <= sum {
                wanted *= 2;
            }
        }
    }
    batches.push(from..f32::INFINITY);
    batches
}

fn range(of: &Range<u32>) -> Range<usize> {
    of.start as usize..of.end as usize
}

/// Divides what is drawn into slices that cost about `most` samples, each with its cost.
fn at_once(resources: &TreeResources, draws: &[PolygonDraw], most: f64) -> Vec<(Vec<PolygonDraw>, f64)> {
    let cost =
        |draw: &PolygonDraw| TreeCost { samples: 0, triangles: triangles_of(resources, draw) }.in_samples();
    let (mut slices, mut slice, mut sum) = (Vec::new(), Vec::new(), 0.0);
    for draw in draws {
        let PolygonDraw { instances, .. } = draw;
        // All of a tree is drawn at once.
        let step = match draw.object {
            Some(_) => {
                let step = most * instances.len() as f64 / cost(draw);
                step.clamp(f64::from(LEAST_AT_ONCE), f64::from(u32::MAX)) as u32
            }
            None => 1,
        };
        for first in (instances.start..instances.end.max(instances.start + 1)).step_by(step as usize) {
            let instances = first..instances.end.min(first.saturating_add(step));
            let draw = PolygonDraw { instances, ..draw.clone() };
            sum += cost(&draw);
            slice.push(draw);
            if sum >= most {
                slices.push((std::mem::take(&mut slice), std::mem::take(&mut sum)));
            }
        }
    }
    if !slice.is_empty() {
        slices.push((slice, sum));
    }
    slices
}

fn meshes_of<'a>(resources: &'a TreeResources, draw: &PolygonDraw) -> impl Iterator<Item = &'a MeshBuffers> {
    let object = draw.object.map(|(object, _)| object);
    let is_of = move |mesh: &&MeshBuffers| object.is_none_or(|object| object == mesh.object);
    resources.species[draw.species].meshes.iter().filter(is_of)
}

/// Returns the number of triangles of what is drawn.
fn triangles_of(resources: &TreeResources, draw: &PolygonDraw) -> u64 {
    let all = resources.species[draw.species].instances.as_ref().filter(|_| draw.object.is_none());
    let of_mesh = |mesh: &MeshBuffers| {
        let instances = all.map_or(&draw.instances, |all| &all.of_object[mesh.object]);
        (mesh.level(draw.level()).indices.len() / 3 * instances.len()) as u64
    };
    meshes_of(resources, draw).map(of_mesh).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_cover_all_depths_and_double() {
        let mut triangles = vec![0; BINS];
        assert_eq!(batches(&triangles, 10), [0.0..f32::INFINITY]);
        triangles[bin(3.0)] = 19;
        assert_eq!(batches(&triangles, 10), [0.0..f32::INFINITY]);
        // Evenly from 1 to 2.
        triangles.fill(0);
        (0..128).for_each(|i| triangles[bin(1.0 + (i as f32 + 0.5) / 128.0)] = 1);
        let of = |least: u64| {
            let batches = batches(&triangles, least);
            assert_eq!((batches[0].start, batches.last().unwrap().end), (0.0, f32::INFINITY));
            assert!(batches.windows(2).all(|two| two[0].end == two[1].start));
            let count = |batch: &Range<f32>| {
                let holds = |at: &usize| batch.contains(&f32::from_bits((*at as u32) << 16));
                (0..BINS).filter(holds).map(|at| triangles[at]).sum::<u64>()
            };
            batches.iter().map(count).collect::<Vec<_>>()
        };
        assert_eq!(of(16), [16, 16, 32, 64]);
        assert_eq!(of(1), [4, 4, 8, 16, 32, 64]);
        assert_eq!(of(65), [128]);
        // All at one depth are one batch.
        triangles.fill(0);
        triangles[bin(7.0)] = 1000;
        assert_eq!(batches(&triangles, 10), [0.0..f32::INFINITY]);
    }

    #[test]
    fn bins_are_in_the_order_of_depths() {
        assert_eq!(bin(0.0), 0);
        let depths = [0.0, 1e-30, 0.1, 0.1009, 1.0, 1.009, 5.0, 1e9, f32::MAX];
        assert!(depths.windows(2).all(|two| bin(two[0]) < bin(two[1])));
        assert!(bin(f32::INFINITY) < BINS);
    }
}
