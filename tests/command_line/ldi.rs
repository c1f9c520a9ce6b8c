//! `ldi build`, `ldi info`, `ldi render` and `ldi export` on the tiny site.

use std::fs;

use super::common::adapter;
use super::site::{PHOTOS, Site, stderr_of, stdout_of};
use quadratura::testing::view::legend::Origin;

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
fn the_stages_of_a_view_are_timed() {
    let Some(site) = Site::built() else { return };
    site.run("ldi build project --photo left --out left.ldi").success();
    let timed = stderr_of(&site.run("ldi render left.ldi --out own --timings").success());
    assert!(["place", "draw", "resolve"].iter().all(|stage| timed.contains(stage)), "{timed}");
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
    if adapter().is_none() {
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
    for (name, words) in
        [("stacks", "--as ldi"), ("published", "--as ldi --published --splat pixel"), ("photo", "--as photo")]
    {
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
    // Arguments without an effect are refused, not ignored.
    for (words, named) in [
        ("--as ldi --guard 0.1", "--from site"),
        ("--as ldi --layers 2", "--from site or --published"),
        ("--as ldi --epsilon 0.1", "--published"),
        ("--as ldi --splat over", "--splat"),
        ("--from site", "--as ldi"),
        ("--published", "--as ldi"),
        ("--as ldi --from site --published", "--published"),
        ("--as photo --best 2", "--best"),
    ] {
        let refused =
            site.run(&format!("render project --cameras photos --out none {words}")).failure().code(2);
        assert!(stderr_of(&refused).contains(named), "{words}: {}", stderr_of(&refused));
    }
    let built = stderr_of(&site.run("ldi build project --best 2").failure().code(2));
    assert!(built.contains("--published"), "{built}");
    let scored = site.json("score project --as ldi --json");
    assert_eq!(
        (&scored["asked"]["as"], scored["photos"].as_array().unwrap().len()),
        (&"ldi of stack".into(), 2)
    );
    assert!(scored["mean"]["coverage"].as_f64().unwrap() > 0.3, "{scored:#}");
}

#[test]
fn several_photos_become_one_image_of_the_published_system() {
    let Some(site) = Site::built() else { return };
    let made = site.json("ldi build project --photo left --published --out as1997.ldi --json");
    assert!(made["images"][0]["report"]["depth_complexity"].as_f64().unwrap() > 1.0, "{made:#}");
    assert_eq!(made["images"][0]["report"]["options"]["published"], "true");
    let info = site.json("ldi info as1997.ldi --json");
    assert_eq!((&info["kind"], info["sources"].as_array().unwrap().len()), (&"photos".into(), 2));
    assert_eq!(info["camera"]["width"], 160, "there is no guard band");
    let named = site.json("ldi build project --published --with left --out named.ldi --json");
    assert_eq!(named["images"][0]["photo"], "left.png");
    let refused = stderr_of(&site.run("ldi build project --published").failure());
    assert!(refused.contains("--out"), "{refused}");
    let unknown = stderr_of(&site.run("ldi build project --published --with nobody --out x.ldi").failure());
    assert!(unknown.contains("nobody"), "{unknown}");
    for others in ["--guard 0.1", "--from site", "--from stack", "--cube"] {
        let words = format!("ldi build project --photo left --published {others} --out x.ldi");
        assert!(stderr_of(&site.run(&words).failure().code(2)).contains("--published"), "{others}");
    }
    site.run("ldi build project --photo left --from site --guard 3 --out x.ldi").failure().code(2);
}

#[test]
fn images_are_exported_as_points() {
    let Some(site) = Site::built() else { return };
    site.run("ldi build project --photo left --out left.ldi").success();
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

#[test]
fn the_image_of_the_site_has_what_its_photo_does_not_see_and_is_made_for_saved_views_too() {
    let Some(site) = Site::built() else { return };
    site.run("ldi build project --photo left --unfilled --out stack.ldi").success();
    let made = site.json("ldi build project --photo left --from site --guard 0.2 --out site.ldi --json");
    assert_eq!(made["images"][0]["report"]["dropped"], 0, "{made:#}");
    let info = site.json("ldi info site.ldi --json");
    assert_eq!((&info["kind"], &info["sources"]), (&"site".into(), &serde_json::json!(PHOTOS)));
    // The other photo's camera sees what the box hides from this one.
    let covered = |file: &str, out: &str| {
        let json = site.json(&format!("ldi render {file} --cameras sparse --out {out} --json"));
        json["pictures"]
            .as_array()
            .unwrap()
            .iter()
            .map(|picture| picture["textured"].as_f64().unwrap())
            .collect::<Vec<_>>()
    };
    let (stack, of_site) = (covered("stack.ldi", "a"), covered("site.ldi", "b"));
    assert!(of_site[1] > stack[1] + 0.01, "{of_site:?} of the site, {stack:?} of the stack");
    // In its own camera the renderer shows the photo, here between faces that are one pixel apart at most.
    let own = site.json("ldi render site.ldi --out own --json");
    let (width, height) = image::image_dimensions(site.path("photos/left.png")).unwrap();
    let picture = &own["pictures"][0];
    assert_eq!((&picture["width"], &picture["height"]), (&width.into(), &height.into()));
    let [own, photo] =
        ["own/left.png", "photos/left.png"].map(|file| image::open(site.path(file)).unwrap().to_rgba8());
    let near = own.pixels().zip(photo.pixels()).filter(|(a, b)| (0..3).all(|c| a[c].abs_diff(b[c]) <= 3));
    // Sums mix neighbours at edges of colour, and surfaces within 2 % of depth.
    assert!(near.count() as f64 > 0.95 * f64::from(width * height));

    let file = site.path("project/project.json");
    let mut project: serde_json::Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
    project["views"] = serde_json::json!([{
        "name": "gate", "position": [0, 0, 0], "rotation": [1, 0, 0, 0], "focal": [1.3, 1.3], "pivot": [0, 0, 8]
    }]);
    fs::write(&file, project.to_string()).unwrap();
    site.run(
        "ldi build project --from site --at gate --ldi-scale 0.1 --guard 0 --background none --out gate.ldi",
    )
    .success();
    let info = site.json("ldi info gate.ldi --json");
    assert_eq!((&info["kind"], &info["camera"]["width"]), (&"site".into(), &192.into()), "{info:#}");
    for (words, status, needed) in [
        ("--at gate --out x.ldi", 2, "--from site"),
        ("--from site --at gaet --out x.ldi", 1, "the nearest name is \"gate\""),
        ("--from site --photo left --best 2 --out x.ldi", 2, "--published"),
        ("--from site --photo left", 1, "--out FILE"),
    ] {
        let refused = stderr_of(&site.run(&format!("ldi build project {words}")).failure().code(status));
        assert!(refused.contains(needed), "{words}: {refused}");
    }
}

#[test]
fn the_image_of_the_site_tells_paint_and_inpainting_from_photos() {
    let Some(site) = Site::built() else { return };
    site.run("fill project").success();
    site.run("export project --out layers --format folder").success();
    super::filling::paint_the_wall(&site, "layers/left.png.layers", [250, 240, 10, 255]);
    site.run("ldi build project --photo left --out stack.ldi").success();
    site.run("ldi build project --photo left --from site --guard 0 --out site.ldi").success();
    let sources = |file: &str| {
        let words = format!(
            "ldi render {file} --cameras sparse --out {file}.views --show provenance --splat pixel --json"
        );
        let rendered = site.json(&words);
        let [own, aside] = [0, 1].map(|view| {
            let name = rendered["pictures"][view]["path"].as_str().unwrap();
            image::open(site.path(name)).unwrap().into_rgba8()
        });
        let of = |origin: Origin, picture: &image::RgbaImage| {
            let [r, g, b] = origin.colour();
            picture.pixels().map(|pixel| pixel.0 == [r, g, b, 255]).collect::<Vec<_>>()
        };
        (of(Origin::Paint, &own), of(Origin::Example, &aside))
    };
    let (of_stack, of_site) = (sources("stack.ldi"), sources("site.ldi"));
    assert_eq!(of_stack.0.iter().filter(|is_paint| **is_paint).count(), 3000);
    // The renderer mixes texels: the rim of the paint may be a pixel wider or narrower; 3000 pixels in rows have 200 at it.
    let other = of_stack.0.iter().zip(&of_site.0).filter(|(a, b)| a != b).count();
    assert!(other <= 200, "{other} pixels are paint in one image only");
    let inpainted = of_site.1.iter().filter(|is_inpainted| **is_inpainted).count();
    assert!(inpainted > 0, "what only filling knows is said to be invented");
}

#[test]
fn an_image_of_the_site_without_filling_is_another_one() {
    let Some(site) = Site::built() else { return };
    let build = "ldi build project --photo left --from site --flat --ldi-scale 0.5 --out site.ldi";
    site.run(build).success();
    site.run(&format!("{build} --unfilled")).success();
    let [filled, unfilled] = ["site.ldi", "site-2.ldi"]
        .map(|file| site.json(&format!("ldi info {file} --json"))["inputs"].clone());
    assert!(filled != unfilled, "{filled}");
}

#[test]
fn what_does_not_fit_a_format_or_a_command_is_refused_with_what_does() {
    let Some(site) = Site::built() else { return };
    site.run("ldi build project --photo left --out left.ldi").success();
    site.run("ldi render left.ldi --out own --splat pixel").success();
    let [own, photo] = ["own/left.png", "photos/left.png"].map(|file| image::open(site.path(file)).unwrap());
    assert!(own.to_rgba8() == photo.to_rgba8(), "its own camera sees the photo");
    for (words, status, needed) in [
        ("ldi export left.ldi --format ply --out x.ply --caption hello", 2, "--format page"),
        ("ldi export left.ldi --format ply --out x.obj", 2, "--out x.ply"),
        ("ldi export left.ldi --format glb --out x.gltf", 2, "--out x.glb"),
        ("ldi export left.ldi --format ply --out x.ply --quality 5", 2, "--format glb"),
        ("ldi render project --out x", 1, "it is a folder"),
        ("render project --as model --memory 1G --cameras photos --out x", 2, "--as ldi"),
        ("ldi build project --photo left --out project", 1, "no plain file"),
    ] {
        let refused = stderr_of(&site.run(words).failure().code(status));
        assert!(refused.contains(needed), "{words}: {refused}");
    }
}

#[test]
fn views_of_the_site_are_predicted_by_its_images() {
    let Some(site) = Site::built() else { return };
    let psnr = |words: &str| {
        let scored = site.json(&format!("score project --exposure raw {words} --json"));
        scored["mean"]["covered"]["psnr"].as_f64().unwrap_or_else(|| panic!("{scored:#}"))
    };
    let (model, of_site) = (psnr(""), psnr("--as ldi --from site"));
    // Two photos of a box and a floor leave few pixels in common: images of one sample a pixel lose a decibel there.
    assert!(of_site > model - 1.5, "{of_site:.2} dB from images, {model:.2} from the model");
}

#[test]
fn a_cube_around_a_photo_is_built_described_and_rendered_in_any_direction() {
    let Some(site) = Site::built() else { return };
    let words = "ldi build project --photo left --from site --ldi-scale 0.5 --cube --out cube.ldi --json";
    let built = site.json(words);
    let faces = built["images"].as_array().unwrap();
    assert_eq!((&built["arrangement"], faces.len()), (&"cube".into(), 6), "{built:#}");
    let info = site.json("ldi info cube.ldi --json");
    assert_eq!((&info["arrangement"], info["images"].as_array().unwrap().len()), (&"cube".into(), 6));
    let side = &info["images"][0]["camera"]["width"];
    assert!(side.as_u64().unwrap() % 64 == 0 && *side == info["images"][5]["camera"]["height"], "{side}");
    // Each splat can be drawn in the order of the faces; the photo's view goes across them.
    for splat in ["sums", "over", "pixel"] {
        let views =
            format!("ldi render cube.ldi --cameras sparse --out {splat} --splat {splat} --scale 0.5 --json");
        let rendered = site.json(&views);
        assert!(rendered["pictures"][0]["textured"].as_f64().unwrap() > 0.9, "{rendered:#}");
    }
    let faces = site.json("ldi render cube.ldi --out faces --json");
    let names: Vec<_> =
        faces["pictures"].as_array().unwrap().iter().map(|face| face["view"].as_str()).collect();
    assert_eq!(names, ["right", "left", "down", "up", "front", "back"].map(Some));
    // The same again replaces the file; readers of single images say what it is.
    site.run(words).success();
    assert!(!site.path("cube-2.ldi").exists());
    let refused = stderr_of(&site.run("ldi export cube.ldi --format page --out page").failure().code(1));
    assert!(refused.contains("several layered depth images"), "{refused}");
    for (words, status, named) in [
        ("--photo left --cube --out x.ldi", 2, "--from site"),
        ("--from site --cube --out x.ldi", 1, "--photo"),
    ] {
        let refused = stderr_of(&site.run(&format!("ldi build project {words}")).failure().code(status));
        assert!(refused.contains(named), "{words}: {refused}");
    }
    site.run("ldi build project --photo left --from site --cube").failure().code(2);
    // What is cut short is refused, and shown as far as it goes on request.
    let bytes = fs::read(site.path("cube.ldi")).unwrap();
    fs::write(site.path("short.ldi"), &bytes[..bytes.len() * 2 / 3]).unwrap();
    site.run("ldi render short.ldi --out none").failure().code(1);
    assert!(stdout_of(&site.run("ldi info short.ldi").failure().code(1)).contains("cube of 6"));
    site.run("ldi render short.ldi --partial --out left-over").success();
}

#[test]
fn a_set_covers_the_site_and_its_views_are_rendered_for_two_eyes() {
    let Some(site) = Site::built() else { return };
    let built = site.json("ldi build project --set 5 --out set.ldi --json");
    let images = built["images"].as_array().unwrap();
    let sum: u64 = images.iter().map(|image| image["adds"].as_u64().unwrap()).sum();
    assert!(sum == built["covered"].as_u64().unwrap() && sum > 100, "{built:#}");
    assert!(sum as f64 >= 0.99 * built["points"].as_u64().unwrap() as f64, "{built:#}");
    let one = site.run("ldi build project --set 1 --flat --out set.ldi").success();
    assert!(stderr_of(&one).contains("set-2.ldi"), "another choice is another file: {}", stderr_of(&one));
    let info = site.json("ldi info set.ldi --json");
    assert_eq!(
        (&info["arrangement"], info["images"].as_array().unwrap().len()),
        (&"set".into(), images.len())
    );
    let flat = "ldi render set.ldi --cameras sparse --size 80x60";
    let plain = site.json(&format!("{flat} --out plain --json"));
    assert!(plain["pictures"][1]["textured"].as_f64().unwrap() > 0.9, "{plain:#}");
    let stereo = site.json(&format!("{flat} --out both --stereo 0.01 --video both/film.apng --json"));
    assert_eq!(
        (&stereo["pictures"][0]["width"], &stereo["pictures"][0]["height"]),
        (&160.into(), &60.into())
    );
    assert!(site.path("both/film.apng").is_file(), "{stereo:#}");
    let noted = stderr_of(&site.run(&format!("{flat} --out far --stereo 3")).success());
    assert!(noted.contains("uncomfortable"), "{noted}");
    let refused = stderr_of(&site.run("ldi render set.ldi --out over --splat over").failure().code(1));
    assert!(refused.contains("--splat sums"), "{refused}");
    site.run("ldi render set.ldi --out none --stereo 0").failure().code(2);
}
