//! Tests of what is refused, with its place, of what is noted, and of mutated files.

use std::fs;

use super::*;
use crate::files::read_plant;
use quadratura_base::scene::synthetic::Rng;

/// A file with two instances of a triangle with a picture; accessor 1 has their translations, 2 their rotations.
fn with_instances() -> Glb {
    let mut glb = Glb::new(json!([{ "name": "leaves", "mesh": 0 }]));
    glb.floats("VEC3", &[[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]);
    glb.floats("VEC4", &[[0.0, 0.0, 0.0, 1.0]; 2]);
    glb.instancing(0, json!({ "TRANSLATION": 1, "ROTATION": 2 }));
    glb.texture(&image::RgbaImage::new(2, 2));
    glb.json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    glb.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    glb
}

#[test]
fn bad_instances_are_told_with_their_json_path() {
    let after = |change: &dyn Fn(&mut Glb)| {
        let mut glb = with_instances();
        change(&mut glb);
        glb.refused()
    };
    const PLACE: &str = "nodes[0].extensions.EXT_mesh_gpu_instancing: ";
    for (said, place, found) in [
        (
            after(&|glb| glb.json["accessors"][2]["count"] = json!(1)),
            PLACE,
            "1 elements of ROTATION, but 2 of the attributes before it",
        ),
        (
            after(&|glb| glb.instancing(0, json!({ "SCALE": 7 }))),
            "accessors[7]: ",
            "this accessor does not exist",
        ),
        (
            after(&|glb| glb.instancing(0, json!({ "SCALE": 2 }))),
            "accessors[2]: ",
            "scales of instances that are not VEC3 of floats",
        ),
        (
            after(&|glb| glb.instancing(0, json!({ "ROTATION": 1 }))),
            "accessors[1]: ",
            "rotations of instances that are not VEC4 of floats or of normalised signed integers",
        ),
        (
            after(&|glb| glb.instancing(0, json!({ "SCALE": -1 }))),
            "line 1 column ",
            "the number -1, expected a whole number",
        ),
        (after(&|glb| glb.instancing(0, json!(7))), "line 1 column ", "the number 7, expected"),
        (
            after(&|glb| {
                let scales = glb.floats("VEC3", &[[1.0, 1.0, 1.0], [1.0, f32::NAN, 1.0]]);
                glb.instancing(0, json!({ "SCALE": scales }));
            }),
            PLACE,
            "the transform of instance 1 is not finite",
        ),
        (
            after(&|glb| {
                let rotations = glb.floats("VEC4", &[[0.0; 4]; 2]);
                glb.instancing(0, json!({ "ROTATION": rotations }));
            }),
            PLACE,
            "the transform of instance 0 is not finite",
        ),
        (
            after(&|glb| glb.json["accessors"][1]["count"] = json!(3_000_000)),
            PLACE,
            "2 elements of ROTATION, but 3000000",
        ),
        (
            after(&|glb| {
                glb.list("accessors")
                    .push(json!({ "componentType": 5126, "count": 2_000_000, "type": "VEC3" }));
                glb.instancing(0, json!({ "TRANSLATION": 3 }));
            }),
            PLACE,
            "2000000 instances; at most 1000000 are read",
        ),
    ] {
        assert!(said.starts_with(place) && said.contains(found), "{place}{found}: {said}");
    }
}

#[test]
fn bad_nodes_meshes_and_pictures_are_told_with_their_json_path() {
    let after = |change: &dyn Fn(&mut Value)| {
        let mut glb = with_instances();
        glb.json["scenes"] = json!([{ "nodes": [0] }]);
        change(&mut glb.json);
        glb.refused()
    };
    let place = "images[0]: ";
    for (said, place, found) in [
        (
            after(&|j| {
                j["nodes"] = json!([{ "children": [1] }, { "children": [2] }, { "children": [1] }]);
            }),
            "nodes[1]: ",
            "its own ancestor: nodes 1, 2, 1",
        ),
        (after(&|j| j["nodes"] = json!([{ "children": [0] }])), "nodes[0]: ", "ancestor: nodes 0, 0"),
        (after(&|j| j["scenes"][0]["nodes"] = json!([0, 0])), "nodes[0]: ", "two parents"),
        (after(&|j| j["nodes"][0]["mesh"] = json!(3)), "meshes[3]: ", "this mesh does not exist"),
        (
            after(&|j| j["nodes"][0]["scale"] = json!([1e20, 1.0, 1.0])),
            "nodes[0]: ",
            "a transform with numbers beyond 1e15",
        ),
        (
            after(&|j| j["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(1)),
            "meshes[0].primitives[0]: ",
            "2 elements of NORMAL for 3 positions",
        ),
        (
            after(&|j| j["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(1)),
            "accessors[1]: ",
            "texture coordinates that are not VEC2",
        ),
        (
            after(&|j| j["meshes"][0]["primitives"][0]["material"] = json!(4)),
            "materials[4]: ",
            "this material does not exist",
        ),
        (
            after(&|j| j["textures"] = json!([])),
            "materials[0].pbrMetallicRoughness.baseColorTexture: ",
            "textures[0] does not exist",
        ),
        (after(&|j| j["textures"] = json!([{}])), "textures[0]: ", "no source"),
        (after(&|j| j["images"] = json!([])), place, "this picture does not exist"),
        (after(&|j| j["images"][0]["bufferView"] = json!(9)), place, "bufferViews[9], which is missing"),
        (after(&|j| j["images"][0] = json!({})), place, "neither a uri nor a bufferView"),
        (after(&|j| j["images"][0]["bufferView"] = json!(0)), place, "not a JPEG, PNG, TIFF or WebP image"),
        (after(&|j| j["images"][0]["uri"] = json!("../leaf.png")), place, "leads out of the model's folder"),
        (after(&|j| j["images"][0]["uri"] = json!("https://x.y/leaf.png")), place, "leads out of"),
        (after(&|j| j["images"][0]["uri"] = json!("data:image/png;base64,!")), place, "not base64"),
        (after(&|j| j["buffers"][0]["uri"] = json!("/etc/x.bin")), "buffers[0]: ", "leads out of"),
        (
            after(&|j| {
                j["accessors"][0] = json!({ "componentType": 5126, "count": 1_000_001, "type": "VEC3" })
            }),
            "accessors[0]: ",
            "1000001 elements without a bufferView",
        ),
        (
            after(&|j| j["extensionsRequired"] = json!(["EXT_meshopt_compression"])),
            "extensionsRequired: ",
            "compressed (EXT_meshopt_compression)",
        ),
    ] {
        assert!(said.contains(place) && said.contains(found), "{place}{found}: {said}");
    }
}

#[test]
fn chains_of_more_levels_than_plants_have_are_refused() {
    let chain = |count: usize| {
        let nodes: Vec<Value> = (0..count)
            .map(|i| if i + 1 < count { json!({ "children": [i + 1] }) } else { json!({ "mesh": 0 }) })
            .collect();
        Glb::new(json!(nodes))
    };
    assert_eq!(chain(64).plant().whole().counts.levels, 64);
    assert!(chain(65).refused().contains("65 levels, but a plant has at most 64"));
    assert!(chain(30_000).refused().contains("levels"));
    let mut endless = chain(64);
    let nodes = endless.list("nodes").iter_mut();
    nodes.for_each(|node| node["scale"] = json!([1e15, 1e15, 1e15]));
    assert!(endless.refused().contains("no size that is a finite number"), "{}", endless.refused());
}

#[test]
fn what_is_left_out_is_noted_once_with_its_number() {
    let mut glb = Glb::new(json!([
        { "mesh": 0 },
        { "mesh": 0, "scale": [1, 0, 1], "skin": 0 },
        { "mesh": 0, "scale": [0, 0, 0] },
    ]));
    let lines = json!({ "attributes": { "POSITION": 0 }, "mode": 1 });
    let flat = glb.floats("VEC3", &[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]]);
    let flat = json!({ "attributes": { "POSITION": flat, "COLOR_0": 0 } });
    glb.json["meshes"][0]["primitives"].as_array_mut().unwrap().extend([lines, flat]);
    glb.json["extensionsUsed"] = json!(["KHR_texture_transform"]);
    let (plant, notes) = glb.noted();
    assert_eq!(plant.whole().counts.polygons, 2);
    for expected in [
        "nodes[2]: a use is left out, because its transform is singular (and 1 more)",
        "meshes[0].primitives[2]: a triangle has no area, and nothing of it is seen",
        "meshes[0].primitives[2]: colours of vertices are left out",
        "meshes[0].primitives[1]: points, lines, morph targets",
        "nodes[1]: skins are left out",
        "extensionsUsed: KHR_texture_transform has no effect",
    ] {
        assert!(notes.iter().any(|note| note.starts_with(expected)), "{expected}: {notes:?}");
    }
    assert_eq!(notes.len(), 6, "{notes:?}");
}

#[test]
fn pictures_and_buffers_beside_a_gltf_file_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let mut glb = with_instances();
    let embedded = glb.plant();
    image::RgbaImage::new(2, 2).save(folder.path().join("a leaf.png")).unwrap();
    fs::write(folder.path().join("tree.bin"), &glb.binary).unwrap();
    glb.json["images"][0] = json!({ "uri": "a%20leaf.png" });
    glb.json["buffers"][0]["uri"] = json!("tree.bin");
    let file = folder.path().join("tree.GLTF");
    fs::write(&file, glb.json.to_string()).unwrap();
    assert!(read_plant(&file, None, &Task::silent()).unwrap() == embedded);
    let seeded = read_plant(&file, Some(3), &Task::silent());
    assert!(matches!(seeded, Err(Error::Request(_))), "{seeded:?}");
    let missing = read_plant(&folder.path().join("no.glb"), None, &Task::silent());
    assert!(matches!(missing, Err(Error::Io { .. })), "{missing:?}");
}

#[test]
fn mutated_files_give_a_plant_or_an_error_and_never_a_fault() {
    mutate(20_000);
}

/// `cargo test --profile quick -p quadratura-foliage --lib a_million_mutated_files_of_gltf -- --ignored`.
#[test]
#[ignore = "the same a million times, which takes longer than other tests"]
fn a_million_mutated_files_of_gltf_give_a_plant_or_an_error() {
    mutate(1_000_000);
}

/// Reads mutations of a small file.
fn mutate(count: u32) {
    let bytes = with_instances().bytes();
    let length = 20 + bytes.windows(4).position(|four| four == b"BIN\0").unwrap();
    let mut rng = Rng::new(19);
    let mut read = 0;
    for case in 0..count {
        let mut bytes = bytes.clone();
        for _ in 0..rng.whole(1, 3) {
            // Mostly in the JSON, whose digits are exchanged for digits, so that it stays JSON with other values.
            let end = if rng.whole(0, 3) == 0 { bytes.len() } else { length };
            let at = rng.whole(0, end.min(bytes.len()) as u32 - 1) as usize;
            let digits: Vec<usize> =
                (at..bytes.len()).filter(|i| bytes[*i].is_ascii_digit()).take(1).collect();
            match (rng.whole(0, 4), digits.first()) {
                (0, _) => bytes[at] = rng.bits() as u8,
                (1, _) => bytes.truncate(at.max(1)),
                (_, Some(digit)) => bytes[*digit] = b"0123456789-e"[rng.whole(0, 11) as usize],
                _ => {}
            }
        }
        match plant_of(Path::new("tree.glb"), &bytes, &Task::silent()) {
            Ok(plant) => {
                read += 1;
                assert!(plant.whole().bounds.ball.radius.is_finite(), "case {case}");
            }
            Err(Error::Input { remedy, .. }) => assert!(!remedy.to_string().is_empty()),
            Err(Error::Io { .. }) => {}
            Err(other) => panic!("case {case}: {other}"),
        }
    }
    assert!((count / 40..count / 40 * 39).contains(&read), "some are plants and some are not: {read}");
}
