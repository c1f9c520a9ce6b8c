//! Paint that is too coarse for another photo: it is named with what to do, and that helps.

use std::fs;

use serde_json::{Value, json};

use super::common::adapter;
use super::site::{Site, stdout_of};

/// Paints all that a photo shows of the wall, and of the floor in the same layer.
fn paint_the_whole_wall(site: &Site, folder: &str) {
    let layers = fs::read_dir(site.path(folder)).unwrap().map(|entry| entry.unwrap().path());
    let wall = layers.into_iter().find(|path| path.to_string_lossy().contains(" wall")).unwrap();
    let mut picture = image::open(&wall).unwrap().into_rgba8();
    let shown = picture.pixels_mut().filter(|pixel| pixel[3] > 0);
    shown.for_each(|pixel| *pixel = image::Rgba([250, 240, 10, 255]));
    picture.save(&wall).unwrap();
}

fn named(report: &Value) -> Vec<[&str; 3]> {
    let list = report["too_coarse"].as_array().unwrap();
    list.iter().map(|paint| ["photo", "face", "from"].map(|key| paint[key].as_str().unwrap())).collect()
}

/// The site with a photo from near and one from more than twice as far: the wall is at depth 12 from near, and at 28 from
/// far.
fn near_and_far() -> Site {
    let site = Site::with_photos(&["far.png", "near.png"], 160, 120, 1);
    let poses = "1 1 0 0 0 0 0 16 1 far.png\n\n2 1 0 0 0 0 0 0 1 near.png\n\n";
    fs::write(site.path("sparse/images.txt"), poses).unwrap();
    site.make_project();
    site
}

#[test]
fn import_and_update_name_the_photo_that_keeps_its_pixels_and_masked_pixels_take_the_paint() {
    if adapter().is_none() {
        return;
    }
    let site = near_and_far();
    site.run("update project -q").success();
    site.run("export project --out layers --format folder -q --photo far").success();
    paint_the_whole_wall(&site, "layers/far.png.layers");

    let imported = site.json("import project layers/far.png.layers --json");
    let expected = ["wall[0]", "floor[0]"].map(|face| ["near.png", face, "far.png"]);
    assert_eq!(named(&imported), expected, "{imported:#}");
    assert!(imported["too_coarse"][0]["pixels"].as_u64() > Some(5000), "{imported:#}");
    let updated = site.json("update project --json");
    assert_eq!(updated["too_coarse"], imported["too_coarse"], "the import was right");
    let again = stdout_of(&site.run("update project").success());
    assert!(again.starts_with("nothing to do") && again.contains("near.png  wall[0] "), "{again}");
    assert!(again.contains("views blend both") && again.contains("quadratura mask project"), "{again}");

    site.run("mask project --object wall --object floor --photo near -q").success();
    let masked = site.json("update project --json");
    assert_eq!(masked["too_coarse"], json!([]), "{masked:#}");
    assert_eq!(masked["photos"][1]["photo"], "near.png");
    let from_paint = masked["photos"][1]["shares"]["from_paint"].as_f64().unwrap();
    assert!(from_paint > 0.3, "{from_paint}");
}

#[test]
fn paint_that_stays_in_its_photo_is_too_coarse_for_none() {
    if adapter().is_none() {
        return;
    }
    let site = near_and_far();
    site.run("build project -q").success();
    site.run("export project --out layers --format folder -q --photo far").success();
    paint_the_whole_wall(&site, "layers/far.png.layers");
    let imported = site.json("import project layers/far.png.layers --only-here --json");
    assert!(imported["changed"].as_u64() > Some(1000));
    assert_eq!(imported["too_coarse"], json!([]));
}
