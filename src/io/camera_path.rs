//! Reads and writes camera paths as JSON files.

use std::path::Path;

use glam::DVec3;

use super::atomic::write_atomically;
use super::json::{read_json, to_json};
use crate::document::camera_path::CameraPath;
use crate::error::{Error, Result};
use crate::projection::flight::Flight;

const LARGEST_PATH: u64 = 16 << 20;
const REMEDY: &str = "correct it; docs/formats.md describes camera paths";

/// Reads a camera path and builds its flight. `up`, a direction in world space, is used where the file does
/// not give one.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] with line and column, or with the keyframe, where the file is not a camera
/// path or describes one that cannot be flown.
pub fn read_camera_path(file: &Path, up: DVec3) -> Result<(CameraPath, Flight)> {
    let path: CameraPath = read_json(file, LARGEST_PATH, REMEDY)?;
    match path.flight(up) {
        Ok(flight) => Ok((path, flight)),
        Err((place, found)) => Err(Error::input(file, place, found, REMEDY)),
    }
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

    fn read(text: &str) -> Result<(CameraPath, Flight)> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        read_camera_path(file.path(), DVec3::Z)
    }

    #[test]
    fn a_path_is_read_and_its_own_up_holds() {
        let (path, flight) = read(PATH).unwrap();
        assert_eq!((path.fps, path.size, flight.frames(path.fps).len()), (10.0, [960, 540], 31));
        let down = flight.at(1.0).1.rotation.transpose() * DVec3::Y;
        assert!(down.z > 0.9, "what is up in the file is up in the picture: {down}");
    }

    #[test]
    fn a_written_path_is_read_unchanged() {
        let (path, _) = read(PATH).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("path.json");
        write_camera_path(&file, &path).unwrap();
        assert_eq!(read_camera_path(&file, DVec3::Z).unwrap().0, path);
    }

    #[test]
    fn errors_name_the_place() {
        let misspelt = read(&PATH.replace("look_at", "lookat")).unwrap_err().to_string();
        assert!(misspelt.contains("line 7") && misspelt.contains("lookat"), "{misspelt}");
        let wide = read(&PATH.replace("\"fov\": 55", "\"fov\": 500")).unwrap_err().to_string();
        assert!(wide.contains("keyframe 1") && wide.contains("500 degrees"), "{wide}");
    }
}
