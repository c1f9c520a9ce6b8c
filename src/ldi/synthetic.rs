//! Small layered depth images that tests of several rooms draw.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::levels::pyramid;
use crate::{DepthPixel, DepthPixelOrigin, Ldi, LdiKind, LdiReport, LdiSurface, ResolutionLevel, Splat};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::Model;
use quadratura_base::scene::synthetic::{Modeller, Rng, centred, look_at};
use quadratura_view::{Quality, Shot};

/// Returns a layered depth image with these depth pixels and surfaces.
pub fn with_level(level: ResolutionLevel, pose: Pose, surfaces: Vec<LdiSurface>) -> Ldi {
    let camera = level.camera;
    Ldi {
        kind: LdiKind::Depth,
        inputs: String::new(),
        camera,
        pose,
        photo_rect: None,
        gain: [0.0; 3],
        levels: pyramid(level, &surfaces),
        surfaces,
        sources: Vec::new(),
        report: LdiReport { quartiles: [1.0, 2.0, 3.0], ..LdiReport::default() },
    }
}

/// Returns all that the rays of a camera meet of a model: every face at every pixel centre, coloured by `colour` of the face's
/// index and the point.
pub fn of_model(
    model: &Arc<Model>,
    camera: Pinhole,
    pose: Pose,
    colour: impl Fn(usize, DVec3) -> [u8; 4],
) -> Ldi {
    let faces: Vec<_> = model.face_ids().collect();
    let planes: Vec<(DVec3, f64)> = faces
        .iter()
        .map(|&face| {
            let plane = &model.face(face).plane;
            let normal = pose.rotation * plane.normal;
            (normal, normal.dot(pose.camera_from_world(plane.point)))
        })
        .collect();
    let nu = |(normal, distance): &(DVec3, f64)| {
        let Pinhole { fx, fy, cx, cy, .. } = camera;
        let scaled = *normal / *distance;
        DVec3::new(scaled.x / fx, scaled.y / fy, scaled.z - scaled.x * cx / fx - scaled.y * cy / fy)
    };
    let object = |i: usize| format!("face {i}");
    let surfaces: Vec<_> = (0..)
        .zip(&planes)
        .map(|(i, plane)| LdiSurface { nu: nu(plane), object: object(i), face: None })
        .collect();
    let corners: Vec<Vec<[DVec3; 3]>> = faces
        .iter()
        .map(|&face| {
            let triangles = model.face_triangles(face).iter();
            triangles.map(|t| t.map(|v| pose.camera_from_world(model.vertices[v as usize]))).collect()
        })
        .collect();
    let row = |y: u32| {
        let mut row = Vec::new();
        for x in 0..camera.width {
            let position = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let ray = camera.ray_in_camera(position);
            let mut met: Vec<DepthPixel> = Vec::new();
            for (face, triangles) in corners.iter().enumerate() {
                let inverse_depth = surfaces[face].nu.dot(position.extend(1.0));
                if inverse_depth <= 1e-9 || !triangles.iter().any(|t| is_within(ray, t)) {
                    continue;
                }
                let point = pose.world_from_camera(ray / inverse_depth);
                met.push(DepthPixel {
                    inverse_depth: inverse_depth as f32,
                    colour: colour(face, point),
                    surface: face as u16 + 1,
                    splat: Splat::new(0, DepthPixelOrigin::Photo),
                });
            }
            met.sort_by(|a, b| b.inverse_depth.total_cmp(&a.inverse_depth));
            row.extend(met.into_iter().map(|pixel| (x as u16, pixel)));
        }
        row
    };
    let level = ResolutionLevel::of_rows(camera, (0..camera.height).map(row));
    with_level(level, pose, surfaces)
}

/// Returns whether a ray from the origin passes through a triangle, from either side.
fn is_within(ray: DVec3, [a, b, c]: &[DVec3; 3]) -> bool {
    let signs = [(a, b), (b, c), (c, a)].map(|(p, q)| p.cross(*q).dot(ray));
    signs.iter().all(|sign| *sign >= 0.0) || signs.iter().all(|sign| *sign <= 0.0)
}

/// Returns a pose near `eye`, up to `apart` away, that looks at a target up to `apart` beside another one.
pub fn step_aside(rng: &mut Rng, eye: DVec3, target: DVec3, apart: f64) -> Pose {
    let mut offset = || DVec3::from_array(std::array::from_fn(|_| rng.between(-apart, apart)));
    look_at(eye + offset(), target + offset())
}

/// Returns the layered depth image of a floor that a camera 1 above it sees, with a colour that changes slowly.
pub fn floor() -> (Arc<Model>, Ldi) {
    let mut model = Modeller::new();
    model.object("floor").quad(DVec3::new(-30.0, 0.0, -1.0), DVec3::X * 60.0, DVec3::Y * 30.0);
    let model = model.finish();
    let ldi = of_model(&model, centred(256, 256, 256.0), look_at(DVec3::ZERO, DVec3::Y), slow);
    (model, ldi)
}

/// Returns a view of the floor from farther above, in which depth pixels are two to eleven times as long as wide.
pub fn from_above(rng: &mut Rng) -> Shot {
    let target = DVec3::new(rng.between(-1.0, 1.0), rng.between(5.0, 7.0), -1.0);
    let eye = target + DVec3::new(rng.between(-2.0, 2.0), rng.between(-2.0, 2.0), 4.0);
    let camera = centred(90, 70, rng.between(80.0, 200.0));
    Shot { quality: Quality::Final, ..Shot::new(camera, look_at(eye, target)) }
}

/// Returns a colour that changes slowly, whatever the face.
pub fn slow(_: usize, point: DVec3) -> [u8; 4] {
    let wave = |rate: f64| (127.0 + 100.0 * (rate * (point.x + point.y)).sin()).round() as u8;
    [wave(1.0), wave(0.5), 99, 255]
}
