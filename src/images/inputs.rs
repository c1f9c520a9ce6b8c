//! The hash of everything that the layered depth image of a stack is made of.

use std::borrow::Borrow;

use super::options::StackLdiOptions;
use quadratura_base::scene::Site;
use quadratura_base::scene::builder::SURROUNDINGS;
use quadratura_document::paint::{PaintBook, PaintEntry};
use quadratura_document::{Project, Stack};
use quadratura_files::hash::Hashing;
use quadratura_projection::relief::ReliefOptions;
use quadratura_stacks::gains;

/// A counter of changes in what is made from the same inputs.
const REVISION: u32 = 5;

/// Returns the hash of everything that the layered depth image of `stack` is made of, as 64 hexadecimal digits: the stack
/// with its filling, the photo's paint, the options, and what gains and relief are estimated from. `current` tells whether
/// the stack was made of the present model.
pub fn inputs(
    project: &Project,
    site: &Site,
    stacks: &[Option<impl Borrow<Stack>>],
    stack: &Stack,
    current: bool,
    book: &PaintBook,
    options: &StackLdiOptions,
) -> String {
    let StackLdiOptions { relief, filled, surroundings } = *options;
    let paint = book.of_photo(&stack.photo.name);
    let views: Vec<_> = paint.iter().map(|entry| book.views.get(&entry.view)).collect();
    // Paint on the surroundings of other photos tells what of this one's is far away.
    let is_around = |entry: &&PaintEntry| surroundings && entry.object == SURROUNDINGS;
    let around: Vec<_> = book.entries.iter().filter(is_around).collect();
    let parts = [
        json(&(env!("CARGO_PKG_VERSION"), REVISION, relief, filled, surroundings, current)),
        json(&project.options.tolerance),
        json(&project.colour),
        json(stack),
        json(&(paint, views)),
        json(&around),
        gains::inputs(site, stacks).into_bytes(),
        ReliefOptions::default().fingerprint().into_bytes(),
    ];
    let mut hashing = Hashing::default();
    parts.iter().for_each(|part| hashing.add(part));
    hashing.hash()
}

fn json(value: &impl serde::Serialize) -> Vec<u8> {
    serde_json::to_vec(value).expect("plain data is JSON")
}
