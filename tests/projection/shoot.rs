//! Photos of invented scenes, taken by rays.

use std::f64::consts::TAU;
use std::fs::File;
use std::path::Path;

use glam::{DMat3, DQuat, DVec2, DVec3};
use quadratura::testing::geometry::{Pinhole, Pose};
use quadratura::testing::layered_files::Raster;
use quadratura::testing::layered_files::png::write_rgba;
use quadratura::testing::projection::model_surface::ModelSurface;
use quadratura::testing::scene::synthetic::{Rng, Scene};
use quadratura::testing::scene::{FaceId, Photo, Samples, Site};
use quadratura::testing::view::hidden::Culling;
use rayon::prelude::*;

/// How photos of a scene are taken.
pub struct Shoot {
    pub photos: u32,
    /// In front of the scene's own camera: what all of them look at, in world units away.
    pub depth: f64,
    /// They stand around it, up to so far apart, in radians.
    pub angle_rad: f64,
    /// By how much photos differ in colour where they show the same, in steps of 8 bits, up or down.
    pub difference: f64,
}

impl Shoot {
    /// A camera's pose, turned about what photos look at by a random angle, and nearer to it by up to this
    /// share of the way.
    pub fn pose(&self, scene: &Scene, rng: &mut Rng, nearer: f64) -> Pose {
        let about = scene.pose.world_from_camera(DVec3::Z * self.depth);
        let axis = DVec3::from_array([(); 3].map(|()| rng.between(-1.0, 1.0))).normalize();
        let turn = DQuat::from_axis_angle(axis, rng.between(-0.5, 0.5) * self.angle_rad);
        let eye = about + turn * (scene.pose.center_in_world() - about) * (1.0 - rng.between(0.0, nearer));
        let rotation = scene.pose.rotation * DMat3::from_quat(turn.inverse());
        Pose { rotation, translation: -(rotation * eye) }
    }

    /// The site of a scene, its photos in `folder`.
    pub fn site(&self, scene: &Scene, rng: &mut Rng, folder: &Path) -> Site {
        let surface = ModelSurface::from_model(&scene.model);
        let photo = |number: u32| {
            let pose = self.pose(scene, rng, 0.2);
            let shade = [(); 3].map(|()| rng.between(-1.0, 1.0) * self.difference);
            let name = format!("{number:02}.png");
            let file = folder.join(&name);
            let raster = taken(&surface, &scene.camera, &pose, shade);
            write_rgba(File::create(&file).unwrap(), &raster, None).unwrap();
            Photo { name, camera: scene.camera, pose, file, masks: Vec::new(), exposure: None }
        };
        Site { photos: (0..self.photos).map(photo).collect(), model: scene.model.clone() }
    }
}

/// A photo whose colours are off by `shade`.
fn taken(surface: &ModelSurface, camera: &Pinhole, pose: &Pose, shade: [f64; 3]) -> Raster {
    let pixel = |i: u32| {
        let px = DVec2::new(f64::from(i % camera.width) + 0.5, f64::from(i / camera.width) + 0.5);
        let (eye, ray) = (pose.center_in_world(), pose.rotation.transpose() * camera.ray_in_camera(px));
        let face = surface.owner(eye, ray, 1e-4, Culling::nothing()).map(|hit| hit.face);
        let own = colour(face, px);
        let byte = |c: usize| (own[c] + shade[c]).round().clamp(0.0, 255.0) as u8;
        [byte(0), byte(1), byte(2), 255]
    };
    let samples: Vec<u8> = (0..camera.width * camera.height).into_par_iter().flat_map_iter(pixel).collect();
    Raster::new(camera.width, camera.height, Samples::U8(samples))
}

/// Gentle waves, with a tint of the face: from texel to texel colours differ so little that it does not
/// matter in which encoding they are filtered. In steps of 8 bits.
fn colour(face: Option<FaceId>, px: DVec2) -> [f64; 3] {
    // Of the golden angle: neighbours in the model have different colours.
    let phase = face.map_or(0.0, |face| 2.4 * f64::from(face.0 + 1));
    let directions = [DVec2::new(0.8, 0.6), DVec2::new(-0.3, 0.9), DVec2::new(0.7, -0.7)];
    let wave = |c: usize| (TAU * px.dot(directions[c]) / 48.0 + c as f64).sin();
    [0, 1, 2].map(|c| 128.0 + 10.0 * (phase + 2.0 * c as f64).sin() + 20.0 * wave(c))
}
