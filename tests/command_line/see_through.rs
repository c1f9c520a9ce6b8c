//! Objects that are declared see-through, on a site of a wall, a floor and a fence of palings that is modelled as one
//! rectangle.

use std::fs;

use image::{Rgb, RgbImage, RgbaImage};
use serde_json::Value;

use super::common::adapter;
use super::site::{Site, json_of, stderr_of, stdout_of};

const PHOTOS: [&str; 3] = ["left.png", "middle.png", "right.png"];
const SIZE: [u32; 2] = [320, 240];
const FOCAL: f64 = 160.0;
/// Where the cameras are along x; they look along z, and y points down.
const CAMERAS: [f64; 3] = [-3.0, 0.0, 3.0];
/// The fence: from and to along x and y, and its depth.
const FENCE: [f64; 4] = [-1.5, 1.5, -1.0, 1.9];
const DEPTH: f64 = 6.0;
/// The width of a paling, and of a gap.
const PALING: f64 = 0.3;

/// Whether there is wood at a place of the fence's rectangle.
fn is_wood(x: f64) -> bool {
    ((x - FENCE[0]) / PALING) as i32 % 2 == 0
}

/// The colour that a ray from (x, 0, 0) in the direction (dx, dy, 1) meets.
fn colour(x: f64, dx: f64, dy: f64) -> [f64; 3] {
    let at = [x + DEPTH * dx, DEPTH * dy];
    if (FENCE[0]..FENCE[1]).contains(&at[0]) && (FENCE[2]..FENCE[3]).contains(&at[1]) && is_wood(at[0]) {
        return [60.0 + 15.0 * (at[1] * 9.0).sin(), 40.0, 90.0 + 20.0 * (at[0] * 5.0).sin()];
    }
    if 12.0 * dy > 2.0 {
        let (z, wide) = (2.0 / dy, x + 2.0 * dx / dy);
        return [150.0 + 30.0 * (wide * 2.0).sin(), 130.0, 110.0 + 25.0 * (z * 3.0).sin()];
    }
    let (wide, high) = (x + 12.0 * dx, 12.0 * dy);
    [190.0 + 25.0 * (wide * 2.5).sin(), 150.0 + 25.0 * (high * 2.0).sin(), 120.0 + 10.0 * (wide * 0.7).sin()]
}

/// The site, not yet built.
fn site() -> Site {
    site_of(&PHOTOS, &CAMERAS)
}

/// The site with these photos, not yet built.
fn site_of(photos: &[&str], cameras: &[f64]) -> Site {
    let site = Site::with_photos(photos, SIZE[0], SIZE[1], 1);
    for (name, x) in photos.iter().zip(cameras) {
        let photo = RgbImage::from_fn(SIZE[0], SIZE[1], |column, row| {
            let mut sum = [0.0; 3];
            for within in [0.125, 0.375, 0.625, 0.875] {
                let across = f64::from(column) + within - f64::from(SIZE[0]) / 2.0;
                let down = f64::from(row) + 0.5 - f64::from(SIZE[1]) / 2.0;
                let seen = colour(*x, across / FOCAL, down / FOCAL);
                (0..3).for_each(|c| sum[c] += seen[c] / 4.0);
            }
            Rgb(sum.map(|sum| sum.round() as u8))
        });
        photo.save(site.path("photos").join(name)).unwrap();
    }
    let [width, height] = SIZE;
    let camera = format!("1 PINHOLE {width} {height} {FOCAL} {FOCAL} {} {}\n", width / 2, height / 2);
    fs::write(site.path("sparse/cameras.txt"), camera).unwrap();
    let pose = |(name, x): (&&str, &f64)| format!("{} 1 0 0 0 {} 0 0 1 {name}\n\n", *x as i32 + 9, -x);
    let poses: String = photos.iter().zip(cameras).map(pose).collect();
    fs::write(site.path("sparse/images.txt"), poses).unwrap();
    let mut model = String::from(
        "o wall\nv -20 -20 12\nv -20 2 12\nv 20 2 12\nv 20 -20 12\nf 4 3 2 1\n\
         o floor\nv -20 2 -9\nv -20 2 12\nv 20 2 12\nv 20 2 -9\nf 8 7 6 5\no fence\n",
    );
    let [x0, x1, y0, y1] = FENCE;
    for [x, y] in [[x0, y0], [x0, y1], [x1, y1], [x1, y0]] {
        model.push_str(&format!("v {x} {y} {DEPTH}\n"));
    }
    model.push_str("f 12 11 10 9\n");
    fs::write(site.path("model.obj"), model).unwrap();
    site.make_project();
    site
}

fn stack_of(site: &Site, photo: &str) -> Value {
    let text = fs::read(site.path("project/stacks").join(photo).join("stack.json")).unwrap();
    serde_json::from_slice(&text).unwrap()
}

/// The alpha of the fence's layer at the photo's pixels of the fence, and how much wood there is.
fn alpha_of_fence(site: &Site, camera: usize) -> Vec<(f64, f64)> {
    let stack = stack_of(site, PHOTOS[camera]);
    let layers = stack["image_layers"].as_array().unwrap();
    let has_matte = |layer: &&Value| layer["matte_file"].is_string();
    let layer = layers.iter().find(has_matte).unwrap_or_else(|| panic!("no matte: {stack:#}"));
    let folder = site.path("project/stacks").join(PHOTOS[camera]);
    let matte = image::open(folder.join(layer["matte_file"].as_str().unwrap())).unwrap().to_luma8();
    let rect: [i64; 4] = serde_json::from_value(layer["rect"].clone()).unwrap();
    let mut found = Vec::new();
    for (x, y, alpha) in matte.enumerate_pixels() {
        let dy = (rect[1] as f64 + f64::from(y) + 0.5 - f64::from(SIZE[1]) / 2.0) / FOCAL;
        let across = |within: f64| rect[0] as f64 + f64::from(x) + within - f64::from(SIZE[0]) / 2.0;
        let at = |within: f64| CAMERAS[camera] + DEPTH * across(within) / FOCAL;
        let is_fence = |at: f64| (FENCE[0]..FENCE[1]).contains(&at);
        if (FENCE[2]..FENCE[3]).contains(&(DEPTH * dy)) && is_fence(at(0.0)) && is_fence(at(1.0)) {
            let wood = [0.125, 0.375, 0.625, 0.875].map(|within| f64::from(u8::from(is_wood(at(within)))));
            found.push((f64::from(alpha[0]) / 255.0, wood.iter().sum::<f64>() / 4.0));
        }
    }
    found
}

#[test]
fn a_fence_that_is_declared_see_through_gets_mattes_and_its_own_layers() {
    if adapter().is_none() {
        return;
    }
    let site = site();
    site.run("build project --stacks-only").success();
    let told = stderr_of(&site.run("matte project --object fence"));
    assert!(told.contains("--see-through 'fence'"), "{told}");
    let decided = stdout_of(&site.run("decide project --see-through fen*").success());
    assert!(decided.contains("fence is see-through") && decided.contains("quadratura update"), "{decided}");
    let listed = site.json("object project --json");
    let fence = |listed: &Value| {
        let objects = listed["objects"].as_array().unwrap();
        objects.iter().find(|it| it["object"] == "fence").unwrap().clone()
    };
    assert_eq!((&fence(&listed)["see_through"], &fence(&listed)["turns"]), (&true.into(), &false.into()));
    let info = site.json("info project --json");
    assert_eq!(info["photos"][0]["state"], "stale", "its layers are others");
    site.run("build project --stacks-only").success();
    let mattes = site.json("matte project --json");
    for row in mattes["mattes"].as_array().unwrap() {
        assert_eq!(row["object"], "fence");
    }
    assert_eq!(mattes["mattes"].as_array().unwrap().len(), 3, "{mattes}");
    let told = stdout_of(&site.run("matte project").success());
    assert!(
        told.contains("are those of before") && told.contains("layers of left.png, middle.png, right.png"),
        "{told}"
    );
    site.run("fill project").success();
    let told = stdout_of(&site.run("matte project --photo left").success());
    assert!(told.contains("the image layers have them"), "{told}");
    for (camera, photo) in PHOTOS.iter().enumerate() {
        let found = alpha_of_fence(&site, camera);
        let wrong = found.iter().filter(|(alpha, wood)| (*alpha > 0.5) != (*wood > 0.5)).count();
        let off = found.iter().map(|(alpha, wood)| (alpha - wood).abs()).sum::<f64>() / found.len() as f64;
        println!("{photo}: {wrong} of {} on the wrong side, {off:.3} off", found.len());
        assert!(found.len() > 3000 && wrong * 20 < found.len(), "{photo}: {wrong} of {}", found.len());
    }
    let (_, exported) = exported_fence(&site, "layers");
    let clear = exported.pixels().filter(|pixel| pixel[3] == 0).count();
    let solid = exported.pixels().filter(|pixel| pixel[3] == 255).count();
    assert!(clear > 1000 && solid > 1000, "{clear} and {solid} pixels of palings and gaps");

    // Solid again, nothing is left of the decision, and no layer has a matte.
    site.run("decide project --no-see-through fence").success();
    assert!(!fs::read_to_string(site.path("project/project.json")).unwrap().contains("see_through"));
    site.run("build project --stacks-only").success();
    site.run("fill project").success();
    let stack = stack_of(&site, PHOTOS[1]);
    let layers = stack["image_layers"].as_array().unwrap();
    assert!(layers.iter().all(|layer| layer["matte_file"].is_null()), "{stack:#}");
}

/// The pixels that all photos mask together for an object, and what was noted.
fn masked(site: &Site, object: &str) -> (u64, String) {
    let done = site.run(&format!("mask project --clear --object {object} --json")).success();
    let photos = json_of(&done)["photos"].as_array().unwrap().clone();
    (photos.iter().map(|photo| photo["pixels"].as_u64().unwrap()).sum(), stderr_of(&done))
}

#[test]
fn a_mask_of_what_is_seen_through_a_fence_holds_it_and_without_mattes_that_is_told() {
    if adapter().is_none() {
        return;
    }
    let site = site();
    let [(fence, told), (wall, _), (all, _)] = ["fence", "wall", "*"].map(|object| masked(&site, object));
    assert!(!told.contains("solid"), "nobody sees through it: {told}");
    site.run("decide project --see-through fence").success();
    let (without, told) = masked(&site, "fence");
    let remedy = "as if they were solid, with all that is seen through them: no photo has a stack yet";
    assert!(told.contains(remedy) && told.contains("quadratura update project"), "{told}");
    assert_eq!(without, fence, "the whole rectangle");

    site.run("mask project --clear").success();
    site.run("build project --stacks-only").success();
    let (palings, told) = masked(&site, "fence");
    assert!(!told.contains("solid"), "{told}");
    // Half of the fence is wood, and some pixels at its rims are mixed.
    assert!(palings * 10 > fence * 4 && palings * 10 < fence * 7, "{palings} of {fence}");
    let (through, _) = masked(&site, "wall");
    // The wall is behind two thirds of the fence, the floor behind the rest.
    assert!(
        (through - wall) * 10 > fence * 2 && (through - wall) * 10 < fence * 5,
        "{wall}, {through} of {fence}"
    );
    assert_eq!(masked(&site, "*").0, all, "every pixel shows something");

    let off = stdout_of(&site.run("object project --off fence").success());
    assert!(off.contains("object project --on 'fence'") && off.contains("remove it again"), "{off}");
    let (removed, told) = masked(&site, "fence");
    assert!(told.contains("removed objects have no mattes") && told.contains("fence"), "{told}");
    assert_eq!(removed, fence);
}

#[test]
fn an_object_is_not_given_to_an_option_and_to_its_opposite() {
    let site = site();
    let before = fs::read_to_string(site.path("project/project.json")).unwrap();
    let opposites = [
        ["--impostor", "--no-impostor"],
        ["--impostor", "--free-impostor"],
        ["--see-through", "--no-see-through"],
        ["--no-see-through", "--free-see-through"],
    ];
    for [option, opposite] in opposites {
        let refused = site.run(&format!("decide project {option} fence {opposite} f*")).failure();
        let told = stderr_of(&refused);
        let expected = format!("fence cannot be given to {option} and to {opposite}");
        assert!(told.contains(&expected), "{told}");
    }
    assert_eq!(fs::read_to_string(site.path("project/project.json")).unwrap(), before);
    let many = stderr_of(&site.run("decide project --see-through *").success());
    assert!(many.contains("3 objects with 3 of the model's 3 faces are declared see-through"), "{many}");
    site.run("decide project --free-see-through *").success();
    site.run("decide project --see-through fence --impostor fence --no-see-through wall").success();
    let free = site.json("decide project --free-see-through * --json");
    assert_eq!((&free["see_through"], &free["impostors"]["fence"]), (&serde_json::json!({}), &true.into()));
    site.run("decide project --free-impostor fen*").success();
    assert_eq!(
        fs::read_to_string(site.path("project/project.json")).unwrap(),
        before,
        "as without decisions"
    );
    let unknown =
        stderr_of(&site.run("decide project --free-impostor gate --free-see-through rail").failure());
    assert!(unknown.contains("gate"), "{unknown}");
}

/// The fence's layer of the middle photo, exported as a folder: its corner in the photo, and the picture.
fn exported_fence(site: &Site, out: &str) -> ([i64; 2], RgbaImage) {
    site.run(&format!("export project --format folder --photo middle.png --out {out}")).success();
    let folder = site.path(out).join("middle.png.layers");
    let stack: Value = serde_json::from_slice(&fs::read(folder.join("stack.json")).unwrap()).unwrap();
    let layers = stack["image_layers"].as_array().unwrap();
    let fence = layers.iter().find(|layer| layer["name"].as_str().unwrap().starts_with("fence")).unwrap();
    let corner = [0, 1].map(|i| fence["rect"][i].as_i64().unwrap());
    (corner, image::open(folder.join(fence["file"].as_str().unwrap())).unwrap().to_rgba8())
}

/// Writes a stroke of the matte brush in the middle photo's view, whose lens has this focal length.
fn write_stroke(site: &Site, mode: &str, focal: f64, radius: f64, at: [[f64; 2]; 2]) {
    let camera = serde_json::json!({
        "K": [[focal, 0.0, 160.0], [0.0, focal, 120.0], [0.0, 0.0, 1.0]],
        "R": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        "t": [0.0, 0.0, 0.0],
    });
    let stroke = serde_json::json!({
        "version": 1,
        "view": { "width": SIZE[0], "height": SIZE[1], "camera": camera },
        "brush": { "mode": mode, "radius": radius },
        "samples": [{ "at": at[0] }, { "at": at[1] }],
    });
    fs::write(site.path("stroke.json"), stroke.to_string()).unwrap();
}

#[test]
fn the_matte_brush_lets_one_see_through_makes_solid_and_solves_and_is_undone() {
    if adapter().is_none() {
        return;
    }
    let site = site();
    site.run("decide project --see-through fence").success();
    site.run("build project --stacks-only").success();
    write_stroke(&site, "solid", FOCAL, 2.0, [[132.0, 130.0], [132.0, 131.0]]);
    let early = stderr_of(&site.run("stroke project stroke.json").failure());
    assert!(
        early.contains("fence in middle.png has no matte yet") && early.contains("quadratura update"),
        "{early}"
    );
    site.run("fill project").success();
    let (_, before) = exported_fence(&site, "before");

    // The first palings are the columns 120 to 128 and 136 to 144, from row 93 to 171.
    let strokes = [
        ("see-through", 3.0, [[140.0, 110.0], [140.0, 114.0]]),
        ("solid", 2.0, [[132.0, 130.0], [132.0, 131.0]]),
        ("solve", 4.0, [[136.0, 148.0], [136.0, 152.0]]),
    ];
    for (mode, radius, at) in strokes {
        write_stroke(&site, mode, FOCAL, radius, at);
        let painted = site.json("stroke project stroke.json --json");
        assert_eq!(painted["layers"].as_array().unwrap().len(), 1, "{mode}: {painted}");
        assert!(painted["changed"].as_u64().unwrap() > 0, "{mode}: {painted}");
    }
    let is_authored = |out: &str| {
        let ([left, top], picture) = exported_fence(&site, out);
        let at = |x: i64, y: i64| *picture.get_pixel((x - left) as u32, (y - top) as u32);
        assert_eq!(at(140, 112)[3], 0, "one sees through");
        let photo = image::open(site.path("photos/middle.png")).unwrap().to_rgb8();
        let [r, g, b] = photo.get_pixel(132, 130).0;
        assert_eq!(at(132, 130).0, [r, g, b, 255], "solid, as the photo shows it");
        assert!(at(139, 150)[3] > 200 && at(133, 150)[3] < 55, "{:?} {:?}", at(139, 150), at(133, 150));
    };
    is_authored("painted");
    // Finding mattes again does not touch what was painted.
    site.run("matte project --force").success();
    site.run("fill project --force").success();
    is_authored("again");
    let info = site.json("info project --json");
    let of_photos = info["mattes"].as_array().unwrap();
    assert_eq!(of_photos.len(), PHOTOS.len(), "{info}");
    assert!(of_photos.iter().all(|row| row["pixels"].as_u64() > row["unknown"].as_u64()), "{info}");

    for _ in strokes {
        site.run("import project --undo").success();
    }
    let (_, after) = exported_fence(&site, "undone");
    assert_eq!(after.dimensions(), before.dimensions());
    assert!(after == before, "as it was");

    write_stroke(&site, "solid", FOCAL + 1.0, 2.0, [[132.0, 130.0], [132.0, 131.0]]);
    let told = stderr_of(&site.run("stroke project stroke.json").failure());
    assert!(told.contains("photo's own view"), "{told}");
    let refused = |layer: Option<&str>, at: [f64; 2]| {
        write_stroke(&site, "solid", FOCAL, 2.0, [at; 2]);
        let mut stroke: Value = serde_json::from_slice(&fs::read(site.path("stroke.json")).unwrap()).unwrap();
        stroke["layer"] = layer.into();
        fs::write(site.path("stroke.json"), stroke.to_string()).unwrap();
        stderr_of(&site.run("stroke project stroke.json").failure())
    };
    let token = |name: &str| {
        let stack = stack_of(&site, "middle.png");
        let layers = stack["image_layers"].as_array().unwrap().iter();
        let layer = layers.clone().find(|layer| layer["name"].as_str().unwrap().starts_with(name)).unwrap();
        layer["id"].as_str().unwrap().to_owned()
    };
    let (fence, wall) = (token("fence"), token("wall"));
    let causes = [
        (None, [300.0, 20.0], format!("draw it over one of them: fence [{fence}] is in columns 120 to 199")),
        (None, [900.0, 20.0], "is outside of middle.png, which has 320 x 240 pixels".into()),
        (Some("gone4711"), [132.0, 130.0], "middle.png has no image layer [gone4711]".into()),
        (
            Some(&*wall),
            [132.0, 130.0],
            "is solid, so it has no matte; to see through floor, wall, declare it".into(),
        ),
        (Some(&*fence), [300.0, 20.0], format!("is beside the image layer fence [{fence}] of middle.png")),
    ];
    for (layer, at, expected) in causes {
        let told = refused(layer, at);
        assert!(told.contains(&expected), "{expected}: {told}");
    }
    site.run("fill project --no-mattes --save-options").success();
    assert!(refused(None, [132.0, 130.0]).contains("leave see-through objects solid (`no_mattes`)"));
}

#[test]
fn what_is_painted_on_a_matte_is_known() {
    if adapter().is_none() {
        return;
    }
    // A photo alone can hardly tell what is behind the fence.
    let site = site_of(&PHOTOS[1..2], &CAMERAS[1..2]);
    site.run("decide project --see-through fence").success();
    site.run("fill project").success();
    let row = |site: &Site| site.json("info project --json")["mattes"][0].clone();
    let unknown = |row: &Value| row["unknown"].as_u64().unwrap();
    let before = row(&site);
    assert!(unknown(&before) * 2 > before["pixels"].as_u64().unwrap(), "{before}");
    write_stroke(&site, "see-through", FOCAL, 8.0, [[150.0, 110.0], [150.0, 150.0]]);
    let painted = site.json("stroke project stroke.json --json")["changed"].as_u64().unwrap();
    let after = row(&site);
    let known = unknown(&before) - unknown(&after);
    assert!(known * 2 > painted && known <= painted, "{known} of {painted} painted pixels were not known");
    // A filling of later counts as before; paint stays paint.
    site.run("fill project").success();
    assert_eq!(row(&site), after);
    site.run("import project --undo").success();
    assert_eq!(row(&site), before);
}

#[test]
fn the_rim_of_the_matte_brush_is_soft() {
    if adapter().is_none() {
        return;
    }
    let site = site();
    site.run("decide project --see-through fence").success();
    site.run("fill project").success();
    // From the middle of a paling, which is eight columns wide, over a gap into the next one.
    write_stroke(&site, "see-through", FOCAL, 10.0, [[140.0, 110.0], [140.0, 130.0]]);
    site.run("stroke project stroke.json").success();
    let ([left, top], picture) = exported_fence(&site, "soft");
    let alpha = |x: i64| picture.get_pixel((x - left) as u32, (120 - top) as u32)[3];
    let row: Vec<u8> = (137..143).map(alpha).collect();
    assert!(row.iter().all(|alpha| *alpha == 0), "{row:?}");
    write_stroke(&site, "solid", FOCAL, 10.0, [[148.0, 110.0], [148.0, 130.0]]);
    site.run("stroke project stroke.json").success();
    let ([left, top], picture) = exported_fence(&site, "solid");
    let alpha = |x: i64| picture.get_pixel((x - left) as u32, (120 - top) as u32)[3];
    let row: Vec<u8> = (138..152).map(alpha).collect();
    assert!(row.windows(2).all(|pair| pair[0] <= pair[1]), "{row:?}");
    assert!(row.iter().filter(|alpha| (8..248).contains(*alpha)).count() >= 3, "{row:?}");
    assert_eq!(row.last(), Some(&255), "{row:?}");
}
