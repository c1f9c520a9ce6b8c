//! Data as scripts. A chunk is a call with its name, the number of its bytes, their checksum, and the bytes in base64; they are a line of
//! JSON that lists parts, and the parts, one after the other (`viewer/chunks.js` reads them).

use serde::Serialize;

use super::html::in_script;
use quadratura_files::base64::to_base64;
use quadratura_files::deflated::deflated;

/// The parts of a chunk.
#[derive(Debug, Default)]
pub struct Chunk {
    listed: Vec<Part>,
    bytes: Vec<u8>,
}

/// The description of a part in the first line.
#[derive(Debug, Serialize)]
struct Part {
    name: String,
    /// The number of bytes in the chunk.
    bytes: usize,
    /// The number of bytes when unpacked; absent where the part is not packed.
    #[serde(skip_serializing_if = "Option::is_none")]
    unpacked: Option<usize>,
}

impl Chunk {
    /// Adds bytes that are packed already, such as those of a JPEG.
    pub fn add(&mut self, name: impl Into<String>, bytes: &[u8]) {
        self.listed.push(Part { name: name.into(), bytes: bytes.len(), unpacked: None });
        self.bytes.extend_from_slice(bytes);
    }

    /// Adds bytes, packed by deflate.
    pub fn add_packed(&mut self, name: impl Into<String>, bytes: &[u8]) {
        let packed = deflated(bytes);
        self.listed.push(Part { name: name.into(), bytes: packed.len(), unpacked: Some(bytes.len()) });
        self.bytes.extend_from_slice(&packed);
    }

    /// Adds numbers as little-endian bytes, packed by deflate.
    pub fn add_numbers<const N: usize>(
        &mut self,
        name: impl Into<String>,
        numbers: impl IntoIterator<Item = [u8; N]>,
    ) {
        let bytes: Vec<u8> = numbers.into_iter().flatten().collect();
        self.add_packed(name, &bytes);
    }

    /// Returns the script of the chunk.
    pub fn script(&self, name: &str) -> Vec<u8> {
        let mut bytes = serde_json::to_vec(&self.listed).expect("plain data is JSON");
        bytes.push(b'\n');
        bytes.extend_from_slice(&self.bytes);
        let (count, sum) = (bytes.len(), adler32(&bytes));
        format!("quadratura.chunk({name:?}, {count}, {sum}, \"{}\");\n", to_base64(&bytes)).into_bytes()
    }
}

/// Returns the script that gives the page its description.
pub fn description(site: &impl Serialize) -> Vec<u8> {
    let json = serde_json::to_string(site).expect("plain data is JSON");
    format!("quadratura.describe({});\n", in_script(&json)).into_bytes()
}

/// The checksum Adler-32 (RFC 1950, section 8.2), which a browser computes quickly.
fn adler32(bytes: &[u8]) -> u32 {
    // The most bytes after which neither sum exceeds 32 bits.
    const MOST: usize = 5552;
    let (mut a, mut b) = (1u32, 0u32);
    for some in bytes.chunks(MOST) {
        for byte in some {
            a += u32::from(*byte);
            b += a;
        }
        a %= 65521;
        b %= 65521;
    }
    b << 16 | a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_the_standard() {
        assert_eq!(adler32(b"Wikipedia"), 0x11e6_0398);
        assert_eq!(adler32(&vec![255; 100_000]), {
            let (a, b) =
                (0..100_000u64).fold((1u64, 0u64), |(a, b), _| ((a + 255) % 65521, (b + a + 255) % 65521));
            (b << 16 | a) as u32
        });
    }

    #[test]
    fn a_chunk_lists_its_parts_and_how_they_are_packed() {
        let mut chunk = Chunk::default();
        chunk.add("a", &[1, 2]);
        chunk.add_numbers("b", [7u16, 7, 7].map(u16::to_le_bytes));
        let script = String::from_utf8(chunk.script("one")).unwrap();
        assert!(script.starts_with("quadratura.chunk(\"one\", ") && script.ends_with("\");\n"), "{script}");
    }
}
