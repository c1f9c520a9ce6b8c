//! Strokes of the brush beside an image editor: a save there neither removes nor absorbs them.

use std::collections::BTreeMap;
use std::fs;
use std::process::{Command, Stdio};
use std::time::Instant;

use super::paper::Paper;
use super::site::program;
use super::{Colour, RED, Studio, paint_of, tree};

/// What the brush paints.
const GREEN: Colour = [0, 200 * 257, 0, 65535];

/// Writes the stroke of a hard, round brush at a pixel of the photo, in the photo's own view.
fn write_stroke(studio: &Studio, file: &str, mode: &str, [x, y]: [f64; 2]) {
    let text = format!(
        r#"{{"version": 1,
        "view": {{"width": 160, "height": 120, "camera": {{"K": [[160, 0, 80], [0, 160, 60], [0, 0, 1]],
            "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [0, 0, 0]}}}},
        "brush": {{"mode": "{mode}", "radius": 6, "hardness": 1, "colour": [0, 200, 0]}},
        "samples": [{{"at": [{x}, {y}]}}]}}"#
    );
    fs::write(studio.site.path(file), text).unwrap();
}

/// Paints a stroke on the wall and returns what it painted.
fn stroke(studio: &Studio) -> BTreeMap<(i32, i32), Colour> {
    let before = studio.paint();
    write_stroke(studio, "stroke.json", "colour", [12.5, 12.5]);
    let report = studio.site.json("stroke project stroke.json --flat --json");
    assert!(report["changed"].as_u64().unwrap() > 90, "{report:#}");
    let green = |(place, colour): ((i32, i32), Colour)| (colour == GREEN).then_some((place, colour));
    let painted: BTreeMap<_, _> = studio.paint().into_iter().filter_map(green).collect();
    assert!(painted.len() > 90 && before.keys().all(|place| studio.paint().contains_key(place)));
    painted
}

/// The paint of the brush, as the project has it.
fn is_kept(studio: &Studio, stroke: &BTreeMap<(i32, i32), Colour>) -> bool {
    let paint = studio.paint();
    stroke.iter().all(|(place, colour)| paint.get(place) == Some(colour))
}

#[test]
fn a_later_save_of_a_file_from_before_the_stroke_neither_removes_nor_absorbs_it() {
    let Some(studio) = Studio::new("psd") else { return };
    let painted = stroke(&studio);
    let mut paper = Paper::read(&studio.file());
    paper.write(&studio.file());
    assert_eq!(studio.import()["import"], serde_json::Value::Null, "an untouched file brings nothing");
    paper.sheet("wall").paint(100, 10, RED);
    paper.write(&studio.file());
    assert_eq!(studio.import()["changed"], 1);
    assert!(is_kept(&studio, &painted) && studio.paint()[&(100, 10)] == RED);
}

#[test]
fn the_export_shows_the_stroke_and_its_save_brings_only_what_was_painted_there() {
    let Some(studio) = Studio::new("psd") else { return };
    let bare = tree(&studio.site.project());
    let painted = stroke(&studio);
    let file = studio.export();
    let mut paper = Paper::read(&file);
    let wall = paper.sheet("wall");
    assert!(painted.iter().all(|((x, y), colour)| wall.at(*x, *y) == *colour), "the artist sees it");
    let (under, beside) = (*painted.keys().nth(40).unwrap(), (100, 10));
    wall.paint(beside.0, beside.1, RED);
    paper.write(&file);
    let name = file.file_name().unwrap().to_str().unwrap().to_owned();
    let import = || studio.site.json(&format!("import project layers/{name} --json"));
    assert_eq!(import()["changed"], 1, "the stroke is not absorbed");
    // What is painted on it there wins as the newest; to undo it gives the stroke back.
    paper.sheet("wall").paint(under.0, under.1, RED);
    paper.write(&file);
    let report = import();
    assert_eq!(report["changed"], 1, "{report:#}");
    assert_eq!(report["files"][0]["layers"][0]["conflicts"].as_array().map(Vec::len), Some(0), "{report:#}");
    assert_eq!(studio.paint()[&under], RED);
    studio.site.run("import project --undo").success();
    assert!(is_kept(&studio, &painted));
    studio.site.run("import project --undo").success();
    assert!(is_kept(&studio, &painted) && !studio.paint().contains_key(&beside));
    studio.site.run("import project --undo").success();
    let stripped = |tree: BTreeMap<std::path::PathBuf, Vec<u8>>| {
        let of_paint = |(path, bytes): (std::path::PathBuf, Vec<u8>)| {
            path.components().any(|part| part.as_os_str() == "paint").then_some((path, bytes))
        };
        tree.into_iter().filter_map(of_paint).collect::<BTreeMap<_, _>>()
    };
    assert!(stripped(tree(&studio.site.project())) == stripped(bare), "byte for byte");
    // The file still shows the stroke that is undone; its save does not bring it back.
    paper.sheet("wall").paint(under.0, under.1, GREEN);
    paper.sheet("wall").paint(101, 10, RED);
    paper.write(&file);
    import();
    assert!(painted.keys().all(|place| !studio.paint().contains_key(place)));
}

#[test]
fn the_eraser_removes_strokes_and_leaves_paint_of_the_image_editor() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    paper.sheet("wall").paint(12, 20, RED);
    paper.write(&studio.file());
    studio.import();
    let painted = stroke(&studio);
    write_stroke(&studio, "erase.json", "erase", [12.5, 16.5]);
    let dry = studio.site.json("stroke project erase.json --flat --dry-run --json");
    assert!(is_kept(&studio, &painted) && dry["import"].is_null());
    let erased = studio.site.json("stroke project erase.json --flat --json");
    assert_eq!(erased["changed"], dry["changed"]);
    let left = studio.paint();
    let gone = painted.keys().filter(|place| left.get(place) != Some(&GREEN)).count();
    assert_eq!(Some(gone as u64), erased["changed"].as_u64());
    assert!(gone > 30 && gone < painted.len() && left[&(12, 20)] == RED);
    let history = studio.site.json("import project --history --json");
    let brushes: Vec<_> = history["imports"].as_array().unwrap().iter().map(|i| i["brush"].clone()).collect();
    assert_eq!(brushes, [serde_json::Value::Null, "colour".into(), "erase".into()]);
    studio.site.run("import project --undo").success();
    assert!(is_kept(&studio, &painted));
}

#[test]
fn a_killed_stroke_is_there_as_a_whole_or_not_at_all() {
    const ROUNDS: u32 = 20;
    let Some(studio) = Studio::new("psd") else { return };
    let project = studio.site.project();
    let start = |round: u32| {
        let file = format!("stroke-{round}.json");
        write_stroke(&studio, &file, "colour", [8.5 + 5.0 * f64::from(round), 8.5]);
        Command::new(program())
            .current_dir(studio.site.folder.path())
            .args(["stroke", "project", &file, "--flat", "-q"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap()
    };
    let started = Instant::now();
    assert!(start(0).wait().unwrap().success());
    let whole = started.elapsed();
    let mut before = paint_of(&project).len();
    let each = before;
    let mut killed = 0;
    for round in 1..=ROUNDS {
        let mut child = start(round);
        // Some are killed, and some end before, whatever else the machine does.
        std::thread::sleep(whole * 3 * round / (2 * ROUNDS));
        child.kill().unwrap();
        killed += usize::from(!child.wait().unwrap().success());
        let after = paint_of(&project).len();
        assert!(
            after == before || after > before + each / 4,
            "half a stroke in round {round}: {before} {after}"
        );
        before = after;
    }
    assert!(killed >= 3, "the strokes end before they are killed");
    assert!(start(ROUNDS + 1).wait().unwrap().success());
    let book = quadratura::testing::io::paint_store::PaintStore::new(&project).read().unwrap();
    let files = tree(&project.join("paint"));
    let is_picture =
        |file: &&std::path::PathBuf| file.is_file() && file.extension().is_some_and(|end| end == "png");
    let pictures = files.keys().filter(is_picture).count();
    assert_eq!(pictures, book.files().len(), "nothing is left over: {:?}", files.keys());
}

#[test]
fn a_stroke_that_is_wrong_is_refused_with_its_place() {
    let Some(studio) = Studio::new("psd") else { return };
    write_stroke(&studio, "stroke.json", "clone", [12.5, 12.5]);
    let refused = studio.site.run("stroke project stroke.json").failure();
    let message = super::stderr_of(&refused);
    assert!(message.contains("stroke.json") && message.contains("source"), "{message}");
    fs::write(studio.site.path("stroke.json"), r#"{"version": 1, "brush": 3}"#).unwrap();
    let message = super::stderr_of(&studio.site.run("stroke project stroke.json").failure());
    assert!(message.contains("line 1") && message.contains("brush strokes"), "{message}");
}
