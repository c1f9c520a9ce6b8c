//! Polycam's raw data: a JSON file per keyframe in `keyframes/corrected_cameras`, or `keyframes/cameras` before the program corrected them.
//!
//! `t_00` to `t_23` are the rows of camera to world, in OpenGL's axes (y up, looking along -z) and a world with y up; `fx`, `fy`, `cx`, `cy`
//! are those of the picture, `width` x `height`, as ARKit took it. The photo has the name of the file. Source: nerfstudio's converter. Not tried with
//! the program itself.

use std::path::{Path, PathBuf};

use glam::{DMat3, DVec3};
use serde_json::Value;

use super::assembly::Assembly;
use super::foreign_text::{json_number, read_value};
use super::format::CameraFormat;
use super::photo_paths::{Without, photo_paths};
use super::pose::{CV_FROM_GL, pose_at, rotation_and_scale};
use super::raw::RawCamera;
use super::recognise::{beginning, folder_of, holds};
use super::reconstruction::ReconstructionFiles;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Lens, Pose};
use quadratura_base::task::Task;
use quadratura_files::text::Objection;

/// The format.
pub(super) struct Polycam;

const REMEDY: &str = "export the raw data of the capture again";

impl CameraFormat for Polycam {
    fn accepted(&self) -> &'static str {
        "Polycam's raw data, with keyframes/corrected_cameras/*.json"
    }

    fn program(&self) -> &'static str {
        "Polycam"
    }

    fn folders(&self) -> &'static [&'static str] {
        &["", "keyframes/corrected_cameras", "corrected_cameras", "keyframes/cameras", "cameras"]
    }

    fn kept_and_lost(&self) -> [&'static str; 2] {
        [
            "pinhole cameras of keyframes, in a world with y up; not tried with the program itself",
            "depth maps, confidence",
        ]
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["json"]
    }

    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>> {
        if !is_one(&beginning(file)) {
            return None;
        }
        let (folder, names) = folder_of(file);
        all(folder, &names).map(Ok)
    }

    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>> {
        all(folder, names).map(Ok)
    }

    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, task: &Task) -> Result<()> {
        let mut frames = Vec::new();
        for (done, file) in files.others.iter().enumerate() {
            task.step("read poses", done as u64, files.others.len() as u64)?;
            match read_value(file, "expected a JSON object with \"t_00\"", REMEDY) {
                Ok(frame) if frame.get("t_00").is_some() => frames.push((file, frame)),
                // Other descriptions are beside those of the cameras.
                Ok(Value::Object(_)) => (),
                Ok(_) => assembly.refused_file(Error::input(file, "", "no JSON object", REMEDY)),
                Err(error) => assembly.refused_file(error),
            }
        }
        let stems: Vec<String> = frames.iter().map(|(file, _)| stem(file)).collect();
        let stems: Vec<&str> = stems.iter().map(String::as_str).collect();
        let photos = photo_paths(&stems, &folders_of_pictures(&files.images), Without::Any);
        for ((file, frame), photo) in frames.iter().zip(&photos) {
            let place = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
            assembly.photo(place, &photo.name, camera(frame), pose(frame));
        }
        Ok(())
    }
}

fn is_one(beginning: &[u8]) -> bool {
    beginning.trim_ascii_start().first() == Some(&b'{')
        && ["\"t_00\"", "\"t_23\"", "\"fx\""].iter().all(|key| holds(beginning, key))
}

/// Returns all descriptions in a folder; `None` where the first is none.
fn all(folder: &Path, names: &[String]) -> Option<ReconstructionFiles> {
    let is_json = |name: &&String| name.to_lowercase().ends_with(".json");
    let others: Vec<PathBuf> = names.iter().filter(is_json).map(|name| folder.join(name)).collect();
    // A capture has hundreds, of which a few tell what they are.
    let first = others.iter().take(4).find(|file| is_one(&beginning(file)))?.clone();
    Some(ReconstructionFiles { others, ..ReconstructionFiles::one(&first) })
}

/// Returns where the program puts the pictures: `corrected_images` beside `corrected_cameras`, `images` beside `cameras`.
fn folders_of_pictures(file: &Path) -> Vec<PathBuf> {
    let cameras = file.parent().unwrap_or(Path::new(""));
    let name = cameras.file_name().unwrap_or_default().to_string_lossy().replace("cameras", "images");
    vec![cameras.with_file_name(name), cameras.to_path_buf()]
}

fn stem(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn camera(frame: &Value) -> Result<RawCamera, Objection> {
    let number = |key: &str| json_number(frame.get(key), key);
    let side = |key: &str| match number(key)? {
        side if (1.0..1e9).contains(&side) && side.fract() == 0.0 => Ok(side as u64),
        side => Err((format!("{key} is {side}, expected a number of pixels"), REMEDY)),
    };
    Ok(RawCamera {
        size: [side("width")?, side("height")?],
        focal: [number("fx")?, number("fy")?],
        centre: [number("cx")?, number("cy")?],
        lens: Lens::None,
    })
}

fn pose(frame: &Value) -> Result<Pose, Objection> {
    let number = |row: usize, column: usize| {
        let key = format!("t_{row}{column}");
        json_number(frame.get(&key), &key)
    };
    let row = |row: usize| Ok::<_, Objection>(DVec3::new(number(row, 0)?, number(row, 1)?, number(row, 2)?));
    // Its rows become the columns of the transpose.
    let (gl_from_world, _) = rotation_and_scale(DMat3::from_cols(row(0)?, row(1)?, row(2)?), "t_00 to t_22")?;
    pose_at(CV_FROM_GL * gl_from_world, DVec3::new(number(0, 3)?, number(1, 3)?, number(2, 3)?))
}
