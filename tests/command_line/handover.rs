//! Exports to other programs: what the command says, and what it refuses.

use std::fs;
use std::path::Path;
use std::process::Command;

use super::common::adapter;
use super::site::{PHOTOS, Site, program, stderr_of, stdout_of};

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
fn a_scene_that_was_changed_is_kept_and_the_new_one_is_beside_it() {
    let Some(site) = Site::built() else { return };
    site.run("export project --format blender --out blender").success();
    let scene = site.path("blender/scene.py");
    let mine = fs::read_to_string(&scene).unwrap() + "# mine\n";
    fs::write(&scene, &mine).unwrap();
    // The program's own refreshing keeps it as well.
    for command in ["export project --format blender --out blender", "update project"] {
        let kept = stderr_of(&site.run(command).success());
        assert!(kept.contains("scene.py was changed since it was exported and is kept"), "{command}: {kept}");
        assert_eq!(fs::read_to_string(&scene).unwrap(), mine);
    }
    let new = fs::read_to_string(site.path("blender/scene-2.py")).unwrap();
    assert_eq!(new + "# mine\n", mine);
}

#[cfg(unix)]
#[test]
fn on_a_full_disk_the_former_export_stays_as_it_was() {
    let Some(site) = Site::built() else { return };
    for format in ["cameras", "blender", "glb", "obj", "usd", "exr", "nuke"] {
        site.run(&format!("export project --format {format} --out {format}")).success();
        let before = contents(&site.path(format));
        // The system refuses all bytes of a file beyond 512, as a full disk does; what is there is whole already, so a new project
        // exports to a new folder as well.
        for out in [format.to_owned(), format!("new-{format}")] {
            let script = format!(
                "trap '' XFSZ; ulimit -f 0; exec \"$0\" export project --format {format} --out {out}"
            );
            let command = Command::new("sh")
                .args(["-c", &script])
                .arg(program())
                .current_dir(site.folder.path())
                .output();
            let failed = command.unwrap();
            let said = String::from_utf8_lossy(&failed.stderr);
            assert!(failed.status.code() == Some(1) && said.contains("could not"), "{out}: {said}");
            assert!(!said.contains("panicked"), "{said}");
        }
        assert!(contents(&site.path(format)) == before, "{format}");
    }
}

/// The files of a folder with their bytes, by name.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => found.extend(contents(&path)),
            false => found.push((path.display().to_string(), fs::read(&path).unwrap())),
        }
    }
    found.sort();
    found
}

#[test]
fn cameras_come_with_the_bookmarks_and_the_flight_in_the_sites_frame() {
    let site = Site::new();
    site.make_project();
    site.run("frame project --unit m --origin wall[0]:0").success();
    let file = site.path("project/project.json");
    let mut project: serde_json::Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
    project["views"] = serde_json::json!([{
        "name": "gate", "position": [1, 2, 3], "rotation": [1, 0, 0, 0], "focal": [1.5, 1.5], "pivot": [0, 0, 12]
    }]);
    let keyframe = |t: i32, x: i32| serde_json::json!({ "t": t, "position": [x, 0, 0], "look_at": [0, 0, 12], "fov": 55 });
    project["flight"] = serde_json::json!({
        "version": 1, "size": [96, 54], "fps": 10, "up": [0, -1, 0], "keyframes": [keyframe(0, 0), keyframe(1, 1)]
    });
    fs::write(&file, project.to_string()).unwrap();
    let json = |name: &str| -> serde_json::Value {
        serde_json::from_slice(&fs::read(site.path(name)).unwrap()).unwrap()
    };
    let placed = |arguments: &str| {
        site.run(&format!("export project --format cameras {arguments}")).success();
        let folder = arguments.split(' ').nth(1).unwrap();
        let view = &json(&format!("{folder}/cameras.json"))["views"][0];
        assert_eq!((view["name"].as_str(), view.get("file")), (Some("gate"), None));
        let keyframe = &json(&format!("{folder}/flight.json"))["keyframes"][1];
        [&view["C"], &keyframe["position"], &keyframe["look_at"]]
            .map(|point| [0, 1, 2].map(|axis| point[axis].as_f64().unwrap()))
    };
    let (framed, world) = (placed("--out framed"), placed("--out world --world"));
    // A corner of the wall is the origin.
    let corner = [20.0, -20.0, 12.0];
    assert_eq!(world, [[1.0, 2.0, 3.0], [1.0, 0.0, 0.0], [0.0, 0.0, 12.0]]);
    for (framed, world) in framed.iter().zip(world) {
        let off = [0, 1, 2].map(|axis| (framed[axis] + corner[axis] - world[axis]).abs());
        assert!(off.iter().all(|off| *off < 1e-9), "{framed:?}");
    }
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
