//! How files of a format are recognised: by their names, and by how they begin.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

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

/// Returns true for a file with one of these names, in upper or lower case.
pub(super) fn has_name(file: &Path, names: &[&str]) -> bool {
    file.file_name().is_some_and(|name| names.iter().any(|usual| name.eq_ignore_ascii_case(usual)))
}

/// Returns true where the beginning of a file holds a text.
pub(super) fn holds(beginning: &[u8], text: &str) -> bool {
    beginning.windows(text.len()).any(|window| window == text.as_bytes())
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

/// Lists the names of the files in a folder, sorted.
pub fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort_unstable();
    names
}

/// Returns the folder that a file is in, with the names of its files, sorted.
pub fn folder_of(file: &Path) -> (&Path, Vec<String>) {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    (folder, names_in(folder))
}
