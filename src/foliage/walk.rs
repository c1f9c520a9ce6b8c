//! Which parts of a plant are drawn by images, and which as polygons, in a view (Max 1996; 1999).

use glam::DAffine3;

use super::bounds::Ball;
use super::images::PlantImages;
use super::plant::{Plant, Use};
use super::seed::mixed;
use super::stipple::Stipple;
use super::stretch::largest_stretch;
use super::view::{HalfSpace, Projection, View};

/// When a sub-object is drawn by its image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WalkOptions {
    /// An image serves while its pixels are smaller than this in the view, in pixels of the view. From [`DISSOLVE`] of it on, the image
    /// gives way to the parts of the sub-object, or to a finer copy.
    pub threshold: f64,
}

impl WalkOptions {
    /// Previews.
    pub const PREVIEW: Self = Self { threshold: 0.8 };
    /// Final pictures.
    pub const FINAL: Self = Self { threshold: 0.36 };
    /// Moving views of more trees than the device draws in time: parts of samples, of which each has 4 x 4, are as large as two pixels.
    pub const COARSEST: Self = Self { threshold: 8.0 };

    /// Returns the most pixels that a sample of an image reaches on the device, on each side of the pixel of its point: what leans steeply
    /// is not drawn longer.
    pub fn reach_px(&self) -> u32 {
        (0.5 * self.threshold).ceil().max(1.0) as u32
    }

    /// Returns how far the surfaces of polygons with less detail may be from those of full detail, in pixels of the view. In moving views,
    /// where images may be coarser, it is that of previews, so that a change of the level is not seen.
    pub fn deviation_px(&self) -> f64 {
        DEVIATION * self.threshold.min(Self::PREVIEW.threshold)
    }

    /// Returns the size of an image's pixels up to which nothing but the image is drawn of any instance.
    pub fn alone(&self) -> f64 {
        // A little smaller, so that rounding changes nothing.
        (1.0 - 1e-9) * (1.0 - SPREAD) * DISSOLVE * self.threshold
    }
}

/// How far the surfaces of polygons with less detail may be from those of full detail, as a share of the threshold.
const DEVIATION: f64 = 0.2;

/// Where the dissolve of an image into finer parts begins, as a share of the threshold.
pub const DISSOLVE: f64 = 0.85;

/// By how much of the threshold the dissolve of one instance may lie below that of another, so that no ring of changes runs through a wood.
const SPREAD: f64 = 0.1;

/// What is drawn of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// All of it, by an image: the index of the copy.
    Image(usize),
    /// The primitives of its own, as polygons at this [level of detail](super::plant::SubObject::detail); what it uses is drawn by itself.
    Polygons(usize),
}

/// An instance that is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drawn {
    /// The index of the sub-object.
    pub object: usize,
    /// What is drawn.
    pub part: Part,
    /// The map from its frame to the view's.
    pub view_from_object: DAffine3,
    /// A factor by which the map stretches at most.
    pub stretch: f64,
    /// A hash of the way from the root to it.
    pub path: u64,
    /// The sub-pixels in which it is drawn. What is drawn of an instance, by itself and by those that it uses, shares all sub-pixels.
    pub stipple: Stipple,
}

/// Returns what is drawn of a plant in a view, in the order of the plant: every sub-pixel of every instance in view exactly once, by itself or
/// by one of those above it.
///
/// Between an image and what is finer there is no jump, because both are drawn in a share of the sub-pixels each that depends on how large the
/// image's pixels are in the view, and on nothing else (a dissolve; proposed by Max 1996 as future work).
pub fn walk(
    plant: &Plant,
    images: &PlantImages,
    view: &View,
    options: &WalkOptions,
    seed: u64,
) -> Vec<Drawn> {
    walk_from(plant, plant.root, images, view, options, seed)
}

/// Returns what is drawn of a sub-object of a plant as [`walk`] does of the whole. The view is of the sub-object's frame.
pub(super) fn walk_from(
    plant: &Plant,
    object: usize,
    images: &PlantImages,
    view: &View,
    options: &WalkOptions,
    seed: u64,
) -> Vec<Drawn> {
    let half_spaces = view.projection.half_spaces(&view.rect());
    let stretches = vec![Vec::new(); plant.objects.len()];
    let mut walk = Walk {
        plant,
        images,
        stretches,
        projection: &view.projection,
        half_spaces,
        options,
        drawn: Vec::new(),
    };
    let path = mixed(seed);
    let root = Visited {
        object,
        view_from_object: view.view_from_plant,
        stretch: largest_stretch(&view.view_from_plant.matrix3),
        path,
        // Another order than that of the directions of the root's image.
        stipple: Stipple::wide(mixed(!path)),
        crossed: (1 << walk.half_spaces.len()) - 1,
    };
    walk.visit(&root);
    walk.drawn
}

struct Walk<'a> {
    plant: &'a Plant,
    images: &'a PlantImages,
    /// How much each use of each sub-object stretches at most; found when the first of its instances is not drawn as a whole.
    stretches: Vec<Vec<f64>>,
    projection: &'a Projection,
    half_spaces: Vec<HalfSpace>,
    options: &'a WalkOptions,
    drawn: Vec<Drawn>,
}

/// An instance on the way.
struct Visited {
    object: usize,
    view_from_object: DAffine3,
    /// A factor by which the map stretches at most: the product of those of all uses on the way, so exact unless two of them stretch
    /// some directions more than others.
    stretch: f64,
    path: u64,
    stipple: Stipple,
    /// The half-spaces that do not hold all of an instance above it: one bit each.
    crossed: u32,
}

impl Walk<'_> {
    fn visit(&mut self, at: &Visited) {
        let Visited { object, path, .. } = *at;
        let plant = self.plant;
        let of = &plant.objects[object];
        let ball = Ball {
            middle: at.view_from_object.transform_point3(of.bounds.ball.middle),
            radius: at.stretch * of.bounds.ball.radius,
        };
        let Some(crossed) = self.crossed(&ball, at.crossed).filter(|_| of.counts.triangles > 0) else {
            return;
        };
        let nearest = ball.middle.z - ball.radius;
        let magnification = pixels_per_unit(self.projection, nearest) * at.stretch;
        let stipple = self.images_of(at, magnification);
        if stipple.is_closed() {
            return;
        }
        if !of.primitives.is_empty() {
            let level = of.detail.level(self.options.deviation_px() / magnification);
            self.drawn.push(at.drawn(Part::Polygons(level), stipple));
        }
        if self.stretches[object].len() < of.uses.len() {
            let stretch = |of: &Use| largest_stretch(&of.parent_from_child.matrix3);
            self.stretches[object] = of.uses.iter().map(stretch).collect();
        }
        for (index, Use { child, parent_from_child }) in of.uses.iter().enumerate() {
            self.visit(&Visited {
                object: *child,
                view_from_object: at.view_from_object * *parent_from_child,
                stretch: at.stretch * self.stretches[object][index],
                path: mixed(path ^ (index as u64 + 1)),
                stipple,
                crossed,
            });
        }
    }

    /// Returns those of the half-spaces that do not hold all of a ball; `None` where one of them holds nothing of it.
    fn crossed(&self, ball: &Ball, of: u32) -> Option<u32> {
        let mut left = of;
        for (index, half_space) in self.half_spaces.iter().enumerate() {
            let bit = 1 << index;
            if of & bit == 0 {
                continue;
            }
            if !half_space.touches(ball) {
                return None;
            }
            if half_space.holds(ball) {
                left &= !bit;
            }
        }
        Some(left)
    }

    /// Draws an instance by its images, the coarsest that serves first, and returns the sub-pixels that are left to its parts.
    fn images_of(&mut self, at: &Visited, magnification: f64) -> Stipple {
        let mut left = at.stipple;
        let Some(images) = &self.images.objects[at.object] else { return left };
        let lowered = SPREAD * (at.path >> 40) as f64 / (1u64 << 24) as f64;
        let threshold = self.options.threshold * (1.0 - lowered);
        for (copy, of_copy) in images.copies.iter().enumerate().rev() {
            let [first, rest] = left.divided(served(of_copy.delta * magnification / threshold));
            if !first.is_closed() {
                self.drawn.push(at.drawn(Part::Image(copy), first));
            }
            left = rest;
            if left.is_closed() {
                break;
            }
        }
        left
    }
}

impl Visited {
    fn drawn(&self, part: Part, stipple: Stipple) -> Drawn {
        let Self { object, view_from_object, stretch, path, .. } = *self;
        Drawn { object, part, view_from_object, stretch, path, stipple }
    }
}

/// Returns the share of the sub-pixels in which an image is drawn whose pixels have this size in a view, as a share of the threshold.
fn served(size: f64) -> f64 {
    let past = ((size - DISSOLVE) / (1.0 - DISSOLVE)).clamp(0.0, 1.0);
    // Without a size, as behind the viewer, no image serves.
    if past.is_nan() { 0.0 } else { 1.0 - past * past * (3.0 - 2.0 * past) }
}

/// Returns how many pixels a unit at this depth takes at most; infinite at and behind the viewer.
fn pixels_per_unit(projection: &Projection, depth: f64) -> f64 {
    match projection {
        Projection::Parallel { scale, .. } => *scale,
        Projection::Perspective { camera, .. } if depth > 0.0 => camera.fx.max(camera.fy) / depth,
        Projection::Perspective { .. } => f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_reach_half_of_their_size_and_the_next_pixels_at_least() {
        let reach = |threshold: f64| WalkOptions { threshold }.reach_px();
        assert_eq!([0.36, 0.8, 2.0, 2.1, 4.0, 8.0].map(reach), [1, 1, 1, 2, 2, 4]);
    }
}
