//! The same cameras in COLMAP's, nerfstudio's and Bundler's format.

#![cfg(test)]

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use glam::{DMat3, DMat4, DQuat, DVec2, DVec3};
use serde_json::{Value, json};

use super::pose::CV_FROM_GL;
use super::*;
use quadratura_base::geometry::{Lens, Pinhole, Pose};
use quadratura_base::scene::synthetic::Rng;

/// A camera as all three formats can have it: square pixels, the principal point in the middle, k1 and k2.
pub(super) struct Taken {
    pub name: &'static str,
    pub size: [u32; 2],
    pub f: f64,
    pub k: [f64; 2],
    /// World to camera, x right, y down, z forward.
    pub pose: Pose,
}

fn turned(rng: &mut Rng) -> DMat3 {
    let mut part = || rng.between(-1.0, 1.0);
    DMat3::from_quat(DQuat::from_xyzw(part(), part(), part(), part()).normalize())
}

pub(super) fn scene(rng: &mut Rng) -> (Vec<Taken>, Vec<DVec3>) {
    let names = [("a.png", [64, 48]), ("nord/b.png", [48, 64]), ("nord/c d.png", [40, 40])];
    let taken = |(name, size): (&'static str, [u32; 2])| Taken {
        name,
        size,
        f: rng.between(40.0, 80.0),
        k: [rng.between(-0.1, 0.1), rng.between(-0.02, 0.02)],
        pose: Pose {
            rotation: turned(rng),
            translation: DVec3::new(rng.between(-3.0, 3.0), rng.between(-3.0, 3.0), rng.between(20.0, 30.0)),
        },
    };
    let taken: Vec<Taken> = names.into_iter().map(taken).collect();
    let points =
        (0..5).map(|_| DVec3::new(rng.between(-5.0, 5.0), rng.between(-5.0, 5.0), rng.between(-5.0, 5.0)));
    (taken, points.collect())
}

/// Where a camera shows a point, in pixels from the upper left corner.
fn pixel(camera: &Pinhole, lens: &Lens, pose: &Pose, point: DVec3) -> DVec2 {
    let seen = pose.camera_from_world(point);
    let bent = lens.distort(seen.truncate() / seen.z);
    DVec2::new(camera.fx * bent.x + camera.cx, camera.fy * bent.y + camera.cy)
}

fn colmap(folder: &Path, taken: &[Taken], points: &[DVec3]) {
    let mut cameras = String::new();
    let mut images = String::new();
    let mut list = String::new();
    for (id, it) in taken.iter().enumerate() {
        let ([w, h], [k1, k2], f) = (it.size, it.k, it.f);
        let (cx, cy) = (0.5 * f64::from(w), 0.5 * f64::from(h));
        writeln!(cameras, "{id} RADIAL {w} {h} {f:?} {cx:?} {cy:?} {k1:?} {k2:?}").unwrap();
        let (q, t) = (DQuat::from_mat3(&it.pose.rotation), it.pose.translation);
        write!(images, "{id} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {id} ", q.w, q.x, q.y, q.z, t.x, t.y, t.z)
            .unwrap();
        writeln!(images, "{}", it.name).unwrap();
        for (point, at) in points.iter().enumerate() {
            let (camera, lens) = (camera(it), lens(it));
            let at = pixel(&camera, &lens, &it.pose, *at);
            write!(images, "{:?} {:?} {point} ", at.x, at.y).unwrap();
        }
        images.push('\n');
    }
    for (id, p) in points.iter().enumerate() {
        writeln!(list, "{id} {:?} {:?} {:?} 0 0 0 0", p.x, p.y, p.z).unwrap();
    }
    for (name, text) in [("cameras.txt", cameras), ("images.txt", images), ("points3D.txt", list)] {
        fs::write(folder.join(name), text).unwrap();
    }
}

fn camera(it: &Taken) -> Pinhole {
    let [width, height] = it.size;
    let (cx, cy) = (0.5 * f64::from(width), 0.5 * f64::from(height));
    Pinhole { width, height, fx: it.f, fy: it.f, cx, cy }
}

fn lens(it: &Taken) -> Lens {
    Lens::Brown { k: [it.k[0], it.k[1], 0.0, 0.0, 0.0, 0.0], p: [0.0; 2] }
}

fn rows(matrix: DMat4) -> Value {
    json!(matrix.transpose().to_cols_array_2d())
}

/// Camera to world in OpenGL's axes, after the world was moved by `applied` and made `scale` times as large.
fn camera_to_world(pose: &Pose, applied: DMat4, scale: f64) -> DMat4 {
    let turn = DMat3::from_mat4(applied) * pose.rotation.transpose() * CV_FROM_GL;
    let centre = applied.transform_point3(pose.center_in_world()) * scale;
    DMat4::from_cols(
        turn.x_axis.extend(0.0),
        turn.y_axis.extend(0.0),
        turn.z_axis.extend(0.0),
        centre.extend(1.0),
    )
}

pub(super) fn transforms(taken: &[Taken], applied: DMat4, scale: f64) -> Value {
    let frame = |it: &Taken| {
        json!({
            "file_path": format!("./photos/{}", it.name),
            "w": it.size[0], "h": f64::from(it.size[1]), "fl_x": it.f, "fl_y": it.f,
            "k1": it.k[0], "k2": it.k[1], "p1": 0, "p2": 0.0,
            "transform_matrix": rows(camera_to_world(&it.pose, applied, scale)),
        })
    };
    let rows = rows(applied);
    json!({
        "camera_model": "OPENCV",
        "applied_transform": rows.as_array().unwrap()[..3],
        "applied_scale": scale,
        "ply_file_path": "sparse_pc.ply",
        "frames": taken.iter().map(frame).collect::<Vec<_>>(),
    })
}

/// Bundler's text and its list; the photo `missing` is not registered.
pub(super) fn bundler(taken: &[Taken], points: &[DVec3], missing: Option<usize>) -> [String; 2] {
    let mut text = format!("# Bundle file v0.3\n{} {}\n", taken.len(), points.len());
    for (index, it) in taken.iter().enumerate() {
        if missing == Some(index) {
            text.push_str(&"0 0 0\n".repeat(5));
            continue;
        }
        let (r, t) = ((CV_FROM_GL * it.pose.rotation).transpose(), CV_FROM_GL * it.pose.translation);
        writeln!(text, "{:?} {:?} {:?}", it.f, it.k[0], it.k[1]).unwrap();
        // The columns of the transpose are the rows.
        for row in [r.x_axis, r.y_axis, r.z_axis, t] {
            writeln!(text, "{:?} {:?} {:?}", row.x, row.y, row.z).unwrap();
        }
    }
    for point in points {
        writeln!(text, "{:?} {:?} {:?}\n10 20 30", point.x, point.y, point.z).unwrap();
        let seen = taken.iter().enumerate().filter(|(index, _)| missing != Some(*index));
        let views: Vec<String> = seen
            .map(|(index, it)| {
                // As Bundler's manual has it.
                let p = CV_FROM_GL * it.pose.camera_from_world(*point);
                let p = -p.truncate() / p.z;
                let r2 = p.length_squared();
                let at = it.f * (1.0 + it.k[0] * r2 + it.k[1] * r2 * r2) * p;
                format!("{index} 7 {:?} {:?}", at.x, at.y)
            })
            .collect();
        writeln!(text, "{} {}", views.len(), views.join(" ")).unwrap();
    }
    let list = taken.iter().map(|it| format!("photos/{} 0 523.5\n", it.name));
    [text, list.collect()]
}

/// A folder with photos of these sizes.
pub(super) fn with_photos(taken: &[Taken]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for it in taken {
        let file = folder.path().join("photos").join(it.name);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        image::RgbImage::new(it.size[0], it.size[1]).save(file).unwrap();
    }
    folder
}

pub(super) fn read(path: &Path) -> Result<Cameras> {
    read_cameras(path, &Task::silent())
}

pub(super) fn written(file: &str, text: &str) -> (tempfile::TempDir, Result<Cameras>) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(file);
    fs::write(&file, text).unwrap();
    let read = read(&file);
    (folder, read)
}

#[track_caller]
fn assert_same(a: &CameraPhoto, b: &CameraPhoto) {
    assert_eq!((&a.name, a.camera, a.lens), (&b.name, b.camera, b.lens));
    let apart = (a.pose.rotation - b.pose.rotation).to_cols_array();
    // Rotations pass through a quaternion, positions are some tens of units large.
    assert!(apart.iter().all(|v| v.abs() < 1e-14), "{apart:?}");
    assert!(a.pose.translation.distance(b.pose.translation) < 1e-12, "{a:?} {b:?}");
}

#[test]
fn a_scene_written_in_three_formats_is_the_same_site() {
    for seed in 0..20 {
        let mut rng = Rng::new(seed);
        let (taken, points) = scene(&mut rng);
        let folder = with_photos(&taken);
        colmap(folder.path(), &taken, &points);
        let moved = DMat4::from_mat3(turned(&mut rng));
        let moved = DMat4::from_translation(DVec3::new(1.0, -2.0, 3.0)) * moved;
        fs::write(folder.path().join("transforms.json"), transforms(&taken, moved, 0.25).to_string())
            .unwrap();
        let [out, list] = bundler(&taken, &points, None);
        fs::write(folder.path().join("bundle.out"), out).unwrap();
        fs::write(folder.path().join("list.txt"), list).unwrap();

        let of_colmap = read(folder.path()).unwrap();
        assert!(
            of_colmap
                .notes
                .iter()
                .any(|note| note.contains("instead of") && note.contains("transforms.json"))
        );
        let of_nerf = read(&folder.path().join("transforms.json")).unwrap();
        let of_bundler = read(&folder.path().join("bundle.out")).unwrap();
        for other in [&of_nerf, &of_bundler] {
            assert!(other.problems.is_empty(), "{:?}", other.problems);
            assert_eq!(other.photos.len(), taken.len());
            other.photos.iter().zip(&of_colmap.photos).for_each(|(a, b)| assert_same(a, b));
        }
        assert!(
            of_nerf.points.is_empty() && of_nerf.notes[0].contains("sparse_pc.ply"),
            "{:?}",
            of_nerf.notes
        );
        assert_eq!(of_bundler.points.len(), points.len());
        for (a, b) in of_bundler.points.iter().zip(&of_colmap.points) {
            assert_eq!(a.position, b.position);
            for (a, b) in a.observations.iter().zip(&b.observations) {
                // The formulas differ in the order of their operations alone.
                assert!(a.0 == b.0 && a.1.distance(b.1) < 1e-10, "{a:?} {b:?}");
            }
        }
    }
}

/// nerfstudio's own way from a pixel to the world: the ray through it in the camera's axes, turned by the matrix.
#[test]
fn a_ray_of_nerfstudios_lies_where_the_camera_shows_it() {
    let mut rng = Rng::new(5);
    let (taken, _) = scene(&mut rng);
    let it = &taken[1];
    let matrix = camera_to_world(&it.pose, DMat4::IDENTITY, 1.0);
    let mut text = transforms(&taken[1..2], DMat4::IDENTITY, 1.0);
    text["frames"][0]["fl_y"] = json!(2.0 * it.f);
    text["frames"][0]["cx"] = json!(20.0);
    text["frames"][0]["k1"] = json!(0.0);
    text["frames"][0]["k2"] = json!(null);
    let (_folder, read) = written("cameras.json", &text.to_string());
    let read = read.unwrap();
    let photo = &read.photos[0];
    assert_eq!((photo.name.as_str(), photo.place.as_str()), ("b.png", "frames[0]"));
    let at = DVec2::new(11.0, 37.0);
    let in_camera = DVec3::new((at.x - 20.0) / it.f, -(at.y - 32.0) / (2.0 * it.f), -1.0);
    let point = matrix.transform_point3(in_camera * 7.0);
    assert!(pixel(&photo.camera, &photo.lens, &photo.pose, point).distance(at) < 1e-10);
}

#[test]
fn old_files_have_an_angle_and_the_photos_tell_their_size() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("train")).unwrap();
    image::RgbImage::new(80, 60).save(folder.path().join("train/r_0.png")).unwrap();
    let identity = rows(DMat4::IDENTITY);
    let text = json!({
        "camera_angle_x": std::f64::consts::FRAC_PI_2,
        "frames": [{"file_path": "./train/r_0", "transform_matrix": identity},
                   {"file_path": "./train/r_1", "transform_matrix": identity}],
    });
    let file = folder.path().join("transforms_train.json");
    fs::write(&file, text.to_string()).unwrap();
    let by_itself = read(folder.path()).unwrap();
    let photo = &by_itself.photos[0];
    // Half of 80 over the tangent of 45 degrees.
    let expected =
        Pinhole { width: 80, height: 60, fx: photo.camera.fx, fy: photo.camera.fx, cx: 40.0, cy: 30.0 };
    assert_eq!((photo.name.as_str(), photo.camera), ("r_0.png", expected));
    assert!((photo.camera.fx - 40.0).abs() < 1e-12);
    assert_eq!(photo.pose.rotation, CV_FROM_GL);
    let problem = by_itself.problems[0].to_string();
    assert!(
        problem.contains("frames[1]") && problem.contains("r_1.png") && problem.contains("not there"),
        "{problem}"
    );
    // The names are known without any photo, and sizes come from another folder.
    let names = read_names(&file, &Task::silent()).unwrap();
    assert_eq!((names.names, names.problems.len()), (vec!["r_0.png".into(), "r_1.png".into()], 0));
    let elsewhere = tempfile::tempdir().unwrap();
    image::RgbImage::new(20, 10).save(elsewhere.path().join("r_1.jpg")).unwrap();
    let of_folder = read_cameras_of(elsewhere.path(), &file, &Task::silent()).unwrap();
    assert_eq!((of_folder.photos[0].name.as_str(), of_folder.photos[0].camera.fx.round()), ("r_1.png", 10.0));
    assert!(of_folder.problems[0].to_string().contains("there is no such photo"), "{:?}", of_folder.problems);
}

#[test]
fn a_photo_that_was_not_registered_is_noted_and_its_observations_go_with_it() {
    let (taken, points) = scene(&mut Rng::new(4));
    let folder = with_photos(&taken);
    let [out, list] = bundler(&taken, &points, Some(1));
    fs::create_dir_all(folder.path().join("bundle")).unwrap();
    fs::write(folder.path().join("bundle/bundle.out"), out.replace("3 5\n", "3 5\r\n")).unwrap();
    // The list stands where Bundler was run, above its folder.
    fs::write(folder.path().join("list.txt"), list.replace("photos/", "./photos/").replace(" 0 523.5", ""))
        .unwrap();
    let read = read(folder.path()).unwrap();
    let names: Vec<&str> = read.photos.iter().map(|photo| photo.name.as_str()).collect();
    assert_eq!(names, ["a.png", "nord/c d.png"]);
    assert!(read.notes[0].contains("1 of 3 photos are not registered"), "{:?}", read.notes);
    assert!(read.points.iter().all(|point| point.observations.iter().map(|it| it.0).eq([0, 1])));
}

#[test]
fn the_piazza_in_three_formats_has_the_same_cameras() {
    let piazza = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../projects/piazza");
    let truth = read(&piazza.join("sparse")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = |photo: &CameraPhoto| piazza.join("photos").join(&photo.name).display().to_string();
    let frame = |photo: &CameraPhoto| {
        let Pinhole { width, height, fx, fy, cx, cy } = photo.camera;
        json!({
            "file_path": path(photo), "w": width, "h": height, "fl_x": fx, "fl_y": fy, "cx": cx, "cy": cy,
            "transform_matrix": rows(camera_to_world(&photo.pose, DMat4::IDENTITY, 1.0)),
        })
    };
    let frames: Vec<Value> = truth.photos.iter().map(frame).collect();
    let file = folder.path().join("transforms.json");
    fs::write(&file, json!({ "frames": frames }).to_string()).unwrap();
    let of_nerf = read(&file).unwrap();
    assert_eq!((of_nerf.photos.len(), of_nerf.problems.len()), (truth.photos.len(), 0));
    let without_lens = |photo: &CameraPhoto| {
        assert!(photo.lens.is_none());
        CameraPhoto { lens: Lens::None, ..photo.clone() }
    };
    of_nerf
        .photos
        .iter()
        .zip(&truth.photos)
        .for_each(|(a, b)| assert_same(&without_lens(a), &without_lens(b)));

    // Bundler cannot say a principal point outside the middle: such photos are not registered there.
    let in_the_middle = |camera: &Pinhole| {
        [2.0 * camera.cx, 2.0 * camera.cy] == [f64::from(camera.width), f64::from(camera.height)]
    };
    let mut out = format!("# Bundle file v0.3\n{} {}\n", truth.photos.len(), truth.points.len());
    for photo in &truth.photos {
        if !in_the_middle(&photo.camera) {
            out.push_str(&"0 0 0\n".repeat(5));
            continue;
        }
        let (r, t) = ((CV_FROM_GL * photo.pose.rotation).transpose(), CV_FROM_GL * photo.pose.translation);
        writeln!(out, "{:?} 0 0", photo.camera.fx).unwrap();
        [r.x_axis, r.y_axis, r.z_axis, t]
            .iter()
            .for_each(|v| writeln!(out, "{:?} {:?} {:?}", v.x, v.y, v.z).unwrap());
    }
    for point in &truth.points {
        let (p, n) = (point.position, point.observations.len());
        writeln!(out, "{:?} {:?} {:?}\n0 0 0\n{n}", p.x, p.y, p.z).unwrap();
        for (photo, at) in &point.observations {
            let middle = truth.photos[*photo as usize].camera;
            let (x, y) = (at.x - 0.5 * f64::from(middle.width), 0.5 * f64::from(middle.height) - at.y);
            writeln!(out, "{photo} 0 {x:?} {y:?}").unwrap();
        }
    }
    fs::write(folder.path().join("bundle.out"), out).unwrap();
    let list: String = truth.photos.iter().map(|photo| path(photo) + "\n").collect();
    fs::write(folder.path().join("list.txt"), list).unwrap();
    let of_bundler = read(&folder.path().join("bundle.out")).unwrap();
    let middle: Vec<&CameraPhoto> =
        truth.photos.iter().filter(|photo| in_the_middle(&photo.camera)).collect();
    assert!(middle.len() >= 6 && middle.len() < truth.photos.len());
    assert_eq!((of_bundler.photos.len(), of_bundler.problems.len()), (middle.len(), 0));
    of_bundler.photos.iter().zip(middle).for_each(|(a, b)| assert_same(&without_lens(a), &without_lens(b)));
    assert_eq!(of_bundler.points.len(), truth.points.len());
}
