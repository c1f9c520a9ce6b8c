//! Hashes of files that are known from an earlier run, in `cache/hashes.json` of a project: a large site is not read again to see
//! that nothing has changed.
//!
//! A file counts as unchanged when its size and its time of change are. A file that was changed so shortly before it was hashed that
//! a second change could have the same time is not remembered; that is judged by the clock of the file system alone, because those
//! of machines differ.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::atomic::write_atomically;
use super::hash::hash_file;
use super::json::{read_json, to_json};
use quadratura_base::error::Result;

/// The file below the project's folder.
const FILE: &str = "cache/hashes.json";
/// The largest file that is read, in bytes: a million photos.
const LARGEST: u64 = 256 << 20;
/// Two changes of a file further apart than this have different times on every file system.
const TICK: Duration = Duration::from_secs(3);

/// A file as it was hashed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct HashedFile {
    bytes: u64,
    /// Nanoseconds since 1970.
    changed: u64,
    blake3: String,
}

/// What is known of the project that this program works on.
struct OpenProject {
    folder: PathBuf,
    /// By path relative to the project's folder.
    known: Option<BTreeMap<PathBuf, HashedFile>>,
    new: BTreeMap<PathBuf, HashedFile>,
    /// The file system's time before the first of the new ones was hashed.
    begun: Option<SystemTime>,
}

static PROJECT: Mutex<Option<OpenProject>> = Mutex::new(None);

/// Uses what is known of the files of the project in `folder`, until [`save`].
pub fn begin(folder: &Path) {
    *project() =
        Some(OpenProject { folder: folder.to_path_buf(), known: None, new: BTreeMap::new(), begun: None });
}

/// Saves what was learned. A failure only costs time, so it is not reported.
pub fn save() {
    let Some(ended) = project().take().filter(|ended| !ended.new.is_empty()) else { return };
    let file = ended.folder.join(FILE);
    // Others may have learned more meanwhile.
    let mut all: BTreeMap<PathBuf, HashedFile> = read_json(&file, LARGEST, "").unwrap_or_default();
    all.extend(ended.new);
    let _ = write_atomically(&file, &to_json(&all));
}

/// Returns the hash of a file as [`hash_file`] does, without reading it where it is known and has not changed.
///
/// # Errors
/// As [`hash_file`].
pub fn hash_unchanged(path: &Path) -> Result<String> {
    let state = state(path);
    if let (Some(known), Some(state)) = (known(path), state)
        && (known.bytes, known.changed) == state
    {
        return Ok(known.blake3);
    }
    let begun = begun();
    let hash = hash_file(path)?;
    if let (Some(state), Some(begun)) = (state, begun) {
        learn(path, state, begun, &hash);
    }
    Ok(hash)
}

/// Returns what an earlier run knew of a file.
fn known(path: &Path) -> Option<HashedFile> {
    let mut project = project();
    let project = project.as_mut()?;
    let read = || read_json(&project.folder.join(FILE), LARGEST, "").unwrap_or_default();
    let known = project.known.get_or_insert_with(read);
    known.get(relative(&project.folder, path)?).cloned()
}

/// Returns the file system's time before the first file was hashed; `None` where nothing can be remembered.
fn begun() -> Option<SystemTime> {
    let mut project = project();
    let project = project.as_mut()?;
    if project.begun.is_none() {
        let cache = project.folder.join(FILE);
        let cache = cache.parent()?;
        fs::create_dir_all(cache).ok()?;
        let probe = tempfile::tempfile_in(cache).ok()?;
        project.begun = probe.metadata().ok()?.modified().ok();
    }
    project.begun
}

fn learn(path: &Path, (bytes, changed): (u64, u64), begun: SystemTime, hash: &str) {
    let Some(begun) = begun.duration_since(UNIX_EPOCH).ok().and_then(|begun| begun.checked_sub(TICK)) else {
        return;
    };
    let mut project = project();
    let Some(project) = project.as_mut().filter(|_| u128::from(changed) < begun.as_nanos()) else { return };
    if let Some(path) = relative(&project.folder, path) {
        let known = HashedFile { bytes, changed, blake3: hash.to_owned() };
        project.new.insert(path.to_path_buf(), known);
    }
}

/// Returns a path relative to the project's folder, as every machine knows it. Files elsewhere are named in full.
fn relative<'a>(folder: &Path, path: &'a Path) -> Option<&'a Path> {
    let relative = path.strip_prefix(folder).ok();
    relative.or_else(|| path.is_absolute().then_some(path))
}

/// Returns size and time of change.
fn state(path: &Path) -> Option<(u64, u64)> {
    let metadata = fs::metadata(path).ok()?;
    let changed = metadata.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
    Some((metadata.len(), u64::try_from(changed.as_nanos()).ok()?))
}

fn project() -> MutexGuard<'static, Option<OpenProject>> {
    // What is known stays true after a panic elsewhere.
    PROJECT.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_old_file_is_not_read_again_and_one_that_has_just_changed_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let write = |name: &str, text: &str, age: u64| {
            fs::write(path(name), text).unwrap();
            let changed = SystemTime::now() - Duration::from_secs(age);
            fs::File::options().append(true).open(path(name)).unwrap().set_modified(changed).unwrap();
        };
        write("old", "wall", 60);
        write("new", "wall", 0);
        begin(folder.path());
        let hash = hash_unchanged(&path("old")).unwrap();
        assert_eq!(hash_unchanged(&path("new")).unwrap(), hash);
        save();
        let before = fs::metadata(path("old")).unwrap().modified().unwrap();
        // The same size and time: this is what is not noticed, and so shows that nothing was read.
        fs::write(path("old"), "door").unwrap();
        fs::File::options().append(true).open(path("old")).unwrap().set_modified(before).unwrap();
        fs::write(path("new"), "door").unwrap();
        begin(folder.path());
        assert_eq!(hash_unchanged(&path("old")).unwrap(), hash);
        assert_ne!(hash_unchanged(&path("new")).unwrap(), hash);
        write("old", "door", 30);
        assert_ne!(hash_unchanged(&path("old")).unwrap(), hash, "another time");
        save();
        assert_eq!(hash_unchanged(&path("old")).unwrap(), hash_file(path("old")).unwrap());
    }
}
