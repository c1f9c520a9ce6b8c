//! `decide` on the tiny site: a box before a wall, on a floor; a shed that nobody sees.

use std::fs;

use serde_json::Value;

use super::common::adapter;
use super::site::{Site, json_of, stderr_of, stdout_of};

fn project_file(site: &Site) -> String {
    fs::read_to_string(site.path("project/project.json")).unwrap()
}

fn layer_names(site: &Site) -> Vec<String> {
    let text = fs::read(site.path("project/stacks/left.png/stack.json")).unwrap();
    let stack: Value = serde_json::from_slice(&text).unwrap();
    let layers = stack["image_layers"].as_array().unwrap();
    layers.iter().map(|layer| layer["name"].as_str().unwrap().to_owned()).collect()
}

/// The states of both photos after another build.
fn built(site: &Site) -> Vec<String> {
    let built = site.json("build project --stacks-only --json");
    let photos = built["photos"].as_array().unwrap();
    photos.iter().map(|photo| photo["state"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn decisions_change_the_stack_of_their_photo_and_taking_them_back_brings_everything_back() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    let before = project_file(&site);
    built(&site);
    let names = layer_names(&site);
    assert_eq!(names.len(), 2, "wall and floor fit the same rectangle: {names:?}");

    let split = stdout_of(&site.run("decide project --photo left --split wall --from floor").success());
    assert!(split.contains("split of wall from floor") && split.contains("quadratura update"), "{split}");
    assert_eq!(built(&site), ["built", "up to date"], "only what changes");
    assert_eq!(layer_names(&site).len(), 3);
    site.run("decide project --photo left --forget 1 --merge wall floor").success();
    assert_eq!(built(&site), ["built", "up to date"]);
    assert_eq!(layer_names(&site), names, "they are together anyway");

    site.command("decide project --photo left --of wall --name").arg("Back wall").assert().success();
    assert_eq!(built(&site), ["up to date"; 2]);
    assert!(layer_names(&site).contains(&"Back wall".to_owned()));

    let listed = site.json("decide project --json");
    let texts: Vec<&str> =
        (0..2).map(|i| listed["photos"][0]["decisions"][i]["text"].as_str().unwrap()).collect();
    assert_eq!(texts[0], "merge of floor, wall");
    assert!(texts[1].starts_with("\"Back wall\" is the layer of"), "{texts:?}");
    assert_eq!(listed["changed"], false);

    site.run("decide project --photo left --forget 2 --forget 1").success();
    assert_eq!(project_file(&site), before);
    assert_eq!(built(&site), ["built", "up to date"]);
    assert_eq!(layer_names(&site), names);
}

#[test]
fn what_cannot_be_is_refused_with_the_reason_and_changes_nothing() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    built(&site);
    let before = project_file(&site);
    let refused = site.command("decide project --photo left --merge wall").arg("box 0").assert().failure();
    let message = stderr_of(&refused);
    assert!(message.contains("in left.png, box 0[0] lies in front of a part of wall[0] ("), "{message}");
    assert!(message.contains("decide project --list --photo left"), "{message}");
    let message = stderr_of(&site.run("decide project --photo left --pin shed").failure());
    assert!(message.contains("left.png does not texture shed: hidden by box 0[0]"), "{message}");
    let message = stderr_of(&site.run("decide project --photo left --exclude gate").failure());
    assert!(message.contains("there is no object or image layer \"gate\""), "{message}");
    assert_eq!(project_file(&site), before);
    site.run("decide project --merge wall floor").code(2);
    site.run("decide project --photo left --tolerance wide").code(2);
}

#[test]
fn the_layers_that_can_be_merged_are_listed() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    assert!(stdout_of(&site.run("decide project --list").success()).contains("no stack yet"));
    built(&site);
    site.run("decide project --photo left --split wall --from floor").success();
    built(&site);
    let before = project_file(&site);
    let listed = site.json("decide project --list --photo left --json");
    let layers = listed["layers"][0]["layers"].as_array().unwrap();
    assert_eq!(layers.len(), 3);
    let of = |name: &str| layers.iter().find(|layer| layer["name"] == name).unwrap();
    assert_eq!(of("floor")["with"], Value::Array(vec![]), "a split and the box are against it: {listed:#}");
    let text = stdout_of(&site.run("decide project --list --photo left").success());
    assert!(text.contains(of("box 0")["token"].as_str().unwrap()) && text.contains("none"), "{text}");
    assert_eq!(project_file(&site), before);
}

#[test]
fn excluded_and_pinned_faces_are_told_and_need_no_build() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    built(&site);
    site.run("decide project --photo left --exclude wall --pin floor").success();
    assert_eq!(built(&site), ["up to date"; 2]);
    let wall = site.json("info project --face wall[0] --json");
    assert_eq!(wall["photos"][0]["decided"], "excluded");
    assert_eq!(wall["photos"][1]["decided"], Value::Null);
    let floor = stdout_of(&site.run("info project --face floor[0]").success());
    assert!(floor.contains("pinned to this photo; in wall, floor"), "{floor}");
    let info = json_of(&site.run("info project --photo left --json").success());
    assert_eq!(info["untextured"]["by_photo"]["left.png"][1]["reason"], "excluded", "{info:#}");
    site.run("decide project --reset").success();
    assert!(!project_file(&site).contains("decisions"));
}
