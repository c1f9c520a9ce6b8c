//! What goes wrong is said with its place, and the rest goes on.

use std::fs;

use quadratura::io::lock::ProjectLock;

use super::common::gpu_rasteriser;
use super::site::{PHOTOS, Site, json_of, stderr_of, whole_stacks};

#[test]
fn new_reports_all_that_is_wrong_at_once_and_leaves_nothing() {
    let site = Site::new();
    let failed =
        site.run("new project --photos pictures --cameras sparse --model model.fbx").failure().code(1);
    let told = stderr_of(&failed);
    assert!(told.contains("pictures") && told.contains("model.fbx"), "{told}");
    assert!(!site.project().exists());

    fs::write(site.path("sparse/cameras.txt"), "1 PINHOLE 160 120 nan 160 80 60\n").unwrap();
    fs::write(site.path("model.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    let failed = site.run("new project --photos photos --cameras sparse --model model.obj").failure().code(1);
    let told = stderr_of(&failed);
    assert!(told.contains("cameras.txt") && told.contains("line 1"), "{told}");
    assert!(told.contains("model.obj") && told.contains("line 2"), "{told}");
    assert!(!site.project().exists());
}

#[test]
fn new_refuses_a_folder_that_is_not_empty_and_leaves_it_alone() {
    let site = Site::new();
    fs::create_dir(site.project()).unwrap();
    fs::write(site.path("project/thesis.txt"), "mine").unwrap();
    let failed = site.run("new project --photos photos --cameras sparse --model model.obj").failure().code(1);
    assert!(stderr_of(&failed).contains("not empty (it holds thesis.txt)"));
    assert_eq!(fs::read_dir(site.project()).unwrap().count(), 1);
}

#[test]
fn a_folder_without_a_project_and_a_broken_project_are_named() {
    let site = Site::new();
    for command in ["check nowhere", "build nowhere", "info nowhere", "export nowhere --out out"] {
        let told = stderr_of(&site.run(command).failure().code(1));
        assert!(told.contains("nowhere") && told.contains("quadratura new"), "{told}");
        assert!(!site.path("nowhere").exists());
    }
    site.make_project();
    let file = site.path("project/project.json");
    let broken = fs::read_to_string(&file).unwrap().replace("\"margin\": 1", "\"margin\": one");
    fs::write(&file, broken).unwrap();
    let told = stderr_of(&site.run("info project").failure().code(1));
    assert!(told.contains("project.json, line 16 column 15"), "{told}");
}

#[test]
fn an_error_is_json_too_where_json_is_wanted() {
    let site = Site::new();
    let failed = json_of(&site.run("info nowhere --json").failure().code(1));
    assert!(failed["error"].as_str().unwrap().contains("nowhere"), "{failed}");
}

#[test]
fn a_missing_photo_is_a_failure_and_the_others_are_built() {
    if gpu_rasteriser().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    fs::remove_file(site.path("photos/left.png")).unwrap();
    let failed = site.run("build project --json").failure().code(1);
    assert!(stderr_of(&failed).contains("left.png"), "{}", stderr_of(&failed));
    let result = json_of(&failed);
    assert_eq!(result["photos"][0]["photo"], PHOTOS[1]);
    assert_eq!(result["photos"][0]["state"], "built");
    assert_eq!(result["problems"].as_array().unwrap().len(), 1);
    assert_eq!(whole_stacks(&site.project()), 1);
    // Who asks for the photo that is there gets it.
    site.command("build project --photo").arg("tür 2").assert().success();
}

#[test]
fn a_photo_that_breaks_off_in_the_middle_fails_alone() {
    if gpu_rasteriser().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    let file = site.path("photos/left.png");
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    let failed = site.run("build project --json").failure().code(1);
    assert!(stderr_of(&failed).contains("left.png"), "{}", stderr_of(&failed));
    assert_eq!(whole_stacks(&site.project()), 1);
    assert!(
        !fs::read_dir(site.path("project/stacks"))
            .unwrap()
            .any(|entry| { entry.unwrap().file_name().to_string_lossy().starts_with('+') })
    );
}

#[test]
fn a_photo_that_nobody_knows_is_refused_by_name() {
    let site = Site::new();
    site.make_project();
    let told = stderr_of(&site.run("info project --photo right.png").failure().code(1));
    assert!(told.contains("right.png"), "{told}");
    let told = stderr_of(&site.run("info project --face roof[0]").failure().code(1));
    assert!(told.contains("roof"), "{told}");
    let told = stderr_of(&site.run("info project --face wall[7]").failure().code(1));
    assert!(told.contains("1 face"), "{told}");
}

#[test]
fn exporting_what_was_not_built_says_what_to_do() {
    let site = Site::new();
    site.make_project();
    let told = stderr_of(&site.run("export project --out layers").failure().code(1));
    assert_eq!(told.matches("quadratura build").count(), 2, "once a photo: {told}");
}

#[test]
fn the_second_writer_is_told_who_the_first_is() {
    let site = Site::new();
    site.make_project();
    let _lock = ProjectLock::take(&site.project()).unwrap();
    let told = stderr_of(&site.run("build project").failure().code(1));
    assert!(told.contains(&format!("process {}", std::process::id())), "{told}");
    site.run("info project").success();
}
