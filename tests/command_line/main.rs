//! The program as users and scripts meet it: in a fresh folder, by its words, its files and its exit
//! status.

mod baked;
mod cameras;
mod coarse;
mod colour;
#[path = "../common/mod.rs"]
mod common;
mod decide;
mod faults;
mod filling;
mod handover;
mod impostors;
mod large_site;
mod ldi;
mod ldi_shown;
mod masks;
mod mattes;
mod missing_photos;
mod names;
mod orthophotos;
mod see_through;
mod seen;
mod site;
mod stopped;
mod suggested;
mod texts;
mod tree;
mod tree_paint;
mod updating;
mod usage;
mod views;

use std::fs;

use common::adapter;
use site::{PHOTOS, Site, json_of, stderr_of, stdout_of, whole_stacks};

#[test]
fn a_site_becomes_a_project_stacks_and_files_for_an_editor() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    let new = site.run("new project --photos photos --cameras sparse --model model.obj").success();
    let text = stdout_of(&new);
    assert!(
        text.contains("2 of 2") && text.contains("160 x 120") && text.contains("4 faces in 4 objects"),
        "{text}"
    );
    assert!(text.contains("quadratura update project"), "it says what to do next: {text}");

    let built = site.json("build project --json");
    assert_eq!(built["photos"].as_array().unwrap().len(), 2);
    assert_eq!(built["photos"][0]["photo"], PHOTOS[0]);
    assert_eq!(built["photos"][0]["state"], "built");
    assert_eq!(built["photos"][0]["stack"]["counts"]["faces"], 3);
    assert_eq!(whole_stacks(&site.project()), 2);

    let exported = site.json("export project --out layers --json");
    assert_eq!(exported["photos"].as_array().unwrap().len(), 2);
    for name in ["left.png.psd", "north%20side%2Ft%C3%BCr%202.png.psd"] {
        assert!(site.path("layers").join(name).is_file(), "{name} in {exported:#}");
    }
}

#[test]
fn check_judges_the_site_and_draws_the_model_over_each_photo() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    let checked = stdout_of(&site.run("check project").success());
    assert!(
        checked.contains("The model is aligned with the photos") && checked.contains("4 faces:"),
        "{checked}"
    );
    assert!(checked.contains("1 not covered by any photo: shed[0]"), "{checked}");
    for picture in ["left.png.jpg", "north%20side%2Ft%C3%BCr%202.png.jpg"] {
        assert!(image::open(site.path("project/cache/check").join(picture)).is_ok(), "{picture}");
    }
    assert_eq!(site.json("check project --json")["report"]["verdict"], "fits");
}

#[test]
fn check_fails_on_a_model_that_misses_the_photos_and_offers_a_transform() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    // Turned to z-down, all of this lies behind the cameras.
    fs::write(site.path("model.obj"), "v -4 -3 9\nv -4 3 9\nv 4 3 9\nv 4 -3 9\nf 4 3 2 1\n").unwrap();
    let new = "new project --photos photos --cameras sparse --model model.obj --model-transform";
    site.run(&format!("{new} z-down")).success();
    let checked = site.run("check project").failure().code(1);
    let text = stdout_of(&checked);
    let offered =
        text.lines().find_map(|line| line.trim().strip_prefix("--model-transform ")).expect("an offer");
    fs::remove_dir_all(site.project()).unwrap();
    site.run(&format!("{new}={offered}").replace(" =", "=")).success();
    site.run("check project").success();
}

#[test]
fn check_fixes_the_alignment_in_the_project_and_restores_it() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    fs::write(site.path("model.obj"), "v -4 -3 9\nv -4 3 9\nv 4 3 9\nv 4 -3 9\nf 4 3 2 1\n").unwrap();
    site.run("new project --photos photos --cameras sparse --model model.obj --model-transform z-down")
        .success();
    let transform = |site: &Site| -> serde_json::Value {
        let project = fs::read(site.path("project/project.json")).unwrap();
        serde_json::from_slice::<serde_json::Value>(&project).unwrap()["world_from_model"].take()
    };
    let wrong = transform(&site);
    let text = stdout_of(&site.run("check project").failure().code(1));
    assert!(text.contains("`quadratura check project --fix` applies it"), "{text}");
    assert_eq!(transform(&site), wrong, "a check alone changes nothing");

    let text = stdout_of(&site.run("check project --fix").success());
    assert!(text.contains("The model is aligned with the photos"), "it is checked again: {text}");
    assert_ne!(transform(&site), wrong);
    let right = transform(&site);
    let restores = text.lines().find(|line| line.contains("restores it")).unwrap();
    let restore = restores.split('`').nth(1).unwrap().strip_prefix("quadratura ").unwrap();
    let again = site.json("check project --fix --json");
    assert_eq!((&again["fixed"], transform(&site)), (&serde_json::Value::Null, right), "it is right already");

    site.run(restore).failure().code(1);
    assert_eq!(transform(&site), wrong);
    let fixed = site.json("check project --fix --json");
    assert!(restore.ends_with(&format!("--fix={}", fixed["fixed"]["before"].as_str().unwrap())), "{fixed:#}");
    site.run("check project --fix=sideways").failure().code(2);
}

#[test]
fn check_aligns_the_model_by_corners_in_photos() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.run("new project --photos photos --cameras sparse --model model.obj --model-transform z-down")
        .success();
    // Two corners of the box and one of the shed in each photo, where the cameras show them.
    let pairs = "--pair -1.5,-1.5,6 left 40,20 --pair 2.1,2.1,6 left 136,116 --pair -1,-1,15 left 69.333,49.333 \
                 --pair 2.1,-1.5,6 2 109.333,20 --pair -1.5,2.1,6 2 13.333,116 --pair 1,1,15 2 80,70.667";
    let found = site.json(&format!("check project {pairs} --json"));
    let of = |value: &serde_json::Value| value.as_f64().unwrap();
    assert!(
        found["by_pairs"]["pairs"].as_array().unwrap().iter().all(|pair| of(&pair["residual_px"]) < 0.1),
        "{found:#}"
    );
    assert_eq!((&found["by_pairs"]["rough"], &found["fixed"]), (&false.into(), &serde_json::Value::Null));

    site.run(&format!("check project --fix {pairs}")).success();
    let project: serde_json::Value =
        serde_json::from_slice(&fs::read(site.path("project/project.json")).unwrap()).unwrap();
    for (i, row) in project["world_from_model"].as_array().unwrap().iter().enumerate() {
        for (j, number) in row.as_array().unwrap().iter().enumerate() {
            // Pixels are given to a thousandth: a ten-thousandth of fifteen metres.
            let right = if i == j { 1.0 } else { 0.0 };
            assert!((of(number) - right).abs() < 2e-3, "{project:#}");
        }
    }
    let refused = |words: &str| stderr_of(&site.run(&format!("check project {words}")).failure());
    assert!(refused("--pair 1,2 left 3,4").contains("\"1,2\" is not a corner of the model"));
    assert!(refused("--pair 1,2,3 left 3,4").contains("give three at least"));
    let outside = "--pair 1,2,3 left 3,4 --pair 1,2,3 left 3,4 --pair 1,2,3 left 161,4";
    assert!(refused(outside).contains("which has 160 x 120 pixels"));
    assert!(refused("--model-cameras sparse").contains("no 4 of their centres agree"));
    assert!(refused("--fix=0").contains("counted from 1"));
}

#[test]
fn info_says_why_a_face_has_no_texture_by_photo_and_by_face() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    let before = stdout_of(&site.run("info project").success());
    assert!(before.contains("not built"), "{before}");
    site.run("build project -q").success();

    let all = stdout_of(&site.run("info project").success());
    assert!(all.contains("built") && all.contains("1 face not textured by any photo"), "{all}");
    assert!(all.contains("shed[0]  hidden in 2"), "{all}");
    let one = stdout_of(&site.run("info project --photo left").success());
    assert!(one.contains("shed[0]  hidden by box 0[0] at pixel"), "{one}");
    let face = stdout_of(&site.run("info project --face wall[0]").success());
    assert_eq!(face.matches("in wall").count(), 2, "{face}");
    let object = stdout_of(&site.run("info project --face wall").success());
    assert!(object.contains("wall[0]  left.png, north side/tür 2.png"), "{object}");
    let hidden = site.json("info project --face shed --json");
    assert_eq!(
        hidden["faces"][0],
        serde_json::json!({
            "face": "shed[0]", "textured": [], "untextured": { "hidden": 2 }
        })
    );
    assert!(!all.contains("unmerged") && one.contains("unmerged"), "figures of the sort are asked for");

    let json = site.json("info project --json");
    assert_eq!(json["untextured"]["in_every_photo"][0]["object"], "shed");
    assert_eq!(json["untextured"]["numbers"][PHOTOS[1]]["hidden"], 1);
    assert_eq!(
        json["untextured"]["by_photo"],
        serde_json::json!({}),
        "faces are listed of photos that are named"
    );
    let json = site.json("info project --photo left --json");
    assert_eq!(json["untextured"]["by_photo"]["left.png"][0]["reason"], "hidden");
    let json = site.json("info project --face shed[0] --json");
    assert_eq!(json["photos"][0]["untextured"]["by"], "box 0[0]");
}

#[test]
fn build_does_again_only_what_changed() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    let states = |words: &str| {
        let rows = site.json(words)["photos"].take();
        [0, 1].map(|i| rows[i]["state"].as_str().unwrap().to_owned())
    };
    assert_eq!(states("build project --json"), ["built", "built"]);
    assert_eq!(states("build project --json"), ["up to date", "up to date"]);
    assert_eq!(states("build project --json --force"), ["built", "built"]);
    let mut photo = image::open(site.path("photos/left.png")).unwrap().to_rgb8();
    photo.put_pixel(80, 60, image::Rgb([1, 2, 3]));
    photo.save(site.path("photos/left.png")).unwrap();
    assert_eq!(states("info project --json"), ["stale", "current"]);
    assert_eq!(states("build project --json"), ["built", "up to date"]);
    fs::remove_dir_all(site.path("project/stacks")).unwrap();
    fs::remove_dir_all(site.path("project/cache")).unwrap();
    assert_eq!(states("build project --json"), ["built", "built"]);
}

#[test]
fn options_hold_once_unless_they_are_saved() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    let state = || site.json("info project --json")["photos"][0]["state"].as_str().unwrap().to_owned();
    let once = site.run("build project --margin 5 --boxes exact").success();
    assert!(stderr_of(&once).contains("--save-options"), "{}", stderr_of(&once));
    assert_eq!(state(), "stale");
    site.run("build project --margin 5 --boxes exact --save-options").success();
    assert_eq!(state(), "current");
    let project = fs::read_to_string(site.path("project/project.json")).unwrap();
    assert!(project.contains("\"margin\": 5") && project.contains("\"boxes\": \"exact\""), "{project}");
}

#[test]
fn the_published_method_builds_too_and_says_so() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    let built = site.json("build project --method stencil --published --photo left.png --json");
    assert_eq!(built["photos"].as_array().unwrap().len(), 1);
    assert_eq!(built["photos"][0]["stack"]["method"], "stencil");
}

#[test]
fn a_file_changed_by_hand_is_found_in_the_inbox_after_the_next_build() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    site.run("build project").success();
    let stack: serde_json::Value =
        serde_json::from_slice(&fs::read(site.path("project/stacks/left.png/stack.json")).unwrap()).unwrap();
    let layer = stack["image_layers"][0]["file"].as_str().unwrap();
    fs::write(site.path("project/stacks/left.png").join(layer), "painted").unwrap();

    let rebuilt = site.run("build project").success();
    let message = stderr_of(&rebuilt);
    assert!(message.contains("changed by hand") && message.contains("inbox"), "{message}");
    let kept = site.path("project/inbox/left.png").join(layer.rsplit('/').next().unwrap());
    assert_eq!(fs::read_to_string(kept).unwrap(), "painted");
    assert_eq!(whole_stacks(&site.project()), 2);
}

#[test]
fn a_photo_that_sees_nothing_of_the_model_shows_its_surroundings_alone() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    fs::write(site.path("model.obj"), "v -4 -3 -9\nv -4 3 -9\nv 4 3 -9\nf 3 2 1\n").unwrap();
    site.make_project();
    let built = site.json("build project --json");
    assert_eq!(built["photos"][0]["stack"]["image_layers"], 1);
    assert_eq!(built["photos"][0]["stack"]["counts"]["faces"], 0);
    assert_eq!(site.json("build project --json")["photos"][0]["state"], "up to date");
    let why = stdout_of(&site.run("info project --photo left.png").success());
    assert!(why.contains("model[0]  behind"), "{why}");
    site.run("build project --method stencil").success();
    site.run("export project --out layers").success();
}

#[test]
fn timings_are_a_table_for_people_and_numbers_for_programs() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    let message = stderr_of(&site.run("build project --timings -q --threads 2").success());
    assert!(
        message.contains("seconds") && message.contains("left.png") && message.contains("s elapsed"),
        "{message}"
    );
    let json = site.json("build project --timings --force --json -q");
    assert!(json["timings"]["wall_seconds"].as_f64().unwrap() > 0.0, "{json:#}");
    assert!(json["timings"]["seconds"]["left.png"].is_object(), "{json:#}");
}

#[test]
fn a_model_of_another_convention_is_turned_by_its_name() {
    let site = Site::new();
    let new =
        "new project --photos photos --cameras sparse --model model.obj --model-transform z-down --json";
    assert_eq!(json_of(&site.run(new).success())["faces"], 4);
    let project = fs::read_to_string(site.path("project/project.json")).unwrap();
    assert!(project.contains("[0.0, -1.0, 0.0, 0.0]"), "{project}");
}
