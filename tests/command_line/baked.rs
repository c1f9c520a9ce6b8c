//! Models with one set of textures, on the tiny site, where y points down.

use std::fs;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use image::{Rgb, RgbImage};
use quadratura::task::Task;
use quadratura::testing::import::models::read_model;
use quadratura::testing::scene::{FaceIndex, Model};
use serde_json::Value;

use super::common::adapter;
use super::site::{PHOTOS, Site, stderr_of};

/// The project with photos that change slowly, whose stacks are built; none where there is no GPU.
fn smooth_site() -> Option<Site> {
    adapter()?;
    let site = Site::new();
    for (name, blue) in PHOTOS.iter().zip([40, 200]) {
        let colour = |x: u32, y: u32| Rgb([(40 + x) as u8, (220 - y) as u8, blue]);
        RgbImage::from_fn(160, 120, colour).save(site.path("photos").join(name)).unwrap();
    }
    site.make_project();
    site.run("build project").success();
    Some(site)
}

/// Exports, and returns what was reported.
fn export(site: &Site, arguments: &str) -> Value {
    site.json(&format!("export project --json {arguments}"))
}

/// Asserts that two models have the same objects with the same faces, corner by corner, after `turn`.
fn assert_same(expected: &Model, found: &Model, turn: impl Fn(DVec3) -> DVec3) {
    let names = |model: &Model| model.objects.iter().map(|object| object.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(found), names(expected));
    for object in &expected.objects {
        let other = found.object(found.object_named(&object.name).unwrap());
        assert_eq!(other.faces.len(), object.faces.len(), "{}", object.name);
        for index in (0..object.faces.len()).map(FaceIndex::new) {
            let ring = |model: &Model| {
                let face = model.face_named(&object.name, index).unwrap();
                model.ring_points(face).collect::<Vec<_>>()
            };
            let (expected, found) = (ring(expected), ring(found));
            assert_eq!(found.len(), expected.len());
            for corner in expected {
                let nearest =
                    found.iter().map(|other| turn(*other).distance(corner)).fold(f64::INFINITY, f64::min);
                // Files have coordinates of 24 bits; the site is 40 units wide.
                assert!(nearest < 40.0 * 1e-6, "{corner} of {} is {nearest} away", object.name);
            }
        }
    }
}

/// The chunks of a GLB file.
fn chunks(file: &Path) -> (Value, Vec<u8>) {
    let bytes = fs::read(file).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    (serde_json::from_slice(&bytes[20..20 + length]).unwrap(), bytes[28 + length..].to_vec())
}

/// The bytes of a buffer view.
fn view<'a>(json: &Value, binary: &'a [u8], view: &Value) -> &'a [u8] {
    let view = &json["bufferViews"][view.as_u64().unwrap() as usize];
    let [at, length] = ["byteOffset", "byteLength"].map(|key| view[key].as_u64().unwrap() as usize);
    &binary[at..at + length]
}

fn floats(bytes: &[u8]) -> Vec<f64> {
    bytes.as_chunks::<4>().0.iter().map(|bytes| f64::from(f32::from_le_bytes(*bytes))).collect()
}

/// The corners of an object in a GLB file: positions as in the world, and places on its page, with the page.
fn corners(file: &Path, object: &str) -> (Vec<(DVec3, DVec2)>, RgbImage) {
    let (json, binary) = chunks(file);
    let meshes = json["meshes"].as_array().unwrap();
    let primitive = &meshes.iter().find(|mesh| mesh["name"] == object).unwrap()["primitives"][0];
    let values = |attribute: &str| {
        let accessor = &json["accessors"][primitive["attributes"][attribute].as_u64().unwrap() as usize];
        floats(view(&json, &binary, &accessor["bufferView"]))
    };
    let positions: Vec<DVec3> =
        values("POSITION").as_chunks().0.iter().map(|p| DVec3::from_array(*p)).collect();
    let places: Vec<DVec2> =
        values("TEXCOORD_0").as_chunks().0.iter().map(|p| DVec2::from_array(*p)).collect();
    let page = &json["images"][primitive["material"].as_u64().unwrap() as usize];
    let picture = image::load_from_memory(view(&json, &binary, &page["bufferView"])).unwrap().to_rgb8();
    (positions.into_iter().zip(places).collect(), picture)
}

#[test]
fn glb_and_obj_read_back_as_the_model_with_its_objects_and_faces() {
    let Some(site) = smooth_site() else { return };
    let (expected, _) = read_model(&site.path("model.obj"), &Task::silent()).unwrap();
    export(&site, "--format glb --out glb");
    let (glb, notes) = read_model(&site.path("glb/site.glb"), &Task::silent()).unwrap();
    assert!(notes.is_empty(), "{notes:?}");
    // The file's y is up, the world's is down.
    let back = |point: DVec3| {
        let (json, _) = chunks(&site.path("glb/site.glb"));
        let rotation: Vec<f64> = serde_json::from_value(json["nodes"][0]["rotation"].clone()).unwrap();
        glam::DQuat::from_slice(&rotation).normalize().inverse() * point
    };
    assert_same(&expected, &glb, back);
    assert!((back(DVec3::Y) - DVec3::NEG_Y).length() < 1e-6);
    export(&site, "--format obj --out obj");
    let (obj, _) = read_model(&site.path("obj/site.obj"), &Task::silent()).unwrap();
    assert_same(&expected, &obj, |point| point);
    export(&site, "--format obj --up y --out upright");
    let (upright, _) = read_model(&site.path("upright/site.obj"), &Task::silent()).unwrap();
    assert_same(&expected, &upright, back);
}

#[test]
fn a_texel_has_the_colour_that_the_photo_shows_there() {
    let Some(site) = smooth_site() else { return };
    // A box is in the middle of both photos; one photo alone makes the colours known.
    export(&site, "--format glb --png --photo left.png --density 40 --out glb");
    let (corners, page) = corners(&site.path("glb/site.glb"), "box 0");
    let size = DVec2::new(page.width().into(), page.height().into());
    let (mut worst, mut places) = (0, 0);
    // Within the triangle of the first three corners positions and places run evenly.
    let [(start, place), (to_s, place_s), (to_t, place_t)] = [corners[0], corners[1], corners[2]];
    for [s, t] in (1..10).flat_map(|s| (1..10 - s).map(move |t| [s, t].map(|share| f64::from(share) / 10.0)))
    {
        let point = start + s * (to_s - start) + t * (to_t - start);
        let place = place + s * (place_s - place) + t * (place_t - place);
        let [x, y] = [80.0 + 160.0 * point.x / point.z, 60.0 + 160.0 * point.y / point.z];
        let texel = page.get_pixel((place.x * size.x) as u32, (place.y * size.y) as u32);
        // Pixel i has its centre at i + 0.5.
        let expected = [40.0 + x - 0.5, 220.0 - (y - 0.5), 40.0];
        let off = texel.0.iter().zip(expected).map(|(a, b)| (f64::from(*a) - b).abs().ceil() as u32);
        worst = worst.max(off.max().unwrap());
        places += 1;
    }
    // A texel is up to half a texel, a third of a pixel and so of a level, beside the place, and colours are of 8 bits.
    assert!(worst <= 2 && places == 36, "off by {worst}");
}

#[test]
fn what_no_photo_shows_is_grey_in_holes_and_black_in_the_map_of_what_is_known() {
    let Some(site) = smooth_site() else { return };
    // The shed is hidden behind the wall.
    let report = export(&site, "--format glb --png --holes --out glb");
    let (corners, page) = corners(&site.path("glb/site.glb"), "shed");
    let middle = corners.iter().map(|(_, place)| *place).sum::<DVec2>() / corners.len() as f64;
    let at = |picture: &RgbImage| {
        let [x, y] = [middle.x * f64::from(picture.width()), middle.y * f64::from(picture.height())];
        picture.get_pixel(x as u32, y as u32).0
    };
    assert_eq!(at(&page), [128; 3]);
    let known = image::open(site.path("glb/site_texture_1.known.png")).unwrap().to_rgb8();
    assert_eq!((known.width() * 4, at(&known)), (page.width(), [0; 3]));
    let coverage = &report["export"]["baked"]["coverage"];
    assert!(coverage["nothing"].as_f64().unwrap() > 0.0 && coverage["photographed"].as_f64().unwrap() > 0.05);
}

#[test]
fn what_no_photo_shows_continues_from_what_is_around_it_backdrops_too_and_is_nowhere_grey() {
    if adapter().is_none() {
        return;
    }
    let site = Site::new();
    // Photos without grey: a texel that is grey is one that was left empty.
    for name in PHOTOS {
        let colour = |x: u32, y: u32| Rgb([200 - (x / 8) as u8, 90 + (y / 8) as u8, 20]);
        RgbImage::from_fn(160, 120, colour).save(site.path("photos").join(name)).unwrap();
    }
    // A sky behind the cameras, which no photo shows, one behind the wall, which hides it, and billboards that no photo shows, whose
    // outlines are not known: an upright one, which turns, and a level one.
    let upright = |z: i32| [[-90, -90, z], [-90, 2, z], [90, 2, z], [90, -90, z]];
    let objects = [
        ("sky_0.backdrop", upright(-900)),
        ("sky_1.backdrop", upright(900)),
        ("bush.billboard", upright(14)),
        ("crown.billboard", [[-9, -50, 13], [-9, -50, 90], [9, -50, 90], [9, -50, 13]]),
    ];
    let mut model = fs::read_to_string(site.path("model.obj")).unwrap();
    let mut at = model.lines().filter(|line| line.starts_with("v ")).count() + 1;
    for (name, corners) in objects {
        model += &format!("o {name}\n");
        model.extend(corners.map(|[x, y, z]| format!("v {x} {y} {z}\n")));
        model += &format!("f {} {} {} {}\n", at + 3, at + 2, at + 1, at);
        at += corners.len();
    }
    fs::write(site.path("model.obj"), model).unwrap();
    site.make_project();
    site.run("build project").success();
    let done = export(&site, "--format glb --png --out glb");
    let left_out = done["export"]["left_out"].to_string();
    assert!(left_out.contains("2 faces of billboards, because no photo shows what is cut out"), "{left_out}");
    let (json, _) = chunks(&site.path("glb/site.glb"));
    assert!(!json["meshes"].to_string().contains("billboard"), "{}", json["meshes"]);
    for object in ["shed", "sky_0.backdrop", "sky_1.backdrop"] {
        let (corners, page) = corners(&site.path("glb/site.glb"), object);
        let middle = corners.iter().map(|(_, place)| *place).sum::<DVec2>() / corners.len() as f64;
        let [x, y] = [middle.x * f64::from(page.width()), middle.y * f64::from(page.height())];
        let [red, green, blue] = page.get_pixel(x as u32, y as u32).0;
        println!("{object}: {red} {green} {blue}");
        assert!(red > green && green > blue + 30, "{object}: {red} {green} {blue}");
    }
}

#[test]
fn a_usd_stage_has_the_objects_and_the_photos_cameras() {
    let Some(site) = smooth_site() else { return };
    export(&site, "--format usd --out usd");
    let text = fs::read_to_string(site.path("usd/site.usda")).unwrap();
    for name in ["wall", "shed", "floor", "box_0", "left_png", "north_side_t_r_2_png"] {
        assert!(text.contains(&format!(" \"{name}\"")), "{name} is missing");
    }
    assert!(text.contains("custom string quadratura:file = \"../photos/left.png\""), "{text}");
    assert!(site.path("usd/site.usdz").metadata().unwrap().len() > text.len() as u64);
}

#[test]
fn textures_larger_than_a_page_are_as_fine_as_one_holds_and_that_is_said() {
    if adapter().is_none() {
        return;
    }
    // The wall is 40 units wide, and photos show it with 640 / 12 pixels per unit.
    let site = Site::with_photos(&PHOTOS, 640, 480, 1);
    site.make_project();
    site.run("build project").success();
    for format in ["obj", "usd", "glb"] {
        let done =
            export(&site, &format!("--format {format} --page-size 1024 --density 100000 --out {format}"));
        let pages = done["export"]["baked"]["pages"].as_array().unwrap();
        let side = |page: &Value| page.as_array().unwrap().iter().map(|side| side.as_u64().unwrap()).max();
        assert!(pages.iter().all(|page| side(page) <= Some(1024)), "{format}: {pages:?}");
        let density = done["export"]["baked"]["density"].as_f64().unwrap();
        assert!(density <= 1024.0 / 40.0, "{format}: {density}");
        let said = done["export"]["left_out"].to_string();
        assert!(said.contains("larger than a page of 1024 x 1024 texels"), "{format}: {said}");
    }
    // The pictures have the size that is reported.
    for entry in fs::read_dir(site.path("obj")).unwrap().map(|entry| entry.unwrap().path()) {
        let is_picture = entry.extension().is_some_and(|ending| ending == "jpg" || ending == "png");
        let size = is_picture.then(|| image::image_dimensions(&entry).unwrap());
        assert!(
            size.is_none_or(|(width, height)| width.max(height) <= 1024),
            "{}: {size:?}",
            entry.display()
        );
    }
    let refused = stderr_of(&site.run("export project --format glb --page-size 16384 --out x").code(2));
    assert!(refused.contains("16384") && refused.contains("8192") && !site.path("x").exists(), "{refused}");
}

#[test]
fn less_memory_changes_nothing_where_the_textures_of_a_chart_fit() {
    let Some(site) = smooth_site() else { return };
    export(&site, "--format obj --page-size 1024 --memory 4G --out much");
    export(&site, "--format obj --page-size 1024 --memory 64M --out little");
    for entry in fs::read_dir(site.path("much")).unwrap() {
        let name = entry.unwrap().file_name();
        let bytes = |folder: &str| fs::read(site.path(folder).join(&name)).unwrap();
        assert!(bytes("much") == bytes("little"), "{}", name.display());
    }
}

#[test]
fn arguments_of_other_formats_are_refused_and_the_same_export_has_the_same_bytes() {
    let Some(site) = smooth_site() else { return };
    for (arguments, expected) in [
        ("--format psd --density 40", "--density does not apply to layered files"),
        ("--format glb --up y", "--up does not apply to glb; it is for --format obj"),
        ("--format cameras --holes", "--holes does not apply to cameras"),
    ] {
        let said = stderr_of(&site.run(&format!("export project {arguments} --out x")).code(2));
        assert!(said.contains(expected), "{said}");
    }
    let bytes = |folder: &str| -> PathBuf {
        export(&site, &format!("--format glb --page-size 1024 --out {folder}"));
        site.path(folder).join("site.glb")
    };
    assert_eq!(fs::read(bytes("a")).unwrap(), fs::read(bytes("b")).unwrap());
}
