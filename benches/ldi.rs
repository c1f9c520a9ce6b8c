//! Warps of a layered depth image, beside two yardsticks in the same run: copying the bytes that a warp of single pixels
//! reads, and a forward warp with a z-buffer in double precision, one depth pixel after the other; by one thread, and by two;
//! and the warp of an image with thousands of times as many faces. And the merging of three depth images of the farmyard into one
//! layered depth image, by the published rule and by ours, by one thread and by two.
//!
//! `cargo bench --bench ldi`: ratios of one run.

use std::collections::BTreeMap;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DMat3, DVec2, DVec3};
use quadratura::task::Task;
use quadratura::testing::geometry::{Pinhole, Pose};
use quadratura::testing::ldi::transfer::Transfer;
use quadratura::testing::ldi::{
    Combining, CommonCamera, DepthPixel, Ldi, LdiKind, LdiReport, LdiSurface, ResolutionLevel, SourceImage,
    Splat, SplatKind, WarpOptions, combine, warp,
};
use quadratura::testing::scene::FaceId;
use quadratura::testing::scene::synthetic::{centred, farmyard};
use quadratura::testing::view::Shot;

/// The frame: 2.66 million layered depth pixels.
const FRAME: [u32; 2] = [2000, 1330];

/// The sides of the faces in pixels, where planes are divided into faces.
const FACE: u32 = 12;

/// Returns a wall and a floor behind a chequer of cards, whose depth pixels all differ in colour: three faces, or if `divided`
/// 55,000 faces of the same planes.
fn cards(divided: bool) -> Ldi {
    let camera = centred(FRAME[0], FRAME[1], 1800.0);
    let pose = Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };
    let nus = [DVec3::new(0.0, 0.0, 0.1), DVec3::new(0.0, 2e-4, -0.08), DVec3::new(2e-5, 0.0, 0.2)];
    let row = |y: u32| -> Vec<(u16, DepthPixel)> {
        let pixel = |x: u32| {
            let surface = match (x / 97 + y / 83) % 3 {
                0 => 2,
                _ if y > 900 => 1,
                _ => 0,
            };
            let inverse_depth =
                nus[surface].dot(DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0)) as f32;
            let colour = [x as u8, y as u8, (x * y) as u8, 255];
            let face = if divided { y / FACE * FRAME[0].div_ceil(FACE) + x / FACE } else { 0 };
            let surface = (3 * face + surface as u32 + 1) as u16;
            (x as u16, DepthPixel { inverse_depth, colour, surface, splat: Splat(0) })
        };
        (0..FRAME[0]).map(pixel).collect()
    };
    let level = ResolutionLevel::of_rows(camera, (0..FRAME[1]).map(row));
    let surface = |nu| LdiSurface { nu, object: "card".into(), face: None };
    let faces = if divided { FRAME[0].div_ceil(FACE) * FRAME[1].div_ceil(FACE) } else { 1 };
    let surfaces = (0..faces).flat_map(|_| nus.map(surface)).collect();
    Ldi { surfaces, levels: vec![level], ..empty(camera, pose) }
}

/// Returns an image of a camera without depth pixels.
fn empty(camera: Pinhole, pose: Pose) -> Ldi {
    Ldi {
        kind: LdiKind::Depth,
        inputs: String::new(),
        camera,
        pose,
        photo_rect: None,
        gain: [0.0; 3],
        surfaces: Vec::new(),
        sources: Vec::new(),
        levels: Vec::new(),
        report: LdiReport::default(),
    }
}

/// A step aside, half a degree of turn for each 2 % of the distance.
fn aside() -> Shot {
    let rotation = DMat3::from_rotation_y(0.05);
    let pose = Pose { rotation, translation: rotation * -DVec3::new(0.3, 0.1, 0.2) };
    Shot::new(centred(1536, 1024, 1380.0), pose)
}

/// The yardstick: nearest depth pixels by comparison of depths.
fn z_buffer(level: &ResolutionLevel, transfer: &Transfer, camera: &Pinhole) -> Vec<[u8; 4]> {
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    let pixels = camera.width as usize * camera.height as usize;
    let (mut nearest, mut colours) = (vec![0.0; pixels], vec![[0; 4]; pixels]);
    for y in 0..level.camera.height {
        for i in level.row(y) {
            let depth = f64::from(level.inverse_depths[i]);
            let position = DVec2::new(f64::from(level.columns[i]) + 0.5, f64::from(y) + 0.5);
            let p = transfer.homogeneous(position, depth);
            let (u, v, q) = (p.x / p.z, p.y / p.z, depth / p.z);
            if p.z > 0.0 && u >= 0.0 && v >= 0.0 && u < width && v < height {
                let at = v as usize * camera.width as usize + u as usize;
                if q > nearest[at] {
                    (nearest[at], colours[at]) = (q, level.colours[i]);
                }
            }
        }
    }
    colours
}

fn warps(criterion: &mut Criterion) {
    let (ldi, divided, shot) = (cards(false), cards(true), aside());
    let level = &ldi.levels[0];
    let mut group = criterion.benchmark_group("warp");
    group.throughput(Throughput::Elements(level.len() as u64)).sample_size(20);
    let mut copies = (level.columns.clone(), level.inverse_depths.clone(), level.colours.clone());
    group.bench_function("copy of the bytes", |b| {
        b.iter(|| {
            copies.0.copy_from_slice(&level.columns);
            copies.1.copy_from_slice(&level.inverse_depths);
            copies.2.copy_from_slice(&level.colours);
            std::hint::black_box(&copies);
        });
    });
    let transfer = Transfer::new(&ldi.camera, &ldi.pose, &shot.camera, &shot.pose);
    group.bench_function("z-buffer", |b| b.iter(|| z_buffer(level, &transfer, &shot.camera)));
    for (threads, suffix) in [(1, ""), (2, ", two threads")] {
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads can be started");
        for (name, splat) in
            [("pixel", SplatKind::Pixel), ("over", SplatKind::Over), ("sums", SplatKind::Sums)]
        {
            let options = WarpOptions { splat, level: Some(0), ..WarpOptions::default() };
            let picture = || warp(&ldi, &shot, &options, &Task::silent()).expect("nobody stops it");
            group.bench_function(format!("{name}{suffix}"), |b| pool.install(|| b.iter(picture)));
        }
    }
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread can be started");
    let options = WarpOptions { level: Some(0), ..WarpOptions::default() };
    let picture = || warp(&divided, &shot, &options, &Task::silent()).expect("nobody stops it");
    group.bench_function("sums, 55,000 faces", |b| one.install(|| b.iter(picture)));
    group.finish();
}

/// Returns the depth images of three cameras of the farmyard, 320 x 320 pixels, 10 degrees apart.
fn farmyard_images() -> Vec<Ldi> {
    let model = farmyard::model();
    let faces: Vec<_> = model.face_ids().collect();
    let image = |(camera, pose): (Pinhole, Pose)| {
        let plane_of = |face: &FaceId| {
            let plane = &model.face(*face).plane;
            let normal = pose.rotation * plane.normal;
            normal / normal.dot(pose.camera_from_world(plane.point))
        };
        let planes: Vec<DVec3> = faces.iter().map(plane_of).collect();
        let pixel = |x: u32, y: u32| -> Option<(u16, DepthPixel)> {
            let ray = camera.ray_in_camera(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
            let hit = |(index, face): (usize, &FaceId)| {
                let inverse_depth = planes[index].dot(ray);
                let within = |[a, b, c]: &[u32; 3]| {
                    let [a, b, c] = [a, b, c].map(|v| pose.camera_from_world(model.vertices[*v as usize]));
                    let signs = [(a, b), (b, c), (c, a)].map(|(p, q)| p.cross(q).dot(ray));
                    signs.iter().all(|sign| *sign >= 0.0) || signs.iter().all(|sign| *sign <= 0.0)
                };
                (inverse_depth > 1e-9 && model.face_triangles(*face).iter().any(within))
                    .then_some((inverse_depth, index))
            };
            let nearest = faces.iter().enumerate().filter_map(hit).max_by(|a, b| a.0.total_cmp(&b.0));
            let (inverse_depth, index) = nearest?;
            let colour = [x as u8, y as u8, (index * 47) as u8, 255];
            let (inverse_depth, surface) = (inverse_depth as f32, index as u16 + 1);
            Some((x as u16, DepthPixel { inverse_depth, colour, surface, splat: Splat(0) }))
        };
        let row = |y: u32| (0..camera.width).filter_map(|x| pixel(x, y)).collect();
        let level = ResolutionLevel::of_rows(camera, (0..camera.height).map(row));
        let nu = |plane: &DVec3| {
            let Pinhole { fx, fy, cx, cy, .. } = camera;
            DVec3::new(plane.x / fx, plane.y / fy, plane.z - plane.x * cx / fx - plane.y * cy / fy)
        };
        let surfaces = planes.iter().zip(0..).map(|(plane, i): (_, u32)| LdiSurface {
            nu: nu(plane),
            object: format!("face {i}"),
            face: None,
        });
        Ldi { camera, pose, surfaces: surfaces.collect(), levels: vec![level], ..empty(camera, pose) }
    };
    farmyard::cameras(3, 10f64.to_radians()).into_iter().map(image).collect()
}

fn merges(criterion: &mut Criterion) {
    let images = farmyard_images();
    let [left, own, right] = &images[..] else { unreachable!("three cameras have three images") };
    let frame = CommonCamera::new(own.camera, own.pose, own.gain, 0.0, true);
    let source = |ldi, is_own| SourceImage { ldi, is_own };
    let sources = [source(own, true), source(left, false), source(right, false)];
    let mut group = criterion.benchmark_group("merge");
    group.throughput(Throughput::Elements(images.iter().map(|ldi| ldi.levels[0].len() as u64).sum()));
    for (threads, suffix) in [(1, ""), (2, ", two threads")] {
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads can be started");
        for (name, published) in [("ours", false), ("published", true)] {
            let combining = Combining { published, ..Combining::default() };
            let merged = || {
                let options = BTreeMap::new();
                combine(LdiKind::Photos, &frame, &sources, &combining, options, &Task::silent())
                    .expect("nobody stops it")
            };
            group.bench_function(format!("{name}{suffix}"), |b| pool.install(|| b.iter(merged)));
        }
    }
    group.finish();
}

criterion_group!(benches, warps, merges);
criterion_main!(benches);
