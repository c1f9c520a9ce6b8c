//! Tests of trees: edits as steps of the history, the tool that places and drags them, and masks of the real ones.

use glam::{DVec2, DVec3};

use super::bench::{PHOTOS, TestBench};
use crate::state::request::{DecideRequest, SelectRequest, SpaceRequest, TreeRequest};
use crate::state::selection::Selection;
use crate::state::space::picking::ViewPixel;
use crate::state::trees::hand::Hold;
use quadratura_base::scene::PhotoId;
use quadratura_document::masks::MaskOrigin;
use quadratura_document::trees::{PlantSource, TreeIndex, TreeLight, TreeSpecies};
use quadratura_document::{Project, Trees};
use quadratura_trees::edit::{TreeChange, placed};

/// A leaf two units high and wide that faces along y.
const LEAF: &str = "material leaf reflected .1 .3 .1 through .1 .4 0 leaf\n\
                    polygon 4  -1 0 0 0 0 0 0 1  1 0 0 0 0 0 1 1  1 0 2 0 0 0 1 0  -1 0 2 0 0 0 0 0\n";
const SIZE_PX: [u32; 2] = [640, 480];

/// A bench whose project has a species of one leaf.
fn bench() -> TestBench {
    let mut bench = TestBench::new();
    std::fs::write(bench.folder().join("leaf.plant"), LEAF).unwrap();
    let species = TreeSpecies { from: PlantSource::File("leaf.plant".into()), up: None, unit: None };
    let trees = Trees { species: [("bush".to_owned(), species)].into(), ..Trees::default() };
    let project = Project { trees, ..bench.project() };
    bench.request(DecideRequest::Edit("species".into(), Box::new(project), None));
    bench.request(TreeRequest::Choose("bush".into()));
    bench
}

/// A bench with trees of these names, before the second step of the stairs.
fn planted(names: &[&str]) -> TestBench {
    let mut bench = bench();
    let mut trees = bench.project().trees;
    for name in names {
        let change = TreeChange { at: Some([-1.5, 1.0, 6.5]), height: Some(1.0), ..TreeChange::default() };
        trees = placed(&trees, "bush", Some(name), &change).unwrap().0;
    }
    let project = Project { trees, ..bench.project() };
    bench.request(DecideRequest::Edit("planting".into(), Box::new(project), None));
    bench
}

fn names(bench: &TestBench) -> Vec<String> {
    bench.project().trees.placed.iter().map(|tree| tree.name.clone()).collect()
}

/// Where the first photo's camera sees a point of the world.
fn pixel_of(bench: &TestBench, point: DVec3) -> ViewPixel {
    let viewpoint = bench.session().viewpoint_of(PhotoId(0));
    let camera = viewpoint.camera(SIZE_PX[0], SIZE_PX[1]);
    let at_px = camera.image_from_camera(viewpoint.pose.camera_from_world(point)).unwrap();
    ViewPixel { viewpoint, size_px: SIZE_PX, at_px }
}

fn at(pixel: &ViewPixel, x: f64, y: f64) -> ViewPixel {
    ViewPixel { at_px: pixel.at_px + DVec2::new(x, y), ..*pixel }
}

#[test]
fn a_click_places_a_tree_on_the_surface_and_a_drag_from_there_is_the_same_step() {
    let mut bench = bench();
    bench.request(TreeRequest::Hand);
    // A point of the nearest step of the stairs.
    let point = DVec3::new(-3.0, 0.5, 6.0);
    let pixel = pixel_of(&bench, point);
    bench.request(TreeRequest::Press(pixel));
    assert_eq!((names(&bench), bench.undoes()), (vec!["bush_1".to_owned()], Some("placing of bush_1")));
    assert_eq!(bench.state.selection.main, Selection::Tree(TreeIndex(0)));
    let foot = |bench: &TestBench| DVec3::from_array(bench.project().trees.placed[0].at);
    assert!(foot(&bench).abs_diff_eq(point, 1e-6), "{}", foot(&bench));
    let there = DVec3::new(-2.6, -0.4, 6.0);
    bench.request(TreeRequest::Drag(pixel_of(&bench, there), Hold::Move));
    assert!(foot(&bench).abs_diff_eq(there, 1e-6), "{}", foot(&bench));
    bench.request(TreeRequest::Drag(at(&pixel_of(&bench, there), 64.0, 0.0), Hold::Turn));
    bench.request(TreeRequest::Drag(at(&pixel_of(&bench, there), 128.0, 0.0), Hold::Turn));
    bench.request(TreeRequest::Drag(at(&pixel_of(&bench, there), 128.0, -40.0), Hold::Height));
    bench.request(TreeRequest::Drag(at(&pixel_of(&bench, there), 128.0, -80.0), Hold::Height));
    bench.request(TreeRequest::Release);
    let tree = bench.project().trees.placed[0].clone();
    assert!((tree.turn - 36.0).abs() < 1e-9 && tree.height.unwrap() > 0.1, "{tree:?}");
    bench.request(DecideRequest::Undo);
    assert!(names(&bench).is_empty(), "all of it was one gesture");
    bench.request(DecideRequest::Redo);
    assert_eq!(bench.project().trees.placed[0], tree);
}

#[test]
fn a_gesture_that_is_given_up_leaves_no_step_and_nothing_is_placed_in_the_sky() {
    let mut bench = bench();
    bench.request(TreeRequest::Press(pixel_of(&bench, DVec3::new(-3.0, 0.5, 6.0))));
    bench.request(TreeRequest::Drag(pixel_of(&bench, DVec3::new(-3.0, -0.5, 6.0)), Hold::Move));
    bench.request(TreeRequest::GiveUp);
    assert_eq!((names(&bench).len(), bench.undoes()), (0, Some("species")));
    bench.pass(0.1);
    assert_eq!(bench.state.selection.main, Selection::Nothing, "what was selected is gone");
    bench.request(TreeRequest::Press(pixel_of(&bench, DVec3::new(-3.0, 9.0, 6.0))));
    assert!(names(&bench).is_empty());
    assert!(bench.said().iter().any(|said| said.contains("no surface")), "{:?}", bench.said());
}

#[test]
fn the_brush_and_the_tool_for_trees_put_each_other_away() {
    let mut bench = bench();
    bench.request(TreeRequest::Hand);
    bench.request(SpaceRequest::Brush);
    assert!(bench.state.space.brush.on && !bench.state.trees.hand.on);
    bench.request(TreeRequest::Hand);
    assert!(!bench.state.space.brush.on && bench.state.trees.hand.on);
}

#[test]
fn the_selection_stays_with_its_tree_where_others_go_and_under_another_name() {
    let mut bench = planted(&["a", "b", "c"]);
    bench.request(SelectRequest::Only(Selection::Tree(TreeIndex(2))));
    bench.request(TreeRequest::Remove("a".into()));
    bench.pass(0.1);
    assert_eq!(bench.state.selection.main, Selection::Tree(TreeIndex(1)));
    let mut tree = bench.state.selected_tree().unwrap().clone();
    tree.name = "old one".into();
    bench.request(TreeRequest::Show(vec!["c".into()], false));
    let set =
        |tree| TreeRequest::Set { name: "c".into(), tree: Box::new(tree), what: "name", goes_on: false };
    bench.request(set(tree.clone()));
    bench.pass(0.1);
    assert_eq!(bench.state.selected_tree().unwrap().name, "old one");
    assert!(bench.state.trees.hidden.contains("old one") && bench.state.trees.hidden.len() == 1);
    tree.name = "b".into();
    bench.request(TreeRequest::Set {
        name: "old one".into(),
        tree: Box::new(tree),
        what: "name",
        goes_on: false,
    });
    assert_eq!(names(&bench), ["b", "old one"]);
    assert!(bench.said().iter().any(|said| said.contains("two trees")), "{:?}", bench.said());
    bench.request(TreeRequest::Remove("old one".into()));
    bench.pass(0.1);
    assert_eq!(bench.state.selection.main, Selection::Nothing);
}

#[test]
fn a_drag_of_a_number_is_one_step_and_a_copy_stands_beside_its_tree() {
    let mut bench = planted(&["a"]);
    bench.request(TreeRequest::WantFigures);
    bench.settle();
    let tree = bench.project().trees.placed[0].clone();
    for (height, goes_on) in [(2.0, true), (3.0, true), (4.0, false)] {
        let tree = Box::new(quadratura_document::trees::PlacedTree { height: Some(height), ..tree.clone() });
        bench.request(TreeRequest::Set { name: "a".into(), tree, what: "height", goes_on });
    }
    assert_eq!((bench.project().trees.placed[0].height, bench.undoes()), (Some(4.0), Some("height of a")));
    bench.request(TreeRequest::Duplicate("a".into()));
    let trees = bench.project().trees;
    let apart = DVec3::from_array(trees.placed[1].at).distance(DVec3::from_array(tree.at));
    // The leaf is as wide as it is high.
    assert!((apart - 4.0).abs() < 1e-6, "{apart}");
    assert_eq!(bench.state.selected_tree().unwrap().name, "bush_1");
    bench.request(DecideRequest::Undo);
    bench.request(DecideRequest::Undo);
    assert_eq!(bench.project().trees.placed[..], [tree]);
}

#[test]
fn the_light_is_a_step_of_its_own_and_light_that_cannot_be_is_refused() {
    let mut bench = planted(&["a"]);
    let light = |x: f64| TreeLight { sun: Some([x, 0.0, 0.0]), ..TreeLight::default() };
    bench.request(TreeRequest::Light { light: light(1.0), goes_on: false });
    assert_eq!((bench.project().trees.light, bench.undoes()), (light(1.0), Some("light on trees")));
    bench.request(TreeRequest::Light { light: light(0.0), goes_on: false });
    assert_eq!(bench.project().trees.light, light(1.0));
    assert!(bench.said().iter().any(|said| said.contains("light.sun")), "{:?}", bench.said());
}

#[test]
fn the_real_trees_are_masked_in_all_photos_as_one_step_and_a_second_time_nothing_changes() {
    let mut bench = planted(&["a"]);
    let keep = |bench: &mut TestBench| {
        while !bench.state.masking.is_kept() || !bench.state.running.is_idle() {
            bench.pass(0.1);
            bench.settle();
        }
    };
    bench.request(TreeRequest::Mask);
    keep(&mut bench);
    assert_eq!(bench.undoes(), Some("masks of trees"), "{:?}", bench.said());
    let masks = bench.project().masks;
    for photo in PHOTOS {
        let is_of_tree = matches!(masks.of(photo), [mask] if matches!(mask.from, MaskOrigin::Tree(_)));
        assert!(is_of_tree && masks.of(photo)[0].pixels > 10, "{photo}: {:?}", masks.of(photo));
    }
    bench.request(TreeRequest::Mask);
    keep(&mut bench);
    assert!(bench.said().iter().any(|said| said.contains("masked already")), "{:?}", bench.said());
    assert_eq!(bench.undoes(), Some("masks of trees"));
    bench.request(TreeRequest::ClearMasks);
    assert!(bench.project().masks.is_empty());
    bench.request(DecideRequest::Undo);
    assert_eq!(bench.project().masks, masks);
}
