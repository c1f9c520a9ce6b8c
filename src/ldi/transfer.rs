//! The transfer: where the depth pixels of a reference camera are in a picture of another camera.
//!
//! With R = R2 R1^T, t = R2 (C1 - C2), A = K2 R K1^-1 and b = K2 t, a depth pixel at image position p = (x, y, 1) with
//! inverse depth d is at `(u omega, v omega, omega) = A p + d b`. This is the paper's C2 C1^-1 applied to (x, y, z, 1), with
//! projections such that z = 1/depth in both cameras: its third row only hands d through. (Index 1: the reference
//! camera; index 2: the camera of the picture.)

use glam::{DMat3, DVec2, DVec3};

use quadratura_base::geometry::{Pinhole, Pose};

/// The columns over which positions are computed from one start, in f64; starts are at multiples of it.
pub const RUN: u32 = 256;

/// The transfer between two cameras, in f64.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transfer {
    /// A, which takes an image position at infinity to the picture.
    pub a: DMat3,
    /// b, by which a depth pixel moves for each unit of inverse depth.
    pub b: DVec3,
    /// E = K1 R1 (C2 - C1): the homogeneous position of the picture's camera in the reference camera's image.
    pub epipole: DVec3,
    /// f2 / f1, with f = sqrt(fx fy).
    pub focal_ratio: f64,
    /// The picture's size in pixels.
    pub size: [u32; 2],
}

/// Returns K.
fn matrix(camera: &Pinhole) -> DMat3 {
    let Pinhole { fx, fy, cx, cy, .. } = *camera;
    DMat3::from_cols(DVec3::new(fx, 0.0, 0.0), DVec3::new(0.0, fy, 0.0), DVec3::new(cx, cy, 1.0))
}

/// Returns the inverse of K.
fn inverse_matrix(camera: &Pinhole) -> DMat3 {
    let Pinhole { fx, fy, cx, cy, .. } = *camera;
    DMat3::from_cols(
        DVec3::new(1.0 / fx, 0.0, 0.0),
        DVec3::new(0.0, 1.0 / fy, 0.0),
        DVec3::new(-cx / fx, -cy / fy, 1.0),
    )
}

impl Transfer {
    /// Composes the transfer from a reference camera (1) to the camera of a picture (2). The difference of the centres is taken
    /// first, so that a world whose origin is far away costs no accuracy.
    pub fn new(camera1: &Pinhole, pose1: &Pose, camera2: &Pinhole, pose2: &Pose) -> Self {
        let forward = pose2.center_in_world() - pose1.center_in_world();
        let focal = |camera: &Pinhole| (camera.fx * camera.fy).sqrt();
        Self {
            a: matrix(camera2) * (pose2.rotation * pose1.rotation.transpose()) * inverse_matrix(camera1),
            b: matrix(camera2) * (pose2.rotation * -forward),
            epipole: matrix(camera1) * (pose1.rotation * forward),
            focal_ratio: focal(camera2) / focal(camera1),
            size: [camera2.width, camera2.height],
        }
    }

    /// Returns `(u omega, v omega, omega)` of an image position with an inverse depth.
    #[inline]
    pub fn homogeneous(&self, position: DVec2, inverse_depth: f64) -> DVec3 {
        self.a * position.extend(1.0) + inverse_depth * self.b
    }

    /// Returns the position in the picture, in pixels, and omega; `None` where omega is not positive.
    #[inline]
    pub fn position(&self, position: DVec2, inverse_depth: f64) -> Option<(DVec2, f64)> {
        let DVec3 { x, y, z } = self.homogeneous(position, inverse_depth);
        (z > 0.0).then(|| (DVec2::new(x / z, y / z), z))
    }

    /// Returns the transfer in single precision, for rows of depth pixels.
    pub fn rows(&self) -> RowTransfer {
        let half = [f64::from(self.size[0]) / 2.0, f64::from(self.size[1]) / 2.0];
        let rows = self.a.transpose();
        // Positions are computed from the picture's centre, where they have the most digits.
        let a = [rows.x_axis - half[0] * rows.z_axis, rows.y_axis - half[1] * rows.z_axis, rows.z_axis];
        let b = [self.b.x - half[0] * self.b.z, self.b.y - half[1] * self.b.z, self.b.z];
        RowTransfer {
            a,
            step: a.map(|row| row.x as f32),
            depth: b.map(|value| value as f32),
            half: half.map(|side| side as f32),
        }
    }
}

/// The transfer in the form in which the rows of a level are moved: composed in f64 and rounded once.
#[derive(Debug, Clone, Copy)]
pub struct RowTransfer {
    /// The rows of A, the first two from the picture's centre.
    a: [DVec3; 3],
    /// The change from one column to the next.
    pub step: [f32; 3],
    /// b, the first two components from the picture's centre.
    pub depth: [f32; 3],
    /// Half the picture's sides in pixels.
    pub half: [f32; 2],
}

/// The start of a run: the homogeneous position at its first column and d = 0.
#[derive(Debug, Clone, Copy)]
pub struct RunStart {
    first: u32,
    /// The homogeneous position, the first two components from the picture's centre.
    pub start: [f32; 3],
}

/// The positions of up to [`Positions::MOST`] depth pixels in a picture.
#[derive(Debug, Clone)]
pub struct Positions {
    /// Columns, in pixels; NaN where the depth pixel is behind the picture's camera.
    pub u: [f32; Self::MOST],
    /// Rows, in pixels; NaN likewise.
    pub v: [f32; Self::MOST],
    /// 1 / omega; NaN likewise.
    pub per_omega: [f32; Self::MOST],
}

impl Positions {
    /// The largest number of depth pixels of one batch.
    pub const MOST: usize = 256;
}

impl Default for Positions {
    fn default() -> Self {
        Self { u: [0.0; Self::MOST], v: [0.0; Self::MOST], per_omega: [0.0; Self::MOST] }
    }
}

impl RowTransfer {
    /// Returns the start of the run that column `x` of row `y` belongs to.
    #[inline]
    pub fn start(&self, x: u32, y: u32) -> RunStart {
        let first = x - x % RUN;
        let p = DVec3::new(f64::from(first) + 0.5, f64::from(y) + 0.5, 1.0);
        let [u, v, omega] = [self.a[0].dot(p), self.a[1].dot(p), self.a[2].dot(p)];
        RunStart { first, start: [u as f32, v as f32, omega as f32] }
    }

    /// Returns omega at d = 0 of a column: negative where the picture's camera looks back along that ray.
    #[inline]
    pub fn omega_at_infinity(&self, run: &RunStart, column: u32) -> f32 {
        run.start[2] + (column - run.first) as f32 * self.step[2]
    }

    /// Computes the positions of depth pixels of one run: `columns` and `inverse_depths` are equally long, at most
    /// [`Positions::MOST`]. Each position is one product and one sum away from the start of the run, never a sum of
    /// increments, and no two operations are fused, so that the results are the same on every processor.
    // Iterators are calls in the profile `quick`, which does not optimise across all functions.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    pub fn place(&self, run: &RunStart, columns: &[u16], inverse_depths: &[f32], out: &mut Positions) {
        let RunStart { first, start } = *run;
        let (step, depth, half) = (self.step, self.depth, self.half);
        let (count, columns) = (inverse_depths.len(), &columns[..inverse_depths.len()]);
        let Positions { u, v, per_omega } = out;
        let (u, v, per_omega) = (&mut u[..count], &mut v[..count], &mut per_omega[..count]);
        for i in 0..count {
            let (k, d) = ((i32::from(columns[i]) - first as i32) as f32, inverse_depths[i]);
            let at = |axis: usize| (start[axis] + k * step[axis]) + d * depth[axis];
            let omega = at(2);
            let per = 1.0 / if omega > 0.0 { omega } else { f32::NAN };
            u[i] = at(0) * per + half[0];
            v[i] = at(1) * per + half[1];
            per_omega[i] = per;
        }
    }
}
