//! Which files a plant consists of, as far as that is known without reading it.

use std::path::{Path, PathBuf};

use crate::io::stamp::Stamp;

/// The endings of the files that plants refer to: other sub-objects, vertex data, included files and pictures.
const ENDINGS: [&str; 12] =
    ["plant", "gltf", "glb", "bin", "ray", "inc", "png", "jpg", "jpeg", "tif", "tiff", "webp"];

/// Takes the stamp of the file of a plant and of all files in and below its folder that it may refer to, without those in the
/// folders `without`.
pub fn plant_stamp(file: &Path, without: &[PathBuf]) -> Stamp {
    let itself = Stamp::from_path(file);
    let Some(folder) = file.parent().filter(|folder| folder.is_dir()) else { return itself };
    let is_meant = |path: &Path| {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        path.is_dir() || ending.is_some_and(|ending| ENDINGS.contains(&ending.as_str()))
    };
    let is_own = |path: &Path| path.canonicalize().is_ok_and(|path| without.contains(&path));
    itself.and(Stamp::of_some(folder, &|path| is_meant(path) && !(path.is_dir() && is_own(path))))
}
