//! A first model from a folder of photos and COLMAP's result, and nothing else.

use std::fs;

use super::site::{Site, json_of, stderr_of};

/// The sample of the program: its photos, cameras and model, and the project.
fn sample() -> Site {
    let site = Site { folder: tempfile::tempdir().unwrap() };
    site.run("sample piazza -q").success();
    site
}

#[test]
fn photos_and_cameras_alone_become_a_project() {
    let site = sample();
    let inputs = "--photos piazza/photos --cameras piazza/sparse";
    let refused = site.run(&format!("new site {inputs}")).code(2);
    let text = stderr_of(&refused);
    assert!(text.contains(&format!("model suggest {inputs} --out model.obj")), "{text}");
    assert!(!site.path("site").exists());

    let found = site.json(&format!("model suggest {inputs} --out model.obj --json"));
    let objects = found["objects"].as_array().unwrap();
    let names: Vec<&str> = objects.iter().map(|object| object["name"].as_str().unwrap()).collect();
    // 810 points are few: walls of the square may be missing.
    assert!(names.contains(&"ground_1"), "{names:?}");
    let faces: u64 = objects.iter().map(|object| object["faces"].as_u64().unwrap()).sum();
    assert!((1..=150).contains(&faces), "{faces}");
    site.run(&format!("new site {inputs} --model model.obj -q")).success();
    let info = site.json("info site --json");
    assert_eq!(info["faces"].as_u64(), Some(faces), "{info:#}");

    let before = fs::read(site.path("model.obj")).unwrap();
    let again = site.run(&format!("model suggest {inputs} --out model.obj")).code(1);
    assert!(stderr_of(&again).contains("--replace"), "{}", stderr_of(&again));
    fs::write(site.path("model.obj"), [before.as_slice(), b"# mine\n"].concat()).unwrap();
    let mine = site.run(&format!("model suggest {inputs} --out model.obj --replace")).code(1);
    assert!(stderr_of(&mine).contains("was changed since"), "{}", stderr_of(&mine));
}

#[test]
fn cameras_that_say_too_little_are_refused_with_what_to_do() {
    let site = sample();
    let inputs = "--photos piazza/photos --cameras piazza/sparse --out model.obj";
    let points = site.path("piazza/sparse/points3D.txt");
    let all = fs::read_to_string(&points).unwrap();
    let five: String =
        all.lines().filter(|line| !line.starts_with('#')).take(5).map(|line| format!("{line}\n")).collect();
    fs::write(&points, five).unwrap();
    let few = stderr_of(&site.run(&format!("model suggest {inputs}")).code(1));
    assert!(
        few.contains("fewer than 30 of 5 sparse points") && few.contains("align the photos again"),
        "{few}"
    );
    fs::remove_file(&points).unwrap();
    let none = stderr_of(&site.run(&format!("model suggest {inputs}")).code(1));
    assert!(none.contains("no sparse points were read") && none.contains("points3D"), "{none}");
    assert!(!site.path("model.obj").exists());
}

#[test]
fn a_mesh_that_no_photo_sees_or_that_is_none_is_refused() {
    let site = sample();
    let suggest = |mesh: &str| {
        let inputs = "--photos piazza/photos --cameras piazza/sparse --out model.obj";
        stderr_of(&site.run(&format!("model suggest {inputs} --mesh {mesh}")).code(1))
    };
    fs::write(site.path("far.obj"), "v 9e6 0 0\nv 9e6 1 0\nv 9e6 0 1\nf 1 2 3\n").unwrap();
    let far = suggest("far.obj");
    assert!(
        far.contains("no two photos see a part of it") && far.contains("coordinates of the cameras"),
        "{far}"
    );
    let cloud = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n";
    fs::write(site.path("cloud.ply"), cloud).unwrap();
    assert!(suggest("cloud.ply").contains("a cloud of points is no mesh"));
    assert!(!site.path("model.obj").exists());
}

#[test]
fn what_the_model_explains_is_not_suggested_again() {
    let site = sample();
    let done = site.run("model suggest piazza/project --add --json");
    // Its model was made with the scene: what is left are trifles, or nothing.
    match done.get_output().status.code() {
        Some(0) => {
            let found = json_of(&done);
            let faces =
                found["objects"].as_array().unwrap().iter().map(|object| object["faces"].as_u64().unwrap());
            assert!(faces.sum::<u64>() < 8, "{found:#}");
            assert!(site.path("piazza/project/suggested.obj").is_file());
        }
        _ => assert!(stderr_of(&done).contains("the model explains all"), "{}", stderr_of(&done)),
    }
}
