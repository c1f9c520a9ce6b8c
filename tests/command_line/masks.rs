//! `mask` and `object`: what is no content of the photos, and what is not in the model.

use std::fs;
use std::path::Path;

use image::{GrayImage, Luma, RgbaImage};
use serde_json::Value;

use super::common::adapter;
use super::site::{PHOTOS, Site, json_of, stderr_of, stdout_of};

/// A stranger before the wall, in pixels of a photo: x, y, width, height.
const FOREIGN: [u32; 4] = [100, 20, 25, 40];

fn is_foreign(x: u32, y: u32) -> bool {
    let [left, top, w, h] = FOREIGN;
    (left..left + w).contains(&x) && (top..top + h).contains(&y)
}

/// A mask as COLMAP has it: black where the stranger is.
fn save_mask(file: &Path) {
    fs::create_dir_all(file.parent().unwrap()).unwrap();
    GrayImage::from_fn(160, 120, |x, y| Luma([if is_foreign(x, y) { 0 } else { 255 }])).save(file).unwrap();
}

fn project_file(site: &Site) -> String {
    fs::read_to_string(site.path("project/project.json")).unwrap()
}

/// The image layers of a photo: where each lies, what it shows, and what fills it.
fn layers(site: &Site, folder: &str) -> Vec<(i64, i64, RgbaImage, Option<RgbaImage>)> {
    let folder = site.path("project/stacks").join(folder);
    let stack: Value = serde_json::from_slice(&fs::read(folder.join("stack.json")).unwrap()).unwrap();
    let open = |file: &Value| image::open(folder.join(file.as_str()?)).ok().map(|picture| picture.to_rgba8());
    let layer = |layer: &Value| {
        let [x, y] = [0, 1].map(|i| layer["rect"][i].as_i64().unwrap());
        (x, y, open(&layer["file"]).unwrap(), open(&layer["filled_file"]))
    };
    stack["image_layers"].as_array().unwrap().iter().map(layer).collect()
}

/// The pixels of a photo that some layer shows.
fn shown(site: &Site, folder: &str) -> Vec<(u32, u32)> {
    let mut shown = Vec::new();
    for (x, y, picture, _) in layers(site, folder) {
        let opaque = picture.enumerate_pixels().filter(|(_, _, pixel)| pixel.0[3] > 0);
        shown.extend(opaque.map(|(u, v, _)| ((x + i64::from(u)) as u32, (y + i64::from(v)) as u32)));
    }
    shown
}

fn tree(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        match entry.is_dir() {
            true => files.extend(tree(&entry)),
            false => files.push((entry.display().to_string(), fs::read(&entry).unwrap())),
        }
    }
    files.sort();
    files
}

#[test]
fn what_is_masked_is_in_no_layer_is_filled_from_the_other_photo_and_comes_back() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    site.run("build project -q").success();
    let (before, other) = (project_file(&site), site.path("project/stacks/north%20side%2Ft%C3%BCr%202.png"));
    let stacks = [tree(&site.path("project/stacks/left.png")), tree(&other)];
    assert!(shown(&site, "left.png").iter().any(|(x, y)| is_foreign(*x, *y)));

    save_mask(&site.path("stranger.png"));
    let masked = site.json("mask project --photo left --add stranger.png --json");
    assert_eq!(masked["photos"][0]["pixels"], 25 * 40);
    assert_eq!(masked["changed"][0], "left.png");
    let state = |site: &Site| {
        let message = site.json("info project --json");
        [0, 1].map(|i| message["photos"][i]["state"].as_str().unwrap().to_owned())
    };
    assert_eq!(state(&site), ["stale", "current"]);
    let built = site.json("build project --json");
    assert_eq!([&built["photos"][0]["state"], &built["photos"][1]["state"]], ["built", "up to date"]);
    assert!(!shown(&site, "left.png").iter().any(|(x, y)| is_foreign(*x, *y)));
    assert!(tree(&other) == stacks[1], "the other photo is as it was");
    let info = stdout_of(&site.run("info project").success());
    assert!(info.contains("file stranger.png"), "{info}");

    site.run("fill project -q").success();
    let mut filled = 0;
    for (x, y, picture, filling) in layers(&site, "left.png") {
        let Some(filling) = filling else { continue };
        for (u, v, pixel) in filling.enumerate_pixels().filter(|(_, _, pixel)| pixel.0[3] > 0) {
            assert_eq!(picture.get_pixel(u, v).0[3], 0, "a filling covers nothing that is shown");
            let (x, y) = ((x + i64::from(u)) as u32, (y + i64::from(v)) as u32);
            filled += u64::from(is_foreign(x, y));
            assert!(pixel.0[3] == 255);
        }
    }
    assert!(filled >= 25 * 40, "every masked pixel is filled: {filled}");

    let cleared = site.json("mask project --clear --photo left.png --json");
    assert_eq!(cleared["photos"].as_array().unwrap().len(), 0);
    assert_eq!(project_file(&site), before, "every byte is back");
    assert!(!site.path("project/masks").exists());
    site.run("build project -q").success();
    let pictures = |files: Vec<(String, Vec<u8>)>| files.into_iter().map(|file| file.1).collect::<Vec<_>>();
    assert!(pictures(tree(&site.path("project/stacks/left.png"))) == pictures(stacks[0].clone()));
}

#[test]
fn after_a_mask_everything_estimated_from_the_photos_is_what_it_would_be_if_it_were_made_anew() {
    if adapter().is_none() {
        return;
    }
    let site = Site::with_photos(&["a.png", "b.png", "c.png", "d.png"], 160, 120, 1);
    site.make_project();
    let estimates = || {
        site.run("build project -q").success();
        let mut files = tree(&site.path("project/cache"));
        files.retain(|(name, _)| name.ends_with(".bin"));
        files
    };
    let before = estimates();
    assert!(
        ["relief.bin", "agreement.bin"]
            .iter()
            .all(|file| before.iter().any(|(name, _)| name.ends_with(file)))
    );
    save_mask(&site.path("stranger.png"));
    site.run("mask project --photo b --add stranger.png").success();
    let renewed = estimates();
    assert!(renewed != before, "the photo without the stranger tells something else");
    fs::remove_dir_all(site.path("project/cache")).unwrap();
    assert!(renewed == estimates());
}

#[test]
fn masks_beside_the_photos_are_found_by_new_and_later_by_name() {
    let site = Site::new();
    save_mask(&site.path("photos/left.mask.png"));
    save_mask(&site.path("masks").join(format!("{}.png", PHOTOS[1])));
    let new = site.run("new project --photos photos --cameras sparse --model model.obj").success();
    let message = stderr_of(&new);
    assert!(message.contains("masked by left.mask.png") && message.contains("../masks/"), "{message}");
    assert!(!message.contains("no camera for this photo"), "a mask is no photo: {message}");
    let listed = site.json("mask project --json");
    assert_eq!(listed["photos"].as_array().unwrap().len(), 2);
    assert!((listed["photos"][0]["share"].as_f64().unwrap() - 1000.0 / 19200.0).abs() < 1e-9);

    // One that was changed since is read again, and one that came later is found.
    GrayImage::from_pixel(160, 120, Luma([255])).save(site.path("photos/left.mask.png")).unwrap();
    save_mask(&site.path("photos/left_mask.png"));
    let found = site.json("mask project --find --photo left --json");
    assert_eq!(found["changed"].as_array().unwrap().len(), 1);
    let makers: Vec<_> = found["photos"][0]["masks"].as_array().unwrap().iter().map(|m| &m["from"]).collect();
    assert_eq!(makers, ["file left_mask.png"]);
}

#[test]
fn a_mask_that_cannot_be_right_is_refused_with_a_remedy() {
    let site = Site::new();
    site.make_project();
    let before = project_file(&site);
    GrayImage::new(80, 60).save(site.path("small.png")).unwrap();
    GrayImage::new(160, 120).save(site.path("black.png")).unwrap();
    let message = |words: &str| stderr_of(&site.run(words).failure().code(1));
    assert!(message("mask project --photo left --add small.png").contains("80 x 60"));
    assert!(message("mask project --photo left --add black.png").contains("the whole photo"));
    assert!(message("mask project --photo nobody --add black.png").contains("nobody"));
    assert!(message("mask project --object tower").contains("tower"));
    assert!(message("mask project --clear --photo left").contains("has no mask"));
    site.run("mask project --add black.png").failure().code(2);
    assert_eq!(project_file(&site), before);

    save_mask(&site.path("stranger.png"));
    site.run("mask project --photo left --add stranger.png").success();
    let folder = fs::read_dir(site.path("project/masks/left.png")).unwrap().next().unwrap().unwrap().path();
    fs::remove_file(folder).unwrap();
    let lost = stderr_of(&site.run("info project").failure().code(1));
    assert!(lost.contains("left.png is left out") && lost.contains("mask project --clear"), "{lost}");
    site.run("mask project --photo left --add stranger.png").success();
    site.run("info project").success();
}

#[test]
fn a_mask_beside_a_photo_that_cannot_be_read_keeps_the_photo_out_until_it_can() {
    let site = Site::new();
    GrayImage::new(80, 60).save(site.path("photos/left.mask.png")).unwrap();
    let new = "new project --photos photos --cameras sparse --model model.obj";
    let is_told = |words: &str| {
        let told = stderr_of(&site.run(words).failure().code(1));
        assert!(told.contains("left.png is left out") && told.contains("mask project --find"), "{told}");
        told
    };
    let told = is_told(new);
    assert!(told.contains("80 x 60") && told.matches("80 x 60").count() == 1, "once: {told}");
    is_told("info project");
    is_told("mask project");
    let listed = json_of(&site.run("info project --json").code(1));
    let states: Vec<&Value> = listed["photos"].as_array().unwrap().iter().map(|it| &it["state"]).collect();
    assert_eq!(states.iter().filter(|state| **state == "left out").count(), 1, "{listed:#}");

    // A file that is right again has to be read.
    fs::remove_file(site.path("photos/left.mask.png")).unwrap();
    save_mask(&site.path("photos/left.mask.png"));
    assert!(is_told("info project").contains("it can be now"));
    let found = site.json("mask project --find --json");
    assert_eq!((&found["changed"][0], &found["photos"][0]["pixels"]), (&"left.png".into(), &1000.into()));
    site.run("info project").success();
}

#[test]
fn masks_may_be_tiffs_and_names_that_are_nearly_the_same_are_told_apart() {
    let site = Site::with_photos(&["a.png", "A.png"], 160, 120, 1);
    fs::create_dir_all(site.path("photos/masks")).unwrap();
    save_mask(&site.path("photos/masks/A.png.tif"));
    let told =
        stderr_of(&site.run("new project --photos photos --cameras sparse --model model.obj").success());
    assert!(told.contains("masked by masks/A.png.tif"), "{told}");
    assert!(told.contains("a.png: masks/A.png.tif is the mask of A.png"), "{told}");
    let masked = site.json("mask project --json");
    assert_eq!(masked["photos"].as_array().unwrap().len(), 1, "{masked:#}");

    // One that has neither name exactly masks both.
    fs::rename(site.path("photos/masks/A.png.tif"), site.path("photos/masks/a.PNG.tif")).unwrap();
    fs::remove_dir_all(site.path("project")).unwrap();
    let told =
        stderr_of(&site.run("new project --photos photos --cameras sparse --model model.obj").success());
    assert!(told.contains("masks A.png, too"), "{told}");
    assert_eq!(site.json("mask project --json")["photos"].as_array().unwrap().len(), 2);
}

#[test]
fn an_object_that_is_off_is_no_part_of_the_site_can_still_be_masked_and_comes_back() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    site.run("build project -q").success();
    let (before, stacks) = (project_file(&site), tree(&site.path("project/stacks")));
    let off = stdout_of(&site.run("object project --off box*").success());
    assert!(off.contains("mask project --object 'box*' --margin 24"), "{off}");
    site.run("object project --on box*").success();
    let off = site.json("object project --off box* --json");
    let named = |name: &str| {
        let objects = off["objects"].as_array().unwrap().clone();
        objects.into_iter().find(|object| object["object"] == name).unwrap()
    };
    assert_eq!((&named("box 0")["off"], &named("wall")["off"]), (&true.into(), &false.into()));
    assert_eq!(site.json("info project --json")["photos"][0]["state"], "stale");

    let bare = site.json("mask project --object box* --json");
    let look = stdout_of(&site.run("mask project --object box* --margin 2").success());
    assert!(look.contains("render project --cameras photos") && look.contains("--margin 24"), "{look}");
    let wide = site.json("mask project --object box* --margin 3 --json");
    let pixels = |message: &Value| message["photos"][0]["pixels"].as_u64().unwrap();
    assert!(pixels(&bare) > 100 && pixels(&wide) > pixels(&bare), "{bare:#}");
    assert_eq!(wide["photos"][0]["masks"].as_array().unwrap().len(), 1, "another margin is the same mask");
    let built = site.json("build project --json");
    assert_eq!(built["photos"][0]["stack"]["counts"]["faces"], 2, "wall and floor");
    let seen = shown(&site, "left.png").len() as u64;
    assert!(seen + pixels(&wide) <= 160 * 120);
    site.run("fill project --without box* -q").success();
    let message = stdout_of(&site.run("info project").success());
    assert!(message.contains("objects removed from the model: box 0"), "{message}");

    let on = stdout_of(&site.command("object project --on").arg("box 0").assert().success());
    assert!(on.contains("2 masks of \"box*\" remain") && on.contains("--clear='object:box*'"), "{on}");
    save_mask(&site.path("stranger.png"));
    site.run("mask project --photo left --add stranger.png -q").success();
    let none = stderr_of(&site.run("mask project --clear=suggested").failure().code(1));
    assert!(none.contains("no photo has a suggested mask"), "{none}");
    let other = stderr_of(&site.run("mask project --clear=object:tower --photo left").failure().code(1));
    assert!(other.contains("photo left has no mask of the object \"tower\""), "{other}");
    site.run("mask project --clear=box").failure().code(2);
    let rest = site.json("mask project --clear=object:box* --json");
    let origins: Vec<&Value> =
        rest["photos"].as_array().unwrap().iter().map(|it| &it["masks"][0]["from"]).collect();
    assert_eq!(origins, ["file stranger.png"], "other masks stay");
    site.run("mask project --clear=files").success();
    assert_eq!(project_file(&site), before);
    site.run("build project -q").success();
    let pictures = |files: Vec<(String, Vec<u8>)>| files.into_iter().map(|file| file.1).collect::<Vec<_>>();
    assert!(pictures(tree(&site.path("project/stacks"))) == pictures(stacks));
    let message = stderr_of(&site.run("object project --off tower --off *").failure().code(1));
    assert!(message.contains("tower"), "{message}");
}

#[test]
fn what_stands_in_one_photo_alone_is_suggested_drawn_and_masked_when_it_is_accepted() {
    // The stranger stands before the wall and before the edge of the box: from some places the box hides that wall.
    let names = ["a.png", "b.png", "c.png", "d.png", "e.png", "f.png"];
    let site = Site::with_photos(&names, 640, 480, 1);
    for name in names {
        let grey = |x, y| if name == "b.png" && is_foreign(x / 4, y / 4) { 20 } else { 150 };
        let photo = image::RgbImage::from_fn(640, 480, |x, y| image::Rgb([grey(x, y); 3]));
        photo.save(site.path("photos").join(name)).unwrap();
    }
    site.make_project();
    let before = project_file(&site);
    let early = stderr_of(&site.run("mask project --accept all").failure().code(1));
    assert!(early.contains("--suggest"), "{early}");

    let message = site.json("mask project --suggest --json");
    let found = message["suggestions"].as_array().unwrap();
    assert!(found.len() == 1 && found[0]["photo"] == "b.png", "{message:#}");
    assert!(site.path("project/cache/suggestions/b.png.jpg").is_file());
    assert_eq!(project_file(&site), before, "suggesting masks nothing");
    let text = stdout_of(&site.run("mask project --suggest").success());
    assert!(text.contains("suggestion") && text.contains("--accept"), "{text}");

    let wrong = stderr_of(&site.run("mask project --accept 1,7").failure().code(1));
    assert!(wrong.contains("no suggestion 7"), "{wrong}");
    site.run("mask project --accept one").failure().code(2);
    let masked = site.json("mask project --accept all --json");
    assert_eq!(masked["photos"][0]["masks"][0]["from"], "suggested");
    let pixels = masked["photos"][0]["pixels"].as_u64().unwrap();
    let [.., width, height] = FOREIGN.map(|side| u64::from(4 * side));
    // With a margin of 6 pixels, and reduced pixels of two.
    assert!((width * height..=(width + 16) * (height + 16)).contains(&pixels), "{pixels}");
    let again = site.json("mask project --suggest --json");
    let left = again["suggestions"].as_array().unwrap().len();
    assert!(left < found.len(), "what is masked is not found again: {again:#}");
}
