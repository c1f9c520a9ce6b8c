//! Where paint is seen: exceptions by photo, surface and import, and what a photo keeps.

use std::collections::{BTreeMap, BTreeSet};

use quadratura::task::Task;
use quadratura::testing::document::Decisions;
use quadratura::testing::io::stack_store::StackStore;
use quadratura::testing::layers::fill::{FillOptions, OnlyHere, Propagation};
use quadratura::testing::layers::{Faces, Options};
use quadratura::testing::scene::FaceIndex;
use quadratura::testing::stacks::fill::{FillInputs, FillRequest, FillState, FilledPhoto, fill};

use super::bench::{Bench, facade};
use super::propagated::{BEHIND, BLEED, bench, clean, laid_over, paint_scrawl, propagating, stack_of};

fn everywhere() -> FillOptions {
    propagating(&["*"])
}

fn only_here(only_here: OnlyHere) -> FillOptions {
    FillOptions { only_here, ..everywhere() }
}

fn of_photo(photo: &str) -> OnlyHere {
    OnlyHere { photos: BTreeSet::from([photo.to_owned()]), ..OnlyHere::default() }
}

fn on(faces: Faces) -> OnlyHere {
    OnlyHere { surfaces: BTreeSet::from([faces]), ..OnlyHere::default() }
}

fn of_import(number: u32) -> OnlyHere {
    OnlyHere { imports: BTreeSet::from([number]), ..OnlyHere::default() }
}

fn states(bench: &Bench, options: &FillOptions) -> Vec<FillState> {
    let stacks: Vec<_> = (0..3).map(|photo| Some(stack_of(bench, photo))).collect();
    let opened = bench.opened();
    let inputs =
        FillInputs::new(bench.folder.path(), &opened.project, &opened.site, &stacks, options).unwrap();
    stacks.iter().flatten().map(|stack| FillState::new(stack, &inputs)).collect()
}

/// The files of the photos on which nothing was painted: the scrawls are painted on photo 0.
fn files_of_others(bench: &Bench) -> BTreeMap<String, Vec<u8>> {
    // The folder of each version has a name of its own.
    let unversioned = |name: String| {
        (name.split('/').next().unwrap().to_owned(), name.rsplit('/').next().unwrap().to_owned())
    };
    let files = bench.files().into_iter().map(|(name, bytes)| (unversioned(name), bytes));
    let others = files.filter(|((photo, _), _)| !photo.starts_with("0.png"));
    others.map(|((photo, file), bytes)| (format!("{photo}/{file}"), bytes)).collect()
}

fn fill_again(bench: &Bench, options: &FillOptions) {
    let request =
        FillRequest { options: options.clone(), force: true, memory: 1 << 30, ..FillRequest::default() };
    let opened = bench.opened();
    let filled = fill(bench.folder.path(), &opened.project, &opened.site, &request, &Task::silent()).unwrap();
    assert!(filled.iter().all(|photo| photo.stack.is_ok()));
    StackStore::new(bench.folder.path()).clear_former().unwrap();
}

#[test]
fn paint_that_stays_in_its_photo_changes_no_byte_of_the_others_and_makes_none_of_them_stale() {
    let bench = bench();
    fill_again(&bench, &everywhere());
    let before = files_of_others(&bench);
    paint_scrawl(&bench, 0, BLEED, clean);
    // The cube hides this one from photo 0, so that others would be filled from its paint, too.
    paint_scrawl(&bench, 0, BEHIND, |_| [0, 65535, 0, 65535]);
    let both = OnlyHere { imports: BTreeSet::from([1, 2]), ..OnlyHere::default() };
    let face = Faces { object: "wall".into(), faces: vec![FaceIndex(0)] };
    for exception in [of_photo("0.png"), on(Faces::whole("wall")), on(face), both] {
        let options = only_here(exception);
        assert_eq!(states(&bench, &options)[1..], [FillState::Current; 2], "{options:?}");
        fill_again(&bench, &options);
        assert!(files_of_others(&bench) == before, "{options:?}");
    }
    fill_again(&bench, &everywhere());
    assert!(files_of_others(&bench) != before, "it is seen elsewhere once it may be");
}

#[test]
fn of_two_imports_the_one_that_may_be_seen_elsewhere_is_and_the_other_is_not() {
    let bench = bench();
    paint_scrawl(&bench, 0, BLEED, clean);
    let below = [BLEED[0], BLEED[1], 1.2, 2.4];
    paint_scrawl(&bench, 0, below, |_| [0, 0, 65535, 65535]);
    let seen = |options: &FillOptions| {
        let filled = bench.fill(options);
        let laid = laid_over(&bench, filled[1].stack.as_ref().unwrap());
        [BLEED, below].map(|[x0, x1, z0, z1]| {
            let within = |point: glam::DVec3| (x0..x1).contains(&point.x) && (z0..z1).contains(&point.z);
            let at = bench.pixels_where(1, within);
            assert!(at.len() > 300);
            at.iter().filter(|at| laid.contains_key(*at)).count() * 100 / at.len()
        })
    };
    assert_eq!(seen(&everywhere()), [100, 100]);
    assert_eq!(seen(&only_here(of_import(1))), [0, 100]);
    assert_eq!(seen(&only_here(of_import(2))), [100, 0]);
    assert_eq!(seen(&only_here(on(Faces::whole("ground")))), [100, 100]);
}

/// The number of pixels of each photo that paint of others replaces.
fn replaced(filled: &[FilledPhoto]) -> Vec<u64> {
    filled.iter().map(|photo| photo.propagated.iter().map(|paint| paint.texels).sum()).collect()
}

#[test]
fn a_protected_photo_keeps_its_pixels_and_a_choice_of_none_is_as_no_choice() {
    let bench = bench();
    paint_scrawl(&bench, 0, BLEED, clean);
    let protected = FillOptions { protected: BTreeSet::from(["1.png".to_owned()]), ..everywhere() };
    let [_, one, two] = replaced(&bench.fill(&protected))[..] else { panic!("three photos") };
    assert!(one == 0 && two > 500, "{one} {two}");
    bench.fill(&FillOptions::default());
    let none = FillOptions { propagate: Propagation::None, ..FillOptions::default() };
    assert_eq!(
        states(&bench, &none),
        [FillState::Current; 3],
        "an answer that changes nothing fills nothing again"
    );
}

#[test]
fn pins_and_exclusions_win_over_paint_of_other_photos() {
    let bench = bench();
    paint_scrawl(&bench, 0, BLEED, clean);
    let with = |photo: &str, decide: fn(&mut quadratura::testing::document::PhotoDecisions)| {
        let mut opened = bench.opened();
        let mut decisions = Decisions::default();
        let mut decided = decisions.of(photo);
        decide(&mut decided);
        decisions.set(photo, decided);
        opened.project.decisions = decisions;
        let request = FillRequest { options: everywhere(), memory: 1 << 30, ..FillRequest::default() };
        replaced(
            &fill(bench.folder.path(), &opened.project, &opened.site, &request, &Task::silent()).unwrap(),
        )
    };
    let free = with("1.png", |_| ());
    assert!(free[0] == 0 && free[1] > 500 && free[2] > 500, "{free:?}");
    assert_eq!(with("1.png", |decided| decided.pin.push(Faces::whole("wall"))), [0, 0, free[2]]);
    assert_eq!(with("2.png", |decided| decided.exclude.push(Faces::whole("wall"))), [0, free[1], 0]);
    let painter = with("0.png", |decided| decided.exclude.push(Faces::whole("wall")));
    assert_eq!(painter, [0, 0, 0], "a photo that does not texture the wall does not paint it either");
}

#[test]
fn paint_less_than_half_as_fine_leaves_visible_pixels_alone_and_is_counted() {
    // The photos are taken from nearly the same place, the first one at this share of the others' resolution.
    for (share, is_seen) in [(0.6, true), (0.4, false)] {
        let bench = Bench::with_first_at(share, facade);
        bench.build(Options::default());
        paint_scrawl(&bench, 0, BLEED, |_| [0, 0, 65535, 65535]);
        let filled = bench.fill(&everywhere());
        let paint = &filled[2].propagated[0];
        let (seen, coarse) = (paint.texels, paint.coarse);
        assert!(seen + coarse > 500, "{paint:?}");
        assert!(if is_seen { coarse == 0 } else { seen == 0 }, "{share}: {paint:?}");
        assert_eq!(laid_over(&bench, filled[2].stack.as_ref().unwrap()).len() as u64, seen);
    }
}
