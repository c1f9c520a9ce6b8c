//! Reads plants of Rayshade 4 (Kolb 1991): named objects, lists and primitives, with their transforms and surfaces.
//!
//! A file is words after the C preprocessor ([`source`]); statements make objects of them ([`statements`]), and objects
//! become sub-objects, one for each surface that they are placed with ([`graph`]).

mod directives;
mod expressions;
mod graph;
mod keywords;
mod lexing;
mod objects;
mod shapes;
mod source;
mod statements;
mod surfaces;
mod textures;
mod transforms;
mod words;

#[cfg(test)]
mod tests;

use std::path::Path;

use glam::DVec3;

use self::graph::drafts;
use self::source::Source;
use self::statements::Statements;
use self::words::Words;
use super::pictures::Folder;
use super::remedies::Wrong;
use crate::{Plant, assemble};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;

/// Reads the plant of a Rayshade file with all that it includes: z is up, and the unit is a metre. What is left out is
/// noted.
///
/// # Errors
/// [`Error::Input`] with file and line; [`Error::Io`]; [`Error::Cancelled`].
pub fn read_rayshade(path: &Path, task: &Task) -> Result<Plant> {
    let mut folder = Folder::of(path)?;
    let source = Source::open(path, &mut folder)?;
    let mut statements = Statements::new(Words::new(source), task);
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let root = statements.read(name)?;
    let Statements { mut objects, mut surfaces, notes, .. } = statements;
    folder.notes().iter().for_each(|note| task.note(note));
    objects.push(root);
    let (drafts, root) = drafts(path, objects, &mut surfaces)?;
    notes.texts().into_iter().for_each(|text| task.note(text));
    assemble(drafts, root, DVec3::Z, 1.0).map_err(|flaw| {
        let Wrong { found, remedy } = Wrong::from(&flaw);
        Error::input(path, "", found, remedy)
    })
}
