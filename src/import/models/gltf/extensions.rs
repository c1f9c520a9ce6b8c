//! Extensions of glTF: which matter for geometry and visibility, and what is done about each.
//!
//! A reader must refuse a file that *requires* an extension that it does not know (glTF 2.0, 3.12). Of those that a file only
//! uses, materials, lights, animations and data about the objects have no effect on polygons; anything else that is on a node,
//! mesh, primitive, accessor or buffer is told, once per file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use gltf::json::Root;
use serde::Deserialize;
use serde::de::IgnoredAny;

use quadratura_base::error::{Error, Result};

/// Extensions that compress geometry.
const COMPRESSED: [&str; 5] = [
    "KHR_draco_mesh_compression",
    "KHR_meshopt_compression",
    "EXT_meshopt_compression",
    "MESHOPT_compression",
    "KHR_gaussian_splatting_compression_spz",
];

/// Extensions that are read: integers as positions, instances, hidden nodes.
const READ: [&str; 3] = ["KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "KHR_node_visibility"];

/// Parts of the names of extensions that do not touch polygons: how they look, sound or move, and what is known about them.
const HARMLESS_PARTS: [&str; 18] = [
    "_materials_",
    "_texture_",
    "_lights_",
    "_light_",
    "_xmp",
    "_audio",
    "_animation",
    "_metadata",
    "_physics",
    "_interactivity",
    "_selectability",
    "_hoverability",
    "_instance_features",
    "_mesh_features",
    "_primitive_outline",
    "_node_name",
    "_articulations",
    "_behavior",
];

/// Other extensions that do not touch polygons.
const HARMLESS: [&str; 12] = [
    "KHR_techniques_webgl",
    "EXT_mesh_manifold",
    "EXT_mesh_primitive_edge_visibility",
    "FB_ngon_encoding",
    "KHR_implicit_shapes",
    "GODOT_single_root",
    "KHR_environment_map",
    "EXT_property_animation",
    "VRM",
    "VRMC_vrm",
    "VRMC_springBone",
    "VRMC_node_constraint",
];

/// The remedy for an extension that is not read.
const WITHOUT: &str = "export the model without it";

/// The extensions that a file uses, by the place where they are.
#[derive(Debug, Default)]
pub struct Extensions {
    /// `nodes[3]`, `meshes[0].primitives[1]`, `accessors[7]`, `bufferViews[2]`, `buffers[1]`.
    by_place: BTreeMap<String, Vec<String>>,
    /// What the user should know about the file, once each.
    pub notes: BTreeSet<String>,
}

/// A part of a file that may have extensions.
#[derive(Deserialize)]
struct Extensible {
    #[serde(default)]
    extensions: Option<BTreeMap<String, IgnoredAny>>,
    #[serde(default)]
    primitives: Vec<Extensible>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Parts {
    #[serde(default)]
    extensions: Option<BTreeMap<String, IgnoredAny>>,
    #[serde(default)]
    nodes: Vec<Extensible>,
    #[serde(default)]
    meshes: Vec<Extensible>,
    #[serde(default)]
    scenes: Vec<Extensible>,
    #[serde(default)]
    accessors: Vec<Extensible>,
    #[serde(default)]
    buffers: Vec<Extensible>,
    #[serde(default)]
    buffer_views: Vec<Extensible>,
}

impl Extensions {
    /// Reads which extensions a file uses.
    ///
    /// # Errors
    /// [`Error::Input`] where it requires one that is not read, is compressed, or is moved by one.
    pub fn read(path: &Path, json: &[u8], root: &Root) -> Result<Self> {
        for name in &root.extensions_required {
            if COMPRESSED.contains(&name.as_str()) {
                return Err(compressed(path, "extensionsRequired", name));
            }
            if !READ.contains(&name.as_str()) && !is_harmless(name) {
                let found = format!("the file needs the extension {name}, which is not read");
                return Err(Error::input(path, "extensionsRequired", found, WITHOUT));
            }
        }
        let parts: Parts = super::parse(path, json)?;
        let mut read = Self::default();
        read.add("the file", parts.extensions.as_ref());
        let lists = [
            ("nodes", &parts.nodes),
            ("meshes", &parts.meshes),
            ("scenes", &parts.scenes),
            ("accessors", &parts.accessors),
            ("buffers", &parts.buffers),
            ("bufferViews", &parts.buffer_views),
        ];
        for (list, parts) in lists {
            for (at, part) in parts.iter().enumerate() {
                read.add(&format!("{list}[{at}]"), part.extensions.as_ref());
                for (i, primitive) in part.primitives.iter().enumerate() {
                    read.add(&format!("{list}[{at}].primitives[{i}]"), primitive.extensions.as_ref());
                }
            }
        }
        if read.on("the file").any(|name| name == "CESIUM_RTC") {
            let found = "the whole model is moved by the extension CESIUM_RTC, which is not read";
            return Err(Error::input(path, "extensions.CESIUM_RTC", found, WITHOUT));
        }
        read.tell();
        Ok(read)
    }

    fn add(&mut self, place: &str, extensions: Option<&BTreeMap<String, IgnoredAny>>) {
        if let Some(extensions) = extensions.filter(|extensions| !extensions.is_empty()) {
            self.by_place.insert(place.to_owned(), extensions.keys().cloned().collect());
        }
    }

    /// Returns the extensions at a place.
    pub fn on(&self, place: &str) -> impl Iterator<Item = &str> {
        self.by_place.get(place).into_iter().flatten().map(String::as_str)
    }

    /// Refuses what has no values in the file but those that an extension compresses.
    ///
    /// # Errors
    /// [`Error::Input`] with the name of the extension.
    pub fn refuse_compressed(&self, path: &Path, place: &str) -> Result<()> {
        let name = self.on(place).find(|name| COMPRESSED.contains(name));
        name.map_or(Ok(()), |name| Err(compressed(path, place, name)))
    }

    /// Notes the extensions that change what is seen and are not read, each with the first place and the number of others.
    fn tell(&mut self) {
        let mut unread: BTreeMap<&str, (&str, usize)> = BTreeMap::new();
        for (place, names) in &self.by_place {
            for name in names {
                // What is compressed is read from its uncompressed copy, or refused where there is none.
                let is_known = [&READ[..], &COMPRESSED].iter().any(|known| known.contains(&name.as_str()));
                if !is_known && !is_harmless(name) {
                    unread.entry(name).or_insert((place, 0)).1 += 1;
                }
            }
        }
        let note = |(name, (place, count)): (&str, (&str, usize))| {
            let others = if count > 1 { format!(" and {} more places", count - 1) } else { String::new() };
            match name {
                "MSFT_lod" => {
                    format!("{place}{others}: of the levels of detail of {name}, the finest is read")
                }
                name => format!(
                    "the extension {name} has no effect, although it may change what is seen ({place}{others})"
                ),
            }
        };
        let notes: Vec<String> = unread.into_iter().map(note).collect();
        self.notes.extend(notes);
    }
}

fn is_harmless(name: &str) -> bool {
    HARMLESS.contains(&name) || HARMLESS_PARTS.iter().any(|part| name.contains(part))
}

fn compressed(path: &Path, place: &str, name: &str) -> Error {
    let found = format!("the geometry is compressed ({name}), which is not read");
    Error::input(path, place, found, "export the model without compression")
}
