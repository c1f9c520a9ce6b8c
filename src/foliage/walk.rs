//! Which parts of a plant are drawn by images, and which as polygons, in a view (Max 1996; 1999).

use glam::DAffine3;

use super::bounds::largest_stretch;
use super::images::PlantImages;
use super::plant::{Plant, Use};
use super::view::{HalfSpace, Projection, View};

/// When a sub-object is drawn by its image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WalkOptions {
    /// An image serves while its pixels are at most this large in the view, in pixels of the view.
    pub threshold: f64,
}

/// What is drawn of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// All of it, by an image: the index of the copy.
    Image(usize),
    /// The primitives of its own, as polygons; what it uses is drawn by itself.
    Polygons,
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
    /// A hash of the way from the root to it.
    pub path: u64,
}

/// Returns what is drawn of a plant in a view, in the order of the plant: every instance in view exactly once, itself or by one of
/// those above it.
pub fn walk(
    plant: &Plant,
    images: &PlantImages,
    view: &View,
    options: &WalkOptions,
    seed: u64,
) -> Vec<Drawn> {
    let half_spaces = view.projection.half_spaces(&view.rect());
    let mut walk =
        Walk { plant, images, projection: &view.projection, half_spaces, options, drawn: Vec::new() };
    walk.visit(plant.root, &view.view_from_plant, mixed(seed));
    walk.drawn
}

struct Walk<'a> {
    plant: &'a Plant,
    images: &'a PlantImages,
    projection: &'a Projection,
    half_spaces: Vec<HalfSpace>,
    options: &'a WalkOptions,
    drawn: Vec<Drawn>,
}

impl Walk<'_> {
    fn visit(&mut self, object: usize, view_from_object: &DAffine3, path: u64) {
        let of = &self.plant.objects[object];
        let ball = of.bounds.ball.mapped(view_from_object);
        if of.counts.triangles == 0 || !self.half_spaces.iter().all(|half_space| half_space.touches(&ball)) {
            return;
        }
        let drawn = |part| Drawn { object, part, view_from_object: *view_from_object, path };
        let nearest = ball.middle.z - ball.radius;
        let magnification =
            pixels_per_unit(self.projection, nearest) * largest_stretch(&view_from_object.matrix3);
        if let Some(copy) = self.serving(object, magnification) {
            self.drawn.push(drawn(Part::Image(copy)));
            return;
        }
        if !of.primitives.is_empty() {
            self.drawn.push(drawn(Part::Polygons));
        }
        for (index, Use { child, parent_from_child }) in of.uses.iter().enumerate() {
            let path = mixed(path ^ (index as u64 + 1));
            self.visit(*child, &(*view_from_object * *parent_from_child), path);
        }
    }

    /// Returns the coarsest copy whose pixels are small enough.
    fn serving(&self, object: usize, magnification: f64) -> Option<usize> {
        let copies = &self.images.objects[object].as_ref()?.copies;
        copies.iter().rposition(|copy| copy.delta * magnification <= self.options.threshold)
    }
}

/// Returns how many pixels a unit at this depth takes at most; infinite at and behind the viewer.
fn pixels_per_unit(projection: &Projection, depth: f64) -> f64 {
    match projection {
        Projection::Parallel { scale, .. } => *scale,
        Projection::Perspective { camera, .. } if depth > 0.0 => camera.fx.max(camera.fy) / depth,
        Projection::Perspective { .. } => f64::INFINITY,
    }
}

/// Returns a number whose bits all depend on all bits of another (Steele, Lea & Flood 2014, the finaliser of *SplitMix*).
pub(super) fn mixed(of: u64) -> u64 {
    let mut bits = of.wrapping_add(0x9E37_79B9_7F4A_7C15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    bits ^ (bits >> 31)
}
