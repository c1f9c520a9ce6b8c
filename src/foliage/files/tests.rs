//! Tests of the keyword format: transforms, what is refused with its line, and what is noted.

use std::fs;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use glam::{DAffine3, DMat4, DVec3, DVec4};

use super::*;
use crate::{Shape, Use};
use quadratura_base::scene::synthetic::Rng;
use quadratura_base::task::Event;

/// A folder with these files.
pub(super) struct Files(tempfile::TempDir);

impl Files {
    pub(super) fn new(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        files.iter().for_each(|(name, text)| fs::write(folder.path(name), text).unwrap());
        folder
    }

    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(super) fn read(&self, name: &str) -> Result<Plant> {
        read_plant(&self.path(name), None, &Task::silent())
    }
}

pub(super) const TRIANGLE: &str = "polygon 3  0 0 0 0 0 0 0 0  1 0 0 0 0 0 1 0  0 1 0 0 0 0 0 1\n";

fn read_text(text: &str) -> Result<Plant> {
    Files::new(&[("tree.plant", text), ("leaf.plant", TRIANGLE)]).read("tree.plant")
}

fn refused(text: &str) -> String {
    read_text(text).unwrap_err().to_string()
}

/// Returns the notes of a text that is read.
fn notes(text: &str) -> Vec<String> {
    let noted = Arc::new(Mutex::new(Vec::new()));
    let sink = noted.clone();
    let task = Task::new(move |event| {
        if let Event::Note { text, .. } = event {
            sink.lock().unwrap().push(text.to_string());
        }
    });
    let files = Files::new(&[("tree.plant", text), ("leaf.plant", TRIANGLE)]);
    read_plant(&files.path("tree.plant"), None, &task).unwrap();
    Arc::try_unwrap(noted)
        .map_or_else(|noted| noted.lock().unwrap().clone(), |noted| noted.into_inner().unwrap())
}

fn numbers(matrix: &DMat4) -> String {
    let numbers: Vec<String> = matrix.to_cols_array().iter().map(ToString::to_string).collect();
    numbers.join(" ")
}

fn any_map(rng: &mut Rng) -> DMat4 {
    let mut number = || (rng.between(-2.0, 2.0) * 64.0).round() / 64.0;
    let mut column = |last: f64| DVec4::new(number(), number(), number(), last);
    DMat4::from_cols(column(0.0), column(0.0), column(0.0), column(1.0))
}

#[test]
fn transforms_act_before_what_was_there_and_braces_take_them_back() {
    let mut rng = Rng::new(2);
    for _ in 0..50 {
        let [p, q, r] = [(); 3].map(|()| any_map(&mut rng));
        // glam stores columns, which are the file's rows: the file's matrices are for row vectors.
        let text = format!(
            "transform {}\n{{ transform {} use leaf {{ transform {} use leaf.plant }} }}\nuse leaf",
            numbers(&p),
            numbers(&q),
            numbers(&r)
        );
        let plant = read_text(&text).unwrap();
        let maps: Vec<DAffine3> = plant.whole().uses.iter().map(|of| of.parent_from_child).collect();
        // T := P T with row vectors: the last transform acts first.
        for (map, expected) in maps.iter().zip([p * q, p * q * r, p]) {
            let difference = DMat4::from(*map) - expected;
            // Products of a few numbers below 2, in steps of 1/64.
            assert!(difference.to_cols_array().iter().all(|d| d.abs() < 1e-12), "{map} {expected}");
        }
        let point = DVec4::new(0.3, -0.7, 0.2, 1.0);
        let by_rows = r.transpose() * q.transpose() * p.transpose();
        let moved = maps[1].transform_point3(point.truncate());
        assert!((by_rows.transpose() * point).truncate().distance(moved) < 1e-12);
    }
}

#[test]
fn a_translation_of_rows_is_in_the_last_row_and_polygons_and_limbs_stand_where_it_says() {
    let shift = "transform 1 0 0 0  0 2 0 0  0 0 1 0  5 6 7 1\n";
    let limb = "tube 5 4 limb 4  0 0 0 .1  0 0 1 .1  0 0 2 .1  0 0 3 0\n";
    let plant = read_text(&format!("# a tree\n{shift}{TRIANGLE}{limb} unit 0.01 up 0 2 0")).unwrap();
    assert_eq!((plant.unit, plant.up), (0.01, DVec3::Y));
    let whole = plant.whole();
    let Shape::Polygon(corners) = &whole.primitives[0].shape else { panic!("{whole:?}") };
    let positions: Vec<DVec3> = corners.iter().map(|corner| corner.position).collect();
    assert_eq!(positions, [(5., 6., 7.), (6., 6., 7.), (5., 8., 7.)].map(DVec3::from));
    let Shape::Limb(limb) = &whole.primitives[1].shape else { panic!("{whole:?}") };
    assert_eq!((limb.sides, limb.segments, limb.points.len()), (5, 4, 4));
    assert_eq!(limb.object_from_limb.transform_point3(DVec3::ONE), DVec3::new(6.0, 8.0, 8.0));
    assert_eq!((whole.counts.polygons, whole.counts.triangles), (21, 41));
}

#[test]
fn a_plant_of_several_files_is_one_graph_whose_files_are_read_once() {
    let files = Files::new(&[
        ("tree.plant", "use branch use branch { use leaf }"),
        ("branch", "use leaf use leaf.plant use branch.box"),
        ("leaf.plant", TRIANGLE),
        ("leaf.box", "this is no plant"),
    ]);
    let plant = files.read("tree.plant").unwrap();
    let names: Vec<&str> = plant.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(names, ["leaf.plant", "branch", "tree.plant"]);
    assert_eq!(plant.whole().counts.polygons, 5);
    let uses: Vec<usize> = plant.objects[1].uses.iter().map(|Use { child, .. }| *child).collect();
    assert_eq!(uses, [0, 0]);
    assert_eq!(files.read("branch").unwrap().whole().counts.polygons, 2);
}

#[test]
fn a_material_lasts_until_the_next_one_and_pictures_are_those_of_the_folder() {
    let files = Files::new(&[(
        "tree.plant",
        &format!(
            "{TRIANGLE} material bark reflected .1 .2 .3 {TRIANGLE} \
             material blade through 0 1 0 picture leaf.png cutout 0.25 leaf {TRIANGLE}"
        ),
    )]);
    let rgba =
        image::RgbaImage::from_fn(2, 1, |x, _| image::Rgba([10, 20, 30, if x == 0 { 0 } else { 255 }]));
    rgba.save(files.path("leaf.png")).unwrap();
    let plant = files.read("tree.plant").unwrap();
    let materials: Vec<_> =
        plant.whole().primitives.iter().map(|primitive| primitive.material.clone()).collect();
    assert_eq!((materials[0].name.as_str(), materials[1].reflected), ("grey", [0.1, 0.2, 0.3]));
    let leaf = &materials[2];
    assert_eq!(
        (leaf.leaf, leaf.cutout, leaf.reflected, leaf.through),
        (true, Some(0.25), [1.0; 3], [0., 1., 0.])
    );
    let pixels = leaf.picture.as_ref().unwrap();
    assert_eq!(pixels.rgba(), [[10, 20, 30, 0], [10, 20, 30, 255]]);
}

#[test]
fn a_cycle_is_spelt_out() {
    let files = Files::new(&[
        ("tree.plant", "use branch"),
        ("branch.plant", "use twig"),
        ("twig.plant", "use branch"),
    ]);
    let message = files.read("tree.plant").unwrap_err().to_string();
    assert!(
        message.contains(r#"uses itself: "branch.plant" uses "twig.plant" uses "branch.plant""#)
            && message.contains("branch.plant: "),
        "{message}"
    );
}

#[test]
fn what_is_wrong_is_told_with_its_line() {
    let shift = |text: &str| format!("transform {text}");
    let cases = [
        ("\n}", "line 2: `}` without"),
        ("{\n{\n}", "line 1: `{` is never closed"),
        ("# x\n\nuse oak", "line 3: `use` of \"oak\", but there is no file \"oak\" or \"oak.plant\""),
        ("use ../leaf", "line 1: `use \"../leaf\"` names a file outside"),
        ("use http://a/leaf", "outside"),
        ("use", "line 1: the file ends; expected the name of `use`"),
        ("leaf", "line 1: \"leaf\", expected a statement"),
        (&shift("1 0 0 0 0 1 0 0\n0 0 1 0 0 0 use leaf"), "line 2: \"use\", expected number 15 of 16"),
        (&shift("1 0 0 0 0 1 0 0 0 0 nan 0 0 0 0 1"), "\"nan\", expected number 11 of 16"),
        (&shift("1 0 0 0 0 1 0 0 0 0 1e16 0 0 0 0 1"), "up to 1e15"),
        (&shift("1 0 0 .5 0 1 0 0 0 0 1 0 0 0 0 1"), "not affine"),
        ("polygon 2 0 0", "\"2\", expected the corners of `polygon`: a whole number from 3 to 1000"),
        ("polygon 3 0 0 0", "the file ends; expected number 4 of 8 of corner 1"),
        ("limb 5", "5 control points, expected 3 k + 1"),
        ("limb 4 0 0 0 -1", "radius -1"),
        ("tube 2 6", "a whole number from 3"),
        ("material a reflected 1 2 0", "2 in `reflected`"),
        ("material a picture no.png", "no picture \"no.png\""),
        ("material a picture /etc/x.png", "outside of the plant's folder"),
        ("material a picture leaf.plant", "leaf.plant"),
        ("unit 0", "a unit of 0 metres"),
        ("up 0 0 0", "`up 0 0 0`"),
    ];
    for (text, expected) in cases {
        let message = refused(text);
        assert!(message.contains(expected), "{text:?}: {message}");
        assert!(message.contains("plant"), "{message}");
    }
    let far = format!("{0}{0}", shift("1e8 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n"));
    assert!(refused(&far).contains("line 2: the transforms up to here"), "{}", refused(&far));
    let braces = refused(&"{\n".repeat(1001));
    assert!(braces.contains("line 1001: more than 1000 braces"), "{braces}");
    let limbs = "tube 1000 10000 limb 4 0 0 0 1 0 0 1 1 0 0 2 1 0 0 3 1\n";
    assert!(refused(limbs).contains("corners"), "{}", refused(limbs));
}

#[test]
fn each_mistake_has_a_remedy_that_fits() {
    for (text, remedy) in [
        ("polygon 3 0 0", remedies::COMPLETE),
        ("unit metre", remedies::NUMBER),
        ("use twig", remedies::FILE),
        ("use ../leaf", remedies::FILE),
        ("bark", remedies::CORRECT),
        ("use tree", "no part may be a part of itself"),
    ] {
        let message = refused(&format!("{TRIANGLE}{text}"));
        assert!(message.contains(remedy), "{text}: {message}");
    }
}

#[test]
fn what_is_left_out_is_noted_once_with_its_number() {
    let flat = "transform 1 0 0 0  0 0 0 0  0 0 1 0  0 0 0 1\n";
    let text = format!("{flat} use leaf\nuse leaf\n{TRIANGLE} use leaf.box material a cutout .5");
    let notes = notes(&text);
    let expected =
        ["line 2: a use or limb is left out", "no area", "bounding box", "no effect without `picture`"];
    assert_eq!(notes.len(), expected.len(), "{notes:?}");
    for (note, expected) in notes.iter().zip(expected) {
        assert!(note.contains(expected), "{note}");
    }
    assert!(notes[0].contains("(and 1 more)") && !notes[1].contains("more"), "{notes:?}");
}

#[cfg(unix)]
#[test]
fn links_that_lead_out_of_the_folder_are_foreign() {
    let outside = Files::new(&[("leaf.plant", TRIANGLE)]);
    let files = Files::new(&[("tree.plant", "use leaf")]);
    std::os::unix::fs::symlink(outside.path("leaf.plant"), files.path("leaf.plant")).unwrap();
    let message = files.read("tree.plant").unwrap_err().to_string();
    assert!(message.contains("outside of the plant's folder"), "{message}");
}

#[test]
fn species_are_known_by_name_by_file_and_by_seed() {
    let files = Files::new(&[
        ("wood.json", include_str!("../../../examples/oak.json")),
        ("bad.json", "{\"name\": 1}"),
    ]);
    let named = |name: &str, seed: Option<u64>| read_plant(Path::new(name), seed, &Task::silent());
    assert!(files.read("wood.json").unwrap() == named("oak", None).unwrap());
    assert!(named("oak", Some(3)).unwrap() == named("oak", None).unwrap());
    assert!(named("oak", Some(2)).unwrap() != named("oak", None).unwrap());
    assert_eq!(named("maple", None).unwrap().whole().counts.polygons, 1_323_512);
    let bad = files.read("bad.json").unwrap_err().to_string();
    assert!(bad.contains("line 1 column"), "{bad}");
    let out = include_str!("../../../examples/oak.json")
        .replace("\"trees\"", "")
        .replace("\"girth\": 0.03", "\"girth\": 3");
    fs::write(files.path("thick.json"), out).unwrap();
    let thick = files.read("thick.json").unwrap_err().to_string();
    assert!(thick.contains("girth: 3, expected a number from 0.0001 to 0.5"), "{thick}");
    assert!(named("elm", None).unwrap_err().to_string().contains("elm"));
    for ending in ["fbx", "ray"] {
        let unknown = named(&format!("elm.{ending}"), None).unwrap_err().to_string();
        assert!(
            unknown.contains(&format!("a file called .{ending}, expected a plant: .plant, .gltf or .glb")),
            "{unknown}"
        );
    }
    assert!(matches!(named("elm.plant", Some(1)), Err(Error::Request(_))));
}
