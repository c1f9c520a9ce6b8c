//! Tests with glTF files, valid and damaged, that the tests write themselves.

use std::fs;

use glam::DVec3;
use proptest::prelude::*;
use serde_json::{Value, json};

use super::*;
use quadratura_base::scene::Model;

fn read_bytes(bytes: &[u8]) -> Result<(Model, Vec<String>)> {
    let path = Path::new("site.gltf");
    let mut notes = Vec::new();
    let builder = read(path, bytes, &Task::silent(), &mut notes)?;
    super::super::finish(path, builder, notes, &Task::silent())
}

fn read_json(json: &Value) -> Result<(Model, Vec<String>)> {
    read_bytes(json.to_string().as_bytes())
}

fn complaint(json: &Value) -> String {
    read_json(json).unwrap_err().to_string().replace("site.gltf, ", "")
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let letter = |three: &[u8], i: usize| {
        let bits = (0..3).fold(0, |bits, k| bits << 8 | u32::from(*three.get(k).unwrap_or(&0)));
        if i > three.len() { '=' } else { char::from(LETTERS[(bits >> (18 - 6 * i) & 63) as usize]) }
    };
    bytes.chunks(3).flat_map(|three| (0..4).map(move |i| letter(three, i))).collect()
}

/// Corners of two squares side by side in z = 0, and one corner above.
const CORNERS: [[f32; 3]; 7] =
    [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [2., 0., 0.], [2., 1., 0.], [0., 0., 1.]];

/// A file with one buffer: the corners, then `indices` as 16-bit numbers; one mesh, one node.
fn file(indices: &[u16]) -> Value {
    let mut bytes: Vec<u8> = CORNERS.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let at = bytes.len();
    bytes.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "thing", "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 7, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": indices.len(), "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": at },
            { "buffer": 0, "byteOffset": at, "byteLength": 2 * indices.len() },
        ],
        "buffers": [{
            "byteLength": bytes.len(),
            "uri": format!("data:application/octet-stream;base64,{}", base64(&bytes)),
        }],
    })
}

/// Both squares and a triangle standing on the first.
const TRIANGLES: [u16; 15] = [0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2, 0, 3, 6];

fn corner_counts(model: &Model) -> Vec<usize> {
    model.face_ids().map(|id| model.ring(id).len()).collect()
}

fn names(model: &Model) -> Vec<&str> {
    model.objects.iter().map(|o| o.name.as_str()).collect()
}

#[test]
fn coplanar_neighbours_become_one_face() {
    let (model, notes) = read_json(&file(&TRIANGLES)).unwrap();
    assert_eq!((corner_counts(&model), names(&model)), (vec![6, 3], vec!["thing"]));
    assert_eq!((model.vertices.len(), notes.len()), (7, 0));
    assert_eq!(model.faces[0].plane.normal, DVec3::Z);
}

#[test]
fn face_triangle_counts_say_what_was_one_face() {
    let mut json = file(&TRIANGLES);
    json["meshes"][0]["extras"] = json!({ "faceTriangleCounts": [2, 2, 1], "other": "x" });
    assert_eq!(corner_counts(&read_json(&json).unwrap().0), [4, 4, 3]);
    json["meshes"][0]["extras"] = json!({ "faceTriangleCounts": [2, 2] });
    let (model, notes) = read_json(&json).unwrap();
    assert_eq!(corner_counts(&model), [6, 3]);
    assert!(notes[0].contains("does not add up to its 5 triangles"), "{notes:?}");
}

#[test]
fn strips_fans_and_lists_without_indices_are_triangles() {
    let with = |indices: &[u16], mode: u32| {
        let mut json = file(indices);
        json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        read_json(&json).unwrap()
    };
    let (strip, _) = with(&[0, 1, 3, 2], 5);
    assert_eq!((corner_counts(&strip), strip.faces[0].plane.normal), (vec![4], DVec3::Z));
    let (fan, _) = with(&[1, 4, 5, 2, 3, 0], 6);
    assert_eq!((corner_counts(&fan), fan.faces[0].plane.normal), (vec![6], DVec3::Z));
    let mut json = file(&TRIANGLES);
    json["meshes"][0]["primitives"] = json!([{ "attributes": { "POSITION": 0 } }]);
    assert_eq!(read_json(&json).unwrap().0.faces.len(), 2);
    let mut json = file(&TRIANGLES);
    let lines = json!({ "attributes": { "POSITION": 0 }, "mode": 1 });
    json["meshes"][0]["primitives"].as_array_mut().unwrap().push(lines);
    assert_eq!(read_json(&json).unwrap().1, ["points and lines are left out"]);
}

#[test]
fn nodes_carry_their_parents_transforms_in_64_bits() {
    let mut json = file(&TRIANGLES);
    json["nodes"] = json!([
        { "translation": [4_500_000.125, 0.0, 0.0], "children": [1, 2] },
        { "name": "east", "mesh": 0, "scale": [2.0, 2.0, 2.0], "rotation": [0.0, 0.0, 1.0, 0.0] },
        { "name": "mirrored", "mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.25, 0, 0, 1] },
    ]);
    let (model, _) = read_json(&json).unwrap();
    assert_eq!(names(&model), ["east", "mirrored"]);
    assert!((model.vertices[2] - DVec3::new(4_499_998.125, -2.0, 0.0)).length() < 1e-9);
    assert_eq!(model.vertices[7 + 2], DVec3::new(4_499_999.375, 1.0, 0.0));
    assert!(model.faces.iter().step_by(2).all(|face| face.plane.normal == DVec3::Z), "wound alike");
}

#[test]
fn instances_are_objects_of_their_own_and_numbered() {
    let mut json = file(&TRIANGLES);
    // Accessor 0 has seven positions, which serve as translations here.
    let instancing = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 0 } } });
    json["nodes"] =
        json!([{ "name": "tree", "mesh": 0, "translation": [0, 0, 10], "extensions": instancing }]);
    json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let (model, notes) = read_json(&json).unwrap();
    assert_eq!(names(&model)[..3], ["tree", "tree-2", "tree-3"]);
    assert_eq!((model.objects.len(), model.faces.len()), (7, 14));
    assert_eq!(notes, ["objects of the same name were numbered (as in chair, chair-2)"]);
    for (vertices, at) in model.vertices.chunks(7).zip(CORNERS) {
        let expected = DVec3::from_array(at.map(f64::from)) + DVec3::new(1.0, 0.0, 10.0);
        assert_eq!(vertices[1], expected);
    }
    json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(1);
    assert!(
        complaint(&json).starts_with("nodes[0].extensions.EXT_mesh_gpu_instancing: 15 elements of SCALE")
    );
}

#[test]
fn names_fall_back_to_the_mesh_and_are_made_unique() {
    let mut json = file(&TRIANGLES);
    json["scenes"] = json!([]);
    json.as_object_mut().unwrap().remove("scene");
    json["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0, "name": "a" }, { "mesh": 0, "name": "a" }]);
    let (model, notes) = read_json(&json).unwrap();
    assert_eq!(names(&model), ["node_0", "a", "a-2"]);
    assert_eq!(notes.len(), 1);
    json["meshes"][0]["name"] = json!("chair");
    assert_eq!(names(&read_json(&json).unwrap().0)[0], "chair");
}

#[test]
fn a_billboard_is_named_so_or_has_the_extra() {
    let is_billboard = |change: &dyn Fn(&mut Value)| {
        let mut json = file(&TRIANGLES);
        change(&mut json);
        read_json(&json).unwrap().0.objects[0].billboard
    };
    assert!(!is_billboard(&|_| ()));
    assert!(is_billboard(&|json| json["nodes"][0]["name"] = json!("Tree Billboard")));
    assert!(is_billboard(&|json| json["nodes"][0]["extras"] = json!({ "billboard": true })));
    assert!(is_billboard(&|json| json["meshes"][0]["extras"] = json!({ "billboard": true })));
    assert!(is_billboard(&|json| {
        json["materials"] = json!([{ "name": "billboard.leaves" }]);
        json["meshes"][0]["primitives"][0]["material"] = json!(0);
    }));
}

#[test]
fn sparse_values_replace_those_of_the_view() {
    let mut json = file(&[0, 1, 2, 3, 0, 1, 2, 5, 6]);
    // Element 2 gets the position that element 5 has: (2, 1, 0).
    json["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": 1, "byteOffset": 4, "componentType": 5123 },
        "values": { "bufferView": 0, "byteOffset": 60 },
    });
    json["accessors"][1]["count"] = json!(3);
    let (model, _) = read_json(&json).unwrap();
    assert!(model.vertices.contains(&DVec3::new(2.0, 1.0, 0.0)));
    json["accessors"][0]["sparse"]["indices"]["byteOffset"] = json!(16);
    json["accessors"][0]["count"] = json!(1);
    json["accessors"][1]["count"] = json!(1);
    assert!(read_json(&json).is_err());
}

#[test]
fn glb_and_buffers_beside_the_file_hold_the_same_model() {
    let folder = tempfile::tempdir().unwrap();
    let mut json = file(&TRIANGLES);
    let uri = json["buffers"][0]["uri"].as_str().unwrap().to_owned();
    let buffers = [gltf::json::Buffer {
        byte_length: 0u64.into(),
        name: None,
        uri: Some(uri),
        extensions: None,
        extras: None,
    }];
    let bytes = container::buffers(Path::new("x"), &buffers, None).unwrap().remove(0).into_owned();
    fs::write(folder.path().join("site 1.bin"), &bytes).unwrap();
    json["buffers"][0]["uri"] = json!("site%201.bin");
    fs::write(folder.path().join("site.gltf"), json.to_string()).unwrap();
    json["buffers"][0].as_object_mut().unwrap().remove("uri");
    fs::write(folder.path().join("site.bin"), glb(&json, &bytes)).unwrap();
    let embedded = read_json(&file(&TRIANGLES)).unwrap().0;
    for name in ["site.gltf", "site.bin"] {
        assert_eq!(super::super::read_model(&folder.path().join(name), &Task::silent()).unwrap().0, embedded);
    }
}

fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(((28 + text.len() + binary.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

#[test]
fn faults_are_named_with_their_json_path() {
    let after = |change: &dyn Fn(&mut Value)| {
        let mut json = file(&TRIANGLES);
        change(&mut json);
        complaint(&json)
    };
    let huge = 1u64 << 60;
    for (said, place, found) in [
        (after(&|j| j["nodes"][0]["children"] = json!([0])), "nodes[0]: ", "its own ancestor"),
        (after(&|j| j["scenes"][0]["nodes"] = json!([0, 0])), "nodes[0]: ", "two parents"),
        (after(&|j| j["scenes"][0]["nodes"] = json!([9])), "nodes[9]: ", "does not exist"),
        (after(&|j| j["scene"] = json!(3)), "scene: ", "scene 3 of 1"),
        (after(&|j| j["nodes"][0]["mesh"] = json!(4)), "meshes[4]: ", "does not exist"),
        (after(&|j| j["nodes"][0]["rotation"] = json!([0, 0, 0, 0])), "nodes[0]: ", "not finite"),
        (after(&|j| j["nodes"][0]["scale"] = json!([1e30, 1e30, 1e30])), "nodes[0]: ", "within 1e15"),
        (
            after(&|j| j["accessors"][0]["count"] = json!(huge)),
            "accessors[0]: ",
            "more than 30000000 elements",
        ),
        (
            after(&|j| j["accessors"][0]["count"] = json!(9)),
            "accessors[0]: ",
            "9 elements of 12 bytes in the 84",
        ),
        (
            after(&|j| j["accessors"][0]["count"] = json!(3)),
            "meshes[0].primitives[0]: ",
            "an index refers to vertex 3 of 3",
        ),
        (after(&|j| j["accessors"][0]["byteOffset"] = json!(huge)), "accessors[0]: ", "7 elements"),
        (
            after(&|j| j["accessors"][0]["bufferView"] = json!(7)),
            "accessors[0]: ",
            "bufferViews[7], which is missing",
        ),
        (
            after(&|j| j["bufferViews"][0]["byteLength"] = json!(huge)),
            "accessors[0]: ",
            "not within its buffer",
        ),
        (after(&|j| j["bufferViews"][0]["byteStride"] = json!(4)), "accessors[0]: ", "a byteStride of 4"),
        (
            after(&|j| j["buffers"][0]["byteLength"] = json!(huge)),
            "buffers[0]: ",
            "bytes where byteLength says",
        ),
        (
            after(&|j| j["buffers"][0]["uri"] = json!("../x.bin")),
            "buffers[0]: ",
            "leads out of the model's folder",
        ),
        (after(&|j| j["buffers"][0]["uri"] = json!("https://x.y/z")), "buffers[0]: ", "leads out of"),
        (
            after(&|j| j["extensionsRequired"] = json!(["KHR_draco_mesh_compression"])),
            "extensionsRequired: ",
            "compressed (KHR_draco_mesh_compression)",
        ),
        (
            after(&|j| j["extensionsRequired"] = json!(["ACME_curved_spaces"])),
            "extensionsRequired: ",
            "needs the extension ACME_curved_spaces, which is not read; export the model without it",
        ),
        (
            after(&|j| j["extensions"] = json!({ "CESIUM_RTC": { "center": [5e5, 4e6, 9.0] } })),
            "extensions.CESIUM_RTC: ",
            "the whole model is moved by the extension CESIUM_RTC",
        ),
        (
            after(&|j| {
                j["meshes"][0]["primitives"][0]["extensions"] = json!({ "KHR_draco_mesh_compression": {} });
                j["accessors"][0].as_object_mut().unwrap().remove("bufferView");
            }),
            "meshes[0].primitives[0]: ",
            "compressed (KHR_draco_mesh_compression)",
        ),
        (
            after(&|j| {
                j["accessors"][0].as_object_mut().unwrap().remove("bufferView");
                j["accessors"][0]["extensions"] = json!({ "MPEG_accessor_timed": {} });
            }),
            "accessors[0]: ",
            "its values come from the extension MPEG_accessor_timed",
        ),
        (
            after(&|j| {
                j["buffers"].as_array_mut().unwrap().push(json!({ "byteLength": 84 }));
                j["bufferViews"][0]["buffer"] = json!(1);
                j["bufferViews"][0]["extensions"] = json!({ "EXT_meshopt_compression": { "buffer": 0 } });
            }),
            "bufferViews[0]: ",
            "compressed (EXT_meshopt_compression), which is not read; export the model without compression",
        ),
        (after(&|j| j["meshes"] = json!(7)), "line 1 column ", "the number 7, expected a list"),
    ] {
        assert!(said.starts_with(place) && said.contains(found), "{place}{found}: {said}");
    }
    assert!(read_bytes(b"glTF\x01\0\0\0\0\0\0\0").unwrap_err().to_string().contains("GLB version 1"));
    assert!(read_bytes(b"glTF\x02").unwrap_err().to_string().contains("truncated: it has 5 bytes"));
    assert!(read_bytes(&b"[".repeat(100_000)).is_err());
}

#[test]
fn required_extensions_that_do_not_touch_polygons_are_no_reason_to_refuse() {
    let mut json = file(&TRIANGLES);
    let required = ["KHR_materials_unlit", "KHR_texture_basisu", "EXT_texture_webp", "KHR_mesh_quantization"];
    json["extensionsRequired"] = json!(required);
    json["extensionsUsed"] = json!(required);
    json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [] }, "EXT_structural_metadata": {} });
    json["meshes"][0]["primitives"][0]["extensions"] =
        json!({ "KHR_materials_variants": { "mappings": [] } });
    let (model, notes) = read_json(&json).unwrap();
    assert_eq!((model, notes), read_json(&file(&TRIANGLES)).unwrap());
}

#[test]
fn an_unknown_extension_on_a_mesh_or_node_is_told_once_with_the_first_place() {
    let mut json = file(&TRIANGLES);
    let unknown = json!({ "ACME_bent": { "by": 3 } });
    json["nodes"][0]["extensions"] = unknown.clone();
    json["meshes"][0]["primitives"][0]["extensions"] = unknown.clone();
    json["materials"] = json!([{ "extensions": { "ACME_paint": {} } }]);
    let (_, notes) = read_json(&json).unwrap();
    let said = "the extension ACME_bent has no effect, although it may change what is seen \
                (meshes[0].primitives[0] and 1 more places)";
    assert_eq!(notes, [said]);
}

#[test]
fn integers_as_positions_are_read_with_and_without_normalisation() {
    // The first four corners in bytes of 0..=100, and in normalised bytes whose full range is 0..=1.
    for (component, normalized, full) in [(5121, false, 1u8), (5121, true, 255), (5120, true, 127)] {
        let mut json = file(&[0, 1, 2, 0, 2, 3]);
        let corners = [[0, 0, 0], [full, 0, 0], [full, full, 0], [0, full, 0]];
        let bytes: Vec<u8> = corners.iter().flat_map(|[x, y, z]| [*x, *y, *z, 0]).collect();
        json["accessors"][0] = json!({ "bufferView": 2, "componentType": component, "normalized": normalized, "count": 4, "type": "VEC3" });
        json["bufferViews"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "buffer": 1, "byteLength": 16, "byteStride": 4 }));
        let uri = format!("data:;base64,{}", base64(&bytes));
        json["buffers"].as_array_mut().unwrap().push(json!({ "byteLength": 16, "uri": uri }));
        json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let (model, _) = read_json(&json).unwrap();
        let truth = read_json(&file(&[0, 1, 2, 0, 2, 3])).unwrap().0;
        assert_eq!(model.vertices[..4], truth.vertices[..4], "{component} {normalized}");
    }
}

#[test]
fn hidden_nodes_and_coarser_levels_are_left_out_with_what_is_below_them() {
    let mut json = file(&TRIANGLES);
    let visible = |is: bool| json!({ "KHR_node_visibility": { "visible": is } });
    json["nodes"] = json!([
        { "name": "shown", "mesh": 0, "extensions": visible(true) },
        { "name": "draft", "mesh": 0, "children": [2], "extensions": visible(false) },
        { "name": "below", "mesh": 0, "extensions": visible(true) },
        { "name": "fine", "mesh": 0, "extensions": { "MSFT_lod": { "ids": [4] } } },
        { "name": "coarse", "mesh": 0 },
        { "mesh": 0, "extensions": visible(false) },
    ]);
    json["scenes"] = json!([]);
    json.as_object_mut().unwrap().remove("scene");
    let (model, notes) = read_json(&json).unwrap();
    assert_eq!(names(&model), ["shown", "fine"]);
    assert_eq!(
        notes,
        [
            "hidden nodes (KHR_node_visibility) are left out, with everything below them: draft, nodes[5]",
            "nodes[3]: of the levels of detail of MSFT_lod, the finest is read",
        ]
    );
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn damaged_files_are_read_or_refused(
        cut in 1..3000usize,
        changes in prop::collection::vec((0..3000usize, any::<u8>()), 0..5),
        digits in prop::collection::vec((0..300usize, b'0'..=b'9'), 0..5),
        binary in any::<bool>(),
    ) {
        let json = file(&TRIANGLES);
        let mut bytes = if binary { glb(&json, &[0; 16]) } else { json.to_string().into_bytes() };
        bytes.truncate(cut);
        for (at, byte) in changes {
            let at = at % bytes.len();
            bytes[at] = byte;
        }
        // Digits are exchanged for digits, so the file stays JSON but has other values.
        let places: Vec<usize> = (0..bytes.len()).filter(|&i| bytes[i].is_ascii_digit()).collect();
        for (at, digit) in digits {
            if let Some(&place) = places.get(at) {
                bytes[place] = digit;
            }
        }
        let _ = read_bytes(&bytes);
    }
}

#[test]
fn other_versions_are_refused_by_name_and_later_ones_are_told_where_they_may_be_read() {
    let with = |asset: Value| {
        let mut json = file(&TRIANGLES);
        json["asset"] = asset;
        json
    };
    let refused = [
        (json!({ "version": "1.0" }), "asset.version: glTF 1.0, of which 2.0 is read"),
        (json!({ "version": "3.0" }), "asset.version: glTF 3.0"),
        (json!({ "version": "draft" }), "asset.version: glTF draft"),
        (json!({ "version": "2.0", "minVersion": "2.1" }), "asset.minVersion: glTF 2.1"),
    ];
    for (asset, part) in refused {
        let said = complaint(&with(asset));
        assert!(said.contains(part) && said.contains("as glTF 2.0"), "{said}");
    }
    // Lists of 1.0 are objects, which would be complained about first.
    let first = json!({ "asset": { "version": "1.1" }, "scenes": { "a": { "nodes": ["b"] } }, "nodes": {} });
    assert!(complaint(&first).contains("glTF 1.1"));
    let (model, notes) = read_json(&with(json!({ "version": "2.1", "minVersion": "2.0" }))).unwrap();
    assert!(model.faces.len() == 2 && notes[0].contains("newer than 2.0"), "{notes:?}");
}

#[test]
fn json_in_other_encodings_is_named_with_what_to_do() {
    let text = file(&TRIANGLES).to_string();
    let wide = |unit: fn(u16) -> [u8; 2], mark: &[u8]| {
        let units = text.encode_utf16().flat_map(unit);
        mark.iter().copied().chain(units).collect::<Vec<u8>>()
    };
    for bytes in [
        wide(u16::to_le_bytes, b"\xff\xfe"),
        wide(u16::to_be_bytes, b"\xfe\xff"),
        wide(u16::to_le_bytes, b""),
        wide(u16::to_be_bytes, b""),
    ] {
        let said = read_bytes(&bytes).unwrap_err().to_string();
        assert!(said.contains("UTF-16") && said.contains("save it as UTF-8"), "{said}");
    }
    let widest: Vec<u8> = text.chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
    assert!(read_bytes(&widest).unwrap_err().to_string().contains("UTF-32"));
}

#[test]
fn a_glb_that_is_cut_short_anywhere_says_how_long_it_is_and_should_be() {
    let json = file(&TRIANGLES);
    let whole = glb(&json, &[7; 40]);
    for length in [4, 8, 11, 12, 19, 20, 100, whole.len() - 1] {
        let said = read_bytes(&whole[..length]).unwrap_err().to_string();
        assert!(said.contains(&format!("truncated: it has {length} bytes, expected")), "{said}");
        assert!(length < 12 || said.contains(&format!("expected {} at least", whole.len())), "{said}");
    }
    let mut without = b"glTF\x02\0\0\0\x18\0\0\0\x04\0\0\0BIN\0".to_vec();
    without.extend([1, 2, 3, 4]);
    assert!(read_bytes(&without).unwrap_err().to_string().contains("no chunk of JSON"));
}
