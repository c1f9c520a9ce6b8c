//! `ldi build`, `ldi info`, `ldi render` and `ldi export` on the tiny site.

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

#[test]
fn an_image_is_exported_as_a_page_and_as_a_mesh_and_nothing_of_others_is_overwritten() {
    let Some(site) = Site::built() else { return };
    site.run("ldi build project --photo left --out left.ldi").success();
    let page = site.json("ldi export left.ldi --format page --out page --caption Square --json");
    assert!(page["bytes"].as_u64().unwrap() > 0 && page["triangles"].as_u64().unwrap() > 1, "{page:#}");
    assert_eq!(page["safe_region"]["across"].as_array().unwrap().len(), 16, "{page:#}");
    for file in page["files"].as_array().unwrap() {
        let path = site.path("page").join(file["name"].as_str().unwrap());
        assert_eq!(fs::metadata(path).unwrap().len(), file["bytes"].as_u64().unwrap(), "{file}");
    }
    assert!(fs::read_to_string(site.path("page/index.html")).unwrap().contains("<title>Square</title>"));
    // An unchanged page is replaced; a changed one stays.
    site.run("ldi export left.ldi --format page --out page").success();
    fs::write(site.path("page/index.html"), "mine").unwrap();
    let noted = stderr_of(&site.run("ldi export left.ldi --format page --out page").success());
    assert!(noted.contains("page-2") && site.path("page-2/index.html").is_file(), "{noted}");
    assert_eq!(fs::read_to_string(site.path("page/index.html")).unwrap(), "mine");

    let mesh = site.json("ldi export left.ldi --format glb --out meshes/left.glb --json");
    let bytes = fs::read(site.path("meshes/left.glb")).unwrap();
    assert_eq!((bytes.len() as u64, &bytes[..4]), (mesh["bytes"].as_u64().unwrap(), &b"glTF"[..]));
    let folder = stderr_of(&site.run("ldi export project --format glb --out x.glb").failure().code(1));
    assert!(folder.contains("cache/ldi"), "{folder}");
    site.run("ldi export left.ldi --format glb --out x.glb --quality 0").failure().code(2);
}

#[test]
fn views_are_made_from_layered_depth_images_instead_of_the_model() {
    let Some(site) = Site::built() else { return };
    let photo = image::open(site.path("photos/left.png")).unwrap().to_rgb8();
    for (name, words) in [
        ("stacks", "--as ldi"),
        ("photos", "--as ldi --from photos --merge keep"),
        ("published", "--as ldi --published --splat pixel"),
        ("photo", "--as photo"),
    ] {
        let words = format!("render project --cameras photos --out {name} {words} --json");
        let rendered = site.json(&words);
        assert_eq!(rendered["problems"].as_array().unwrap().len(), 0, "{rendered:#}");
        // Its own camera shows the photo, whatever the way: rounded by exposures, mixed by a millionth, or, by the published
        // rule, averaged with the other photo where depths are alike.
        let own = image::open(site.path(name).join("left.png")).unwrap().to_rgba8();
        let off: Vec<f64> = own
            .pixels()
            .zip(photo.pixels())
            .filter(|(own, _)| own[3] == 255)
            .map(|(own, photo)| (0..3).map(|c| f64::from(own[c].abs_diff(photo[c]))).sum::<f64>() / 3.0)
            .collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        let most = if name == "published" { 60.0 } else { 3.0 };
        assert!(off.len() > 10_000 && mean < most, "{name}: {mean} of {}", off.len());
    }
    let refused =
        stderr_of(&site.run("render project --cameras photos --out item --as ldi --show item").failure());
    assert!(refused.contains("--as"), "{refused}");
    // Arguments without an effect are refused, not ignored.
    for (words, named) in [
        ("--as ldi --guard 0.1", "--from photos"),
        ("--as ldi --splat over", "--splat"),
        ("--from photos", "--as ldi"),
        ("--as photo --best 2", "--best"),
    ] {
        let refused =
            site.run(&format!("render project --cameras photos --out none {words}")).failure().code(1);
        assert!(stderr_of(&refused).contains(named), "{words}: {}", stderr_of(&refused));
    }
    let built = stderr_of(&site.run("ldi build project --hidden").failure().code(1));
    assert!(built.contains("--hidden"), "{built}");
    let scored = site.json("score project --as ldi --json");
    assert_eq!(
        (&scored["asked"]["as"], scored["photos"].as_array().unwrap().len()),
        (&"ldi of stack".into(), 2)
    );
    assert!(scored["mean"]["coverage"].as_f64().unwrap() > 0.3, "{scored:#}");
}

#[test]
fn several_photos_become_one_image_with_a_guard_band() {
    let Some(site) = Site::built() else { return };
    let made = site.json("ldi build project --photo left --from photos --out both.ldi --json");
    assert!(made["images"][0]["report"]["depth_complexity"].as_f64().unwrap() > 1.0, "{made:#}");
    let info = site.json("ldi info both.ldi --json");
    assert_eq!((&info["kind"], info["sources"].as_array().unwrap().len()), (&"photos".into(), 2));
    assert_eq!(info["camera"]["width"], 160 + 2 * 48);
    let published =
        site.json("ldi build project --photo left --from photos --published --out as1997.ldi --json");
    assert_eq!(published["images"][0]["report"]["options"]["published"], "true");
    let refused = stderr_of(&site.run("ldi build project --from photos").failure());
    assert!(refused.contains("--out"), "{refused}");
    let unknown = stderr_of(
        &site.run("ldi build project --photo left --from photos --with nobody --out x.ldi").failure(),
    );
    assert!(unknown.contains("nobody"), "{unknown}");
    site.run("ldi build project --photo left --from photos --guard 3 --out x.ldi").failure().code(2);
}

#[test]
fn images_are_exported_as_layers_and_points() {
    let Some(site) = Site::built() else { return };
    site.run("ldi build project --photo left --out left.ldi").success();
    let layers = site.json("ldi export left.ldi --format layers --out layers --json");
    assert!(
        site.path("layers/ldi.json").is_file() && site.path("layers/depth-00.png").is_file(),
        "{layers:#}"
    );
    let points = site.json("ldi export left.ldi --format ply --out left.ply --json");
    let info = site.json("ldi info left.ldi --json");
    let all = points["points"].as_u64().unwrap() + points["at_infinity"].as_u64().unwrap();
    assert_eq!(all, info["depth_pixels"].as_u64().unwrap());
    fs::write(site.path("other.ply"), "a letter").unwrap();
    let noted = stderr_of(&site.run("ldi export left.ldi --format ply --out other.ply").success());
    assert!(noted.contains("other-2.ply"), "{noted}");
    assert_eq!(fs::read_to_string(site.path("other.ply")).unwrap(), "a letter");
}

#[test]
fn depth_images_from_elsewhere_become_one_image() {
    let site = Site::new();
    let depths = |file: &str, shift: f32| {
        let mut bytes = b"Pf\n160 120\n-1.0\n".to_vec();
        let value = |i: usize| if i % 160 < 80 { 4.0 + shift } else { 8.0 };
        (0..160 * 120).for_each(|i| bytes.extend(value(i).to_le_bytes()));
        fs::write(site.path(file), bytes).unwrap();
    };
    depths("a.pfm", 0.0);
    depths("b.pfm", 0.5);
    let camera = |x: f64| {
        format!(
            r#"{{"K": [[160, 0, 80], [0, 160, 60], [0, 0, 1]], "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [{x}, 0, 0]}}"#
        )
    };
    let image = |colour: &str, depth: &str, camera: &str| {
        format!(r#"{{"colour": "photos/{colour}", "depth": "{depth}", "camera": {camera}, "kind": "axis"}}"#)
    };
    let list = |images: &[String]| {
        fs::write(site.path("list.json"), format!(r#"{{"version": 1, "images": [{}]}}"#, images.join(", ")))
            .unwrap();
    };
    let [a, b] = [image(PHOTOS[0], "a.pfm", &camera(0.0)), image(PHOTOS[1], "b.pfm", &camera(-0.5))];
    list(&[a.clone(), b]);
    let made = site.json(&format!(
        "ldi build --depth-images list.json --reference photos/{} --out all.ldi --json",
        PHOTOS[0]
    ));
    assert!(made["images"][0]["report"]["depth_complexity"].as_f64().unwrap() > 1.0, "{made:#}");
    let info = site.json("ldi info all.ldi --json");
    assert_eq!((&info["kind"], info["sources"].as_array().unwrap().len()), (&"depth".into(), 2));
    site.run("ldi render all.ldi --out views").success();
    // One that cannot be used does not stop the others.
    list(&[a, image(PHOTOS[1], "gone.pfm", &camera(-0.5))]);
    let words = format!("ldi build --depth-images list.json --reference photos/{} --out one.ldi", PHOTOS[0]);
    let failed = stderr_of(&site.run(&words).failure().code(1));
    assert!(failed.contains("gone.pfm") && site.path("one.ldi").is_file(), "{failed}");
    let refused =
        stderr_of(&site.run("ldi build --depth-images list.json --reference nobody --out x.ldi").failure());
    assert!(refused.contains("nobody") || refused.contains("gone.pfm"), "{refused}");
    site.run("ldi build").failure().code(2);
}
