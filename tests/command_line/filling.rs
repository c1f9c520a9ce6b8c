//! `fill`, and what the other commands make of it.

use std::fs;

use crate::common::adapter;
use crate::site::{PHOTOS, Site, stderr_of, stdout_of, whole_stacks};

#[test]
fn what_is_hidden_is_filled_told_exported_and_shown() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    let early = site.run("fill project --dry-run").failure().code(1);
    assert!(stderr_of(&early).contains("quadratura update"), "it says what to do first");
    site.run("build project -q").success();
    let message = |word: &str| stdout_of(&site.run("info project").success()).contains(word);
    assert!(message("not filled"));

    let filled = site.json("fill project --json");
    for photo in filled["photos"].as_array().unwrap() {
        assert_eq!(photo["state"], "filled");
        assert!(photo["shares"]["hidden"].as_f64().unwrap() > 0.0, "the box hides a part of the wall");
        assert_eq!(photo["shares"]["empty"], 0.0);
    }
    assert_eq!(site.json("fill project --json")["photos"][0]["state"], "up to date");
    assert!(message("from photos") && !message("not filled"));
    assert_eq!(site.json("info project --json")["filling"][0]["state"], "filled");
    assert_eq!(whole_stacks(&site.project()), 2);
    let again = site.json("build project --json");
    assert_eq!(again["photos"][0]["state"], "up to date", "a filled stack is as good as any");

    site.run("export project --out layers --provenance").success();
    let legend = fs::read(site.path("layers/left.png.provenance/legend.json")).unwrap();
    let legend: serde_json::Value = serde_json::from_slice(&legend).unwrap();
    let file = legend["layers"][0]["file"].as_str().unwrap();
    assert!(file.starts_with("order-0") && file.contains("wall"), "{file}");
    assert!(site.path("layers/left.png.provenance").join(file).is_file());
    assert_eq!(legend["colours"][0]["text"], "the photo itself");
    let covered = |words: &str| {
        let drawn = site.json(&format!("render project --cameras photos --out views --json {words}"));
        drawn.to_string()
    };
    assert!(!covered("").is_empty() && !covered("--unfilled").is_empty());
}

#[test]
fn an_object_that_is_left_out_is_kept_so_in_the_project_if_that_is_asked_for() {
    if adapter().is_none() {
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

/// Recolours a part of the wall in one exported folder, and takes that home.
pub fn paint_the_wall(site: &Site, folder: &str, colour: [u8; 4]) {
    let layers = fs::read_dir(site.path(folder)).unwrap().map(|entry| entry.unwrap().path());
    let wall = layers.into_iter().find(|path| path.to_string_lossy().contains(" wall")).unwrap();
    let mut picture = image::open(&wall).unwrap().into_rgba8();
    let (width, height) = picture.dimensions();
    let shown: Vec<(u32, u32)> = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .filter(|&(x, y)| picture.get_pixel(x, y)[3] > 0)
        .take(3000)
        .collect();
    shown.into_iter().for_each(|(x, y)| picture.put_pixel(x, y, image::Rgba(colour)));
    picture.save(&wall).unwrap();
    let report = site.json(&format!("import project {folder} --json"));
    assert_eq!(report["changed"], 3000);
}

#[test]
fn paint_of_one_photo_is_offered_to_the_others_laid_over_them_and_taken_away_again() {
    if adapter().is_none() {
        return;
    }
    let site = Site::with_photos(&["left.png", "right.png"], 160, 120, 1);
    site.make_project();
    site.run("build project -q").success();
    site.run("export project --out layers --format folder").success();
    let nothing = stdout_of(&site.run("fill project --propagate --dry-run").success());
    assert!(nothing.contains("no paint would be projected to any photo"), "{nothing}");
    paint_the_wall(&site, "layers/left.png.layers", [250, 240, 10, 255]);

    let dry = site.json("fill project --propagate --dry-run --json");
    let offer = &dry["propagated"][0];
    assert_eq!((&offer["photo"], &offer["paint"]["from"]), (&"right.png".into(), &"left.png".into()));
    assert!(offer["paint"]["texels"].as_u64().unwrap() > 500, "{offer:#}");
    assert!(stdout_of(&site.run("info project").success()).contains("not filled"), "nothing was written");

    let note = stderr_of(&site.run("fill project --propagate=left.png").success());
    assert!(note.contains("--save-options"), "{note}");
    assert_eq!(site.json("info project --json")["propagated"][0]["paint"], offer["paint"]);
    site.run("export project --out spread --format folder --provenance").success();
    let legend = fs::read_to_string(site.path("spread/right.png.provenance/legend.json")).unwrap();
    assert!(legend.contains("[painted in left.png]"), "{legend}");
    // What another photo lent is no paint of this one.
    let home = site.json("import project spread/right.png.layers --json");
    assert_eq!(home["changed"], 0);

    paint_the_wall(&site, "spread/right.png.layers", [10, 20, 250, 255]);
    let message = site.json("fill project --propagate=left.png --save-options --json");
    assert!(message["propagated"][0]["paint"]["conflicts"].as_u64().unwrap() > 200, "{message:#}");
    assert!(fs::read_to_string(site.path("project/project.json")).unwrap().contains("propagate"));
    assert_eq!(
        site.json("fill project --json")["photos"][0]["state"],
        "up to date",
        "the project says so now"
    );
    let away = site.json("fill project --no-propagate --save-options --json");
    assert_eq!(away["propagated"], serde_json::json!([]));
    let unknown = site.run("fill project --propagate=nobody.png").failure().code(1);
    assert!(stderr_of(&unknown).contains("nobody.png"));
}
