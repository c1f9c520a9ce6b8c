//! Killed while it imports: the paint of before is there, or that of after, whole.

use std::process::{Command, Stdio};
use std::time::Instant;

use super::paper::Paper;
use super::site::program;
use super::{RED, Studio, paint_of};

const ROUNDS: u32 = 25;

#[test]
fn a_killed_import_loses_nothing_and_the_next_one_leaves_no_litter() {
    let Some(studio) = Studio::new("psd") else { return };
    let project = studio.site.project();
    let mut paper = Paper::read(&studio.file());
    let places = paper.sheet("wall").pixels_where(true);
    let start = || {
        Command::new(program())
            .current_dir(studio.site.folder.path())
            .args(["import", "project", "layers/left.png.psd", "-q"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap()
    };
    // How long an import takes on this machine: the others are killed at all stages of it.
    paper.sheet("wall").paint(places[0].0, places[0].1, RED);
    paper.write(&studio.file());
    let started = Instant::now();
    assert!(start().wait().unwrap().success());
    let whole = started.elapsed();
    let mut before = paint_of(&project);
    assert_eq!(before.len(), 1);
    let mut killed = 0;
    for round in 0..ROUNDS {
        let (x, y) = places[37 * (round as usize + 1)];
        paper.sheet("wall").paint(x, y, RED);
        paper.write(&studio.file());
        let mut import = start();
        std::thread::sleep(whole * round / ROUNDS);
        import.kill().unwrap();
        killed += usize::from(!import.wait().unwrap().success());
        let after = paint_of(&project);
        let is_before = after == before;
        assert!(is_before || after.contains_key(&(x, y)), "half an import in round {round}");
        assert!(before.keys().all(|place| after.contains_key(place)), "paint was lost in round {round}");
        before = after;
    }
    assert!(killed >= 3, "the imports end before they are killed");
    let report = studio.import();
    assert_eq!(paint_of(&project).len(), 1 + ROUNDS as usize, "{report:#}");
    let book = quadratura::testing::io::paint_store::PaintStore::new(&project).read().unwrap();
    let named = book.files().len();
    let files = super::tree(&project.join("paint"));
    let pictures =
        files.keys().filter(|file| file.is_file() && file.extension().is_some_and(|e| e == "png")).count();
    assert_eq!(pictures, named, "nothing is left over: {:?}", files.keys());
    assert!(files.keys().all(|file| !file.to_string_lossy().contains("quadratura-")), "no unfinished file");
}
