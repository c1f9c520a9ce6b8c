//! USD as text (`.usda`), and with its textures in one file (`.usdz`): for Blender, Houdini, Unreal, Maya, Omniverse, Quick Look.
//!
//! `/site/model` has a mesh per object and `/site/cameras` a camera per photo. What names of primitives forbid is kept in the attribute `quadratura:name`.
//! Materials emit their textures and reflect nothing, because photos contain their light.
//!
//! | module | contents |
//! |---|---|
//! | `text` | names, numbers and strings of the text format |
//! | `mesh`, `material`, `camera` | one primitive each |
//! | `package` | the stored archive of `.usdz` |

mod camera;
mod material;
mod mesh;
mod package;
mod text;

use std::fmt::Write as _;

use glam::{DMat3, DVec3};

use self::text::{PrimitiveNames, matrix, quoted};
use super::{TexturePage, TexturedModel, WrittenFile};
use crate::camera::HandoverCamera;

/// The shortest and the longest distance that cameras show, in extents of the site.
const CLIPPING: [f64; 2] = [1e-4, 1e2];

/// Writes a model and cameras: the stage as text, its textures, and all of it in one file.
pub fn usd(model: TexturedModel, cameras: &[HandoverCamera], generator: &str) -> Vec<WrittenFile> {
    let stage = WrittenFile {
        name: format!("{}.usda", model.name),
        bytes: stage(&model, cameras, generator).into_bytes(),
    };
    let name = format!("{}.usdz", model.name);
    let textures = model.pages.into_iter().map(|page| WrittenFile { name: page.file, bytes: page.bytes });
    let mut files: Vec<WrittenFile> = std::iter::once(stage).chain(textures).collect();
    let package = WrittenFile { name, bytes: package::package(&files) };
    files.push(package);
    files
}

fn stage(model: &TexturedModel, cameras: &[HandoverCamera], generator: &str) -> String {
    let (axis, turn) = axis_of(model.up);
    let [x, y, z] = model.origin.to_array();
    let mut text = format!(
        "#usda 1.0\n(\n    customLayerData = {{\n        string creator = {}\n        double3 origin = ({x}, {y}, {z})\n    }}\n    \
         defaultPrim = \"site\"\n    metersPerUnit = 1\n    upAxis = \"{axis}\"\n)\n\ndef Xform \"site\" (\n    kind = \"component\"\n)\n{{\n",
        quoted(generator),
    );
    if turn != DMat3::IDENTITY {
        let rows = [turn.x_axis, turn.y_axis, turn.z_axis, DVec3::ZERO];
        text.push_str(&transform(&rows, "    "));
    }
    text.push_str("    def Scope \"materials\"\n    {\n");
    let materials = Materials::new(&model.pages);
    for (number, name) in materials.names.iter().enumerate() {
        let first = materials.of_page.iter().position(|of_page| *of_page == number);
        material::write(&mut text, name, &model.pages[first.expect("a material is that of a page")]);
    }
    text.push_str("    }\n\n    def Xform \"model\"\n    {\n");
    let mut names = PrimitiveNames::default();
    for object in model.objects.iter().filter(|object| !object.faces.is_empty()) {
        mesh::write(&mut text, &names.name(&object.name), object, &materials);
    }
    text.push_str("    }\n\n    def Xform \"cameras\"\n    {\n");
    let clipping = CLIPPING.map(|share| share * extent(model, cameras));
    let mut names = PrimitiveNames::default();
    for camera in cameras {
        camera::write(&mut text, &names.name(&camera.name), camera, clipping);
    }
    text.push_str("    }\n}\n");
    text
}

/// The materials of pages; tiles of one picture share one.
struct Materials<'a> {
    pages: &'a [TexturePage],
    names: Vec<String>,
    /// The material of each page, as an index into the names.
    of_page: Vec<usize>,
}

impl<'a> Materials<'a> {
    fn new(pages: &'a [TexturePage]) -> Self {
        let (mut sets, mut names) = (Vec::new(), PrimitiveNames::default());
        let mut of_page = Vec::with_capacity(pages.len());
        for page in pages {
            let known = sets.iter().position(|set| *set == page.set());
            of_page.push(known.unwrap_or(sets.len()));
            if known.is_none() {
                sets.push(page.set());
            }
        }
        let names = sets.iter().map(|set| names.name(set)).collect();
        Self { pages, names, of_page }
    }
}

/// Returns the stage's up axis, and the rotation that brings the model's up direction there; USD knows no other axes.
fn axis_of(up: DVec3) -> (char, DMat3) {
    match up {
        DVec3::Z => ('Z', DMat3::IDENTITY),
        DVec3::Y => ('Y', DMat3::IDENTITY),
        up => ('Y', super::glb::y_from_up(up)),
    }
}

/// Returns a transform by where it takes the axes and the origin.
fn transform(rows: &[DVec3; 4], indent: &str) -> String {
    let mut text = String::new();
    let written = writeln!(
        text,
        "{indent}matrix4d xformOp:transform = {}\n{indent}uniform token[] xformOpOrder = [\"xformOp:transform\"]",
        matrix(rows),
    );
    written.expect("memory does not fail");
    text
}

/// Returns the diagonal of the box around model and cameras; 1 of nothing.
fn extent(model: &TexturedModel, cameras: &[HandoverCamera]) -> f64 {
    let faces = model.objects.iter().flat_map(|object| &object.faces);
    let corners = faces.flat_map(|face| face.corners.iter().map(|corner| corner.position));
    let points = corners.chain(cameras.iter().map(|camera| camera.pose.center_in_world()));
    let (low, high) = points
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)));
    let diagonal = (high - low).length();
    if diagonal.is_finite() && diagonal > 0.0 { diagonal } else { 1.0 }
}

#[cfg(test)]
mod tests;
