//! What is damaged is named, with what is lost and what to do; all else goes on.

use std::fs;
use std::path::{Path, PathBuf};

use super::paper::Paper;
use super::{RED, SOFT, Studio, json_of, layer, paint_the_wall, stderr_of, stdout_of};

/// All pictures of paint.
fn pictures(studio: &Studio) -> Vec<PathBuf> {
    let files = fs::read_dir(studio.site.path("project/paint/left.png")).unwrap();
    files.map(|entry| entry.unwrap().path()).collect()
}

fn cut(file: &Path) {
    let bytes = fs::read(file).unwrap();
    fs::write(file, &bytes[..bytes.len() / 2]).unwrap();
}

/// Of an exported folder, the file of the layer with this in its name.
fn file_of(studio: &Studio, name: &str) -> PathBuf {
    let files = fs::read_dir(studio.file()).unwrap().map(|entry| entry.unwrap().path());
    files.filter(|file| file.is_file()).find(|file| file.to_string_lossy().contains(name)).unwrap()
}

#[test]
fn damaged_paint_is_called_paint_and_comes_back_with_the_file_that_it_came_from() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let painted = paint_the_wall(&mut paper, [0, 0]);
    paper.write(&studio.file());
    studio.import();
    let picture = pictures(&studio).into_iter().next().unwrap();
    for damage in [cut, |file: &Path| fs::remove_file(file).unwrap()] {
        damage(&picture);
        for command in [
            "build project --json",
            "info project --json",
            "export project --format psd --out again --json",
            "render project --cameras photos --out pictures --json",
        ] {
            let done = studio.site.run(command).failure().code(1);
            let message = stderr_of(&done);
            assert!(
                message.contains("px of paint on") && message.contains("import layers/left.png.psd again"),
                "{message}"
            );
            assert!(!message.contains("stack"), "{command}: {message}");
            assert!(
                json_of(&done)["photos"].is_array() || json_of(&done)["pictures"].is_array(),
                "it went on"
            );
        }
        studio.import();
        assert_eq!(studio.paint(), painted);
        studio.site.run("info project").success();
    }
}

#[test]
fn a_layer_that_cannot_be_read_is_left_out_with_the_reason_and_the_others_are_taken() {
    for damage in [cut, |file: &Path| fs::write(file, "no picture").unwrap()] {
        let Some(studio) = Studio::new("folder") else { return };
        let mut paper = Paper::read(&studio.file());
        let painted = paint_the_wall(&mut paper, [0, 0]);
        paper.write(&studio.file());
        damage(&file_of(&studio, "box"));
        let done = studio.site.run("import project layers/left.png.layers --json").failure().code(1);
        let report = json_of(&done);
        assert_eq!(layer(&report, "box")["state"], "left-out");
        let message = stderr_of(&done);
        assert!(
            message.contains("left out") && message.contains("box") && message.contains("save it again"),
            "{message}"
        );
        assert_eq!(studio.paint(), painted);
    }
}

#[test]
fn where_the_kept_pixels_are_gone_those_of_the_same_stack_will_do_and_else_nothing_is_guessed() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let mut painted = paint_the_wall(&mut paper, [0, 0]);
    paper.write(&studio.file());
    studio.import();
    fs::remove_dir_all(studio.site.path("project/exports/pixels")).unwrap();
    let (x, y) = paper.sheet("wall").pixels_where(true)[3];
    paper.sheet("wall").paint(x, y, RED);
    painted.insert((x, y), RED);
    paper.write(&studio.file());
    studio.import();
    assert_eq!(studio.paint(), painted, "the paint that the project has since is no part of them");

    fs::remove_dir_all(studio.site.path("project/stacks")).unwrap();
    paper.sheet("wall").paint(x, y, SOFT);
    paper.write(&studio.file());
    let done = studio.site.run("import project layers/left.png.psd --json").failure().code(1);
    let report = json_of(&done);
    assert_eq!(layer(&report, "wall")["state"], "left-out", "{report:#}");
    assert_eq!(layer(&report, "box")["state"], "unchanged", "its hash is enough");
    assert!(stderr_of(&done).contains("export again"), "{}", stderr_of(&done));
    assert_eq!(studio.paint(), painted, "what the project has stays");
}

#[test]
fn a_psd_that_is_cut_within_its_merged_picture_is_imported_and_noted() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let painted = paint_the_wall(&mut paper, [0, 0]);
    paper.write(&studio.file());
    let bytes = fs::read(studio.file()).unwrap();
    fs::write(studio.file(), &bytes[..bytes.len() - 7]).unwrap();
    let report = studio.import();
    assert!(report["files"][0]["notes"][0].as_str().unwrap().contains("merged picture"), "{report:#}");
    assert_eq!(studio.paint(), painted);
}

#[test]
fn paint_of_a_file_and_of_its_copy_is_counted_once() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let painted = paint_the_wall(&mut paper, [0, 0]);
    paper.write(&studio.file());
    fs::copy(studio.file(), studio.site.path("layers/copy.psd")).unwrap();
    let report = studio.site.json("import project layers --json");
    assert_eq!((&report["changed"], report["files"].as_array().unwrap().len()), (&painted.len().into(), 2));
    assert_eq!(studio.paint(), painted);
}

#[test]
fn layers_of_a_folder_keep_their_names() {
    let Some(studio) = Studio::new("folder") else { return };
    let report = studio.import();
    let layers = report["files"][0]["layers"].as_array().unwrap();
    assert!(!layers.is_empty() && layers.iter().all(|layer| layer["renamed"] == false), "{report:#}");
}

#[test]
fn a_folder_with_square_brackets_as_it_was_exported_once_still_comes_home() {
    let Some(studio) = Studio::new("folder") else { return };
    let mut paper = Paper::read(&studio.file());
    let painted = paint_the_wall(&mut paper, [0, 0]);
    paper.write(&studio.file());
    let stack = studio.file().join("stack.json");
    let described = fs::read_to_string(&stack).unwrap();
    let bracketed = |text: &str| text.replace(" (", " [").replace(").png", "].png");
    fs::write(&stack, bracketed(&described)).unwrap();
    for entry in fs::read_dir(studio.file()).unwrap().map(|entry| entry.unwrap().path()) {
        let name = entry.file_name().unwrap().to_str().unwrap().to_owned();
        fs::rename(&entry, entry.with_file_name(bracketed(&name))).unwrap();
    }
    fs::rename(studio.file(), studio.site.path("layers/left.png")).unwrap();
    studio.site.run("import project layers/left.png").success();
    assert_eq!(studio.paint(), painted);
}

#[test]
fn what_cannot_be_imported_is_answered_with_what_can() {
    let Some(studio) = Studio::new("folder") else { return };
    let one = file_of(&studio, "wall");
    let message = |words: &str, last: &Path| {
        let mut command = studio.site.command(words);
        stderr_of(&command.arg(last).assert().failure().code(1))
    };
    let whole = message("import project", one.strip_prefix(studio.site.folder.path()).unwrap());
    assert!(whole.contains("give the folder") && whole.contains("layers/left.png.layers"), "{whole}");
    assert!(message("import project", Path::new("gone.psd")).contains("check the path"));
    fs::create_dir(studio.site.path("empty")).unwrap();
    assert!(message("import project", Path::new("empty")).contains("give PSD"));
    fs::write(studio.site.path("layers/file.psd"), "x").unwrap();
    assert!(message("watch project", Path::new("layers/file.psd")).contains("saves to: layers"));
}

#[test]
fn the_history_names_files_as_they_are_reached_from_here() {
    let Some(studio) = Studio::new("psd") else { return };
    let mut paper = Paper::read(&studio.file());
    let (x, y) = paper.sheet("wall").pixels_where(true)[0];
    paper.sheet("wall").paint(x, y, RED);
    paper.write(&studio.file());
    studio.import();
    let history = stdout_of(&studio.site.run("import project --history").success());
    assert!(history.contains(" layers/left.png.psd"), "{history}");
}
