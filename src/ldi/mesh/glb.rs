//! Writes a layered depth image as GLB (binary glTF 2.0): its segments as meshes without lighting, and the reference camera.
//!
//! The axes are glTF's: y up, the camera at the origin, looking along -z; lengths are world units. What is infinitely far is on
//! a sphere around the camera ([`GlbContent::sky`]). glTF has no textures that are divided per pixel; the segments' cells are small
//! enough ([`crate::segments::SegmentOptions::undivided`]).

use std::io::Write;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use serde_json::{Value, json};

use crate::page::pictures::rgba_png;
use crate::segments::{Atlas, Segments, TexturedPart, Vertex};
use quadratura_base::error::Result;
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_files::atomic::write_atomically_with;
use quadratura_files::free_path::{FreePath, free_path};
use quadratura_files::hash::hash_bytes;
use quadratura_page::pictures::jpeg;

#[cfg(test)]
mod tests;

/// The content of a GLB file.
#[derive(Debug, Clone, Copy)]
pub struct GlbContent<'a> {
    /// The name of the meshes.
    pub name: &'a str,
    /// The reference camera.
    pub camera: &'a Pinhole,
    /// Its pose in the world, which is kept beside the meshes.
    pub pose: &'a Pose,
    /// The meshes and colours.
    pub segments: &'a Segments,
    /// The quality of JPEGs, from 1 to 100.
    pub quality: u8,
}

/// What marks a file's hash, which is that of the file with zeros in its place.
const HASH: &str = "\"quadratura_hash\":\"";
const HASH_DIGITS: usize = 64;
/// The sky is this many times as far as the farthest other corner.
const SKY: f64 = 4.0;
/// The largest part of opacity that is cut off: half a pixel, where a rim is.
const CUT: f64 = 0.5;

/// Writes a GLB file atomically; returns its size in bytes.
///
/// # Errors
/// [`quadratura_base::Error::Io`].
pub fn write_glb(file: &Path, mesh: &GlbContent<'_>) -> Result<u64> {
    let bytes = glb(mesh);
    write_atomically_with(file, |out| out.write_all(&bytes))?;
    Ok(bytes.len() as u64)
}

/// Returns the first of `NAME.glb`, `NAME-2.glb` and so on that is free or an unchanged file of this program, and the files
/// that are kept.
pub fn place_of_glb(out: &Path) -> (PathBuf, Vec<PathBuf>) {
    let FreePath { path, spared } = free_path(out, |path| std::fs::read(path).is_ok_and(is_unchanged));
    (path, spared)
}

/// Returns whether a file has the hash that is written in it.
fn is_unchanged(mut bytes: Vec<u8>) -> bool {
    let Some(at) = bytes.windows(HASH.len()).position(|part| part == HASH.as_bytes()) else { return false };
    let start = at + HASH.len();
    let Some(hash) = bytes.get(start..start + HASH_DIGITS).map(<[u8]>::to_vec) else { return false };
    bytes[start..start + HASH_DIGITS].fill(b'0');
    hash_bytes(&bytes).as_bytes() == hash
}

/// Returns the bytes of a GLB file.
fn glb(mesh: &GlbContent<'_>) -> Vec<u8> {
    let mut writer = Writer::default();
    let json = writer.document(mesh);
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    writer.binary.resize(writer.binary.len().next_multiple_of(4), 0);
    let chunks: [(&[u8; 4], &[u8]); 2] = [(b"JSON", &text), (b"BIN\0", &writer.binary)];
    let length = 12 + chunks.iter().map(|(_, bytes)| 8 + bytes.len()).sum::<usize>();
    let mut out = Vec::with_capacity(length);
    out.extend(b"glTF");
    out.extend(2u32.to_le_bytes());
    out.extend((length as u32).to_le_bytes());
    for (kind, bytes) in chunks {
        out.extend((bytes.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(bytes);
    }
    let hash = hash_bytes(&out);
    let at = out.windows(HASH.len()).position(|part| part == HASH.as_bytes());
    let start = at.expect("the document has a hash") + HASH.len();
    out[start..start + HASH_DIGITS].copy_from_slice(hash.as_bytes());
    out
}

/// The binary part with the views into it.
#[derive(Default)]
struct Writer {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Writer {
    fn document(&mut self, mesh: &GlbContent<'_>) -> Value {
        let sky = mesh.sky();
        let (mut primitives, mut materials, mut textures, mut images) = (vec![], vec![], vec![], vec![]);
        for (number, atlas) in mesh.segments.atlases.iter().enumerate() {
            primitives.push(self.primitive(mesh, number, sky));
            images.push(self.image(atlas, mesh.quality));
            textures.push(json!({ "source": number, "sampler": 0 }));
            materials.push(material(number, atlas.opaque));
        }
        let Pinhole { width, height, fx, fy, cx, cy } = *mesh.camera;
        let [w, h] = [width, height].map(f64::from);
        let position = mesh.pose.center_in_world();
        let rotation = mesh.pose.rotation;
        let axes = [rotation.row(0), -rotation.row(1), -rotation.row(2)].map(|axis| axis.to_array());
        json!({
            "asset": { "version": "2.0", "generator": format!("Quadratura {}", env!("CARGO_PKG_VERSION")) },
            "extras": { "quadratura_hash": "0".repeat(HASH_DIGITS) },
            "extensionsUsed": ["KHR_materials_unlit"],
            "scene": 0,
            "scenes": [{ "nodes": [0, 1] }],
            "nodes": [
                { "name": mesh.name, "mesh": 0 },
                { "name": "reference camera", "camera": 0, "extras": {
                    "width": width, "height": height, "fx": fx, "fy": fy, "cx": cx, "cy": cy,
                    "position_in_world": position.to_array(), "axes_in_world": axes,
                } },
            ],
            "cameras": [{ "type": "perspective", "perspective": {
                "yfov": 2.0 * (h / 2.0 / fy).atan(), "aspectRatio": w * fy / (h * fx),
                "znear": mesh.segments.reach / 100.0, "zfar": 2.0 * sky,
            } }],
            "meshes": [{ "name": mesh.name, "primitives": primitives }],
            "materials": materials,
            "textures": textures,
            "samplers": [{ "magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071 }],
            "images": images,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.binary.len().next_multiple_of(4) }],
        })
    }

    /// Adds the parts of an atlas.
    fn primitive(&mut self, mesh: &GlbContent<'_>, number: usize, sky: f64) -> Value {
        let atlas = &mesh.segments.atlases[number];
        let (mut positions, mut texels, mut indices) = (Vec::new(), Vec::new(), Vec::<u32>::new());
        for part in mesh.segments.parts.iter().filter(|part| part.atlas == number) {
            let first = positions.len() as u32;
            positions
                .extend(part.vertices.iter().map(|vertex| mesh.position(vertex, sky).as_vec3().to_array()));
            texels.extend(part.vertices.iter().map(|vertex| texture_coordinates(part, vertex, atlas)));
            // Counter-clockwise from the front, as glTF has it.
            indices.extend(
                part.triangles
                    .iter()
                    .flat_map(|&[a, b, c]| [a, c, b])
                    .map(|corner| first + u32::from(corner)),
            );
        }
        let bounds = |pick: fn(f32, f32) -> f32| {
            let picked = |a: [f32; 3], b: &[f32; 3]| std::array::from_fn(|i| pick(a[i], b[i]));
            positions.iter().fold(positions[0], picked)
        };
        let (least, largest) = (bounds(f32::min), bounds(f32::max));
        let floats = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>();
        let view = self.view(&floats(positions.as_flattened()), Some(ARRAY));
        let position = self
            .accessor(json!({ "bufferView": view, "componentType": FLOAT, "count": positions.len(),
            "type": "VEC3", "min": least, "max": largest }));
        let view = self.view(&floats(texels.as_flattened()), Some(ARRAY));
        let texel = self.accessor(
            json!({ "bufferView": view, "componentType": FLOAT, "count": texels.len(), "type": "VEC2" }),
        );
        let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ELEMENTS));
        let index = self.accessor(
            json!({ "bufferView": view, "componentType": UNSIGNED_INT, "count": indices.len(), "type": "SCALAR" }),
        );
        json!({ "attributes": { "POSITION": position, "TEXCOORD_0": texel }, "indices": index, "material": number })
    }

    fn image(&mut self, atlas: &Atlas, quality: u8) -> Value {
        let (kind, bytes) = match atlas.opaque {
            true => ("image/jpeg", jpeg(&atlas.rgb, [atlas.width, atlas.height], quality)),
            false => ("image/png", rgba_png(atlas)),
        };
        let view = self.view(&bytes, None);
        json!({ "bufferView": view, "mimeType": kind })
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.binary.extend(bytes);
        self.views.push(view);
        self.views.len() - 1
    }
}

// Numbers of the glTF 2.0 specification, section 3.6.
const ARRAY: u32 = 34962;
const ELEMENTS: u32 = 34963;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;

impl GlbContent<'_> {
    /// Returns the radius of the sphere on which what is infinitely far is drawn, in world units.
    pub fn sky(&self) -> f64 {
        let vertices = self.segments.parts.iter().flat_map(|part| &part.vertices);
        let depths = vertices.map(|vertex| f64::from(vertex.inverse_depth)).filter(|depth| *depth > 0.0);
        let farthest = depths.map(f64::recip).fold(0.0, f64::max);
        SKY * if farthest > 0.0 { farthest } else { 1000.0 * self.segments.reach }
    }

    /// Returns the position of a corner in glTF's axes.
    fn position(&self, vertex: &Vertex, sky: f64) -> DVec3 {
        let ray = self.camera.ray_in_camera(DVec2::new(vertex.x.into(), vertex.y.into()));
        let depth = f64::from(vertex.inverse_depth);
        let point = if depth > 0.0 { ray / depth } else { ray.normalize() * sky };
        DVec3::new(point.x, -point.y, -point.z)
    }
}

fn texture_coordinates(part: &TexturedPart, vertex: &Vertex, atlas: &Atlas) -> [f32; 2] {
    let texel = Segments::texel(part, vertex);
    [(texel.x / f64::from(atlas.width)) as f32, (texel.y / f64::from(atlas.height)) as f32]
}

fn material(atlas: usize, opaque: bool) -> Value {
    let mut material = json!({
        "name": format!("atlas {}", atlas + 1),
        "pbrMetallicRoughness": { "baseColorTexture": { "index": atlas }, "metallicFactor": 0.0 },
        "extensions": { "KHR_materials_unlit": {} },
    });
    if !opaque {
        material["alphaMode"] = "MASK".into();
        material["alphaCutoff"] = CUT.into();
    }
    material
}
