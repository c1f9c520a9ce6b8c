//! The site's frame and orthophotos: what the commands say, write and refuse.

use std::fs;

use super::site::{Site, stderr_of, stdout_of};

/// The wall of the tiny site, which both photos show.
const WALL: &str = "wall[0]";

#[test]
fn a_frame_is_set_shown_and_forgotten() {
    let site = Site::new();
    site.make_project();
    let before = fs::read_to_string(site.path("project/project.json")).unwrap();
    let shown = stdout_of(&site.run("frame project").success());
    assert!(shown.contains("not set") && shown.contains("--scale A B 12.34"), "{shown}");
    let set = site.json(&format!("frame project --level cameras --scale {WALL}:0 {WALL}:1 5m --json"));
    let scale = set["frame"]["scale"]["value"].as_f64().unwrap();
    assert!(scale > 0.0 && set["changed"] == true, "{set}");
    assert!(set["frame"]["scale"]["from"].as_str().unwrap().contains("5 m from"), "{set}");
    let north = site.json("frame project --north 0,0,0 0,0,1 --azimuth 90 --origin 1,2,3 --json");
    assert_eq!(north["frame"]["origin"]["value"], serde_json::json!([1.0, 2.0, 3.0]));
    // The cameras look along z, up is -y: what is east of them is along z, so north is along -x.
    let x = north["frame"]["north"]["value"][0].as_f64().unwrap();
    assert!((x + 1.0).abs() < 1e-9, "{north}");
    let shown = stdout_of(&site.run("frame project").success());
    assert!(shown.contains("the mean up direction of the cameras"), "{shown}");
    site.run("frame project --reset").success();
    assert_eq!(fs::read_to_string(site.path("project/project.json")).unwrap(), before);
}

#[test]
fn points_and_parts_that_say_nothing_are_refused_and_nothing_changes() {
    let site = Site::new();
    site.make_project();
    let before = fs::read_to_string(site.path("project/project.json")).unwrap();
    for (given, meant) in [
        (format!("--scale {WALL}:0 {WALL}:0 5"), "are the same point"),
        (format!("--scale {WALL}:0 nothing[0]:1 5"), "there is no object \"nothing\""),
        (format!("--scale {WALL}:0 {WALL}:99 5"), "there is no corner 99"),
        ("--origin left:9000,10".to_owned(), "is not in left"),
        ("--origin somewhere".to_owned(), "is not a point; write OBJECT[FACE]:CORNER"),
        (format!("--north {WALL}:0 {WALL}:1"), "give --level, too"),
        ("--crs EPSG:25832 --offset 1 2 3".to_owned(), "give --level and --scale and --north, too"),
        ("--level nowhere".to_owned(), "there is no object \"nowhere\""),
    ] {
        let refused = stderr_of(&site.run(&format!("frame project {given}")).failure());
        assert!(refused.contains(meant), "{given}: {refused}");
    }
    for (given, meant) in [
        (format!("--scale {WALL}:0 {WALL}:1 0"), "is no length above 0"),
        ("--unit furlong".to_owned(), "invalid value"),
        ("--crs 7 --offset 1 2 3".to_owned(), "such as EPSG:25832"),
        ("--remove everything".to_owned(), "invalid value"),
    ] {
        let refused = stderr_of(&site.run(&format!("frame project {given}")).code(2));
        assert!(refused.contains(meant), "{given}: {refused}");
    }
    assert_eq!(fs::read_to_string(site.path("project/project.json")).unwrap(), before);
}

#[test]
fn a_damaged_frame_and_a_newer_project_are_named() {
    let site = Site::new();
    site.make_project();
    let path = site.path("project/project.json");
    let before = fs::read_to_string(&path).unwrap();
    let with = |frame: &str| before.replacen('{', &format!("{{ \"frame\": {frame}, "), 1);
    fs::write(&path, with(r#"{"scale": {"value": 0, "from": "me"}}"#)).unwrap();
    let refused = stderr_of(&site.run("frame project").failure());
    assert!(refused.contains("project.json") && refused.contains("a number above 0"), "{refused}");
    fs::write(&path, before.replace("\"version\": 1", "\"version\": 99")).unwrap();
    let refused = stderr_of(&site.run("frame project").failure());
    assert!(refused.contains("version 99"), "{refused}");
}

#[test]
fn exports_are_in_the_frame_unless_the_world_is_asked_for() {
    let site = Site::new();
    site.make_project();
    site.run("export project --format cameras --out plain").success();
    site.run(&format!("frame project --scale {WALL}:0 {WALL}:1 100")).success();
    let said = stdout_of(&site.run("export project --format cameras --out framed").success());
    assert!(said.contains("the site's frame"), "{said}");
    site.run("export project --format cameras --world --out world").success();
    let read = |folder: &str| fs::read_to_string(site.path(&format!("{folder}/cameras.json"))).unwrap();
    assert_eq!(read("plain"), read("world"));
    assert_ne!(read("plain"), read("framed"));
    let refused = stderr_of(&site.run("export project --world --out layers").code(2));
    assert!(refused.contains("--world does not apply to layered files"), "{refused}");
}

#[test]
fn pictures_of_cameras_in_the_frame_are_those_of_the_photos() {
    let Some(site) = Site::built() else { return };
    let no_frame = stderr_of(&site.run("render project --cameras sparse --in-frame --out none").failure());
    assert!(no_frame.contains("the site has no frame"), "{no_frame}");
    site.run(&format!("frame project --level cameras --scale {WALL}:0 {WALL}:1 5m --origin 1,2,3")).success();
    site.run("export project --format cameras --out cameras").success();
    site.run("render project --cameras photos --out expected").success();
    let same = |folder: &str, file: &str, expected: &str| {
        let pixels = |file: &str| image::open(site.path(file)).unwrap().into_rgb8().into_raw();
        let (found, expected) = (pixels(&format!("{folder}/{file}")), pixels(expected));
        let off = found.iter().zip(&expected).filter(|(a, b)| a.abs_diff(**b) > 2).count();
        // Poses are the same but for the rounding of what is written; few pixels at edges may flip.
        assert!(
            found.len() == expected.len() && 100 * off <= found.len(),
            "{folder}: {off} of {}",
            found.len()
        );
    };
    for (number, cameras) in ["cameras/transforms.json", "cameras/sparse/0"].into_iter().enumerate() {
        let out = format!("found-{number}");
        site.run(&format!("render project --cameras {cameras} --in-frame --out {out}")).success();
        same(&out, "left.png", "expected/left.png");
    }
}

#[test]
fn an_orthophoto_needs_a_scale_and_says_how_to_set_one() {
    let site = Site::new();
    site.make_project();
    let refused =
        stderr_of(&site.run(&format!("ortho project --on {WALL} --scale 1:10 --out out")).failure());
    assert!(refused.contains("quadratura frame SITE --scale"), "{refused}");
    for (given, meant) in [
        ("--scale 1:10 --out out", "--on"),
        (&format!("--on {WALL} --out out"), "give the resolution"),
        (&format!("--on {WALL} --scale 1:10 --dpi 300 --gsd 2mm --out out"), "give two of them"),
        (&format!("--on {WALL} --scale ten --out out"), "is no scale"),
        (&format!("--on {WALL} --gsd 2mm --name a/b --out out"), "without folder"),
    ] {
        let refused = stderr_of(&site.run(&format!("ortho project {given}")).code(2));
        assert!(refused.contains(meant), "{given}: {refused}");
    }
    site.run("frame project --unit m").success();
    for (given, meant) in [
        ("--on nothing --gsd 2mm", "there is no object \"nothing\""),
        (&format!("--on {WALL} --gsd 0.0001mm"), "pixels at most"),
        (&format!("--on {WALL} --gsd 2mm --memory 1M"), "give --memory"),
        (&format!("--section {WALL}:0 {WALL}:0 --gsd 2mm"), "the same point or above each other"),
    ] {
        let refused = stderr_of(&site.run(&format!("ortho project {given} --out out")).failure());
        assert!(refused.contains(meant), "{given}: {refused}");
    }
    assert!(!site.path("out").exists());
}

#[test]
fn an_orthophoto_has_a_picture_a_page_its_sources_and_its_place_and_keeps_what_was_changed() {
    let Some(site) = Site::built() else { return };
    site.run("frame project --unit m").success();
    let made =
        site.json(&format!("ortho project --on {WALL} --gsd 50mm --out out --format tiff,png,pdf --json"));
    let files: Vec<&str> =
        made["files"].as_array().unwrap().iter().map(|file| file.as_str().unwrap()).collect();
    let expected = ["wall_0.tif", "wall_0.png", "wall_0.pdf", "wall_0.provenance.png", "wall_0.json"];
    assert_eq!(files, expected);
    for file in expected {
        assert!(site.path(&format!("out/{file}")).is_file(), "{file}");
    }
    let [width, height] = [0, 1].map(|at| made["size_px"][at].as_u64().unwrap() as u32);
    for file in ["out/wall_0.tif", "out/wall_0.png"] {
        assert_eq!(image::image_dimensions(site.path(file)).unwrap(), (width, height), "{file}");
    }
    let record = made["shares"]["photographed"].as_f64().unwrap();
    // The photos show a part of the wall, which runs far beyond them.
    assert!(record > 0.05 && record < 0.5, "{made}");
    // Again the same bytes, in the same place.
    let first = fs::read(site.path("out/wall_0.tif")).unwrap();
    site.run(&format!("ortho project --on {WALL} --gsd 50mm --out out --format tiff,png,pdf")).success();
    assert_eq!(fs::read(site.path("out/wall_0.tif")).unwrap(), first);
    assert!(!site.path("out/wall_0-2.tif").exists());
    fs::write(site.path("out/wall_0.png"), "mine").unwrap();
    let again =
        site.run(&format!("ortho project --on {WALL} --gsd 50mm --out out --format tiff,png,pdf")).success();
    assert!(stderr_of(&again).contains("they are kept"), "{}", stderr_of(&again));
    assert_eq!(fs::read_to_string(site.path("out/wall_0.png")).unwrap(), "mine");
    assert!(site.path("out/wall_0-2.png").is_file());
}
