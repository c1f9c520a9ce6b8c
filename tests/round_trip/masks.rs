//! A layer called `mask`: what is painted in it is no content of the photo, and can be taken back like paint.

use std::collections::BTreeSet;

use quadratura::testing::geometry::PixelRect;
use quadratura::testing::io::mask_file::read_mask;
use quadratura::testing::layered_files::{Depth, Raster};

use super::paper::{Paper, Sheet};
use super::site::json_of;
use super::{RED, SOFT, Studio, layer, paint_the_wall, tree};

/// An empty layer of the photo's size, shifted by where the photo lies on the canvas.
fn sheet(name: &str, depth: Depth) -> Sheet {
    let rect = PixelRect { x: 0, y: 0, w: 160, h: 120 };
    Sheet { name: name.into(), rect, pixels: Raster::blank(160, 120, depth), visible: false, id: None }
}

/// A stroke of opaque pixels; a soft one beside it masks nothing.
fn stroke(sheet: &mut Sheet) -> BTreeSet<(i32, i32)> {
    let opaque: BTreeSet<_> = (30..70).flat_map(|x| (x / 3..x / 3 + 9).map(move |y| (x, y))).collect();
    opaque.iter().for_each(|&(x, y)| sheet.paint(x, y, RED));
    (30..70).for_each(|x| sheet.paint(x, x / 3 + 40, SOFT));
    opaque
}

/// What the project masks of its photo.
fn masked(studio: &Studio) -> BTreeSet<(i32, i32)> {
    let listed = studio.site.json("mask project --json");
    let Some(file) = listed["photos"][0]["masks"][0]["file"].as_str() else { return BTreeSet::new() };
    let masked = read_mask(&studio.site.path("project/masks").join(file), [160, 120]).unwrap();
    masked.iter().flat_map(|(y, run)| run.clone().map(move |x| (x, y))).collect()
}

#[test]
fn exactly_what_is_painted_in_a_layer_called_mask_is_masked_and_paint_comes_home_beside_it() {
    for format in ["psd", "ora", "xcf"] {
        let Some(studio) = Studio::new(format) else { return };
        let mut paper = Paper::read(&studio.file());
        let paint = paint_the_wall(&mut paper, [0, 0]);
        let mut mask = sheet("Mask #1", paper.depth);
        let expected = stroke(&mut mask);
        paper.sheets.push(mask);
        paper.write(&studio.file());
        let report = studio.import();
        assert_eq!(masked(&studio), expected, "{format}");
        assert_eq!(studio.paint(), paint, "{format}");
        let message = layer(&report, "Mask");
        assert_eq!(
            (&message["state"], &message["changed"]),
            (&"mask".into(), &expected.len().into()),
            "{report:#}"
        );
        assert_eq!(studio.import()["import"], serde_json::Value::Null, "the same again changes nothing");
    }
}

#[test]
fn an_imported_mask_is_replaced_by_the_next_one_of_its_file_and_taken_back_with_its_import() {
    let Some(studio) = Studio::new("psd") else { return };
    let before = tree(&studio.site.project());
    let mut paper = Paper::read(&studio.file());
    let mut mask = sheet("mask", paper.depth);
    let first = stroke(&mut mask);
    paper.sheets.push(mask);
    paper.write(&studio.file());
    assert_eq!(studio.import()["import"], 1);
    paper.sheets.last_mut().unwrap().paint(5, 5, RED);
    paper.write(&studio.file());
    let second = studio.import();
    assert_eq!((&second["import"], &second["changed"]), (&2.into(), &1.into()));
    assert!(masked(&studio).contains(&(5, 5)));
    studio.site.run("import project --undo").success();
    assert_eq!(masked(&studio), first);
    studio.site.run("import project --undo").success();
    assert!(masked(&studio).is_empty());
    studio.site.run("mask project --find").success();
    let files = |tree: std::collections::BTreeMap<_, Vec<u8>>| tree.into_iter().collect::<Vec<_>>();
    let authored = studio.site.path("project/project.json");
    assert_eq!(std::fs::read(&authored).unwrap(), before[&authored]);
    assert!(
        files(tree(&studio.site.path("project/stacks"))).iter().all(|(path, bytes)| before[path] == *bytes)
    );
}

#[test]
fn an_import_that_cannot_be_written_masks_nothing_either() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let (x, y) = paper.sheet("wall").pixels_where(true)[3];
    paper.sheet("wall").paint(x, y, RED);
    paper.write(&studio.file());
    studio.import();
    // Something stands where the import would say what it has begun.
    let obstacle = studio.site.path("project/paint/unfinished.txt");
    std::fs::create_dir(&obstacle).unwrap();
    let mut mask = sheet("mask", paper.depth);
    let expected = stroke(&mut mask);
    paper.sheets.push(mask);
    paper.write(&studio.file());
    studio.site.run("import project layers/left.png.psd").failure();
    assert!(masked(&studio).is_empty());
    std::fs::remove_dir(&obstacle).unwrap();
    assert_eq!(studio.import()["import"], 2, "a step that can be taken back");
    assert_eq!(masked(&studio), expected);
    studio.site.run("import project --undo").success();
    assert!(masked(&studio).is_empty());
}

#[test]
fn a_dry_run_masks_nothing_and_a_layer_that_covers_everything_is_left_out() {
    let Some(studio) = Studio::new("ora") else { return };
    let before = tree(&studio.site.project());
    let mut paper = Paper::read(&studio.file());
    let mut mask = sheet("mask", paper.depth);
    stroke(&mut mask);
    paper.sheets.push(mask);
    paper.write(&studio.file());
    let report = studio.import_with("--dry-run");
    assert!(report["changed"].as_u64().unwrap() > 0 && tree(&studio.site.project()) == before, "{report:#}");

    let whole = paper.sheets.last_mut().unwrap();
    (0..160).for_each(|x| (0..120).for_each(|y| whole.paint(x, y, RED)));
    paper.write(&studio.file());
    let report = json_of(&studio.site.run("import project layers/left.png.ora --json").failure().code(1));
    assert_eq!(layer(&report, "mask")["state"], "left-out", "{report:#}");
    assert!(masked(&studio).is_empty() && tree(&studio.site.project()) == before);
}

#[test]
fn a_picture_called_mask_in_a_folder_of_layers_is_one_too_wherever_the_canvas_lies() {
    let Some(studio) = Studio::new("folder") else { return };
    let mut picture = image::RgbaImage::new(160, 120);
    (20..40).for_each(|x| picture.put_pixel(x, 7, image::Rgba([0, 0, 0, 255])));
    picture.save(studio.file().join("mask.png")).unwrap();
    studio.import();
    assert_eq!(masked(&studio), (20..40).map(|x| (x, 7)).collect());

    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let mut mask = sheet("mask", paper.depth);
    let expected = stroke(&mut mask);
    paper.sheets.push(mask);
    paper.on_canvas(300, 200, 17, 9).write(&studio.file());
    studio.import();
    assert_eq!(masked(&studio), expected);
}
