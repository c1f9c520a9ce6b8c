//! Reads models: OBJ, glTF and GLB become one [`Model`] of named objects with polygon faces.
//!
//! [`obj`] and [`gltf`] describe what names an object. In all formats an object is a billboard when its name,
//! or the name of a material on it, contains the word `billboard`.

pub mod gltf;
mod limits;
mod notes;
pub mod obj;

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Model, ModelBuilder};
use quadratura_base::task::Task;
use quadratura_files::guarded::guarded;

pub use limits::{LARGEST_FILE, MOST_CORNERS, check_file_size};

/// Reads a model: OBJ by the extension `.obj`, glTF and GLB by theirs or by how the file begins. Returns the
/// model in the file's own coordinates, and notes for the user about what is wrong with it or was left out. A
/// face that is degenerate, not planar or crosses itself gives a note, never an error.
///
/// # Errors
/// [`Error::Io`] when the file cannot be read; [`Error::Input`] with line, byte or JSON path when it is
/// damaged, too large or has no faces; [`Error::Cancelled`] on request.
pub fn read_model(path: &Path, task: &Task) -> Result<(Model, Vec<String>)> {
    guarded(path, "export the model again, or a part of it at a time", || decoded(path, task))
}

fn decoded(path: &Path, task: &Task) -> Result<(Model, Vec<String>)> {
    let mut file = File::open(path).map_err(Error::io(path, "open it"))?;
    let metadata = file.metadata().map_err(Error::io(path, "read it"))?;
    if !metadata.is_file() {
        return Err(Error::input(path, "", "this is not a file", "give an .obj, .gltf or .glb file"));
    }
    if metadata.len() == 0 {
        return Err(Error::input(path, "", "the file is empty: 0 bytes", "copy or export it again"));
    }
    limits::check_file_size(path, metadata.len())?;
    let mut notes = Vec::new();
    let builder = match format_of(path, &mut file)? {
        Format::Obj => {
            let input = BufReader::with_capacity(1 << 20, file);
            obj::read(path, input, metadata.len(), task, &mut notes)?
        }
        Format::Gltf => {
            let mut bytes = Vec::new();
            file.take(LARGEST_FILE).read_to_end(&mut bytes).map_err(Error::io(path, "read it"))?;
            gltf::read(path, &bytes, task, &mut notes)?
        }
    };
    finish(path, builder, notes, task)
}

enum Format {
    Obj,
    Gltf,
}

/// Determines the format by the extension, or else by how the file begins.
fn format_of(path: &Path, file: &mut File) -> Result<Format> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match extension.as_str() {
        "obj" => return Ok(Format::Obj),
        "gltf" | "glb" => return Ok(Format::Gltf),
        _ => {}
    }
    let mut start = Vec::new();
    file.take(4).read_to_end(&mut start).map_err(Error::io(path, "read it"))?;
    file.rewind().map_err(Error::io(path, "read it"))?;
    match start.as_slice() {
        b"glTF" => Ok(Format::Gltf),
        _ => {
            let found = format!("`.{extension}` is not a supported model format");
            Err(Error::input(path, "", found, "export the model as OBJ, glTF or GLB"))
        }
    }
}

fn finish(
    path: &Path,
    builder: ModelBuilder,
    mut notes: Vec<String>,
    task: &Task,
) -> Result<(Model, Vec<String>)> {
    let (model, flaws) = builder.finish(task)?;
    if model.triangles.is_empty() {
        let found = match model.faces.len() {
            0 => "it has no faces".to_owned(),
            n => format!("none of its {n} faces has an area"),
        };
        return Err(Error::input(path, "", found, "export the model with its polygon faces"));
    }
    notes.extend(notes::about_faces(&model, &flaws));
    Ok((model, notes))
}
