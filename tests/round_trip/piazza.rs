//! The same on the sample project: a real photo with dozens of layers, of every format.

use std::collections::BTreeMap;
use std::path::Path;

use super::paper::Paper;
use super::site::json_of;
use super::{RED, SOFT, Studio, adapter, paint_of};
use quadratura::testing::document::paint::ERASED;

/// One photo of the sample, built.
fn studio() -> Option<Studio> {
    adapter()?;
    let site = super::site::Site { folder: tempfile::tempdir().unwrap() };
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("projects/piazza");
    let path = |name: &str| sample.join(name).into_os_string();
    let mut new = site.command("new project");
    new.args(["--photos".into(), path("photos"), "--cameras".into(), path("sparse")]);
    new.args(["--model".into(), path("piazza.obj")]).assert().success();
    site.run("build project --photo 01_church -q").success();
    Some(Studio { site, format: "psd" })
}

#[test]
fn on_the_sample_exactly_the_painted_pixels_of_many_layers_come_home() {
    let Some(studio) = studio() else { return };
    for format in ["psd", "ora", "xcf", "folder"] {
        let words = format!("export project --photo 01_church --format {format} --out {format} --json");
        let exported = studio.site.json(&words)["photos"][0]["path"].as_str().unwrap().to_owned();
        let file = studio.site.path(&exported);
        let import = || json_of(&studio.site.run(&format!("import project {exported} --json")).success());
        let mut paper = Paper::read(&file);
        paper.write(&file);
        let untouched = import();
        assert_eq!(untouched["import"], serde_json::Value::Null, "{format}: {untouched:#}");
        assert!(untouched["files"][0]["layers"].as_array().unwrap().len() > 10, "many layers");

        let mut expected: BTreeMap<String, u64> = BTreeMap::new();
        let mut places = BTreeMap::new();
        for sheet in paper.image_layers() {
            let (shown, empty) = (sheet.pixels_where(true), sheet.pixels_where(false));
            let strokes = shown.iter().step_by(911).map(|place| (*place, RED));
            let soft = empty.iter().step_by(1777).map(|place| (*place, SOFT));
            let erased = shown.iter().skip(300).step_by(2003).map(|place| (*place, [0; 4]));
            let strokes: Vec<_> = strokes.chain(soft).chain(erased).collect();
            let mut own = BTreeMap::new();
            for ((x, y), colour) in strokes {
                sheet.paint(x, y, colour);
                own.insert((x, y), if colour[3] == 0 { ERASED } else { colour });
            }
            expected.insert(sheet.name.clone(), own.len() as u64);
            own.into_iter()
                .for_each(|(place, colour)| places.entry(place).or_insert_with(Vec::new).push(colour));
        }
        paper.write(&file);
        let report = import();
        for layer in report["files"][0]["layers"].as_array().unwrap() {
            let name = layer["name"].as_str().unwrap();
            assert_eq!(layer["painted"].as_u64(), expected.get(name).copied(), "{format}: {layer:#}");
        }
        let paint = paint_of(&studio.site.project());
        assert_eq!(paint.len(), places.len(), "{format}: nothing else");
        assert!(paint.iter().all(|(place, colour)| places[place].contains(colour)), "{format}");
        studio.site.run("import project --undo").success();
        let left = std::fs::read_dir(studio.site.path("project/paint")).unwrap();
        let left: Vec<_> = left.map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, ["taken.json"], "{format}: taken back");
    }
}
