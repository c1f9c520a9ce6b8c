//! Reads plants of glTF 2.0 and GLB, with the reading that models have: nodes are sub-objects, and their children uses.
//!
//! A node has one parent in glTF, so that repetition is written out. It is found again: nodes with the same mesh and the
//! same children become one sub-object ([`graph`]). `EXT_mesh_gpu_instancing` gives one use an instance.

mod graph;
mod materials;
mod meshes;
mod pictures;

#[cfg(test)]
mod tests;

use std::fs;
use std::path::Path;

use glam::DVec3;

use self::graph::Graph;
use self::meshes::MeshReader;
use super::notes::Notes;
use super::remedies::Wrong;
use crate::{Plant, assemble};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_import::models::check_file_size;
use quadratura_import::models::gltf::{Source, scene_nodes};

/// Reads the plant of a glTF or GLB file: y is up, and the unit is a metre. What is left out is noted.
///
/// # Errors
/// [`Error::Input`] with line and column or with a JSON path; [`Error::Io`]; [`Error::Cancelled`].
pub fn read_gltf(path: &Path, task: &Task) -> Result<Plant> {
    let size = fs::metadata(path).map_err(Error::io(path, "read it"))?.len();
    check_file_size(path, size)?;
    let bytes = fs::read(path).map_err(Error::io(path, "read it"))?;
    plant_of(path, &bytes, task)
}

/// Makes the plant of the bytes of a file; buffers and pictures beside it are searched relative to `path`.
fn plant_of(path: &Path, bytes: &[u8], task: &Task) -> Result<Plant> {
    let source = Source::open(path, bytes)?;
    let mut file_notes = source.extensions.notes.clone();
    let nodes = scene_nodes(&source, &mut file_notes)?;
    file_notes.into_iter().for_each(|note| task.note(note));
    let mut notes = Notes::default();
    if source.root.extensions_used.iter().any(|name| name == "KHR_texture_transform") {
        notes.add("KHR_texture_transform has no effect", || "extensionsUsed".to_owned());
    }
    let graph = Graph::new(MeshReader::new(&source)?);
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (drafts, root) = graph.build(&nodes, name, &mut notes, task)?;
    notes.texts().into_iter().for_each(|text| task.note(text));
    assemble(drafts, root, DVec3::Y, 1.0).map_err(|flaw| {
        let Wrong { found, remedy } = Wrong::from(&flaw);
        Error::input(path, "", found, remedy)
    })
}
