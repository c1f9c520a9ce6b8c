//! Bounds on the size of deflated data.

/// Maximum number of bytes that a byte of deflated data can produce: two bits for a match of 258 bytes.
const MOST: u64 = 1032;

/// Returns whether `code` bytes of deflated data can produce `expected` bytes. Anything else is refused
/// before memory is allocated for it.
pub fn can_inflate_to(code: u64, expected: u64) -> bool {
    expected <= code.saturating_mul(MOST)
}
