//! The light on trees on the device (`shaders/daylight.wgsl`).

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use crate::foliage::Light;
use crate::projection::Shot;

/// The WGSL source that is put before passes that light trees.
pub const SOURCE: &str = include_str!("../../../../shaders/daylight.wgsl");

/// The light in the layout of the shader (`Daylight`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct DaylightWords {
    pub towards_sun: [f32; 3],
    pub pad0: f32,
    pub up: [f32; 3],
    pub pad1: f32,
    pub sun: [f32; 3],
    pub pad2: f32,
    pub sky: [f32; 3],
    pub pad3: f32,
    pub ground: [f32; 3],
    pub pad4: f32,
}

impl DaylightWords {
    /// Returns the light in the camera's frame of a view.
    pub fn new(light: &Light, shot: &Shot) -> Self {
        let in_camera = |direction: DVec3| (shot.pose.rotation * direction).as_vec3().to_array();
        let Light { towards_sun, up, sun, sky, ground } = light;
        Self {
            towards_sun: in_camera(*towards_sun),
            up: in_camera(*up),
            sun: sun.to_array(),
            sky: sky.to_array(),
            ground: ground.to_array(),
            ..Self::zeroed()
        }
    }
}
