//! Strokes on the site of two photos: a box (1 unit around the axis, at depth 6) in front of a wall (at depth 12).

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::*;
use crate::import::take_back;
use quadratura_document::paint::{ERASED, PaintColour};
use quadratura_document::stack::StackCamera;
use quadratura_document::stroke::{Brush, StrokeSample, StrokeView};
use quadratura_sites::open::Opened;
use quadratura_stacks::tiny_site::tiny_stacks;

const RED: [u8; 3] = [200, 10, 20];

/// Where the photo `left.png` was taken.
const LEFT: f64 = -1.5;

/// A project of its own, and the files of its paint.
struct Easel {
    _folder: tempfile::TempDir,
    project: PathBuf,
    opened: Opened,
}

type Pixels = BTreeMap<(String, String, i32, i32), PaintColour>;

impl Easel {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (project, opened) = tiny_stacks(folder.path()).unwrap();
        Self { _folder: folder, project, opened }
    }

    fn apply(&self, stroke: &Stroke) -> Result<StrokeReport> {
        let look = Appearance { flat: true, ..Appearance::default() };
        apply(
            &self.project,
            &self.opened.project,
            &self.opened.site,
            stroke,
            &look,
            StrokeOptions::default(),
            &Task::silent(),
        )
    }

    fn applied(&self, stroke: &Stroke) -> StrokeReport {
        self.apply(stroke).unwrap()
    }

    /// All paint by photo, object and pixel; later imports show.
    fn paint(&self) -> Pixels {
        let store = PaintStore::new(&self.project);
        let book = store.read().unwrap();
        let mut entries: Vec<_> = book.entries.iter().collect();
        entries.sort_by_key(|entry| entry.import);
        let of_entry = |entry: &quadratura_document::paint::PaintEntry| {
            let patch = store.patch(entry).unwrap();
            let place = |(x, y, colour)| ((entry.photo.clone(), entry.object.clone(), x, y), colour);
            patch.iter().map(place).collect::<Vec<_>>()
        };
        entries.into_iter().flat_map(of_entry).collect()
    }

    fn tree(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        files(&self.project.join("paint"))
    }
}

fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let Ok(entries) = fs::read_dir(folder) else { return BTreeMap::new() };
    let of_entry = |path: PathBuf| match path.is_dir() {
        true => files(&path),
        false => BTreeMap::from([(path.clone(), fs::read(path).unwrap())]),
    };
    entries.flat_map(|entry| of_entry(entry.unwrap().path())).collect()
}

/// The stroke of a hard brush in the view of a camera at `x` with the photos' lens.
fn stroke(x: f64, mode: BrushMode, samples: &[[f64; 2]]) -> Stroke {
    let camera = StackCamera {
        K: [[64.0, 0.0, 32.0], [0.0, 64.0, 24.0], [0.0, 0.0, 1.0]],
        R: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        t: [-x, 0.0, 0.0],
    };
    Stroke {
        version: 1,
        view: StrokeView { width: 64, height: 48, camera },
        brush: Brush { mode, radius: 3.0, hardness: 1.0, opacity: 1.0, colour: RED },
        source: None,
        layer: None,
        samples: samples.iter().map(|at| StrokeSample { at: *at, pressure: 1.0 }).collect(),
    }
}

fn sixteen(rgb: [u8; 3]) -> PaintColour {
    [rgb[0], rgb[1], rgb[2], 255].map(|sample| u16::from(sample) * 257)
}

/// A pixel of a photo of the site.
fn of_photo(easel: &Easel, photo: &str, x: i32, y: i32) -> [u8; 3] {
    let file = easel.project.parent().unwrap().join("photos").join(photo);
    let raster = quadratura_layered_files::png::read_rgba(&file, 64, 48).unwrap();
    let [r, g, b, _] = raster.rgba16(x as u32, y as u32).map(in_8_bits);
    [r, g, b]
}

fn largest_difference(a: PaintColour, b: [u8; 3]) -> u8 {
    (0..3).map(|c| in_8_bits(a[c]).abs_diff(b[c])).max().unwrap()
}

#[test]
fn in_the_view_of_a_photo_a_stroke_paints_exactly_its_pixels_under_the_brush() {
    let easel = Easel::new();
    let report = easel.applied(&stroke(LEFT, BrushMode::Colour, &[[10.5, 10.5]]));
    let paint = easel.paint();
    assert_eq!((report.number, report.changed, report.uncovered), (Some(1), paint.len() as u64, 0));
    for ((photo, object, x, y), colour) in &paint {
        assert_eq!((photo.as_str(), object.as_str(), *colour), ("left.png", "wall", sixteen(RED)));
        assert!((f64::from(*x) - 10.0).hypot(f64::from(*y) - 10.0) <= 3.0, "{x}, {y}");
    }
    // A disc of radius 3 around a pixel's centre: the four pixels at its rim may be in or out by rounding.
    assert!((25..=29).contains(&paint.len()), "{}", paint.len());
    let book = PaintStore::new(&easel.project).read().unwrap();
    assert!(book.entries.iter().all(|entry| entry.is_of_brush()) && book.documents.is_empty());
    assert_eq!(book.imports[0].brush, Some(BrushMode::Colour));
}

#[test]
fn a_stroke_does_not_reach_what_something_else_hides() {
    let easel = Easel::new();
    // The box covers the columns from 37.3 to 58.7 and the rows from 13.3 to 34.7.
    easel.applied(&stroke(LEFT, BrushMode::Colour, &[[30.0, 24.0], [48.0, 24.0]]));
    let paint = easel.paint();
    let columns =
        |object: &str| paint.keys().filter(|key| key.1 == object).map(|key| key.2).collect::<Vec<_>>();
    let (wall, of_box) = (columns("wall"), columns("box"));
    assert!(wall.len() > 30 && of_box.len() > 30);
    assert!(wall.iter().all(|x| *x <= 37) && wall.contains(&36), "{wall:?}");
    assert!(of_box.iter().all(|x| *x >= 37) && of_box.contains(&48), "{of_box:?}");
}

#[test]
fn a_stroke_over_two_photos_is_in_each_where_it_has_most_weight_and_one_undo_removes_it() {
    let easel = Easel::new();
    let before = easel.tree();
    let report = easel.applied(&stroke(0.0, BrushMode::Colour, &[[4.5, 6.5], [59.5, 6.5]]));
    let photos: Vec<&str> = report.layers.iter().map(|layer| layer.photo.as_str()).collect();
    assert_eq!(photos, ["left.png", "right.png"]);
    // The place on the wall that a pixel shows, in the view's columns: seen from 1.5 units aside, it is 8 px aside.
    let column = |photo: &str, x: i32| x + if photo == "left.png" { -8 } else { 8 };
    let paint = easel.paint();
    let of = |name: &str| {
        paint
            .keys()
            .filter(|key| key.0 == name && key.3 == 6)
            .map(|key| column(name, key.2))
            .collect::<Vec<_>>()
    };
    let (left, right) = (of("left.png"), of("right.png"));
    assert!(left.iter().all(|x| !right.contains(x)), "{left:?} {right:?}");
    let mut all = [left, right].concat();
    all.sort_unstable();
    assert_eq!(all, (2..=61).collect::<Vec<_>>(), "no place is left out between the photos");
    // Its book of paint would keep the pictures on disk.
    drop(report);
    take_back(&easel.project).unwrap();
    assert_eq!(easel.tree(), before);
}

#[test]
fn a_soft_and_thin_stroke_mixes_with_what_the_layer_shows() {
    let easel = Easel::new();
    let mut soft = stroke(LEFT, BrushMode::Colour, &[[10.5, 10.5]]);
    soft.brush.opacity = 0.5;
    easel.applied(&soft);
    let paint = easel.paint();
    for ((photo, _, x, y), colour) in &paint {
        let below = of_photo(&easel, photo, *x, *y);
        let mean = [0, 1, 2].map(|c| ((u16::from(below[c]) + u16::from(RED[c])) / 2) as u8);
        assert!(largest_difference(*colour, mean) <= 1 && colour[3] == u16::MAX, "{colour:?} {mean:?}");
    }
    assert!(paint.len() > 20);
    let mut lighter = soft.clone();
    lighter.samples[0].pressure = 0.4;
    lighter.samples[0].at = [20.5, 10.5];
    assert!(easel.applied(&lighter).changed < paint.len() as u64 / 2, "pressure makes it narrower");
}

#[test]
fn a_clone_shows_what_the_view_shows_at_the_source() {
    let easel = Easel::new();
    let mut clone = stroke(LEFT, BrushMode::Clone, &[[20.5, 30.5]]);
    clone.source = Some([10.5, 10.5]);
    easel.applied(&clone);
    let paint = easel.paint();
    assert!(paint.len() > 20);
    for ((photo, _, x, y), colour) in paint {
        let source = of_photo(&easel, &photo, x - 10, y - 20);
        assert!(largest_difference(colour, source) <= 1, "{x}, {y}: {colour:?} {source:?}");
    }
    clone.source = Some([1000.0, 10.5]);
    let report = easel.applied(&clone);
    assert!(report.number.is_none() && report.without_source > 20);
}

#[test]
fn healing_takes_the_colours_around_the_stroke_and_cloning_does_not() {
    let easel = Easel::new();
    let off = |mode: BrushMode| {
        let mut stroke = stroke(LEFT, mode, &[[20.5, 24.5]]);
        // The box is red, and of one colour there.
        stroke.source = Some([44.5, 24.5]);
        easel.applied(&stroke);
        let paint = easel.paint();
        let off =
            paint.iter().map(|((photo, _, x, y), c)| largest_difference(*c, of_photo(&easel, photo, *x, *y)));
        let largest = off.max().unwrap();
        take_back(&easel.project).unwrap();
        largest
    };
    let (healed, cloned) = (off(BrushMode::Heal), off(BrushMode::Clone));
    // The wall's colour is smooth: a membrane over three pixels differs by little from it. The box differs by 110.
    assert!(healed <= 12 && cloned > 80, "{healed} {cloned}");
}

#[test]
fn erasing_removes_strokes_under_the_brush_alone_and_is_undone_byte_for_byte() {
    let easel = Easel::new();
    easel.applied(&stroke(LEFT, BrushMode::Colour, &[[6.5, 10.5], [26.5, 10.5]]));
    let (painted, before) = (easel.paint(), easel.tree());
    // From another place: the paint of a photo is erased where it is seen, not where the photo has most weight.
    let report = easel.applied(&stroke(1.5, BrushMode::Erase, &[[0.5, 10.5]]));
    let left = easel.paint();
    assert_eq!(report.changed, (painted.len() - left.len()) as u64);
    assert!(report.changed > 15 && left.iter().all(|(place, colour)| painted[place] == *colour));
    assert!(!left.values().any(|colour| *colour == ERASED), "the photo is bare again, not erased");
    let gone: Vec<i32> =
        painted.keys().filter(|place| !left.contains_key(*place)).map(|place| place.2).collect();
    assert!(gone.iter().all(|x| (13..=20).contains(x)), "{gone:?}");
    drop(report);
    take_back(&easel.project).unwrap();
    assert_eq!(easel.tree(), before);
    assert!(
        easel.applied(&stroke(LEFT, BrushMode::Erase, &[[20.5, 40.5]])).number.is_none(),
        "nothing there"
    );
}

#[test]
fn erasing_along_a_soft_stroke_with_the_same_brush_leaves_nothing_of_it() {
    let easel = Easel::new();
    let mut soft = stroke(LEFT, BrushMode::Colour, &[[6.5, 10.5], [26.5, 10.5]]);
    soft.brush.hardness = 0.0;
    easel.applied(&soft);
    assert!(easel.paint().len() > 60);
    soft.brush.mode = BrushMode::Erase;
    easel.applied(&soft);
    assert_eq!(easel.paint(), Pixels::new());
}

#[test]
fn a_stroke_tells_what_becomes_of_its_pixels() {
    let easel = Easel::new();
    let report = easel.applied(&stroke(LEFT, BrushMode::Colour, &[[10.5, 10.5], [20.5, 10.5]]));
    let StrokeCoverage { pixels, painted, .. } = report.coverage;
    assert!(pixels > 60 && painted == pixels, "in the view of a photo: {report:?}");
    assert_eq!(report.objects, ["wall"]);
    // The same view, ten times larger: a texel of the photo has ten pixels a side; the brush is between its centres.
    let mut fine = stroke(LEFT, BrushMode::Colour, &[[100.0, 100.0], [140.0, 100.0]]);
    fine.view.camera.K = [[640.0, 0.0, 320.0], [0.0, 640.0, 240.0], [0.0, 0.0, 1.0]];
    (fine.view.width, fine.view.height) = (640, 480);
    let report = easel.applied(&fine);
    let StrokeCoverage { pixels, painted, coarse, .. } = report.coverage;
    assert!(report.number.is_none() && pixels > 200 && (painted, coarse) == (0, pixels), "{report:?}");
    fine.brush.radius = 60.0;
    let StrokeCoverage { pixels, painted, .. } = easel.applied(&fine).coverage;
    assert!(painted * 10 > pixels * 8, "a larger brush helps: {painted} of {pixels}");
}

#[test]
fn a_stroke_over_a_stroke_is_on_top_and_its_undo_shows_the_first_again() {
    let easel = Easel::new();
    easel.applied(&stroke(LEFT, BrushMode::Colour, &[[10.5, 10.5]]));
    let (paint, before) = (easel.paint(), easel.tree());
    let mut second = stroke(LEFT, BrushMode::Colour, &[[12.5, 10.5]]);
    second.brush.colour = [0, 0, 255];
    assert_eq!(easel.applied(&second).number, Some(2));
    let both = easel.paint();
    let key = |x: i32| ("left.png".to_owned(), "wall".to_owned(), x, 10);
    assert_eq!((both[&key(8)], both[&key(12)]), (sixteen(RED), sixteen([0, 0, 255])));
    assert_eq!(easel.applied(&second).number, None, "the same stroke again changes nothing");
    take_back(&easel.project).unwrap();
    assert_eq!((easel.paint(), easel.tree()), (paint, before));
}

#[test]
fn a_stroke_over_a_stroke_of_another_photo_replaces_it_there_so_that_it_is_on_top_from_everywhere() {
    let easel = Easel::new();
    // What the left photo shows at column 30.5 of the wall, the right one shows 16 px to the left.
    easel.applied(&stroke(LEFT, BrushMode::Colour, &[[24.5, 6.5], [36.5, 6.5]]));
    let (first, before) = (easel.paint(), easel.tree());
    let mut second = stroke(-LEFT, BrushMode::Colour, &[[14.5, 6.5]]);
    second.brush.colour = [0, 0, 255];
    easel.applied(&second);
    let paint = easel.paint();
    let left: Vec<i32> =
        paint.keys().filter(|key| key.0 == "left.png" && key.3 == 6).map(|key| key.2).collect();
    let right: Vec<i32> =
        paint.keys().filter(|key| key.0 == "right.png" && key.3 == 6).map(|key| key.2).collect();
    assert!(right.contains(&14) && left.contains(&24) && left.contains(&36), "{left:?} {right:?}");
    assert!(right.iter().all(|x| !left.contains(&(x + 16))), "{left:?} {right:?}");
    take_back(&easel.project).unwrap();
    assert_eq!((easel.paint(), easel.tree()), (first, before));
}

#[test]
fn the_same_stroke_gives_the_same_files_on_any_number_of_threads() {
    let painted = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let easel = Easel::new();
            let mut heal = stroke(0.3, BrushMode::Heal, &[[6.5, 20.5], [50.0, 8.0]]);
            (heal.source, heal.brush.hardness) = (Some([10.0, 36.0]), 0.3);
            easel.applied(&heal);
            let pictures =
                easel.tree().into_iter().filter(|(path, _)| path.extension().is_some_and(|e| e == "png"));
            pictures.map(|(path, bytes)| (path.file_name().unwrap().to_owned(), bytes)).collect::<Vec<_>>()
        })
    };
    let alone = painted(1);
    assert!(!alone.is_empty() && alone == painted(4));
}

#[test]
fn where_no_photo_covers_the_surface_it_says_so_and_off_the_model_it_refuses() {
    let easel = Easel::new();
    let behind = |rotation: [[f64; 3]; 3], t: [f64; 3]| {
        let mut stroke = stroke(0.0, BrushMode::Colour, &[[32.0, 24.0]]);
        (stroke.view.camera.R, stroke.view.camera.t) = (rotation, t);
        stroke
    };
    let turned = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    // From behind the wall, towards the cameras.
    let report = easel.applied(&behind(turned, [0.0, 0.0, 20.0]));
    assert!(report.number.is_none() && report.uncovered > 20, "{report:?}");
    let StrokeCoverage { pixels, hidden, outside, .. } = report.coverage;
    assert!(pixels > 10 && hidden + outside == pixels, "{report:?}");
    let away = easel.apply(&behind(turned, [0.0, 0.0, 0.0])).unwrap_err().to_string();
    assert!(away.contains("does not touch the model"), "{away}");
    let mut wrong = stroke(0.0, BrushMode::Clone, &[[1.0, 1.0]]);
    wrong.source = None;
    let message = easel.apply(&wrong).unwrap_err().to_string();
    assert!(message.contains("source"), "{message}");
    assert!(easel.tree().is_empty());
}
