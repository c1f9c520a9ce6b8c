//! The primitives of meshes.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use gltf::json::accessor::ComponentType;
use gltf::json::mesh::{Primitive as Described, Semantic};
use gltf::json::validation::Checked;
use rustc_hash::FxHashMap;

use super::super::notes::Notes;
use super::materials::{Materials, TexturedMaterial};
use crate::{Corner, Primitive, Shape, TriangleList};
use quadratura_base::error::Result;
use quadratura_import::models::gltf::{Source, surface};

/// Reads meshes, each once.
pub struct MeshReader<'a> {
    /// The file.
    pub source: &'a Source<'a>,
    materials: Materials<'a>,
    known: FxHashMap<usize, Vec<Primitive>>,
}

impl<'a> MeshReader<'a> {
    /// Prepares the meshes of a file.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with line and column, where materials are damaged.
    pub fn new(source: &'a Source<'a>) -> Result<Self> {
        Ok(Self { source, materials: Materials::new(source)?, known: FxHashMap::default() })
    }

    /// Returns the primitives of a mesh.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with the JSON path; [`quadratura_base::Error::Io`] for pictures.
    pub fn primitives(&mut self, mesh: usize, notes: &mut Notes) -> Result<Vec<Primitive>> {
        if let Some(known) = self.known.get(&mesh) {
            return Ok(known.clone());
        }
        let place = format!("meshes[{mesh}]");
        let described = self.source.root.meshes.get(mesh);
        let described = described.ok_or_else(|| self.source.error(&place, "this mesh does not exist"))?;
        let mut primitives = Vec::new();
        for (i, described) in described.primitives.iter().enumerate() {
            primitives.extend(self.primitive(&format!("{place}.primitives[{i}]"), described, notes)?);
        }
        self.known.insert(mesh, primitives.clone());
        Ok(primitives)
    }

    fn primitive(
        &mut self,
        place: &str,
        described: &Described,
        notes: &mut Notes,
    ) -> Result<Option<Primitive>> {
        let mut left_out = BTreeSet::new();
        let found = surface(self.source, place, described, &mut left_out)?;
        if !left_out.is_empty() {
            notes.add("points, lines, morph targets and primitives without positions are left out", || {
                place.to_owned()
            });
        }
        let Some(found) = found.filter(|found| !found.triangles.is_empty()) else { return Ok(None) };
        let material = described.material.map(|material| material.value());
        let Some(TexturedMaterial { material, texture_set }) = self.materials.surface(material, notes)?
        else {
            return Ok(None);
        };
        if described.attributes.contains_key(&Checked::Valid(Semantic::Colors(0))) {
            notes.add("colours of vertices are left out", || place.to_owned());
        }
        let count = found.positions.len();
        let normals = self.normals(place, described, count)?;
        let textures = self.textures(place, described, texture_set, count)?;
        let corner = |i: usize| Corner {
            position: found.positions[i],
            normal: normals.get(i).copied().unwrap_or_default(),
            texture: textures.get(i).copied().unwrap_or_default(),
        };
        let corners: Vec<Corner> = (0..count).map(corner).collect();
        let has_no_area = |triangle: &&[u32; 3]| {
            let [a, b, c] = triangle.map(|i| found.positions[i as usize]);
            (b - a).cross(c - a) == DVec3::ZERO
        };
        for _ in found.triangles.iter().filter(has_no_area) {
            notes.add("a triangle has no area, and nothing of it is seen", || place.to_owned());
        }
        let shape = Shape::Triangles(TriangleList { corners, triangles: found.triangles });
        Ok(Some(Primitive { shape, material }))
    }

    /// Reads normals, none where the primitive has none. Those that are not finite are 0, which stands for the plane's.
    fn normals(&self, place: &str, described: &Described, count: usize) -> Result<Vec<DVec3>> {
        let expected = "normals that are not VEC3 of floats or of normalised signed integers of 8 or 16 bits";
        let takes = |component, normalized| match component {
            ComponentType::F32 => true,
            ComponentType::I8 | ComponentType::I16 => normalized,
            _ => false,
        };
        let Some(accessor) = described.attributes.get(&Checked::Valid(Semantic::Normals)) else {
            return Ok(Vec::new());
        };
        let normals = self.source.vectors(accessor.value(), expected, takes)?;
        self.check_count(place, "NORMAL", normals.len(), count)?;
        Ok(normals.into_iter().map(|normal| DVec3::from_array(normal).normalize_or_zero()).collect())
    }

    /// Reads the places in pictures of a set, none where the material needs none or the primitive has none.
    fn textures(
        &self,
        place: &str,
        described: &Described,
        set: Option<u32>,
        count: usize,
    ) -> Result<Vec<DVec2>> {
        let expected = "texture coordinates that are not VEC2 of floats or of integers of 8 or 16 bits";
        let semantic = set.map(|set| Checked::Valid(Semantic::TexCoords(set)));
        let Some(accessor) = semantic.and_then(|semantic| described.attributes.get(&semantic)) else {
            return Ok(Vec::new());
        };
        let takes = |component, _| component != ComponentType::U32;
        let textures = self.source.vectors(accessor.value(), expected, takes)?;
        self.check_count(place, "TEXCOORD", textures.len(), count)?;
        let finite = |(i, texture): (usize, [f64; 2])| {
            let texture = DVec2::from_array(texture);
            let place = || format!("accessors[{}], element {i}", accessor.value());
            let found = "a texture coordinate that is not finite";
            if texture.is_finite() { Ok(texture) } else { Err(self.source.error(&place(), found)) }
        };
        textures.into_iter().enumerate().map(finite).collect()
    }

    fn check_count(&self, place: &str, name: &str, found: usize, expected: usize) -> Result<()> {
        if found == expected {
            return Ok(());
        }
        Err(self.source.error(place, format!("{found} elements of {name} for {expected} positions")))
    }
}
