//! What keeps light from the points of a plant: shadows, and its own crown.

use glam::{DAffine3, DMat3, DVec3};

use super::openness::Openness;
use super::raster::Fragment;
use super::shade::LightReach;
use super::shadow::Shadow;
use super::sunlit::Sunlit;
use super::view::{Projection, View, normal_map};

/// What keeps light from a plant that is drawn.
#[derive(Debug, Clone, Copy)]
pub struct Shades<'a> {
    /// What keeps the sun's light.
    pub sun: SunShade<'a>,
    /// The openness of the plant.
    pub openness: &'a Openness,
}

/// What keeps the sun's light from a plant.
#[derive(Debug, Clone, Copy)]
pub enum SunShade<'a> {
    /// A shadow that falls on it, to the leaf.
    Shadow {
        /// The shadow.
        shadow: &'a Shadow,
        /// The map from the plant's frame to the shadow's.
        frame_from_plant: DAffine3,
    },
    /// Its own crown, as far as its openness knows.
    Crown {
        /// The direction to the sun in the frame of the light.
        towards_sun: DVec3,
        /// What of it reaches the crown; `None` for all.
        sunlit: Option<&'a Sunlit>,
    },
}

/// [`Shades`] at the points of a view.
#[derive(Debug, Clone, Copy)]
pub(super) struct ViewShades<'a> {
    sun: ViewSun<'a>,
    openness: &'a Openness,
    projection: Projection,
    plant_from_view: DAffine3,
    /// The map of normals from the view's frame to the plant's, up to a positive factor.
    plant_from_normal: DMat3,
}

/// [`SunShade`] at the points of a view.
#[derive(Debug, Clone, Copy)]
enum ViewSun<'a> {
    Shadow {
        shadow: &'a Shadow,
        sun_from_view: DAffine3,
    },
    /// The direction is in the plant's frame.
    Crown {
        towards_sun: DVec3,
        sunlit: Option<&'a Sunlit>,
    },
}

impl<'a> ViewShades<'a> {
    pub fn new(shades: &Shades<'a>, view: &View) -> Self {
        let plant_from_view = view.view_from_plant.inverse();
        let sun = match shades.sun {
            SunShade::Shadow { shadow, frame_from_plant } => {
                let sun_from_view = shadow.sun_from_frame() * frame_from_plant * plant_from_view;
                ViewSun::Shadow { shadow, sun_from_view }
            }
            SunShade::Crown { towards_sun, sunlit } => {
                let in_view = view.light_from_view.transpose() * towards_sun;
                ViewSun::Crown { towards_sun: plant_from_view.transform_vector3(in_view), sunlit }
            }
        };
        Self {
            sun,
            openness: shades.openness,
            projection: view.projection,
            plant_from_view,
            plant_from_normal: normal_map(&plant_from_view.matrix3),
        }
    }

    /// Returns what reaches a fragment in the middle of its sub-pixels in `mask`; its normal has length 1 in the view's frame, and
    /// `facing` is the cosine of its angle to the direction to the sun.
    pub fn reach(&self, fragment: &Fragment, mask: u16, normal: DVec3, facing: f64) -> LightReach {
        let (px, nearness) = fragment.middle_of(mask);
        let point = self.projection.view_from_image(px, nearness);
        let in_plant = self.plant_from_view.transform_point3(point);
        let normal = (self.plant_from_normal * normal).normalize_or_zero();
        LightReach {
            sun: match self.sun {
                ViewSun::Shadow { shadow, sun_from_view } => {
                    shadow.lit(sun_from_view.transform_point3(point), facing)
                }
                ViewSun::Crown { towards_sun, sunlit } => {
                    let reaches = sunlit.map_or(1.0, |sunlit| sunlit.at(in_plant));
                    reaches * self.openness.towards(in_plant, towards_sun)
                }
            },
            front: self.openness.at(in_plant, normal),
            back: self.openness.at(in_plant, -normal),
        }
    }
}
