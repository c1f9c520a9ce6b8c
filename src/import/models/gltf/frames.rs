//! What the package does not read of nodes: transforms in 64 bits, and instances.

use glam::{DAffine3, DMat4, DQuat, DVec3};
use gltf::json::accessor::ComponentType;
use serde::Deserialize;

use super::accessor::Source;
use quadratura_base::error::Result;

/// The largest number of instances of all nodes together.
pub const MOST_INSTANCES: usize = 1_000_000;

/// The nodes' transforms in 64 bits (the package reads them in 32, which shifts a site in map coordinates by half a
/// metre), and the accessors of their instances.
#[derive(Deserialize)]
pub struct NodeFrames {
    /// One for each node.
    #[serde(default)]
    pub nodes: Vec<Frame>,
}

/// The transform of a node, and its instances.
#[derive(Deserialize)]
pub struct Frame {
    #[serde(default)]
    matrix: Option<[f64; 16]>,
    #[serde(default = "zeros")]
    translation: [f64; 3],
    #[serde(default = "unturned")]
    rotation: [f64; 4],
    #[serde(default = "ones")]
    scale: [f64; 3],
    #[serde(default)]
    extensions: Option<NodeExtensions>,
}

#[derive(Deserialize)]
struct NodeExtensions {
    #[serde(default, rename = "EXT_mesh_gpu_instancing")]
    instancing: Option<Instancing>,
    #[serde(default, rename = "KHR_node_visibility")]
    visibility: Option<NodeVisibility>,
    #[serde(default, rename = "MSFT_lod")]
    levels: Option<LodNodes>,
}

/// `KHR_node_visibility`: a node that is not visible hides everything below it.
#[derive(Deserialize)]
struct NodeVisibility {
    #[serde(default = "yes")]
    visible: bool,
}

fn yes() -> bool {
    true
}

/// `MSFT_lod`: other nodes that stand for a node seen from far away.
#[derive(Deserialize)]
struct LodNodes {
    #[serde(default)]
    ids: Vec<usize>,
}

#[derive(Deserialize)]
struct Instancing {
    attributes: Attributes,
}

/// The accessors of instances' transforms. Other attributes, such as numbers of instances, say nothing about where they
/// are.
#[derive(Deserialize)]
#[serde(rename_all = "UPPERCASE")]
struct Attributes {
    #[serde(default)]
    translation: Option<usize>,
    #[serde(default)]
    rotation: Option<usize>,
    #[serde(default)]
    scale: Option<usize>,
}

fn zeros() -> [f64; 3] {
    [0.0; 3]
}

fn ones() -> [f64; 3] {
    [1.0; 3]
}

fn unturned() -> [f64; 4] {
    DQuat::IDENTITY.to_array()
}

impl Frame {
    /// Returns whether the node and everything below it is hidden.
    pub fn is_hidden(&self) -> bool {
        let visibility = self.extensions.as_ref().and_then(|known| known.visibility.as_ref());
        visibility.is_some_and(|visibility| !visibility.visible)
    }

    /// Returns the nodes that stand for this one, seen from far away.
    pub fn coarser_levels(&self) -> &[usize] {
        let levels = self.extensions.as_ref().and_then(|known| known.levels.as_ref());
        levels.map_or(&[], |levels| &levels.ids)
    }

    /// Returns the map from the node's frame to its parent's.
    pub fn parent_from_node(&self) -> DMat4 {
        let from_parts = || {
            let rotation = DQuat::from_array(self.rotation).normalize();
            DMat4::from_scale_rotation_translation(self.scale.into(), rotation, self.translation.into())
        };
        self.matrix.as_ref().map_or_else(from_parts, DMat4::from_cols_array)
    }
}

/// Returns the maps from the mesh of a node to the node's frame, one for each instance: T * R * S of the accessors of
/// `EXT_mesh_gpu_instancing`. `None` for nodes that have their mesh once, as most do; so do those whose instances have
/// no place of their own.
///
/// # Errors
/// [`quadratura_base::Error::Input`] with the JSON path, where accessors cannot be read, differ in their counts, are too long or
/// give a transform that is not finite.
pub fn instances(source: &Source, node: usize) -> Result<Option<Vec<DAffine3>>> {
    let extensions = source.frames.nodes.get(node).and_then(|frame| frame.extensions.as_ref());
    let Some(Instancing { attributes }) = extensions.and_then(|known| known.instancing.as_ref()) else {
        return Ok(None);
    };
    let Some(count) = instance_count(source, node, attributes)? else { return Ok(None) };
    let floats = |component, _| component == ComponentType::F32;
    let places = |accessor: Option<usize>, what: &str, usual: [f64; 3]| match accessor {
        Some(accessor) => {
            source.vectors(accessor, &format!("{what} of instances that are not VEC3 of floats"), floats)
        }
        None => Ok(vec![usual; count]),
    };
    let translations = places(attributes.translation, "translations", zeros())?;
    let scales = places(attributes.scale, "scales", ones())?;
    let rotations = match attributes.rotation {
        Some(accessor) => {
            source.vectors(accessor, UNLIKE_ROTATIONS, |component, normalized| match component {
                ComponentType::F32 => true,
                ComponentType::I8 | ComponentType::I16 => normalized,
                _ => false,
            })?
        }
        None => vec![unturned(); count],
    };
    let map = |i: usize| {
        let rotation = DQuat::from_array(rotations[i]).normalize();
        let map = DAffine3::from_scale_rotation_translation(
            DVec3::from_array(scales[i]),
            rotation,
            DVec3::from_array(translations[i]),
        );
        let found = || format!("the transform of instance {i} is not finite");
        if map.is_finite() { Ok(map) } else { Err(source.error(&place_of(node), found())) }
    };
    (0..count).map(map).collect::<Result<_>>().map(Some)
}

const UNLIKE_ROTATIONS: &str =
    "rotations of instances that are not VEC4 of floats or of normalised signed integers of 8 or 16 bits";

fn place_of(node: usize) -> String {
    format!("nodes[{node}].extensions.EXT_mesh_gpu_instancing")
}

/// Returns the number of instances, which all accessors have in common; `None` without accessors.
fn instance_count(source: &Source, node: usize, attributes: &Attributes) -> Result<Option<usize>> {
    let Attributes { translation, rotation, scale } = attributes;
    let mut common: Option<u64> = None;
    for (name, accessor) in [("TRANSLATION", translation), ("ROTATION", rotation), ("SCALE", scale)] {
        let Some(accessor) = *accessor else { continue };
        let count = source.accessor(accessor)?.count.0;
        let expected = *common.get_or_insert(count);
        if count != expected {
            let found = format!("{count} elements of {name}, but {expected} of the attributes before it");
            return Err(source.error(&place_of(node), found));
        }
    }
    match common {
        Some(count) if count > MOST_INSTANCES as u64 => {
            let found = format!("{count} instances; at most {MOST_INSTANCES} are read");
            Err(source.error(&place_of(node), found))
        }
        count => Ok(count.map(|count| count as usize)),
    }
}
