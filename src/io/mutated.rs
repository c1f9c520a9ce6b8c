//! Mutated lists and paths give a result or an error, and never a fault.

#![cfg(test)]

use std::path::Path;

use crate::camera_path::read_camera_path;
use crate::depth_image::read_list;
use crate::mutations::{mutated, mutations};
use crate::photo_list::read_photo_list;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::synthetic::Rng;
use quadratura_base::task::Task;
use quadratura_foliage::files::list::read_tree_list;

/// Reads mutations of a text. Errors say what to do.
fn check(text: &str, words: &[&str], read: impl Fn(&Path) -> Result<()>) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    let read_as = |text: &[u8]| {
        std::fs::write(&file, text).unwrap();
        read(&file)
    };
    read_as(text.as_bytes()).unwrap();
    let mut rng = Rng::new(91);
    for case in 0..mutations(400) {
        let text = mutated(text, words, &mut rng);
        if let Err(Error::Input { remedy, .. }) = read_as(&text) {
            assert!(!remedy.to_string().is_empty(), "case {case}: {}", String::from_utf8_lossy(&text));
        }
    }
}

#[test]
fn mutated_lists_and_paths_give_a_result_or_an_error_and_never_a_fault() {
    check("# north\na b.jpg\r\nc#1.jpg\n", &["#", "\u{feff}", "\r"], |file| read_photo_list(file).map(drop));
    let trees = "name,species,x,y,height,crown,casts\r\nold,oak,1.5,-2,6,4,yes\r\n\"a, b\",,3,4,,,no\r\n";
    check(trees, &[",", ";", "\"", "nan", "\r"], |file| read_tree_list(file).map(drop));
    let path = r#"{"version": 1, "size": [96, 54], "fps": 10, "keyframes": [
        {"t": 0, "position": [0, NaN, 2], "look_at": [0, 0, 3], "fov": 55},
        {"t": 1, "position": [0, -8, 2], "look_at": [0, 0, 3], "fov": 55},
        {"t": 3, "position": [6, -6, 2], "rotation": [1, 0, 0, 0], "K": [[50, 0, 48], [0, 50, 27], [0, 0, 1]]}]}"#;
    let words = ["NaN", "-Infinity", "nan(ind)", "-1.#IND", "{", "}", "[", "]", ",", "null", "\""];
    check(path, &words, |file| read_camera_path(file, glam::DVec3::Z).map(drop));
    let list = r#"{"version": 1, "images": [{"colour": "a.png", "depth": "a.pfm", "kind": "axis", "background": Infinity,
        "camera": {"K": [[9, 0, 4], [0, 9, 3], [0, 0, 1]], "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [0, NaN, 0]}}]}"#;
    check(list, &words, |file| read_list(file, &Task::silent()).map(drop));
}
