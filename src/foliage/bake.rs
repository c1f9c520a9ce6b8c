//! Makes the images of a plant's sub-objects (Max 1996, section 3).

use glam::{DAffine3, DMat3, DVec2, Vec3};
use rayon::prelude::*;

use super::bounds::{Ball, Bounds};
use super::directions::Directions;
use super::drawer::{Drawer, FragmentCanvas};
use super::facet::Facet;
use super::gains::measured;
use super::images::{ImageCopy, LightCorrection, MBuffer, ObjectImages, PlantImages};
use super::layered::{LayeredRows, draw_part};
use super::mbuffer::{LayerSample, LayeredPixels, Slabs};
use super::mesh::Meshes;
use super::plant::{Plant, SubObject};
use super::raster::Fragment;
use super::reproject::TargetRows;
use super::view::{Projection, View};
use super::walk::{WalkOptions, walk_from};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::task::Task;

/// The stage that is reported for making images.
const STAGE: &str = "bake plant";

/// Surfaces within this many pixels' sides of depth are one layer of an image.
const SAME_LAYER: f64 = 1.5;

/// How images are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct BakeOptions {
    /// The directions from which images are made.
    pub directions: Directions,
    /// The number of slabs into which a sub-object is cut across a direction; 1 makes M-buffers.
    pub slabs: u8,
    /// The largest number of surfaces in a pixel of a slab. The last one takes all that is behind the others.
    pub layers: u8,
    /// Columns and rows of the finest images of all sub-objects but the whole plant, about; fewer, or no images, where there are few polygons.
    pub side: u32,
    /// The least columns and rows of the whole plant's finest images, unless it has few polygons.
    pub least_side: u32,
    /// The most columns and rows of the whole plant's finest images.
    pub most_side: u32,
    /// Whether images are made from those of the parts of a sub-object, where these have images, instead of all polygons (Max 1996):
    /// faster for plants of many polygons, and less accurate.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub from_parts: bool,
}

impl Default for BakeOptions {
    fn default() -> Self {
        Self::LAYERS
    }
}

impl BakeOptions {
    /// M-buffers: 22 directions, up to eight surfaces in a pixel (Max 1996: four).
    pub const LAYERS: Self = Self {
        directions: Directions::Around,
        slabs: 1,
        layers: 8,
        side: 192,
        least_side: 96,
        most_side: 384,
        from_parts: false,
    };
    /// Slabs: six directions, six slabs (Max, Deussen & Keating 1999). A second surface in a pixel of a slab fills what the first one
    /// leaves open.
    pub const SLABS: Self = Self { directions: Directions::Axes, slabs: 6, layers: 2, ..Self::LAYERS };
}

/// The directions whose views tell how many samples views have: three at right angles, of both kinds of images.
const SIDES: [usize; 3] = [0, 2, 4];

/// The most that leaves let through over what they reflect.
const MOST_THROUGH: f32 = 16.0;

/// Copies end at this many pixels across.
const COARSEST_SIDE: f64 = 24.0;

/// How many samples views from [`SIDES`] have on average for each polygon of the sub-object, at most. Of 22 directions about two serve a
/// viewpoint, and devices draw four samples about as fast as a polygon, or faster (docs/performance.md).
const SAMPLES_PER_POLYGON: f64 = 2.0;

/// Makes images of the sub-objects for which they save something; those of fewer polygons than `side` have none.
///
/// The whole plant, and sub-objects that it uses at least as often as there are directions, have the finest images, up to the wanted
/// resolution, whose views have at most two samples for each polygon; they have none if even views of 24 pixels have more. Other
/// sub-objects have images of the wanted resolution, or none if their views have more samples than polygons: making and storing all views
/// would cost more than their few uses save. In a painted plant, each use that paint reaches is such a sub-object.
///
/// All images have copies of half the resolution, a quarter, and so on.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn bake(plant: &Plant, options: &BakeOptions, task: &Task) -> Result<PlantImages> {
    let meshes = if options.from_parts { Meshes::of_all_levels(plant) } else { Meshes::in_full(plant) };
    let baker = Baker { plant, meshes: &meshes, options, task };
    let instances = plant.instances();
    let leaf = plant.whole().leaves.mean();
    let total = plant.objects.len() as u64;
    let BakeOptions { directions, from_parts, .. } = *options;
    // Parts come before what uses them.
    let mut images = PlantImages { directions, from_parts: false, objects: vec![None; plant.objects.len()] };
    let mut has_parts = vec![false; plant.objects.len()];
    for object in 0..plant.objects.len() {
        task.step(STAGE, object as u64, total)?;
        let mut children = plant.objects[object].uses.iter().map(|of| of.child);
        has_parts[object] = children.any(|child| images.objects[child].is_some() || has_parts[child]);
        let parts = Some(&images).filter(|_| from_parts && has_parts[object]);
        let is_shared = object == plant.root || instances[object] >= directions.count() as u64;
        let made = baker.object(parts, object, is_shared, leaf)?;
        images.from_parts |= made.is_some() && from_parts && has_parts[object];
        images.objects[object] = made;
    }
    task.step(STAGE, total, total)?;
    Ok(images)
}

/// Makes the finest images of a whole plant, whether they save something or not; `None` for a plant without size.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn finest_copy(plant: &Plant, options: &BakeOptions, task: &Task) -> Result<Option<ImageCopy>> {
    let meshes = Meshes::in_full(plant);
    let baker = Baker { plant, meshes: &meshes, options, task };
    let ball = plant.whole().bounds.ball;
    if ball.radius <= 0.0 {
        return Ok(None);
    }
    let finest = 2.0 * ball.radius / baker.whole_side(&ball, plant.whole().leaves.mean());
    baker.copy(None, plant.root, finest).map(|(copy, _)| Some(copy))
}

struct Baker<'a> {
    plant: &'a Plant,
    meshes: &'a Meshes,
    options: &'a BakeOptions,
    task: &'a Task,
}

impl Baker<'_> {
    /// Makes the images of a sub-object, if they save something; from `parts`, the images of its parts, where they are given.
    fn object(
        &self,
        parts: Option<&PlantImages>,
        object: usize,
        is_shared: bool,
        leaf: Option<f64>,
    ) -> Result<Option<ObjectImages>> {
        let ball = self.plant.objects[object].bounds.ball;
        let is_whole = object == self.plant.root;
        let across = if is_whole { self.whole_side(&ball, leaf) } else { f64::from(self.options.side) };
        if ball.radius <= 0.0 {
            return Ok(None);
        }
        let Some(finest) = self.finest(parts, object, is_shared, 2.0 * ball.radius / across)? else {
            return Ok(None);
        };
        let (copy, light) = self.copy(parts, object, finest)?;
        let mut copies = vec![copy];
        let mut delta = 2.0 * finest;
        while is_fine_enough(&self.plant.objects[object].bounds, delta) {
            copies.push(self.copy(parts, object, delta)?.0);
            delta *= 2.0;
        }
        let sums = light.iter().fold([Vec3::ZERO; 2], |all, of| [all[0] + of[0], all[1] + of[1]]);
        let images = ObjectImages { copies, through: through_over_reflected(sums) };
        measured(self.plant, object, images, self.options.directions, parts, self.task).map(Some)
    }

    /// Returns the side of a pixel of the finest images that save something: `wanted`, or, of shared sub-objects, larger by powers of the
    /// square root of 2; `None` where images do not save anything.
    fn finest(
        &self,
        parts: Option<&PlantImages>,
        object: usize,
        is_shared: bool,
        wanted: f64,
    ) -> Result<Option<f64>> {
        let SubObject { bounds, counts, .. } = &self.plant.objects[object];
        let most = if is_shared { SAMPLES_PER_POLYGON } else { 1.0 } * counts.polygons as f64;
        // Fewer polygons than pixels in a row are no reason for images, and plants may store thousands of such sub-objects.
        if counts.polygons < u64::from(self.options.side) {
            return Ok(None);
        }
        let pixels = f64::from(side_of(bounds.ball.radius, wanted)).powi(2);
        if pixels * f64::from(self.options.slabs.max(1)) * f64::from(self.options.layers) <= most {
            return Ok(Some(wanted));
        }
        let saves = |delta: f64| {
            let views = SIDES.into_par_iter().map(|side| self.view(parts, object, delta, side));
            let samples = views.map(|view| Ok(view?.image.samples.len())).sum::<Result<usize>>()?;
            Ok(samples as f64 <= SIDES.len() as f64 * most)
        };
        if !is_shared {
            // Half the resolution first, which is faster: if that has too many samples, so has the finer one.
            return Ok((saves(2.0 * wanted)? && saves(wanted)?).then_some(wanted));
        }
        let deltas = (0..).map(|step| wanted * 2f64.powf(0.5 * f64::from(step)));
        for delta in deltas.take_while(|delta| *delta <= wanted || is_fine_enough(bounds, *delta)) {
            if saves(delta)? {
                return Ok(Some(delta));
            }
        }
        Ok(None)
    }

    /// Returns how many pixels are across the whole plant in its finest images: half a leaf each.
    fn whole_side(&self, ball: &Ball, leaf: Option<f64>) -> f64 {
        let wanted = leaf.map_or(f64::from(self.options.side), |leaf| 4.0 * ball.radius / leaf);
        wanted.clamp(f64::from(self.options.least_side), f64::from(self.options.most_side))
    }

    /// Makes the views from all directions, with their leaves' sums of light.
    fn copy(
        &self,
        parts: Option<&PlantImages>,
        object: usize,
        delta: f64,
    ) -> Result<(ImageCopy, Vec<[Vec3; 2]>)> {
        let views = (0..self.options.directions.count())
            .into_par_iter()
            .map(|direction| self.view(parts, object, delta, direction));
        let views = views.collect::<Result<Vec<_>>>()?;
        let lengths = views.iter().map(|view| view.length).collect();
        let (views, light) = views.into_iter().map(|view| (view.image, view.light)).unzip();
        let side = side_of(self.plant.objects[object].bounds.ball.radius, delta);
        let correction = LightCorrection { gain: Vec3::ONE, lengths };
        Ok((ImageCopy { delta, side, views, correction }, light))
    }

    /// Makes a view.
    fn view(
        &self,
        parts: Option<&PlantImages>,
        object: usize,
        delta: f64,
        direction: usize,
    ) -> Result<BakedView> {
        let Bounds { ball, space } = self.plant.objects[object].bounds;
        let side = side_of(ball.radius, delta);
        let rotation = self.options.directions.view_from_object(direction);
        let view = image_view(&ball, delta, rotation);
        let rect = view.rect();
        let (count, slabs) = (rect.area() as usize, usize::from(self.options.slabs.max(1)));
        // The middle of the box is that of the ball, and depths are about it.
        let half = rotation.row(2).abs().dot(0.5 * (space.high - space.low)) as f32;
        let canvas = ImageCanvas {
            rect,
            pixels: LayeredPixels::new(slabs * count, self.options.layers),
            slabs: Slabs::new(slabs, half),
            epsilon: (SAME_LAYER * delta) as f32,
            light: [Vec3::ZERO; 2],
        };
        debug_assert_eq!(rect, PixelRect::of_size(side, side));
        let mut drawer = Drawer::new(self.plant, self.meshes, &view, rect, canvas, self.task);
        match parts {
            Some(parts) => self.parts(parts, object, &view, &mut drawer)?,
            None => drawer.visit(object, &view.view_from_plant)?,
        }
        let ImageCanvas { pixels, light, .. } = drawer.canvas;
        let light = if parts.is_some() { pixels.light_of_leaves() } else { light };
        let through = through_over_reflected(light);
        let image = match slabs {
            1 => MBuffer::of(&pixels, count, ball.radius, through),
            _ => MBuffer::of_slabs(&pixels, count, slabs, ball.radius, through),
        };
        Ok(BakedView { image, light, length: pixels.mean_length_of_leaves() })
    }

    /// Draws a sub-object into its own image from images of its parts that are as fine as in final pictures, and as polygons what has none
    /// so fine (Max 1996, section 3).
    fn parts(
        &self,
        made: &PlantImages,
        object: usize,
        view: &View,
        drawer: &mut Drawer<ImageCanvas>,
    ) -> Result<()> {
        for drawn in walk_from(self.plant, object, made, view, &WalkOptions::FINAL, 0) {
            self.task.check_cancelled()?;
            draw_part(drawer, self.plant, made, &drawn, view, SAME_LAYER);
        }
        Ok(())
    }
}

/// Returns whether images of a sub-object whose pixels have this side have [`COARSEST_SIDE`] pixels across; rounding does not count.
fn is_fine_enough(bounds: &Bounds, delta: f64) -> bool {
    2.0 * bounds.ball.radius / delta >= (1.0 - 1e-9) * COARSEST_SIDE
}

/// A view that was made.
struct BakedView {
    image: MBuffer,
    /// The sums of the light that its leaves reflect and let through.
    light: [Vec3; 2],
    /// The mean length of the mean normals of its leaves.
    length: f32,
}

/// Returns what leaves let through over what they reflect. Of what reflects next to nothing there is no share: what it lets through is cut
/// off there.
fn through_over_reflected([reflected, through]: [Vec3; 2]) -> Vec3 {
    through / reflected.max(through / MOST_THROUGH).max(Vec3::splat(f32::MIN_POSITIVE))
}

/// Returns columns and rows of images whose pixels have this side: the ball fits with a pixel to spare on each side.
pub(super) fn side_of(radius: f64, delta: f64) -> u32 {
    2 * (radius / delta).ceil() as u32 + 2
}

/// Returns a view of a sub-object: parallel, about the middle of its ball, turned by a rotation from its frame.
pub(super) fn image_view(ball: &Ball, delta: f64, rotation: DMat3) -> View {
    let side = side_of(ball.radius, delta);
    View {
        projection: Projection::Parallel {
            width: side,
            height: side,
            scale: delta.recip(),
            centre_px: DVec2::splat(0.5 * f64::from(side)),
        },
        view_from_plant: DAffine3::from_mat3_translation(rotation, -(rotation * ball.middle)),
        light_from_view: DMat3::IDENTITY,
    }
}

/// The layered pixels of a view that is being made: those of each slab, nearest first.
struct ImageCanvas {
    rect: PixelRect,
    pixels: LayeredPixels,
    slabs: Slabs,
    epsilon: f32,
    /// The sums of what leaves reflect and let through.
    light: [Vec3; 2],
}

impl LayeredRows for ImageCanvas {
    fn rows(&mut self) -> TargetRows<'_> {
        TargetRows { rect: self.rect, pixels: &mut self.pixels, slabs: self.slabs, beside_polygons: true }
    }
}

impl FragmentCanvas for ImageCanvas {
    #[inline]
    fn visible(&self, fragment: &Fragment) -> u16 {
        fragment.mask
    }

    /// Bark that looks away is left out: with it both sides of a twig would have no normal on average.
    #[inline]
    fn put(&mut self, fragment: &Fragment, visible: u16, facet: &Facet) {
        if facet.is_back {
            return;
        }
        let sample = LayerSample::of_facet(visible, -fragment.middle as f32, facet);
        if sample.is_leaf {
            self.light[0] += sample.weight * sample.reflected;
            self.light[1] += sample.weight * sample.through;
        }
        let epsilon = self.epsilon;
        self.rows().insert((fragment.x, fragment.y), &sample, epsilon);
    }
}
