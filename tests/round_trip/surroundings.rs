//! The layer of the surroundings out to an image editor and home again.

use std::collections::BTreeMap;
use std::fs;

use quadratura::testing::document::stack::Stack;
use quadratura::testing::io::layered::{Raster, read_layered};
use quadratura::testing::io::paint_store::PaintStore;
use quadratura::testing::io::photo::read_photo;
use quadratura::testing::io::stack_store::StackStore;

use super::paper::{Colour, Paper};
use super::{RED, SOFT, Studio, layer, paint_of, stdout_of};

const FORMATS: [&str; 4] = ["psd", "ora", "xcf", "folder"];

/// A project whose wall ends below the upper edge of the photo, built and exported.
fn below_the_sky(format: &'static str) -> Option<Studio> {
    let studio = Studio::new(format)?;
    fs::remove_dir_all(studio.site.path("layers")).unwrap();
    set_wall(&studio, -1.0);
    studio.site.run("build project -q").success();
    studio.export();
    Some(studio)
}

/// Moves the upper edge of the wall, which is at -20.
fn set_wall(studio: &Studio, top: f64) {
    let model = studio.site.path("model.obj");
    let text = fs::read_to_string(&model).unwrap();
    let lines = text.lines().map(|line| match line.split(' ').collect::<Vec<_>>()[..] {
        ["v", x, _, "12"] if !line.ends_with(" 2 12") => format!("v {x} {top} 12\n"),
        _ => format!("{line}\n"),
    });
    fs::write(&model, lines.collect::<String>()).unwrap();
}

fn stack(studio: &Studio) -> Stack {
    StackStore::new(studio.site.project()).current("left.png").unwrap().unwrap()
}

/// Paints on the sky: what the photo shows of it, what is behind the wall, and erases a little.
fn paint_the_sky(paper: &mut Paper) -> BTreeMap<(i32, i32), Colour> {
    let sky = paper.sheet("surroundings");
    let (shown, empty) = (sky.pixels_where(true), sky.pixels_where(false));
    let strokes = shown.iter().step_by(53).map(|place| (*place, RED));
    let painted: BTreeMap<_, _> =
        strokes.chain(empty.iter().step_by(17).map(|place| (*place, SOFT))).collect();
    painted.iter().for_each(|((x, y), colour)| sky.paint(*x, *y, *colour));
    assert!(painted.len() > 60, "the test paints enough: {}", painted.len());
    painted
}

#[test]
fn the_sky_goes_out_in_every_format_and_comes_home_with_its_paint() {
    for format in FORMATS {
        let Some(studio) = below_the_sky(format) else { return };
        let photo = Raster::of_photo(read_photo(&studio.site.path("photos/left.png"), 160, 120).unwrap());
        let document = read_layered(&studio.file()).unwrap();
        assert!(
            super::leftovers::stacked(&document.layers) == photo,
            "{format}: the document is not the photo"
        );

        let mut paper = Paper::read(&studio.file());
        let expected = paint_the_sky(&mut paper);
        paper.write(&studio.file());
        let report = studio.import();
        assert_eq!(layer(&report, "surroundings")["state"], "painted", "{format}: {report:#}");
        assert_eq!(studio.paint(), expected, "{format}");
        let book = PaintStore::new(&studio.site.project()).read().unwrap();
        let on: Vec<_> = book.entries.iter().map(|e| (e.object.as_str(), e.face, e.beyond)).collect();
        assert_eq!(on, [("[surroundings]", None, false)], "{format}");
        let text = fs::read_to_string(studio.site.path("project/paint/paint.json")).unwrap();
        assert!(!text.contains("\"face\""), "{text}");
        assert_eq!(studio.import()["import"], serde_json::Value::Null, "{format}: nothing is new");

        // It lies on the layer from now on, and can be undone.
        let mut again = Paper::read(&studio.site.path("layers").join(newest(&studio)));
        let sky = again.sheet("surroundings");
        assert!(
            expected.iter().filter(|(_, c)| c[3] == u16::MAX).all(|(&(x, y), c)| sky.at(x, y) == *c),
            "{format}"
        );
        studio.site.run("import project --undo -q").success();
        assert!(studio.paint().is_empty(), "{format}");
    }
}

/// Exports again and returns the name of the new file.
fn newest(studio: &Studio) -> String {
    studio.export().file_name().unwrap().to_string_lossy().into_owned()
}

#[test]
fn paint_on_the_sky_survives_rebuilds_and_waits_while_there_is_no_sky() {
    let Some(studio) = below_the_sky("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let expected = paint_the_sky(&mut paper);
    paper.write(&studio.file());
    studio.import();
    studio.site.run("build project -q --reach all --boxes exact --save-options").success();
    assert_eq!(paint_of(&studio.site.project()), expected);
    let last = stack(&studio).image_layers.pop().unwrap();
    assert_eq!((last.name.as_str(), last.texels_used), ("surroundings", 160 * 120));

    set_wall(&studio, -20.0);
    let built = studio.site.json("build project -q --json");
    assert_eq!(built["paint"]["without_place"][0]["face"], "[surroundings]", "{built:#}");
    assert!(stack(&studio).image_layers.iter().all(|layer| layer.name != "surroundings"));
    assert_eq!(paint_of(&studio.site.project()), expected, "nothing is lost");
    set_wall(&studio, -1.0);
    studio.site.run("build project -q").success();
    let info = studio.site.json("info project --json");
    assert!(info["paint"]["without_place"].as_array().is_none_or(Vec::is_empty), "{info:#}");
}

#[test]
fn the_sky_is_no_hidden_part_of_the_model_and_has_a_row_of_its_own() {
    let Some(studio) = below_the_sky("psd") else { return };
    let shares = |site: &super::site::Site| site.json("info project --json")["filling"][0]["shares"].clone();
    let some = shares(&studio.site);
    studio.site.run("build project -q --reach all --save-options").success();
    let all = shares(&studio.site);
    assert_eq!(some["hidden"], all["hidden"], "however much of the sky is needed");
    let hidden = |shares: &serde_json::Value| shares["hidden_of_surroundings"].as_f64().unwrap();
    assert!(hidden(&some) > 0.0 && hidden(&all) > hidden(&some), "{some:#} {all:#}");
    studio.site.run("fill project -q").success();
    assert_eq!(shares(&studio.site)["empty"], 0.0, "the sky is not counted");
    let text = stdout_of(&studio.site.run("fill project --force").success());
    assert!(text.contains("\n  surroundings"), "{text}");
}

#[test]
fn the_sky_can_be_renamed_and_nothing_else_can_be_decided_about_it() {
    let Some(studio) = below_the_sky("psd") else { return };
    studio.site.run("decide project --photo left.png --name Sky --of [surroundings] -q").success();
    studio.site.run("build project -q").success();
    assert_eq!(stack(&studio).image_layers.last().unwrap().name, "Sky");
    let refused = studio.site.run("decide project --photo left.png --merge [surroundings] wall").failure();
    let message = super::stderr_of(&refused);
    assert!(message.contains("the surroundings lie behind everything"), "{message}");
}

#[test]
fn a_view_shows_the_sky_or_nothing_or_a_colour_where_no_surface_is() {
    let Some(studio) = below_the_sky("folder") else { return };
    let site = &studio.site;
    let sky = stack(&studio).image_layers.pop().unwrap();
    let photo = image::open(site.path("photos/left.png")).unwrap().to_rgb8();
    let drawn = |background: &str| {
        let out = format!("views-{}", background.trim_start_matches('#'));
        site.run(&format!(
            "render project --cameras photos --mode best --out {out} --background {background}"
        ))
        .success();
        image::open(site.path(&out).join("left.png")).unwrap().to_rgba8()
    };
    let [whole, cut, red] = ["surroundings", "none", "#ff0000"].map(drawn);
    let empty = cut.pixels().filter(|pixel| pixel.0[3] == 0).count() as u64;
    // Along outlines pixels are covered partly.
    assert!(empty.abs_diff(sky.texels_visible) <= 2 * 160, "{empty} and {}", sky.texels_visible);
    for (x, y, pixel) in cut.enumerate_pixels().filter(|(.., pixel)| pixel.0[3] == 0) {
        let apart = (0..3).map(|c| whole[(x, y)].0[c].abs_diff(photo[(x, y)].0[c])).max();
        assert!(apart <= Some(1) && whole[(x, y)].0[3] == 255, "{x}, {y}: {:?} {pixel:?}", whole[(x, y)]);
        assert_eq!(red[(x, y)].0, [255, 0, 0, 255], "{x}, {y}");
    }
    let refused = site.run("render project --cameras photos --out views --background sky").failure();
    assert!(super::stderr_of(&refused).contains("surroundings, none, or a colour"));
}
