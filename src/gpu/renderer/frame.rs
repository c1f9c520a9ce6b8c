//! The uniform of a view (`Frame` of `shaders/surfaces.wgsl`).

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::surfaces::split;
use quadratura_projection::Sources;
use quadratura_projection::cells::Cells;
use quadratura_view::optics::ViewLens;
use quadratura_view::{Shot, Unseen};

/// The share of the nearest depth within which faces count as one surface, as in the visibility sort.
const TOLERANCE: f32 = 1e-4;

/// The uniform in the layout of the shaders (`Frame`), which document the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct CameraUniform {
    pub right: [f32; 3],
    pub focal_x: f32,
    pub down: [f32; 3],
    pub focal_y: f32,
    pub forward: [f32; 3],
    pub near: f32,
    pub center: [f32; 2],
    pub size: [f32; 2],
    pub eye_high: [f32; 3],
    pub density: f32,
    pub eye_low: [f32; 3],
    pub lambda: f32,
    pub cell_px: u32,
    pub reach: f32,
    pub relief: f32,
    pub backs: u32,
    pub transient_angle: f32,
    pub widest: f32,
    pub falloff: [f32; 2],
    pub surroundings_first: u32,
    pub surroundings_columns: u32,
    pub per_surroundings_scale: f32,
    pub dome_first: u32,
    pub light_first: u32,
    pub light_groups: u32,
    pub pad0: [u32; 2],
    pub of_common: [f32; 3],
    pub continues: u32,
    pub of_sky: [f32; 3],
    pub surroundings_reach: f32,
}

impl CameraUniform {
    /// Builds the uniform of a view. `origin` is the world point that positions are relative to.
    pub fn new(shot: &Shot, lens: &ViewLens, origin: DVec3, cells: &Cells, sources: &Sources) -> Self {
        let scale = sources.surroundings_scale;
        let (near, cell_px, surroundings) = (cells.near(), cells.side_px, cells.surroundings);
        let [right, down, forward] = shot.pose.rotation_rows().map(|row| row.map(|v| v as f32));
        let (eye_high, eye_low) = split(shot.viewpoint() - origin);
        let camera = &shot.camera;
        Self {
            right,
            focal_x: camera.fx as f32,
            down,
            focal_y: camera.fy as f32,
            forward,
            near: near as f32,
            center: [camera.cx as f32, camera.cy as f32],
            size: [camera.width as f32, camera.height as f32],
            eye_high,
            density: (camera.fx * camera.fy) as f32,
            eye_low,
            lambda: shot.blend.lambda as f32,
            cell_px,
            reach: 1.0 + TOLERANCE,
            relief: f32::from(u8::from(shot.relief)),
            backs: u32::from(shot.backs),
            transient_angle: shot.blend.transient_angle() as f32,
            widest: lens.widest as f32,
            falloff: lens.falloff.map(|coefficient| coefficient as f32),
            surroundings_first: surroundings.map_or(0, |cells| cells.first),
            surroundings_columns: surroundings.map_or(0, |cells| cells.columns),
            per_surroundings_scale: (1.0 / scale.max(f64::from(f32::MIN_POSITIVE))) as f32,
            dome_first: sources.photos.len() as u32,
            light_first: 0,
            light_groups: 0,
            pad0: [0; 2],
            of_common: [1.0; 3],
            continues: u32::from(shot.unseen == Unseen::Continued),
            of_sky: [1.0; 3],
            surroundings_reach: surroundings.map_or(f32::MAX, |cells| (cells.reach.0 as f32).min(f32::MAX)),
        }
    }
}
