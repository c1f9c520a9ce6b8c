//! A farmyard: a ground, a barn with a roof, a shed, a fence, three trees and a tractor, as in the figures of Gortler, He &
//! Cohen 1997, section 5, whose scene is not published.

use std::sync::Arc;

use glam::{DMat3, DVec3, dvec3};

use super::{Modeller, centred, look_at};
use crate::geometry::{Pinhole, Pose};
use crate::scene::Model;

/// What all cameras look at: the middle of the yard, in world units (metres, z up).
const TARGET: DVec3 = DVec3::new(0.0, 0.0, 1.8);
/// The cameras' distance from it, and their height.
const DISTANCE: f64 = 17.0;
const HEIGHT: f64 = 3.0;

/// Makes the model.
pub fn model() -> Arc<Model> {
    let mut m = Modeller::new();
    let upright = DMat3::IDENTITY;
    m.object("ground").quad(dvec3(-30.0, -30.0, 0.0), DVec3::X * 60.0, DVec3::Y * 60.0);
    m.object("barn").cuboid(dvec3(-1.0, 6.0, 2.0), dvec3(4.0, 2.5, 2.0), upright);
    let (eave, ridge) = (4.0, 6.2);
    m.object("barn roof").quad(dvec3(-5.4, 3.2, eave), DVec3::X * 8.8, dvec3(0.0, 2.8, ridge - eave)).quad(
        dvec3(-5.4, 8.8, eave),
        DVec3::X * 8.8,
        dvec3(0.0, -2.8, ridge - eave),
    );
    m.object("shed").cuboid(dvec3(6.0, 3.0, 1.3), dvec3(1.6, 1.4, 1.3), DMat3::from_rotation_z(0.3));
    m.object("fence");
    for post in 0..9 {
        m.cuboid(dvec3(-7.0 + 1.5 * f64::from(post), -5.0, 0.6), dvec3(0.06, 0.06, 0.6), upright);
    }
    for height in [0.45, 0.95] {
        m.cuboid(dvec3(-1.0, -5.0, height), dvec3(6.0, 0.03, 0.05), upright);
    }
    for (tree, (x, y)) in [(-7.0, 1.5), (4.0, -3.0), (-3.5, -1.5)].into_iter().enumerate() {
        m.object(format!("tree {tree}")).cuboid(dvec3(x, y, 0.8), dvec3(0.12, 0.12, 0.8), upright);
        for (i, size) in [1.1, 0.8].into_iter().enumerate() {
            let turned = DMat3::from_rotation_z(0.7 * i as f64 + x);
            m.cuboid(dvec3(x, y, 2.2 + i as f64), dvec3(size, size, 0.6), turned);
        }
    }
    let axes = DMat3::from_rotation_z(-0.5);
    m.object("tractor").cuboid(dvec3(1.0, 0.0, 0.9), dvec3(1.3, 0.45, 0.35), axes);
    m.cuboid(dvec3(0.4, 0.35, 1.7), dvec3(0.55, 0.5, 0.55), axes);
    for (x, y, size) in [(0.0, 1.0, 0.75), (0.0, -0.6, 0.75), (2.0, 0.0, 0.45), (1.7, -0.9, 0.45)] {
        m.cuboid(dvec3(x, y, size), dvec3(size, 0.15, size), axes);
    }
    m.finish()
}

/// Returns cameras of 320 x 320 pixels in a row around the yard, `apart` radians from one to the next.
pub fn cameras(count: u32, apart: f64) -> Vec<(Pinhole, Pose)> {
    let camera = centred(320, 320, 380.0);
    (0..count)
        .map(|i| {
            let angle = (f64::from(i) - f64::from(count - 1) / 2.0) * apart;
            let eye = dvec3(DISTANCE * angle.sin(), -DISTANCE * angle.cos(), HEIGHT);
            (camera, look_at(eye, TARGET))
        })
        .collect()
}
