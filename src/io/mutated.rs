//! Mutations of text files, for tests that reading them gives a result or an error, and never a fault.
//!
//! `QUADRATURA_MUTATIONS=1000000 cargo test --release -p quadratura-io --lib mutated` reads as many of each format.

#![cfg(test)]

use std::path::Path;

use super::camera_path::read_camera_path;
use super::depth_image::read_list;
use super::photo_list::read_photo_list;
use super::tree_list::read_tree_list;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::synthetic::Rng;
use quadratura_base::task::Task;

/// Returns the number of mutations: `usual`, or what the environment says.
pub fn mutations(usual: u32) -> u32 {
    std::env::var("QUADRATURA_MUTATIONS").ok().and_then(|count| count.parse().ok()).unwrap_or(usual)
}

/// Returns a text after one to four changes: bytes, cuts, repeats, splices, exchanged words, numbers, and these words.
pub fn mutated(text: &str, words: &[&str], rng: &mut Rng) -> Vec<u8> {
    const NUMBERS: [&str; 9] = ["nan", "inf", "1e999", "-1", "99999999999", "0", "1e-320", "1e15", "-0.5"];
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..rng.whole(1, 4) {
        let place = |rng: &mut Rng, bytes: &[u8]| rng.whole(0, bytes.len() as u32 - 1) as usize;
        let at = place(rng, &bytes);
        let end = (at + rng.whole(0, 30) as usize).min(bytes.len());
        match rng.whole(0, 7) {
            0 => bytes[at] = rng.bits() as u8,
            1 => drop(bytes.drain(at..end)),
            2 => drop(bytes.splice(at..at, bytes[at..end].to_vec())),
            3 if rng.chance(0.3) => bytes.truncate(at.max(1)),
            4 => bytes[at] = b"0123456789.-+eE \n{}#()^*/"[rng.whole(0, 24) as usize],
            5 => {
                let other = place(rng, &bytes);
                let piece = bytes[at..end].to_vec();
                drop(bytes.splice(other..other, piece));
            }
            6 => exchange(&mut bytes, at, end),
            which => {
                let words = if which == 3 { &NUMBERS } else { words };
                let word = words[rng.whole(0, words.len() as u32 - 1) as usize];
                let from = bytes[..at].iter().rposition(u8::is_ascii_whitespace).map_or(0, |i| i + 1);
                let to = if which == 3 { end_of_word(&bytes, from) } else { from };
                drop(bytes.splice(from..to, format!("{word} ").into_bytes()));
            }
        }
        if bytes.is_empty() {
            bytes.push(b' ');
        }
    }
    bytes
}

fn end_of_word(bytes: &[u8], from: usize) -> usize {
    bytes[from..].iter().position(u8::is_ascii_whitespace).map_or(bytes.len(), |length| from + length)
}

/// Exchanges the first two words between two places.
fn exchange(bytes: &mut Vec<u8>, at: usize, end: usize) {
    let part = String::from_utf8_lossy(&bytes[at..end]).into_owned();
    let mut words: Vec<&str> = part.split(' ').collect();
    if words.len() > 1 {
        words.swap(0, 1);
    }
    drop(bytes.splice(at..end, words.join(" ").into_bytes()));
}

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
