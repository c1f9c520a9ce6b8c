//! The layer of the surroundings out to an image editor and home again.

use std::collections::BTreeMap;
use std::fs;

use quadratura::task::Task;
use quadratura::testing::document::stack::Stack;
use quadratura::testing::import::photo::read_photo;
use quadratura::testing::io::paint_store::PaintStore;
use quadratura::testing::io::stack_store::StackStore;
use quadratura::testing::layered_files::{Raster, read_layered};
use quadratura::testing::projection::Gains;
use quadratura::testing::sites::open::open;
use quadratura::testing::stacks::surroundings::SiteSurroundings;

use super::paper::{Colour, Paper};
use super::site::Site;
use super::{RED, SOFT, Studio, layer, paint_of, stderr_of, stdout_of};

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
    let [whole, cut, red, plain] = ["surroundings", "none", "#ff0000", "sky"].map(drawn);
    let empty = cut.pixels().filter(|pixel| pixel.0[3] == 0).count() as u64;
    // Along outlines pixels are covered partly.
    assert!(empty.abs_diff(sky.texels_visible) <= 2 * 160, "{empty} and {}", sky.texels_visible);
    for (x, y, pixel) in cut.enumerate_pixels().filter(|(.., pixel)| pixel.0[3] == 0) {
        let apart = (0..3).map(|c| whole[(x, y)].0[c].abs_diff(photo[(x, y)].0[c])).max();
        assert!(apart <= Some(1) && whole[(x, y)].0[3] == 255, "{x}, {y}: {:?} {pixel:?}", whole[(x, y)]);
        assert_eq!(red[(x, y)].0, [255, 0, 0, 255], "{x}, {y}");
        assert_eq!(plain[(x, y)].0[3], 255, "{x}, {y}: the computed sky is everywhere");
    }
    assert!(plain != whole && plain != red, "it is not what the photo shows");
    let refuse = |more: &str| {
        let refused = site.run(&format!("render project --cameras photos --out views {more}")).failure();
        super::stderr_of(&refused)
    };
    assert!(refuse("--background blue").contains("surroundings, sky, none, or a colour"));
    assert!(refuse("--background sky --as ldi").contains("--background sky is for views of the model"));
}

/// A project of two photos with the same model, built and exported.
fn two_below_the_sky() -> Option<Studio> {
    super::adapter()?;
    let site = Site::with_photos(&["left.png", "right.png"], 160, 120, 1);
    let studio = Studio { site, format: "psd" };
    set_wall(&studio, -1.0);
    studio.site.make_project();
    studio.site.run("build project -q").success();
    studio.export();
    Some(studio)
}

/// The numbers of texels of a filling by the name of their source, on the last layer.
fn sources_of_sky(stack: &Stack, project: &std::path::Path) -> BTreeMap<String, usize> {
    let (layer, fill) = (stack.image_layers.last().unwrap(), stack.fill.as_ref().unwrap());
    let file = &layer.fill.as_ref().expect("the sky is filled").provenance_file;
    let path = StackStore::new(project).folder(&stack.photo.name).join(file);
    let picture = image::open(path).unwrap().to_luma16();
    let mut counts = BTreeMap::new();
    for pixel in picture.pixels() {
        // PNGs of 8 bits are read with 257 times the value.
        let number = if fill.origins.len() < 256 { pixel.0[0] / 257 } else { pixel.0[0] };
        *counts.entry(fill.origins[usize::from(number)].clone()).or_default() += 1;
    }
    counts
}

#[test]
fn the_hidden_sky_is_filled_from_other_photos_and_no_figure_of_walls_counts_it() {
    let Some(studio) = two_below_the_sky() else { return };
    studio.site.run("fill project -q").success();
    let filled = stack(&studio);
    let (layer, fill) = (filled.image_layers.last().unwrap(), filled.fill.as_ref().unwrap());
    let hidden = layer.texels_used - layer.texels_visible;
    assert!(hidden > 100);
    assert_eq!(layer.fill.as_ref().unwrap().texels_filled, hidden, "nothing of it stays empty");
    let sky = sources_of_sky(&filled, &studio.site.project());
    assert!(sky.get("right.png").is_some_and(|count| *count > 50), "{sky:?}");
    let of_faces: u64 = filled.image_layers[..filled.image_layers.len() - 1]
        .iter()
        .filter_map(|layer| Some(layer.fill.as_ref()?.texels_filled))
        .sum();
    let counted =
        fill.texels_from_photos + fill.texels_from_paint + fill.texels_by_example + fill.texels_diffused;
    assert_eq!(counted, of_faces);
    // Stacked, the layers still are the photo.
    let photo = Raster::of_photo(read_photo(&studio.site.path("photos/left.png"), 160, 120).unwrap());
    fs::remove_dir_all(studio.site.path("layers")).unwrap();
    let exported = studio.site.path("layers").join(newest(&studio));
    assert!(super::leftovers::stacked(&read_layered(&exported).unwrap().layers) == photo);
}

#[test]
fn paint_on_one_photos_sky_fills_the_hidden_sky_of_others_and_is_undone_there_too() {
    let Some(studio) = two_below_the_sky() else { return };
    studio.site.run("fill project -q").success();
    let other =
        |studio: &Studio| StackStore::new(studio.site.project()).current("right.png").unwrap().unwrap();
    let before = sources_of_sky(&other(&studio), &studio.site.project());
    let mut paper = Paper::read(&studio.file());
    let sky = paper.sheet("surroundings");
    let places = [sky.pixels_where(true), sky.pixels_where(false)].concat();
    places.iter().for_each(|(x, y)| sky.paint(*x, *y, RED));
    paper.write(&studio.file());
    studio.import();
    studio.site.run("fill project -q").success();
    let painted = sources_of_sky(&other(&studio), &studio.site.project());
    let from_paint = painted.get("[painted in left.png]").copied().unwrap_or_default();
    assert!(from_paint > 50, "{before:?} {painted:?}");
    let again = stdout_of(&studio.site.run("fill project").success());
    assert!(again.contains("0 photos filled, 2 up to date"), "{again}");
    studio.site.run("import project --undo -q").success();
    studio.site.run("fill project -q").success();
    assert_eq!(sources_of_sky(&other(&studio), &studio.site.project()), before);
}

#[test]
fn a_photo_that_is_left_out_has_no_say_in_the_dome_whatever_it_shows() {
    let Some(studio) = two_below_the_sky() else { return };
    let without_left = || {
        let task = Task::silent();
        let opened = open(&studio.site.project(), &task).unwrap();
        let store = StackStore::new(studio.site.project());
        let stacks: Vec<Option<Stack>> =
            opened.site.photos.iter().map(|photo| store.current(&photo.name).unwrap()).collect();
        let gains = Gains::none(stacks.len());
        let folder = studio.site.project();
        let mut around =
            SiteSurroundings::open(&folder, &opened.project, &opened.site, &stacks, &gains, 1 << 30, &task)
                .unwrap();
        let left = opened.site.photo_named("left.png").unwrap();
        let found = around.without(&[left], &gains, &task).unwrap();
        (around.whole().dome.clone().unwrap(), found.dome.unwrap(), found.agreement)
    };
    let (whole, dome, agreement) = without_left();
    let file = studio.site.path("photos/left.png");
    let mut photo = image::open(&file).unwrap().to_rgb8();
    photo.pixels_mut().for_each(|pixel| pixel.0 = pixel.0.map(|value| 255 - value / 2));
    photo.save(&file).unwrap();
    studio.site.run("build project -q").success();
    let (altered, dome_again, agreement_again) = without_left();
    assert!(whole != altered, "it has a say otherwise");
    assert!(dome == dome_again && agreement == agreement_again);
}

#[test]
fn the_sky_goes_out_as_a_picture_of_all_directions_and_is_replaced_by_another() {
    let Some(studio) = below_the_sky("psd") else { return };
    let site = &studio.site;
    for name in ["sky.png", "sky.hdr"] {
        let told = site.json(&format!("surroundings project --export {name} --width 64 --json"));
        assert!(told["known"].as_f64().unwrap() > 0.0 && told["photos"] == 1, "{told:#}");
        let picture = image::open(site.path(name)).unwrap();
        assert_eq!((picture.width(), picture.height()), (64, 32), "{name}");
        assert!(told["known_near"].as_f64() > told["known"].as_f64(), "{told:#}");
        let set = site.json(&format!("surroundings project --set {name} --json"));
        assert_eq!(set["picture"]["middle"], told["middle"], "{name} says where its middle looks");
        site.run("surroundings project --remove -q").success();
    }
    let refused = stderr_of(&site.run("surroundings project --export sky.png").failure());
    assert!(refused.contains("exists"), "{refused}");
    let refused = stderr_of(&site.run("surroundings project --export sky.exr").failure());
    assert!(refused.contains(".hdr"), "{refused}");

    image::RgbImage::from_pixel(48, 32, image::Rgb([9; 3])).save(site.path("wrong.png")).unwrap();
    let refused = stderr_of(&site.run("surroundings project --set wrong.png").failure());
    assert!(refused.contains("48 x 32") && refused.contains("twice as wide as high"), "{refused}");
    assert!(!fs::read_to_string(site.path("project/project.json")).unwrap().contains("surroundings"));
    image::RgbImage::from_pixel(64, 32, image::Rgb([255, 0, 0])).save(site.path("red.png")).unwrap();
    let told = stderr_of(&site.run("surroundings project --set red.png").success());
    assert!(told.contains("red.png does not say in which direction its middle is"), "{told}");
    let set = site.json("surroundings project --set red.png --middle 1,0,0 --json");
    assert_eq!((&set["picture"]["middle"][0], &set["known"]), (&1.0.into(), &1.0.into()), "{set:#}");
    site.run("surroundings project --export again.png --width 8 -q").success();
    let again = image::open(site.path("again.png")).unwrap().to_rgb8();
    assert!(again.pixels().all(|pixel| pixel.0 == [255, 0, 0]));
    fs::remove_file(site.path("red.png")).unwrap();
    let told = stderr_of(&site.run("surroundings project").success());
    assert!(told.contains("red.png") && told.contains("not used"), "{told}");
    site.run("surroundings project --remove -q").success();
    assert!(!fs::read_to_string(site.path("project/project.json")).unwrap().contains("red.png"));
}

#[test]
fn where_the_model_covers_everything_there_is_no_dome_and_all_else_works() {
    let Some(studio) = below_the_sky("psd") else { return };
    let site = &studio.site;
    set_wall(&studio, -20.0);
    site.run("build project -q").success();
    site.run("fill project -q").success();
    let told = site.json("surroundings project --json");
    assert_eq!((&told["known"], &told["photos"]), (&serde_json::Value::Null, &0.into()), "{told:#}");
    let refused = stderr_of(&site.run("surroundings project --export sky.png").failure());
    assert!(refused.contains("nothing around the model") && refused.contains("--set"), "{refused}");
    site.run("score project -q").success();
}
