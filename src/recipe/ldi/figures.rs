//! What is computed of all depth pixels together: quartiles of distances, and the surfaces that are named.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::cover::Found;
use super::planes::SurfacePlane;
use crate::geometry::Pinhole;
use crate::ldi::layout::MOST_SURFACES;
use crate::ldi::spacing::{entry_of, normal_of};
use crate::ldi::{DepthPixel, LdiSurface, Splat};

/// Returns the distance of a depth pixel from the camera; infinite for inverse depth 0.
fn distance(camera: &Pinhole, found: &Found, y: u32) -> f64 {
    let ray = camera.ray_in_camera(DVec2::new(f64::from(found.column) + 0.5, f64::from(y) + 0.5));
    ray.length() / f64::from(found.inverse_depth)
}

/// Returns the quartiles of the distances of all depth pixels that are not infinitely far away; 0 where there are none.
pub fn quartiles(camera: &Pinhole, rows: &[Vec<Found>]) -> [f64; 3] {
    let of_row = |(y, row): (usize, &Vec<Found>)| {
        row.iter().map(move |found| distance(camera, found, y as u32) as f32).collect::<Vec<_>>()
    };
    let mut distances: Vec<f32> = rows.par_iter().enumerate().flat_map_iter(of_row).collect();
    distances.retain(|distance| distance.is_finite());
    let count = distances.len();
    [1, 2, 3].map(|quarter| match count {
        0 => 0.0,
        _ => f64::from(*distances.select_nth_unstable_by(quarter * (count - 1) / 4, f32::total_cmp).1),
    })
}

/// The surfaces that depth pixels name.
pub struct Named {
    /// The surfaces in the order of the planes.
    pub surfaces: Vec<LdiSurface>,
    /// How many have no number, because there are too many.
    pub unknown: u64,
    /// The number of each plane's surface; 0 for an unknown one.
    numbers: Vec<u16>,
    /// The unit normals of the planes, towards the camera.
    normals: Vec<DVec3>,
}

impl Named {
    /// Numbers the surfaces of the planes that have depth pixels. Where there are too many, those with the fewest are unknown.
    pub fn new(camera: &Pinhole, planes: &[SurfacePlane], rows: &[Vec<Found>]) -> Self {
        let mut pixels = vec![0u64; planes.len()];
        rows.iter().flatten().for_each(|found| pixels[found.plane as usize] += 1);
        let mut used: Vec<usize> = (0..planes.len()).filter(|&plane| pixels[plane] > 0).collect();
        let unknown = used.len().saturating_sub(MOST_SURFACES);
        if unknown > 0 {
            used.sort_by_key(|&plane| (std::cmp::Reverse(pixels[plane]), plane));
            used.truncate(MOST_SURFACES);
            used.sort_unstable();
        }
        let mut numbers = vec![0; planes.len()];
        used.iter().zip(1..).for_each(|(&plane, number)| numbers[plane] = number);
        let surfaces: Vec<LdiSurface> = used.iter().map(|&plane| planes[plane].surface()).collect();
        let mut normals = vec![-DVec3::Z; planes.len()];
        for (&plane, surface) in used.iter().zip(&surfaces).filter(|(_, surface)| surface.nu != DVec3::ZERO) {
            normals[plane] = normal_of(surface, camera);
        }
        Self { surfaces, unknown: unknown as u64, numbers, normals }
    }

    /// Returns a row of the layout.
    pub fn row(
        &self,
        camera: &Pinhole,
        y: u32,
        row: &[Found],
        quartiles: &[f64; 3],
    ) -> Vec<(u16, DepthPixel)> {
        let pixel = |found: &Found| {
            let plane = found.plane as usize;
            let entry = entry_of(self.normals[plane], distance(camera, found, y), quartiles);
            let pixel = DepthPixel {
                inverse_depth: found.inverse_depth,
                colour: found.colour,
                surface: self.numbers[plane],
                splat: Splat::new(entry, found.origin),
            };
            (found.column, pixel)
        };
        row.iter().map(pixel).collect()
    }
}
