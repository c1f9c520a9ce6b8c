//! The search for the cameras' files at a path given by the user.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::format::{CameraFormat, FORMATS, ReconstructionFiles};
use crate::error::{Error, Result};

/// A reconstruction that was found.
pub(super) struct Located {
    /// The index of its format in [`FORMATS`].
    pub rank: usize,
    /// The files of the reconstruction.
    pub files: ReconstructionFiles,
}

impl Located {
    /// Returns its format.
    pub fn format(&self) -> &'static dyn CameraFormat {
        FORMATS[self.rank]
    }
}

/// Finds the reconstruction at a path to a folder or to one of its files.
///
/// # Errors
/// Returns [`Error::Input`] when there is no complete reconstruction, with what was looked for and what is missing.
pub(super) fn locate(path: &Path) -> Result<Located> {
    if path.is_file() {
        return at_file(path);
    }
    if !path.is_dir() {
        return Err(Error::input(path, "", "this file or folder does not exist", "check the path"));
    }
    let mut found = all_in(path, |format| format.folders());
    let (rank, files) = if found.is_empty() { return Err(nothing_in(path)) } else { found.remove(0) };
    let mut files = files?;
    let others = found.into_iter().filter_map(|(_, files)| files.ok());
    let others: Vec<String> = others.map(|other| other.images.display().to_string()).collect();
    if !others.is_empty() {
        let (used, others) = (files.images.display(), others.join(" and "));
        files.notes.push(format!("{used}: read instead of {others}; to use that, give the file itself"));
    }
    Ok(Located { rank, files })
}

/// Collects the files that each format finds, in the order of the table.
fn all_in(
    path: &Path,
    folders: fn(&'static dyn CameraFormat) -> &'static [&'static str],
) -> Vec<(usize, Result<ReconstructionFiles>)> {
    // Most formats look into the same folder.
    let mut listed: BTreeMap<PathBuf, Vec<String>> = BTreeMap::new();
    let mut found = Vec::new();
    for (rank, format) in FORMATS.iter().enumerate() {
        let files = folders(*format).iter().find_map(|below| {
            let folder = if below.is_empty() { path.to_path_buf() } else { path.join(below) };
            let names = listed.entry(folder.clone()).or_insert_with(|| names_in(&folder));
            format.in_folder(&folder, names)
        });
        found.extend(files.map(|files| (rank, files)));
    }
    found
}

/// Finds the reconstruction to which a given file belongs. A file of no known format stands for its folder.
fn at_file(file: &Path) -> Result<Located> {
    for (rank, format) in FORMATS.iter().enumerate() {
        if let Some(files) = format.of_file(file) {
            return Ok(Located { rank, files: files? });
        }
    }
    let folder = file.parent().unwrap_or(Path::new(""));
    match all_in(folder, |_| &[""]).into_iter().next() {
        Some((rank, Ok(files))) => Ok(Located { rank, files }),
        _ => {
            let found = "it holds no cameras of a format that is read here";
            Err(Error::input(file, "", found, format!("give {}", accepted())))
        }
    }
}

/// Returns true for a file from which cameras can be read, judged by its content or, for COLMAP's, by its name.
pub fn is_camera_file(file: &Path) -> bool {
    file.is_file() && FORMATS.iter().any(|format| format.of_file(file).is_some())
}

/// Cameras that were found in a folder, without being read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct CamerasThere {
    /// The index of their format in the table; the first format contains most information.
    pub format: usize,
    /// The size in bytes of the file with the poses, as a measure of the number of photos.
    pub bytes: u64,
}

/// Finds the cameras in a folder, without the folders below it.
pub fn cameras_in(folder: &Path) -> Option<CamerasThere> {
    let (format, files) = all_in(folder, |_| &[""]).into_iter().find(|(_, files)| files.is_ok())?;
    let bytes = std::fs::metadata(files.ok()?.images).map_or(0, |file| file.len());
    Some(CamerasThere { format, bytes })
}

/// Returns a list of the accepted files for messages and help.
pub fn accepted() -> &'static str {
    static ACCEPTED: std::sync::LazyLock<String> = std::sync::LazyLock::new(|| {
        let all: Vec<&str> = FORMATS.iter().map(|format| format.accepted()).collect();
        all.join("; or ")
    });
    &ACCEPTED
}

fn nothing_in(path: &Path) -> Error {
    let mut folders: Vec<&str> = FORMATS.iter().flat_map(|format| format.folders()).copied().collect();
    folders.retain(|folder| !folder.is_empty());
    let found = format!("no cameras in this folder or below it in {}", folders.join(", "));
    let remedy = format!("give {}; other programs can export to one of these", accepted());
    Error::input(path, "", found, remedy)
}

/// Lists the names of the files in a folder, sorted.
fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort_unstable();
    names
}

/// The number of bytes at a file's beginning by which it is recognised.
const BEGINNING: u64 = 1 << 16;
/// The most files of a folder whose content is read; a reconstruction has only few files.
const LOOKED_INTO: usize = 32;

/// Reads the beginning of a file, without a byte order mark. Returns no bytes where the file cannot be read.
pub(super) fn beginning(file: &Path) -> Vec<u8> {
    let mut bytes = Vec::new();
    // A pipe would be waited for without end.
    if file.is_file()
        && let Ok(file) = File::open(file)
    {
        let _ = file.take(BEGINNING).read_to_end(&mut bytes);
    }
    bytes.strip_prefix(b"\xEF\xBB\xBF").map(<[u8]>::to_vec).unwrap_or(bytes)
}

/// Lists the files of a folder with this ending whose content satisfies `is_one`. Files with one of the `usual` names
/// come first.
pub(super) fn recognised(
    folder: &Path,
    names: &[String],
    ending: &str,
    usual: &[&str],
    is_one: fn(&[u8]) -> bool,
) -> Vec<PathBuf> {
    let place = |name: &str| usual.iter().position(|usual| *usual == name).unwrap_or(usual.len());
    let mut named: Vec<&String> = names.iter().filter(|name| name.to_lowercase().ends_with(ending)).collect();
    named.sort_by_key(|name| place(name));
    let files = named.into_iter().take(LOOKED_INTO).map(|name| folder.join(name));
    files.filter(|file| is_one(&beginning(file))).collect()
}
