//! Derived values in `cache/` of a project: one form of file for all of them.
//!
//! The first line is JSON: what the file holds, the version of that, the hash of everything that it was made from, and the length and
//! hash of what follows. After the line feed follows the value, written by postcard and packed with deflate.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::atomic::write_atomically;
use super::deflated::{deflated, first_line, inflated};
use super::hash::hash_bytes;
use quadratura_base::error::{Error, Result};

/// What a file holds, and in which version: one that changes when the same inputs give other values, or values of another form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CachedKind {
    /// The name.
    pub name: &'static str,
    /// The version. No other is read.
    pub version: u32,
}

#[derive(Debug, Serialize, Deserialize)]
struct FirstLine {
    format: String,
    version: u32,
    inputs: String,
    /// The number of bytes of the value before it is packed.
    bytes: u64,
    /// The hash of the packed value.
    hash: String,
}

/// Writes a value; `inputs` is the hash of everything that it was made from.
///
/// # Errors
/// [`Error::Io`].
pub fn write_cached(
    file: &Path,
    kind: CachedKind,
    inputs: &str,
    value: &(impl Serialize + ?Sized),
) -> Result<()> {
    let plain = to_bytes(value);
    let packed = deflated(&plain);
    let first = FirstLine {
        format: kind.name.to_owned(),
        version: kind.version,
        inputs: inputs.to_owned(),
        bytes: plain.len() as u64,
        hash: hash_bytes(&packed),
    };
    let mut bytes = serde_json::to_vec(&first).expect("plain data is JSON");
    bytes.push(b'\n');
    bytes.extend(packed);
    let folder = file.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    write_atomically(file, &bytes)
}

/// Returns the value in a file if it was made from `inputs`. A file that is missing, damaged, of another kind or version, or made from
/// other inputs gives `None`: the caller has to make the value again.
pub fn read_cached<T: DeserializeOwned>(file: &Path, kind: CachedKind, inputs: &str) -> Option<T> {
    let bytes = std::fs::read(file).ok()?;
    let (first, packed): (FirstLine, _) = first_line(&bytes).ok()?;
    let is_asked = first.format == kind.name && first.version == kind.version && first.inputs == inputs;
    if !is_asked || first.hash != hash_bytes(packed) {
        return None;
    }
    from_bytes(&inflated(packed, first.bytes).ok()?)
}

/// Returns a value as bytes.
pub(super) fn to_bytes(value: &(impl Serialize + ?Sized)) -> Vec<u8> {
    postcard::to_stdvec(value).expect("plain data in memory can be written")
}

/// Returns the value that [`to_bytes`] wrote; `None` where these bytes are none.
pub(super) fn from_bytes<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    postcard::from_bytes(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const KIND: CachedKind = CachedKind { name: "heights", version: 3 };

    fn written() -> (tempfile::TempDir, std::path::PathBuf, Vec<(String, Option<f64>)>) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("cache/heights.bin");
        let value = vec![("wall".to_owned(), Some(0.1)), ("roof".to_owned(), None)];
        write_cached(&file, KIND, "abc", &value).unwrap();
        (folder, file, value)
    }

    #[test]
    fn what_is_read_is_what_was_written_from_the_same_inputs() {
        let (_folder, file, value) = written();
        let read = |kind, inputs: &str| read_cached::<Vec<(String, Option<f64>)>>(&file, kind, inputs);
        assert_eq!(read(KIND, "abc"), Some(value));
        assert_eq!(read(KIND, "abd"), None);
        assert_eq!(read(CachedKind { version: 4, ..KIND }, "abc"), None);
        assert_eq!(read(CachedKind { name: "depths", ..KIND }, "abc"), None);
    }

    #[test]
    fn no_damaged_file_is_read() {
        let (_folder, file, value) = written();
        let whole = std::fs::read(&file).unwrap();
        let read = || read_cached::<Vec<(String, Option<f64>)>>(&file, KIND, "abc");
        for length in 0..whole.len() {
            std::fs::write(&file, &whole[..length]).unwrap();
            assert_eq!(read(), None, "{length} of {} bytes", whole.len());
        }
        for at in 0..whole.len() {
            let mut other = whole.clone();
            other[at] ^= 1;
            std::fs::write(&file, &other).unwrap();
            // Blanks in the line, which JSON does not count, are the only change that may be missed.
            assert!(read().is_none_or(|read| read == value), "byte {at}");
        }
    }
}
