//! Reads dense meshes from photogrammetry: triangles without names, as PLY, OBJ, glTF or GLB.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use glam::DVec3;
use serde::Deserialize;

use super::models::{check_file_size, read_model};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_files::guarded::guarded;

/// The most triangles that are read.
pub const MOST_TRIANGLES: usize = 5_000_000;

/// A dense mesh.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DenseMesh {
    /// The vertices, in the file's coordinates.
    pub vertices: Vec<DVec3>,
    /// The triangles, as indices into the vertices.
    pub triangles: Vec<[u32; 3]>,
}

/// The elements of a PLY file that make a mesh; others, and other properties, are skipped.
#[derive(Deserialize)]
struct PlyMesh {
    vertex: Vec<PlyVertex>,
    #[serde(default)]
    face: Vec<PlyFace>,
}

#[derive(Deserialize)]
struct PlyVertex {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Deserialize)]
struct PlyFace {
    /// Both names are in use.
    #[serde(alias = "vertex_index")]
    vertex_indices: Vec<u32>,
}

/// Reads a mesh: PLY (text or binary) by the extension `.ply`, otherwise a model. Polygons are divided into triangles.
///
/// # Errors
/// [`Error::Io`] when the file cannot be read; [`Error::Input`] when it is damaged, has no triangles or more than [`MOST_TRIANGLES`];
/// [`Error::Cancelled`] on request.
pub fn read_mesh(path: &Path, task: &Task) -> Result<DenseMesh> {
    let is_ply = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ply"));
    let mesh = if is_ply {
        guarded(path, "export the mesh again", || read_ply(path))?
    } else {
        let (model, _) = read_model(path, task)?;
        DenseMesh { vertices: model.vertices, triangles: model.triangles }
    };
    task.check_cancelled()?;
    let found = match mesh.triangles.len() {
        0 => "it has no triangles: a cloud of points is no mesh".to_owned(),
        count if count > MOST_TRIANGLES => {
            format!("it has {count} triangles, and {MOST_TRIANGLES} can be read")
        }
        _ => return Ok(mesh),
    };
    let remedy =
        if mesh.triangles.is_empty() { "export the mesh with its faces" } else { "simplify the mesh" };
    Err(Error::input(path, "", found, remedy))
}

fn read_ply(path: &Path) -> Result<DenseMesh> {
    let file = File::open(path).map_err(Error::io(path, "open it"))?;
    check_file_size(path, file.metadata().map_err(Error::io(path, "read it"))?.len())?;
    let damaged = |found: String| Error::input(path, "", found, "export the mesh again");
    let PlyMesh { vertex, face } = serde_ply::from_reader(BufReader::with_capacity(1 << 20, file))
        .map_err(|error| damaged(format!("this is no PLY file that can be read: {error}")))?;
    let vertices: Vec<DVec3> = vertex.iter().map(|PlyVertex { x, y, z }| DVec3::new(*x, *y, *z)).collect();
    if let Some(at) = vertices.iter().position(|vertex| !vertex.is_finite()) {
        return Err(damaged(format!("vertex {at} has a coordinate that is no number")));
    }
    let mut triangles = Vec::with_capacity(face.len());
    for (at, PlyFace { vertex_indices: corners }) in face.iter().enumerate() {
        if let Some(corner) = corners.iter().find(|corner| **corner as usize >= vertices.len()) {
            let count = vertices.len();
            return Err(damaged(format!("face {at} names vertex {corner}, and there are {count}")));
        }
        triangles.extend((2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]]));
    }
    Ok(DenseMesh { vertices, triangles })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
                          element face 1\nproperty list uchar int vertex_indices\nend_header\n";

    fn read(name: &str, bytes: &[u8]) -> Result<DenseMesh> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(name);
        std::fs::write(&file, bytes).unwrap();
        read_mesh(&file, &Task::silent())
    }

    fn text(face: &str) -> String {
        format!("ply\nformat ascii 1.0\ncomment scan\n{HEADER}0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n{face}\n")
    }

    fn binary() -> Vec<u8> {
        let mut bytes = format!("ply\nformat binary_little_endian 1.0\n{HEADER}").into_bytes();
        for [x, y] in [[0.0f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            [x, y, 0.0].into_iter().for_each(|it| bytes.extend(it.to_le_bytes()));
            bytes.push(9);
        }
        bytes.push(4);
        (0..4i32).for_each(|corner| bytes.extend(corner.to_le_bytes()));
        bytes
    }

    #[test]
    fn text_binary_and_models_are_the_same_mesh() {
        let expected = [[0, 1, 2], [0, 2, 3]];
        let of_text = read("scan.ply", text("4 0 1 2 3").as_bytes()).unwrap();
        assert_eq!(
            (of_text.triangles.as_slice(), of_text.vertices[2]),
            (&expected[..], DVec3::new(1.0, 1.0, 0.0))
        );
        assert_eq!(read("scan.PLY", &binary()).unwrap(), of_text);
        let other = text("4 0 1 2 3").replace("vertex_indices", "vertex_index");
        assert_eq!(read("scan.ply", other.as_bytes()).unwrap(), of_text);
        let obj = read("scan.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n").unwrap();
        assert_eq!(obj.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn damaged_files_and_clouds_are_refused_with_the_place() {
        let refused = |bytes: &[u8]| read("scan.ply", bytes).unwrap_err().to_string();
        assert!(refused(text("3 0 1 7").as_bytes()).contains("face 0 names vertex 7, and there are 4"));
        assert!(refused(text("3 0 1 2").replace("1 1 0 9", "1 nan 0 9").as_bytes()).contains("vertex 2"));
        assert!(refused(b"solid cube").contains("no PLY file"));
        let cloud = text("").replace("element face 1\nproperty list uchar int vertex_indices\n", "");
        assert!(
            refused(cloud.as_bytes()).contains("a cloud of points is no mesh"),
            "{}",
            refused(cloud.as_bytes())
        );
        let whole = binary();
        for end in 0..whole.len() {
            assert!(read("scan.ply", &whole[..end]).is_err(), "{end} bytes of {}", whole.len());
        }
    }
}
