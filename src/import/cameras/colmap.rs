//! COLMAP's three files, text or binary, as one format.

use std::path::{Path, PathBuf};

use super::assembly::Assembly;
use super::format::CameraFormat;
use super::reconstruction::ReconstructionFiles;
use super::rigs::Rigs;
use super::{binary, text};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;

/// The format; [`text`] and [`binary`] are its readers.
pub(super) struct Colmap;

impl CameraFormat for Colmap {
    fn accepted(&self) -> &'static str {
        "COLMAP's cameras and images files, .bin or .txt, or a folder above them such as sparse/0"
    }

    fn program(&self) -> &'static str {
        "COLMAP"
    }

    fn folders(&self) -> &'static [&'static str] {
        &["", "sparse", "sparse/0", "0"]
    }

    fn kept_and_lost(&self) -> [&'static str; 2] {
        [
            "all lenses, poses (also of rigs), points with observations; not tried with the program itself, but with files that it wrote",
            "panoramas; colours of points; sensors other than cameras",
        ]
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["bin", "txt"]
    }

    /// Recognises files by their names, because the text files have no signature.
    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>> {
        let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().to_lowercase();
        let (stem, extension) = (part(file.file_stem()), part(file.extension()));
        let is_binary = extension == "bin";
        if !["cameras", "images", "points3d", "rigs", "frames"].contains(&stem.as_str())
            || !(is_binary || extension == "txt")
        {
            return None;
        }
        let folder = file.parent().unwrap_or(Path::new(""));
        Some(complete(folder, is_binary).ok_or_else(|| {
            let [cameras, images, _] = names(is_binary);
            let remedy = "give the folder or one of the files that COLMAP wrote \
                          (cameras, images, points3D; .bin or .txt)";
            Error::input(file, "", format!("{cameras} and {images} are not both beside it"), remedy)
        }))
    }

    fn in_folder(&self, folder: &Path, _names: &[String]) -> Option<Result<ReconstructionFiles>> {
        let mut files = complete(folder, true).or_else(|| complete(folder, false))?;
        files.notes.extend(other_models(&files.cameras));
        Some(Ok(files))
    }

    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, task: &Task) -> Result<()> {
        if let [rigs, frames] = files.others.as_slice() {
            let rigs = Rigs::read(rigs, frames, assembly, task)?;
            assembly.rigs(rigs);
        }
        if files.cameras.extension().is_some_and(|extension| extension == "bin") {
            binary::read(files, assembly, task)
        } else {
            text::read(files, assembly, task)
        }
    }
}

fn names(binary: bool) -> [&'static str; 3] {
    if binary {
        ["cameras.bin", "images.bin", "points3D.bin"]
    } else {
        ["cameras.txt", "images.txt", "points3D.txt"]
    }
}

/// Returns the files in `folder`, when cameras and photos are both there.
fn complete(folder: &Path, binary: bool) -> Option<ReconstructionFiles> {
    let [cameras, images, points] = names(binary).map(|name| folder.join(name));
    if !cameras.is_file() || !images.is_file() {
        return None;
    }
    let mut notes = Vec::new();
    if binary && folder.join("images.txt").is_file() {
        notes.push(format!("{}: read instead of images.txt beside it", images.display()));
    }
    let points = points.is_file().then_some(points);
    let rigs =
        ["rigs", "frames"].map(|name| folder.join(name).with_extension(if binary { "bin" } else { "txt" }));
    let others = match rigs.each_ref().map(|file| file.is_file()) {
        [true, true] => rigs.to_vec(),
        [false, false] => Vec::new(),
        [has_rigs, _] => {
            let (there, missing) = if has_rigs { (&rigs[0], &rigs[1]) } else { (&rigs[1], &rigs[0]) };
            notes.push(format!(
                "{}: not used without {}; the poses of {} are, which may be older",
                there.display(),
                missing.file_name().unwrap_or_default().display(),
                images.file_name().unwrap_or_default().display()
            ));
            Vec::new()
        }
    };
    Some(ReconstructionFiles { cameras, images, points, others, notes })
}

/// Returns a note about further parts of a reconstruction, which COLMAP numbers; only one part is read.
fn other_models(cameras: &Path) -> Option<String> {
    let folder = cameras.parent()?;
    let number: u32 = folder.file_name()?.to_str()?.parse().ok()?;
    let others: Vec<PathBuf> = (0..64)
        .filter(|&other| other != number)
        .filter_map(|other| Some(folder.parent()?.join(other.to_string())))
        .filter(|other| other.is_dir())
        .collect();
    let other = others.first()?;
    let (used, all) = (folder.display(), others.len() + 1);
    Some(format!(
        "{used}: the first of {all} separate reconstructions is used; to use another, give its folder, \
         for example {}",
        other.display()
    ))
}
