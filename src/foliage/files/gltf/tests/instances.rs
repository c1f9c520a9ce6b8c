//! Tests of the graph: nodes, repetition that is found again, and instances.

use glam::{DAffine3, DQuat};

use super::*;
use quadratura_base::scene::synthetic::Rng;

#[test]
fn a_node_is_a_sub_object_and_its_children_are_uses() {
    let glb = Glb::new(json!([
        { "name": "tree", "mesh": 0, "children": [1, 2, 3] },
        { "name": "twig", "mesh": 0, "translation": [0, 2, 0], "scale": [0.5, 0.5, 0.5] },
        { "name": "camera", "camera": 0 },
        { "translation": [1, 0, 0], "children": [4] },
        { "mesh": 0, "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 3, 4, 5, 1] },
    ]));
    let plant = glb.plant();
    assert_eq!((plant.whole().name.as_str(), plant.up, plant.unit), ("tree", DVec3::Y, 1.0));
    assert_eq!(feet(&plant), [(0., 0., 0.), (0., 2., 0.), (4., 4., 5.)].map(DVec3::from));
    let counts = plant.whole().counts;
    assert_eq!((counts.sub_objects, counts.polygons, counts.levels), (3, 3, 3));
    let names: Vec<&str> = plant.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(names, ["twig", "node_3", "tree"], "what holds nothing is left out");
}

#[test]
fn a_scene_of_several_nodes_or_of_one_that_is_moved_uses_them() {
    for (nodes, uses) in [
        (json!([{ "mesh": 0 }]), 0),
        (json!([{ "mesh": 0, "translation": [1, 0, 0] }]), 1),
        (json!([{ "mesh": 0 }, { "mesh": 0 }]), 2),
    ] {
        let plant = Glb::new(nodes).plant();
        assert_eq!(plant.whole().uses.len(), uses);
        assert_eq!(plant.whole().name, if uses == 0 { "node_0" } else { "tree.glb" });
    }
    let empty = Glb::new(json!([{ "name": "nothing" }])).plant();
    assert_eq!(empty.whole().counts.polygons, 0);
}

/// Two branches with two leaves each; the second one's transforms are `shift` aside, and its leaves in reverse order.
fn branches(shift: f64) -> Glb {
    let leaf = |x: f64| json!({ "name": format!("leaf {x}"), "mesh": 0, "translation": [x, 0.1, 0] });
    Glb::new(json!([
        { "name": "branch", "children": [2, 3], "translation": [0, 1, 0] },
        { "name": "branch.001", "children": [4, 5], "translation": [0, 2, 0] },
        leaf(1.0), leaf(2.0), leaf(2.0 + shift), leaf(1.0 + shift),
    ]))
}

#[test]
fn nodes_with_the_same_mesh_and_children_become_one_sub_object() {
    // Less than half of a step of 32-bit numbers at 1.
    let same = branches(2e-8).plant();
    let names: Vec<&str> = same.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(names, ["leaf 1", "branch", "tree.glb"]);
    assert_eq!((same.whole().counts.sub_objects, same.instances()[0]), (4, 4));
    assert!(feet(&same)[1].distance(DVec3::new(2.0, 1.1, 0.0)) < 1e-7);
    let other = branches(1e-6).plant();
    assert_eq!(other.objects.len(), 4, "the branches differ");
    assert_eq!(other.whole().counts, same.whole().counts);
}

/// The values of the three accessors of instances.
struct Instances {
    translations: Vec<[f32; 3]>,
    rotations: Vec<[f32; 4]>,
    scales: Vec<[f32; 3]>,
}

/// Instances at known places; the first rotation has a length of 2.
fn any_instances(count: usize) -> Instances {
    let mut rng = Rng::new(5);
    let mut number = |low: f64, high: f64| rng.between(low, high) as f32;
    let translations = (0..count).map(|_| [(); 3].map(|()| number(-1.0, 1.0))).collect();
    let turn = |i: usize| if i == 0 { [0.0, 0.0, 0.0, 2.0] } else { [(); 4].map(|()| number(-1.0, 1.0)) };
    let rotations = (0..count).map(turn).collect();
    let scales = (0..count).map(|_| [(); 3].map(|()| number(0.1, 2.0))).collect();
    Instances { translations, rotations, scales }
}

#[test]
fn instances_are_uses_at_node_times_translation_rotation_scale() {
    let Instances { translations, rotations, scales } = any_instances(7);
    let node = json!({ "name": "leaves", "mesh": 0, "translation": [5, 0, 0], "rotation": [0, 0, 1, 0] });
    let mut glb = Glb::new(json!([{ "children": [1] }, node]));
    let (t, r, s) =
        (glb.floats("VEC3", &translations), glb.floats("VEC4", &rotations), glb.floats("VEC3", &scales));
    glb.instancing(1, json!({ "TRANSLATION": t, "ROTATION": r, "SCALE": s, "_ID": 99 }));
    glb.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let plant = glb.plant();
    let counts = plant.whole().counts;
    assert_eq!((counts.sub_objects, counts.polygons, plant.objects.len()), (7, 7, 3));
    let node = DAffine3::from_rotation_translation(DQuat::from_xyzw(0., 0., 1., 0.), DVec3::new(5., 0., 0.));
    let leaves = &plant.objects[1];
    assert_eq!((leaves.name.as_str(), leaves.uses.len()), ("leaves", 7));
    for (i, of) in leaves.uses.iter().enumerate() {
        let turn = DQuat::from_array(rotations[i].map(f64::from)).normalize();
        let point = DVec3::new(0.2, -0.7, 1.1);
        let expected = turn * (point * DVec3::from_array(scales[i].map(f64::from)))
            + DVec3::from_array(translations[i].map(f64::from));
        // Rounding of a few operations on numbers near 1.
        assert!(of.parent_from_child.transform_point3(point).distance(expected) < 1e-14, "{i}");
        let foot = node.transform_point3(DVec3::from_array(translations[i].map(f64::from)));
        assert!(feet(&plant)[i].distance(foot) < 1e-14, "{i}");
    }
}

#[test]
fn rotations_may_be_normalised_integers_and_attributes_may_be_missing() {
    let quarter = std::f64::consts::FRAC_1_SQRT_2;
    let read = |glb: &mut Glb, accessor: usize| {
        glb.instancing(0, json!({ "ROTATION": accessor }));
        let plant = glb.plant();
        plant.whole().uses.iter().map(|of| of.parent_from_child.matrix3.x_axis).collect::<Vec<_>>()
    };
    let bytes: Vec<u8> = [0i8, 0, 90, 90, 0, 0, 127, 0].map(|n| n as u8).into();
    let mut glb = Glb::new(json!([{ "mesh": 0 }]));
    let as_bytes = glb
        .accessor(&bytes, json!({ "componentType": 5120, "count": 2, "type": "VEC4", "normalized": true }));
    let shorts: Vec<u8> = [0, 0, (32767.0 * quarter) as i16, (32767.0 * quarter) as i16, 0, 0, 32767, 0]
        .iter()
        .flat_map(|n: &i16| n.to_le_bytes())
        .collect();
    let as_shorts = glb
        .accessor(&shorts, json!({ "componentType": 5122, "count": 2, "type": "VEC4", "normalized": true }));
    for accessor in [as_bytes, as_shorts] {
        let axes = read(&mut glb, accessor);
        // Equal numbers stay equal, so that a quarter turn is exact but for rounding.
        assert!(axes[0].distance(DVec3::Y) < 1e-15 && axes[1].distance(-DVec3::X) < 1e-15, "{axes:?}");
    }
    glb.instancing(0, json!({ "_ID": 0 }));
    assert_eq!(glb.plant().whole().uses.len(), 0, "instances without a place are one");
}

#[test]
fn instances_and_nodes_at_the_same_places_are_one_graph() {
    let places = [[0.0f32, 1.0, 0.0], [0.5, 2.0, 0.0]];
    let mut instanced = Glb::new(json!([{ "name": "leaf", "mesh": 0 }]));
    let accessor = instanced.floats("VEC3", &places);
    instanced.instancing(0, json!({ "TRANSLATION": accessor }));
    let leaf = |place: [f32; 3]| json!({ "name": "leaf", "mesh": 0, "translation": place });
    let nodes = Glb::new(json!([{ "name": "leaf", "children": [1, 2] }, leaf(places[0]), leaf(places[1])]));
    assert!(instanced.plant() == nodes.plant());
}

#[test]
fn a_thousand_twigs_that_are_written_out_are_stored_once() {
    let mut nodes = vec![json!({ "name": "tree", "children": (1..=1000).collect::<Vec<_>>() })];
    let leaf = |at: usize| json!({ "mesh": 0, "translation": [0.1 * at as f64, 0.2, 0.3] });
    nodes.extend(
        (0..1000).map(|i| json!({ "children": [1001 + 2 * i, 1002 + 2 * i], "translation": [i, 0, 0] })),
    );
    nodes.extend((0..2000).map(|i| leaf(i % 2)));
    let plant = Glb::new(json!(nodes)).plant();
    assert_eq!((plant.objects.len(), plant.whole().counts.polygons), (3, 2000));
    assert_eq!(plant.instances(), [2000, 1000, 1]);
}
