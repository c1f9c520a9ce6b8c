//! Billboards that turn, on the tiny site, where y points down.

use std::fs;

use serde_json::Value;

use super::common::adapter;
use super::site::{Site, stderr_of, stdout_of};

/// The site with a tree of two crossing rectangles in front of the wall, and a carpet on the floor.
fn with_billboards() -> Site {
    let site = Site::new();
    let mut model = fs::read_to_string(site.path("model.obj")).unwrap();
    let mut first = 1 + model.lines().filter(|line| line.starts_with("v ")).count();
    let mut face = |name: &str, corners: [[f64; 3]; 4]| {
        model.push_str(&format!("o {name}\n"));
        corners.iter().for_each(|[x, y, z]| model.push_str(&format!("v {x} {y} {z}\n")));
        model.push_str(&format!("f {} {} {} {}\n", first, first + 1, first + 2, first + 3));
        first += 4;
    };
    face("tree.billboard", [[2.0, -1.0, 9.0], [2.0, 2.0, 9.0], [4.0, 2.0, 9.0], [4.0, -1.0, 9.0]]);
    face("tree.billboard", [[3.0, -1.0, 8.0], [3.0, 2.0, 8.0], [3.0, 2.0, 10.0], [3.0, -1.0, 10.0]]);
    face("carpet.billboard", [[-3.0, 1.9, 7.0], [-3.0, 1.9, 8.0], [-2.0, 1.9, 8.0], [-2.0, 1.9, 7.0]]);
    fs::write(site.path("model.obj"), model).unwrap();
    site.make_project();
    site
}

/// The elements of an object in the stack of the first photo, and its surfaces.
fn tree_of(site: &Site) -> (Vec<Value>, Vec<Value>) {
    let text = fs::read(site.path("project/stacks/left.png/stack.json")).unwrap();
    let stack: Value = serde_json::from_slice(&text).unwrap();
    let is_tree = |it: &&Value| it["object"] == "tree.billboard";
    let layers = stack["visibility_layers"].as_array().unwrap().iter();
    let elements = layers.flat_map(|layer| layer.as_array().unwrap()).filter(is_tree).cloned().collect();
    (elements, stack["surfaces"].as_array().unwrap().iter().filter(is_tree).cloned().collect())
}

#[test]
fn a_billboard_turns_towards_each_photo_until_somebody_decides_otherwise() {
    if adapter().is_none() {
        return;
    }
    let site = with_billboards();
    let built = site.run("build project --stacks-only").success();
    let told = stderr_of(&built);
    assert!(told.contains("carpet.billboard cannot turn") && told.contains("lies on the ground"), "{told}");
    let (elements, surfaces) = tree_of(&site);
    assert_eq!(elements.len(), 1, "one rectangle instead of two that cross");
    assert_eq!(
        (&elements[0]["impostor"], &elements[0]["faces"]),
        (&Value::Bool(true), &serde_json::json!([0]))
    );
    // The photo's camera stands at the origin: the rectangle through the trunk is across the way to it.
    let corners: Vec<[f64; 3]> = serde_json::from_value(surfaces[0]["outline"].clone()).unwrap();
    for [x, y, z] in &corners {
        let off = (x - 3.0) * 3.0 + (z - 9.0) * 9.0;
        assert!(off.abs() < 1e-9 && (*y == -1.0 || *y == 2.0), "{corners:?}");
        assert!(((x - 3.0).hypot(z - 9.0) - 1.0).abs() < 1e-9, "{corners:?}");
    }
    // Its other face is told to be in the same layer.
    let info = site.json("info project --face tree.billboard[1] --json");
    assert_eq!(info["photos"][0]["textured"], true, "{info}");
    let listed = site.json("object project --json");
    let turns = |name: &str| {
        let objects = listed["objects"].as_array().unwrap().iter();
        objects.clone().find(|it| it["object"] == name).unwrap()["turns"].clone()
    };
    assert_eq!((turns("tree.billboard"), turns("wall")), (true.into(), false.into()));
    // What cannot turn is named for what it is.
    assert_eq!(turns("carpet.billboard"), Value::Bool(false));
    let list = stdout_of(&site.run("object project").success());
    assert!(list.contains("billboard, cannot turn: it has no height: it lies on the ground"), "{list}");
    let carpet = site.json("info project --face carpet.billboard --json");
    assert_eq!(carpet["turns"], false, "{carpet}");
    assert_eq!(carpet["cannot_turn"], "it has no height: it lies on the ground");
    let info = site.json("info project --json");
    assert_eq!(info["cannot_turn"], serde_json::json!({ "carpet.billboard": carpet["cannot_turn"] }));
    let said = stdout_of(&site.run("info project").success());
    assert!(said.contains("carpet.billboard cannot turn towards cameras: it has no height"), "{said}");

    let decided = stdout_of(&site.run("decide project --no-impostor tree*").success());
    assert!(decided.contains("tree.billboard stays as it is modelled"), "{decided}");
    assert!(decided.contains("quadratura update"), "{decided}");
    site.run("build project --stacks-only").success();
    let (elements, surfaces) = tree_of(&site);
    assert!(elements.iter().all(|element| element["impostor"].is_null()), "{elements:?}");
    assert_eq!(surfaces.len(), 2, "as it is modelled");

    // The name turns it again, so that nothing is left of the decision.
    site.run("decide project --impostor tree.billboard").success();
    let project = fs::read_to_string(site.path("project/project.json")).unwrap();
    assert!(!project.contains("impostors"), "{project}");
    let refused = stderr_of(&site.run("decide project --impostor shrub --no-impostor fern").failure());
    assert!(refused.contains("shrub") && refused.contains("fern"), "{refused}");
}

/// The files of the mattes and their bytes.
fn matte_files(site: &Site) -> Vec<(String, Vec<u8>)> {
    let files = fs::read_dir(site.path("project/cache/mattes")).unwrap().map(|file| file.unwrap().path());
    let mut files: Vec<(String, Vec<u8>)> =
        files.map(|file| (file.display().to_string(), fs::read(&file).unwrap())).collect();
    files.sort();
    files
}

#[test]
fn mattes_are_found_once_and_again_with_the_same_bytes_and_a_damaged_file_is_made_again() {
    if adapter().is_none() {
        return;
    }
    let site = with_billboards();
    let told = stderr_of(&site.run("matte project"));
    assert!(told.contains("no photo has a stack yet"), "{told}");
    site.run("build project --stacks-only").success();
    let found = site.json("matte project --json");
    assert_eq!(found["anew"], true, "{found}");
    let mattes = found["mattes"].as_array().unwrap();
    assert!(!mattes.is_empty());
    for matte in mattes {
        assert_eq!(matte["object"], "tree.billboard", "the carpet does not turn");
        let count = |name: &str| matte[name].as_u64().unwrap();
        let parts = ["solid", "see_through", "fractional", "unknown"].map(count);
        assert_eq!(parts.iter().sum::<u64>(), count("pixels"), "{matte}");
        assert!(count("pixels") > 0, "{matte}");
    }
    let files = matte_files(&site);
    let again = site.json("matte project --json");
    assert_eq!((&again["anew"], &again["mattes"]), (&Value::Bool(false), &found["mattes"]));
    let forced = site.json("matte project --force --threads 1 --json");
    assert_eq!((&forced["anew"], &forced["mattes"]), (&Value::Bool(true), &found["mattes"]));
    assert_eq!(matte_files(&site), files, "the same bytes, on any number of threads");
    fs::write(&files[0].0, &files[0].1[..files[0].1.len() / 2]).unwrap();
    assert_eq!(site.json("matte project --json")["anew"], true);
    assert_eq!(matte_files(&site), files);
    let unknown = stderr_of(&site.run("matte project --object wall"));
    assert!(unknown.contains("no object named \u{201c}wall\u{201d} is see-through; "), "{unknown}");
}
