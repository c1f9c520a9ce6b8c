//! The mesh of an object.

use glam::{DVec2, DVec3};

use super::Materials;
use super::text::{array, quoted, tuple};
use crate::textured::{Shared, TexturedFace, TexturedObject};

/// A turn of a polygon's outline counts as the other way from this share of the two edges' lengths.
const STRAIGHT: f64 = 1e-9;

/// The polygons of a mesh.
#[derive(Default)]
struct Polygons {
    points: Vec<DVec3>,
    counts: Vec<usize>,
    indices: Vec<usize>,
    /// The coordinates of texture of each corner, v upwards.
    uvs: Vec<DVec2>,
    /// The face of each polygon, as its index within the object.
    faces: Vec<usize>,
    /// The material of each polygon.
    materials: Vec<usize>,
}

/// Writes the mesh of an object, which is called `name`. Faces that are not convex are
/// written as triangles, because renderers of USD draw polygons as fans; `primvars:face` tells which polygons are one face.
pub(super) fn write(text: &mut String, name: &str, object: &TexturedObject, materials: &Materials) {
    let polygons = polygons(object, materials);
    let (low, high) =
        polygons.points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| {
            (low.min(*point), high.max(*point))
        });
    let point = |point: &DVec3| tuple(point.to_array());
    let uv = |uv: &DVec2| tuple(uv.to_array());
    let mut used = polygons.materials.clone();
    used.sort_unstable();
    used.dedup();
    let bound = match used[..] {
        [material] => binding("            ", &materials.names[material]),
        _ => "            uniform token subsetFamily:materialBind:familyType = \"partition\"\n".to_owned(),
    };
    let api = if used.len() == 1 {
        " (\n            prepend apiSchemas = [\"MaterialBindingAPI\"]\n        )"
    } else {
        ""
    };
    let counts = array(&polygons.counts);
    let indices = array(&polygons.indices);
    let points = array(polygons.points.iter().map(point));
    let uvs = array(polygons.uvs.iter().map(uv));
    let faces = array(&polygons.faces);
    let extent = array([low, high].iter().map(point));
    let full = quoted(&object.name);
    text.push_str(&format!(
        r#"        def Mesh "{name}"{api}
        {{
            uniform bool doubleSided = 1
            float3[] extent = {extent}
            int[] faceVertexCounts = {counts}
            int[] faceVertexIndices = {indices}
{bound}            point3f[] points = {points}
            int[] primvars:face = {faces} (
                interpolation = "uniform"
            )
            texCoord2f[] primvars:st = {uvs} (
                interpolation = "faceVarying"
            )
            custom string quadratura:name = {full}
            uniform token subdivisionScheme = "none"
"#
    ));
    for number in used.iter().filter(|_| used.len() > 1) {
        let is_of = |polygon: &usize| polygons.materials[*polygon] == *number;
        let members = array((0..polygons.materials.len()).filter(is_of));
        let material = &materials.names[*number];
        let bound = binding("                ", material);
        text.push_str(&format!(
            r#"
            def GeomSubset "{material}" (
                prepend apiSchemas = ["MaterialBindingAPI"]
            )
            {{
                uniform token elementType = "face"
                uniform token familyName = "materialBind"
                int[] indices = {members}
{bound}            }}
"#
        ));
    }
    text.push_str("        }\n\n");
}

fn binding(indent: &str, material: &str) -> String {
    format!("{indent}rel material:binding = </site/materials/{material}>\n")
}

fn polygons(object: &TexturedObject, materials: &Materials) -> Polygons {
    let mut polygons = Polygons::default();
    let mut shared = Shared::new();
    for (index, face) in object.faces.iter().enumerate() {
        let whole: Vec<u32> = (0..face.corners.len() as u32).collect();
        let parts =
            if is_convex(face) { vec![whole] } else { face.triangles.iter().map(|t| t.to_vec()).collect() };
        for part in parts {
            polygons.counts.push(part.len());
            polygons.faces.push(index);
            polygons.materials.push(materials.of_page[face.page]);
            for corner in part.iter().map(|&corner| face.corners[corner as usize]) {
                let (number, is_new) = shared.number(corner.position.to_array().map(f64::to_bits));
                if is_new {
                    polygons.points.push(corner.position);
                }
                polygons.indices.push(number);
                polygons.uvs.push(materials.pages[face.page].st(corner.uv));
            }
        }
    }
    polygons
}

/// Returns whether a polygon turns one way at all corners; a bridge to a hole turns the other way.
fn is_convex(face: &TexturedFace) -> bool {
    let corners = &face.corners;
    let at = |i: usize| corners[i % corners.len()].uv;
    let turns: Vec<f64> = (0..corners.len())
        .map(|i| {
            let (a, b) = (at(i + 1) - at(i), at(i + 2) - at(i + 1));
            a.perp_dot(b) / (a.length() * b.length()).max(f64::MIN_POSITIVE)
        })
        .collect();
    let is_one_way = |sign: f64| turns.iter().all(|turn| sign * turn >= -STRAIGHT);
    // A star that goes round twice turns one way, too, but has more triangles than are needed.
    face.triangles.len() + 2 == corners.len() && (is_one_way(1.0) || is_one_way(-1.0))
}
