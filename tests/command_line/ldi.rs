//! `ldi build`, `ldi info` and `ldi render` on the tiny site.

use std::fs;

use super::common::gpu_rasteriser;
use super::site::{PHOTOS, Site, stderr_of, stdout_of};

#[test]
fn a_file_shows_its_own_photo_and_other_views_without_the_project() {
    let Some(site) = Site::built() else { return };
    let made = site.json("ldi build project --photo left --out left.ldi --json");
    let report = &made["images"][0]["report"];
    assert!(report["depth_complexity"].as_f64().unwrap() >= 1.0, "{made:#}");
    assert!(report["empty_needed"].as_u64().unwrap() > 0, "the box hides what nobody has filled: {made:#}");
    fs::rename(site.project(), site.path("moved")).unwrap();

    let info = site.json("ldi info left.ldi --json");
    assert_eq!((&info["kind"], &info["sources"][0]), (&"stack".into(), &PHOTOS[0].into()));
    let rendered = site.json("ldi render left.ldi --out own --splat pixel --json");
    assert_eq!(rendered["pictures"].as_array().unwrap().len(), 1);
    let [own, photo] = ["own/left.png", "photos/left.png"].map(|file| image::open(site.path(file)).unwrap());
    assert!(own.to_rgba8() == photo.to_rgba8(), "its own camera sees the photo");
    let aside = site.json("ldi render left.ldi --cameras sparse --out aside --size 80x60 --json");
    let pictures = aside["pictures"].as_array().unwrap();
    assert_eq!((pictures.len(), &pictures[1]["width"]), (2, &80.into()));
    assert!(pictures[1]["textured"].as_f64().unwrap() > 0.5, "{aside:#}");
}

#[test]
fn images_in_the_cache_are_kept_until_the_stack_or_the_options_change() {
    let Some(site) = Site::built() else { return };
    let kept = |words: &str| {
        let made = site.json(words);
        let images = made["images"].as_array().unwrap();
        images.iter().map(|image| image["up_to_date"].as_bool().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(kept("ldi build project --json"), [false, false]);
    assert_eq!(kept("ldi build project --json"), [true, true]);
    assert!(site.path("project/cache/ldi/left.png.ldi").is_file());
    assert_eq!(kept("ldi build project --photo left --flat --json"), [false]);
    let states = site.json("ldi info project --json");
    let state = |image: usize| states["images"][image]["state"].as_str().unwrap().to_owned();
    assert_eq!([state(0), state(1)], ["out of date", "up to date"]);
    // One that is damaged is made again.
    let file = site.path("project/cache/ldi/left.png.ldi");
    site.run("ldi build project --photo left").success();
    let mut bytes = fs::read(&file).unwrap();
    let last = bytes.len() / 2;
    bytes[last] ^= 1;
    fs::write(&file, bytes).unwrap();
    assert_eq!(kept("ldi build project --photo left --json"), [false]);
}

#[test]
fn a_file_of_somebody_else_stays_and_one_that_is_cut_short_is_shown_only_on_request() {
    let Some(site) = Site::built() else { return };
    fs::write(site.path("left.ldi"), "a letter").unwrap();
    let noted = stderr_of(&site.run("ldi build project --photo left --out left.ldi").success());
    assert!(noted.contains("left-2.ldi"), "{noted}");
    assert_eq!(fs::read_to_string(site.path("left.ldi")).unwrap(), "a letter");
    site.run("ldi build project --photo left --out left-2.ldi").success();
    assert!(!site.path("left-2-2.ldi").exists(), "an image of the same photo is replaced");

    let bytes = fs::read(site.path("left-2.ldi")).unwrap();
    let header = bytes.iter().position(|byte| *byte == b'\n').unwrap();
    fs::write(site.path("short.ldi"), &bytes[..header + (bytes.len() - header) / 2]).unwrap();
    let refused = stderr_of(&site.run("ldi render short.ldi --out views").failure().code(1));
    assert!(refused.contains("--partial"), "{refused}");
    let described = site.run("ldi info short.ldi").failure().code(1);
    assert!(stdout_of(&described).contains("whole rows"), "{}", stdout_of(&described));
    site.run("ldi render short.ldi --partial --out views").success();
    // Another image of the photo, with other options, has its own file and its own picture.
    site.run("ldi build project --photo left --flat --unfilled --background none --out left-2.ldi").success();
    assert!(site.path("left-2-2.ldi").is_file());
    let two = site.json("ldi render left-2.ldi left-2-2.ldi --out two --json");
    assert!(site.path("two/left.png").is_file() && site.path("two/left-2.png").is_file(), "{two:#}");
    // The others go on where one file cannot be read.
    let both = site.run("ldi render left.ldi left-2.ldi --out both").failure().code(1);
    assert!(site.path("both/left.png").is_file() && stderr_of(&both).contains("left.ldi"));
}

#[test]
fn a_photo_without_a_stack_is_named_and_one_file_cannot_hold_two_photos() {
    if gpu_rasteriser().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    site.run("build project --photo left").success();
    let built = site.run("ldi build project").failure().code(1);
    assert!(stderr_of(&built).contains(PHOTOS[1]), "{}", stderr_of(&built));
    assert!(site.path("project/cache/ldi/left.png.ldi").is_file(), "the other one is built");
    let both = stderr_of(&site.run("ldi build project --out both.ldi").failure().code(1));
    assert!(both.contains("--photo"), "{both}");
}
