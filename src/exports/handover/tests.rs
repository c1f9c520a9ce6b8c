//! Exports to other programs, read back or taken as these programs take them.

use std::fs;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use serde_json::Value;

use super::baked::options::BakedOptions;
use super::{HandedOver, HandoverFormat, HandoverOptions, hand_over};
use quadratura_base::error::Result;
use quadratura_base::scene::Photo;
use quadratura_base::scene::Samples;
use quadratura_base::task::Task;
use quadratura_editing::import::{ImportOptions, Imported, import_once};
use quadratura_import::cameras::read_cameras;
use quadratura_layered_files::Raster;
use quadratura_layered_files::png::{read_rgba, write_rgba};
use quadratura_layers::device::SiteDevice;
use quadratura_sites::open::{Opened, open};
use quadratura_stacks::tiny_site::{tiny_project, tiny_site, tiny_stacks};

/// Poses in text files have all digits of their numbers; quaternions are computed and normalised.
const READ_BACK: f64 = 1e-9;

fn exported(project: &Path, opened: &Opened, out: &Path, format: HandoverFormat) -> HandedOver {
    let photos: Vec<&Photo> = opened.site.photos.iter().collect();
    let baked = BakedOptions::default();
    let options = HandoverOptions { format, photos_per_face: 8, baked, world: false, memory: 1 << 28 };
    let start = || -> Result<Box<dyn SiteDevice>> { panic!("these formats need no device") };
    hand_over(project, opened, &photos, out, &options, &start, &Task::silent()).unwrap()
}

fn json(file: &Path) -> Value {
    serde_json::from_slice(&fs::read(file).unwrap()).unwrap()
}

/// The numbers of a list, of lists too.
fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(numbers).collect(),
        other => vec![other.as_f64().unwrap()],
    }
}

#[test]
fn cameras_are_read_back_from_each_of_the_files_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let (project, opened) = tiny_project(folder.path()).unwrap();
    let out = folder.path().join("cameras");
    let done = exported(&project, &opened, &out, HandoverFormat::Cameras);
    assert_eq!(done.origin, [0.0; 3]);
    for file in ["sparse/0", "transforms.json"] {
        let cameras = read_cameras(&out.join(file), &Task::silent()).unwrap();
        assert_eq!(cameras.photos.len(), 2, "{file}");
        for (read, photo) in cameras.photos.iter().zip(&opened.site.photos) {
            assert_eq!((read.camera, read.is_pinhole()), (photo.camera, true), "{file}");
            let [a, b] = [&read.pose, &photo.pose].map(|pose| (pose.rotation, pose.translation));
            assert!(a.0.abs_diff_eq(b.0, READ_BACK) && a.1.abs_diff_eq(b.1, READ_BACK), "{file}");
        }
    }
    let plain = json(&out.join("cameras.json"));
    let camera = &plain["cameras"][1];
    assert_eq!((&camera["name"], &camera["file"]), (&"right.png".into(), &"../photos/right.png".into()));
    assert_eq!((numbers(&camera["C"]), numbers(&camera["t"])), (vec![1.5, 0.0, 0.0], vec![-1.5, 0.0, 0.0]));
    assert_eq!(numbers(&camera["K"]), [64.0, 0.0, 32.0, 0.0, 64.0, 24.0, 0.0, 0.0, 1.0]);
}

/// A site with a bent lens, whose points are observed where that lens shows them.
fn bent_site(folder: &Path) -> (PathBuf, Opened) {
    tiny_site(folder).unwrap();
    let sparse = folder.join("sparse");
    fs::write(sparse.join("cameras.txt"), "1 SIMPLE_RADIAL 64 48 64 32 24 -0.1\n").unwrap();
    let cameras = read_cameras(&sparse, &Task::silent()).unwrap();
    let points: Vec<DVec3> =
        (0..12).map(|i| DVec3::new(f64::from(i % 4) - 1.5, f64::from(i / 4) - 1.0, 12.0)).collect();
    let mut images = String::new();
    for (number, photo) in cameras.photos.iter().enumerate() {
        let t = photo.pose.translation;
        let seen = points.iter().enumerate().map(|(point, at)| {
            let px = photo.image_from_world(*at).unwrap();
            format!("{} {} {}", px.x, px.y, point + 1)
        });
        let seen: Vec<String> = seen.collect();
        images +=
            &format!("{} 1 0 0 0 {} {} {} 1 {}\n{}\n", number + 1, t.x, t.y, t.z, photo.name, seen.join(" "));
    }
    fs::write(sparse.join("images.txt"), images).unwrap();
    let listed = points
        .iter()
        .enumerate()
        .map(|(point, at)| format!("{} {} {} {} 9 9 9 0 1 {point} 2 {point}\n", point + 1, at.x, at.y, at.z));
    fs::write(sparse.join("points3D.txt"), listed.collect::<String>()).unwrap();
    let project = folder.join("project");
    let new = quadratura_sites::create::NewProject {
        photos: folder.join("photos"),
        cameras: sparse,
        model: folder.join("model.obj"),
        ..Default::default()
    };
    let opened = quadratura_sites::create::create_project(&project, &new, &Task::silent()).unwrap();
    (project, opened)
}

#[test]
fn photos_of_a_bent_lens_are_written_undistorted_with_their_observations() {
    let folder = tempfile::tempdir().unwrap();
    let (project, opened) = bent_site(folder.path());
    let out = folder.path().join("cameras");
    exported(&project, &opened, &out, HandoverFormat::Cameras);
    for (photo, name) in opened.site.photos.iter().zip(["left.png", "right.png"]) {
        let copy = fs::read(out.join("images").join(name)).unwrap();
        assert!(copy == fs::read(&photo.file).unwrap(), "{name} is the undistorted picture");
    }
    let cameras = read_cameras(&out.join("sparse/0"), &Task::silent()).unwrap();
    assert!(cameras.photos.iter().all(|photo| photo.is_pinhole()));
    assert_eq!(cameras.points.len(), 12);
    let reprojection = cameras.reprojection.expect("24 observations");
    // The undistortion of a position is iterated to a small part of a pixel.
    assert!(reprojection.median_px < 1e-3, "{}", reprojection.median_px);
}

#[test]
fn blenders_scene_refers_to_files_that_exist_and_projects_the_model_where_the_photos_show_it() {
    let folder = tempfile::tempdir().unwrap();
    let (project, opened) = tiny_stacks(folder.path()).unwrap();
    let out = folder.path().join("blender");
    let done = exported(&project, &opened, &out, HandoverFormat::Blender);
    let scene = json(&out.join("scene.json"));
    let layers = scene["layers"].as_array().unwrap();
    assert!(!layers.is_empty());
    for layer in layers {
        for file in ["file", "confidence"] {
            let file = layer[file].as_str().unwrap();
            assert!(out.join(file).is_file(), "{file}");
            assert!(file.contains(layer["token"].as_str().unwrap()), "files are named by token");
        }
        // The middle of the wall between the cameras, in each photo.
        let point = [0.2, 2.5, 12.0, 1.0];
        let rows: Vec<f64> = numbers(&layer["uv_from_world"])
            .chunks(4)
            .map(|row| (0..4).map(|i| row[i] * point[i]).sum())
            .collect();
        let uv = DVec2::new(rows[0], rows[1]) / rows[2];
        let file = out.join(layer["file"].as_str().unwrap());
        let stack = json(&file.parent().unwrap().join("stack.json"));
        let described = stack["image_layers"].as_array().unwrap();
        let described = described.iter().find(|it| it["id"] == layer["token"]).unwrap();
        let rect = numbers(&described["rect"]);
        let px = DVec2::new(rect[0], rect[1]) + uv * DVec2::new(rect[2], rect[3]);
        let photo = &opened.site.photos[layer["photo"].as_u64().unwrap() as usize];
        let expected =
            photo.camera.image_from_camera(photo.pose.camera_from_world(DVec3::new(0.2, 2.5, 12.0)));
        assert!(px.distance(expected.unwrap()) < 1e-9, "{px}");
    }
    let objects = scene["objects"].as_array().unwrap();
    let names: Vec<&str> = objects.iter().map(|object| object["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["wall", "box"]);
    let material = &scene["materials"][objects[0]["materials"][0].as_u64().unwrap() as usize];
    assert_eq!(material["uses"].as_array().unwrap().len(), 2, "both photos show the wall");
    assert!(done.left_out.iter().any(|what| what.starts_with("relief")), "{:?}", done.left_out);
}

#[test]
fn a_script_for_nuke_refers_to_files_that_exist_and_surfaces_are_where_the_model_has_them() {
    let folder = tempfile::tempdir().unwrap();
    let (project, opened) = tiny_stacks(folder.path()).unwrap();
    let out = folder.path().join("nuke");
    exported(&project, &opened, &out, HandoverFormat::Nuke);
    let script = fs::read_to_string(out.join("site.nk")).unwrap();
    let files: Vec<&str> =
        script.lines().filter_map(|line| line.trim().strip_prefix("file \"")?.strip_suffix('"')).collect();
    assert!(files.len() > 4, "{script}");
    for file in &files {
        assert!(out.join(file).is_file(), "{file}");
    }
    let is_on_model = |line: &str| {
        let at: Vec<f64> = line.split(' ').map(|number| number.parse().unwrap()).collect();
        // The wall is at depth 12, the box at 6.
        at[2] == 12.0 && at[0].abs() == 20.0 || at[2] == 6.0 && at[0].abs() == 1.0
    };
    for surfaces in files.iter().filter(|file| file.ends_with(".obj")) {
        let text = fs::read_to_string(out.join(surfaces)).unwrap();
        let mut corners = text.lines().filter_map(|line| line.strip_prefix("v "));
        assert!(corners.clone().count() >= 4 && corners.all(is_on_model), "{text}");
    }
}

#[test]
fn the_same_scene_gives_the_same_bytes_in_another_folder() {
    let folder = tempfile::tempdir().unwrap();
    let (project, opened) = tiny_stacks(folder.path()).unwrap();
    let content = |name: &str| {
        let out = folder.path().join(name);
        exported(&project, &opened, &out, HandoverFormat::Blender);
        ["scene.json", "scene.py", "handover.json"].map(|file| fs::read(out.join(file)).unwrap())
    };
    assert!(content("one") == content("two"));
}

/// Makes the middle of a picture red.
fn paint(file: &Path) {
    let size = imagesize(file);
    let raster = read_rgba(file, size[0], size[1]).unwrap();
    let Samples::U8(mut samples) = raster.samples().clone() else { panic!("8 bits") };
    for y in size[1] / 4..size[1] / 2 {
        for x in size[0] / 4..size[0] / 2 {
            let at = 4 * (y * size[0] + x) as usize;
            samples[at..at + 4].copy_from_slice(&[255, 0, 0, 255]);
        }
    }
    let painted = Raster::new(size[0], size[1], Samples::U8(samples));
    write_rgba(fs::File::create(file).unwrap(), &painted, None).unwrap();
}

fn imagesize(file: &Path) -> [u32; 2] {
    quadratura_import::photo::picture_size(file).unwrap()
}

#[test]
fn paint_on_a_scenes_layer_is_imported_and_the_next_export_refreshes_the_file_in_place() {
    let folder = tempfile::tempdir().unwrap();
    let (project, opened) = tiny_stacks(folder.path()).unwrap();
    let out = folder.path().join("blender");
    exported(&project, &opened, &out, HandoverFormat::Blender);
    let layers = out.join("layers/left.png.layers");
    let wall = json(&layers.join("stack.json"))["image_layers"].as_array().unwrap().last().unwrap().clone();
    let file = layers.join(wall["file"].as_str().unwrap());
    paint(&file);
    let painted = fs::read(&file).unwrap();
    // What is painted and not imported is kept, and the new layers are beside it.
    exported(&project, &opened, &out, HandoverFormat::Blender);
    assert!(fs::read(&file).unwrap() == painted && out.join("layers/left.png-2.layers").is_dir());
    fs::remove_dir_all(out.join("layers/left.png-2.layers")).unwrap();

    let Imported { changed, failed, files, .. } =
        import_once(&project, std::slice::from_ref(&layers), ImportOptions::default(), &Task::silent())
            .unwrap();
    assert!(changed > 0 && failed.is_empty(), "{failed:?} {files:?}");
    let opened = open(&project, &Task::silent()).unwrap();
    exported(&project, &opened, &out, HandoverFormat::Blender);
    assert!(!out.join("layers/left.png-2.layers").exists(), "it is in place");
    let [width, height] = imagesize(&file);
    let now = read_rgba(&file, width, height).unwrap();
    let Samples::U8(samples) = now.samples() else { panic!("8 bits") };
    let at = 4 * (height / 3 * width + width / 3) as usize;
    assert_eq!(samples[at..at + 4], [255, 0, 0, 255], "the paint is the project's now");
    assert!(project.join("inbox/left.png.layers").is_dir(), "what was painted is kept");
}
