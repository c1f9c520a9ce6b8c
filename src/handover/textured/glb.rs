//! glTF 2.0 as one binary file: for viewers, engines and museum pages.
//!
//! A root node turns the model's up direction to +y and names the local origin in its `extras`. Below it is one node with one mesh per object;
//! `extras.faceTriangleCounts` tells which triangles are one polygon. Materials are unlit, because photos contain their light.

use glam::{DMat3, DQuat, DVec3};
use serde_json::{Value, json};

use super::{Shared, TexturedModel, TexturedObject, WrittenFile};
use crate::textured::PageKind;

/// The first bytes of a binary glTF file.
const MAGIC: &[u8] = b"glTF";
const VERSION: u32 = 2;
const JSON_CHUNK: &[u8] = b"JSON";
const BINARY_CHUNK: &[u8] = b"BIN\0";

/// The values of glTF's constants, as OpenGL has them.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const CLAMP_TO_EDGE: u32 = 33071;
const LINEAR: u32 = 9729;
const LINEAR_MIPMAP_LINEAR: u32 = 9987;

/// Writes a model as one file with its textures.
pub fn glb(model: &TexturedModel, generator: &str) -> WrittenFile {
    let mut buffer = Buffer::default();
    let objects: Vec<&TexturedObject> =
        model.objects.iter().filter(|object| !object.faces.is_empty()).collect();
    let meshes: Vec<Value> = objects.iter().map(|object| mesh(object, &mut buffer)).collect();
    let images: Vec<Value> = model
        .pages
        .iter()
        .map(|page| {
            let view = buffer.view(&page.bytes, None);
            json!({ "bufferView": view, "mimeType": page.kind.media_type(), "name": page.material() })
        })
        .collect();
    let mut nodes = vec![root(model, objects.len())];
    nodes.extend(objects.iter().enumerate().map(|(index, object)| {
        let mut node = json!({ "name": object.name, "mesh": index });
        if object.billboard {
            node["extras"] = json!({ "billboard": true });
        }
        node
    }));
    let mut document = json!({
        "asset": { "version": "2.0", "generator": generator },
        "scene": 0,
        "scenes": [{ "name": model.name, "nodes": [0] }],
        "nodes": nodes,
    });
    let lists = [
        ("meshes", meshes),
        ("accessors", buffer.accessors),
        ("bufferViews", buffer.views),
        ("images", images),
        ("textures", (0..model.pages.len()).map(|page| json!({ "sampler": 0, "source": page })).collect()),
        (
            "materials",
            model
                .pages
                .iter()
                .enumerate()
                .map(|(index, page)| material(index, page.material(), page.kind))
                .collect(),
        ),
    ];
    // Empty lists are no glTF.
    for (name, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
        document[name] = Value::Array(list);
    }
    if !model.pages.is_empty() {
        document["extensionsUsed"] = json!(["KHR_materials_unlit"]);
        document["samplers"] = json!([{
            "magFilter": LINEAR, "minFilter": LINEAR_MIPMAP_LINEAR, "wrapS": CLAMP_TO_EDGE, "wrapT": CLAMP_TO_EDGE,
        }]);
        document["buffers"] = json!([{ "byteLength": buffer.bytes.len() }]);
    }
    WrittenFile { name: format!("{}.glb", model.name), bytes: container(&document, buffer.bytes) }
}

/// Returns the node that turns the model, with the objects' nodes below it.
fn root(model: &TexturedModel, objects: usize) -> Value {
    let [x, y, z, w] = DQuat::from_mat3(&y_from_up(model.up)).to_array();
    let children: Vec<usize> = (1..=objects).collect();
    let mut node = json!({
        "name": model.name,
        "rotation": [x as f32, y as f32, z as f32, w as f32],
        "extras": { "origin": model.origin.to_array() },
    });
    if objects > 0 {
        node["children"] = json!(children);
    }
    node
}

/// Returns the rotation that takes the up direction to +y; z to y by a quarter turn about x, as exporters do.
pub(super) fn y_from_up(up: DVec3) -> DMat3 {
    let y_from_z = DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y);
    if up == DVec3::Z {
        y_from_z
    } else {
        y_from_z * DMat3::from_quat(DQuat::from_rotation_arc(up, DVec3::Z))
    }
}

fn material(index: usize, name: &str, kind: PageKind) -> Value {
    let mut material = json!({
        "name": name,
        "pbrMetallicRoughness": { "baseColorTexture": { "index": index }, "metallicFactor": 0, "roughnessFactor": 1 },
        "extensions": { "KHR_materials_unlit": {} },
        "doubleSided": true,
    });
    if kind == PageKind::PngWithAlpha {
        material["alphaMode"] = json!("MASK");
    }
    material
}

fn mesh(object: &TexturedObject, buffer: &mut Buffer) -> Value {
    let primitives: Vec<Value> = object
        .runs()
        .map(|faces| {
            let (mut positions, mut uvs, mut indices) = (Vec::new(), Vec::new(), Vec::new());
            let mut shared = Shared::new();
            for face in faces {
                for corner in face.triangles.iter().flatten() {
                    let corner = face.corners[*corner as usize];
                    let (position, uv) = (corner.position.as_vec3().to_array(), corner.uv.as_vec2().to_array());
                    let (number, is_new) = shared.number((position.map(f32::to_bits), uv.map(f32::to_bits)));
                    if is_new {
                        positions.push(position);
                        uvs.push(uv);
                    }
                    indices.push(number as u32);
                }
            }
            let attributes = json!({ "POSITION": buffer.positions(&positions), "TEXCOORD_0": buffer.uvs(&uvs) });
            json!({ "attributes": attributes, "indices": buffer.indices(&indices), "material": faces[0].page })
        })
        .collect();
    let counts: Vec<usize> = object.faces.iter().map(|face| face.triangles.len()).collect();
    json!({ "name": object.name, "primitives": primitives, "extras": { "faceTriangleCounts": counts } })
}

/// The binary part with its descriptions.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Appends bytes and returns the number of their view.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, bytes: &[u8], target: u32, mut accessor: Value) -> usize {
        accessor["bufferView"] = json!(self.view(bytes, Some(target)));
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn positions(&mut self, positions: &[[f32; 3]]) -> usize {
        let extreme = |start: f32, choose: fn(f32, f32) -> f32| {
            positions
                .iter()
                .fold([start; 3], |found, position| [0, 1, 2].map(|c| choose(found[c], position[c])))
        };
        let (min, max) = (extreme(f32::INFINITY, f32::min), extreme(f32::NEG_INFINITY, f32::max));
        let accessor = json!({
            "componentType": FLOAT, "count": positions.len(), "type": "VEC3", "min": min, "max": max,
        });
        self.accessor(&bytes_of(positions.as_flattened(), f32::to_le_bytes), ARRAY_BUFFER, accessor)
    }

    fn uvs(&mut self, uvs: &[[f32; 2]]) -> usize {
        let accessor = json!({ "componentType": FLOAT, "count": uvs.len(), "type": "VEC2" });
        self.accessor(&bytes_of(uvs.as_flattened(), f32::to_le_bytes), ARRAY_BUFFER, accessor)
    }

    fn indices(&mut self, indices: &[u32]) -> usize {
        let accessor = json!({ "componentType": UNSIGNED_INT, "count": indices.len(), "type": "SCALAR" });
        self.accessor(&bytes_of(indices, u32::to_le_bytes), ELEMENT_ARRAY_BUFFER, accessor)
    }
}

fn bytes_of<T: Copy>(values: &[T], bytes: fn(T) -> [u8; 4]) -> Vec<u8> {
    values.iter().flat_map(|&value| bytes(value)).collect()
}

/// Returns the file: a header and two chunks, each a multiple of four bytes long.
fn container(document: &Value, binary: Vec<u8>) -> Vec<u8> {
    let mut text = serde_json::to_vec(document).expect("it contains numbers and strings only");
    text.resize(text.len().next_multiple_of(4), b' ');
    let chunks = [(JSON_CHUNK, text), (BINARY_CHUNK, binary)];
    let chunks: Vec<_> = chunks.into_iter().filter(|(_, bytes)| !bytes.is_empty()).collect();
    let length: usize = 12 + chunks.iter().map(|(_, bytes)| 8 + bytes.len()).sum::<usize>();
    let mut file = Vec::with_capacity(length);
    file.extend(MAGIC);
    file.extend(VERSION.to_le_bytes());
    file.extend((length as u32).to_le_bytes());
    for (kind, bytes) in chunks {
        file.extend((bytes.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(bytes);
    }
    file
}
