//! What deflated data can grow to.

/// The most bytes that a byte of deflated data can stand for: two bits a match of 258 bytes.
const MOST: u64 = 1032;

/// Whether `code` bytes of deflated data can give `expected` bytes. What cannot is refused before memory
/// is taken for it.
pub fn can_inflate_to(code: u64, expected: u64) -> bool {
    expected <= code.saturating_mul(MOST)
}
