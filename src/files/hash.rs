//! BLAKE3 hashes of files and data, by which changed files are recognised.

use std::fs::File;
use std::path::Path;

use quadratura_base::error::{Error, Result};

/// Returns the BLAKE3 of a file's content as 64 hexadecimal digits.
///
/// # Errors
/// [`Error::Io`] when it cannot be read.
pub fn hash_file(path: impl AsRef<Path>) -> Result<String> {
    let path = path.as_ref();
    let file = File::open(path).map_err(Error::io(path, "open it"))?;
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(file).map_err(Error::io(path, "read it"))?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// Returns the BLAKE3 of `bytes` as 64 hexadecimal digits.
pub fn hash_bytes(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

/// An incremental hash over a sequence of byte strings.
#[derive(Default)]
pub struct Hashing(blake3::Hasher);

impl Hashing {
    /// Adds one byte string. Its length counts, too: `ab`, `c` and `a`, `bc` have different hashes.
    pub fn add(&mut self, bytes: &[u8]) {
        self.0.update(&(bytes.len() as u64).to_le_bytes()).update(bytes);
    }

    /// Adds bytes without their length: a content that is added in pieces has the hash of [`hash_bytes`].
    pub fn extend(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// Returns the hash of everything that was added, as 64 hexadecimal digits.
    pub fn hash(&self) -> String {
        self.0.finalize().to_hex().to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_each_part_changes_the_hash() {
        let hash = |parts: &[&str]| {
            let mut hashing = Hashing::default();
            parts.iter().for_each(|part| hashing.add(part.as_bytes()));
            hashing.hash()
        };
        assert_eq!(hash(&["ab", "c"]), hash(&["ab", "c"]));
        assert!(hash(&["ab", "c"]) != hash(&["a", "bc"]) && hash(&["", "a"]) != hash(&["a"]));
    }

    #[test]
    fn pieces_without_their_lengths_have_the_hash_of_the_whole() {
        let mut hashing = Hashing::default();
        ["pi", "", "azza"].iter().for_each(|part| hashing.extend(part.as_bytes()));
        assert_eq!(hashing.hash(), hash_bytes(b"piazza"));
    }

    #[test]
    fn a_file_has_the_hash_of_its_bytes() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "piazza").unwrap();
        assert_eq!(hash_file(file.path()).unwrap(), hash_bytes(b"piazza"));
    }
}
