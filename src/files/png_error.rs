//! What the system says when a PNG cannot be written.

use std::io;

use png::EncodingError;

/// Returns the system's own error, so that a full disk, for example, is still recognised.
pub fn io_error(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        error => error.into(),
    }
}
