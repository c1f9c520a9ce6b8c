//! `transforms.json` of nerfstudio, instant-ngp and NeRF's own scenes.
//!
//! Each of `frames` has a `file_path` and a `transform_matrix`, camera to world in OpenGL's axes (y up, looking along
//! -z). Sizes, focal lengths and lenses are global or the frame's own. A frame that uses a `NaN` is left out. `applied_transform`, by which nerfstudio turned
//! the world, is undone, so that a model of the same world fits. Source: nerfstudio, *Data conventions*; instant-ngp,
//! `docs/nerf_dataset_tips.md`.

use std::path::{Path, PathBuf};

use glam::{DMat3, DMat4, DVec3};
use serde_json::{Map, Value};

use super::assembly::Assembly;
use super::foreign_text::{kind, read_value};
use super::format::CameraFormat;
use super::photo_paths::{Without, photo_paths};
use super::pose::{CV_FROM_GL, is_on_a_map, rotation_and_scale};
use super::recognise::{beginning, has_name, holds, recognised};
use super::reconstruction::ReconstructionFiles;
use super::transforms_lens::{Fields, camera};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Pose;
use quadratura_base::task::Task;
use quadratura_files::foreign_json::text_of;
use quadratura_files::text::Objection;

/// The format.
pub(super) struct Transforms;

/// The names that nerfstudio, instant-ngp and NeRF's own scenes use.
const USUAL_NAMES: [&str; 2] = ["transforms.json", "transforms_train.json"];
const REMEDY: &str = "correct it in a text editor, or write it anew with nerfstudio or instant-ngp; it may be cut short or damaged";

impl CameraFormat for Transforms {
    fn accepted(&self) -> &'static str {
        "transforms.json of nerfstudio or instant-ngp"
    }

    fn program(&self) -> &'static str {
        "nerfstudio or instant-ngp"
    }

    fn kept_and_lost(&self) -> [&'static str; 2] {
        [
            "OPENCV and OPENCV_FISHEYE lenses; applied_transform is undone; not tried with the programs themselves",
            "points; mask_path; k4 of OPENCV",
        ]
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["json"]
    }

    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>> {
        let is_one = has_name(file, &USUAL_NAMES) || is_transforms(&beginning(file));
        is_one.then(|| Ok(ReconstructionFiles::one(file)))
    }

    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>> {
        let found = recognised(folder, names, ".json", &USUAL_NAMES, is_transforms);
        ReconstructionFiles::first_of(&found).map(Ok)
    }

    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, task: &Task) -> Result<()> {
        let file = &files.images;
        let global = match read_value(file, EXPECTED, REMEDY)? {
            Value::Object(global) => global,
            other => {
                let found = format!("{}, {EXPECTED}", kind(Some(&other)));
                return Err(Error::input(file, "", found, REMEDY));
            }
        };
        read_frames(file, &global, assembly, task)
    }
}

const EXPECTED: &str = "expected a JSON object with a list \"frames\" of photos";

/// Returns true for a JSON object with the key `frames` and another key that only such files contain.
fn is_transforms(beginning: &[u8]) -> bool {
    let keys =
        ["\"transform_matrix\"", "\"file_path\"", "\"camera_angle_x\"", "\"fl_x\"", "\"applied_transform\""];
    beginning.trim_ascii_start().first() == Some(&b'{')
        && holds(beginning, "\"frames\"")
        && keys.into_iter().any(|key| holds(beginning, key))
}

fn read_frames(
    file: &Path,
    global: &Map<String, Value>,
    assembly: &mut Assembly<'_>,
    task: &Task,
) -> Result<()> {
    let frames = match global.get("frames") {
        Some(Value::Array(frames)) => frames,
        other => {
            let found = format!("{}, expected a list of photos", kind(other));
            return Err(Error::input(file, "frames", found, REMEDY));
        }
    };
    let world = World::new(global).map_err(|(found, remedy)| Error::input(file, "", found, remedy))?;
    let mut named: Vec<(usize, &Map<String, Value>, &str)> = Vec::with_capacity(frames.len());
    for (index, frame) in frames.iter().enumerate() {
        match path_of(frame) {
            Ok((frame, path)) => named.push((index, frame, path)),
            Err(objection) => assembly.refused_photo(place(index), objection),
        }
    }
    let paths: Vec<&str> = named.iter().map(|(.., path)| *path).collect();
    let folder: PathBuf = file.parent().unwrap_or(Path::new("")).to_path_buf();
    let photos = photo_paths(&paths, &[folder], Without::Png);
    let fields = |frame| Fields { frame, global };
    let stated = named.iter().all(|&(_, frame, _)| fields(frame).states_size());
    let sizes = if stated { Vec::new() } else { assembly.sizes(&photos, task)? };
    for (done, (&(index, frame, _), photo)) in named.iter().zip(&photos).enumerate() {
        task.step("read poses", done as u64, named.len() as u64)?;
        let of_file = || sizes[done].clone();
        let camera = camera(fields(frame), of_file);
        let pose = matrix(frame.get("transform_matrix")).and_then(|matrix| world.pose(matrix));
        assembly.photo(place(index), &photo.name, camera, pose);
    }
    note_what_is_not_read(file, global, frames, assembly);
    Ok(())
}

fn place(index: usize) -> String {
    format!("frames[{index}]")
}

fn path_of(frame: &Value) -> Result<(&Map<String, Value>, &str), Objection> {
    let Value::Object(fields) = frame else {
        return Err((format!("{}, expected an object", kind(Some(frame))), "remove it"));
    };
    let path = fields.get("file_path");
    match path.and_then(text_of) {
        Some(path) if !path.trim().is_empty() => Ok((fields, path)),
        _ => {
            let found = format!("file_path is {}, expected the path of the photo", kind(path));
            Err((found, "write the path of the photo, from the folder of this file"))
        }
    }
}

fn note_what_is_not_read(
    file: &Path,
    global: &Map<String, Value>,
    frames: &[Value],
    assembly: &mut Assembly<'_>,
) {
    let file = file.display();
    if let Some(points) = global.get("ply_file_path").and_then(text_of) {
        assembly.note(format!(
            "{file}: the points in {points} are not read, because they do not say which photos show them"
        ));
    }
    let masked = frames.iter().filter(|frame| frame.get("mask_path").and_then(text_of).is_some()).count();
    if masked > 0 {
        assembly.note(format!(
            "{file}: {masked} of {} photos have a mask_path, which is not read; masks are found beside the photos, as \
             masks/NAME.jpg.png",
            frames.len()
        ));
    }
}

/// The transform that nerfstudio applied to the world.
struct World {
    rotation: DMat3,
    scale: f64,
    translation: DVec3,
}

impl World {
    /// Reads `applied_transform`, 3 or 4 rows of 4 numbers, and `applied_scale`; both are optional.
    fn new(global: &Map<String, Value>) -> Result<Self, Objection> {
        let moved = match global.get("applied_transform") {
            None | Some(Value::Null) => DMat4::IDENTITY,
            there => matrix_called("applied_transform", there)?,
        };
        let (rotation, scale) = rotation_and_scale(DMat3::from_mat4(moved), "applied_transform")?;
        let more = match global.get("applied_scale") {
            None | Some(Value::Null) => 1.0,
            there => there.and_then(Value::as_f64).filter(|scale| (1e-9..1e9).contains(scale)).ok_or_else(
                || {
                    let found = format!("applied_scale is {}, expected a positive number", kind(there));
                    (found, "write the number by which positions were multiplied")
                },
            )?,
        };
        let translation = moved.w_axis.truncate();
        if !is_on_a_map(translation.into()) {
            let found = format!("applied_transform moves by {translation}, more than 1e15");
            return Err((found, "export the cameras again"));
        }
        Ok(Self { rotation, scale: scale * more, translation: translation * more })
    }

    /// Converts a `transform_matrix` to a pose in the world before the transform was applied.
    fn pose(&self, camera_to_world: DMat4) -> Result<Pose, Objection> {
        let (turn, _) = rotation_and_scale(DMat3::from_mat4(camera_to_world), "transform_matrix")?;
        let moved = camera_to_world.w_axis.truncate();
        let centre = self.rotation.transpose() * (moved - self.translation) / self.scale;
        if !is_on_a_map(centre.into()) {
            let found = format!("the position {:?} is not within 1e15 of the origin", moved.to_array());
            return Err((found, "write positions in the model's unit"));
        }
        let rotation = (self.rotation.transpose() * turn * CV_FROM_GL).transpose();
        Ok(Pose { rotation, translation: -(rotation * centre) })
    }
}

fn matrix(value: Option<&Value>) -> Result<DMat4, Objection> {
    matrix_called("transform_matrix", value)
}

/// Reads a matrix of 3 or 4 rows of 4 numbers.
fn matrix_called(name: &str, value: Option<&Value>) -> Result<DMat4, Objection> {
    let wrong = |found: String| {
        (format!("{name} {found}, expected 3 or 4 rows of 4 numbers"), "export the cameras again")
    };
    let Some(Value::Array(rows)) = value else { return Err(wrong(format!("is {}", kind(value)))) };
    if !(3..=4).contains(&rows.len()) {
        return Err(wrong(format!("has {} rows", rows.len())));
    }
    let mut numbers = [[0.0; 4], [0.0; 4], [0.0; 4], [0.0, 0.0, 0.0, 1.0]];
    for (number, row) in rows.iter().enumerate() {
        let Value::Array(items) = row else {
            return Err(wrong(format!("row {number} is {}", kind(Some(row)))));
        };
        if items.len() != 4 {
            return Err(wrong(format!("row {number} has {} items", items.len())));
        }
        for (to, item) in numbers[number].iter_mut().zip(items) {
            *to = item.as_f64().ok_or_else(|| wrong(format!("row {number} holds {}", kind(Some(item)))))?;
        }
    }
    if numbers[3] != [0.0, 0.0, 0.0, 1.0] {
        return Err((
            format!("{name} ends with the row {:?}, expected 0, 0, 0, 1", numbers[3]),
            "export the cameras again",
        ));
    }
    Ok(DMat4::from_cols_array_2d(&numbers).transpose())
}
