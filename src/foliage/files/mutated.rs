//! Mutated files of each text format give a plant or an error, and never a fault.
//!
//! `QUADRATURA_MUTATIONS=1000000 cargo test --release -p quadratura-foliage --lib mutated_files_of` reads as many of each format.

#![cfg(test)]

use std::fs;

use super::tests::{Files, TRIANGLE};
use super::*;
use crate::mutations::{mutated, mutations};
use quadratura_base::scene::synthetic::Rng;

/// Reads mutations of a text as a file of this name. Some must be plants, and some not.
fn check(name: &str, text: &str, words: &[&str], usual: u32) {
    let count = mutations(usual);
    let files = Files::new(&[("leaf.plant", TRIANGLE)]);
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
fn mutated_species_give_a_plant_or_an_error_and_never_a_fault() {
    let text = include_str!("../../../examples/oak.json");
    let words =
        ["{", "}", "[", "]", ",", "\"count\": 9,", "\"levels\": [", "null", "true", "\"seed\": 3,", ":"];
    check("tree.json", text, &words, 4000);
}
