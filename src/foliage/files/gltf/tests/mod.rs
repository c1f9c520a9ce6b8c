//! Tests with GLB files that the tests make themselves.

mod bad;
mod instances;
mod materials;
mod pictures;

use std::io::Cursor;
use std::path::Path;
use std::sync::{Arc, Mutex};

use glam::DVec3;
use serde_json::{Value, json};

use super::*;
use crate::{Corner, Shape, SubObject};
use quadratura_base::task::Event;

/// A file in the making: its JSON, and the buffer of its binary chunk.
struct Glb {
    json: Value,
    binary: Vec<u8>,
}

/// Corners of a triangle in z = 0.
const TRIANGLE: [[f32; 3]; 3] = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];

impl Glb {
    /// One mesh, a triangle without indices, and these nodes, of which those without a parent are the scene's.
    fn new(nodes: Value) -> Self {
        let json = json!({
            "asset": { "version": "2.0" },
            "nodes": nodes,
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
            "accessors": [],
            "bufferViews": [],
            "buffers": [{ "byteLength": 0 }],
        });
        let mut glb = Self { json, binary: Vec::new() };
        glb.floats("VEC3", &TRIANGLE);
        glb
    }

    fn list(&mut self, name: &str) -> &mut Vec<Value> {
        if self.json[name].is_null() {
            self.json[name] = json!([]);
        }
        self.json[name].as_array_mut().unwrap()
    }

    /// Adds bytes to the buffer; returns the view of them.
    fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len() });
        self.binary.extend(bytes);
        self.json["buffers"][0]["byteLength"] = json!(self.binary.len());
        self.list("bufferViews").push(view);
        self.list("bufferViews").len() - 1
    }

    fn accessor(&mut self, bytes: &[u8], accessor: Value) -> usize {
        let mut accessor = accessor;
        accessor["bufferView"] = json!(self.view(bytes));
        self.list("accessors").push(accessor);
        self.list("accessors").len() - 1
    }

    fn floats<const N: usize>(&mut self, kind: &str, vectors: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = vectors.iter().flatten().flat_map(|number| number.to_le_bytes()).collect();
        self.accessor(&bytes, json!({ "componentType": 5126, "count": vectors.len(), "type": kind }))
    }

    /// Gives a node instances.
    fn instancing(&mut self, node: usize, attributes: Value) {
        self.json["nodes"][node]["extensions"] =
            json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    }

    /// Adds a picture to the buffer, and a texture of it.
    fn texture(&mut self, rgba: &image::RgbaImage) -> usize {
        let mut png = Cursor::new(Vec::new());
        rgba.write_to(&mut png, image::ImageFormat::Png).unwrap();
        let view = self.view(&png.into_inner());
        self.list("images").push(json!({ "bufferView": view, "mimeType": "image/png" }));
        let image = self.list("images").len() - 1;
        self.list("textures").push(json!({ "source": image }));
        self.list("textures").len() - 1
    }

    fn bytes(&self) -> Vec<u8> {
        let mut text = self.json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut binary = self.binary.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend(((28 + text.len() + binary.len()) as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", text), (b"BIN\0", binary)] {
            bytes.extend((chunk.len() as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(chunk);
        }
        bytes
    }

    fn read(&self) -> Result<Plant> {
        plant_of(Path::new("tree.glb"), &self.bytes(), &Task::silent())
    }

    fn plant(&self) -> Plant {
        self.read().unwrap()
    }

    fn refused(&self) -> String {
        self.read().unwrap_err().to_string().replace("tree.glb, ", "")
    }

    /// Reads the file; returns the plant with what is noted.
    fn noted(&self) -> (Plant, Vec<String>) {
        let noted = Arc::new(Mutex::new(Vec::new()));
        let sink = noted.clone();
        let task = Task::new(move |event| {
            if let Event::Note { text, .. } = event {
                sink.lock().unwrap().push(text.to_string());
            }
        });
        let plant = plant_of(Path::new("tree.glb"), &self.bytes(), &task).unwrap();
        let notes = noted.lock().unwrap().clone();
        (plant, notes)
    }
}

/// The corners of a sub-object's only primitive.
fn corners(object: &SubObject) -> &[Corner] {
    match &object.primitives[..] {
        [crate::Primitive { shape: Shape::Triangles(list), .. }] => &list.corners,
        other => panic!("{other:?}"),
    }
}

/// Where all instances of the triangle's first corner are, in the plant's frame, in the order of the plant.
fn feet(plant: &Plant) -> Vec<DVec3> {
    fn visit(plant: &Plant, object: usize, map: glam::DAffine3, feet: &mut Vec<DVec3>) {
        let of = &plant.objects[object];
        feet.extend(of.primitives.iter().map(|_| map.transform_point3(corners(of)[0].position)));
        for child in &of.uses {
            visit(plant, child.child, map * child.parent_from_child, feet);
        }
    }
    let mut feet = Vec::new();
    visit(plant, plant.root, glam::DAffine3::IDENTITY, &mut feet);
    feet
}
