//! Builds a mesh's polygons: reads triangles from its primitives and joins them.

use std::collections::BTreeSet;

use glam::DVec3;
use gltf::json;
use gltf::json::mesh::{Mode, Semantic};
use gltf::json::validation::Checked;
use rustc_hash::FxHashMap;
use serde::Deserialize;

use super::super::limits::{check_count, check_position};
use super::accessor::Source;
use quadratura_base::error::Result;
use quadratura_base::geometry::polygon::{join_all, join_coplanar};
use quadratura_base::scene::builder::says_billboard;

/// The polygons of a mesh in its own coordinates.
#[derive(Default)]
pub(super) struct MeshPolygons {
    pub positions: Vec<DVec3>,
    /// Weakly simple rings of indices into `positions`, in file order.
    pub rings: Vec<Vec<u32>>,
    pub billboard: bool,
}

/// The supported `extras` of a mesh, node or material.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Extras {
    /// The number of triangles of each face, in order, over all primitives.
    face_triangle_counts: Vec<u32>,
    /// Whether the object is a billboard.
    pub billboard: bool,
}

impl Extras {
    /// Parses extras. Those of other programs may hold anything; what does not fit is ignored.
    pub fn from_extras(extras: &json::Extras) -> Self {
        extras.as_ref().and_then(|raw| serde_json::from_str(raw.get()).ok()).unwrap_or_default()
    }
}

/// Reads a mesh. What is left out is added to `notes`, each kind once.
///
/// # Errors
/// [`quadratura_base::Error::Input`] with the JSON path.
pub(super) fn polygons(source: &Source, mesh: usize, notes: &mut BTreeSet<String>) -> Result<MeshPolygons> {
    let place = format!("meshes[{mesh}]");
    let Some(described) = source.root.meshes.get(mesh) else {
        return Err(source.error(&place, "this mesh does not exist"));
    };
    let mut welded = Welded::default();
    let mut triangles = Vec::new();
    let mut ends = Vec::new();
    for (i, primitive) in described.primitives.iter().enumerate() {
        let place = format!("{place}.primitives[{i}]");
        read_primitive(source, &place, primitive, &mut welded, &mut triangles, notes)?;
        ends.push(triangles.len());
    }
    let extras = Extras::from_extras(&described.extras);
    let rings = match runs(&extras.face_triangle_counts, triangles.len()) {
        Some(runs) => runs.flat_map(|run| join_all(&triangles[run], &welded.positions)).collect(),
        None => {
            if !extras.face_triangle_counts.is_empty() {
                notes.insert(format!(
                    "{place}.extras.faceTriangleCounts does not add up to its {} triangles: faces were joined by planes",
                    triangles.len()
                ));
            }
            joined_by_primitive(&triangles, &ends, &welded)
        }
    };
    let billboard =
        extras.billboard || described.primitives.iter().any(|p| has_billboard_material(source, p));
    Ok(MeshPolygons { positions: welded.positions, rings, billboard })
}

/// Returns the range of triangles of each face, if the counts cover all triangles.
fn runs(counts: &[u32], triangles: usize) -> Option<impl Iterator<Item = std::ops::Range<usize>>> {
    let sum: u64 = counts.iter().map(|&n| u64::from(n)).sum();
    let mut end = 0;
    (!counts.is_empty() && sum == triangles as u64).then(|| {
        counts.iter().map(move |&n| {
            end += n as usize;
            end - n as usize..end
        })
    })
}

fn joined_by_primitive(triangles: &[[u32; 3]], ends: &[usize], welded: &Welded) -> Vec<Vec<u32>> {
    let mut rings = Vec::new();
    let mut start = 0;
    for &end in ends {
        rings.extend(join_coplanar(&triangles[start..end], &welded.positions, welded.noise));
        start = end;
    }
    rings
}

fn has_billboard_material(source: &Source, primitive: &json::mesh::Primitive) -> bool {
    let material = primitive.material.and_then(|index| source.root.materials.get(index.value()));
    material.is_some_and(|material| {
        material.name.as_deref().is_some_and(says_billboard)
            || Extras::from_extras(&material.extras).billboard
    })
}

/// Vertices of a mesh, one per position: exporters duplicate them at every crease.
#[derive(Default)]
struct Welded {
    positions: Vec<DVec3>,
    known: FxHashMap<[u64; 3], u32>,
    /// Rounding error of the largest coordinate in 32 bits.
    noise: f64,
}

impl Welded {
    fn add(&mut self, position: DVec3) -> u32 {
        // Adding zero turns -0.0 into 0.0.
        let key = position.to_array().map(|x| (x + 0.0).to_bits());
        self.noise = self.noise.max(position.abs().max_element() * f64::from(f32::EPSILON) * 2.0);
        *self.known.entry(key).or_insert_with(|| {
            self.positions.push(position);
            self.positions.len() as u32 - 1
        })
    }
}

fn read_primitive(
    source: &Source,
    place: &str,
    primitive: &json::mesh::Primitive,
    welded: &mut Welded,
    triangles: &mut Vec<[u32; 3]>,
    notes: &mut BTreeSet<String>,
) -> Result<()> {
    let Some(surface) = surface(source, place, primitive, notes)? else { return Ok(()) };
    let vertices: Vec<u32> = surface.positions.into_iter().map(|position| welded.add(position)).collect();
    triangles.extend(surface.triangles.iter().map(|corners| corners.map(|corner| vertices[corner as usize])));
    check_count(source.path, || place.to_owned(), triangles.len() * 3, "corners")
}

/// The triangles of a primitive.
pub struct Surface {
    /// The positions of its vertices; finite.
    pub positions: Vec<DVec3>,
    /// Three indices into `positions` a triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// Reads the triangles of a primitive; `None`, with a note, where it has none.
///
/// # Errors
/// [`quadratura_base::Error::Input`] with the JSON path.
pub fn surface(
    source: &Source,
    place: &str,
    primitive: &json::mesh::Primitive,
    notes: &mut BTreeSet<String>,
) -> Result<Option<Surface>> {
    let Checked::Valid(mode) = primitive.mode else { return Err(source.error(place, "an unknown mode")) };
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        notes.insert("points and lines are left out".to_owned());
        return Ok(None);
    }
    if primitive.targets.as_ref().is_some_and(|targets| !targets.is_empty()) {
        notes.insert("morph targets are left out: the shape at rest is used".to_owned());
    }
    let Some(accessor) = primitive.attributes.get(&Checked::Valid(Semantic::Positions)) else {
        notes.insert(format!("{place} has no positions; it is left out"));
        return Ok(None);
    };
    refuse_values_elsewhere(source, place, primitive, accessor.value())?;
    let mut positions = Vec::new();
    for (i, position) in source.positions(accessor.value())?.into_iter().enumerate() {
        let position = DVec3::from_array(position);
        check_position(source.path, || format!("accessors[{}], element {i}", accessor.value()), position)?;
        positions.push(position);
    }
    let count = positions.len() as u32;
    let corners = match primitive.indices {
        Some(indices) => source.indices(indices.value())?,
        None => (0..count).collect(),
    };
    if let Some(index) = corners.iter().find(|index| **index >= count) {
        return Err(source.error(place, format!("an index refers to vertex {index} of {count}")));
    }
    Ok(Some(Surface { positions, triangles: triangles_of(mode, &corners) }))
}

/// Refuses a primitive whose positions or indices are not in the file because one of its extensions has them.
fn refuse_values_elsewhere(
    source: &Source,
    place: &str,
    primitive: &json::mesh::Primitive,
    positions: usize,
) -> Result<()> {
    let indices = primitive.indices.map(|indices| indices.value());
    for accessor in std::iter::once(positions).chain(indices) {
        let described = source.accessor(accessor)?;
        if described.buffer_view.is_some() || described.sparse.is_some() {
            continue;
        }
        source.extensions.refuse_compressed(source.path, place)?;
        if let Some(name) = source.extensions.on(place).find(|name| !name.contains("_materials_")) {
            let found = format!("its values come from the extension {name}, which is not read");
            return Err(source.error(place, found));
        }
    }
    Ok(())
}

/// Returns the triangles of a primitive; points and lines have none.
fn triangles_of(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    let triple = |t: &[u32]| [t[0], t[1], t[2]];
    match mode {
        // Every other triangle of a strip has the opposite winding.
        Mode::TriangleStrip => {
            let turned = |(i, t): (usize, &[u32])| if i % 2 == 0 { triple(t) } else { [t[1], t[0], t[2]] };
            corners.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => {
            corners.get(1..).unwrap_or_default().windows(2).map(|t| [corners[0], t[0], t[1]]).collect()
        }
        Mode::Triangles => corners.chunks_exact(3).map(triple).collect(),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => Vec::new(),
    }
}
