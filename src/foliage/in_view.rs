//! What is drawn of a plant in a view, ready for a device: images of sub-objects with their maps, and sub-objects as polygons.

use glam::{DAffine3, Mat3, Vec3};

use super::directions::Serving;
use super::flakes::door_of;
use super::images::PlantImages;
use super::lighting::OfSamples;
use super::place::{Instance, Place};
use super::plant::Plant;
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
    /// How many of 16 sub-pixels it draws in, and where they begin.
    pub open: [u32; 2],
    /// A hash of the way to the sub-object: images of one instance have the same.
    pub seed: u32,
}

/// What is drawn of a plant in a view.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct InView {
    /// Images.
    pub images: Vec<ImageInView>,
    /// Sub-objects whose own primitives are drawn as polygons, with the maps from their frames to the view's; ordered by sub-object.
    pub polygons: Vec<(usize, DAffine3)>,
}

/// Returns what is drawn of a plant in a view. `seed` tells one tree from another.
pub fn in_view(plant: &Plant, images: &PlantImages, view: &View, options: &WalkOptions, seed: u64) -> InView {
    let mut found = InView::default();
    for drawn in walk(plant, images, view, options, seed) {
        match drawn.part {
            Part::Polygons => found.polygons.push((drawn.object, drawn.view_from_object)),
            Part::Image(copy) => add_images(&mut found.images, &drawn, copy, (plant, images), view),
        }
    }
    found.polygons.sort_by_key(|(object, _)| *object);
    found
}

/// Adds the images of a sub-object from the directions that serve the viewpoint.
fn add_images(
    to: &mut Vec<ImageInView>,
    drawn: &Drawn,
    copy: usize,
    (plant, images): (&Plant, &PlantImages),
    view: &View,
) {
    let Some(instance) = Instance::of((plant, images), drawn, copy) else { return };
    let (object, path) = (drawn.object, drawn.path);
    let mut before = 0.0;
    for Serving { direction, weight } in instance.serving(&view.projection) {
        let door = door_of(images.directions, (before, weight), path);
        before += weight;
        if door.is_closed() {
            continue;
        }
        let place = Place::new(&instance, &view.projection, direction);
        let Place { linear, origin, .. } = place;
        let OfSamples { view_from_normal, through, gain, length } = instance.of_samples(&place, direction);
        let (open, seed) = (door.opening(), (path >> 32) as u32);
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
            open,
            seed,
        });
    }
}
