//! Exports to other programs: what the command says, and what it refuses.

use std::fs;

use super::common::adapter;
use super::site::{PHOTOS, Site, stderr_of, stdout_of};

#[test]
fn cameras_are_exported_without_stacks_and_a_project_can_be_made_of_them() {
    let site = Site::new();
    site.make_project();
    let done = site.run("export project --format cameras --out cameras").success();
    assert!(stdout_of(&done).contains("files of 2 photos in cameras"), "{}", stdout_of(&done));
    for cameras in ["cameras/sparse/0", "cameras/transforms.json"] {
        let folder = format!("of-{}", cameras.len());
        let made = site
            .run(&format!("new {folder} --photos photos --cameras {cameras} --model model.obj"))
            .success();
        assert!(stdout_of(&made).contains("2 of 2"), "{cameras}");
    }
    let again = site.json("export project --format cameras --out cameras --photo left --json");
    assert_eq!((&again["photos"], &again["export"]["spared"]), (&1.into(), &serde_json::json!([])));
}

#[test]
fn a_changed_file_is_kept_and_the_folder_of_another_project_is_refused() {
    let site = Site::new();
    site.make_project();
    site.run("export project --format cameras --out cameras").success();
    fs::write(site.path("cameras/cameras.json"), "mine").unwrap();
    let kept = site.run("export project --format cameras --out cameras").success();
    assert!(
        stderr_of(&kept).contains("was changed since it was exported and is kept"),
        "{}",
        stderr_of(&kept)
    );
    assert_eq!(fs::read_to_string(site.path("cameras/cameras.json")).unwrap(), "mine");
    assert!(site.path("cameras/cameras-2.json").is_file());
    site.run("new other --photos photos --cameras sparse --model model.obj").success();
    let refused = stderr_of(&site.run("export other --format cameras --out cameras").failure());
    assert!(refused.contains("this folder holds an export of another project"), "{refused}");
    let own = stderr_of(&site.run("export project --format cameras --out project/stacks/x").failure());
    assert!(own.contains("this folder belongs to the project"), "{own}");
}

#[test]
fn folders_of_layers_follow_update_and_watch_and_those_that_are_gone_are_forgotten() {
    let Some(site) = Site::built() else { return };
    site.run("export project --format blender --out blender").success();
    site.run("export project --format exr --out exr --photo left").success();
    site.run("export project --format cameras --out cameras").success();
    let list = || fs::read_to_string(site.path("project/exports/handover/folders.json")).unwrap();
    assert!(
        list().contains("\"../blender\"") && list().contains("\"../exr\"") && !list().contains("cameras")
    );
    let picture = || fs::read(site.path("exr/left.png.exr")).unwrap();
    let before = picture();
    assert_eq!(&before[..4], [0x76, 0x2f, 0x31, 0x01], "the mark of OpenEXR");
    // Filling changes the stacks, so both folders are written again, once.
    let said = stderr_of(&site.run("update project").success());
    assert!(said.contains("blender is up to date") && said.contains("exr is up to date"), "{said}");
    let idle = stderr_of(&site.run("update project").success());
    assert!(!idle.contains("is up to date:"), "{idle}");
    // What is painted elsewhere is in them as soon as `watch` has imported it.
    site.run("export project --format folder --out layered --photo left").success();
    let layers = site.path("layered/left.png.layers");
    let is_layer = |file: &std::path::PathBuf| {
        file.file_name().is_some_and(|name| name.to_string_lossy().starts_with("order-"))
    };
    let files = fs::read_dir(&layers).unwrap().map(|entry| entry.unwrap().path());
    let largest = files.filter(is_layer).max_by_key(|file| fs::metadata(file).unwrap().len()).unwrap();
    let mut painted = image::open(&largest).unwrap().into_rgba8();
    painted.pixels_mut().take(400).for_each(|pixel| *pixel = image::Rgba([250, 0, 250, 255]));
    painted.save(&largest).unwrap();
    let filled = picture();
    let said = stderr_of(&site.run("watch project layered --once").success());
    assert!(said.contains("exr is up to date: 1 file"), "{said}");
    assert!(picture() != filled, "the paint is in it");
    fs::remove_dir_all(site.path("exr")).unwrap();
    let said = stderr_of(&site.run("update project").success());
    assert!(said.contains("exr is gone, and is no longer brought up to date"), "{said}");
    assert!(!list().contains("exr"), "{}", list());
}

/// The cameras of one photo as `transforms.json`, as programs for single photos write them: no points.
fn one_camera(name: &str) -> String {
    let frame = serde_json::json!({
        "file_path": format!("photos/{name}"), "fl_x": 160, "cx": 80, "cy": 60, "w": 160, "h": 120,
        "transform_matrix": [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]],
    });
    serde_json::json!({ "frames": [frame] }).to_string()
}

#[test]
fn a_site_of_one_photo_without_points_goes_out_to_every_program_without_a_filling() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    fs::write(site.path("transforms.json"), one_camera(PHOTOS[0])).unwrap();
    site.run("new project --photos photos --cameras transforms.json --model model.obj").success();
    let checked = site.run("check project");
    let said = format!("{}{}", stdout_of(&checked), stderr_of(&checked));
    assert!(said.contains("no sparse points") && said.contains("cannot be judged"), "{said}");
    site.run("build project").success();
    for format in ["blender", "cameras", "glb", "obj", "usd", "exr", "nuke"] {
        let done = site.json(&format!("export project --format {format} --out {format} --json"));
        assert!(!done["export"]["files"].as_array().unwrap().is_empty(), "{format}: {done}");
        assert_eq!(done["problems"], serde_json::json!([]), "{format}");
    }
}

#[test]
fn a_photo_that_cannot_be_read_is_a_problem_and_the_other_is_exported() {
    let Some(site) = Site::built() else { return };
    fs::write(site.path("photos/left.png"), "no picture").unwrap();
    for format in ["exr", "nuke"] {
        let failed = site.run(&format!("export project --format {format} --out {format}")).code(1);
        assert!(stderr_of(&failed).contains("left.png"), "{format}: {}", stderr_of(&failed));
        let entries = fs::read_dir(site.path(format)).unwrap().count();
        assert!(entries > 1, "{format}: the other photo is there");
    }
}

#[test]
fn tiles_are_for_formats_that_have_them() {
    let site = Site::new();
    site.make_project();
    let refused = stderr_of(&site.run("export project --format glb --udim --out out").code(2));
    assert!(refused.contains("--udim does not apply to glb"), "{refused}");
    assert!(!site.path("out").exists());
}

#[test]
fn arguments_of_other_formats_are_refused() {
    let site = Site::new();
    site.make_project();
    for (given, meant) in [
        ("--format cameras --provenance", "psd, folder, ora and xcf"),
        ("--format cameras --blend", "blender"),
        ("--format psd --photos-per-face 3", "blender"),
        ("--format blender --photos-per-face 0", "a whole number from 1"),
    ] {
        let refused = site.run(&format!("export project {given} --out out")).code(2);
        assert!(stderr_of(&refused).contains(meant), "{given}: {}", stderr_of(&refused));
        assert!(!site.path("out").exists());
    }
    let unbuilt = stderr_of(&site.run("export project --format blender --out out").failure());
    assert!(unbuilt.contains("no photo has a stack yet"), "{unbuilt}");
}
