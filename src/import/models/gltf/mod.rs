//! Reads glTF 2.0 and GLB.
//!
//! - Every node with a mesh is an object named after the node, else after the mesh, else `node_7`; names that
//!   occur more than once are numbered (`chair`, `chair-2`). A mesh that several nodes use gives several
//!   objects, and so do the instances of `EXT_mesh_gpu_instancing`.
//! - The triangles of a mesh are joined to faces: by `extras.faceTriangleCounts` of the mesh where present,
//!   else those neighbours in a primitive that are coplanar.
//! - A billboard is marked by the name of its node, mesh or material, or by `extras.billboard: true`.
//! - Positions are converted to 64 bits before anything else; node transforms are read in 64 bits.
//! - A node that `KHR_node_visibility` hides is left out with everything below it, with a note.
//! - What a file requires and is not known is refused by name; `extensions` says which other extensions matter.
//! - Buffers are read from the file itself and from files in or below its folder, nowhere else. Skins, morph
//!   targets, points and lines are left out with a note.

mod accessor;
mod container;
mod extensions;
mod frames;
mod mesh;
mod scene;

use std::collections::BTreeSet;
use std::path::Path;

use gltf::json::Root;
use rustc_hash::FxHashMap;
use serde::de::DeserializeOwned;

use super::limits::{check_count, check_position};
use extensions::Extensions;
use mesh::{Extras, MeshPolygons};
use quadratura_base::error::Result;
use quadratura_base::scene::builder::says_billboard;
use quadratura_base::scene::{ModelBuilder, ObjectId};
use quadratura_base::task::Task;
use scene::PlacedMesh;

pub use accessor::Source;
pub use container::resource;
pub use frames::instances;
pub use mesh::surface;
pub use scene::{SceneNode, scene_nodes};

/// Reads a glTF or GLB file from its `bytes`; `path` is named in errors, and buffers are searched relative to
/// it.
///
/// # Errors
/// [`quadratura_base::Error::Input`] with line and column or with a JSON path; [`quadratura_base::Error::Io`]; [`quadratura_base::Error::Cancelled`].
pub fn read(path: &Path, bytes: &[u8], task: &Task, notes: &mut Vec<String>) -> Result<ModelBuilder> {
    let source = Source::open(path, bytes)?;
    notes.extend(container::respelled(path, &source.root.buffers));
    let mut new_notes = source.extensions.notes.clone();
    let placed = scene::placed_meshes(&source, &mut new_notes)?;
    let builder = ModelAssembly::new(&source).build(&placed, task, &mut new_notes)?;
    notes.extend(new_notes);
    Ok(builder)
}

impl<'a> Source<'a> {
    /// Reads the JSON of a glTF or GLB file and all of its buffers.
    ///
    /// # Errors
    /// As [`read`].
    pub fn open(path: &'a Path, bytes: &'a [u8]) -> Result<Self> {
        let container::Container { json, binary } = container::split(path, bytes)?;
        let version = container::check_version(path, json)?;
        container::check_counts(path, json)?;
        let root: Root = parse(path, json)?;
        let mut extensions = Extensions::read(path, json, &root)?;
        extensions.notes.extend(version);
        refuse_missing_buffers(path, &root, &extensions, binary.is_some())?;
        let buffers = container::buffers(path, &root.buffers, binary)?;
        Ok(Self { path, json, frames: parse(path, json)?, root, buffers, extensions })
    }
}

/// Parses the JSON of a glTF file.
///
/// # Errors
/// [`quadratura_base::Error::Input`] with line and column.
pub fn parse<T: DeserializeOwned>(path: &Path, json: &[u8]) -> Result<T> {
    let remedy = "check that it is a glTF 2.0 file, or export the model again";
    quadratura_files::foreign_json::parse_foreign_json(path, json, remedy)
}

/// Refuses buffers that are not in the file because what is in them is compressed elsewhere.
fn refuse_missing_buffers(path: &Path, root: &Root, extensions: &Extensions, has_binary: bool) -> Result<()> {
    let is_missing = |buffer: usize| {
        let described = root.buffers.get(buffer);
        described.is_some_and(|it| it.uri.is_none()) && !(buffer == 0 && has_binary)
    };
    let buffers = (0..root.buffers.len()).filter(|buffer| is_missing(*buffer));
    for buffer in buffers {
        extensions.refuse_compressed(path, &format!("buffers[{buffer}]"))?;
    }
    for (i, _) in root.buffer_views.iter().enumerate().filter(|(_, view)| is_missing(view.buffer.value())) {
        extensions.refuse_compressed(path, &format!("bufferViews[{i}]"))?;
    }
    Ok(())
}

/// Collects the placed meshes in a model.
struct ModelAssembly<'a> {
    source: &'a Source<'a>,
    builder: ModelBuilder,
    polygons: FxHashMap<usize, MeshPolygons>,
    /// How often each name occurred.
    asked: FxHashMap<String, u32>,
}

impl<'a> ModelAssembly<'a> {
    fn new(source: &'a Source<'a>) -> Self {
        Self {
            source,
            builder: ModelBuilder::new(),
            polygons: FxHashMap::default(),
            asked: FxHashMap::default(),
        }
    }

    fn build(
        mut self,
        placed: &[PlacedMesh],
        task: &Task,
        notes: &mut BTreeSet<String>,
    ) -> Result<ModelBuilder> {
        for (done, node_mesh) in placed.iter().enumerate() {
            task.step("read the model", done as u64, placed.len() as u64)?;
            if self.source.root.nodes[node_mesh.node].skin.is_some() {
                notes.insert("skins are left out: the shape at rest is used".to_owned());
            }
            let polygons = match self.polygons.remove(&node_mesh.mesh) {
                Some(known) => known,
                None => mesh::polygons(self.source, node_mesh.mesh, notes)?,
            };
            self.add(node_mesh, &polygons, notes)?;
            self.polygons.insert(node_mesh.mesh, polygons);
        }
        Ok(self.builder)
    }

    fn add(
        &mut self,
        node_mesh: &PlacedMesh,
        polygons: &MeshPolygons,
        notes: &mut BTreeSet<String>,
    ) -> Result<()> {
        if polygons.rings.is_empty() {
            return Ok(());
        }
        let at = || format!("nodes[{}]", node_mesh.node);
        let path = self.source.path;
        check_count(path, at, self.builder.vertices().len() + polygons.positions.len(), "vertices")?;
        let corners: usize = polygons.rings.iter().map(Vec::len).sum();
        check_count(path, at, self.builder.corner_count() + corners, "corners")?;
        let first = self.builder.vertices().len() as u32;
        for &position in &polygons.positions {
            let position = node_mesh.apply(position);
            check_position(path, at, position)?;
            self.builder.vertex(position);
        }
        let object = self.object(node_mesh, polygons, notes);
        for ring in &polygons.rings {
            let mut ring: Vec<u32> = ring.iter().map(|&v| first + v).collect();
            if node_mesh.is_mirrored() {
                ring.reverse();
            }
            self.builder.face(object, &ring);
        }
        Ok(())
    }

    fn object(
        &mut self,
        node_mesh: &PlacedMesh,
        polygons: &MeshPolygons,
        notes: &mut BTreeSet<String>,
    ) -> ObjectId {
        let node = &self.source.root.nodes[node_mesh.node];
        let mesh = &self.source.root.meshes[node_mesh.mesh];
        let given = [&node.name, &mesh.name].into_iter().flatten().find(|name| !name.is_empty());
        let name = given.cloned().unwrap_or_else(|| format!("node_{}", node_mesh.node));
        let unique = self.unique(&name);
        if unique != name {
            notes.insert("objects of the same name were numbered (as in chair, chair-2)".to_owned());
        }
        let object = self.builder.object(&unique);
        let named = mesh.name.as_deref().is_some_and(says_billboard);
        if named || polygons.billboard || Extras::from_extras(&node.extras).billboard {
            self.builder.mark_billboard(object);
        }
        object
    }

    /// Returns the name, or the name with the first number that makes it unique.
    fn unique(&mut self, name: &str) -> String {
        let count = self.asked.entry(name.to_owned()).or_default();
        loop {
            *count += 1;
            let candidate = if *count == 1 { name.to_owned() } else { format!("{name}-{count}") };
            if !self.builder.has_object(&candidate) {
                return candidate;
            }
        }
    }
}

#[cfg(test)]
mod tests;
