//! Finding the cameras' files, whatever the user pointed at.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::format::{CameraFormat, FORMATS, Files};
use crate::error::{Error, Result};

/// A reconstruction that was found.
pub(super) struct Located {
    /// Its format's place in [`FORMATS`].
    pub rank: usize,
    /// Its files.
    pub files: Files,
}

impl Located {
    /// Its format.
    pub fn format(&self) -> &'static dyn CameraFormat {
        FORMATS[self.rank]
    }
}

/// The reconstruction at a path to a folder or to one of its files.
///
/// # Errors
/// [`Error::Input`] when there is no complete one, naming what was looked for and what is missing.
pub(super) fn locate(path: &Path) -> Result<Located> {
    if path.is_file() {
        return at_file(path);
    }
    if !path.is_dir() {
        return Err(Error::input(path, "", "there is no such file or folder", "check the path"));
    }
    let mut found = all_in(path, |format| format.folders());
    let (rank, files) = if found.is_empty() { return Err(nothing_in(path)) } else { found.remove(0) };
    let mut files = files?;
    let others = found.into_iter().filter_map(|(_, files)| files.ok());
    let others: Vec<String> = others.map(|other| other.images.display().to_string()).collect();
    if !others.is_empty() {
        let (used, others) = (files.images.display(), others.join(" and "));
        files.notes.push(format!("{used}: read instead of {others}; to use that, point at the file itself"));
    }
    Ok(Located { rank, files })
}

/// What each format finds, in the order of the table.
fn all_in(
    path: &Path,
    folders: fn(&'static dyn CameraFormat) -> &'static [&'static str],
) -> Vec<(usize, Result<Files>)> {
    let of_format = |(rank, format): (usize, &&'static dyn CameraFormat)| {
        let of_folder = |below: &&str| {
            let folder = if below.is_empty() { path.to_path_buf() } else { path.join(below) };
            format.in_folder(&folder, &names_in(&folder))
        };
        folders(*format).iter().find_map(of_folder).map(|files| (rank, files))
    };
    FORMATS.iter().enumerate().filter_map(of_format).collect()
}

/// The reconstruction that a named file belongs to. A file of no format stands for its folder.
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
            Err(Error::input(file, "", found, format!("point at {}", accepted())))
        }
    }
}

/// Whether a file is one of those that cameras are read from, by its content or, for COLMAP's, by its name.
pub fn is_camera_file(file: &Path) -> bool {
    file.is_file() && FORMATS.iter().any(|format| format.of_file(file).is_some())
}

/// Cameras that stand in a folder itself; they are not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct CamerasThere {
    /// The place of their format among those that are read: the first is the one with most to tell.
    pub format: usize,
    /// Bytes of the file with the poses: more bytes, more photos.
    pub bytes: u64,
}

/// The cameras in a folder, not in those below it.
pub fn cameras_in(folder: &Path) -> Option<CamerasThere> {
    let (format, files) = all_in(folder, |_| &[""]).into_iter().find(|(_, files)| files.is_ok())?;
    let bytes = std::fs::metadata(files.ok()?.images).map_or(0, |file| file.len());
    Some(CamerasThere { format, bytes })
}

/// What can be given as cameras, for people.
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
    let found = format!("no cameras in it, nor in {} below it", folders.join(", "));
    let remedy = format!("point at {}; other programs can export to one of these", accepted());
    Error::input(path, "", found, remedy)
}

/// Names of the files in a folder, sorted.
fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort_unstable();
    names
}

/// A file is recognised by this much of its beginning.
const BEGINNING: u64 = 1 << 16;
/// So many files of a folder are looked into: those of a reconstruction are few.
const LOOKED_INTO: usize = 32;

/// The beginning of a file, without what some editors put before the first sign; empty where it cannot be read.
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

/// The files of a folder whose names end so and whose content `is_one`: those called as one of `usual` first.
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
