//! PackBits, the run-length encoding of PSD channels: a header byte n is followed for n in 0..=127 by n + 1
//! literal bytes, and for n in 129..=255 by one byte that is repeated 257 - n times. (Apple Technical Note
//! TN1023; TIFF 6.0, section 9.)

/// Shorter runs stay among the literal bytes: interrupting a literal for a run of three saves nothing, and
/// photos are full of those.
const SHORTEST_RUN: usize = 4;
/// Maximum number of bytes per header.
const LONGEST: usize = 128;

/// Appends the code of one row to `out` and returns its length in bytes.
pub fn pack_row(row: &[u8], out: &mut Vec<u8>) -> usize {
    let before = out.len();
    out.reserve(longest_code(row.len()));
    let mut at = 0;
    while at < row.len() {
        let run_at = next_run(row, at);
        put_literals(&row[at..run_at], out);
        let run = run_length(&row[run_at..]);
        put_run(row.get(run_at), run, out);
        at = run_at + run;
    }
    out.len() - before
}

/// Returns the length of the longest code for `length` bytes: only literals, one header per 128.
pub fn longest_code(length: usize) -> usize {
    length + length.div_ceil(LONGEST)
}

/// Returns where the next run of at least [`SHORTEST_RUN`] equal bytes begins; the row's length if there is
/// none.
fn next_run(row: &[u8], from: usize) -> usize {
    let mut at = from;
    // Eight positions at once: a byte of `differs` is zero where four neighbours are equal.
    while at + 8 + SHORTEST_RUN - 1 <= row.len() {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| eight_bytes(row, at + i));
        let differs = (a ^ b) | (b ^ c) | (c ^ d);
        let zeros = lowest_zero_byte(differs);
        if zeros != 0 {
            return at + zeros.trailing_zeros() as usize / 8;
        }
        at += 8;
    }
    row[at..].windows(SHORTEST_RUN).position(all_equal).map_or(row.len(), |found| at + found)
}

fn all_equal(window: &[u8]) -> bool {
    window.iter().all(|byte| *byte == window[0])
}

fn eight_bytes(row: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(row[at..at + 8].try_into().expect("the slice has eight bytes"))
}

/// Returns a word whose lowest set bit is in the lowest zero byte of `word`; 0 if there is none. (The classic
/// borrow trick: bits above that byte may be wrong, the lowest one never is.)
fn lowest_zero_byte(word: u64) -> u64 {
    const LOW: u64 = u64::from_ne_bytes([0x01; 8]);
    const HIGH: u64 = u64::from_ne_bytes([0x80; 8]);
    word.wrapping_sub(LOW) & !word & HIGH
}

/// Returns the number of equal bytes at the start of `row`.
fn run_length(row: &[u8]) -> usize {
    let Some(&first) = row.first() else { return 0 };
    let same = u64::from_ne_bytes([first; 8]);
    let mut at = 0;
    while at + 8 <= row.len() {
        let differs = eight_bytes(row, at) ^ same;
        if differs != 0 {
            return at + differs.trailing_zeros() as usize / 8;
        }
        at += 8;
    }
    at + row[at..].iter().take_while(|byte| **byte == first).count()
}

fn put_literals(bytes: &[u8], out: &mut Vec<u8>) {
    for chunk in bytes.chunks(LONGEST) {
        out.push((chunk.len() - 1) as u8);
        out.extend_from_slice(chunk);
    }
}

/// Writes a run. It is also correct for the one or two bytes that a long run may leave: a "run" of one has
/// the header 0, which is that of one literal byte.
fn put_run(byte: Option<&u8>, length: usize, out: &mut Vec<u8>) {
    let Some(&byte) = byte else { return };
    let mut left = length;
    while left > 0 {
        let now = left.min(LONGEST);
        out.extend_from_slice(&[(257 - now) as u8, byte]);
        left -= now;
    }
}

/// Decodes a row; false when the code ends too early or encodes too much. A header of 128 is ignored; what
/// follows a full row is padding.
pub fn unpack_row(mut code: &[u8], mut row: &mut [u8]) -> bool {
    while !row.is_empty() {
        let Some((&header, rest)) = code.split_first() else { return false };
        let (count, literal) = match usize::from(header) {
            n @ 0..128 => (n + 1, true),
            128 => (0, true),
            n => (257 - n, false),
        };
        let used = if literal { count } else { 1 };
        if count > row.len() || used > rest.len() {
            return false;
        }
        let (here, later) = row.split_at_mut(count);
        if literal {
            here.copy_from_slice(&rest[..count]);
        } else {
            here.fill(rest[0]);
        }
        (code, row) = (&rest[used..], later);
    }
    true
}

/// Returns the length of the shortest code for `length` bytes: only runs.
pub fn shortest_code(length: u64) -> u64 {
    2 * length.div_ceil(LONGEST as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[track_caller]
    fn assert_unpacks(code: &[u8], row: &[u8]) {
        let mut found = vec![0x5a; row.len()];
        assert!(unpack_row(code, &mut found), "{} bytes of code", code.len());
        assert_eq!(found, row);
    }

    fn packed(row: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        assert_eq!(pack_row(row, &mut out), out.len());
        out
    }

    #[test]
    fn an_empty_row_has_an_empty_code() {
        assert!(packed(&[]).is_empty());
    }

    #[test]
    fn a_transparent_row_takes_two_bytes_per_128_pixels() {
        assert_eq!(packed(&[0; 256]), [129, 0, 129, 0]);
    }

    #[test]
    fn runs_of_every_length_around_the_limits_come_back() {
        for length in (0..20).chain(120..140).chain(250..270) {
            for before in 0..12 {
                let mut row: Vec<u8> = (0..before).collect();
                row.extend(std::iter::repeat_n(77, length));
                row.extend([1, 2, 3, 4]);
                assert_unpacks(&packed(&row), &row);
            }
        }
    }

    #[test]
    fn noise_grows_by_one_byte_in_128_at_most() {
        let noise: Vec<u8> = (0..10_000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        assert!(packed(&noise).len() <= longest_code(noise.len()));
    }

    #[test]
    fn code_is_read_by_the_definition() {
        assert_unpacks(&[2, 7, 8, 9, 128, 254, 5], &[7, 8, 9, 5, 5, 5]);
        assert_unpacks(&[0, 7, 99, 99], &[7]);
        for wrong in [&[2, 7, 8][..], &[254], &[253, 5], &[0, 1, 0, 2], &[]] {
            assert!(!unpack_row(wrong, &mut [0; 3]), "{wrong:?}");
        }
    }

    proptest! {
        #[test]
        fn every_row_comes_back(row in proptest::collection::vec((0u8..4, 1usize..200), 0..40)) {
            let row: Vec<u8> = row.iter().flat_map(|&(byte, n)| std::iter::repeat_n(byte, n)).collect();
            let code = packed(&row);
            prop_assert!(code.len() <= longest_code(row.len()));
            assert_unpacks(&code, &row);
        }

        #[test]
        fn every_noisy_row_comes_back(row in proptest::collection::vec(0u8..3, 0..600)) {
            assert_unpacks(&packed(&row), &row);
        }
    }
}
