//! Names that nothing has, and other slips: one form of message, with what was probably meant.

use std::fs;

use crate::common::adapter;
use crate::site::{Site, json_of, stderr_of, stdout_of};

#[test]
fn a_name_with_a_slip_is_answered_with_the_nearest_one_wherever_it_is_typed() {
    let site = Site::new();
    site.make_project();
    for (command, answer) in [
        ("info project --photo lfet", "there is no photo \"lfet\"; the nearest name is \"left.png\""),
        ("fill project --photo lefd", "there is no photo \"lefd\"; the nearest name is \"left.png\""),
        (
            "fill project --propagate=lefd.png",
            "there is no photo \"lefd.png\"; the nearest name is \"left.png\"",
        ),
        ("info project --face wal[0]", "there is no object \"wal\"; the nearest name is \"wall\""),
        ("fill project --without wel*", "there is no object \"wel*\"; the nearest name is \"wall\""),
        ("object project --off flour", "there is no object \"flour\"; the nearest name is \"floor\""),
        ("mask project --object flour", "there is no object \"flour\"; the nearest name is \"floor\""),
        ("decide project --photo left --merge wall flor", "the nearest name is \"floor\""),
        ("render project --view gate --out out", "there is no saved view \"gate\"; there are none"),
    ] {
        let told = stderr_of(&site.run(command).failure().code(1));
        assert!(told.contains(answer), "{command}: {told}");
    }
}

#[test]
fn a_wrong_folder_of_photos_is_one_error_for_all_of_them() {
    let photos = ["a.png", "b.png", "c.png"];
    let site = Site::with_photos(&photos, 160, 120, 1);
    fs::create_dir(site.path("empty")).unwrap();
    let wrong = site.run("new project --photos empty --cameras sparse --model model.obj").failure().code(1);
    let told = stderr_of(&wrong);
    assert_eq!(told.matches("error:").count(), 1, "{told}");
    assert!(told.contains("3 files in") && told.contains("empty: there is no file of this name"), "{told}");
}

#[test]
fn a_name_is_that_of_one_layer() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    site.run("build project -q").success();
    site.command("decide project --photo left --split wall --from").arg("box 0").assert().success();
    site.run("build project -q").success();
    let both = site.command("decide project --photo left --name front --of wall").arg("box 0").assert();
    let told = stderr_of(&both.failure().code(1));
    assert!(told.contains("does not contain") && told.contains("merge them first"), "{told}");
    site.run("decide project --photo left --name front --of wall").success();
}

#[test]
fn a_change_of_one_object_is_shown_by_itself() {
    let site = Site::new();
    site.make_project();
    let off = stdout_of(&site.run("object project --off shed").success());
    assert!(off.contains("shed") && off.contains("removed") && !off.contains("wall"), "{off}");
    assert!(off.contains("quadratura update project"), "{off}");
    let all = stdout_of(&site.run("object project").success());
    assert!(all.contains("wall") && all.contains("1 removed from the model"), "{all}");
}

#[test]
fn a_camera_path_that_is_empty_or_cut_short_is_told_in_our_own_words() {
    let site = Site::new();
    site.make_project();
    for (text, answer) in [("", "the file is empty"), ("{\"version\": 1, \"key", "cut short")] {
        fs::write(site.path("path.json"), text).unwrap();
        let wrong = site.run("render project --cameras path.json --out out").failure().code(1);
        let told = stderr_of(&wrong);
        assert!(told.contains("path.json") && told.contains(answer) && !told.contains("EOF"), "{told}");
    }
}

#[test]
fn a_result_goes_to_a_file_as_json_beside_the_table() {
    let site = Site::new();
    site.make_project();
    let info = site.run("info project --json-file info.json").success();
    assert!(stdout_of(&info).contains("not built"), "the table");
    let json: serde_json::Value = serde_json::from_slice(&fs::read(site.path("info.json")).unwrap()).unwrap();
    assert_eq!(json, json_of(&site.run("info project --json").success()));
    assert_eq!(json["problems"], serde_json::json!([]));
}

#[cfg(unix)]
#[test]
fn a_result_is_written_into_a_pipe_and_through_a_link() {
    let site = Site::new();
    site.make_project();
    assert!(std::process::Command::new("mkfifo").arg(site.path("pipe")).status().unwrap().success());
    let pipe = site.path("pipe");
    let reader = std::thread::spawn(move || fs::read(pipe).unwrap());
    site.run("info project --json-file pipe").success();
    let json: serde_json::Value = serde_json::from_slice(&reader.join().unwrap()).unwrap();
    assert_eq!(json, json_of(&site.run("info project --json").success()));
    std::os::unix::fs::symlink("there.json", site.path("link.json")).unwrap();
    fs::write(site.path("there.json"), "old").unwrap();
    site.run("info project --json-file link.json").success();
    assert!(site.path("link.json").symlink_metadata().unwrap().is_symlink());
    assert_eq!(
        json,
        serde_json::from_slice::<serde_json::Value>(&fs::read(site.path("there.json")).unwrap()).unwrap()
    );
}

#[cfg(feature = "gui")]
#[test]
fn a_project_that_does_not_exist_is_named_before_the_display() {
    let site = Site::new();
    let wrong = site.command("edit nowhere").env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").assert();
    let told = stderr_of(&wrong.failure().code(1));
    assert!(told.contains("nowhere") && told.contains("quadratura new"), "{told}");
}

#[test]
fn names_of_a_mac_are_found_by_their_composed_form() {
    let (composed, decomposed) = ("porche_\u{e9}t\u{e9}", "porche_e\u{301}te\u{301}");
    let site = Site::with_photos(&["a.png", "b.png"], 160, 120, 1);
    let images = fs::read_to_string(site.path("sparse/images.txt")).unwrap();
    fs::write(site.path("sparse/images.txt"), images.replace("a.png", &format!("{composed}.png"))).unwrap();
    fs::rename(site.path("photos/a.png"), site.path(&format!("photos/{decomposed}.png"))).unwrap();
    let mask = format!("photos/{decomposed}.mask.png");
    image::GrayImage::from_fn(160, 120, |x, _| image::Luma([if x < 16 { 0 } else { 255 }]))
        .save(site.path(&mask))
        .unwrap();
    let created = site.run("new project --photos photos --cameras sparse --model model.obj").success();
    let told = stderr_of(&created);
    assert!(told.contains("the file was found under another Unicode form"), "{told}");
    assert!(told.contains("its mask was found under another Unicode form"), "{told}");
    let listed = site.json(&format!("info project --photo {decomposed} --json"));
    assert_eq!(listed["photos"].as_array().map(Vec::len), Some(1), "{listed}");
}
