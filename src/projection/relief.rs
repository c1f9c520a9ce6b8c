//! Relief: the heights of the true surface over coarse faces of the model. It is estimated from the photos
//! and used for display only; the model itself is not changed.
//!
//! Photos projected onto a coarse face disagree where the true surface deviates from it. Floating Textures
//! (Eisemann et al. 2008) warp them into register for each view. Since the cameras are known far better than
//! the surface, one height per surface point explains all these warps and holds for any viewpoint. A point
//! moves along its viewing ray, so that a photo's own camera sees the photo's own pixels whatever the relief.

mod detail;
mod estimate;
mod fingerprint;
mod options;
mod plot;
mod smooth;
mod sweep;
mod sweep_view;
#[cfg(test)]
mod tests;

pub use estimate::{estimate_faces, estimate_relief, relief_without, seen_faces};
pub use options::ReliefOptions;
pub use sweep_view::{SweepView, SweepViews};

use glam::{DVec2, DVec3};

use quadratura_base::geometry::polygon::PlaneFrame;

/// The heights of one face, on a grid in its plane.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FaceRelief {
    /// The frame of flat coordinates in the face's plane, in world units.
    pub frame: PlaneFrame,
    /// The grid's low corner, in flat coordinates.
    pub low: DVec2,
    /// Side of a cell, in world units.
    pub cell: f64,
    /// The number of columns and rows.
    pub size: [u32; 2],
    /// Heights over the plane, along the face's normal, in world units, at the cells' centres, row by row
    /// from the low corner; `size[0] * size[1]` values.
    pub heights: Vec<f32>,
}

impl FaceRelief {
    /// Interpolates the height at a point of the plane: bilinear between the cells' centres, constant beyond
    /// the outer ones. It is written out, without `raster::bilinear`, so that it reads like the shader (`height_at`).
    pub fn height(&self, point_in_world: DVec3) -> f64 {
        let at = (self.frame.flat(point_in_world) - self.low) / self.cell - 0.5;
        let (x, y) = (at.x.max(0.0), at.y.max(0.0));
        let last = [self.size[0] - 1, self.size[1] - 1];
        let (x0, y0) = ((x as u32).min(last[0]), (y as u32).min(last[1]));
        let (x1, y1) = ((x0 + 1).min(last[0]), (y0 + 1).min(last[1]));
        let (sx, sy) = ((x - f64::from(x0)).min(1.0), (y - f64::from(y0)).min(1.0));
        let value = |x: u32, y: u32| f64::from(self.heights[(y * self.size[0] + x) as usize]);
        let row = |y: u32| value(x0, y) * (1.0 - sx) + value(x1, y) * sx;
        row(y0) * (1.0 - sy) + row(y1) * sy
    }

    /// Returns the largest absolute height, in world units.
    pub fn largest(&self) -> f64 {
        self.heights.iter().fold(0.0, |most, h| most.max(f64::from(h.abs())))
    }

    /// Intersects the ray from `eye` through a point of the plane with the relief, by the same two steps as
    /// the shader (`on_relief`).
    pub fn meet(&self, eye: DVec3, point_in_world: DVec3, normal: DVec3) -> DVec3 {
        let ray = (point_in_world - eye).normalize();
        let facing = normal.dot(ray);
        let slope = if facing < 0.0 { facing.min(-LEAST_FACING) } else { facing.max(LEAST_FACING) };
        let near = point_in_world + ray * (self.height(point_in_world) / slope);
        point_in_world + ray * (self.height(near) / slope)
    }
}

/// The least cosine of the angle between ray and normal that is used; points of faces seen more edge-on are
/// not moved farther.
pub const LEAST_FACING: f64 = 0.1;

/// The relief of all faces.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Relief {
    /// The relief of each face by id; faces with `None` and those beyond the list are flat.
    pub of_face: Vec<Option<FaceRelief>>,
}

impl Relief {
    /// Returns the relief of a face; `None` where it is flat.
    pub fn of(&self, face: quadratura_base::scene::FaceId) -> Option<&FaceRelief> {
        self.of_face.get(face.0 as usize)?.as_ref()
    }
}
