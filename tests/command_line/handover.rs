//! Exports to other programs: what the command says, and what it refuses.

use std::fs;

use super::site::{Site, stderr_of, stdout_of};

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
