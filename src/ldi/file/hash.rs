//! The hashes that are in the file.

use quadratura_files::hash::hash_bytes;

/// The number of hexadecimal digits of a hash in the file.
pub const HASH_DIGITS: usize = 16;

/// Returns the first [`HASH_DIGITS`] digits of the BLAKE3 of bytes.
pub(super) fn short_hash(bytes: &[u8]) -> String {
    let mut hash = hash_bytes(bytes);
    hash.truncate(HASH_DIGITS);
    hash
}
