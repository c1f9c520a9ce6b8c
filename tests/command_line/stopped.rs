//! Killed, or asked to stop: the project is whole at every moment.

use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::common::adapter;
use super::site::{Site, program, whole_stacks};

const PHOTOS: [&str; 6] = ["a.png", "b.png", "c.png", "d.png", "e.png", "f.png"];

fn site() -> Site {
    let site = Site::with_photos(&PHOTOS, 900, 700, 8);
    site.make_project();
    site
}

fn start_build(site: &Site) -> Child {
    Command::new(program())
        .current_dir(site.folder.path())
        .args(["build", "project", "--quiet", "--force"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Waits until the build writes, which is when a kill is worth anything.
fn wait_for_writing(site: &Site, build: &mut Child) {
    let started = Instant::now();
    let stacks = site.path("project/stacks");
    let writes = || {
        let photos = fs::read_dir(&stacks).into_iter().flatten().flatten();
        let mut names = photos.flat_map(|photo| fs::read_dir(photo.path()).into_iter().flatten().flatten());
        names.any(|entry| entry.file_name().to_string_lossy().starts_with("+new-"))
    };
    while !writes() && build.try_wait().unwrap().is_none() && started.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_micros(200));
    }
}

#[test]
fn a_killed_build_leaves_whole_stacks_and_the_next_one_finishes_the_work() {
    if adapter().is_none() {
        return;
    }
    let site = site();
    let mut killed = 0;
    for milliseconds in [0, 2, 5, 9, 15, 40, 90] {
        let mut build = start_build(&site);
        wait_for_writing(&site, &mut build);
        std::thread::sleep(Duration::from_millis(milliseconds));
        build.kill().unwrap();
        killed += usize::from(!build.wait().unwrap().success());
        whole_stacks(&site.project());
    }
    assert!(killed >= 3, "the builds end before they are killed; make the site larger");

    site.run("build project").success();
    assert_eq!(whole_stacks(&site.project()), PHOTOS.len());
    let mut left: Vec<_> = fs::read_dir(site.path("project/stacks"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    left.sort();
    assert_eq!(left, PHOTOS, "nothing is left over of the killed builds");
    assert!(!site.path("project/inbox").exists(), "nobody has changed anything");
    for photo in PHOTOS {
        let entries = fs::read_dir(site.path("project/stacks").join(photo)).unwrap().count();
        assert_eq!(entries, 2, "{photo}: stack.json and one version");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_stops_the_build_with_exit_status_130() {
    if adapter().is_none() {
        return;
    }
    let site = site();
    let mut build = start_build(&site);
    wait_for_writing(&site, &mut build);
    // The shell's own `kill`: a small system has no program of that name.
    let kill = format!("kill -INT {}", build.id());
    let interrupt = Command::new("sh").args(["-c", &kill]).status().unwrap();
    assert!(interrupt.success());
    let ended = build.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(130), "{}", String::from_utf8_lossy(&ended.stderr));
    whole_stacks(&site.project());
    site.run("build project").success();
    assert_eq!(whole_stacks(&site.project()), PHOTOS.len());
}

#[cfg(unix)]
#[test]
fn what_a_killed_export_left_is_cleared_by_the_next_one_and_nothing_else() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    site.run("build project -q").success();
    let layers = site.path("layers");
    fs::create_dir_all(layers.join(".quadratura-a1B2c3/guides")).unwrap();
    let names = [".quadratura-x7Y8z9.tmp", ".quadratura-mine.psd", "notes.tmp", ".quadratura-a1B2c3"];
    for name in names {
        let path = layers.join(name);
        let file = fs::File::open(&path).or_else(|_| fs::File::create(&path)).unwrap();
        file.set_modified(std::time::SystemTime::now() - Duration::from_secs(5)).unwrap();
    }
    site.run("export project --out layers").success();
    let left: Vec<bool> = names.iter().map(|name| layers.join(name).exists()).collect();
    assert_eq!(left, [false, true, true, false], "only what this program makes is cleared");
}
