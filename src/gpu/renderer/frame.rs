//! The uniform of a view (`Frame` of `shaders/surfaces.wgsl`).

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::surfaces::split;
use quadratura_projection::Sources;
use quadratura_projection::cells::Cells;
use quadratura_view::optics::ViewLens;
use quadratura_view::{Shot, Unseen};

/// How the depth buffer stores depths: more in front, linear over the image, and 0 where nothing is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StoredDepths {
    /// `near / depth`; depths are those from the viewpoint, in world units.
    Perspective {
        /// The depth of the near plane.
        near: f64,
    },
    /// `(far - depth) * per_unit`, of parallel rays; depths are those behind the view's reference point.
    Parallel {
        /// A depth behind everything.
        far: f64,
        /// 1 over the range of depths from the near plane on.
        per_unit: f64,
    },
}

/// The depths behind all that is visible, in visible ranges, that keep stored depths of parallel rays away from 0: what is nearer by a share
/// of its stored depth is nearer by about the same everywhere.
const BEHIND: f64 = 0.25;

/// The range of depths of parallel rays in front of all that is visible, as a share.
const BEFORE: f64 = 0.01;

impl StoredDepths {
    /// Returns how the depths of a view are stored. `depths` are the least and the largest depth from the viewpoint of what is visible.
    pub fn new(shot: &Shot, depths: [f64; 2]) -> Self {
        let Some(parallel) = shot.parallel else {
            return Self::Perspective { near: Cells { depths, ..Cells::default() }.near() };
        };
        let [nearest, farthest] = depths.map(|depth| depth - parallel.distance);
        // A plane at right angles to the rays has no range of its own.
        let range = (farthest - nearest).max(BEFORE * parallel.extent);
        let far = farthest + BEHIND * range;
        let near =
            parallel.from_depth.unwrap_or(f64::NEG_INFINITY).max(nearest - BEFORE * range).min(farthest);
        Self::Parallel { far, per_unit: 1.0 / (far - near) }
    }

    /// Returns what is stored for a depth.
    pub fn stored(self, depth: f64) -> f64 {
        match self {
            Self::Perspective { near } if depth > 0.0 => near / depth,
            Self::Perspective { .. } => f64::INFINITY,
            Self::Parallel { far, per_unit } => (far - depth) * per_unit,
        }
    }

    /// Returns the depth of what is stored; infinite where nothing is.
    pub fn depth(self, stored: f32) -> f64 {
        let stored = f64::from(stored);
        match self {
            Self::Perspective { near } => near / stored,
            Self::Parallel { .. } if stored <= 0.0 => f64::INFINITY,
            Self::Parallel { far, per_unit } => far - stored / per_unit,
        }
    }
}

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
    pub parallel: u32,
    pub far: f32,
    pub of_common: [f32; 3],
    pub continues: u32,
    pub of_sky: [f32; 3],
    pub surroundings_reach: f32,
}

impl CameraUniform {
    /// Builds the uniform of a view. `origin` is the world point that positions are relative to.
    pub fn new(shot: &Shot, lens: &ViewLens, origin: DVec3, cells: &Cells, sources: &Sources) -> Self {
        let scale = sources.surroundings_scale;
        let (cell_px, surroundings) = (cells.side_px, cells.surroundings);
        let (near, far) = match StoredDepths::new(shot, cells.depths) {
            StoredDepths::Perspective { near } => (near, 0.0),
            StoredDepths::Parallel { far, per_unit } => (per_unit, far),
        };
        let [right, down, forward] = shot.pose.rotation_rows().map(|row| row.map(|v| v as f32));
        let (eye_high, eye_low) = split(shot.reference() - origin);
        let camera = &shot.camera;
        // Pixels per world unit, of parallel rays.
        let per_distance = shot.parallel.map_or(1.0, |parallel| 1.0 / parallel.distance);
        let [focal_x, focal_y] = [camera.fx * per_distance, camera.fy * per_distance];
        // No lens makes parallel rays.
        let lens = if shot.parallel.is_some() { &ViewLens::default() } else { lens };
        Self {
            right,
            focal_x: focal_x as f32,
            down,
            focal_y: focal_y as f32,
            forward,
            near: near as f32,
            center: [camera.cx as f32, camera.cy as f32],
            size: [camera.width as f32, camera.height as f32],
            eye_high,
            density: (focal_x * focal_y) as f32,
            eye_low,
            lambda: shot.blend.lambda as f32,
            cell_px,
            reach: 1.0 + shot.stored_tolerance() as f32,
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
            parallel: u32::from(shot.parallel.is_some()),
            far: far as f32,
            of_common: [1.0; 3],
            continues: u32::from(shot.unseen == Unseen::Continued),
            of_sky: [1.0; 3],
            surroundings_reach: surroundings.map_or(f32::MAX, |cells| (cells.reach.0 as f32).min(f32::MAX)),
        }
    }
}
