//! What the files of one version of a stack were when we wrote them.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;
use std::time::UNIX_EPOCH;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::hash::{hash_bytes, hash_file};
use super::json::{read_json, to_json};
use crate::error::{Error, Result};

/// The record's own name in the folder that it describes.
pub const RECORD: &str = "files.json";

/// A record has about 100 bytes a file, and a stack has thousands of files at most.
const LARGEST_RECORD: u64 = 64 << 20;

/// The record of one version's files.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct StackFiles {
    /// BLAKE3 of the `stack.json` that names them.
    pub stack: String,
    /// By name.
    pub files: BTreeMap<String, Written>,
}

/// A file as we wrote it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Written {
    /// Its size.
    pub bytes: u64,
    /// BLAKE3 of its content.
    pub blake3: String,
}

/// What became of a file since.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// As we wrote it.
    Intact,
    /// Other content, or not ours at all.
    Changed,
    /// Gone.
    Missing,
}

impl StackFiles {
    /// Sends every file in `folder` to the disk, in parallel, and records it.
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
                Ok((name, Written { bytes, blake3: hash_file(&path)? }))
            })
            .collect::<Result<_>>()?;
        Ok(Self { stack: String::new(), files })
    }

    /// The record in `folder`; `None` where there is none that can be read.
    pub fn read(folder: &Path) -> Option<Self> {
        read_json(&folder.join(RECORD), LARGEST_RECORD, "").ok()
    }

    /// A short name for these files together with the stack that `stack` describes: the same for
    /// the same content, whenever and wherever it is built.
    pub fn version(&self, stack: &[u8]) -> String {
        let mut text = to_json(self);
        text.extend_from_slice(stack);
        hash_bytes(&text)[..VERSION_DIGITS].to_owned()
    }

    /// What became of the file `name` in `folder`. Size and time of change are looked at first, the
    /// content only where the time is not the one in `stamps`: a file that was changed to the same
    /// size and given its old time back, to the nanosecond, passes as intact.
    ///
    /// # Errors
    /// [`Error::Io`] when it exists and cannot be read.
    pub fn state(&self, folder: &Path, name: &str, stamps: &Stamps) -> Result<State> {
        let path = folder.join(name);
        let Ok(metadata) = fs::symlink_metadata(&path) else { return Ok(State::Missing) };
        let Some(written) = self.files.get(name) else { return Ok(State::Changed) };
        if !metadata.is_file() || metadata.len() != written.bytes {
            return Ok(State::Changed);
        }
        if stamps.0.get(&written.blake3).is_some_and(|stamp| modified_ns(&metadata) == Some(*stamp)) {
            return Ok(State::Intact);
        }
        Ok(if hash_file(&path)? == written.blake3 { State::Intact } else { State::Changed })
    }

    /// True when every file is as we wrote it.
    ///
    /// # Errors
    /// [`Error::Io`] when one cannot be read.
    pub fn all_intact(&self, folder: &Path, stamps: &Stamps) -> Result<bool> {
        for name in self.files.keys() {
            if self.state(folder, name, stamps)? != State::Intact {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

const VERSION_DIGITS: usize = 12;

/// True for the name of a folder that holds one version of a stack.
pub fn is_version(name: &str) -> bool {
    name.len() == VERSION_DIGITS && name.bytes().all(|b| b.is_ascii_hexdigit() && !b.is_ascii_uppercase())
}

/// When files were last written, in nanoseconds since 1970, by the hash of their content. It lives
/// in the cache and only saves time: without it every file's content is read. (Two files with the
/// same content share one entry; the other one is then hashed each time.)
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Stamps(BTreeMap<String, u64>);

impl Stamps {
    /// The times of the files of `record`, which lie in `folder`.
    pub fn of(record: &StackFiles, folder: &Path) -> Self {
        let stamp = |(name, written): (&String, &Written)| {
            let metadata = fs::symlink_metadata(folder.join(name)).ok()?;
            Some((written.blake3.clone(), modified_ns(&metadata)?))
        };
        Self(record.files.iter().filter_map(stamp).collect())
    }

    /// Those in `file`; none where it cannot be read.
    pub fn read(file: &Path) -> Self {
        read_json(file, LARGEST_RECORD, "").unwrap_or_default()
    }

    /// Keeps them in `file`. Failing costs nothing but time, so it is not reported.
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

/// The names of everything in `folder` but the record, sorted.
///
/// # Errors
/// [`Error::Io`] when it cannot be read.
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
