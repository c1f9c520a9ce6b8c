//! What keeps light from the points of a plant: shadows, and its own crown.

use glam::{DAffine3, DMat3, DVec3};

use super::openness::Openness;
use super::raster::Fragment;
use super::shade::Reach;
use super::shadow::Shadow;
use super::view::{Projection, View, normal_map};

/// Shadow and openness of a plant that is drawn.
#[derive(Debug, Clone, Copy)]
pub struct Shades<'a> {
    /// The shadow that falls on it.
    pub shadow: &'a Shadow,
    /// The map from the plant's frame to the shadow's.
    pub frame_from_plant: DAffine3,
    /// The openness of the plant.
    pub openness: &'a Openness,
}

/// [`Shades`] at the points of a view.
#[derive(Debug, Clone, Copy)]
pub(super) struct ViewShades<'a> {
    shadow: &'a Shadow,
    openness: &'a Openness,
    projection: Projection,
    sun_from_view: DAffine3,
    plant_from_view: DAffine3,
    /// The map of normals from the view's frame to the plant's, up to a positive factor.
    plant_from_normal: DMat3,
}

impl<'a> ViewShades<'a> {
    pub fn new(shades: &Shades<'a>, view: &View) -> Self {
        let plant_from_view = view.view_from_plant.inverse();
        let Shades { shadow, frame_from_plant, openness } = shades;
        Self {
            shadow,
            openness,
            projection: view.projection,
            sun_from_view: shadow.sun_from_frame() * *frame_from_plant * plant_from_view,
            plant_from_view,
            plant_from_normal: normal_map(&plant_from_view.matrix3),
        }
    }

    /// Returns what reaches a fragment in the middle of its sub-pixels in `mask`; its normal has length 1 in the view's frame, and
    /// `facing` is the cosine of its angle to the direction to the sun.
    pub fn reach(&self, (fragment, mask): (&Fragment, u16), normal: DVec3, facing: f64) -> Reach {
        let (px, nearness) = fragment.middle_of(mask);
        let point = self.projection.view_from_image(px, nearness);
        let in_plant = self.plant_from_view.transform_point3(point);
        let normal = (self.plant_from_normal * normal).normalize_or_zero();
        Reach {
            sun: self.shadow.lit(self.sun_from_view.transform_point3(point), facing),
            front: self.openness.at(in_plant, normal),
            back: self.openness.at(in_plant, -normal),
        }
    }
}
