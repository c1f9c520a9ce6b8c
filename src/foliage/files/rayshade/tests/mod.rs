//! Tests of plants of Rayshade: statements, what is refused with its line, and what is noted.

mod bad;
mod preprocessed;
mod shapes;
mod surfaces;

use std::fs;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use glam::{DAffine3, DVec3};

use super::*;
use crate::files::read_plant;
use crate::{Corner, Mesh, Shape, SubObject};
use quadratura_base::scene::synthetic::Rng;
use quadratura_base::task::Event;

/// A folder with these files, the first of which is the plant.
struct Files(tempfile::TempDir, PathBuf);

impl Files {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        let path = folder.path().join(files[0].0);
        Self(folder, path)
    }

    /// Reads the plant; returns it with what is noted.
    fn noted(&self) -> Result<(Plant, Vec<String>)> {
        let noted = Arc::new(Mutex::new(Vec::new()));
        let sink = noted.clone();
        let task = Task::new(move |event| {
            if let Event::Note { text, .. } = event {
                sink.lock().unwrap().push(text.to_string());
            }
        });
        let plant = read_plant(&self.1, None, &task)?;
        let notes = noted.lock().unwrap().clone();
        Ok((plant, notes))
    }
}

fn noted(text: &str) -> (Plant, Vec<String>) {
    Files::new(&[("tree.ray", text)]).noted().unwrap()
}

fn plant(text: &str) -> Plant {
    noted(text).0
}

fn refused(text: &str) -> String {
    Files::new(&[("tree.ray", text)]).noted().unwrap_err().to_string()
}

fn corners(object: &SubObject, index: usize) -> &[Corner] {
    let Shape::Polygon(corners) = &object.primitives[index].shape else { panic!("{object:?}") };
    corners
}

const TRIANGLE: &str = "triangle 0 0 0 1 0 0 0 1 0\n";

#[test]
fn transforms_are_those_of_the_keyword_format_and_act_in_their_order() {
    let mut rng = Rng::new(5);
    for _ in 0..40 {
        let mut number = || (rng.between(-2.0, 2.0) * 64.0).round() / 64.0;
        let m: [f64; 12] = std::array::from_fn(|_| number());
        let shift = [(); 3].map(|()| number());
        let words = |numbers: &[f64]| numbers.iter().map(|n| format!("{n} ")).collect::<String>();
        let text = format!(
            "name leaf {TRIANGLE} list object leaf transform {} end translate {}",
            words(&m),
            words(&shift)
        );
        let found = plant(&text);
        let rows = |i: usize| format!("{} 0 ", words(&m[3 * i..3 * i + 3]));
        let keyword = format!(
            "transform 1 0 0 0 0 1 0 0 0 0 1 0 {} 1 transform {}{}{}{} 1 use leaf",
            words(&shift),
            rows(0),
            rows(1),
            rows(2),
            words(&m[9..])
        );
        let leaf = "polygon 3 0 0 0 0 0 0 0 0 1 0 0 0 0 0 0 0 0 1 0 0 0 0 0 0";
        let files = Files::new(&[("tree.plant", &keyword), ("leaf.plant", leaf)]);
        let expected = files.noted().unwrap().0;
        let outer = found.whole().uses[0];
        let map = outer.parent_from_child * found.objects[outer.child].uses[0].parent_from_child;
        let difference =
            map.to_cols_array().into_iter().zip(expected.whole().uses[0].parent_from_child.to_cols_array());
        // Sums and products of few numbers in steps of 1/64.
        assert!(difference.into_iter().all(|(a, b)| (a - b).abs() < 1e-12), "{text}");
        assert_eq!(found.objects[0].primitives[0].shape, expected.objects[0].primitives[0].shape);
    }
}

#[test]
fn rotations_are_right_handed_and_of_degrees() {
    let plant = plant("triangle 1 0 0 2 0 0 1 0 1 rotate 0 0 2 90 translate 0 0 1");
    let expected = [(0., 1., 1.), (0., 2., 1.), (0., 1., 2.)].map(DVec3::from);
    for (corner, expected) in corners(plant.whole(), 0).iter().zip(expected) {
        assert!(corner.position.distance(expected) < 1e-12, "{corner:?}");
    }
}

#[test]
fn one_plant_in_three_formats_gives_one_graph() {
    let ray = "surface leaf diffuse .25 .5 0 translu 1 0 0 0 3\n\
               name leaf triangle leaf 0 0 0 1 0 0 0 1 0\n\
               name twig list object leaf translate 1 0 0 object leaf scale 2 2 2 end\n\
               name tree list object twig object twig translate 0 0 4 end\nobject tree\n";
    let keyword = Files::new(&[
        ("tree.plant", "use twig transform 1 0 0 0 0 1 0 0 0 0 1 0 0 0 4 1 use twig"),
        (
            "twig.plant",
            "{ transform 1 0 0 0 0 1 0 0 0 0 1 0 1 0 0 1 use leaf } transform 2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1 use leaf",
        ),
        (
            "leaf.plant",
            "material leaf reflected .25 .5 0 leaf polygon 3 0 0 0 0 0 0 0 0 1 0 0 0 0 0 0 0 0 1 0 0 0 0 0 0",
        ),
    ]);
    let leaves = |name: u32| {
        format!(
            r#"{{"mesh": 0, "name": "leaf", "translation": [1,0,0]}}, {{"mesh": 0, "name": "leaf{name}", "scale": [2,2,2]}}"#
        )
    };
    let bytes = [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].map(f32::to_le_bytes).concat();
    let gltf = format!(
        r#"{{"asset": {{"version": "2.0"}}, "nodes": [
        {{"name": "tree", "children": [1, 2]}}, {{"name": "twig", "children": [3, 4]}},
        {{"name": "twig", "children": [5, 6], "translation": [0, 0, 4]}}, {}, {}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}],
        "materials": [{{"name": "leaf", "pbrMetallicRoughness": {{"baseColorFactor": [0.25, 0.5, 0, 1]}}}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}], "buffers": [{{"uri": "a.bin", "byteLength": 36}}]}}"#,
        leaves(1),
        leaves(2)
    );
    let gltf = Files::new(&[("tree.gltf", &gltf)]);
    fs::write(gltf.0.path().join("a.bin"), bytes).unwrap();
    let of_ray = plant(ray);
    for other in [keyword.noted().unwrap().0, gltf.noted().unwrap().0] {
        assert_eq!((of_ray.whole().counts, of_ray.root), (other.whole().counts, other.root));
        for (a, b) in of_ray.objects.iter().zip(&other.objects) {
            assert_eq!((&a.uses, a.counts), (&b.uses, b.counts));
            let corners = |object: &SubObject| -> Vec<DVec3> {
                Mesh::of(object).iter().flat_map(|mesh| &mesh.corners).map(|corner| corner.position).collect()
            };
            assert_eq!(corners(a), corners(b));
            for (a, b) in a.primitives.iter().zip(&b.primitives) {
                assert_eq!((a.material.reflected, a.material.leaf), (b.material.reflected, b.material.leaf));
            }
        }
    }
    let names: Vec<&str> = of_ray.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(names, ["leaf", "twig", "tree"]);
}

#[test]
fn the_transform_of_a_named_list_is_its_own() {
    let plant = plant(&format!(
        "name leaf {TRIANGLE} name twig list {TRIANGLE} object leaf end translate 1 2 3 object twig"
    ));
    let twig = plant.whole();
    assert_eq!((twig.name.as_str(), twig.counts.levels), ("twig", 2));
    assert_eq!(corners(twig, 0)[0].position, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(twig.uses[0].parent_from_child, DAffine3::from_translation(DVec3::new(1.0, 2.0, 3.0)));
}

#[test]
fn what_stands_outside_of_definitions_is_the_plant() {
    let plant = plant(&format!(
        "name leaf {TRIANGLE} name unused {TRIANGLE} object leaf object leaf translate 1 0 0"
    ));
    assert_eq!(
        (plant.whole().name.as_str(), plant.whole().uses.len(), plant.objects.len()),
        ("tree.ray", 2, 2)
    );
    assert_eq!((plant.up, plant.unit), (DVec3::Z, 1.0));
}
