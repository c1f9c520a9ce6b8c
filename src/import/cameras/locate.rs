//! The search for the cameras' files at a path given by the user.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use super::format::CameraFormat;
use super::formats::{FormatId, formats};
use super::photo_name::short;
use super::recognise::{beginning, names_in};
use super::reconstruction::ReconstructionFiles;
use quadratura_base::error::{Error, Result};
use quadratura_files::text::{lines_of, not_utf16};

/// A reconstruction that was found.
pub(super) struct Located {
    /// Its format.
    pub format: FormatId,
    /// The files of the reconstruction.
    pub files: ReconstructionFiles,
}

/// Finds the reconstruction at a path to a folder or to one of its files.
///
/// # Errors
/// Returns [`Error::Input`] when there is no complete reconstruction, with what was looked for and what is missing, and
/// [`Error::Io`] when the file or folder cannot be read.
pub(super) fn locate(path: &Path) -> Result<Located> {
    if path.is_file() {
        return at_file(path);
    }
    if !path.is_dir() {
        let found = match path.exists() {
            true => "this is neither a file nor a folder",
            false if path.as_os_str().is_empty() => "the path is empty",
            false => "this file or folder does not exist",
        };
        let above = path.ancestors().skip(1).take(2).find(|above| above.is_dir() && locate(above).is_ok());
        let remedy = match above {
            Some(above) => format!("check the path; there are cameras in {}", above.display()),
            None => format!("check the path; give {}", accepted()),
        };
        return Err(Error::input(path, "", found, remedy));
    }
    let mut found = all_in(path, |format| format.folders());
    let (format, files) = if found.is_empty() { return defective_in(path) } else { found.remove(0) };
    let mut files = files?;
    let others = found.into_iter().filter_map(|(_, files)| files.ok());
    files.note_instead_of(&others.map(|other| other.images).collect::<Vec<_>>());
    Ok(Located { format, files })
}

/// Collects the files that each format finds, in the order of the table.
fn all_in(
    path: &Path,
    folders: fn(&'static dyn CameraFormat) -> &'static [&'static str],
) -> Vec<(FormatId, Result<ReconstructionFiles>)> {
    // Most formats look into the same folder.
    let mut listed: BTreeMap<PathBuf, Vec<String>> = BTreeMap::new();
    let mut found = Vec::new();
    for id in FormatId::all() {
        let files = folders(id.format()).iter().find_map(|below| {
            let folder = folder_below(path, below);
            let names = listed.entry(folder.clone()).or_insert_with(|| names_in(&folder));
            id.format().in_folder(&folder, names)
        });
        found.extend(files.map(|files| (id, files)));
    }
    found
}

/// Finds a file that has the usual name of a format in a folder in which no format was recognised.
///
/// # Errors
/// Returns an error when there is no such file.
fn defective_in(path: &Path) -> Result<Located> {
    std::fs::read_dir(path).map_err(Error::io(path, "read the folder"))?;
    for format in FormatId::all() {
        for folder in format.format().folders().iter().map(|below| folder_below(path, below)) {
            let mut files =
                names_in(&folder).into_iter().map(|name| folder.join(name)).filter(|it| it.is_file());
            if let Some(files) = files.find_map(|file| format.format().of_file(&file)) {
                return Ok(Located { format, files: files? });
            }
        }
    }
    Err(nothing_in(path))
}

/// Joins a folder and a path below it; an empty path gives the folder without a trailing slash.
fn folder_below(folder: &Path, below: &str) -> PathBuf {
    if below.is_empty() { folder.to_path_buf() } else { folder.join(below) }
}

/// Finds the reconstruction to which a given file belongs. A file of no known format is refused, also beside a reconstruction:
/// that may be an older one.
fn at_file(file: &Path) -> Result<Located> {
    for format in FormatId::all() {
        if let Some(files) = format.format().of_file(file) {
            return Ok(Located { format, files: files? });
        }
    }
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let beside = all_in(folder, |_| &[""]).into_iter().next();
    let beside = beside.and_then(|(format, files)| Some(Located { format, files: files.ok()? }));
    let there = match beside {
        Some(located) if located.files.clone().all().iter().any(|known| known == file) => return Ok(located),
        Some(located) => format!("; there are cameras in {} beside it", located.files.images.display()),
        None => String::new(),
    };
    File::open(file).map_err(Error::io(file, "read it"))?;
    let found = format!("{}, expected cameras", content_of(&beginning(file)));
    Err(Error::input(file, "", found, format!("give {}{there}", accepted())))
}

/// Describes the content of a file of no known format.
fn content_of(beginning: &[u8]) -> String {
    if beginning.is_empty() {
        return "it is empty".into();
    }
    if not_utf16(beginning).is_some() {
        return "it is text in UTF-16 or a binary file of another kind".into();
    }
    let text = String::from_utf8_lossy(beginning);
    match lines_of(&text).map(str::trim).find(|line| !line.is_empty()) {
        Some(line) if !line.contains(|c: char| c.is_control() || c == char::REPLACEMENT_CHARACTER) => {
            format!("it begins with the line {}", short(line))
        }
        Some(_) => "it is a binary file of another kind".into(),
        None => "it has only empty lines".into(),
    }
}

/// Returns true for a file from which cameras can be read, judged by its content or by its name.
pub fn is_camera_file(file: &Path) -> bool {
    file.is_file() && formats().any(|format| format.of_file(file).is_some())
}

/// Cameras that were found in a folder, without being read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct CamerasThere {
    /// Their format; of several, the first of the table of formats is read.
    pub format: FormatId,
    /// The size in bytes of the file with the poses, as a measure of the number of photos.
    pub bytes: u64,
}

/// Finds the cameras in a folder, without the folders below it.
pub fn cameras_in(folder: &Path) -> Option<CamerasThere> {
    let (format, files) = all_in(folder, |_| &[""]).into_iter().find(|(_, files)| files.is_ok())?;
    let bytes = std::fs::metadata(files.ok()?.images).map_or(0, |file| file.len());
    Some(CamerasThere { format, bytes })
}

/// Lists the extensions of the files of all formats, in lower case.
pub fn extensions() -> Vec<&'static str> {
    let mut all: Vec<&str> = formats().flat_map(|format| format.extensions()).copied().collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// Returns a list of the accepted files for messages and help.
pub fn accepted() -> String {
    let all: Vec<&str> = formats().map(|format| format.accepted()).collect();
    all.join("; or ")
}

/// Names the programs whose files are read, each once.
pub fn programs() -> String {
    let mut names: Vec<&str> = Vec::new();
    for name in formats().map(|format| format.program()) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let last = names.pop().unwrap_or_default();
    format!("{} or {last}", names.join(", "))
}

/// Lists all formats: what the files are called, what is read of them, and what is not.
pub fn described() -> Vec<[&'static str; 3]> {
    let of_format = |format: &'static dyn CameraFormat| {
        let [kept, lost] = format.kept_and_lost();
        [format.accepted(), kept, lost]
    };
    formats().map(of_format).collect()
}

fn nothing_in(path: &Path) -> Error {
    let mut folders: Vec<&str> = formats().flat_map(|format| format.folders()).copied().collect();
    folders.retain(|folder| !folder.is_empty());
    let found = format!("no cameras in this folder or below it in {}", folders.join(", "));
    let remedy = format!("give {}; other programs can export to one of these", accepted());
    Error::input(path, "", found, remedy)
}
