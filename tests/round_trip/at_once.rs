//! Edits of a whole image: it is mirrored or turned and comes home all the same; what loses colours is refused, and what
//! else changes nearly everything is a question. And what is undone out of order.

use std::fs;
use std::process::{Command, Stdio};
use std::time::Duration;

use moxcms::ColorProfile;
use quadratura::testing::geometry::PixelRect;
use quadratura::testing::layered_files::Raster;
use serde_json::Value;

use super::paper::{Colour, Paper, Sheet};
use super::psd_file::{Coding, File, Layer};
use super::site::program;
use super::{RED, Studio, json_of, layer, paint_the_wall, stderr_of, stdout_of};

/// Where an editor puts the pixel (x, y) of an image of w x h, whether the sides change places, and the words for it.
type Turn = (fn([i32; 2], [i32; 2]) -> [i32; 2], bool, &'static str);

const TURNS: [Turn; 7] = [
    (|[x, y], [w, _]| [w - 1 - x, y], false, "mirrored horizontally"),
    (|[x, y], [_, h]| [x, h - 1 - y], false, "mirrored vertically"),
    (|[x, y], [w, h]| [w - 1 - x, h - 1 - y], false, "turned by 180 degrees"),
    (|[x, y], [_, h]| [h - 1 - y, x], true, "turned by 90 degrees clockwise"),
    (|[x, y], [w, _]| [y, w - 1 - x], true, "turned by 90 degrees counter-clockwise"),
    (|[x, y], _| [y, x], true, "turned by 90 degrees clockwise and mirrored horizontally"),
    (|[x, y], [w, h]| [h - 1 - y, w - 1 - x], true, "turned by 90 degrees clockwise and mirrored vertically"),
];

/// A layer after a turn of a canvas of this size.
fn turned(sheet: &Sheet, (place, exchanged, _): Turn, canvas: [i32; 2]) -> Sheet {
    let (w, h) = (sheet.rect.w, sheet.rect.h);
    let corners = [[sheet.rect.x, sheet.rect.y], [sheet.rect.right() - 1, sheet.rect.bottom() - 1]];
    let [a, b] = corners.map(|corner| place(corner, canvas));
    let (w, h) = if exchanged { (h, w) } else { (w, h) };
    let rect = PixelRect { x: a[0].min(b[0]), y: a[1].min(b[1]), w, h };
    let mut pixels = Raster::blank(w, h, sheet.pixels.depth());
    for y in sheet.rect.y..sheet.rect.bottom() {
        for x in sheet.rect.x..sheet.rect.right() {
            let [u, v] = place([x, y], canvas);
            pixels.set_rgba16((u - rect.x) as u32, (v - rect.y) as u32, sheet.at(x, y));
        }
    }
    Sheet { rect, pixels, ..sheet.clone() }
}

fn turn_paper(paper: &mut Paper, turn: Turn) {
    let canvas = [paper.width as i32, paper.height as i32];
    paper.sheets = paper.sheets.iter().map(|sheet| turned(sheet, turn, canvas)).collect();
    if turn.1 {
        (paper.width, paper.height) = (paper.height, paper.width);
    }
}

#[test]
fn an_image_that_was_mirrored_or_turned_comes_home_as_if_it_had_not_been() {
    for (turn, format) in TURNS.into_iter().zip(["psd", "xcf", "ora"].into_iter().cycle()) {
        let Some(studio) = Studio::new(format) else { return };
        let mut paper = Paper::read(&studio.file());
        let painted = paint_the_wall(&mut paper, [0, 0]);
        turn_paper(&mut paper, turn);
        paper.write(&studio.file());
        let report = studio.import();
        assert_eq!(studio.paint(), painted, "{}: {report:#}", turn.2);
        assert_eq!(report["files"][0]["turned"], turn.2);
        assert!(report["files"][0]["notes"].to_string().contains(turn.2), "{report:#}");
    }
}

#[test]
fn an_image_that_was_turned_and_cropped_or_scaled_is_understood() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let painted = paint_the_wall(&mut paper, [0, 0]);
    turn_paper(&mut paper, TURNS[3]);
    paper.on_canvas(200, 300, 17, 40).write(&studio.file());
    let report = studio.import();
    assert_eq!(studio.paint(), painted, "{report:#}");
    assert_eq!(
        (&report["files"][0]["turned"], &report["files"][0]["offset"]),
        (&TURNS[3].2.into(), &vec![40, 63].into())
    );

    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    turn_paper(&mut paper, TURNS[0]);
    for sheet in &mut paper.sheets {
        let small = &sheet.pixels;
        let mut large = Raster::blank(2 * small.width(), 2 * small.height(), small.depth());
        for (x, y) in PixelRect::of_size(large.width(), large.height()).pixels() {
            let (x, y) = (x as u32, y as u32);
            large.set_rgba16(x, y, small.rgba16(x / 2, y / 2));
        }
        let PixelRect { x, y, w, h } = sheet.rect;
        sheet.rect = PixelRect { x: 2 * x, y: 2 * y, w: 2 * w, h: 2 * h };
        sheet.pixels = large;
    }
    (paper.width, paper.height) = (2 * paper.width, 2 * paper.height);
    paper.write(&studio.file());
    let refused = stderr_of(&studio.site.run("import project layers/left.png.psd").code(1));
    assert!(refused.contains("mirrored horizontally and scaled to 2.0000"), "{refused}");
}

#[test]
fn a_layer_that_was_mirrored_by_itself_comes_home_to_its_place() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let painted = paint_the_wall(&mut paper, [0, 0]);
    let wall = paper.sheet("wall");
    // About its own middle, as an editor does it.
    let PixelRect { x, w, .. } = wall.rect;
    let about = 2 * x + w as i32;
    *wall = turned(wall, TURNS[0], [about, 0]);
    paper.write(&studio.file());
    let report = studio.import();
    assert_eq!(studio.paint(), painted, "{report:#}");
    assert_eq!(layer(&report, "wall")["turned"], "mirrored horizontally");
    assert_eq!(report["files"][0]["turned"], Value::Null);
}

#[test]
fn files_of_a_folder_that_were_turned_at_their_places_are_turned_back_small_ones_too() {
    type Edit = fn(&image::DynamicImage) -> image::DynamicImage;
    let edits: [(Edit, &str); 3] = [
        (image::DynamicImage::fliph, "mirrored horizontally"),
        (image::DynamicImage::rotate180, "turned by 180 degrees"),
        (image::DynamicImage::rotate90, "turned by 90 degrees clockwise"),
    ];
    for (edit, words) in edits {
        let Some(studio) = Studio::new("folder") else { return };
        let mut turned = 0;
        for file in fs::read_dir(studio.file()).unwrap().map(|entry| entry.unwrap().path()) {
            if file.file_name().unwrap().to_string_lossy().starts_with("order-") {
                edit(&image::open(&file).unwrap()).save(&file).unwrap();
                turned += 1;
            }
        }
        assert!(turned > 1);
        let report = studio.import();
        assert!(studio.paint().is_empty(), "{words}: {report:#}");
        assert!(report["files"][0]["notes"].to_string().contains(words), "{report:#}");
        assert_eq!(report["files"][0]["turned"], Value::Null);
    }
}

/// Brightens every pixel of all image layers by a curve.
fn graded(paper: &mut Paper) {
    for sheet in paper.image_layers() {
        for (x, y) in sheet.pixels_where(true) {
            let brighter = |value: u16| 257 * (255.0 * (f64::from(value) / 65535.0).powf(0.6)).round() as u16;
            let [r, g, b, a] = sheet.at(x, y);
            sheet.paint(x, y, [brighter(r), brighter(g), brighter(b), a]);
        }
    }
}

#[test]
fn a_grade_of_everything_is_a_question_that_all_answers() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    graded(&mut paper);
    paper.write(&studio.file());
    for options in ["", "--dry-run"] {
        let asked = studio.site.run(&format!("import project layers/left.png.psd --json {options}")).code(1);
        let report = json_of(&asked);
        assert_eq!(
            (&report["import"], &report["files"]),
            (&Value::Null, &Value::Array(vec![])),
            "{report:#}"
        );
        let question = &report["questioned"][0]["question"];
        assert_eq!(question["layers"], question["of_layers"], "{report:#}");
        assert_eq!(question["kind"], "curve", "{report:#}");
        assert!(report["problems"][0].as_str().unwrap().contains("--all"), "{report:#}");
        assert!(studio.paint().is_empty());
    }
    let asked = studio.site.run("import project layers/left.png.psd").code(1);
    let (said, why) = (stdout_of(&asked), stderr_of(&asked));
    assert!(said.contains("painted") && said.contains("nothing changed"), "{said}");
    assert!(why.contains("changed at once") && why.contains("`quadratura import project --all"), "{why}");
    let all = studio.import_with("--all");
    let expected: usize = paper.image_layers().map(|sheet| sheet.pixels_where(true).len()).sum();
    assert!(all["changed"].as_u64().unwrap() > expected as u64 / 2, "{all:#}");
    // What was imported once is no question again, and the way back is none.
    let (x, y) = paper.sheet("wall").pixels_where(true)[5];
    paper.sheet("wall").paint(x, y, RED);
    paper.write(&studio.file());
    assert_eq!(studio.import()["changed"], 1);
    studio.site.run("import project --undo").success();
    studio.site.run("import project --undo").success();
    assert!(studio.paint().is_empty());
}

#[test]
fn a_watch_keeps_a_file_with_a_question_for_all() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    graded(&mut paper);
    paper.write(&studio.file());
    // It never ends by itself with `--once`, because nothing was imported.
    let mut watch = Command::new(program())
        .current_dir(studio.site.folder.path())
        .args(["watch", "project", "layers", "--once"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_secs(4));
    watch.kill().unwrap();
    let output = watch.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(said.matches("changed at once").count(), 1, "asked once: {said}");
    assert!(studio.paint().is_empty());
    assert!(studio.import_with("--all")["changed"].as_u64().unwrap() > 0);
}

#[test]
fn another_profile_that_was_only_assigned_changes_nothing() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let (x, y) = paper.sheet("wall").pixels_where(true)[40];
    paper.sheet("wall").paint(x, y, RED);
    paper.icc = Some(ColorProfile::new_adobe_rgb().encode().unwrap());
    paper.write(&studio.file());
    let report = studio.import();
    assert_eq!(studio.paint(), [((x, y), RED)].into(), "{report:#}");
    assert!(report["files"][0]["notes"].to_string().contains("assigned"), "{report:#}");
}

#[test]
fn an_image_in_greyscale_is_refused_with_what_to_do() {
    let Some(studio) = Studio::new("psd") else { return };
    let paper = Paper::read(&studio.file());
    let layers = paper.sheets.iter().map(|sheet| {
        let PixelRect { x, y, w, h } = sheet.rect;
        let values: Vec<Colour> = PixelRect::of_size(w, h)
            .pixels()
            .map(|(x, y)| sheet.pixels.rgba16(x as u32, y as u32).map(|value| value / 257))
            .collect();
        let grey = values.iter().map(|[r, g, b, _]| (r + g + b) / 3).collect();
        let alpha = values.iter().map(|colour| colour[3]).collect();
        let name = Box::leak(sheet.name.clone().into_boxed_str());
        Layer::new(name, [x, y, w as i32, h as i32], vec![(0, Coding::Rle, grey), (-1, Coding::Rle, alpha)])
    });
    let xmp = format!(
        "<x xmlns:dc='http://purl.org/dc/elements/1.1/'><dc:identifier>{}</dc:identifier></x>",
        paper.key
    );
    let resources = vec![(1060, xmp.into_bytes())];
    let file =
        File { canvas: [paper.width, paper.height], mode: 1, resources, ..File::new(8, layers.collect()) };
    fs::write(studio.file(), file.bytes()).unwrap();
    let why = stderr_of(&studio.site.run("import project layers/left.png.psd").code(1));
    assert!(why.contains("greyscale") && why.contains("convert the image to RGB"), "{why}");
    assert!(studio.paint().is_empty());
}

#[test]
fn an_edit_that_was_undone_in_the_editor_is_told_as_that() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let before = paper.sheet("wall").clone();
    let painted = paint_the_wall(&mut paper, [0, 0]);
    paper.write(&studio.file());
    studio.import();
    *paper.sheet("wall") = before;
    paper.write(&studio.file());
    let said = stdout_of(&studio.site.run("import project layers/left.png.psd").success());
    let removed = format!("{} pixels of earlier paint removed", painted.len());
    assert!(said.contains("paint removed") && said.contains(&removed), "{said}");
    let unchanged = paper.image_layers().count() - 1;
    assert!(said.contains(&format!("{unchanged} layer")), "the others: {said}");
}

#[test]
fn an_import_is_undone_by_its_number_where_no_later_one_depends_on_it() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let mut paint = |name: &str, colour: Colour| {
        let (x, y) = paper.sheet(name).pixels_where(true)[30];
        paper.sheet(name).paint(x, y, colour);
        paper.write(&studio.file());
        studio.import();
        (x, y)
    };
    paint("wall", RED);
    let on_box = paint("box", [0, 65535, 0, 65535]);
    let undone = studio.site.json("import project --undo 1 --json");
    assert_eq!(undone["undone"]["import"], 1);
    assert_eq!(studio.paint().keys().copied().collect::<Vec<_>>(), [on_box]);
    // The file still has the stroke, which its next save brings back.
    assert_eq!(studio.import()["changed"], 1);
    let mut again = Paper::read(&studio.file());
    let (x, y) = again.sheet("wall").pixels_where(true)[90];
    again.sheet("wall").paint(x, y, RED);
    again.write(&studio.file());
    studio.import();
    let why = stderr_of(&studio.site.run("import project --undo 3").code(1));
    assert!(why.contains("undo import 4 first"), "{why}");
}
