//! Tests of the formats on a house of two pages.

use super::*;
use serde_json::Value;

use super::obj::UpAxis;

const GENERATOR: &str = "a test";

/// A house of one wall and its gable on two pages, and a sheet on the first.
pub fn model() -> TexturedModel {
    let corner =
        |x: f64, z: f64| Corner { position: DVec3::new(x, 1.5, z), uv: DVec2::new(x / 8.0, 1.0 - z / 8.0) };
    let wall = TexturedFace {
        corners: vec![corner(0.0, 0.0), corner(4.0, 0.0), corner(4.0, 3.0), corner(0.0, 3.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        page: 0,
    };
    let gable = TexturedFace {
        corners: vec![corner(0.0, 3.0), corner(4.0, 3.0), corner(2.0, 5.25)],
        triangles: vec![[0, 1, 2]],
        page: 1,
    };
    let page = |file: &str, kind| TexturePage {
        file: file.into(),
        kind,
        tile: None,
        bytes: encoded(kind, &[200; 4 * 256][..256 * kind.channels()], [16, 16]),
    };
    TexturedModel {
        name: "site".into(),
        origin: DVec3::new(1000.0, 2000.0, 0.0),
        up: DVec3::Z,
        objects: vec![
            TexturedObject {
                name: "house, old".into(),
                faces: vec![wall.clone(), gable, wall.clone()],
                billboard: false,
            },
            TexturedObject { name: "sheet".into(), faces: vec![wall], billboard: true },
            TexturedObject { name: "nothing".into(), faces: vec![], billboard: false },
        ],
        pages: vec![page("site_1.jpg", PageKind::Jpeg), page("site_2.png", PageKind::PngWithAlpha)],
    }
}

/// Returns the two chunks of a file, after checking the lengths that it says.
fn chunks(file: &[u8]) -> (Value, &[u8]) {
    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&file[..4], word(4), word(8)), (&b"glTF"[..], 2, file.len()));
    let length = word(12);
    assert_eq!((length % 4, &file[16..20]), (0, &b"JSON"[..]));
    let binary = &file[20 + length..];
    assert_eq!((&binary[4..8], word(20 + length)), (&b"BIN\0"[..], binary.len() - 8));
    (serde_json::from_slice(&file[20..20 + length]).unwrap(), &binary[8..])
}

#[test]
fn a_glb_has_a_node_per_object_and_keeps_the_order_of_faces_over_pages() {
    let file = glb::glb(&model(), GENERATOR);
    assert_eq!(file.name, "site.glb");
    let (json, binary) = chunks(&file.bytes);
    assert_eq!(json["nodes"][0]["children"], serde_json::json!([1, 2]));
    assert_eq!(json["nodes"][0]["extras"]["origin"], serde_json::json!([1000.0, 2000.0, 0.0]));
    assert_eq!(json["nodes"][1]["name"], "house, old");
    assert_eq!(json["nodes"][2]["extras"]["billboard"], true);
    assert_eq!(json["meshes"][0]["extras"]["faceTriangleCounts"], serde_json::json!([2, 1, 2]));
    let primitives = json["meshes"][0]["primitives"].as_array().unwrap();
    let materials: Vec<_> =
        primitives.iter().map(|primitive| primitive["material"].as_u64().unwrap()).collect();
    assert_eq!(materials, [0, 1, 0]);
    assert_eq!(json["materials"][1]["alphaMode"], "MASK");
    let view = &json["bufferViews"][json["images"][0]["bufferView"].as_u64().unwrap() as usize];
    let [at, length] = ["byteOffset", "byteLength"].map(|key| view[key].as_u64().unwrap() as usize);
    assert_eq!(&binary[at..at + length], &model().pages[0].bytes[..]);
}

#[test]
fn the_root_node_turns_up_to_y_and_leaves_x_where_z_was_up() {
    for up in [DVec3::Z, DVec3::Y, DVec3::new(0.6, 0.0, 0.8), DVec3::NEG_Y] {
        let turned = glb::y_from_up(up) * up;
        assert!((turned - DVec3::Y).length() < 1e-12, "{up} becomes {turned}");
    }
    assert!((glb::y_from_up(DVec3::Z) * DVec3::X - DVec3::X).length() < 1e-12);
}

#[test]
fn an_obj_has_polygons_and_shares_corners() {
    let files = obj::obj(model(), UpAxis::Project, GENERATOR);
    let names: Vec<_> = files.iter().map(|file| file.name.as_str()).collect();
    assert_eq!(names, ["site.obj", "site.mtl", "site_1.jpg", "site_2.png"]);
    let text = String::from_utf8(files[0].bytes.clone()).unwrap();
    let lines = |start: &str| {
        text.lines().filter(|line| line.starts_with(start)).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(lines("o "), ["o house, old", "o sheet"]);
    assert_eq!(lines("f "), ["f 1/1 2/2 3/3 4/4", "f 4/4 3/3 5/5", "f 1/1 2/2 3/3 4/4", "f 1/1 2/2 3/3 4/4"]);
    assert_eq!(lines("v ").last().unwrap(), "v 2 1.5 5.25");
    assert_eq!(lines("usemtl "), ["usemtl site_1", "usemtl site_2", "usemtl site_1", "usemtl site_1"]);
    let turned = String::from_utf8(obj::obj(model(), UpAxis::Y, GENERATOR)[0].bytes.clone()).unwrap();
    assert!(turned.contains("\nv 2 5.25 -1.5\n"), "{turned}");
}

/// The house with its pages as tiles, of which the second is the first of the second row.
fn tiled() -> TexturedModel {
    let mut model = model();
    for (page, tile) in model.pages.iter_mut().zip([0, 10]) {
        page.file = format!("site.{}.jpg", FIRST_UDIM + tile);
        (page.tile, page.kind) = (Some(tile), PageKind::Jpeg);
    }
    model
}

#[test]
fn tiles_have_squares_of_their_own_and_materials_of_the_format() {
    let text = |files: &[WrittenFile], name: &str| {
        let file = files.iter().find(|file| file.name == name).unwrap();
        String::from_utf8(file.bytes.clone()).unwrap()
    };
    let files = obj::obj(tiled(), UpAxis::Project, GENERATOR);
    let (geometry, materials) = (text(&files, "site.obj"), text(&files, "site.mtl"));
    // The gable's top is on the tile 1011: in the first column of the second row.
    assert!(geometry.contains("\nvt 0.25000000 1.65625000\n"), "{geometry}");
    assert!(geometry.contains("usemtl site.1001") && geometry.contains("usemtl site.1011"), "{geometry}");
    assert!(materials.contains("map_Ke -clamp on site.1011.jpg"), "{materials}");
    let stage = text(&usd::usd(tiled(), &[], GENERATOR), "site.usda");
    assert_eq!(stage.matches("def Material").count(), 1, "tiles are one material");
    assert!(stage.contains("@./site.<UDIM>.jpg@") && !stage.contains("GeomSubset"), "{stage}");
    assert!(stage.contains("(0.25, 1.65625)"), "{stage}");
}
