//! Detects whether a file or folder has changed, without reading its content.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use super::hash::{Hashing, hash_file};
use quadratura_base::error::Result;

/// Sub-folders are searched down to this depth, because links may form circles.
const DEEPEST: usize = 16;
/// At most this many files of a folder are looked at; enough for a large survey, and still fast.
const MOST_FILES: usize = 100_000;

/// Paths, lengths in bytes and modification times of a file, or of all files of a folder.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Stamp(Vec<(PathBuf, u64, Option<SystemTime>)>);

impl Stamp {
    /// Takes the stamp of a file or folder as it is now; it is empty where nothing exists or nothing can be
    /// read.
    pub fn from_path(path: &Path) -> Self {
        let mut files = Vec::new();
        match path.is_dir() {
            true => gather(path, 0, &|_| true, &mut files),
            false => files.push(path.to_path_buf()),
        }
        Self::of_files(files)
    }

    /// Takes the stamp of those files of a folder that are meant; of its sub-folders those that are meant are searched.
    pub fn of_some(folder: &Path, is_meant: &dyn Fn(&Path) -> bool) -> Self {
        let mut files = Vec::new();
        gather(folder, 0, is_meant, &mut files);
        Self::of_files(files)
    }

    fn of_files(mut files: Vec<PathBuf>) -> Self {
        files.sort();
        Self(files.into_iter().filter_map(file_state).collect())
    }

    /// Returns whether no file was found.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the union of two stamps.
    pub fn and(mut self, other: Self) -> Self {
        self.0.extend(other.0);
        self
    }

    /// Returns a hash of the stamp that does not depend on where the document is: names relative to
    /// `document`, lengths, and times in nanoseconds since 1970.
    pub fn token(&self, document: &Path) -> String {
        let mut hashing = Hashing::default();
        for (file, bytes, changed) in &self.0 {
            let since = changed.and_then(|changed| changed.duration_since(UNIX_EPOCH).ok());
            hashing.add(below(document, file).as_bytes());
            hashing.add(&bytes.to_le_bytes());
            hashing.add(&since.map_or(0, |since| since.as_nanos()).to_le_bytes());
        }
        hashing.hash()
    }

    /// Returns a hash of the content of the stamp's files, which are read for it.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Io`] when one of them cannot be read or no longer exists.
    pub fn content(&self, document: &Path) -> Result<String> {
        let mut hashing = Hashing::default();
        for (file, _, _) in &self.0 {
            hashing.add(below(document, file).as_bytes());
            hashing.add(hash_file(file)?.as_bytes());
        }
        Ok(hashing.hash())
    }
}

/// Returns the path of a document's file relative to the document; empty for a document that is a single
/// file.
fn below(document: &Path, file: &Path) -> String {
    file.strip_prefix(document).unwrap_or(file).to_string_lossy().replace('\\', "/")
}

fn gather(folder: &Path, depth: usize, is_meant: &dyn Fn(&Path) -> bool, files: &mut Vec<PathBuf>) {
    let found = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    for path in found.take(MOST_FILES).filter(|path| is_meant(path)) {
        if files.len() >= MOST_FILES {
            return;
        }
        if !path.is_dir() {
            files.push(path);
        } else if depth < DEEPEST {
            gather(&path, depth + 1, is_meant, files);
        }
    }
}

fn file_state(file: PathBuf) -> Option<(PathBuf, u64, Option<SystemTime>)> {
    let metadata = fs::metadata(&file).ok()?;
    Some((file, metadata.len(), metadata.modified().ok()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stamp_changes_with_any_file_of_a_folder_and_its_content_does_not_depend_on_times() {
        let folder = tempfile::tempdir().unwrap();
        let document = folder.path().join("left.layers");
        fs::create_dir_all(document.join("of")).unwrap();
        fs::write(document.join("a.png"), "wall").unwrap();
        fs::write(document.join("of/b.png"), "door").unwrap();
        let before = Stamp::from_path(&document);
        let moved = folder.path().join("right.layers");
        fs::rename(&document, &moved).unwrap();
        assert!(Stamp::from_path(&document).is_empty());
        let after = Stamp::from_path(&moved);
        assert_eq!(before.token(&document), after.token(&moved), "the same wherever it lies");
        let content = after.content(&moved).unwrap();
        let inner = fs::File::options().append(true).open(moved.join("of/b.png")).unwrap();
        inner.set_modified(UNIX_EPOCH).unwrap();
        assert_ne!(Stamp::from_path(&moved).token(&moved), after.token(&moved));
        assert_eq!(Stamp::from_path(&moved).content(&moved).unwrap(), content);
        fs::write(moved.join("of/b.png"), "doors").unwrap();
        assert_ne!(Stamp::from_path(&moved).content(&moved).unwrap(), content);
    }
}
