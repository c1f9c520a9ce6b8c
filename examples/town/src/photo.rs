//! Photos of the town: one ray per pixel, the sun with its shadows, the sky, exposure and noise.

use glam::{DVec3, dvec3};
use image::{Rgb, RgbImage};
use quadratura_base::geometry::Pinhole;
use quadratura_base::scene::synthetic::Rng;

use crate::colours::{albedo, hash, unit};
use crate::houses::Town;
use crate::plan::Station;

/// Farther away nothing is drawn, in metres.
const FARTHEST: f64 = 5000.0;

/// Takes a photo. Its exposure differs from that of others by 10 percent at most.
pub fn taken(town: &Town, station: &Station, camera: &Pinhole, seed: u64) -> RgbImage {
    let exposure = Rng::new(seed).between(0.9, 1.1);
    let world_from_camera = station.pose.rotation.transpose();
    RgbImage::from_fn(camera.width, camera.height, |x, y| {
        let [u, v] = [f64::from(x) + 0.5, f64::from(y) + 0.5];
        let direction =
            world_from_camera * dvec3((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
        let light = exposure * seen(town, station.eye, direction, 1.0 / camera.fx);
        let noise = hash(seed, u64::from(y) << 32 | u64::from(x));
        let channel = |channel: usize| {
            let noise = unit(hash(noise, channel as u64)) + unit(hash(noise, channel as u64 + 3)) - 1.0;
            (255.0 * srgb(light[channel]) + 2.0 * noise).round().clamp(0.0, 255.0) as u8
        };
        Rgb([0, 1, 2].map(channel))
    })
}

/// Returns the light along a ray whose direction has depth 1; `pixel`: what a pixel covers at depth 1.
fn seen(town: &Town, eye: DVec3, direction: DVec3, pixel: f64) -> DVec3 {
    let sun = dvec3(0.45, -0.35, 0.82).normalize();
    let Some((depth, triangle)) = town.rays.first_hit(eye, direction, FARTHEST) else {
        return sky(direction.normalize(), sun);
    };
    let surface = &town.surfaces[town.face_of[triangle as usize] as usize];
    let point = eye + direction * depth;
    let steepness = surface.normal.dot(direction.normalize()).abs().max(0.05);
    let footprint = depth * pixel / steepness.sqrt();
    let falls = surface.normal.dot(sun).max(0.0);
    let lit = falls > 0.0 && town.rays.first_hit(point + 1e-4 * surface.normal, sun, FARTHEST).is_none();
    let direct = if lit { 1.15 * falls } else { 0.0 };
    let ambient = dvec3(0.50, 0.55, 0.62) * (0.75 + 0.25 * surface.normal.z);
    albedo(surface, point, footprint) * (ambient + DVec3::splat(direct))
}

/// A sky with a paler horizon and a glow around the sun.
fn sky(direction: DVec3, sun: DVec3) -> DVec3 {
    let up = direction.z.max(0.0);
    let glow = direction.dot(sun).max(0.0).powi(60);
    dvec3(0.62, 0.68, 0.74).lerp(dvec3(0.20, 0.36, 0.66), up.sqrt()) + DVec3::splat(0.25 * glow)
}

/// Encodes linear light between 0 and 1.
fn srgb(light: f64) -> f64 {
    let light = light.clamp(0.0, 1.0);
    if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
}
