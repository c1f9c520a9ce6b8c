//! Which files a plant consists of, as far as that is known without reading it.

use std::path::Path;

use quadratura_files::stamp::Stamp;

/// The endings of the files that plants refer to: other sub-objects, vertex data and pictures.
const ENDINGS: [&str; 10] = ["plant", "gltf", "glb", "bin", "png", "jpg", "jpeg", "tif", "tiff", "webp"];

/// Takes the stamp of the file of a plant and of all files in its folder that it may refer to, and, unless it is `shallow`, of those
/// below it.
pub fn plant_stamp(file: &Path, shallow: bool) -> Stamp {
    let itself = Stamp::from_path(file);
    let Some(folder) = file.parent().filter(|folder| folder.is_dir()) else { return itself };
    let is_meant = |path: &Path| {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        match path.is_dir() {
            true => !shallow,
            false => ending.is_some_and(|ending| ENDINGS.contains(&ending.as_str())),
        }
    };
    itself.and(Stamp::of_some(folder, &is_meant))
}
