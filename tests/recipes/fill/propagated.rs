//! Paint as a source of filling, and paint of one photo on the others.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use glam::DVec3;
use quadratura::task::Task;
use quadratura::testing::document::Stack;
use quadratura::testing::document::paint::{ERASED, PaintColour, PaintEntry, PaintPatch, PaintedView};
use quadratura::testing::document::stack::{LayerFill, origins};
use quadratura::testing::editing::layer_view::{LayerViewContent, layer_view};
use quadratura::testing::geometry::PixelRect;
use quadratura::testing::io::paint_store::PaintStore;
use quadratura::testing::io::stack_store::StackStore;
use quadratura::testing::layers::Options;
use quadratura::testing::layers::fill::FillOptions;
use quadratura::testing::stacks::fill::shares::layer_shares;
use quadratura::testing::stacks::fill::{FillInputs, FillRequest, FillState, FilledPhoto, fill, tell};
use quadratura::testing::stacks::layer_pixels::layer_pixels;
use quadratura::testing::stacks::paint::PhotoPaint;

use super::bench::{Bench, decode, difference, facade};

/// A scrawl on the wall, beside the cube for all three cameras.
pub const BLEED: [f64; 4] = [-4.0, -1.8, 3.3, 4.9];

/// One that the cube hides from the camera on the left, and from no other.
pub const BEHIND: [f64; 4] = [2.5, 3.3, 0.4, 1.1];

pub const BLUE: PaintColour = [0, 0, 65535, 65535];

fn is_in([x0, x1, z0, z1]: [f64; 4], point: DVec3, margin: f64) -> bool {
    (x0 - margin..x1 + margin).contains(&point.x) && (z0 - margin..z1 + margin).contains(&point.z)
}

/// The facade with two scrawls on it.
fn scrawled(point: DVec3) -> [f64; 3] {
    let on_wall = point.y > 5.9;
    let scrawled = on_wall && (is_in(BLEED, point, 0.0) || is_in(BEHIND, point, 0.0));
    if scrawled { [0.9, 0.05, 0.1] } else { facade(point) }
}

/// What is under the scrawls.
pub fn clean(point: DVec3) -> PaintColour {
    let [r, g, b] = facade(point).map(|value| (value * 65535.0) as u16);
    [r, g, b, 65535]
}

pub fn bench() -> Bench {
    let bench = Bench::photographed(scrawled);
    bench.build(Options::default());
    bench
}

pub fn stack_of(bench: &Bench, photo: usize) -> Stack {
    let store = StackStore::new(bench.folder.path());
    store.current(&format!("{photo}.png")).unwrap().unwrap()
}

/// Paints on the only face of an object, as an import would.
pub fn paint(bench: &Bench, photo: usize, object: &str, pixels: &[(i32, i32, PaintColour)]) {
    let store = PaintStore::new(bench.folder.path());
    let before = store.read().unwrap();
    let mut book = before.clone();
    let stack = stack_of(bench, photo);
    let surface = stack.surfaces.iter().find(|surface| surface.object == object).unwrap();
    let view = format!("v{photo}");
    let mut entry = PaintEntry {
        photo: stack.photo.name.clone(),
        object: object.into(),
        face: Some(surface.face),
        triangle: None,
        beyond: false,
        layer: "token".into(),
        document: "key@file.psd".into(),
        import: book.next_import(),
        view: view.clone(),
        outline: surface.outline.clone(),
        file: String::new(),
        rect: PixelRect { x: 0, y: 0, w: 0, h: 0 },
        pixels: 0,
    };
    store.add(&mut entry, &PaintPatch::of_pixels(pixels)).unwrap();
    book.views.insert(view, PaintedView { photo: stack.photo, camera: stack.camera });
    book.entries.push(entry);
    book.tidy();
    store.commit(&book, &before).unwrap();
}

/// Paints the wall where it is scrawled, and a little around.
pub fn paint_scrawl(bench: &Bench, photo: usize, scrawl: [f64; 4], colour: impl Fn(DVec3) -> PaintColour) {
    let pixels = bench.pixels_where(photo, |point| is_in(scrawl, point, 0.08));
    let painted = pixels.into_iter().map(|at| (at[0], at[1], colour(bench.on_wall(photo, at))));
    paint(bench, photo, "wall", &painted.collect::<Vec<_>>());
}

pub fn propagating(photos: &[&str]) -> FillOptions {
    FillOptions {
        propagate: photos.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>().into(),
        ..FillOptions::default()
    }
}

/// Removes the last entry of paint.
pub fn take_back(bench: &Bench) {
    let store = PaintStore::new(bench.folder.path());
    let before = store.read().unwrap();
    let mut book = before.clone();
    book.entries.pop();
    store.commit(&book, &before).unwrap();
}

/// The texels of a stack that paint of other photos was laid over: pixel of the photo, colour, origin.
pub fn laid_over(bench: &Bench, stack: &Stack) -> BTreeMap<[i32; 2], ([u16; 3], String)> {
    let folder = StackStore::new(bench.folder.path()).folder(&stack.photo.name);
    let origins = stack.fill.as_ref().map(|fill| fill.origins.clone()).unwrap_or_default();
    let mut laid = BTreeMap::new();
    for layer in &stack.image_layers {
        let Some(LayerFill { propagation_file: Some(file), provenance_file, .. }) = &layer.fill else {
            continue;
        };
        let (width, _, rgba) = decode(&folder.join(file));
        let (.., places) = decode(&folder.join(provenance_file));
        for (i, texel) in rgba.chunks_exact(4).enumerate().filter(|(_, texel)| texel[3] > 0) {
            let at = [layer.rect.x + (i as u32 % width) as i32, layer.rect.y + (i as u32 / width) as i32];
            laid.insert(at, ([texel[0], texel[1], texel[2]], origins[usize::from(places[i])].clone()));
        }
    }
    laid
}

fn stacks(filled: Vec<FilledPhoto>) -> Vec<Stack> {
    filled.into_iter().map(|photo| photo.stack.unwrap()).collect()
}

fn share_near(differences: &[f64]) -> f64 {
    differences.iter().filter(|difference| **difference < 12.0).count() as f64 / differences.len() as f64
}

#[test]
fn a_scrawl_painted_away_in_one_photo_goes_in_all_and_nothing_else_changes() {
    let bench = bench();
    paint_scrawl(&bench, 0, BLEED, clean);
    let without = stacks(bench.fill(&FillOptions::default()));
    assert!(without.iter().all(|stack| laid_over(&bench, stack).is_empty()), "nobody asked for it");
    let filled = stacks(bench.fill(&propagating(&["0.png"])));
    assert!(laid_over(&bench, &filled[0]).is_empty(), "a photo's own paint is there already");
    for (photo, stack) in filled.iter().enumerate().skip(1) {
        let laid = laid_over(&bench, stack);
        let scrawl: BTreeSet<_> =
            bench.pixels_where(photo, |point| is_in(BLEED, point, 0.0)).into_iter().collect();
        assert!(scrawl.len() > 500 && scrawl.iter().all(|at| laid.contains_key(at)), "all of it is gone");
        let around: BTreeSet<_> =
            bench.pixels_where(photo, |point| is_in(BLEED, point, 0.15)).into_iter().collect();
        assert!(laid.keys().all(|at| around.contains(at)), "and no more");
        assert!(laid.values().all(|(_, origin)| *origin == origins::painted_in("0.png")));
        let off = |(at, (rgb, _)): (&[i32; 2], &([u16; 3], String))| {
            difference(*rgb, facade(bench.on_wall(photo, *at)))
        };
        let off: Vec<f64> = laid.iter().map(off).collect();
        assert!(share_near(&off) > 0.85, "{}", share_near(&off));
    }
    // Looked at alone, a layer says whose paint it is; what lies over the photo counts to no filling of hidden parts.
    let (stack, laid) = (&filled[1], laid_over(&bench, &filled[1]).len() as u64);
    let (wall, _) = stack.numbered_layers().find(|(_, layer)| layer.name.starts_with("wall")).unwrap();
    let looked =
        layer_view(bench.folder.path(), stack, wall, LayerViewContent::Provenance, &Task::silent()).unwrap();
    let entry =
        looked.legend.iter().find(|(name, ..)| name == "paint in 0.png").expect("it is in the legend");
    assert!(entry.2 >= laid, "{entry:?}, {laid} laid");
    let shares = layer_shares(bench.folder.path(), "1.png", &Task::silent()).unwrap();
    assert_eq!(shares.iter().map(|shares| shares.propagated).sum::<u64>(), laid);
    let hidden = shares.iter().all(|shares| shares.filled() <= shares.hidden);
    assert!(hidden, "{shares:?}");
    let taken_back = stacks(bench.fill(&FillOptions::default()));
    assert!(taken_back.iter().all(|stack| laid_over(&bench, stack).is_empty()), "and it is taken back whole");
}

#[test]
fn a_photos_own_paint_stays_and_what_contradicts_it_is_told() {
    let bench = bench();
    paint_scrawl(&bench, 0, BLEED, clean);
    let right_half = [-2.9, BLEED[1], BLEED[2], BLEED[3]];
    paint_scrawl(&bench, 1, right_half, |_| BLUE);
    // What it would put there itself.
    let left_edge = [BLEED[0], -3.6, BLEED[2], BLEED[3]];
    paint_scrawl(&bench, 2, left_edge, clean);
    let filled = bench.fill(&propagating(&["0.png"]));
    let message: Vec<_> = filled.iter().map(|photo| photo.propagated.clone()).collect();
    assert!(message[0].is_empty());
    let [one, two] = [&message[1][0], &message[2][0]];
    assert_eq!((one.from.as_str(), one.face.as_str(), message[1].len()), ("0.png", "wall[0]", 1));
    assert!(one.conflicts > 200 && one.conflicts <= one.own && one.texels > 200, "{one:?}");
    // Edges of the facade are between pixels, here and there.
    assert!(two.own > 100 && two.conflicts < two.own / 5, "the same again is no contradiction: {two:?}");
    let stack = filled[1].stack.as_ref().unwrap();
    assert_eq!(stack.fill.as_ref().unwrap().propagated, message[1], "it can be looked up later");
    let laid = laid_over(&bench, stack);
    let own = bench.pixels_where(1, |point| is_in(right_half, point, 0.08));
    assert!(own.iter().all(|at| !laid.contains_key(at)), "own paint is not covered");
    assert_eq!(laid.len() as u64, one.texels);
    // And it is what everybody sees.
    let (wall, _) = stack.numbered_layers().find(|(_, layer)| layer.name.starts_with("wall")).unwrap();
    let painted = PhotoPaint::open(bench.folder.path(), stack).unwrap();
    let folder = StackStore::new(bench.folder.path()).folder("1.png");
    let shown = layer_pixels(stack, &folder, &painted, wall).unwrap();
    let rect = stack.layer(wall).rect;
    let at = |at: [i32; 2]| shown.rgba16((at[0] - rect.x) as u32, (at[1] - rect.y) as u32);
    assert!(own.iter().all(|place| at(*place) == BLUE));
    let (place, (rgb, _)) = laid.iter().next().unwrap();
    assert_eq!(at(*place)[..3], rgb.map(|value| value * 257), "laid over, it shows in the layer");
}

#[test]
fn two_paints_that_contradict_each_other_are_told_and_the_nearer_one_shows() {
    let bench = bench();
    paint_scrawl(&bench, 0, BLEED, clean);
    paint_scrawl(&bench, 2, BLEED, |_| BLUE);
    let filled = bench.fill(&propagating(&["*"]));
    let message = &filled[1].propagated;
    assert!(message.iter().map(|paint| paint.dissents).sum::<u64>() > 300, "{message:?}");
    let seen: BTreeSet<_> = message.iter().map(|paint| paint.from.as_str()).collect();
    let laid = laid_over(&bench, filled[1].stack.as_ref().unwrap());
    let shown: BTreeSet<_> = laid.values().map(|(_, origin)| origins::painter(origin).unwrap()).collect();
    assert_eq!(seen, shown);
    // Of one of them alone nothing contradicts.
    let one = bench.fill(&propagating(&["2.png"]));
    assert!(one[1].propagated.iter().all(|paint| paint.dissents == 0 && paint.from == "2.png"));
}

#[test]
fn a_hidden_texel_is_as_it_was_painted_elsewhere_and_not_as_other_photos_still_show_it() {
    let bench = bench();
    let hidden: BTreeSet<_> = bench.pixels_where(0, |point| is_in(BEHIND, point, -0.1)).into_iter().collect();
    let filled_there = |stack: &Stack| {
        let texels = bench.texels(0, stack).into_iter();
        let on_wall = |texel: &super::bench::Filled| {
            stack.image_layers[texel.layer].name.starts_with("wall") && hidden.contains(&texel.at)
        };
        texels.filter(on_wall).collect::<Vec<_>>()
    };
    let red = |rgb: [u16; 3]| rgb[0] > 180 && rgb[1] < 90;
    let before = stacks(bench.fill(&FillOptions::default()));
    let there = filled_there(&before[0]);
    let scrawled = there.iter().filter(|texel| red(texel.rgb)).count();
    assert!(there.len() > 60 && 10 * scrawled > 9 * there.len(), "{scrawled} of {}", there.len());
    paint_scrawl(&bench, 1, BEHIND, clean);
    // The photo on the right still shows the scrawl.
    let after = stacks(bench.fill(&FillOptions::default()));
    let origins = &after[0].fill.as_ref().unwrap().origins;
    let there = filled_there(&after[0]);
    assert!(there.iter().all(|texel| origins[usize::from(texel.place)] == origins::painted_in("1.png")));
    let off: Vec<f64> =
        there.iter().map(|texel| difference(texel.rgb, facade(bench.on_wall(0, texel.at)))).collect();
    assert!(share_near(&off) > 0.85, "{}", share_near(&off));
    assert!(after[0].fill.as_ref().unwrap().texels_from_paint >= there.len() as u64);
    let trusted = there.iter().map(|texel| texel.confidence).max().unwrap();
    assert!((100..=128).contains(&trusted), "as much as what another photo shows: {trusted}");
}

#[test]
fn what_was_painted_away_everywhere_comes_from_nowhere() {
    let bench = bench();
    [1, 2].into_iter().for_each(|photo| paint_scrawl(&bench, photo, BEHIND, |_| ERASED));
    let filled = stacks(bench.fill(&propagating(&["*"])));
    assert!(filled.iter().all(|stack| laid_over(&bench, stack).is_empty()), "an erased place is no offer");
    let hidden: BTreeSet<_> = bench.pixels_where(0, |point| is_in(BEHIND, point, 0.0)).into_iter().collect();
    let there = bench.texels(0, &filled[0]).into_iter().filter(|texel| hidden.contains(&texel.at));
    let wall: Vec<_> =
        there.filter(|texel| filled[0].image_layers[texel.layer].name.starts_with("wall")).collect();
    assert!(wall.len() > 100 && wall.iter().all(|texel| texel.place == 2 || texel.place == 3));
    assert!(
        !wall.iter().any(|texel| texel.rgb[0] > 180 && texel.rgb[1] < 90),
        "the scrawl does not come back"
    );
}

#[test]
fn what_was_painted_where_its_photo_sees_nothing_goes_to_the_photos_that_show_the_place() {
    let bench = bench();
    // The cube stands before it there.
    paint_scrawl(&bench, 0, BEHIND, clean);
    let filled = bench.fill(&propagating(&["0.png"]));
    for (photo, filled) in filled.iter().enumerate().skip(1) {
        let laid = laid_over(&bench, filled.stack.as_ref().unwrap());
        let scrawl = bench.pixels_where(photo, |point| is_in(BEHIND, point, -0.05));
        assert!(scrawl.len() > 100 && scrawl.iter().all(|at| laid.contains_key(at)));
    }
}

#[test]
fn a_dry_run_tells_the_same_and_writes_nothing() {
    let bench = bench();
    paint_scrawl(&bench, 0, BLEED, clean);
    let (folder, opened) = (bench.folder.path(), bench.opened());
    let before = bench.files();
    let request = FillRequest {
        options: propagating(&["0.png"]),
        photos: vec![],
        memory: 1 << 30,
        force: false,
        keep_former: false,
    };
    let dry = tell(folder, &opened.project, &opened.site, &request, &Task::silent()).unwrap();
    assert!(bench.files() == before && stack_of(&bench, 1).fill.is_none());
    let wet = fill(folder, &opened.project, &opened.site, &request, &Task::silent()).unwrap();
    let message =
        |filled: &[FilledPhoto]| filled.iter().map(|photo| photo.propagated.clone()).collect::<Vec<_>>();
    assert!(!message(&dry)[1].is_empty());
    assert_eq!(message(&dry), message(&wet));
    let again = fill(folder, &opened.project, &opened.site, &request, &Task::silent()).unwrap();
    assert!(again.iter().all(|photo| photo.up_to_date));
    assert_eq!(message(&again), message(&wet), "what is up to date still tells it");
    assert_eq!(
        message(&tell(folder, &opened.project, &opened.site, &request, &Task::silent()).unwrap()),
        message(&wet)
    );
    let nobody = FillRequest { options: propagating(&["nobody.png"]), ..request };
    let error =
        tell(folder, &opened.project, &opened.site, &nobody, &Task::silent()).unwrap_err().to_string();
    assert!(error.contains("nobody.png"), "{error}");
}

#[test]
fn paint_makes_those_fillings_stale_that_it_may_go_into() {
    let bench = bench();
    bench.fill(&FillOptions::default());
    let states = || {
        let stacks: Vec<_> = (0..3).map(|photo| Some(stack_of(&bench, photo))).collect();
        let options = FillOptions::default();
        let opened = bench.opened();
        let inputs =
            FillInputs::new(bench.folder.path(), &opened.project, &opened.site, &stacks, &options).unwrap();
        stacks.iter().flatten().map(|stack| FillState::new(stack, &inputs)).collect::<Vec<_>>()
    };
    assert_eq!(states(), [FillState::Current; 3]);
    // A side of the cube that one photo sees.
    let of_cube = |photo: usize| {
        let stack = stack_of(&bench, photo);
        let faces = stack.surfaces.iter().filter(|surface| surface.object == "cube");
        faces.map(|surface| surface.face).collect::<BTreeSet<_>>()
    };
    let alone: Vec<_> = of_cube(0).difference(&of_cube(2)).copied().collect();
    assert!(!alone.is_empty(), "the cameras stand to both sides of it");
    let store = PaintStore::new(bench.folder.path());
    paint(&bench, 0, "cube", &[(100, 100, BLUE)]);
    let before = store.read().unwrap();
    let mut book = before.clone();
    let surfaces = stack_of(&bench, 0).surfaces;
    let side = surfaces.iter().find(|s| s.object == "cube" && s.face == alone[0]).unwrap();
    (book.entries[0].face, book.entries[0].outline) = (Some(side.face), side.outline.clone());
    store.commit(&book, &before).unwrap();
    assert_eq!((states()[0], states()[2]), (FillState::Stale, FillState::Current));
    bench.fill(&FillOptions::default());
    assert_eq!(states(), [FillState::Current; 3]);
    paint_scrawl(&bench, 0, BLEED, clean);
    assert_eq!(states(), [FillState::Stale; 3], "all of them show the wall");
    fs::remove_dir_all(bench.folder.path().join("paint")).unwrap();
    assert_eq!((states()[0], states()[2]), (FillState::Stale, FillState::Current));
}
