//! The same tree in two formats gives the same picture.

use std::fs;

use glam::{DAffine3, DMat4, DQuat};
use image::{Rgba, RgbaImage};

use super::*;
use crate::files::read_plant;
use crate::{OutdoorLight, View, draw};
use quadratura_base::scene::synthetic::{centred, look_at};
use quadratura_view::Picture;

/// A quad of a leaf as two triangles: position, and place in the picture. Numbers fit into 32 bits.
const LEAF: [[f32; 5]; 4] =
    [[0., 0., 0., 0., 1.], [0.5, 0., 0.125, 1., 1.], [0.5, 0.75, 0., 1., 0.], [0., 0.75, 0.125, 0., 0.]];
/// A twig, without a picture.
const TWIG: [[f32; 3]; 3] = [[-0.0625, 0., 0.], [0.0625, 0., 0.], [0., 2., 0.25]];

fn picture() -> RgbaImage {
    RgbaImage::from_fn(8, 8, |x, y| {
        Rgba([(20 * x) as u8, 160, (10 * y) as u8, if (x + y) % 5 < 3 { 255 } else { 40 }])
    })
}

/// The places of leaves on the twig, and of twigs on the tree.
fn places() -> [Vec<DAffine3>; 2] {
    let place = |i: u32, size: f64| {
        let at = f64::from(i);
        DAffine3::from_scale_rotation_translation(
            DVec3::splat(size),
            DQuat::from_rotation_y(0.75 * at) * DQuat::from_rotation_x(0.5),
            DVec3::new(0.0, 0.25 * at, 0.0),
        )
    };
    [(0..7).map(|i| place(i, 0.75)).collect(), (0..5).map(|i| place(i, 1.0)).collect()]
}

fn as_text(numbers: impl IntoIterator<Item = f64>) -> String {
    numbers.into_iter().map(|number| format!(" {number:?}")).collect()
}

fn keyword(folder: &Path) -> Plant {
    let corner = |[x, y, z, u, v]: [f32; 5]| as_text([x, y, z, 0., 0., 0., u, v].map(f64::from));
    let triangle = |of: [[f32; 5]; 3]| format!("polygon 3{}\n", of.map(corner).concat());
    let uses = |places: &[DAffine3], name: &str| -> String {
        let line = |map: &DAffine3| {
            format!("{{ transform{} use {name} }}\n", as_text(DMat4::from(*map).to_cols_array()))
        };
        places.iter().map(line).collect()
    };
    let [leaves, twigs] = places();
    let leaf = "material leaf reflected 0.5 0.75 0.5 through 0.25 0.25 0 picture leaf.png cutout 0.5 leaf\n";
    let leaf =
        [leaf.to_owned(), triangle([LEAF[0], LEAF[1], LEAF[2]]), triangle([LEAF[0], LEAF[2], LEAF[3]])];
    let twig = TWIG.map(|[x, y, z]| [x, y, z, 0., 0.]);
    let twig = format!("material bark reflected .25 .125 .125\n{}", triangle(twig));
    picture().save(folder.join("leaf.png")).unwrap();
    fs::write(folder.join("leaf.plant"), leaf.concat()).unwrap();
    fs::write(folder.join("twig.plant"), twig + &uses(&leaves, "leaf")).unwrap();
    fs::write(folder.join("tree.plant"), "up 0 1 0\n".to_owned() + &uses(&twigs, "twig")).unwrap();
    read_plant(&folder.join("tree.plant"), None, &Task::silent()).unwrap()
}

/// Nodes of the tree: twigs with leaves, all written out.
fn nodes() -> Value {
    let [leaves, twigs] = places();
    let matrix = |map: &DAffine3| json!(DMat4::from(*map).to_cols_array());
    let mut nodes = vec![json!({ "name": "tree", "children": [] })];
    for twig in &twigs {
        let first = nodes.len();
        let children: Vec<usize> = (1..=leaves.len()).map(|i| first + i).collect();
        nodes[0]["children"].as_array_mut().unwrap().push(json!(first));
        nodes.push(json!({ "name": "twig", "mesh": 1, "matrix": matrix(twig), "children": children }));
        nodes.extend(leaves.iter().map(|leaf| json!({ "name": "leaf", "mesh": 0, "matrix": matrix(leaf) })));
    }
    json!(nodes)
}

fn glb(folder: &Path) -> Plant {
    let mut glb = Glb::new(nodes());
    let texture = glb.texture(&picture());
    glb.json["textures"][texture]["sampler"] = json!(0);
    glb.json["samplers"] = json!([{ "wrapS": 33071, "wrapT": 33071 }]);
    // A quarter of the light is let through, so that three quarters of the base colour are reflected.
    let transmission =
        json!({ "diffuseTransmissionFactor": 0.25, "diffuseTransmissionColorFactor": [1, 1, 0] });
    glb.json["materials"] = json!([
        {
            "name": "leaf", "alphaMode": "MASK",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5f32 / 0.75, 1.0, 0.5f32 / 0.75, 1.0],
                "baseColorTexture": { "index": texture },
            },
            "extensions": { "KHR_materials_diffuse_transmission": transmission },
        },
        { "name": "bark", "pbrMetallicRoughness": { "baseColorFactor": [0.25, 0.125, 0.125, 1] } },
    ]);
    let positions = glb.floats("VEC3", &LEAF.map(|[x, y, z, ..]| [x, y, z]));
    let textures = glb.floats("VEC2", &LEAF.map(|[.., u, v]| [u, v]));
    let indices: Vec<u8> = [0u8, 1, 2, 0, 2, 3].into();
    let indices = glb.accessor(&indices, json!({ "componentType": 5121, "count": 6, "type": "SCALAR" }));
    let twig = glb.floats("VEC3", &TWIG);
    let attributes = json!({ "POSITION": positions, "TEXCOORD_0": textures });
    glb.json["meshes"] = json!([
        { "primitives": [{ "attributes": attributes, "indices": indices, "material": 0 }] },
        { "primitives": [{ "attributes": { "POSITION": twig }, "material": 1 }] },
    ]);
    let file = folder.join("tree.glb");
    fs::write(&file, glb.bytes()).unwrap();
    read_plant(&file, None, &Task::silent()).unwrap()
}

#[test]
fn a_tree_of_the_keyword_format_and_of_glb_has_one_graph_and_one_picture() {
    let folder = tempfile::tempdir().unwrap();
    let plants = [keyword(folder.path()), glb(folder.path())];
    let graphs = plants.each_ref().map(|plant| {
        let counts: Vec<_> =
            plant.objects.iter().map(|object| (object.counts, object.uses.clone())).collect();
        (counts, plant.whole().bounds, plant.up, plant.unit)
    });
    assert_eq!(graphs[0], graphs[1]);
    assert_eq!(plants[0].whole().counts.polygons, 5 * (1 + 7 * 2));
    for eye in [DVec3::new(3.0, 1.0, 2.0), DVec3::new(-2.0, 3.0, -4.0), DVec3::new(0.5, 1.0, 0.75)] {
        let pose = look_at(eye, DVec3::new(0.0, 1.5, 0.0));
        let drawn = plants.each_ref().map(|plant| -> Picture {
            let view = View::perspective(centred(80, 80, 60.0), &pose, &plant.whole().bounds.ball);
            draw(plant, &view, &OutdoorLight::day(plant.up), &Task::silent()).unwrap().picture
        });
        let covered = drawn[0].pixels().iter().filter(|pixel| pixel[3] > 0).count();
        assert!(covered > 200, "the tree is in the picture: {covered} pixels");
        assert!(drawn[0] == drawn[1], "from {eye}");
    }
}
