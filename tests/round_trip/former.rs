//! Files of a former program (`tests/former`) open, are up to date, and import.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::common::adapter;
use crate::paper::{Colour, Paper};
use crate::site::Site;
use crate::{copy, paint_of};

const GREEN: Colour = [0, 200 * 257, 0, 65535];

/// A copy of the files; the folder goes with it.
fn former() -> Site {
    let site = Site { folder: tempfile::tempdir().unwrap() };
    copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/former"), site.folder.path());
    site
}

#[test]
fn a_former_project_has_its_decisions_and_its_paint_and_its_layers_are_made_anew() {
    if adapter().is_none() {
        return;
    }
    let site = former();
    let before = paint_of(&site.project());
    // Stacks have surroundings now, which those of before do not have.
    for (command, word) in [("build", "built"), ("fill", "filled"), ("build", "up to date")] {
        let done = site.json(&format!("{command} project --json"));
        let photos = done["photos"].as_array().unwrap();
        assert!(photos.len() == 2 && photos.iter().all(|p| p["state"] == word), "{command}: {done:#}");
    }
    assert_eq!(paint_of(&site.project()), before);
    let decided = site.json("decide project --json");
    let text = decided["photos"].to_string();
    assert!(text.contains("Gable box") && text.contains("floor"), "{decided:#}");
    assert_eq!(decided["problems"].as_array().unwrap().len(), 0, "{decided:#}");
    assert_eq!(paint_of(&site.project()).len(), 24);
    let undone = site.json("import project --undo --json");
    assert!(paint_of(&site.project()).is_empty(), "{undone:#}");
}

#[test]
fn a_former_export_of_every_format_comes_back_unchanged_and_then_with_what_was_painted() {
    for file in ["psd/left.png.psd", "xcf/left.png.xcf", "ora/left.png.ora", "folder/left.png.layers"] {
        let site = former();
        let path: PathBuf = site.path("exports").join(file);
        let before = paint_of(&site.project());
        let import = format!("import project exports/{file} --json");
        site.json(&import);
        assert_eq!(paint_of(&site.project()), before, "{file}: nothing was painted");

        let mut paper = Paper::read(&path);
        let wall = paper.sheet("wall");
        let painted: BTreeMap<(i32, i32), Colour> = [((8, 9), GREEN), ((9, 9), GREEN)].into();
        painted.iter().for_each(|((x, y), colour)| wall.paint(*x, *y, *colour));
        paper.write(&path);
        site.json(&import);
        let mut after = paint_of(&site.project());
        after.retain(|pixel, _| !before.contains_key(pixel));
        assert_eq!(after, painted, "{file}");
    }
}
