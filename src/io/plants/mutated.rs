//! Mutated files of each text format give a plant or an error, and never a fault.
//!
//! `QUADRATURA_MUTATIONS=1000000 cargo test --release --lib mutated_files_of` reads as many of each format.

#![cfg(test)]

use std::fs;

use super::tests::{Files, TRIANGLE};
use super::*;
use crate::scene::synthetic::Rng;

/// Returns a text after one to four changes: bytes, cuts, repeats, splices, exchanged words, numbers, and these words.
fn mutated(text: &str, words: &[&str], rng: &mut Rng) -> Vec<u8> {
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

/// Reads mutations of a text as a file of this name. Some must be plants, and some not.
fn check(name: &str, text: &str, words: &[&str], usual: u32) {
    let count = std::env::var("QUADRATURA_MUTATIONS").ok().and_then(|count| count.parse().ok());
    let count: u32 = count.unwrap_or(usual);
    let files =
        Files::new(&[("leaf.plant", TRIANGLE), ("leaf.ray", "name leaf triangle 0 0 0 1 0 0 0 1 0\n")]);
    fs::write(files.path(name), text).unwrap();
    files.read(name).unwrap();
    let mut rng = Rng::new(77);
    let mut read = 0;
    for case in 0..count {
        let text = mutated(text, words, &mut rng);
        fs::write(files.path(name), &text).unwrap();
        match files.read(name) {
            Ok(plant) => {
                read += 1;
                assert!(plant.whole().bounds.ball.radius.is_finite(), "case {case}");
            }
            Err(Error::Input { remedy, .. }) => assert!(!remedy.to_string().is_empty()),
            Err(other) => panic!("case {case}: {other}: {}", String::from_utf8_lossy(&text)),
        }
    }
    assert!((count / 100..count / 100 * 99).contains(&read), "some are plants and some are not: {read}");
}

#[test]
fn mutated_files_of_keywords_give_a_plant_or_an_error_and_never_a_fault() {
    let text = format!(
        "# a branch\nunit 0.5 up 0 1 0\nmaterial bark reflected .2 .1 .1\ntube 6 4\n\
         limb 7  0 0 0 .3  0 0 1 .2  0 .1 2 .2  0 .3 3 .1  0 .4 4 .1  0 .5 5 .05  0 1 6 0\n\
         {{ transform 1 0 0 0  0 .5 .5 0  0 -.5 .5 0  0 0 2 1\n  use leaf\n  {{ use leaf.plant }}\n}}\n\
         material leaf through .1 .5 .1 leaf\n{TRIANGLE}use leaf.box\nuse leaf\n"
    );
    let words =
        ["{", "}", "use tree", "use leaf", "transform", "polygon 3", "limb 4", "tube 3 1", "material x", "#"];
    check("tree.plant", &text, &words, 8000);
}

#[test]
fn mutated_files_of_rayshade_give_a_plant_or_an_error_and_never_a_fault() {
    let text = "/* a tree */\n#define TALL 3\n#include \"leaf.ray\"\n#ifndef NEVER\ndefine angle 30\n#endif\n\
                eyep 0 -9 4\nlight 1 point 0 0 9\nsurface bark diffuse .3 .2 .1 specular 0 0 0\n\
                surface leaf diffuse .1 .4 .1 translu .5 .2 1 .2 3\n\
                name twig grid 3 3 3\n\tcylinder bark .1 0 0 0 0 0 1\n\tdisc .1 0 0 1 0 0 1\n\
                \tobject leaf rotate 0 1 0 (angle * dtor + 2 ^ 3) translate 0 0 1\nend\n\
                name tree list\n\tapplysurf leaf\n\tcone bark .3 0 0 0 .1 0 0 TALL\n\tsphere 1 0 0 TALL\n\
                \tobject twig scale 2 2 2 rotate 0 0 1 (hypot(3, 4) * 10)\n\tobject leaf twig transform 1 0 0 0 1 0 0 0 1 0 0 2\n\
                \tpoly 0 0 0 1 0 0 1 1 0 0 1 0\n\tbox -1 -1 -1 1 1 0 texture checker bark scale 2 2 2\n\
                \tlist triangleuv 0 0 0 0 0 1 0 0 1 0 0 0 0 1 1 0 0 1 0 0 0 1 0 1 end\nend\n\
                plane 0 0 0 0 0 1\nobject tree\nobject tree translate 5 0 0\n";
    let words = [
        "list",
        "end",
        "name tree",
        "object tree",
        "object twig",
        "(",
        ")",
        "/*",
        "*/",
        "\n#define TALL TALL TALL\n",
        "\n#define end TALL end\n",
        "\n#include \"tree.ray\"\n",
        "\n#ifdef TALL\n",
        "\n#else\n",
        "\n#endif\n",
        "surface",
        "applysurf",
        "cursurf",
        "texture image leaf.ray map uv",
        "union",
        "difference",
        "rotate",
        "scale 0 0 0",
        "diffuse",
        "translu",
        "triangle",
        "(1 / 0)",
        "sphere",
        "blob",
        "define angle",
        "sqrt (-1)",
    ];
    check("tree.ray", text, &words, 8000);
}

#[test]
fn mutated_species_give_a_plant_or_an_error_and_never_a_fault() {
    let text = include_str!("../../../examples/oak.json");
    let words =
        ["{", "}", "[", "]", ",", "\"count\": 9,", "\"levels\": [", "null", "true", "\"seed\": 3,", ":"];
    check("tree.json", text, &words, 4000);
}
