//! `watch`: a save in the image editor is all it takes.

use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use quadratura::task::Task;
use quadratura::testing::editing::import::{ImportOptions, Imported, LayerCache, history, import, take_back};
use quadratura::testing::editing::watch::{WatchOptions, watch};
use serde_json::Value;

use super::paper::Paper;
use super::site::program;
use super::{RED, SOFT, Studio, paint_the_wall};

fn start(studio: &Studio) -> Child {
    start_in(studio, "layers")
}

fn start_in(studio: &Studio, folder: &str) -> Child {
    let child = Command::new(program())
        .current_dir(studio.site.folder.path())
        .args(["watch", "project", folder, "--once", "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Until it looked at what is there: that is no save.
    std::thread::sleep(Duration::from_millis(700));
    child
}

/// What it told; fails where it does not end by itself.
fn ended(mut watch: Child) -> Value {
    let started = Instant::now();
    while watch.try_wait().unwrap().is_none() {
        if started.elapsed() > Duration::from_secs(60) {
            watch.kill().unwrap();
            panic!("nothing was imported");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let output = watch.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Paints a pixel of the wall and saves in some way.
fn saved_by(save: impl Fn(&Paper, &std::path::Path)) {
    let Some(studio) = Studio::new("psd") else { return };
    let watch = start(&studio);
    let mut paper = Paper::read(&studio.file());
    let (x, y) = paper.sheet("wall").pixels_where(true)[321];
    paper.sheet("wall").paint(x, y, RED);
    save(&paper, &studio.file());
    let message = ended(watch);
    assert_eq!(studio.paint(), [((x, y), RED)].into(), "{message:#}");
    assert_eq!(message["imports"].as_array().unwrap().last().unwrap()["changed"], 1);
}

#[test]
fn a_save_in_a_sub_folder_and_in_an_exported_folder_is_imported() {
    let Some(studio) = Studio::new("folder") else { return };
    let inner = studio.site.path("layers/of/monday");
    fs::create_dir_all(&inner).unwrap();
    fs::rename(studio.file(), inner.join("left")).unwrap();
    for (round, folder) in [(1, "layers"), (2, "layers/of/monday/left")] {
        let watch = start_in(&studio, folder);
        let mut paper = Paper::read(&inner.join("left"));
        let (x, y) = paper.sheet("wall").pixels_where(true)[100 * round];
        paper.sheet("wall").paint(x, y, RED);
        paper.write(&inner.join("left"));
        ended(watch);
        assert_eq!(studio.paint().len(), round);
    }
}

#[test]
fn a_second_save_looks_only_at_what_changed_and_brings_the_same() {
    for format in ["psd", "xcf", "ora", "folder"] {
        let Some(studio) = Studio::new(format) else { return };
        let recall = LayerCache::default();
        let project = studio.site.project();
        let import = || {
            let (files, options) = ([studio.file()], ImportOptions::default());
            import(&project, &files, options, &recall, &Task::silent()).unwrap()
        };
        let mut paper = Paper::read(&studio.file());
        let mut painted = paint_the_wall(&mut paper, [0, 0]);
        paper.write(&studio.file());
        assert_eq!(import().changed, painted.len() as u64);
        assert_eq!(import().changed, 0, "{format}");
        let (x, y) = paper.sheet("wall").pixels_where(true)[7];
        let blue = [0, 0, 65535, 65535];
        paper.sheet("wall").paint(x, y, blue);
        painted.insert((x, y), blue);
        paper.write(&studio.file());
        assert_eq!(import().changed, 1, "{format}");
        assert_eq!(studio.paint(), painted, "{format}");
    }
}

#[test]
fn a_save_over_the_file_is_imported() {
    saved_by(|paper, file| paper.write(file));
}

#[test]
fn a_save_by_rename_is_imported() {
    saved_by(|paper, file| {
        let temporary = file.with_file_name(".saving.tmp");
        paper.write(&temporary);
        fs::rename(&temporary, file).unwrap();
    });
}

#[test]
fn a_file_that_is_written_slowly_is_imported_when_it_is_complete() {
    saved_by(|paper, file| {
        let temporary = file.with_file_name(".whole.tmp");
        paper.write(&temporary);
        let bytes = fs::read(&temporary).unwrap();
        for share in 1..=6 {
            fs::write(file, &bytes[..bytes.len() * share / 6]).unwrap();
            std::thread::sleep(Duration::from_millis(250));
        }
    });
}

/// Watches for a while; `message` hears of imports.
fn watched(studio: &Studio, options: WatchOptions, mut message: impl FnMut(&Imported)) {
    let task = Task::silent();
    let stop = task.stop_flag();
    let (project, folder) = (studio.site.project(), studio.site.path("layers"));
    let since = Instant::now();
    let ender = std::thread::spawn(move || {
        std::thread::sleep(WATCHED);
        stop.store(true, std::sync::atomic::Ordering::Relaxed);
    });
    watch(&project, &folder, options, || Ok(()), &task, |imported, _| message(&imported)).unwrap();
    assert!(since.elapsed() >= WATCHED, "it ended by itself");
    ender.join().unwrap();
}

/// Long enough for several rounds on a busy machine.
const WATCHED: Duration = Duration::from_secs(4);

#[test]
fn a_save_that_nobody_saw_comes_home_at_the_next_watch_and_an_import_that_was_taken_back_does_not() {
    let Some(studio) = Studio::new("xcf") else { return };
    let project = studio.site.project();
    let mut paper = Paper::read(&studio.file());
    let places = paper.sheet("wall").pixels_where(true);
    paper.sheet("wall").paint(places[5].0, places[5].1, RED);
    paper.write(&studio.file());
    let mut numbers = Vec::new();
    watched(&studio, WatchOptions::default(), |imported| numbers.push(imported.number));
    assert_eq!(numbers, [Some(1)]);
    take_back(&project).unwrap();
    watched(&studio, WatchOptions::default(), |imported| panic!("{imported:?}"));
    assert!(studio.paint().is_empty());

    // Saved before the paint was written last, and never seen: as when the program is left while another import runs.
    let other = studio.file().with_file_name("other.xcf");
    paper.sheet("wall").paint(places[9].0, places[9].1, SOFT);
    paper.write(&other);
    let file = fs::File::options().append(true).open(&other).unwrap();
    file.set_modified(std::time::SystemTime::now() - Duration::from_secs(3600)).unwrap();
    let mut files = Vec::new();
    watched(&studio, WatchOptions::default(), |imported| {
        files.extend(imported.files.iter().map(|report| report.file.clone()));
    });
    assert_eq!(files, [other]);
    assert_eq!(studio.paint().len(), 2, "what the copy holds");
}

#[test]
fn what_was_imported_by_command_and_taken_back_does_not_come_home_by_itself() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let places = paper.sheet("wall").pixels_where(true);
    paper.sheet("wall").paint(places[5].0, places[5].1, RED);
    paper.write(&studio.file());
    assert_eq!(studio.import()["changed"], 1);
    studio.site.json("import project --undo --json");
    watched(&studio, WatchOptions::default(), |imported| panic!("{imported:?}"));
    assert!(studio.paint().is_empty());
    paper.sheet("wall").paint(places[9].0, places[9].1, SOFT);
    paper.write(&studio.file());
    let mut changed = Vec::new();
    watched(&studio, WatchOptions::default(), |imported| changed.push(imported.changed));
    assert_eq!(changed, [2], "the next save brings all that it holds");
}

#[test]
fn a_file_that_is_never_whole_is_taken_as_far_as_it_can_be_and_every_import_that_is_told_is_one_of_the_history()
 {
    let Some(studio) = Studio::new("folder") else { return };
    let (mut paper, mut other) = (Paper::read(&studio.file()), Paper::read(&studio.file()));
    let places = paper.sheet("wall").pixels_where(true);
    let whole = studio.file().with_file_name("whole.layers");
    super::copy_folder(&studio.file(), &whole);
    other.sheet("wall").paint(places[5].0, places[5].1, RED);
    other.write(&studio.file());
    let mut files = fs::read_dir(studio.file()).unwrap().map(|entry| entry.unwrap().path());
    let damaged = files.find(|file| file.to_string_lossy().contains("box") && file.is_file());
    fs::write(damaged.unwrap(), "no picture").unwrap();
    paper.sheet("wall").paint(places[9].0, places[9].1, SOFT);
    paper.write(&whole);
    let options = WatchOptions { patience: Duration::ZERO, ..WatchOptions::default() };
    let mut message = Vec::new();
    watched(&studio, options, |imported| {
        message.push(imported.number.unwrap());
        // Both are due in the next round: one anew, one for the last time.
        if message.len() == 1 {
            paper.sheet("wall").paint(places[13].0, places[13].1, SOFT);
            paper.write(&whole);
        }
    });
    let numbers: Vec<u32> =
        history(&studio.site.project()).unwrap().iter().map(|import| import.number).collect();
    assert_eq!(message, numbers);
    assert!(numbers.len() > 1, "{numbers:?}");
    let left = studio.paint();
    assert_eq!(left.len(), 3, "what can be read of the damaged one is there: {left:?}");
}
