//! What goes wrong with many photos: some are missing, cut short or of another size, the disk is full, a project is copied while it is
//! made, clocks run backwards.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant, SystemTime};

use super::common::adapter;
use super::site::{Site, json_of, program, stderr_of, stdout_of, whole_stacks};

const COUNT: usize = 13;

fn names() -> Vec<String> {
    (0..COUNT).map(|number| format!("{number:02}.png")).collect()
}

fn site() -> Site {
    let names = names();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    Site::with_photos(&names, 200, 150, 4)
}

/// Spoils one photo in each way that is frequent: it is missing, cut short, or of another size.
fn spoil(site: &Site) -> [&'static str; 3] {
    fs::remove_file(site.path("photos/02.png")).unwrap();
    let file = site.path("photos/05.png");
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    image::RgbImage::new(230, 150).save(site.path("photos/09.png")).unwrap();
    ["02.png", "05.png", "09.png"]
}

/// The files of a project's stacks with their bytes.
fn stacks(project: &Path) -> Vec<(String, Vec<u8>)> {
    fn add(folder: &Path, below: &Path, found: &mut Vec<(String, Vec<u8>)>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => add(&path, below, found),
                false => {
                    let name = path.strip_prefix(below).unwrap().to_string_lossy().into_owned();
                    found.push((name, fs::read(&path).unwrap()));
                }
            }
        }
    }
    let mut found = Vec::new();
    add(&project.join("stacks"), project, &mut found);
    found.sort();
    found
}

#[test]
fn photos_that_are_missing_cut_short_or_of_another_size_are_each_told_once_and_the_others_are_made() {
    if adapter().is_none() {
        return;
    }
    // Before the project is made: it has the others. What is in a file is seen when it is built.
    let new = site();
    let spoilt = spoil(&new);
    let made = new.run("new project --photos photos --cameras sparse --model model.obj").failure().code(1);
    for (photo, reason) in [(spoilt[0], "there is no file"), (spoilt[2], "230 x 150 pixels")] {
        let told: Vec<String> =
            stderr_of(&made).lines().filter(|line| line.contains(photo)).map(str::to_owned).collect();
        assert!(told.len() == 1 && told[0].contains(reason), "{photo}: {told:?}");
    }
    // And afterwards: every command says so, and does the rest.
    let site = site();
    site.make_project();
    spoil(&site);
    let failed = site.run("update project --json").failure().code(1);
    for photo in spoilt {
        // Notes say besides which estimates a photo that cannot be decoded has no part in.
        let said = stderr_of(&failed);
        let told = said.lines().filter(|line| line.starts_with("error: ") && line.contains(photo));
        assert_eq!(told.count(), 1, "{said}");
    }
    assert_eq!(json_of(&failed)["problems"].as_array().unwrap().len(), 3);
    assert_eq!(whole_stacks(&site.project()), COUNT - 3);
    let again = site.run("update project").failure().code(1);
    assert!(stdout_of(&again).contains("10 up to date"), "{}", stdout_of(&again));
}

#[cfg(unix)]
#[test]
fn where_nothing_more_can_be_written_photos_fail_one_by_one_and_the_next_update_makes_the_same_bytes() {
    if adapter().is_none() {
        return;
    }
    let [site, other] = [site(), site()];
    site.make_project();
    other.make_project();
    site.run("update project").success();
    // The system refuses all bytes of a file beyond a limit, in units of 512, as a full disk does. The limit is that of the middle
    // one of the layers' files, so that some photos can be written and others cannot.
    let mut sizes: Vec<usize> = stacks(&site.project()).iter().map(|(_, bytes)| bytes.len()).collect();
    sizes.sort_unstable();
    let blocks = sizes[sizes.len() * 19 / 20] / 512;
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" update project");
    let failed = Command::new("sh")
        .arg("-c")
        .arg(script)
        .arg(program())
        .current_dir(other.folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&failed.stderr).into_owned();
    assert_eq!(failed.status.code(), Some(1), "{said}");
    assert!(said.contains("could not write it"), "{said}");
    let left = fs::read_dir(other.path("project/stacks")).unwrap().flatten();
    let left = left.flat_map(|photo| fs::read_dir(photo.path()).into_iter().flatten().flatten());
    assert!(left.into_iter().all(|entry| !entry.file_name().to_string_lossy().starts_with("+new-")));
    other.run("update project").success();
    assert!(stacks(&other.project()) == stacks(&site.project()));
}

/// Copies a folder as people do, whatever changes meanwhile.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).into_iter().flatten().flatten() {
        let (path, to) = (entry.path(), to.join(entry.file_name()));
        match path.is_dir() {
            true => copy(&path, &to),
            false => drop(fs::copy(&path, &to)),
        }
    }
}

#[test]
fn a_project_that_is_copied_while_it_is_made_is_finished_from_the_copy_with_the_same_bytes() {
    if adapter().is_none() {
        return;
    }
    let site = site();
    site.make_project();
    let mut update = Command::new(program())
        .current_dir(site.folder.path())
        .args(["update", "project", "--quiet"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let started = Instant::now();
    let has_begun = || site.path("project/stacks/03.png/stack.json").is_file();
    while !has_begun() && started.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(1));
    }
    copy(&site.project(), &site.path("copy"));
    update.kill().unwrap();
    update.wait().unwrap();
    // Locks came with it; their holder is gone.
    let status = site.run("status copy").success();
    assert!(stdout_of(&status).contains("13 photos"), "{}", stdout_of(&status));
    site.run("update copy").success();
    site.run("update project").success();
    assert_eq!(whole_stacks(&site.path("copy")), COUNT);
    assert!(stacks(&site.path("copy")) == stacks(&site.project()));
}

#[test]
fn a_photo_that_changes_while_the_clock_is_set_back_is_noticed() {
    if adapter().is_none() {
        return;
    }
    let site = site();
    site.make_project();
    site.run("update project").success();
    // Other pixels in as many bytes would keep the size: this photo becomes a copy of another one, of an earlier time.
    fs::copy(site.path("photos/04.png"), site.path("photos/07.png")).unwrap();
    let mut pixels = image::open(site.path("photos/07.png")).unwrap().to_rgb8();
    pixels.put_pixel(3, 3, image::Rgb([9, 200, 30]));
    pixels.save(site.path("photos/07.png")).unwrap();
    let earlier = SystemTime::now() - Duration::from_secs(10 * 365 * 86400);
    File::options().write(true).open(site.path("photos/07.png")).unwrap().set_modified(earlier).unwrap();
    let result = json_of(&site.run("update project --json").success());
    let built: Vec<&str> = result["photos"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|photo| photo["stack"] == "built")
        .map(|photo| photo["photo"].as_str().unwrap())
        .collect();
    assert_eq!(built, ["07.png"]);
}

#[test]
fn the_stack_of_another_version_of_the_program_is_refused_by_its_version_and_made_again_only_on_request() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    site.run("update project").success();
    let file = site.path("project/stacks/left.png/stack.json");
    let text = fs::read_to_string(&file).unwrap();
    let newer =
        text.replacen("\"version\": 2", "\"version\": 3", 1).replacen("\"version\":2", "\"version\":3", 1);
    assert_ne!(newer, text);
    fs::write(&file, &newer).unwrap();
    let message = stderr_of(&site.run("export project --photo left --out layers").failure().code(1));
    assert!(message.contains("version 3, this program reads version 2"), "{message}");
    assert_eq!(fs::read_to_string(&file).unwrap(), newer, "what a newer program made stays");
}
