//! The mesh of an object.

use glam::{DVec2, DVec3};

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
    uvs: Vec<DVec2>,
    /// The face of each polygon, as its index within the object.
    faces: Vec<usize>,
    /// The page of each polygon.
    pages: Vec<usize>,
}

/// Writes the mesh of an object, which is called `name`; `materials` are the names of the pages' materials. Faces that are not convex are
/// written as triangles, because renderers of USD draw polygons as fans; `primvars:face` tells which polygons are one face.
pub(super) fn write(text: &mut String, name: &str, object: &TexturedObject, materials: &[String]) {
    let polygons = polygons(object);
    let (low, high) =
        polygons.points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| {
            (low.min(*point), high.max(*point))
        });
    let point = |point: &DVec3| tuple(point.to_array());
    // v runs upwards.
    let uv = |uv: &DVec2| tuple([uv.x, 1.0 - uv.y]);
    let mut pages = polygons.pages.clone();
    pages.sort_unstable();
    pages.dedup();
    let bound = match pages[..] {
        [page] => binding("            ", &materials[page]),
        _ => "            uniform token subsetFamily:materialBind:familyType = \"partition\"\n".to_owned(),
    };
    let api = if pages.len() == 1 {
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
    for page in pages.iter().filter(|_| pages.len() > 1) {
        let members = array((0..polygons.pages.len()).filter(|&polygon| polygons.pages[polygon] == *page));
        let (material, bound) = (&materials[*page], binding("                ", &materials[*page]));
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

fn polygons(object: &TexturedObject) -> Polygons {
    let mut polygons = Polygons::default();
    let mut shared = Shared::new();
    for (index, face) in object.faces.iter().enumerate() {
        let whole: Vec<u32> = (0..face.corners.len() as u32).collect();
        let parts =
            if is_convex(face) { vec![whole] } else { face.triangles.iter().map(|t| t.to_vec()).collect() };
        for part in parts {
            polygons.counts.push(part.len());
            polygons.faces.push(index);
            polygons.pages.push(face.page);
            for corner in part.iter().map(|&corner| face.corners[corner as usize]) {
                let (number, is_new) = shared.number(corner.position.to_array().map(f64::to_bits));
                if is_new {
                    polygons.points.push(corner.position);
                }
                polygons.indices.push(number);
                polygons.uvs.push(corner.uv);
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
