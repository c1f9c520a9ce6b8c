//! `render` and `score` on the tiny site.

use std::fs;

use super::common::adapter;
use super::site::{PHOTOS, Site, stderr_of, stdout_of};

#[test]
fn photos_are_rendered_from_their_own_cameras_and_an_edited_picture_stays() {
    let Some(site) = Site::built() else { return };
    let rendered = site.json("render project --cameras photos --out views --json");
    let pictures = rendered["pictures"].as_array().unwrap();
    assert_eq!(pictures.len(), 2);
    for name in ["left.png", "north%20side%2Ft%C3%BCr%202.png"] {
        let picture = image::open(site.path("views").join(name)).unwrap();
        assert_eq!((picture.width(), picture.height(), picture.color().has_alpha()), (160, 120, true));
    }
    assert!(pictures[0]["textured"].as_f64().unwrap() > 0.9, "{rendered:#}");

    image::RgbaImage::new(160, 120).save(site.path("views/left.png")).unwrap();
    let again = site.run("render project --cameras photos --out views --size 80x60").success();
    assert!(stderr_of(&again).contains("is kept"), "{}", stderr_of(&again));
    let sizes =
        ["left.png", "left-2.png"].map(|name| image::open(site.path("views").join(name)).unwrap().width());
    assert_eq!(sizes, [160, 80]);
}

#[test]
fn an_image_layer_that_cannot_be_read_is_left_out_and_the_picture_is_drawn() {
    let Some(site) = Site::built() else { return };
    let stack = fs::read(site.path("project/stacks/left.png/stack.json")).unwrap();
    let stack: serde_json::Value = serde_json::from_slice(&stack).unwrap();
    let largest = stack["image_layers"].as_array().unwrap().iter().max_by_key(|l| l["texels_used"].as_u64());
    let file = largest.unwrap()["file"].as_str().unwrap();
    let path = site.path("project/stacks/left.png").join(file);
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    for words in ["render project --cameras photos --out views", "score project"] {
        let message = stderr_of(&site.run(words).failure().code(1));
        assert!(message.contains(file) && message.contains("1 image layer could not be read"), "{message}");
    }
    let picture = image::open(site.path("views/left.png")).unwrap().to_rgba8();
    assert!(picture.pixels().any(|pixel| pixel.0[3] == 255), "other layers serve");
}

#[test]
fn a_photo_seen_by_its_own_camera_is_the_photo() {
    let Some(site) = Site::built() else { return };
    site.run("render project --cameras photos --out views --mode best").success();
    let photo = image::open(site.path("photos/left.png")).unwrap().to_rgb8();
    let picture = image::open(site.path("views/left.png")).unwrap().to_rgba8();
    // Within a surface; where surfaces meet, or the photo ends, samples of others are mixed in.
    let inside = (30..60u32).flat_map(|y| (10..30u32).map(move |x| (x, y)));
    for (x, y) in inside {
        let (is, was) = (picture.get_pixel(x, y).0, photo.get_pixel(x, y).0);
        let most = (0..3).map(|c| is[c].abs_diff(was[c])).max().unwrap();
        // Interfaces allow an error of 0.6 steps where light is stored as sRGB.
        assert!(most <= 1 && is[3] == 255, "{x}, {y}: {is:?} instead of {was:?}");
    }
}

#[test]
fn colmap_cameras_lists_and_flights_are_views_too() {
    let Some(site) = Site::built() else { return };
    let count = |words: &str| {
        site.json(&format!("render project {words} --json"))["pictures"].as_array().unwrap().len()
    };
    fs::write(site.path("list.txt"), "# one\nleft\n").unwrap();
    assert_eq!(count("--cameras list.txt --out listed"), 1);
    assert_eq!(count("--cameras sparse --out colmap"), 2);
    let flight =
        "--through left,tür --size 32x24 --out flight --fps 5 --video flight.apng --write-path path.json";
    // A blank and a slash in its name leave no doubt when both are left out.
    let flight = flight.replace("tür", "left");
    assert_eq!(count(&flight), 11);
    assert!(image::open(site.path("flight.apng")).is_ok());
    assert!(site.path("flight/frame-00011.png").is_file());
    assert_eq!(count("--cameras path.json --out again"), 11);
    let message = stderr_of(&site.run(&format!("render project {flight}")).failure().code(1));
    assert!(message.contains("path.json already exists"), "{message}");
}

#[test]
fn when_no_photo_is_left_nothing_is_drawn_and_that_is_told() {
    let Some(site) = Site::built() else { return };
    let mut command = site.command("render project --cameras photos --out views --without left");
    let message = stderr_of(&command.args(["--without", PHOTOS[1]]).assert().failure().code(1));
    assert!(message.contains("leaves no photo") && !site.path("views").exists(), "{message}");
}

#[test]
fn one_wrong_camera_fails_alone() {
    let Some(site) = Site::built() else { return };
    fs::write(site.path("list.txt"), "left\nnowhere\n").unwrap();
    let run = site.run("render project --cameras list.txt --out views").failure().code(1);
    assert!(
        stderr_of(&run).contains("line 2") && site.path("views/left.png").is_file(),
        "{}",
        stderr_of(&run)
    );
}

#[test]
fn without_stacks_render_says_what_to_do() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    site.make_project();
    let message = stderr_of(&site.run("render project --cameras photos --out views").failure().code(1));
    assert!(message.contains("quadratura update"), "{message}");
}

#[test]
fn score_predicts_each_photo_from_the_others_and_writes_differences() {
    let Some(site) = Site::built() else { return };
    let score = site.json("score project --scale 1 --holes --pictures differences --json");
    assert_eq!((score["photos"].as_array().unwrap().len(), &score["asked"]["held_out"]), (2, &false.into()));
    let covered = score["mean"]["coverage"].as_f64().unwrap();
    assert!(covered > 0.5 && covered < 1.0, "a metre to the side, a strip is seen by one photo: {covered}");
    let whole = site.json("score project --scale 1 --json");
    assert_eq!(whole["mean"]["coverage"], 1.0, "what no photo shows is continued");
    assert!(score["mean"]["covered"]["psnr"].is_number() && score["objects"][0]["object"].is_string());
    assert_eq!(image::open(site.path("differences/left.png")).unwrap().width(), 3 * 160 + 16);

    let text = stdout_of(&site.run("score project --ignore wall --ignore box*").success());
    assert!(text.contains("mean of 2") && text.contains("Left out: wall, box*."), "{text}");
    // The mask is the same for the table and the file.
    let text = stdout_of(&site.run("score project --only *x* --json-file only.json").success());
    assert!(
        text.contains("mean of 2") && text.contains("only pixels whose nearest surface is of *x*."),
        "{text}"
    );
    let file: serde_json::Value = serde_json::from_slice(&fs::read(site.path("only.json")).unwrap()).unwrap();
    assert_eq!(file["asked"]["only"][0], "*x*");
    let objects = file["objects"].as_array().unwrap();
    assert!(objects.iter().all(|object| object["object"].as_str().unwrap().contains('x')), "{file:#}");
    let counted = |list: &str, field: [&str; 2]| -> u64 {
        let field = |item: &serde_json::Value| item[field[0]].as_u64().or(item[field[0]][field[1]].as_u64());
        file[list].as_array().unwrap().iter().filter_map(field).sum()
    };
    let of_objects = counted("objects", ["pixels", ""]) + counted("objects", ["holes", ""]);
    assert_eq!(counted("photos", ["with_holes", "pixels"]), of_objects);
    let message = stderr_of(&site.run("score project --ignore sky").failure().code(1));
    assert!(message.contains("sky"), "{message}");
}

#[test]
fn held_out_photos_are_scored_against_all_of_the_project() {
    let Some(site) = Site::built() else { return };
    let score = site.json("score project --cameras sparse --photos photos --scale 1 --json");
    assert_eq!(score["asked"]["held_out"], true);
    // They are the project's own: nearly everything is predicted as it is.
    assert!(score["mean"]["covered"]["psnr"].as_f64().unwrap() > 30.0, "{score:#}");
}

#[test]
fn a_stack_is_shown_exploded() {
    let Some(site) = Site::built() else { return };
    fs::write(site.path("list.txt"), "left\n").unwrap();
    site.run("render project --cameras list.txt --show exploded --size 200x100 --out views").success();
    let picture = image::open(site.path("views/left.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), (200, 100));
    let message =
        stderr_of(&site.run("render project --cameras sparse --show exploded --out views").failure().code(1));
    assert!(message.contains("--cameras photos"), "{message}");
    let flight =
        site.run("render project --through left,left --show exploded --out flight").failure().code(1);
    assert_eq!(stderr_of(&flight).matches("error:").count(), 1, "{}", stderr_of(&flight));
    assert!(stdout_of(&flight).is_empty() && !site.path("flight").exists());
}

#[test]
fn a_saved_view_is_rendered_by_its_name_with_a_legend_in_print_and_in_the_picture() {
    let Some(site) = Site::built() else { return };
    let file = site.path("project/project.json");
    let mut project: serde_json::Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
    project["views"] = serde_json::json!([{
        "name": "gate/1", "position": [0, 0, 0], "rotation": [1, 0, 0, 0], "focal": [1.3, 1.3], "pivot": [0, 0, 8]
    }]);
    fs::write(&file, project.to_string()).unwrap();
    let wrong = stderr_of(&site.run("render project --view gaet/1 --out views").failure().code(1));
    assert!(wrong.contains("there is no saved view \"gaet/1\"; the nearest name is \"gate/1\""), "{wrong}");

    let render = "render project --view gate/1 --size 400x300 --show provenance";
    let plain = stdout_of(&site.run(&format!("{render} --out plain")).success());
    assert!(plain.contains("Source:\n  #5b8db8  the photo itself\n"), "{plain}");
    assert!(plain.contains("  #808080  not covered by any photo"), "{plain}");
    let json = site.json(&format!("{render} --out drawn --legend --json"));
    assert_eq!(json["legend"]["colours"][0]["colour"], "#5b8db8");
    let [plain, drawn] = ["plain", "drawn"]
        .map(|folder| image::open(site.path(folder).join("gate%2F1.png")).unwrap().to_rgba8());
    assert_eq!(plain.dimensions(), (400, 300));
    let same = |rows: std::ops::Range<u32>| {
        rows.flat_map(|y| (0..400).map(move |x| (x, y)))
            .all(|(x, y)| plain.get_pixel(x, y) == drawn.get_pixel(x, y))
    };
    assert!(same(0..150) && !same(200..300), "the legend is at the bottom");
    let textured = |folder: &str| {
        site.json(&format!("{render} --out {folder} --json"))["pictures"][0]["textured"].clone()
    };
    assert_eq!(json["pictures"][0]["textured"], textured("plain"), "the legend is no surface");
}

#[test]
fn what_no_photo_shows_is_continued_and_told_and_left_out_on_request() {
    let Some(site) = Site::built() else { return };
    let render = "render project --cameras photos --without left.png";
    let told = stdout_of(&site.run(&format!("{render} --out whole")).success());
    assert!(told.contains("% of the pixels show what no photo shows"), "{told}");
    let json = site.json(&format!("{render} --holes --out holes --json"));
    let [whole, holes] =
        ["whole", "holes"].map(|folder| image::open(site.path(folder).join("left.png")).unwrap().to_rgba8());
    assert!(whole.pixels().all(|pixel| pixel.0[3] == 255));
    let left_out: f64 = holes.pixels().map(|pixel| 1.0 - f64::from(pixel.0[3]) / 255.0).sum();
    let share = left_out / f64::from(holes.width() * holes.height());
    let shares: Vec<f64> =
        json["continued"].as_object().unwrap().values().map(|share| share.as_f64().unwrap()).collect();
    // A small picture tells the share, one sample per pixel: edges of holes are counted whole or not at all.
    assert!(share > 0.01 && shares.iter().any(|told| (told - share).abs() < 0.03), "{share}, {shares:?}");
    let kept = whole.pixels().zip(holes.pixels()).filter(|(_, hole)| hole.0[3] == 255);
    assert!(kept.clone().count() > 1000);
    let differing = kept.filter(|(whole, hole)| whole != hole).count();
    assert!(differing < 200, "only what is beside holes changes: {differing}");
}
