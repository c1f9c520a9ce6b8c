//! A script read as Nuke reads it: by a parser of its grammar, and an evaluator of the cameras in it.

use std::collections::BTreeMap;

use glam::{DMat3, DVec2, DVec3};

use super::*;
use crate::blender::scene::uv_from_world;
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::synthetic::Rng;

/// A node as it was read: its class, its knobs as text, and the nodes that are its inputs.
#[derive(Debug, Clone)]
struct Node {
    class: String,
    knobs: BTreeMap<String, String>,
    inputs: Vec<usize>,
}

/// Splits a value off a text: quoted, in balanced braces, in brackets, or a word.
fn value(text: &str) -> (String, &str) {
    let text = text.trim_start_matches(' ');
    let (mut depth, mut quoted, mut escaped) = (0, false, false);
    for (at, c) in text.char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' if depth == 0 => quoted = !quoted,
            '{' | '[' if !quoted => depth += 1,
            '}' | ']' if !quoted => {
                if depth == 0 {
                    return (text[..at].to_owned(), &text[at..]);
                }
                depth -= 1;
            }
            ' ' | '\n' if depth == 0 && !quoted => return (text[..at].to_owned(), &text[at..]),
            _ => (),
        }
    }
    assert!(depth == 0 && !quoted && !escaped, "unbalanced: {text}");
    (text.to_owned(), "")
}

/// Reads a script: nodes by their order. Stacks of groups are their own.
fn read(script: &str) -> Vec<Node> {
    let (mut nodes, mut names) = (Vec::<Node>::new(), BTreeMap::<String, usize>::new());
    let mut stacks: Vec<Vec<usize>> = vec![Vec::new()];
    let mut groups: Vec<usize> = Vec::new();
    let mut rest = script;
    while let Some(line) = rest.lines().next() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let stack = stacks.last_mut().unwrap();
        match &words[..] {
            ["set", name, "[stack", "0]"] => {
                names.insert((*name).to_owned(), *stack.last().expect("a node to name"));
            }
            ["push", name] => stack.push(names[name.strip_prefix('$').unwrap()]),
            ["end_group"] => {
                let inside = stacks.pop().unwrap();
                assert_eq!(inside.len(), 1, "a group leaves its output");
                assert_eq!(nodes[inside[0]].class, "Output");
                stacks.last_mut().unwrap().push(groups.pop().unwrap());
            }
            [class, "{"] => {
                let mut knobs = BTreeMap::new();
                rest = &rest[line.len() + 1..];
                loop {
                    let line = rest.lines().next().unwrap();
                    if line.trim() == "}" {
                        break;
                    }
                    let (knob, after) = value(line);
                    let (found, left) = value(after);
                    assert!(left.is_empty(), "{line}");
                    assert!(knobs.insert(knob, found).is_none(), "{line} is there twice");
                    rest = &rest[line.len() + 1..];
                }
                let count = knobs.get("inputs").map_or(1, |count| count.parse().unwrap());
                let count = if *class == "Root" { 0 } else { count };
                let inputs: Vec<usize> = (0..count).map(|_| stack.pop().expect("an input")).collect();
                nodes.push(Node { class: (*class).to_owned(), knobs, inputs });
                match *class {
                    "Root" => (),
                    "Group" => {
                        groups.push(nodes.len() - 1);
                        stacks.push(Vec::new());
                    }
                    _ => stack.push(nodes.len() - 1),
                }
            }
            other => assert!(line.starts_with('#') || other.first() == Some(&"version"), "{line}"),
        }
        let line = rest.lines().next().unwrap();
        rest = rest.get(line.len() + 1..).unwrap_or("");
    }
    assert_eq!(stacks.len(), 1, "groups end");
    nodes
}

fn numbers(text: &str) -> Vec<f64> {
    let bare: String = text.chars().map(|c| if "{}\"".contains(c) { ' ' } else { c }).collect();
    bare.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

/// Where a camera of the script has a point in its format of `size` pixels: the film is moved by half widths, and a pixel
/// is as wide by its height as the format says.
fn drawn(camera: &Node, size: DVec2, point: DVec3) -> DVec2 {
    let knob = |name: &str| numbers(&camera.knobs[name]);
    let matrix = knob("matrix");
    let axis = |column: usize| DVec3::from_array([0, 1, 2].map(|row| matrix[4 * row + column]));
    let local = point - axis(3);
    let [x, y, z] = [0, 1, 2].map(|column| local.dot(axis(column)));
    let (focal, width, height) = (knob("focal")[0], knob("haperture")[0], knob("vaperture")[0]);
    let moved = knob("win_translate");
    let film = DVec2::new(x, y) / -z * focal - 0.5 * width * DVec2::new(moved[0], moved[1]);
    DVec2::new((film.x / width + 0.5) * size.x, (0.5 - film.y / height) * size.y)
}

fn photos() -> Vec<NukePhoto> {
    let mut rng = Rng::new(11);
    (0..12)
        .map(|index| {
            let (width, height) = (rng.whole(300, 4000), rng.whole(300, 4000));
            let fx = rng.between(0.5, 3.0) * f64::from(width);
            let camera = Pinhole {
                width,
                height,
                fx,
                fy: fx / rng.between(0.5, 2.0),
                cx: rng.between(-0.2, 1.2) * f64::from(width),
                cy: rng.between(-0.2, 1.2) * f64::from(height),
            };
            let rotation = DMat3::from_euler(
                glam::EulerRot::XYZ,
                rng.between(-3.0, 3.0),
                rng.between(-1.5, 1.5),
                rng.between(-3.0, 3.0),
            );
            let mut place =
                || DVec3::new(rng.between(-9.0, 9.0), rng.between(-9.0, 9.0), rng.between(-9.0, 9.0));
            let pose = Pose { rotation, translation: place() };
            let name = format!("photo {index} \"[$x]\" {{.jpg");
            let layer = |number: u32, rect: PixelRect| NukeLayer {
                token: format!("t{index}{number}"),
                name: "wall, [of] the {town}".into(),
                order: number,
                rect,
                file: format!("layers/a b/t{number}.png"),
                geometry: format!("surfaces/t{number}.obj"),
            };
            let layers = vec![
                layer(1, PixelRect { x: -30, y: 40, w: 512, h: 256 }),
                layer(0, PixelRect { x: 100, y: -7, w: 64, h: 1024 }),
            ];
            NukePhoto {
                camera: HandoverCamera { name, file: "../photos/a.jpg".into(), camera, pose },
                layers,
            }
        })
        .collect()
}

#[test]
fn every_layer_is_projected_where_its_texture_matrix_has_it() {
    let photos = photos();
    let nodes = read(&script(&photos, "a test"));
    let mut rng = Rng::new(5);
    let mut checked = 0;
    for photo in &photos {
        for layer in &photo.layers {
            let is_own = |node: &&Node| node.knobs["name"] == format!("project_{}", layer.token);
            let project = nodes.iter().filter(|node| node.class == "Project3D2").find(is_own).unwrap();
            let [picture, camera] = [0, 1].map(|input| &nodes[project.inputs[input]]);
            assert_eq!((picture.class.as_str(), camera.class.as_str()), ("Premult", "Camera2"));
            let read = &nodes[picture.inputs[0]];
            assert_eq!(value(&read.knobs["file"]).0, format!("\"{}\"", layer.file));
            let size = DVec2::new(layer.rect.w.into(), layer.rect.h.into());
            assert_eq!(numbers(&read.knobs["format"])[..2], size.to_array());
            // The film has the shape of the format with its pixels.
            let [width, height] = ["haperture", "vaperture"].map(|knob| numbers(&camera.knobs[knob])[0]);
            let pixel_aspect = numbers(&read.knobs["format"])[6];
            assert!((width / height - size.x / size.y * pixel_aspect).abs() < 1e-9);
            let rows = uv_from_world(&photo.camera.camera, &photo.camera.pose, layer.rect);
            for _ in 0..20 {
                let depth = rng.between(1.0, 40.0);
                let local = DVec3::new(rng.between(-0.5, 0.5) * depth, rng.between(-0.5, 0.5) * depth, depth);
                let point = photo.camera.pose.world_from_camera(local);
                let [u, v, q] = rows.map(|row| DVec3::new(row[0], row[1], row[2]).dot(point) + row[3]);
                let expected = DVec2::new(u / q, v / q) * size;
                let found = drawn(camera, size, point);
                assert!(found.distance(expected) < 0.01, "{found} {expected}");
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 12 * 2 * 20);
}

#[test]
fn the_chosen_photos_camera_layers_and_plate_are_drawn_and_compared() {
    let photos = photos();
    let nodes = read(&script(&photos, "a test"));
    let named =
        |name: &str| nodes.iter().find(|node| node.knobs.get("name").is_some_and(|it| it == name)).unwrap();
    for kind in ["camera", "photo", "plate"] {
        let chosen = named(&format!("choose_{kind}"));
        assert_eq!(chosen.class, "Switch");
        let names: Vec<&str> =
            chosen.inputs.iter().map(|input| nodes[*input].knobs["name"].as_str()).collect();
        let expected: Vec<String> = (0..12).map(|index| format!("{kind}_{index}")).collect();
        assert_eq!(names, expected, "input n is photo n");
    }
    let classes = |name: &str| -> Vec<&str> {
        named(name).inputs.iter().map(|input| nodes[*input].knobs["name"].as_str()).collect()
    };
    assert_eq!(classes("picture"), ["frame", "choose_photo", "choose_camera"], "background, scene, camera");
    assert_eq!(classes("difference"), ["choose_plate", "picture"]);
    let apply = named("apply_t00");
    let of_apply: Vec<&str> = apply.inputs.iter().map(|input| nodes[*input].class.as_str()).collect();
    assert_eq!(of_apply, ["ReadGeo2", "Project3D2"], "geometry, material");
    assert_eq!(nodes.iter().filter(|node| node.class == "ApplyMaterial").count(), 24);
}
