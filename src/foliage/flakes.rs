//! Pictures of plants whose images are drawn texel by texel (Max, Deussen & Keating 1999): as *flakes*, small pieces of surface at their
//! own depths, or, as published, on planes of depth. The nearest one is kept at each sub-pixel, and what is seen is lit in the end.

use glam::{Mat3, Vec2, Vec3};

use super::brute::check;
use super::directions::{Directions, Serving};
use super::door::Door;
use super::drawer::{Canvas, Drawer, Facet};
use super::flake::{Flake, FlakeBuffer, key};
use super::images::{MBuffer, MSample, PlantImages, depth_from_stored};
use super::listed::{BandPicture, ImageCost, in_bands, meshes_of, rgba_of_light};
use super::mesh::Mesh;
use super::place::{Instance, Place};
use super::plant::Plant;
use super::raster::Fragment;
use super::shade::{Light, Reach, Surface, shade};
use super::view::View;
use super::walk::{Drawn, Part, WalkOptions, walk};
use crate::error::{Error, Result};
use crate::geometry::PixelRect;
use crate::projection::Picture;
use crate::task::Task;

/// The number of rows that are drawn together. It changes no pixel: bands only share work among threads.
const BAND: u32 = 64;

/// An axis whose squared cosine to the viewer is 1/8 or more, 69 degrees, draws in all sub-pixels, and below in a share that falls to none.
/// What an axis sees from the side is told by others, too, and drawn from all it covers too much and is too bright: the mean normal of
/// several leaves leans towards the axis (docs/quality.md).
const OPEN: f64 = 8.0;

/// How texels are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Texels {
    /// Each as a piece of surface that leans as its normal tells.
    Flakes,
}

/// How plants are drawn texel by texel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlakeOptions {
    /// When images serve.
    pub walk: WalkOptions,
    /// How texels are drawn.
    pub texels: Texels,
}

impl FlakeOptions {
    /// Previews: images serve while their pixels are at most 0.7 pixels large.
    pub const PREVIEW: Self = Self { walk: WalkOptions { threshold: 0.7 }, texels: Texels::Flakes };
    /// Final pictures.
    pub const FINAL: Self = Self { walk: WalkOptions { threshold: 0.35 }, texels: Texels::Flakes };
}

/// Draws a plant from its images, texel by texel.
///
/// # Errors
/// Those of [`super::draw`].
pub fn draw_flakes(
    (plant, images): (&Plant, &PlantImages),
    view: &View,
    light: &Light,
    options: &FlakeOptions,
    task: &Task,
) -> Result<(Picture, ImageCost)> {
    check(plant, view)?;
    let drawn = walk(plant, images, view, &options.walk, 0);
    let meshes = meshes_of(plant, &drawn);
    let scene = Scene { plant, images, meshes: &meshes, drawn: &drawn, view, light, options };
    in_bands((view.rect(), BAND), &drawn, &|rect| scene.band(rect, task), task)
}

/// What all bands of a picture share.
struct Scene<'a> {
    plant: &'a Plant,
    images: &'a PlantImages,
    meshes: &'a [Vec<Mesh>],
    drawn: &'a [Drawn],
    view: &'a View,
    light: &'a Light,
    options: &'a FlakeOptions,
}

impl<'a> Scene<'a> {
    /// Draws a band of rows.
    fn band(&self, rect: PixelRect, task: &Task) -> Result<BandPicture> {
        let Self { plant, images, view, .. } = self;
        let half_spaces = view.projection.half_spaces(&rect);
        let canvas = FlakeCanvas { buffer: FlakeBuffer::new(rect), drawn: List::default() };
        let mut drawer = Drawer::new((plant, self.meshes), view, (rect, canvas), task);
        let mut cost = ImageCost::default();
        for Drawn { object, part, view_from_object, path } in self.drawn {
            let ball = plant.objects[*object].bounds.ball;
            let in_view = ball.mapped(view_from_object);
            if !half_spaces.iter().all(|half_space| half_space.touches(&in_view)) {
                continue;
            }
            task.go_on()?;
            match (part, &images.objects.get(*object).and_then(Option::as_ref)) {
                (Part::Image(copy), Some(of)) => {
                    let instance = Instance {
                        directions: images.directions,
                        copy: &of.copies[*copy],
                        ball,
                        through: of.through,
                        view_from_object: *view_from_object,
                        path: *path,
                    };
                    cost.samples += self.image(&instance, &mut drawer.canvas)?;
                }
                _ => drawer.own(*object, view_from_object),
            }
        }
        cost.triangles = drawer.triangles;
        Ok((self.resolve(&drawer.canvas), cost))
    }

    /// Draws the images of an instance that serve; returns the number of samples.
    fn image(&self, instance: &Instance<'a>, canvas: &mut FlakeCanvas<'a>) -> Result<u64> {
        let projection = &self.view.projection;
        let (mut before, mut drawn) = (0.0, 0);
        for Serving { direction, weight } in instance.serving(projection) {
            let door = match instance.directions {
                Directions::Around => Door::between(before, before + weight, instance.path),
                Directions::Axes => Door::open(OPEN * weight, instance.path),
            };
            before += weight;
            if door.is_closed() {
                continue;
            }
            let place = Place::new(instance, projection, direction);
            let image = &instance.copy.views[direction];
            let index = canvas.drawn.begin_image(image, (place.view_from_normal, instance.through))?;
            let drawing = Drawing::new((instance, &place), canvas.buffer.rect);
            drawn +=
                drawing.draw((image, index), Some(&door).filter(|door| !door.is_wide()), &mut canvas.buffer);
        }
        Ok(drawn)
    }

    /// Returns R, G, B, A of the pixels: the mean light of the covered sub-pixels, and their share.
    fn resolve(&self, canvas: &FlakeCanvas) -> Vec<u8> {
        let FlakeCanvas { buffer, drawn } = canvas;
        let mut lighting = Lighting { drawn, view: self.view, light: self.light, last: 0 };
        buffer.rect.pixels().flat_map(|(x, y)| lighting.pixel((x, y), &buffer.pixel(x, y))).collect()
    }
}

/// An image of an instance that is drawn in a band.
struct Drawing<'a> {
    place: &'a Place,
    /// The same as in the place, in sub-pixels from the band's corner.
    focal: Vec2,
    centre: Vec2,
    /// The steps to the right, down and away by a side of a texel.
    steps: Mat3,
    /// How far from its middle a texel reaches at most, in sub-pixels.
    reach: f32,
    /// The middle of the first texel, at the depth that is stored as 0.
    origin: Vec3,
    depth_step: Vec3,
    side: usize,
    delta: f32,
    radius: f32,
    rect: PixelRect,
}

impl<'a> Drawing<'a> {
    fn new((instance, place): (&Instance, &'a Place), rect: PixelRect) -> Self {
        let [step, first_depth] = depth_from_stored(instance.ball.radius).map(|value| value as f32);
        let (delta, radius) = (instance.copy.delta as f32, instance.ball.radius as f32);
        let (linear, half) = (place.linear, 0.5 * instance.copy.side as f32);
        let first = Vec3::new((0.5 - half) * delta, (0.5 - half) * delta, first_depth);
        let corner = Vec2::new(rect.x as f32, rect.y as f32);
        let focal = 4.0 * place.focal;
        let stretch = [linear.x_axis, linear.y_axis, linear.z_axis].map(Vec3::length).iter().sum::<f32>();
        let nearest = place.origin.z - stretch * radius;
        let per_unit = match place.perspective {
            true if nearest > 0.0 => focal.max_element() / nearest,
            true => f32::INFINITY,
            false => focal.max_element(),
        };
        Self {
            place,
            focal,
            centre: 4.0 * (place.centre_px - corner),
            steps: linear * delta,
            // Half a texel across and down, each leaning by 3 at most, perspective included.
            reach: 8.0 * per_unit * delta * stretch,
            origin: linear * first + place.origin,
            depth_step: linear.z_axis * step,
            side: instance.copy.side as usize,
            delta,
            radius,
            rect,
        }
    }

    /// Draws the samples of an image, the first of which has the index `first`; returns how many.
    fn draw(&self, (image, first): (&MBuffer, u32), door: Option<&Door>, buffer: &mut FlakeBuffer) -> u64 {
        let half = 0.5 * self.side as f32;
        let (mut next, mut drawn) = (0, 0);
        for (row, counts) in image.counts.chunks_exact(self.side).enumerate() {
            let samples: usize = counts.iter().map(|count| usize::from(*count)).sum();
            let y = (row as f32 + 0.5 - half) * self.delta;
            if samples == 0 || !self.place.row_meets(y, self.radius, (self.delta, &self.rect)) {
                next += samples;
                continue;
            }
            drawn += samples as u64;
            let row_origin = self.origin + row as f32 * self.steps.y_axis;
            for (column, &count) in counts.iter().enumerate() {
                if count == 0 {
                    continue;
                }
                let base = row_origin + column as f32 * self.steps.x_axis;
                for sample in &image.samples[next..next + usize::from(count)] {
                    let at = base + self.depth_step * f32::from(sample.depth);
                    self.flake((at, sample, first + next as u32), door, buffer);
                    next += 1;
                }
            }
        }
        drawn
    }

    /// Draws a sample at a point of the view's frame.
    #[inline(always)]
    fn flake(
        &self,
        (at, sample, index): (Vec3, &MSample, u32),
        door: Option<&Door>,
        buffer: &mut FlakeBuffer,
    ) {
        let place = self.place;
        let (mut scale, mut shrink, mut nearness) = (self.focal, 0.0, -at.z);
        if place.perspective {
            nearness = at.z.recip();
            (scale, shrink) = (self.focal * nearness, nearness);
        }
        let from_centre = scale * at.truncate();
        let px = from_centre + self.centre;
        let size = buffer.size();
        // Comparisons that also fail for what is no number.
        let is_near = px.x > -self.reach
            && px.y > -self.reach
            && px.x < size[0] as f32 + self.reach
            && px.y < size[1] as f32 + self.reach
            && (nearness > 0.0 || !place.perspective);
        if !is_near {
            return;
        }
        if !sample.normal.is_leaf() {
            let normal = place.view_from_normal * sample.normal.normal();
            let looks_away = if place.perspective { normal.dot(at) > 0.0 } else { normal.z > 0.0 };
            if looks_away {
                return;
            }
        }
        let slope = sample.normal.slope();
        let change = |step: Vec3| scale * step.truncate() - from_centre * (step.z * shrink);
        let along = change(self.steps.z_axis);
        let across = change(self.steps.x_axis) + slope.x * along;
        let down = change(self.steps.y_axis) + slope.y * along;
        // The depth is that of the middle of the covered parts: the texel's own middle lies elsewhere on the surface.
        let middle = match sample.mask {
            u16::MAX => px,
            mask => px - slope.dot(middle_of(mask)) * along,
        };
        let key = key(nearness, index);
        let flake = Flake { middle, across, down, mask: sample.mask };
        match door {
            None => flake.cover(size, |x, y| buffer.put(x, y, key)),
            Some(door) => {
                let rect = self.rect;
                flake.cover(size, |x, y| {
                    let open = door.open_at(rect.x + x / 4, rect.y + y / 4);
                    if open >> (4 * (y & 3) + (x & 3)) & 1 != 0 {
                        buffer.put(x, y, key);
                    }
                });
            }
        }
    }
}

/// What was drawn in a band: each index belongs to a sample of an image or to a fragment of a polygon.
#[derive(Default)]
struct List<'a> {
    /// The first index of each, in order.
    firsts: Vec<u32>,
    parts: Vec<Listed<'a>>,
    /// The fragments of all polygons.
    facets: Vec<Facet>,
    /// The first index that is free.
    next: u32,
}

/// What some indices in a row belong to.
#[derive(Clone, Copy)]
enum Listed<'a> {
    /// The samples of an image, the map of their normals into the view, and what leaves let through over what they reflect.
    Image(&'a MBuffer, Mat3, Vec3),
    /// Fragments: the first one's index among all.
    Facets(usize),
}

impl<'a> List<'a> {
    /// Adds the samples of an image; returns the index of the first.
    ///
    /// # Errors
    /// [`Error::Request`] where indices run out.
    fn begin_image(&mut self, image: &'a MBuffer, (view_from_normal, through): (Mat3, Vec3)) -> Result<u32> {
        let first = self.next;
        let count = u32::try_from(image.samples.len()).ok();
        let Some(next) = count.and_then(|count| first.checked_add(count)) else {
            return Err(Error::Request(format!(
                "more than {} samples of images are in {BAND} rows of the picture; give a larger tau, or a smaller picture",
                u32::MAX
            )));
        };
        self.firsts.push(first);
        self.parts.push(Listed::Image(image, view_from_normal, through));
        self.next = next;
        Ok(first)
    }

    /// Adds a fragment; returns its index.
    fn add_facet(&mut self, facet: &Facet) -> u32 {
        let index = self.next;
        if !matches!(self.parts.last(), Some(Listed::Facets(_))) {
            self.firsts.push(index);
            self.parts.push(Listed::Facets(self.facets.len()));
        }
        self.facets.push(*facet);
        self.next = self.next.saturating_add(1);
        index
    }
}

/// Draws polygons beside flakes.
struct FlakeCanvas<'a> {
    buffer: FlakeBuffer,
    drawn: List<'a>,
}

impl Canvas for FlakeCanvas<'_> {
    #[inline]
    fn visible(&self, fragment: &Fragment) -> u16 {
        self.buffer.visible(fragment)
    }

    #[inline]
    fn put(&mut self, fragment: &Fragment, visible: u16, facet: &Facet) {
        let index = self.drawn.add_facet(facet);
        self.buffer.put_fragment(fragment, visible, index);
    }
}

/// Lights what is seen.
struct Lighting<'a> {
    drawn: &'a List<'a>,
    view: &'a View,
    light: &'a Light,
    /// Where the last index was found.
    last: usize,
}

impl Lighting<'_> {
    /// Returns R, G, B, A of a pixel.
    fn pixel(&mut self, at: (i32, i32), indices: &[Option<u32>; 16]) -> [u8; 4] {
        let (mut distinct, mut count) = ([(0u32, 0u32); 16], 0);
        for index in indices.iter().flatten() {
            match distinct[..count].iter_mut().find(|(other, _)| other == index) {
                Some((_, times)) => *times += 1,
                None => {
                    distinct[count] = (*index, 1);
                    count += 1;
                }
            }
        }
        let (mut sum, mut covered) = (Vec3::ZERO, 0);
        for (index, times) in &distinct[..count] {
            sum += *times as f32 * self.light_of(*index, at);
            covered += times;
        }
        rgba_of_light(sum, covered)
    }

    /// Returns the light that comes from what has an index, at a pixel.
    fn light_of(&mut self, index: u32, (x, y): (i32, i32)) -> Vec3 {
        let List { firsts, parts, facets, .. } = self.drawn;
        let is_last =
            firsts[self.last] <= index && firsts.get(self.last + 1).is_none_or(|next| index < *next);
        if !is_last {
            self.last = firsts.partition_point(|first| *first <= index) - 1;
        }
        let offset = (index - firsts[self.last]) as usize;
        let surface = match parts[self.last] {
            Listed::Facets(first) => {
                let Facet { normal, reflected, through, .. } = facets[first + offset];
                Surface { normal: self.view.light_from_view * normal, reflected, through }
            }
            Listed::Image(image, view_from_normal, through) => {
                let sample = &image.samples[offset];
                let reflected = sample.reflected();
                let normal = (view_from_normal * sample.normal.normal()).as_dvec3();
                let point = glam::DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let towards = self.view.projection.view_from_image(point, 1.0);
                let towards = self.view.projection.towards_viewer(towards);
                let normal = if normal.dot(towards) < 0.0 { -normal } else { normal };
                Surface {
                    normal: (self.view.light_from_view * normal).normalize_or_zero(),
                    reflected,
                    through: sample.normal.is_leaf().then_some(reflected * through),
                }
            }
        };
        shade(&surface, self.light, &Reach::ALL)
    }
}

/// Returns the middle of the covered parts of a texel from its own, in sides of a texel.
#[inline]
fn middle_of(mask: u16) -> Vec2 {
    let count = |of: u16| (mask & of).count_ones() as f32;
    let x = 3.0 * (count(0x8888) - count(0x1111)) + count(0x4444) - count(0x2222);
    let y = 3.0 * (count(0xF000) - count(0x000F)) + count(0x0F00) - count(0x00F0);
    Vec2::new(x, y) / (8.0 * mask.count_ones() as f32)
}
