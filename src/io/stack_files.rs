//! Records the files of one version of a stack as they were written, and finds out which have changed.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;
use std::time::UNIX_EPOCH;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use quadratura_base::error::{Error, Result};
use quadratura_files::hash::{hash_bytes, hash_file};
use quadratura_files::json::{read_json, to_json};

/// The name of the record in the folder that it describes.
pub const RECORD: &str = "files.json";

/// Limit in bytes; a record has about 100 bytes per file, and a stack has thousands of files at most.
const LARGEST_RECORD: u64 = 64 << 20;

/// The record of one version's files.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct StackFiles {
    /// BLAKE3 of the `stack.json` that names them.
    pub stack: String,
    /// The files by name.
    pub files: BTreeMap<String, FileRecord>,
}

/// Returns the hash of a stack's file as it was written; that of its content where there is no record, and an empty one where it
/// cannot be read.
pub fn recorded_hash(file: &Path) -> String {
    let record = file.parent().and_then(StackFiles::read);
    let name = file.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let recorded = record.and_then(|record| Some(record.files.get(name)?.blake3.clone()));
    recorded.unwrap_or_else(|| hash_file(file).unwrap_or_default())
}

/// Size and hash of a file as it was written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileRecord {
    /// Size in bytes.
    pub bytes: u64,
    /// BLAKE3 of its content.
    pub blake3: String,
}

/// The state of a file compared with the record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileState {
    /// The file is as it was written.
    Intact,
    /// The file has other content, or is not in the record.
    Changed,
    /// The file no longer exists.
    Missing,
}

impl StackFiles {
    /// Flushes every file in `folder` to disk, in parallel, and records it.
    ///
    /// # Errors
    /// [`Error::Io`], for instance on a full disk.
    pub fn sync_and_record(folder: &Path) -> Result<Self> {
        let files = names_in(folder)?
            .into_par_iter()
            .map(|name| {
                let path = folder.join(&name);
                let file = File::open(&path).map_err(Error::io(&path, "open it"))?;
                file.sync_all().map_err(Error::io(&path, "write it to disk"))?;
                let bytes = file.metadata().map_err(Error::io(&path, "read its size"))?.len();
                Ok((name, FileRecord { bytes, blake3: hash_file(&path)? }))
            })
            .collect::<Result<_>>()?;
        Ok(Self { stack: String::new(), files })
    }

    /// Reads the record in `folder`; `None` where there is no readable one.
    pub fn read(folder: &Path) -> Option<Self> {
        read_json(&folder.join(RECORD), LARGEST_RECORD, "").ok()
    }

    /// Returns a short name for these files together with the content `stack` of `stack.json`: the same
    /// content always gives the same name.
    pub fn version(&self, stack: &[u8]) -> String {
        let mut text = to_json(self);
        text.extend_from_slice(stack);
        hash_bytes(&text)[..VERSION_DIGITS].to_owned()
    }

    /// Compares the file `name` in `folder` with the record. Its size and modification time are checked
    /// first, its content only if the time is not the one in `stamps`. A file that was changed without
    /// changing its size and whose old time was restored to the nanosecond therefore counts as intact.
    ///
    /// # Errors
    /// [`Error::Io`] when it exists and cannot be read.
    pub fn state(&self, folder: &Path, name: &str, stamps: &FileTimes) -> Result<FileState> {
        let path = folder.join(name);
        let Ok(metadata) = fs::symlink_metadata(&path) else { return Ok(FileState::Missing) };
        let Some(written) = self.files.get(name) else { return Ok(FileState::Changed) };
        if !metadata.is_file() || metadata.len() != written.bytes {
            return Ok(FileState::Changed);
        }
        if stamps.0.get(&written.blake3).is_some_and(|stamp| modified_ns(&metadata) == Some(*stamp)) {
            return Ok(FileState::Intact);
        }
        Ok(if hash_file(&path)? == written.blake3 { FileState::Intact } else { FileState::Changed })
    }

    /// Returns whether every file is as it was written.
    ///
    /// # Errors
    /// [`Error::Io`] when one cannot be read.
    pub fn all_intact(&self, folder: &Path, stamps: &FileTimes) -> Result<bool> {
        for name in self.files.keys() {
            if self.state(folder, name, stamps)? != FileState::Intact {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

const VERSION_DIGITS: usize = 12;

/// Returns whether `name` is that of a folder with one version of a stack.
pub fn is_version(name: &str) -> bool {
    name.len() == VERSION_DIGITS && name.bytes().all(|b| b.is_ascii_hexdigit() && !b.is_ascii_uppercase())
}

/// Modification times of files in nanoseconds since 1970, by the hash of their content. They are kept in the
/// cache and only save time: without them the content of every file is read. (Two files with the same content
/// share one entry; one of them is then hashed each time.)
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct FileTimes(BTreeMap<String, u64>);

impl FileTimes {
    /// Reads the times of the files in `record`, which are in `folder`.
    pub fn new(record: &StackFiles, folder: &Path) -> Self {
        let stamp = |(name, written): (&String, &FileRecord)| {
            let metadata = fs::symlink_metadata(folder.join(name)).ok()?;
            Some((written.blake3.clone(), modified_ns(&metadata)?))
        };
        Self(record.files.iter().filter_map(stamp).collect())
    }

    /// Reads the times from `file`; none where it cannot be read.
    pub fn read(file: &Path) -> Self {
        read_json(file, LARGEST_RECORD, "").unwrap_or_default()
    }

    /// Writes the times to `file`. A failure only costs time, so it is not reported.
    pub fn write(&self, file: &Path) {
        if let Some(folder) = file.parent() {
            let _ = fs::create_dir_all(folder).and_then(|()| fs::write(file, to_json(self)));
        }
    }
}

fn modified_ns(metadata: &fs::Metadata) -> Option<u64> {
    let since_1970 = metadata.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
    u64::try_from(since_1970.as_nanos()).ok()
}

/// Returns the names of everything in `folder` except the record, sorted.
///
/// # Errors
/// [`Error::Io`] when the folder cannot be read.
pub fn names_in(folder: &Path) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(Error::io(folder, "read the folder"))? {
        let entry = entry.map_err(Error::io(folder, "read the folder"))?;
        names.push(entry.file_name().to_string_lossy().into_owned());
    }
    names.retain(|name| name != RECORD);
    names.sort();
    Ok(names)
}
