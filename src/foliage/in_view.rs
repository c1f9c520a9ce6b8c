//! What is drawn of a plant in a view, ready for a device: images of sub-objects with their maps, and sub-objects as polygons.

use glam::{DAffine3, DMat3, Vec3};

use super::directions::{Serving, serving, view_from_object};
use super::door::Door;
use super::images::PlantImages;
use super::plant::Plant;
use super::reproject::towards_viewer;
use super::view::{View, normal_map};
use super::walk::{Drawn, Part, WalkOptions, walk};

/// An image of a sub-object that is drawn in a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageInView {
    /// The index of the sub-object.
    pub object: usize,
    /// The index of its copy.
    pub copy: usize,
    /// The direction from which the image is seen.
    pub direction: usize,
    /// The map from the image's frame, with the origin in the middle of the sub-object's ball, to the view's.
    pub view_from_image: DAffine3,
    /// The map of normals, up to a positive factor.
    pub view_from_normal: DMat3,
    /// The share of light that leaves let through over what they reflect.
    pub through: Vec3,
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

/// Adds the images of a sub-object from the directions around the viewpoint.
fn add_images(
    to: &mut Vec<ImageInView>,
    &Drawn { object, view_from_object: in_view, path, .. }: &Drawn,
    copy: usize,
    (plant, images): (&Plant, &PlantImages),
    view: &View,
) {
    let ball = plant.objects[object].bounds.ball;
    let through = images.objects[object].as_ref().map_or(Vec3::ZERO, |of| of.through);
    let origin = in_view.transform_point3(ball.middle);
    let mut before = 0.0;
    for Serving { direction, weight } in serving(towards_viewer(&in_view, &ball, &view.projection)) {
        let linear = in_view.matrix3 * view_from_object(direction).transpose();
        let door = Door::between(before, before + weight, path);
        before += weight;
        to.push(ImageInView {
            object,
            copy,
            direction,
            view_from_image: DAffine3::from_mat3_translation(linear, origin),
            view_from_normal: of_size_one(&normal_map(&linear)),
            through,
            open: door.opening(),
            seed: (path >> 32) as u32,
        });
    }
}

/// Returns a map whose largest number is 1, so that it does not leave the numbers that f32 has.
pub(super) fn of_size_one(map: &DMat3) -> DMat3 {
    let largest = map.to_cols_array().iter().fold(0.0f64, |most, value| most.max(value.abs()));
    *map * (1.0 / largest.max(f64::MIN_POSITIVE))
}
