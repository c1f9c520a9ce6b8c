//! `fill`, and what the other commands make of it.

use std::fs;

use crate::common::gpu_rasteriser;
use crate::site::{PHOTOS, Site, stderr_of, stdout_of, whole_stacks};

#[test]
fn what_is_hidden_is_filled_told_exported_and_shown() {
    if gpu_rasteriser().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    let early = site.run("fill project").failure().code(1);
    assert!(stderr_of(&early).contains("quadratura build"), "it says what to do first");
    site.run("build project -q").success();
    let told = |word: &str| stdout_of(&site.run("info project").success()).contains(word);
    assert!(told("not filled"));

    let filled = site.json("fill project --json");
    for photo in filled["photos"].as_array().unwrap() {
        assert_eq!(photo["state"], "filled");
        assert!(photo["shares"]["hidden"].as_f64().unwrap() > 0.0, "the box hides a part of the wall");
        assert_eq!(photo["shares"]["empty"], 0.0);
    }
    assert_eq!(site.json("fill project --json")["photos"][0]["state"], "up to date");
    assert!(told("from photos") && !told("not filled"));
    assert_eq!(site.json("info project --json")["filling"][0]["state"], "filled");
    assert_eq!(whole_stacks(&site.project()), 2);
    let again = site.json("build project --json");
    assert_eq!(again["photos"][0]["state"], "up to date", "a filled stack is as good as any");

    site.run("export project --out layers --provenance").success();
    assert!(site.path("layers/left.png.provenance/legend.json").is_file());
    let covered = |words: &str| {
        let drawn = site.json(&format!("render project --cameras photos --out views --json {words}"));
        drawn.to_string()
    };
    assert!(!covered("").is_empty() && !covered("--unfilled").is_empty());
}

#[test]
fn an_object_that_is_left_out_is_kept_so_in_the_project_if_that_is_asked_for() {
    if gpu_rasteriser().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    site.run("build project -q").success();
    let wrong = site.run("fill project --without tower").failure().code(1);
    assert!(stderr_of(&wrong).contains("tower"));
    let note = stderr_of(&site.run("fill project --without wall --photo left").success());
    assert!(note.contains("--save-options"), "{note}");
    assert!(!fs::read_to_string(site.path("project/project.json")).unwrap().contains("without"));
    let stale = site.json("info project --json");
    assert_eq!(stale["filling"][0]["state"], "stale", "the project would fill it otherwise");
    site.run("fill project --without wall --save-options").success();
    assert!(fs::read_to_string(site.path("project/project.json")).unwrap().contains("\"wall\""));
    let kept = site.json("info project --json");
    assert_eq!(kept["filling"][1]["photo"], PHOTOS[1]);
    assert!(kept["filling"][1]["shares"]["empty"].as_f64().unwrap() > 0.0);
    assert_eq!(kept["filling"][1]["state"], "filled");
}
