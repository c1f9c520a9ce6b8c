//! The surfaces of several layered depth images, in one camera.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};

use crate::layout::{Ldi, LdiSurface, MOST_SURFACES};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::FaceIndex;

/// The least distance of the camera from a plane, as a share of that of the source's camera, below which the plane counts as
/// seen from its side: it has no inverse depth.
const LEAST_DISTANCE: f64 = 1e-6;

/// The surfaces of all sources.
#[derive(Debug)]
pub struct CommonSurfaces {
    /// The surfaces in the common camera.
    pub list: Vec<LdiSurface>,
    /// The number of each source's surfaces in the list, by source and number; 0 for unknown ones.
    pub numbers: Vec<Vec<u16>>,
    /// The number of surfaces that became unknown.
    pub unknown: u64,
}

/// What identifies a surface: object and face.
type ObjectFace<'a> = (&'a str, Option<FaceIndex>);

impl CommonSurfaces {
    /// Finds the surfaces of sources in a camera. Surfaces of one object and face are one; where there are too many, those
    /// with the fewest depth pixels are unknown, and so are planes in which the camera is.
    pub fn new(camera: &Pinhole, pose: &Pose, sources: &[&Ldi]) -> Self {
        let mut found: BTreeMap<ObjectFace, (LdiSurface, u64)> = BTreeMap::new();
        let mut unknown = 0;
        for ldi in sources {
            let pixels = depth_pixels_of_surfaces(ldi);
            for (surface, pixels) in ldi.surfaces.iter().zip(&pixels[1..]) {
                match in_camera(surface, ldi, camera, pose) {
                    Some(nu) => {
                        let entry = found.entry(key(surface));
                        let new = || (LdiSurface { nu, ..surface.clone() }, 0);
                        entry.or_insert_with(new).1 += pixels;
                    }
                    None => unknown += 1,
                }
            }
        }
        let mut kept: Vec<(&ObjectFace, &(LdiSurface, u64))> = found.iter().collect();
        unknown += kept.len().saturating_sub(MOST_SURFACES) as u64;
        if kept.len() > MOST_SURFACES {
            kept.sort_by_key(|(key, (_, pixels))| (std::cmp::Reverse(*pixels), **key));
            kept.truncate(MOST_SURFACES);
            kept.sort_by_key(|(key, _)| **key);
        }
        let number: BTreeMap<ObjectFace, u16> =
            kept.iter().zip(1..).map(|((key, _), i)| (**key, i)).collect();
        let numbers = sources
            .iter()
            .map(|ldi| {
                let of = |surface: &LdiSurface| number.get(&key(surface)).copied().unwrap_or(0);
                std::iter::once(0).chain(ldi.surfaces.iter().map(of)).collect()
            })
            .collect();
        Self { list: kept.into_iter().map(|(_, (surface, _))| surface.clone()).collect(), numbers, unknown }
    }
}

fn key(surface: &LdiSurface) -> ObjectFace<'_> {
    (&surface.object, surface.face)
}

/// Returns the number of depth pixels of each surface, the unknown one first.
fn depth_pixels_of_surfaces(ldi: &Ldi) -> Vec<u64> {
    let mut pixels = vec![0; ldi.surfaces.len() + 1];
    ldi.levels[0].surfaces.iter().for_each(|surface| pixels[usize::from(*surface)] += 1);
    pixels
}

/// Returns nu of a surface in another camera; `None` where this camera is in the surface's plane.
fn in_camera(surface: &LdiSurface, ldi: &Ldi, camera: &Pinhole, pose: &Pose) -> Option<DVec3> {
    if surface.nu == DVec3::ZERO {
        return Some(DVec3::ZERO);
    }
    // d = nu . K X / z and d z = 1 make m . X = 1 with m = K^T nu, X a point of the plane in the source's camera.
    let m = matrix(&ldi.camera).transpose() * surface.nu;
    let rotation = ldi.pose.rotation * pose.rotation.transpose();
    let moved = ldi.pose.rotation * (pose.center_in_world() - ldi.pose.center_in_world());
    let distance = 1.0 - m.dot(moved);
    if distance.abs() < LEAST_DISTANCE {
        return None;
    }
    let in_camera = rotation.transpose() * m / distance;
    Some(matrix(camera).transpose().inverse() * in_camera)
}

/// Returns K.
fn matrix(camera: &Pinhole) -> DMat3 {
    let Pinhole { fx, fy, cx, cy, .. } = *camera;
    DMat3::from_cols(DVec3::new(fx, 0.0, 0.0), DVec3::new(0.0, fy, 0.0), DVec3::new(cx, cy, 1.0))
}
