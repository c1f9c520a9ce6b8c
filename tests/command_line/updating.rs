//! `update`, and `fill` where stacks are missing.

use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use quadratura::testing::io::stack_readers::StackReader;

use crate::common::adapter;
use crate::site::{PHOTOS, Site, json_of, program, stderr_of, stdout_of, whole_stacks};

fn states(result: &serde_json::Value) -> Vec<(String, String, String)> {
    let word = |photo: &serde_json::Value, key: &str| photo[key].as_str().unwrap_or_default().to_owned();
    let photos = result["photos"].as_array().unwrap();
    photos.iter().map(|photo| (word(photo, "state"), word(photo, "stack"), word(photo, "filling"))).collect()
}

fn owned([state, stack, filling]: [&str; 3]) -> (String, String, String) {
    (state.into(), stack.into(), filling.into())
}

const MADE: [&str; 3] = ["up to date", "built", "filled"];
const KNOWN: [&str; 3] = ["up to date", "up to date", "up to date"];

#[test]
fn update_builds_and_fills_what_needs_it_and_says_when_there_is_nothing_to_do() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    let skipped = stdout_of(&site.run("update project --only-existing").success());
    assert_eq!(skipped, "nothing to do: 0 photos up to date, 2 never built and skipped\n");
    assert_eq!(states(&site.json("update project --photo left --json")), [owned(MADE)]);
    assert_eq!(whole_stacks(&site.project()), 1, "nobody asked for the other");
    let again = site.json("update project --json");
    assert_eq!(states(&again)[1], owned(MADE));
    assert_eq!(stdout_of(&site.run("update project").success()), "nothing to do: 2 photos up to date\n");
    assert_eq!(states(&site.json("update project --json")), [owned(KNOWN), owned(KNOWN)]);
    let info = site.json("info project --json");
    assert_eq!(
        (&info["photos"][1]["state"], &info["filling"][1]["state"]),
        (&"current".into(), &"filled".into())
    );
}

#[test]
fn update_goes_on_after_a_photo_that_fails() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    let file = site.path("photos/left.png");
    // Its end is there, so that the damage shows when its pixels are read.
    let mut bytes = fs::read(&file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle..middle + 64].fill(0);
    fs::write(&file, &bytes).unwrap();
    let failed = site.run("update project --json").failure().code(1);
    assert!(stderr_of(&failed).contains("left.png"), "{}", stderr_of(&failed));
    let result = json_of(&failed);
    assert_eq!(states(&result), [owned(["failed", "", ""]), owned(MADE)]);
    assert_eq!(result["problems"].as_array().unwrap().len(), 1);
    let reason = "cannot be decoded";
    assert_eq!(stderr_of(&failed).matches(reason).count(), 1, "{}", stderr_of(&failed));
}

#[test]
fn another_command_comes_between_two_photos_of_an_update() {
    if adapter().is_none() {
        return;
    }
    let photos = ["a.png", "b.png", "c.png", "d.png"];
    let site = Site::with_photos(&photos, 900, 700, 6);
    site.make_project();
    let mut update = Command::new(program())
        .current_dir(site.folder.path())
        .args(["update", "project", "--quiet", "--threads", "1"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let started = Instant::now();
    let has_begun = || site.path("project/stacks").join("a.png").join("stack.json").is_file();
    while !has_begun() && started.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(update.try_wait().unwrap().is_none(), "the update is over before anything comes between");
    let decided = site.run("decide project --photo b --margin 7");
    assert!(update.try_wait().unwrap().is_none(), "the command waited for the whole update");
    decided.success();
    let ended = update.wait_with_output().unwrap();
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let info = site.json("info project --json");
    for photo in 0..photos.len() {
        assert_eq!(info["photos"][photo]["state"], "current", "{info:#}");
        assert_eq!(info["filling"][photo]["state"], "filled", "{info:#}");
    }
}

#[test]
fn fill_builds_the_stacks_that_it_needs_and_says_which() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    let text = stdout_of(&site.run("fill project --photo left").success());
    assert!(text.contains("1 stack built first: left.png"), "{text}");
    assert_eq!(whole_stacks(&site.project()), 1);
    let filled = site.json("fill project --json");
    assert_eq!(filled["built"], serde_json::json!([PHOTOS[1]]));
    assert_eq!(filled["photos"].as_array().unwrap().len(), 2);
    let dry = site.run("fill project --dry-run").success();
    assert!(!stderr_of(&dry).contains("left out"), "{}", stderr_of(&dry));
}

/// Returns the number of versions of a photo's stack on disk.
fn versions(site: &Site) -> usize {
    let folder = site.path("project/stacks").join(PHOTOS[0]);
    fs::read_dir(folder).unwrap().filter(|entry| entry.as_ref().unwrap().path().is_dir()).count()
}

#[test]
fn a_stack_that_another_command_reads_stays_until_that_ends() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    site.run("update project --photo left").success();
    assert_eq!(versions(&site), 1);
    // As `render` and `score` do.
    let reader = StackReader::begin(&site.project());
    site.run("decide project --photo left --margin 5").success();
    site.run("update project --photo left").success();
    assert!(versions(&site) > 1, "the version that is read is there");
    drop(reader);
    site.run("update project --photo left").success();
    assert_eq!(versions(&site), 1);
}
