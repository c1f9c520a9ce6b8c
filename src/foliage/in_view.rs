//! What is drawn of a plant in a view, ready for a device: images of sub-objects with their maps, and sub-objects as polygons.

use glam::{DAffine3, Mat3, Vec3};

use super::bounds::Ball;
use super::flakes::stipples_of;
use super::images::PlantImages;
use super::lighting::OfSamples;
use super::place::{ImagePlacement, Instance};
use super::plant::Plant;
use super::stipple::Stipple;
use super::view::View;
use super::walk::{Drawn, Part, WalkOptions, walk};

/// An image of a sub-object that is drawn in a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageInView {
    /// The index of the sub-object.
    pub object: usize,
    /// The index of its copy.
    pub copy: usize,
    /// The index of the direction from which the image is seen.
    pub direction: usize,
    /// The map from the image's frame, with the origin in the middle of the sub-object's ball, to the view's: `linear * p + origin`.
    pub linear: Mat3,
    /// The middle of the ball in the view.
    pub origin: Vec3,
    /// The map of normals, up to a positive factor.
    pub view_from_normal: Mat3,
    /// The share of light that leaves let through over what they reflect.
    pub through: Vec3,
    /// The factor on the light of its samples.
    pub gain: Vec3,
    /// The length of the mean normals of its leaves.
    pub length: f32,
    /// The sub-pixels in which its direction draws.
    pub of_direction: Stipple,
    /// The sub-pixels in which the sub-object is drawn by images of this copy.
    pub of_part: Stipple,
}

/// The polygons that a sub-object has of its own, in a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolygonsInView {
    /// The index of the sub-object.
    pub object: usize,
    /// Its [level of detail](super::plant::SubObject::detail).
    pub level: usize,
    /// The map from its frame to the view's.
    pub view_from_object: DAffine3,
    /// A factor by which the map stretches at most.
    pub stretch: f64,
    /// The sub-pixels in which they are drawn.
    pub stipple: Stipple,
}

impl PolygonsInView {
    /// Returns a ball around them in the view, and around what the sub-object uses.
    pub fn ball(&self, plant: &Plant) -> Ball {
        let Ball { middle, radius } = plant.objects[self.object].bounds.ball;
        Ball { middle: self.view_from_object.transform_point3(middle), radius: self.stretch * radius }
    }
}

/// What is drawn of a plant in a view.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct InView {
    /// Images.
    pub images: Vec<ImageInView>,
    /// Sub-objects whose own primitives are drawn as polygons; ordered by sub-object and level, and of each first those that are drawn in all
    /// sub-pixels.
    pub polygons: Vec<PolygonsInView>,
}

/// Returns what is drawn of a plant in a view. `seed` tells one tree from another.
pub fn in_view(plant: &Plant, images: &PlantImages, view: &View, options: &WalkOptions, seed: u64) -> InView {
    let mut found = InView::default();
    // By sub-object and level: drawn in all sub-pixels, or in part of them.
    let levels = plant.objects.iter().map(|object| vec![[Vec::new(), Vec::new()]; object.detail.count()]);
    let mut polygons: Vec<_> = levels.collect();
    for drawn in walk(plant, images, view, options, seed) {
        let Drawn { object, view_from_object, stretch, stipple, .. } = drawn;
        match drawn.part {
            Part::Polygons(level) => {
                let of = PolygonsInView { object, level, view_from_object, stretch, stipple };
                polygons[object][level][usize::from(!stipple.is_wide())].push(of);
            }
            Part::Image(copy) => add_images(&mut found.images, &drawn, copy, plant, images, view),
        }
    }
    found.polygons = polygons.into_iter().flatten().flatten().flatten().collect();
    found
}

/// Adds the images of a sub-object from the directions that serve the viewpoint.
fn add_images(
    to: &mut Vec<ImageInView>,
    drawn: &Drawn,
    copy: usize,
    plant: &Plant,
    images: &PlantImages,
    view: &View,
) {
    let Some(instance) = Instance::of(plant, images, drawn, copy) else { return };
    let Drawn { object, path, stipple: of_part, .. } = *drawn;
    let serving = instance.serving(&view.projection);
    for (direction, of_direction) in stipples_of(images.directions, &serving, path) {
        let place = ImagePlacement::new(&instance, &view.projection, direction);
        let ImagePlacement { linear, origin, .. } = place;
        let OfSamples { view_from_normal, through, gain, length } = instance.of_samples(&place, direction);
        to.push(ImageInView {
            object,
            copy,
            direction,
            linear,
            origin,
            view_from_normal,
            through,
            gain,
            length,
            of_direction,
            of_part,
        });
    }
}
