//! fSpy's project `.fspy`: one photo, calibrated by its vanishing points.
//!
//! After the mark `fspy` come the version, and the sizes of the state (JSON) and of the picture, as whole numbers of four bytes. The
//! transform is from camera to world by rows, in OpenGL's axes; lengths in the photo are in halves of its longer side, y upwards from the
//! middle. Source: fSpy, *Project file format*; the convention was compared with files that fSpy wrote.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use glam::{DMat3, DVec3};
use serde_json::Value;

use super::assembly::Assembly;
use super::foreign_text::{json_number, json_numbers, kind};
use super::format::CameraFormat;
use super::pose::{CV_FROM_GL, pose_at, rotation_and_scale};
use super::raw::RawCamera;
use super::recognise::{beginning, recognised};
use super::reconstruction::ReconstructionFiles;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Lens, Pose};
use quadratura_base::task::Task;
use quadratura_files::foreign_json::parse_foreign_json;
use quadratura_files::text::Objection;

/// The format.
pub(super) struct FSpy;

const MARK: &[u8] = b"fspy";
/// The only version there is.
const VERSION: u32 = 1;
/// The largest state, in bytes; it has some thousand.
const LARGEST_STATE: u32 = 16 << 20;
const REMEDY: &str = "save the project again in fSpy";

impl CameraFormat for FSpy {
    fn accepted(&self) -> &'static str {
        "fSpy's project .fspy, of one photo with the same name"
    }

    fn program(&self) -> &'static str {
        "fSpy"
    }

    fn kept_and_lost(&self) -> [&'static str; 2] {
        [
            "focal length and principal point of one photo; not tried with the program itself, but with files that it wrote",
            "the picture inside; vanishing points; units",
        ]
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["fspy"]
    }

    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>> {
        beginning(file).starts_with(MARK).then(|| Ok(ReconstructionFiles::one(file)))
    }

    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>> {
        let found = recognised(folder, names, ".fspy", &[], |beginning| beginning.starts_with(MARK));
        let mut files = ReconstructionFiles::one(found.first()?);
        if let Some(other) = found.get(1) {
            let (used, other) = (files.images.display(), other.display());
            files.notes.push(format!(
                "{used}: read instead of {other}; each project of fSpy has a world of its own, and is a site of its own"
            ));
        }
        Some(Ok(files))
    }

    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, _: &Task) -> Result<()> {
        let file = &files.images;
        let state = state(file)?;
        let parameters = match state.get("cameraParameters") {
            Some(parameters) if parameters.is_object() => parameters,
            other => {
                let found = format!("its camera is {}: the photo is not calibrated", kind(other));
                return Err(Error::input(
                    file,
                    "cameraParameters",
                    found,
                    "set the vanishing points in fSpy, and save again",
                ));
            }
        };
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        assembly.photo("cameraParameters".into(), &name, camera(parameters), pose(parameters));
        assembly.note(format!(
            "{}: one photo, without sparse points; it is the photo called {name} in the folder of the photos (the one inside the \
             project is not used), and its world has the unit and origin that were chosen in fSpy",
            file.display()
        ));
        Ok(())
    }
}

fn state(file: &Path) -> Result<Value> {
    let damaged = |found: String| Error::input(file, "", found, REMEDY);
    let mut input = File::open(file).map_err(Error::io(file, "read it"))?;
    let mut head = [0; 16];
    input.read_exact(&mut head).map_err(|_| damaged("it ends within its head of 16 bytes".into()))?;
    let number = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    let (version, length) = (number(4), number(8));
    if version != VERSION {
        return Err(damaged(format!("version {version}, expected {VERSION}")));
    }
    if length > LARGEST_STATE {
        return Err(damaged(format!("a state of {length} bytes, more than {LARGEST_STATE}")));
    }
    let mut text = Vec::new();
    input.take(length.into()).read_to_end(&mut text).map_err(Error::io(file, "read it"))?;
    if text.len() < length as usize {
        return Err(damaged(format!("it ends after {} of the {length} bytes of its state", text.len())));
    }
    parse_foreign_json(file, &text, REMEDY)
}

fn camera(parameters: &Value) -> Result<RawCamera, Objection> {
    let number = |key: &str| json_number(parameters.get(key), key);
    let side = |key: &str| match number(key)? {
        side if (1.0..1e9).contains(&side) && side.fract() == 0.0 => Ok(side as u64),
        side => Err((format!("{key} is {side}, expected a number of pixels"), REMEDY)),
    };
    let size = [side("imageWidth")?, side("imageHeight")?];
    let half = 0.5 * size[0].max(size[1]) as f64;
    let principal = parameters.get("principalPoint");
    let of = |axis: &str| json_number(principal.and_then(|point| point.get(axis)), "principalPoint");
    let centre = [0.5 * size[0] as f64 + of("x")? * half, 0.5 * size[1] as f64 - of("y")? * half];
    Ok(RawCamera { size, focal: [number("relativeFocalLength")? * half; 2], centre, lens: Lens::None })
}

fn pose(parameters: &Value) -> Result<Pose, Objection> {
    let rows = parameters.get("cameraTransform").and_then(|transform| transform.get("rows"));
    let rows = rows.and_then(Value::as_array).filter(|rows| rows.len() == 4);
    let rows = rows.ok_or_else(|| ("cameraTransform has no 4 rows".to_owned(), REMEDY))?;
    let mut matrix = [[0.0; 4]; 3];
    for (to, row) in matrix.iter_mut().zip(rows) {
        *to = json_numbers(Some(row), "cameraTransform")?;
    }
    let row = |row: [f64; 4]| DVec3::new(row[0], row[1], row[2]);
    // Its rows become the columns of the transpose.
    let gl_from_world = DMat3::from_cols(row(matrix[0]), row(matrix[1]), row(matrix[2]));
    let (gl_from_world, _) = rotation_and_scale(gl_from_world, "cameraTransform")?;
    pose_at(CV_FROM_GL * gl_from_world, DVec3::new(matrix[0][3], matrix[1][3], matrix[2][3]))
}
