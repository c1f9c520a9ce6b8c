//! Square pieces of surfaces, drawn so that from wherever they are seen the same points of them fall on
//! the centres of pixels.
//!
//! A camera whose image is parallel to a plane shows it without perspective: a square grid on the plane is
//! a square grid in the picture, whatever the viewpoint, and a shift of the principal point brings the one
//! onto the other (a view camera does that with its lens). So the same surface points are compared from
//! any two viewpoints, nothing resampled between them; what is left is the rounding of f32, about a
//! thousandth of a pixel. And each pixel stands for the same piece of surface in both, so that photos are
//! looked up at the same level, with the same penalty for resolution: only angles change.

use glam::{DMat3, DVec2, DVec3};
use quadratura::task::Task;
use quadratura::testing::geometry::polygon::PlaneFrame;
use quadratura::testing::geometry::{Pinhole, Pose};
use quadratura::testing::gpu::Renderer;
use quadratura::testing::projection::Renders;
use quadratura::testing::projection::model_surface::ModelSurface;
use quadratura::testing::scene::synthetic::Rng;
use quadratura::testing::scene::{FaceId, Model};
use quadratura::testing::view::hidden::Culling;
use quadratura::testing::view::{Exposure, Shot};

/// Pixels on a side. Those around the border are drawn to be neighbours only.
pub const SIDE: u32 = 27;

/// The piece of a face.
#[derive(Debug, Clone, Copy)]
pub struct Patch {
    pub face: FaceId,
    /// Of the face.
    normal: DVec3,
    /// The point on the centre of the first pixel.
    first: DVec3,
    /// To the next pixel to the right, and down.
    steps: [DVec3; 2],
}

impl Patch {
    /// Somewhere in what a view shows. `texel`: what a photo's pixel covers at a distance of 1; pixels of
    /// the patch are from half as large as that to four times as large. `None` where there is nothing
    /// planar, or next to edge-on.
    pub fn random(
        surface: &ModelSurface,
        model: &Model,
        view: &Shot,
        texel: f64,
        rng: &mut Rng,
    ) -> Option<Self> {
        let share = DVec2::new(rng.unit(), rng.unit());
        let px = share * DVec2::new(view.camera.width.into(), view.camera.height.into());
        let scale = (2.0_f64).powf(rng.between(-1.0, 2.0));
        let eye = view.viewpoint();
        let ray = (view.pose.rotation.transpose() * view.camera.ray_in_camera(px)).normalize();
        let hit = surface.owner(eye, ray, 1e-4, Culling::nothing())?;
        let face = model.face(hit.face);
        // Where relief is the same height all over, no point is held back (it is from a cosine of 0.1 on).
        if !face.planar || face.plane.normal.dot(ray).abs() < 0.2 {
            return None;
        }
        let frame = PlaneFrame::from_plane(&face.plane);
        let away = frame.u.cross(frame.v).dot(ray) > 0.0;
        let axes = if away { [frame.u, frame.v] } else { [frame.v, frame.u] };
        let steps = axes.map(|axis| axis * hit.t * texel * scale);
        let middle = eye + ray * hit.t;
        let first = middle - (steps[0] + steps[1]) * (0.5 * f64::from(SIDE - 1));
        Some(Self { face: hit.face, normal: face.plane.normal, first, steps })
    }

    /// The patch seen from a viewpoint, as it is when it stands off its plane by `height`.
    pub fn shot(&self, eye: DVec3, height: f64) -> Shot {
        let [right, down] = self.steps.map(DVec3::normalize);
        let spacing = self.steps[0].length();
        let rotation = DMat3::from_cols(right, down, right.cross(down)).transpose();
        let first = rotation * (self.first + self.normal * height - eye);
        let focal = first.z / spacing;
        let (cx, cy) = (0.5 - first.x / spacing, 0.5 - first.y / spacing);
        let camera = Pinhole { width: SIDE, height: SIDE, fx: focal, fy: focal, cx, cy };
        let mut shot = Shot::new(camera, Pose { rotation, translation: -(rotation * eye) });
        // Of another direction the view's own exposure would be another one.
        shot.exposure = Exposure::Common;
        shot
    }

    /// The points on the centres of the pixels, in row order, this high over the face's plane.
    pub fn points(&self, height: f64) -> Vec<DVec3> {
        let first = self.first + self.normal * height;
        let at = |i: u32| first + self.steps[0] * f64::from(i % SIDE) + self.steps[1] * f64::from(i / SIDE);
        (0..SIDE * SIDE).map(at).collect()
    }

    /// Where a ray from `eye` through a point over the plane meets the plane.
    pub fn on_plane(&self, eye: DVec3, point: DVec3) -> DVec3 {
        let ray = point - eye;
        eye + ray * (self.normal.dot(self.first - eye) / self.normal.dot(ray))
    }

    /// For each pixel whether it shows the patch's face from all viewpoints, and its eight neighbours do.
    pub fn seen(&self, renderer: &mut Renderer, eyes: &[DVec3], height: f64) -> Vec<bool> {
        let side = SIDE as usize;
        let mut seen = vec![true; side * side];
        for &eye in eyes {
            let faces = renderer.faces(&self.shot(eye, height), &Task::silent()).unwrap();
            seen.iter_mut().zip(faces).for_each(|(seen, face)| *seen &= face == self.face.0 + 1);
        }
        let around = |i: usize| {
            let (x, y) = (i % side, i / side);
            let inside = x > 0 && y > 0 && x + 1 < side && y + 1 < side;
            inside && (0..9).all(|k| seen[(y + k / 3 - 1) * side + x + k % 3 - 1])
        };
        (0..side * side).map(around).collect()
    }
}
