//! What every reader and writer of files needs: files that are replaced in one step, JSON with line and column of a fault, text in
//! any encoding, packed bytes, hashes, the lock of a project, paths that are free.

pub mod atomic;
pub mod base64;
pub mod cached;
pub mod deflated;
pub mod foreign_json;
pub mod free_path;
pub mod guarded;
pub mod hash;
pub mod inbox;
pub mod json;
pub mod known_hashes;
pub mod lease;
pub mod lock;
pub mod machine;
pub mod named_file;
pub mod png_error;
pub mod scratch;
pub mod stamp;
pub mod text;
pub mod writable;
