//! Paint stays on its surface, whatever becomes of stacks, model and names; and imports can be taken back.

use std::fs;

use quadratura::testing::document::paint::ERASED;
use quadratura::testing::io::paint_store::PaintStore;

use super::paper::{Paper, token};
use super::site::{stderr_of, stdout_of};
use super::{RED, Studio, layer, paint_the_wall, tree};

/// A studio whose wall is painted, and the file as it was painted.
fn painted() -> Option<(Studio, Paper)> {
    let studio = Studio::new("psd")?;
    let mut paper = Paper::read(&studio.file());
    paint_the_wall(&mut paper, [0, 0]);
    paper.write(&studio.file());
    studio.import();
    Some((studio, paper))
}

/// The next export shows all paint on the surfaces where it was painted, and nothing else of it has changed.
fn assert_paint_is_kept(studio: &Studio) {
    let painted = Paper::read(&studio.export());
    let (paint, away) = (studio.site.path("project/paint"), studio.site.path("away"));
    fs::rename(&paint, &away).unwrap();
    let mut bare = Paper::read(&studio.export());
    fs::rename(&away, &paint).unwrap();
    let all = studio.paint();
    for sheet in painted.sheets.iter().filter(|sheet| token(&sheet.name).is_some()) {
        let without = bare.sheet(&sheet.name).clone();
        let rect = sheet.rect.union(&without.rect);
        for (x, y) in (rect.y..rect.bottom()).flat_map(|y| (rect.x..rect.right()).map(move |x| (x, y))) {
            let (now, then) = (sheet.at(x, y), without.at(x, y));
            let same = now == then || now[3] + then[3] == 0;
            assert!(same || all.contains_key(&(x, y)), "{}: {x}, {y}: {now:?} {then:?}", sheet.name);
        }
    }
    let layers: Vec<_> = painted.sheets.iter().filter(|sheet| token(&sheet.name).is_some()).collect();
    let mut seen = 0;
    for ((x, y), colour) in surface_paint(studio) {
        let mut shown = layers.iter().filter(|sheet| !sheet.name.contains("box")).map(|sheet| sheet.at(x, y));
        if colour == ERASED {
            assert!(shown.all(|shown| shown[3] == 0), "{x}, {y} was erased");
        } else {
            assert!(shown.any(|shown| shown == colour), "{x}, {y} should be {colour:?}");
        }
        seen += 1;
    }
    assert!(seen > 100, "{seen}");
}

/// Paint within outlines, where the photo is: rectangles of another stack may reach less far beyond it.
fn surface_paint(studio: &Studio) -> Vec<((i32, i32), super::Colour)> {
    let store = PaintStore::new(&studio.site.project());
    let book = store.read().unwrap();
    let within = book.entries.iter().filter(|entry| !entry.beyond);
    let pixels = within.flat_map(|entry| store.patch(entry).unwrap().iter().collect::<Vec<_>>());
    let in_photo = |x: i32, y: i32| (0..160).contains(&x) && (0..120).contains(&y);
    pixels.filter(|&(x, y, _)| in_photo(x, y)).map(|(x, y, colour)| ((x, y), colour)).collect()
}

#[test]
fn the_next_export_shows_the_paint_and_its_other_layers_are_untouched() {
    let Some((studio, mut paper)) = painted() else { return };
    assert_paint_is_kept(&studio);
    let mut again = Paper::read(&studio.export());
    for sheet in paper.image_layers().filter(|sheet| !sheet.name.starts_with("wall")) {
        let hash = sheet.hash();
        assert_eq!(again.sheet(&sheet.name.clone()).hash(), hash, "{}", sheet.name);
    }
    // What was exported with paint on it brings none of that again.
    let name = studio.site.path("layers/left.png-2.psd");
    Paper::read(&name).write(&name);
    let report = studio.site.json("import project layers/left.png-2.psd --json");
    assert_eq!(report["import"], serde_json::Value::Null, "{report:#}");
}

#[test]
fn stacks_built_in_another_way_show_the_same_paint() {
    let Some((studio, _)) = painted() else { return };
    fs::remove_dir_all(studio.site.path("project/stacks")).unwrap();
    fs::remove_dir_all(studio.site.path("project/cache")).unwrap();
    for options in ["--margin 9", "--boxes exact --published --margin 3", "--tolerance 0.001"] {
        studio.site.run(&format!("build project -q {options}")).success();
        assert_paint_is_kept(&studio);
    }
}

#[test]
fn a_file_exported_before_a_rebuild_still_comes_home() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let expected = paint_the_wall(&mut paper, [0, 0]);
    paper.write(&studio.file());
    fs::remove_dir_all(studio.site.path("project/stacks")).unwrap();
    studio.site.run("build project -q --margin 7 --boxes exact").success();
    studio.import();
    assert_eq!(studio.paint(), expected);
}

#[test]
fn an_object_that_was_renamed_keeps_its_paint_and_one_that_is_gone_is_told() {
    let Some((studio, mut paper)) = painted() else { return };
    let model = studio.site.path("model.obj");
    let text = fs::read_to_string(&model).unwrap();
    fs::write(&model, text.replace("o wall", "o rampart")).unwrap();
    let built = stdout_of(&studio.site.run("build project -q").success());
    assert!(!built.contains("no longer exist"), "{built}");
    let mut again = Paper::read(&studio.export());
    let rampart = again.sheet("rampart").clone();
    let wall = paper.sheet("wall");
    assert!(wall.pixels_where(true).iter().all(|&(x, y)| rampart.at(x, y) == wall.at(x, y)));

    let without: String = text.replace("o wall", "o gone").lines().map(|line| format!("{line}\n")).collect();
    let farther = without.replace(" 12\n", " 40\n");
    fs::write(&model, farther).unwrap();
    let built = studio.site.json("build project -q --json");
    assert_eq!(built["paint"]["without_place"][0]["face"], "wall[0]", "{built:#}");
    let info = stdout_of(&studio.site.run("info project").success());
    assert!(info.contains("paint on surfaces that no longer exist") && info.contains("wall[0]"), "{info}");
    fs::write(&model, text).unwrap();
    studio.site.run("build project -q").success();
    assert_paint_is_kept(&studio);
}

#[test]
fn an_import_is_told_before_it_is_made_and_taken_back_byte_for_byte() {
    let Some(studio) = Studio::new("psd") else { return };
    let project = studio.site.project();
    let mut before = vec![tree(&project)];
    let mut paper = Paper::read(&studio.file());
    for round in 1..=3 {
        let (x, y) = paper.sheet("wall").pixels_where(true)[100 * round];
        paper.sheet("wall").paint(x, y, RED);
        paper.sheet("box").paint(80 + round as i32, 60, RED);
        paper.write(&studio.file());
        let message = studio.import_with("--dry-run");
        assert_eq!((message["dry_run"].as_bool(), message["changed"].as_u64()), (Some(true), Some(2)));
        assert!(tree(&project) == before[round - 1], "a dry run writes nothing");
        let report = studio.import();
        assert_eq!(report["import"], round);
        assert_eq!(layer(&report, "wall")["changed"], 1);
        before.push(tree(&project));
    }
    let history = studio.site.json("import project --history --json");
    assert_eq!(history["imports"].as_array().unwrap().len(), 3);
    for round in (1..=3).rev() {
        assert!(tree(&project) == before[round]);
        studio.site.run("import project --undo").success();
    }
    assert!(tree(&project) == before[0], "not even an empty folder is left");
    let nothing = studio.site.run("import project --undo").failure();
    assert!(stderr_of(&nothing).contains("no import"));
}

#[test]
fn two_files_that_contradict_each_other_are_told_and_the_newer_shows() {
    let Some(studio) = Studio::new("psd") else { return };
    let other = studio.site.path("layers/copy.psd");
    let mut paper = Paper::read(&studio.file());
    let place = paper.sheet("wall").pixels_where(true)[500];
    paper.sheet("wall").paint(place.0, place.1, RED);
    paper.write(&studio.file());
    studio.import();
    let blue = [0, 0, 65535, 65535];
    paper.sheet("wall").paint(place.0, place.1, blue);
    paper.write(&other);
    let report = studio.site.json("import project layers/copy.psd --json");
    assert_eq!(layer(&report, "wall")["conflicts"][0]["pixels"], 1, "{report:#}");
    assert_eq!(studio.paint()[&place], blue);
    studio.site.run("import project --undo").success();
    assert_eq!(studio.paint()[&place], RED);
}

#[test]
fn pictures_show_the_paint() {
    let Some((studio, mut paper)) = painted() else { return };
    // A patch of pure red on the wall, large enough to be seen in a picture.
    let wall = paper.sheet("wall");
    let block: Vec<_> = wall
        .pixels_where(true)
        .into_iter()
        .filter(|(x, y)| (4..24).contains(x) && (4..24).contains(y))
        .collect();
    assert!(block.len() > 200);
    block.iter().for_each(|(x, y)| wall.paint(*x, *y, [65535, 0, 0, 65535]));
    paper.write(&studio.file());
    studio.import();
    studio.site.run("render project --cameras photos --out views --flat -q").success();
    let picture = image::open(studio.site.path("views/left.png")).unwrap().to_rgba8();
    for (x, y) in block.into_iter().filter(|(x, y)| (8..20).contains(x) && (8..20).contains(y)) {
        let pixel = picture.get_pixel(x as u32, y as u32).0;
        assert!(pixel[0] > 240 && pixel[1] < 15 && pixel[2] < 15, "{x}, {y}: {pixel:?}");
    }
}
