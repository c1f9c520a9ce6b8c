//! Reads and writes camera paths as JSON files.

use std::path::Path;

use glam::DVec3;
use serde_json::Value;

use quadratura_base::error::{Error, Result};
use quadratura_document::camera_path::CameraPath;
use quadratura_files::atomic::write_atomically;
use quadratura_files::foreign_json::{first_no_number, parse_foreign_json};
use quadratura_files::json::{in_words, read_limited, to_json};
use quadratura_view::flight::Flight;

const LARGEST_PATH: u64 = 16 << 20;
const REMEDY: &str = "correct it; docs/formats.md describes camera paths";

/// A camera path that was read.
#[derive(Debug)]
pub struct ReadPath {
    /// The path, without the keyframes that are left out.
    pub path: CameraPath,
    /// Its flight.
    pub flight: Flight,
    /// The keyframes that are left out, because `NaN` or `Infinity` is in them; one error each.
    pub problems: Vec<Error>,
}

/// Reads a camera path and builds its flight. `up`, a direction in world space, is used where the file does
/// not give one.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] with line and column, or with the keyframe, where the file is not a camera
/// path or describes one that cannot be flown.
pub fn read_camera_path(file: &Path, up: DVec3) -> Result<ReadPath> {
    let text = read_limited(file, LARGEST_PATH, REMEDY.into())?;
    let (path, problems) = match parse_foreign_json(file, &text, REMEDY) {
        Ok(path) => (path, Vec::new()),
        Err(error) => without_bad_keyframes(file, &text).unwrap_or(Err(error))?,
    };
    match path.flight(up) {
        Ok(flight) => Ok(ReadPath { path, flight, problems }),
        Err((place, found)) => Err(Error::input(file, place, found, REMEDY)),
    }
}

/// Reads a path without the keyframes that hold what is no number; `None` where there are none.
fn without_bad_keyframes(file: &Path, text: &[u8]) -> Option<Result<(CameraPath, Vec<Error>)>> {
    let mut whole: Value = parse_foreign_json(file, text, REMEDY).ok()?;
    let keyframes = whole.get_mut("keyframes")?.as_array_mut()?;
    let (mut kept, mut problems) = (Vec::new(), Vec::new());
    for (number, keyframe) in (1..).zip(std::mem::take(keyframes)) {
        match first_no_number(&keyframe) {
            None => kept.push(keyframe),
            Some((path, word)) => {
                let found = format!("{path} holds {word}, expected a number: this keyframe is left out");
                problems.push(Error::input(file, format!("keyframe {number}"), found, REMEDY));
            }
        }
    }
    *keyframes = kept;
    if problems.is_empty() {
        return None;
    }
    let path = serde_json::from_value(whole);
    Some(
        path.map(|path| (path, problems))
            .map_err(|error| Error::input(file, "", in_words(&error.to_string()), REMEDY)),
    )
}

/// Writes a camera path, whole or not at all.
///
/// # Errors
/// [`Error::Io`]; an old file stays.
pub fn write_camera_path(file: &Path, path: &CameraPath) -> Result<()> {
    write_atomically(file, &to_json(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATH: &str = r#"{
  "version": 1,
  "size": [960, 540],
  "fps": 10,
  "up": [0, 0, -1],
  "keyframes": [
    {"t": 0, "position": [0, -8, 2], "look_at": [0, 0, 3], "fov": 55},
    {"t": 3, "position": [6, -6, 2], "look_at": [0, 0, 3], "K": [[500, 0, 480], [0, 500, 270], [0, 0, 1]]}
  ]
}
"#;

    fn read(text: &str) -> Result<ReadPath> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        read_camera_path(file.path(), DVec3::Z)
    }

    #[test]
    fn a_keyframe_that_holds_no_number_is_left_out_by_name_and_the_others_are_flown() {
        let bad = r#"{"t": 1, "position": [0, NaN, 2], "look_at": [0, 0, 3], "fov": 55},"#;
        let text = PATH.replacen("    {\"t\": 3", &format!("    {bad}\n    {{\"t\": 3"), 1);
        let ReadPath { path, problems, .. } = read(&text).unwrap();
        assert_eq!(path, read(PATH).unwrap().path);
        let told = problems[0].to_string();
        assert!(told.contains("keyframe 2: position[1] holds NaN") && problems.len() == 1, "{told}");
        let fps = read(&PATH.replace("\"fps\": 10", "\"fps\": Infinity")).unwrap_err().to_string();
        assert!(fps.contains("line 4 column 17: Infinity, expected a number"), "{fps}");
    }

    #[test]
    fn a_path_is_read_and_its_own_up_holds() {
        let ReadPath { path, flight, .. } = read(PATH).unwrap();
        assert_eq!((path.fps, path.size, flight.frames(path.fps).len()), (10.0, [960, 540], 31));
        let down = flight.at(1.0).1.rotation.transpose() * DVec3::Y;
        assert!(down.z > 0.9, "what is up in the file is up in the picture: {down}");
    }

    #[test]
    fn a_written_path_is_read_unchanged() {
        let path = read(PATH).unwrap().path;
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("path.json");
        write_camera_path(&file, &path).unwrap();
        assert_eq!(read_camera_path(&file, DVec3::Z).unwrap().path, path);
    }

    #[test]
    fn errors_name_the_place() {
        let misspelt = read(&PATH.replace("look_at", "lookat")).unwrap_err().to_string();
        assert!(misspelt.contains("line 7") && misspelt.contains("lookat"), "{misspelt}");
        let wide = read(&PATH.replace("\"fov\": 55", "\"fov\": 500")).unwrap_err().to_string();
        assert!(wide.contains("keyframe 1") && wide.contains("500 degrees"), "{wide}");
    }
}
