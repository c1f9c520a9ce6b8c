//! Compresses and decompresses tiles of 64 x 64 pixels as XCF stores them: the first bytes of all pixels,
//! then the second ones and so on, run-length encoded.
//!
//! A header n below 127 repeats the next byte n + 1 times; 127 is followed by a length of 16 bits and the
//! byte to repeat; 128 by a length and as many literal bytes; above that follow 256 - n literal bytes.

use rayon::prelude::*;

use crate::Raster;
use quadratura_base::scene::Samples;

/// The side of a tile in pixels; tiles at the right and bottom edge may be smaller.
pub const TILE: u32 = 64;

/// Shorter runs stay among the literal bytes: interrupting a literal for a run of three saves nothing.
const SHORTEST_RUN: usize = 4;
/// The longest run or literal with a header of one byte.
const LONGEST_SHORT: usize = 127;

/// A compressed raster.
pub struct Tiles {
    pub width: u32,
    pub height: u32,
    bytes_per_pixel: u32,
    /// Rows of tiles from the top, each from the left.
    rows: Vec<TileRow>,
}

/// A row of tiles: their code, and the length of each tile's code.
struct TileRow {
    code: Vec<u8>,
    lengths: Vec<u64>,
}

impl Tiles {
    /// Compresses a raster, which must not be empty.
    pub fn from_raster(raster: &Raster) -> Self {
        let (width, height) = (raster.width(), raster.height());
        let tops: Vec<u32> = (0..height).step_by(TILE as usize).collect();
        let rows = tops.into_par_iter().map(|top| TileRow::new(raster, top)).collect();
        let bytes_per_pixel = 4 * raster.depth().bytes() as u32;
        Self { width, height, bytes_per_pixel, rows }
    }

    /// Returns bytes per pixel: 4 or 8.
    pub fn bytes_per_pixel(&self) -> u32 {
        self.bytes_per_pixel
    }

    /// Yields the length of each tile's code in bytes, in order.
    pub fn lengths(&self) -> impl Iterator<Item = u64> {
        self.rows.iter().flat_map(|row| row.lengths.iter().copied())
    }

    /// Yields the code of all tiles, in order.
    pub fn codes(&self) -> impl Iterator<Item = &[u8]> {
        self.rows.iter().map(|row| &row.code[..])
    }
}

impl TileRow {
    fn new(raster: &Raster, top: u32) -> Self {
        let (width, bottom) = (raster.width(), (top + TILE).min(raster.height()));
        match raster.samples() {
            Samples::U8(samples) => Self::pack(samples, width, top..bottom, |sample| [sample]),
            Samples::U16(samples) => Self::pack(samples, width, top..bottom, u16::to_be_bytes),
        }
    }

    fn pack<T: Copy, const BYTES: usize>(
        samples: &[T],
        width: u32,
        rows: std::ops::Range<u32>,
        bytes_of: impl Fn(T) -> [u8; BYTES],
    ) -> Self {
        let mut row = Self { code: Vec::new(), lengths: Vec::new() };
        let mut plane = Vec::with_capacity((TILE * TILE) as usize);
        for left in (0..width).step_by(TILE as usize) {
            let before = row.code.len();
            let right = (left + TILE).min(width);
            for byte in 0..4 * BYTES {
                plane.clear();
                for y in rows.clone() {
                    let line = 4 * y as usize * width as usize;
                    let (pixels, _) =
                        samples[line + 4 * left as usize..line + 4 * right as usize].as_chunks::<4>();
                    plane.extend(pixels.iter().map(|pixel| bytes_of(pixel[byte / BYTES])[byte % BYTES]));
                }
                pack(&plane, &mut row.code);
            }
            row.lengths.push((row.code.len() - before) as u64);
        }
        row
    }
}

/// Appends the code of `bytes`.
fn pack(bytes: &[u8], out: &mut Vec<u8>) {
    let mut at = 0;
    while at < bytes.len() {
        let run_at = next_run(bytes, at);
        put_literal(&bytes[at..run_at], out);
        let run = bytes[run_at..].iter().take_while(|byte| **byte == bytes[run_at]).count();
        put_run(bytes.get(run_at), run, out);
        at = run_at + run;
    }
}

/// Returns where the next run begins that is worth a header; the end if there is none.
fn next_run(bytes: &[u8], from: usize) -> usize {
    let (mut start, mut at) = (from, from + 1);
    while at < bytes.len() {
        if bytes[at] != bytes[start] {
            start = at;
        } else if at + 1 - start == SHORTEST_RUN {
            return start;
        }
        at += 1;
    }
    bytes.len()
}

fn put_literal(bytes: &[u8], out: &mut Vec<u8>) {
    match bytes.len() {
        0 => return,
        // No tile has more bytes per plane than fit 16 bits.
        length if length > LONGEST_SHORT => {
            out.push(128);
            out.extend((length as u16).to_be_bytes());
        }
        length => out.push((256 - length) as u8),
    }
    out.extend(bytes);
}

fn put_run(byte: Option<&u8>, length: usize, out: &mut Vec<u8>) {
    let Some(&byte) = byte else { return };
    if length > LONGEST_SHORT {
        out.push(127);
        out.extend((length as u16).to_be_bytes());
    } else {
        out.push((length - 1) as u8);
    }
    out.push(byte);
}

/// Decodes a tile of pixels of `bytes_per_pixel` bytes each; false when the code ends too early or encodes
/// too much. Bytes behind the code are ignored. `planes` is scratch memory.
pub fn unpack(mut code: &[u8], tile: &mut [u8], bytes_per_pixel: usize, planes: &mut Vec<u8>) -> bool {
    planes.resize(tile.len(), 0);
    let pixels = tile.len() / bytes_per_pixel;
    for plane in planes.chunks_exact_mut(pixels.max(1)) {
        match unpack_plane(code, plane) {
            Some(rest) => code = rest,
            None => return false,
        }
    }
    interleave(planes, tile, bytes_per_pixel);
    true
}

/// Decodes one plane and returns the rest of the code.
fn unpack_plane<'c>(mut code: &'c [u8], mut plane: &mut [u8]) -> Option<&'c [u8]> {
    while !plane.is_empty() {
        let (literal, count, rest) = header(code)?;
        let (here, later) = plane.split_at_mut_checked(count)?;
        if literal {
            let (bytes, rest) = rest.split_at_checked(count)?;
            here.copy_from_slice(bytes);
            code = rest;
        } else {
            let (byte, rest) = rest.split_first()?;
            here.fill(*byte);
            code = rest;
        }
        plane = later;
    }
    Some(code)
}

/// Interleaves planes to pixels; the loops for 8- and 16-bit layers are unrolled.
fn interleave(planes: &[u8], tile: &mut [u8], bytes_per_pixel: usize) {
    match bytes_per_pixel {
        1 => tile.copy_from_slice(planes),
        3 => interleave_of::<3>(planes, tile),
        4 => interleave_of::<4>(planes, tile),
        8 => interleave_of::<8>(planes, tile),
        _ => {
            let pixels = tile.len() / bytes_per_pixel;
            for (byte, plane) in planes.chunks_exact(pixels.max(1)).enumerate() {
                let targets = tile[byte..].iter_mut().step_by(bytes_per_pixel);
                targets.zip(plane).for_each(|(to, from)| *to = *from);
            }
        }
    }
}

fn interleave_of<const N: usize>(planes: &[u8], tile: &mut [u8]) {
    let count = tile.len() / N;
    let planes: [&[u8]; N] = std::array::from_fn(|plane| &planes[plane * count..][..count]);
    let (pixels, _) = tile.as_chunks_mut::<N>();
    for (i, pixel) in pixels.iter_mut().enumerate() {
        *pixel = std::array::from_fn(|byte| planes[byte][i]);
    }
}

/// Parses a header: whether literal bytes follow, the number of pixels, and the rest of the code.
fn header(code: &[u8]) -> Option<(bool, usize, &[u8])> {
    let (&first, rest) = code.split_first()?;
    let n = usize::from(first);
    if n != 127 && n != 128 {
        return Some(if n < 127 { (false, n + 1, rest) } else { (true, 256 - n, rest) });
    }
    let (length, rest) = rest.split_first_chunk::<2>()?;
    Some((n == 128, u16::from_be_bytes(*length).into(), rest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unpacked(code: &[u8], tile: &mut [u8], bytes_per_pixel: usize) -> bool {
        unpack(code, tile, bytes_per_pixel, &mut Vec::new())
    }

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        pack(bytes, &mut out);
        out
    }

    #[test]
    fn code_is_read_by_the_definition() {
        let mut tile = [0; 6];
        assert!(unpacked(&[1, 9, 255, 8, 127, 0, 3, 7], &mut tile, 1));
        assert_eq!(tile, [9, 9, 8, 7, 7, 7]);
        assert!(unpacked(&[128, 0, 2, 1, 2, 254, 3, 4, 1, 5, 99], &mut tile, 3));
        assert_eq!(tile, [1, 3, 5, 2, 4, 5]);
        let by_two = [[0, 1], [1, 2], [2, 3]].concat();
        assert!(unpacked(&[0, 0, 0, 1, 0, 2, 0, 1, 0, 2, 0, 3], &mut tile, 2));
        assert_eq!(tile[..], by_two);
        for wrong in [&[6, 9][..], &[5], &[128, 0, 6, 1], &[127, 1], &[250, 1, 2], &[]] {
            assert!(!unpacked(wrong, &mut tile, 1), "{wrong:?}");
        }
    }

    #[test]
    fn an_empty_tile_takes_four_bytes_a_plane() {
        assert_eq!(packed(&[0; 4096]), [127, 16, 0, 0]);
    }

    #[test]
    fn runs_of_every_length_around_the_limits_come_back() {
        for length in (1..10).chain(120..135).chain([4000]) {
            for before in [0, 1, 3, 126, 127, 128, 129] {
                let mut bytes: Vec<u8> = (0..before).map(|i| (i * 7) as u8).collect();
                bytes.extend(std::iter::repeat_n(77, length));
                let mut found = vec![0; bytes.len()];
                assert!(unpacked(&packed(&bytes), &mut found, 1));
                assert_eq!(found, bytes, "{before} literals, a run of {length}");
            }
        }
    }

    proptest! {
        #[test]
        fn every_plane_comes_back(bytes in proptest::collection::vec((0u8..3, 1usize..200), 0..20)) {
            let mut bytes: Vec<u8> = bytes.iter().flat_map(|&(byte, n)| std::iter::repeat_n(byte, n)).collect();
            bytes.truncate(4096);
            let mut found = vec![0; bytes.len()];
            prop_assert!(unpacked(&packed(&bytes), &mut found, 1));
            prop_assert_eq!(found, bytes);
        }
    }
}
