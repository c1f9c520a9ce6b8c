//! Wavefront OBJ with its material file and textures: for programs that keep polygons.
//!
//! Faces are n-gons, objects `o`. Materials have no diffuse light, because photos contain theirs: they emit the texture (`map_Ke`); `map_Kd` is for
//! readers that know no emission.

use std::fmt::Write as _;

use glam::{DMat3, DVec3};

use super::{PageKind, Shared, TexturedModel, WrittenFile};

/// The direction that is up in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum UpAxis {
    /// As in the project.
    #[default]
    Project,
    /// +y, as many programs expect it.
    Y,
}

/// Writes a model: the OBJ file, its material file, and the textures.
pub fn obj(model: TexturedModel, up: UpAxis, generator: &str) -> Vec<WrittenFile> {
    let text = |suffix: &str, text: String| WrittenFile {
        name: format!("{}{suffix}", model.name),
        bytes: text.into_bytes(),
    };
    let described =
        [text(".obj", geometry(&model, up, generator)), text(".mtl", materials(&model, generator))];
    let textures = model.pages.into_iter().map(|page| WrittenFile { name: page.file, bytes: page.bytes });
    described.into_iter().chain(textures).collect()
}

fn geometry(model: &TexturedModel, up: UpAxis, generator: &str) -> String {
    let turn = match up {
        UpAxis::Project => DMat3::IDENTITY,
        UpAxis::Y => super::glb::y_from_up(model.up),
    };
    let DVec3 { x, y, z } = model.origin;
    let mut text = format!("# {generator}\n# origin {x} {y} {z}\nmtllib {}.mtl\n", model.name);
    let mut positions = Shared::new();
    let mut uvs = Shared::new();
    let mut write = |line: std::fmt::Arguments| {
        text.write_fmt(line).expect("memory does not fail");
    };
    for object in model.objects.iter().filter(|object| !object.faces.is_empty()) {
        write(format_args!("o {}\n", one_line(&object.name)));
        let mut material = None;
        for face in &object.faces {
            let mut corners = Vec::with_capacity(face.corners.len());
            for corner in &face.corners {
                let position = turn * corner.position;
                let (vertex, is_new) = positions.number(position.to_array().map(f64::to_bits));
                if is_new {
                    let [x, y, z] = position.to_array().map(decimal);
                    write(format_args!("v {x} {y} {z}\n"));
                }
                let st = model.pages[face.page].st(corner.uv);
                let (place, is_new) = uvs.number(st.to_array().map(f64::to_bits));
                if is_new {
                    write(format_args!("vt {:.8} {:.8}\n", st.x, st.y));
                }
                corners.push((vertex + 1, place + 1));
            }
            if material != Some(face.page) {
                write(format_args!("usemtl {}\n", model.pages[face.page].material()));
                material = Some(face.page);
            }
            write(format_args!("f"));
            corners.iter().for_each(|(vertex, place)| write(format_args!(" {vertex}/{place}")));
            write(format_args!("\n"));
        }
    }
    text
}

/// Returns a coordinate with all its digits, without an exponent, which some readers do not know.
fn decimal(value: f64) -> String {
    format!("{}", value + 0.0)
}

/// Returns a name on one line, as names end with the line.
fn one_line(name: &str) -> String {
    name.replace(['\n', '\r'], " ")
}

fn materials(model: &TexturedModel, generator: &str) -> String {
    let of_page = |page: &super::TexturePage| {
        let (name, file) = (page.material(), &page.file);
        let alpha =
            if page.kind == PageKind::PngWithAlpha { format!("map_d {file}\n") } else { String::new() };
        format!(
            "\nnewmtl {name}\nKa 0 0 0\nKd 0 0 0\nKs 0 0 0\nKe 1 1 1\nillum 0\nmap_Ke -clamp on {file}\nmap_Kd -clamp on {file}\n{alpha}"
        )
    };
    format!("# {generator}\n{}", model.pages.iter().map(of_page).collect::<String>())
}
