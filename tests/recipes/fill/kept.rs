//! Fillings after a change of paint: only what the paint concerns is computed anew, and the files are those of a
//! complete filling.

use std::collections::BTreeMap;

use quadratura::task::Task;
use quadratura::testing::document::paint::ERASED;
use quadratura::testing::layers::Options;
use quadratura::testing::layers::fill::{FillOptions, Invent};
use quadratura::testing::stacks::fill::{FillRequest, FilledPhoto, fill};

use super::bench::Bench;
use super::propagated::{BEHIND, BLEED, BLUE, clean, paint, paint_scrawl, propagating, take_back};

/// A part of the ground.
const GROUND: (&str, [[i32; 2]; 2]) = ("ground", [[100, 215], [130, 230]]);

fn filled(bench: &Bench, options: &FillOptions, force: bool) -> Vec<FilledPhoto> {
    let request =
        FillRequest { options: options.clone(), photos: vec![], memory: 1 << 30, force, keep_former: false };
    let opened = bench.opened();
    let filled = fill(bench.folder.path(), &opened.project, &opened.site, &request, &Task::silent()).unwrap();
    assert!(filled.iter().all(|photo| photo.stack.is_ok()));
    filled
}

/// The texels that a filling computed anew, by photo, after which the files are compared with those of a complete
/// filling.
fn anew(bench: &Bench, options: &FillOptions, what: &str) -> Vec<u64> {
    let partial = filled(bench, options, false);
    let partial_files = bench.files();
    let whole = filled(bench, options, true);
    let whole_files = bench.files();
    let differing = |files: &BTreeMap<String, Vec<u8>>| {
        files
            .iter()
            .filter(|(name, bytes)| whole_files.get(*name) != Some(*bytes))
            .map(|(name, _)| name.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(differing(&partial_files), Vec::<String>::new(), "{what}");
    assert_eq!(partial_files.len(), whole_files.len());
    for (partial, whole) in partial.iter().zip(&whole) {
        assert_eq!(partial.stack.as_ref().unwrap(), whole.stack.as_ref().unwrap(), "{what}: {}", whole.photo);
        assert_eq!(partial.propagated, whole.propagated);
    }
    partial.iter().map(|photo| photo.anew).collect()
}

#[test]
fn after_each_stroke_the_files_are_those_of_a_complete_filling() {
    for options in [FillOptions::default(), propagating(&["*"]), propagating(&["1.png"])] {
        let bench = Bench::courtyard();
        bench.build(Options::default());
        let whole: u64 = filled(&bench, &options, false).iter().map(|photo| photo.anew).sum();
        assert!(whole > 0);
        let mut least = whole;
        let mut stroke = |what: &str| {
            let sum: u64 = anew(&bench, &options, what).iter().sum();
            assert!(sum <= whole, "{what}: {sum} of {whole}");
            least = least.min(sum);
        };
        paint_scrawl(&bench, 0, BLEED, |_| BLUE);
        stroke("the first stroke");
        paint_scrawl(&bench, 1, BEHIND, clean);
        stroke("one behind the cube, of another photo");
        take_back(&bench);
        stroke("without it");
        paint_scrawl(&bench, 2, BEHIND, |_| ERASED);
        stroke("erased");
        let (object, [[x0, y0], [x1, y1]]) = GROUND;
        let pixels: Vec<_> = (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y, BLUE))).collect();
        paint(&bench, 1, object, &pixels);
        stroke("on the ground");
        paint(&bench, 1, "cube", &[(150, 140, BLUE), (151, 140, BLUE), (150, 141, BLUE)]);
        stroke("on the cube");
        assert!(least < whole / 2, "{least} of {whole} texels are computed anew at least");
    }
}

#[test]
fn a_filling_with_other_options_or_with_files_changed_by_hand_is_made_anew_as_a_whole() {
    let bench = Bench::courtyard();
    bench.build(Options::default());
    let whole: Vec<u64> =
        filled(&bench, &FillOptions::default(), false).iter().map(|photo| photo.anew).collect();
    let diffuse = FillOptions { invent: Invent::Diffusion, ..Default::default() };
    assert_eq!(anew(&bench, &diffuse, "options"), whole);
    paint_scrawl(&bench, 0, BLEED, |_| BLUE);
    let files = bench.files();
    let name = files.keys().find(|name| name.starts_with("1.png") && name.ends_with(".filled.png")).unwrap();
    let path = bench.folder.path().join("stacks").join(name);
    std::fs::write(&path, &files[files.keys().rfind(|n| n.ends_with(".filled.png")).unwrap()]).unwrap();
    let partial = filled(&bench, &diffuse, false);
    assert_eq!(partial[1].anew, whole[1], "nothing is taken from files that somebody else wrote");
    assert!(partial[2].anew < whole[2]);
    assert_eq!(partial[1].kept.len(), 1, "and that file is kept");
}

#[test]
fn a_photo_that_changes_leaves_the_fillings_that_take_nothing_from_it() {
    let bench = Bench::two_courtyards();
    bench.build(Options::default());
    let options = FillOptions::default();
    assert!(filled(&bench, &options, false).iter().all(|photo| photo.anew > 0));
    bench.repaint(3, [250, 0, 0], |point| (point.x - 101.0).abs() < 1.0 && (3.0..6.0).contains(&point.z));
    bench.build(Options::default());
    let partial = filled(&bench, &options, false);
    let up_to_date: Vec<bool> = partial.iter().map(|photo| photo.up_to_date).collect();
    assert_eq!(up_to_date, [true, true, false, false], "the first courtyard sees nothing of the second");
    assert_eq!(anew(&bench, &options, "nothing has changed since"), [0; 4]);
}
