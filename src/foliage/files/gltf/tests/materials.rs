//! Tests of materials: pictures, what is cut out, what is let through, and what is a leaf.

use image::{Rgba, RgbaImage};

use super::*;
use crate::{Material, Wrap};

/// A picture of two pixels: nothing, and green.
fn half() -> RgbaImage {
    RgbaImage::from_fn(2, 1, |x, _| Rgba(if x == 0 { [255, 0, 0, 0] } else { [0, 255, 0, 255] }))
}

/// Reads the only material of a file, with a picture as texture 0.
fn read(material: Value) -> (Option<Arc<Material>>, Vec<String>) {
    let mut glb = Glb::new(json!([{ "mesh": 0 }]));
    glb.texture(&half());
    glb.json["materials"] = json!([material]);
    glb.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let (plant, notes) = glb.noted();
    (plant.whole().primitives.first().map(|primitive| primitive.material.clone()), notes)
}

fn material(material: Value) -> Arc<Material> {
    read(material).0.unwrap()
}

fn textured(more: Value) -> Value {
    let mut material = json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } });
    material.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    material
}

#[test]
fn the_base_colour_is_reflected_and_its_picture_repeats() {
    let plain = material(
        json!({ "name": "bark", "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 0.125, 1] } }),
    );
    assert_eq!((plain.name.as_str(), plain.reflected, plain.leaf), ("bark", [0.5, 0.25, 0.125], false));
    assert_eq!((plain.cutout, plain.picture.is_none(), plain.through), (None, true, [0.0; 3]));
    let textured = material(textured(json!({})));
    assert_eq!((textured.reflected, textured.wrap, textured.cutout), ([1.0; 3], [Wrap::Repeated; 2], None));
    assert_eq!(textured.picture.as_ref().unwrap().rgba(), [[255, 0, 0, 0], [0, 255, 0, 255]]);
    let none = Glb::new(json!([{ "mesh": 0 }])).plant();
    assert_eq!(none.whole().primitives[0].material.reflected, [1.0; 3]);
}

#[test]
fn mask_and_blend_are_cut_out_at_the_alpha_that_is_said_or_at_a_half() {
    let cutout = |more: Value| material(textured(more)).cutout;
    assert_eq!(cutout(json!({ "alphaMode": "MASK" })), Some(0.5));
    assert_eq!(cutout(json!({ "alphaMode": "MASK", "alphaCutoff": 0.25 })), Some(0.25));
    assert_eq!(cutout(json!({ "alphaMode": "BLEND" })), Some(0.5));
    assert_eq!(cutout(json!({ "alphaMode": "OPAQUE" })), None);
    let faint = |alpha: f64, mode: &str| {
        let base = json!({ "baseColorTexture": { "index": 0 }, "baseColorFactor": [1, 1, 1, alpha] });
        read(json!({ "alphaMode": mode, "pbrMetallicRoughness": base }))
    };
    // The factor multiplies the picture's alpha.
    assert_eq!(faint(0.8, "MASK").0.unwrap().cutout, Some(0.5 / 0.8));
    let (nothing, notes) = faint(0.4, "BLEND");
    assert!(nothing.is_none() && notes[0].contains("materials[0]: a surface is left out"), "{notes:?}");
    let (glass, notes) = read(json!({ "alphaMode": "BLEND" }));
    assert_eq!(glass.unwrap().cutout, None);
    assert!(notes[0].contains("alphaMode has no effect without a picture"), "{notes:?}");
}

#[test]
fn diffuse_transmission_is_let_through_and_not_reflected() {
    let with = |transmission: Value| {
        let base = json!({ "baseColorFactor": [0.5, 0.5, 0.5, 1] });
        let extensions = json!({ "KHR_materials_diffuse_transmission": transmission });
        material(json!({ "pbrMetallicRoughness": base, "extensions": extensions }))
    };
    let leaf =
        with(json!({ "diffuseTransmissionFactor": 0.25, "diffuseTransmissionColorFactor": [0.5, 1, 0] }));
    assert_eq!((leaf.reflected, leaf.through, leaf.leaf), ([0.375; 3], [0.125, 0.25, 0.0], true));
    let none = with(json!({}));
    assert_eq!((none.reflected, none.through, none.leaf), ([0.5; 3], [0.0; 3], true));
    // Pictures count by their means: half of the alpha, and green where there is any.
    let textured = with(json!({
        "diffuseTransmissionFactor": 1.0,
        "diffuseTransmissionTexture": { "index": 0 },
        "diffuseTransmissionColorTexture": { "index": 0 },
    }));
    assert_eq!((textured.reflected, textured.through), ([0.25; 3], [0.0, 0.5, 0.0]));
}

#[test]
fn leaves_are_called_so_or_cut_out_and_seen_from_both_sides() {
    for (name, is_leaf) in [
        ("leaf", true),
        ("Leaves_01", true),
        ("maple_leaf.002", true),
        ("leafage", true),
        ("cloverleaf", false),
        ("bark", false),
        ("", false),
    ] {
        assert_eq!(material(json!({ "name": name })).leaf, is_leaf, "{name}");
    }
    assert!(material(textured(json!({ "alphaMode": "MASK", "doubleSided": true }))).leaf);
    assert!(!material(textured(json!({ "alphaMode": "MASK" }))).leaf);
    assert!(!material(textured(json!({ "doubleSided": true }))).leaf);
}

#[test]
fn samplers_say_how_pictures_go_on() {
    let mut glb = Glb::new(json!([{ "mesh": 0 }]));
    glb.texture(&half());
    glb.json["textures"][0]["sampler"] = json!(0);
    glb.json["samplers"] = json!([{ "wrapS": 33071, "wrapT": 33648 }]);
    glb.json["materials"] = json!([textured(json!({}))]);
    glb.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let plant = glb.plant();
    assert_eq!(plant.whole().primitives[0].material.wrap, [Wrap::Held, Wrap::Mirrored]);
}

#[test]
fn normals_and_the_set_of_texture_coordinates_that_the_picture_names_are_read() {
    let mut glb = Glb::new(json!([{ "mesh": 0 }]));
    glb.texture(&half());
    let normals = glb.floats("VEC3", &[[0., 0., 2.], [0., f32::NAN, 0.], [1., 0., 0.]]);
    let bytes = [0u8, 255, 51, 0, 255, 255];
    let textures = json!({ "componentType": 5121, "count": 3, "type": "VEC2", "normalized": true });
    let textures = glb.accessor(&bytes, textures);
    glb.json["materials"] =
        json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "texCoord": 1 } } }]);
    let attributes = json!({ "POSITION": 0, "NORMAL": normals, "TEXCOORD_0": 0, "TEXCOORD_1": textures });
    glb.json["meshes"][0]["primitives"][0] = json!({ "attributes": attributes, "material": 0 });
    let plant = glb.plant();
    let corners = corners(plant.whole());
    assert_eq!([0, 1, 2].map(|i| corners[i].normal), [DVec3::Z, DVec3::ZERO, DVec3::X]);
    let textures = [0, 1, 2].map(|i| corners[i].texture.to_array());
    assert_eq!(textures, [[0.0, 1.0], [0.2, 0.0], [1.0, 1.0]]);
}
